//! Signals that ask the program to end: Ctrl-C, SIGTERM, and SIGHUP of a terminal that closes.
//!
//! They end it at once, also while it waits for a pipe. While rows are rendered the first one makes the work stop in
//! order, and the complete rows are kept. While a file has a name that it must not keep, all signals wait; see
//! [`undisturbed`](raytracer::undisturbed).

#[cfg(unix)]
mod taker;
#[cfg(not(unix))]
#[path = "signals/no_taker.rs"]
mod taker;

#[cfg(unix)]
use crate::app::start;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use taker::Taker;

/// The end of a run by a signal: the program's exit status, as shells form it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted(pub u8);

impl Interrupted {
    fn by(signal: i32) -> Self {
        Self((128 + signal) as u8)
    }
}

/// What becomes of the signals.
pub struct Signals {
    /// The last signal that came; 0 for none.
    received: Arc<AtomicUsize>,
    /// Whether the next signal ends the program at once.
    ends: Arc<AtomicBool>,
    taker: Taker,
}

/// The signals. SIGHUP is not among them if it is ignored, as by `nohup`.
fn ending() -> impl Iterator<Item = i32> {
    #[cfg(unix)]
    let hangup = (!start::ignores_hangup()).then_some(signal_hook::consts::SIGHUP);
    #[cfg(not(unix))]
    let hangup = None;
    [SIGINT, SIGTERM].into_iter().chain(hangup)
}

impl Signals {
    /// From now on, a signal ends the program at once with a status of its own.
    pub fn watch() -> io::Result<Self> {
        let ends = Arc::new(AtomicBool::new(true));
        let signals = Self { received: Arc::default(), ends, taker: Taker::default() };
        for signal in ending() {
            // The handlers are called in this order.
            flag::register_usize(signal, signals.received.clone(), signal as usize)?;
            let status = Interrupted::by(signal).0;
            flag::register_conditional_shutdown(signal, status.into(), signals.ends.clone())?;
            flag::register(signal, signals.ends.clone())?;
        }
        Ok(signals)
    }

    /// The signal that came, if one did.
    pub fn received(&self) -> Option<Interrupted> {
        match self.received.load(Ordering::SeqCst) {
            0 => None,
            signal => Some(Interrupted::by(signal as i32)),
        }
    }

    /// From now on, a signal ends the program at once. An error if one was noted before.
    pub fn end_at_once(&self) -> Result<(), Interrupted> {
        self.ends.store(true, Ordering::SeqCst);
        self.received().map_or(Ok(()), Err)
    }

    /// From now on, a signal ends the program after this task, in place of an earlier one, whatever the first thread
    /// waits for. An error if one was noted before.
    pub fn end_after(&mut self, task: impl FnOnce() + Send + 'static) -> Result<(), Interrupted> {
        self.taker.set(Box::new(task));
        self.received().map_or(Ok(()), Err)
    }

    /// From now on, the first signal is noted, and the second one ends the program at once.
    pub fn end_at_second(&self) {
        self.ends.store(false, Ordering::SeqCst);
    }
}
