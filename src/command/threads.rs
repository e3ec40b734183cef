//! Starts the threads of a run: the number that the user asks for, or one for each core.

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use raytracer::diagnostic::Diagnostic;
use std::{io, thread};

/// The stack of a thread, in bytes. Nothing recurses as deep as its input, so the depth of a scene's tree and the
/// number of bounces do not matter.
const STACK: usize = 2 << 20;

/// Starts the threads for all parallel work; the calling thread is one of them. There are no more threads than rows or
/// cores, whichever is larger.
pub fn start(wanted: Option<usize>, rows: usize) -> Result<(), Diagnostic> {
    let pool = ThreadPoolBuilder::new().num_threads(count(wanted, rows)).use_current_thread();
    let pool = pool.spawn_handler(spawn(wanted.is_some())).build().map_err(refused)?;
    // The threads run until the program ends.
    std::mem::forget(pool);
    Ok(())
}

/// Returns a pool of its own, without the calling thread.
pub fn pool(wanted: Option<usize>, rows: usize) -> Result<ThreadPool, Diagnostic> {
    let pool = ThreadPoolBuilder::new().num_threads(count(wanted, rows));
    pool.spawn_handler(spawn(true)).build().map_err(refused)
}

/// Returns the number of threads. Without one, the library would take it from the environment.
fn count(wanted: Option<usize>, rows: usize) -> usize {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    wanted.map_or(cores, |wanted| wanted.min(rows.max(cores)))
}

/// Starts a thread. If the system refuses one that is not needed, the others do all the work.
fn spawn(is_needed: bool) -> impl FnMut(ThreadBuilder) -> io::Result<()> {
    move |worker| match thread::Builder::new().stack_size(STACK).spawn(|| worker.run()) {
        Err(error) if is_needed => Err(error),
        _ => Ok(()),
    }
}

fn refused(error: ThreadPoolBuildError) -> Diagnostic {
    Diagnostic::error(format!("`-threads`: the system does not start the threads: {error}"))
}
