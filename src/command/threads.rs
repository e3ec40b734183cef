//! Starts the threads of a run: the number that the user asks for, or one for each core.

use crate::base::memory::{self, NoMemory};
use crate::diagnostic::Diagnostic;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use std::fmt::Display;
use std::sync::mpsc::channel;
use std::thread;

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
    // The threads run until the program ends.
    begin(pool, wanted.is_some()).map(std::mem::forget)
}

/// Returns a pool of its own, without the calling thread.
pub fn pool(wanted: Option<usize>, rows: usize) -> Result<ThreadPool, Diagnostic> {
    let count = count(wanted, rows);
    ask_for(count).map_err(refused)?;
    begin(ThreadPoolBuilder::new().num_threads(count), true)
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

/// Starts the threads of a pool, and waits until they have begun: one that finds no memory by then ends the program, so
/// nothing else may take it meanwhile. If the system refuses a thread that is not needed, the others do all the work.
fn begin(pool: ThreadPoolBuilder, is_needed: bool) -> Result<ThreadPool, Diagnostic> {
    let (begins, begun) = channel();
    let spawn = move |worker: ThreadBuilder| {
        let begins = begins.clone();
        let run = move || {
            let _ = begins.send(());
            drop(begins);
            worker.run();
        };
        match thread::Builder::new().stack_size(STACK).spawn(run) {
            Err(error) if is_needed => Err(error),
            _ => Ok(()),
        }
    };
    let pool = pool.spawn_handler(spawn).build().map_err(refused)?;
    let running = begun.iter().count() + usize::from(pool.current_thread_index().is_some());
    if running == pool.current_num_threads() {
        pool.broadcast(|_| {});
    }
    Ok(pool)
}

fn refused(error: impl Display) -> Diagnostic {
    Diagnostic::error(format!("`-threads`: the system does not start the threads: {error}"))
}
