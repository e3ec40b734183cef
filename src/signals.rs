//! Signals that ask the program to end: Ctrl-C, SIGTERM, and SIGHUP of a terminal that closes.
//!
//! They end it at once, also while it waits for a pipe. While rows are rendered the first one makes the work stop in
//! order, and the complete rows are kept. While a file has a name that it must not keep, all signals wait; see
//! [`undisturbed`](raytracer::undisturbed).

mod taker;

use crate::at_start;
use signal_hook::flag;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
pub use taker::Taker;

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
}

#[cfg(unix)]
const ENDING: [i32; 3] = {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    [SIGHUP, SIGINT, SIGTERM]
};
#[cfg(not(unix))]
const ENDING: [i32; 2] = [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM];

impl Signals {
    /// From now on, a signal ends the program at once with a status of its own. One that is ignored stays so.
    pub fn watch() -> io::Result<Self> {
        let signals = Self { received: Arc::default(), ends: Arc::new(AtomicBool::new(true)) };
        for signal in ENDING.into_iter().filter(|&signal| !at_start::ignores(signal)) {
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

    /// From now on, the first signal is noted, and the second one ends the program at once.
    pub fn end_at_second(&self) {
        self.ends.store(false, Ordering::SeqCst);
    }
}
