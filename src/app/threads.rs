//! The threads of a run: as many as are asked for, or as the machine has cores.

use crate::app::failed;
use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};
use raytracer::diagnostic::Diagnostic;
use raytracer::memory::{self, NoMemory};
use raytracer::undisturbed::without_signals;
use std::io;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// The stack of a thread, in bytes. No step of the program recurses as deep as its input, so the depth of a scene's
/// tree and the number of bounces do not matter.
const STACK: usize = 2 << 20;

/// What a thread takes beside its stack: guard pages, and the stack on which an overflow is reported.
const BESIDE_STACK: usize = 1 << 16;

/// What the heap of the C library grows by. That library ends the program if it has no memory for the list of what a
/// thread drops when it ends.
const HEAP_GROWTH: usize = 1 << 20;

/// A pool in which only this thread works at first. To start the others takes as long as a small picture.
pub struct Crew {
    pub pool: Arc<ThreadPool>,
    reserve: Mutex<Vec<ThreadBuilder>>,
    has_reserve: AtomicBool,
    at_work: AtomicUsize,
}

impl Crew {
    /// A pool of as many threads as in [`pool`]. If their number is given, or memory is limited, they all start at
    /// once, so that it is an error if one does not.
    pub fn new(wanted: Option<usize>) -> Result<Self, Diagnostic> {
        let mut reserve = vec![];
        let pool = match wanted.is_some() || memory_is_limited() {
            true => pool(wanted, PoolPlace::Here)?,
            false => ThreadPoolBuilder::new()
                .num_threads(most_cores())
                .use_current_thread()
                .spawn_handler(|thread| {
                    reserve.push(thread);
                    Ok(())
                })
                .build()
                .map_err(|error| refused(&error))?,
        };
        let has_reserve = AtomicBool::new(!reserve.is_empty());
        let at_work = AtomicUsize::new(pool.current_num_threads() - reserve.len());
        Ok(Self { pool: Arc::new(pool), reserve: Mutex::new(reserve), has_reserve, at_work })
    }

    /// Starts the other threads of the pool, as many as there are cores for them. If the system starts fewer, these do
    /// all the work.
    pub fn start_all(&self) {
        if !self.has_reserve.swap(false, Ordering::Relaxed) {
            return;
        }
        let mut reserve = self.reserve.lock().unwrap_or_else(PoisonError::into_inner);
        let others = reserve.drain(..).take(cores() - 1);
        let starts =
            |waiting: ThreadBuilder| thread::Builder::new().stack_size(STACK).spawn(|| waiting.run()).is_ok();
        let started = without_signals(|| others.map(starts).filter(|&starts| starts).count());
        self.at_work.fetch_add(started, Ordering::Relaxed);
    }

    /// How many threads work, this one among them.
    pub fn at_work(&self) -> usize {
        self.at_work.load(Ordering::Relaxed)
    }
}

/// Limits the threads that are wanted to those that find work: a picture is shared by its rows, and building a grid by
/// the cores.
pub fn useful(wanted: Option<usize>, rows: usize) -> Option<usize> {
    wanted.map(|wanted| wanted.min(rows.max(cores())))
}

/// Where the threads of a pool run.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum PoolPlace {
    /// This thread is among them: for one thread none is started, and calls from here neither wake another nor wait.
    Here,
    /// All are started.
    Apart,
}

/// A pool of the number of threads that `-threads` asks for; without it, of as many as the machine has cores, or as the
/// system starts. The pool decides nothing by itself: it would read variables of the environment.
pub fn pool(wanted: Option<usize>, place: PoolPlace) -> Result<ThreadPool, Diagnostic> {
    let here = usize::from(place == PoolPlace::Here);
    let count = wanted.unwrap_or_else(cores);
    let waiting = match (start(count - here), wanted) {
        (Ok(waiting), _) => waiting,
        (Err(Refused { reason, .. }), Some(_)) => return Err(refused(&reason)),
        (Err(Refused { waiting, reason }), None) if waiting.len() + here == 0 => {
            return Err(refused(&reason));
        }
        (Err(Refused { waiting, .. }), None) => waiting,
    };
    let pool = ThreadPoolBuilder::new().num_threads(waiting.len() + here);
    let mut waiting = waiting.into_iter();
    let pool = pool.spawn_handler(|thread| {
        let next = waiting.next().ok_or_else(|| io::Error::other("no thread is left"))?;
        next.send(thread).map_err(|_| io::Error::other("a thread has ended"))
    });
    let pool = if place == PoolPlace::Here { pool.use_current_thread() } else { pool };
    let pool = pool.build().map_err(|error| refused(&error))?;
    if memory_is_limited() {
        // A thread allocates when it first looks for work, and ends the program if there is no memory left by then.
        pool.broadcast(|_| ());
    }
    Ok(pool)
}

/// The number of cores that the program may use.
fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// At least the number of [`cores`]: those that the system may give to the program, where that is quickly asked. How
/// much time the program gets on them is written in files, and reading these takes a part of a small picture's time.
#[cfg(target_os = "linux")]
fn most_cores() -> usize {
    rustix::thread::sched_getaffinity(None).map_or_else(|_| cores(), |cores| cores.count() as usize)
}

/// At least the number of [`cores`].
#[cfg(not(target_os = "linux"))]
fn most_cores() -> usize {
    cores()
}

/// The message that a pool does not get its threads.
fn refused(reason: &dyn std::fmt::Display) -> Diagnostic {
    failed(format!("`-threads`: {reason}"))
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
        // Without it, the thread would end the program.
        if memory::ask((STACK + BESIDE_STACK + HEAP_GROWTH) as u64).is_err() {
            return refused(waiting, &NoMemory { bytes: (count * (STACK + BESIDE_STACK)) as u64 });
        }
        let (sender, receiver) = channel::<ThreadBuilder>();
        let running = is_limited.then(|| running.clone());
        let work = move || {
            // The one that starts this thread waits for it.
            let _ = running.map(|running| running.send(()));
            receiver.recv().into_iter().for_each(ThreadBuilder::run);
        };
        match without_signals(|| thread::Builder::new().stack_size(STACK).spawn(work)) {
            Ok(_) => waiting.push(sender),
            Err(reason) => return refused(waiting, &reason),
        }
        if is_limited {
            let _ = is_running.recv();
        }
    }
    Ok(waiting)
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn a_crew_works_before_and_after_its_other_threads_start() {
        if memory_is_limited() {
            // All start at once.
            return;
        }
        let crew = Crew::new(None).unwrap();
        let here = thread::current().id();
        let mut both = [None; 2];
        let [a, b] = &mut both;
        rayon::join(|| *a = Some(thread::current().id()), || *b = Some(thread::current().id()));
        assert_eq!(both, [Some(here); 2]);
        assert_eq!(crew.at_work(), 1);

        crew.start_all();
        assert_eq!(crew.at_work(), cores());
        // It ends when as many threads have come.
        let meeting = Barrier::new(crew.at_work());
        rayon::scope(|scope| {
            let come = || _ = meeting.wait();
            (1..crew.at_work()).for_each(|_| scope.spawn(move |_| come()));
            meeting.wait();
        });
    }
}
