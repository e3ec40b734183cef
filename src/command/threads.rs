//! Starts the threads of a run: the number that the user asks for, or one for each core.

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use raytracer::base::memory::{self, NoMemory};
use raytracer::diagnostic::Diagnostic;
use std::fmt::Display;
use std::{io, thread};

/// The stack of a thread, in bytes. Nothing recurses as deep as its input, so the depth of a scene's tree and the
/// number of bounces do not matter.
const STACK: usize = 2 << 20;

/// Starts the threads for all parallel work; the calling thread is one of them. There are no more threads than rows or
/// cores, whichever is larger. If there is no memory for threads that the user does not ask for, the calling thread
/// works alone.
pub fn start(wanted: Option<usize>, rows: usize) -> Result<(), Diagnostic> {
    let mut count = count(wanted, rows);
    match ask_for(count - 1) {
        Err(error) if wanted.is_some() => return Err(refused(error)),
        Err(_) => count = 1,
        Ok(()) => {}
    }
    let pool = ThreadPoolBuilder::new().num_threads(count).use_current_thread();
    let pool = pool.spawn_handler(spawn(wanted.is_some())).build().map_err(refused)?;
    // The threads run until the program ends.
    std::mem::forget(pool);
    Ok(())
}

/// Returns a pool of its own, without the calling thread.
pub fn pool(wanted: Option<usize>, rows: usize) -> Result<ThreadPool, Diagnostic> {
    let count = count(wanted, rows);
    ask_for(count).map_err(refused)?;
    ThreadPoolBuilder::new().num_threads(count).spawn_handler(spawn(true)).build().map_err(refused)
}

/// Returns an error if there is no memory for this number of threads. A thread that finds none for its own variables
/// when it begins would end the whole program, so the system is asked before the first one begins.
fn ask_for(threads: usize) -> Result<(), NoMemory> {
    const OWN: usize = STACK / 8;
    memory::ask((threads * (STACK + OWN)) as u64)
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

fn refused(error: impl Display) -> Diagnostic {
    Diagnostic::error(format!("`-threads`: the system does not start the threads: {error}"))
}
