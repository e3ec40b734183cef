//! Another thread that takes the signals, and does something before it ends the program.

use super::{Interrupted, ending};
use nix::sys::signal::{SigSet, Signal};
use raytracer::undisturbed::undisturbed;
use signal_hook::low_level::exit;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

/// What is done before the program ends.
type Task = Box<dyn FnOnce() + Send>;

/// The thread that takes the signals, which is there from the first task on.
#[derive(Default)]
pub struct Taker(Option<Arc<Mutex<Option<Task>>>>);

/// Signals that are of no concern to others: they stop the program, let it go on, or are ignored.
const LEFT: [Signal; 7] = [
    Signal::SIGTSTP,
    Signal::SIGTTIN,
    Signal::SIGTTOU,
    Signal::SIGCONT,
    Signal::SIGCHLD,
    Signal::SIGWINCH,
    Signal::SIGURG,
];

/// Signals that end a program which does nothing about them.
const OTHERS: [Signal; 8] = [
    Signal::SIGQUIT,
    Signal::SIGUSR1,
    Signal::SIGUSR2,
    Signal::SIGALRM,
    Signal::SIGVTALRM,
    Signal::SIGPROF,
    Signal::SIGXCPU,
    Signal::SIGIO,
];

/// The stack of the thread, and what it takes beside it, in bytes.
const STACK: usize = 1 << 18;

impl Taker {
    /// From now on, a signal ends the program after this task, in place of an earlier one.
    pub fn set(&mut self, task: Task) {
        let next = self.0.get_or_insert_with(start);
        *next.lock().unwrap_or_else(PoisonError::into_inner) = Some(task);
    }
}

fn start() -> Arc<Mutex<Option<Task>>> {
    let task: Arc<Mutex<Option<Task>>> = Arc::default();
    let mut blocked = SigSet::all();
    LEFT.into_iter().for_each(|signal| blocked.remove(signal));
    let taken: SigSet = ending().filter_map(|signal| Signal::try_from(signal).ok()).chain(OTHERS).collect();
    let own = task.clone();
    let take = move || {
        let signal = loop {
            if let Ok(signal) = taken.wait() {
                break signal;
            }
        };
        let task = own.lock().unwrap_or_else(PoisonError::into_inner).take();
        task.into_iter().for_each(|task| task());
        undisturbed(|| exit(Interrupted::by(signal as i32).0.into()))
    };
    // Without the thread, signals are noted as before.
    if blocked.thread_block().is_ok() {
        let started = thread::Builder::new().name("signals".into()).stack_size(STACK).spawn(take);
        if started.is_err() {
            let _ = blocked.thread_unblock();
        }
    }
    task
}
