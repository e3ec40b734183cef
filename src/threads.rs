//! The threads of a run: as many as are asked for, or as the machine has cores.

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use raytracer::memory::{NoMemory, with_room};
use std::hint::black_box;
use std::io;
use std::sync::mpsc::{Sender, channel};
use std::thread;

/// The stack of a thread, in bytes. No step of the program recurses as deep as its input, so the depth of a scene's
/// tree and the number of bounces do not matter.
const STACK: usize = 2 << 20;

/// What a thread takes beside its stack: guard pages, and the stack on which an overflow is reported.
const BESIDE_STACK: usize = 1 << 16;

/// Where the threads of a pool run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// This thread is among them: for one thread none is started, and calls from here neither wake another nor wait.
    Here,
    /// All are started.
    Apart,
}

/// A pool of the number of threads that `-threads` asks for; without it, of as many as the machine has cores, or as the
/// system starts. The pool decides nothing by itself: it would read variables of the environment.
pub fn pool(wanted: Option<usize>, place: Place) -> Result<ThreadPool, String> {
    let here = usize::from(place == Place::Here);
    let count = wanted.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
    let refused = |reason: String| format!("error: `-threads`: {reason}");
    let waiting = match (start(count - here), wanted) {
        (Ok(waiting), _) => waiting,
        (Err(Refused { reason, .. }), Some(_)) => return Err(refused(reason)),
        (Err(Refused { waiting, reason }), None) if waiting.len() + here == 0 => return Err(refused(reason)),
        (Err(Refused { waiting, .. }), None) => waiting,
    };
    let pool = ThreadPoolBuilder::new().num_threads(waiting.len() + here);
    let mut waiting = waiting.into_iter();
    let pool = pool.spawn_handler(|thread| {
        let next = waiting.next().ok_or_else(|| io::Error::other("no thread is left"))?;
        next.send(thread).map_err(|_| io::Error::other("a thread has ended"))
    });
    let pool = if place == Place::Here { pool.use_current_thread() } else { pool };
    let pool = pool.build().map_err(|error| refused(error.to_string()))?;
    if memory_is_limited() {
        // A thread allocates when it first looks for work, and ends the program if there is no memory left by then.
        pool.broadcast(|_| ());
    }
    Ok(pool)
}

/// A thread that waits for the pool that it is to work for. It ends when this is dropped.
type Waiting = Sender<ThreadBuilder>;

/// The system starts fewer threads than it is asked for.
struct Refused {
    /// Those that it has started.
    waiting: Vec<Waiting>,
    reason: String,
}

/// Starts threads. Where memory is limited, one after the other: a thread allocates when it begins to run, and ends the
/// program if another has taken the memory by then.
fn start(count: usize) -> Result<Vec<Waiting>, Refused> {
    let mut waiting = vec![];
    let refused = |waiting, reason: &dyn std::fmt::Display| {
        Err(Refused { waiting, reason: format!("the system does not start {count} more threads: {reason}") })
    };
    let is_limited = count > 0 && memory_is_limited();
    let (running, is_running) = channel::<()>();
    for _ in 0..count {
        if !has_room_for_stack() {
            return refused(waiting, &NoMemory { bytes: (count * (STACK + BESIDE_STACK)) as u64 });
        }
        let (sender, receiver) = channel::<ThreadBuilder>();
        let running = is_limited.then(|| running.clone());
        let work = move || {
            // The one that starts this thread waits for it.
            let _ = running.map(|running| running.send(()));
            receiver.recv().into_iter().for_each(ThreadBuilder::run);
        };
        match thread::Builder::new().stack_size(STACK).spawn(work) {
            Ok(_) => waiting.push(sender),
            Err(reason) => return refused(waiting, &reason),
        }
        if is_limited {
            let _ = is_running.recv();
        }
    }
    Ok(waiting)
}

/// Whether there is memory for what a thread takes, without which it would end the program.
fn has_room_for_stack() -> bool {
    with_room::<u8>(STACK + BESIDE_STACK).map(black_box).is_ok()
}

/// Whether the system limits the addresses that the program may use.
#[cfg(target_os = "linux")]
fn memory_is_limited() -> bool {
    rustix::process::getrlimit(rustix::process::Resource::As).current.is_some()
}

/// Whether the system limits the addresses that the program may use: not known.
#[cfg(not(target_os = "linux"))]
fn memory_is_limited() -> bool {
    false
}
