//! Ctrl-C and SIGTERM. A run ends in order: with its temporary files removed, and the complete rows kept.

use signal_hook::SigId;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{flag, low_level};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The end of a run by a signal: the program's exit status, as shells form it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interrupted(pub u8);

/// What becomes of the signals during a run.
///
/// While files are written, signals are only noted, because a temporary file has a name for that time. Elsewhere they
/// end the program at once, or the second one does where the first makes the work stop in order.
pub struct Signals {
    /// The last signal that came; 0 for none.
    received: Arc<AtomicUsize>,
    /// The handlers that end the program.
    enders: Vec<SigId>,
}

const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

impl Signals {
    /// From now on, signals are noted.
    pub fn hold() -> io::Result<Self> {
        let received = Arc::new(AtomicUsize::new(0));
        for signal in SIGNALS {
            flag::register_usize(signal, received.clone(), signal as usize)?;
        }
        Ok(Self { received, enders: vec![] })
    }

    /// The signal that came, if one did.
    pub fn received(&self) -> Option<Interrupted> {
        match self.received.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(Interrupted(status(signal as i32) as u8)),
        }
    }

    /// From now on, signals are noted.
    pub fn hold_again(&mut self) {
        for id in self.enders.drain(..) {
            low_level::unregister(id);
        }
    }

    /// From now on, a signal ends the program at once. An error if one was noted before.
    pub fn end_at_once(&mut self) -> Result<(), Interrupted> {
        self.end_if(&Arc::new(AtomicBool::new(true)))
    }

    /// From now on, the second signal ends the program at once, and the first is noted. An error if one was noted
    /// before.
    pub fn end_at_second(&mut self) -> Result<(), Interrupted> {
        let has_come = Arc::new(AtomicBool::new(self.received().is_some()));
        let noted = self.end_if(&has_come);
        for signal in SIGNALS {
            // This handler follows the one that looks at the flag. A handler that is refused has come before.
            self.enders.extend(flag::register(signal, has_come.clone()));
        }
        noted
    }

    /// From now on, a signal ends the program if the flag is set.
    fn end_if(&mut self, condition: &Arc<AtomicBool>) -> Result<(), Interrupted> {
        self.hold_again();
        for signal in SIGNALS {
            let end = flag::register_conditional_shutdown(signal, status(signal), condition.clone());
            self.enders.extend(end);
        }
        self.received().map_or(Ok(()), Err)
    }
}

fn status(signal: i32) -> i32 {
    128 + signal
}
