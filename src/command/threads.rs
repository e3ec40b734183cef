//! The threads of a run: as many as the user asks for, or as there are cores.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// The stack of a thread, in bytes. Nothing recurses as deep as its input, so the depth of a scene's tree and the
/// number of bounces do not matter.
const STACK: usize = 2 << 20;

/// Starts the threads on which all parallel work runs; the calling thread is one of them. More than rows or cores would
/// have no work.
pub fn start(wanted: Option<usize>, rows: usize) -> Result<(), String> {
    pool_of(count(wanted, rows)).use_current_thread().build_global().map_err(refused)
}

/// Returns a pool of its own, without the calling thread.
pub fn pool(wanted: Option<usize>, rows: usize) -> Result<ThreadPool, String> {
    pool_of(count(wanted, rows)).build().map_err(refused)
}

fn count(wanted: Option<usize>, rows: usize) -> usize {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    wanted.map_or(cores, |wanted| wanted.min(rows.max(cores)))
}

/// The number of threads is given, since otherwise variables of the environment would decide.
fn pool_of(count: usize) -> ThreadPoolBuilder {
    ThreadPoolBuilder::new().num_threads(count).stack_size(STACK)
}

fn refused(error: ThreadPoolBuildError) -> String {
    format!("error: `-threads`: the system does not start the threads: {error}")
}
