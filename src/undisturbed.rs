//! Work that no signal cuts short.
//!
//! A signal goes to any thread that does not block it. So all threads but the first block every signal from their start
//! on, and the first one blocks them for as long as a file has a name that it must not keep.

use std::sync::{Mutex, PoisonError};

/// Held by the thread whose work must not be cut short.
static AT_WORK: Mutex<()> = Mutex::new(());

/// Does work in whose course the program is ended neither by a signal, which waits, nor by a thread that waits for its
/// turn to do the same.
pub fn undisturbed<T>(work: impl FnOnce() -> T) -> T {
    let _turn = AT_WORK.lock().unwrap_or_else(PoisonError::into_inner);
    without_signals(work)
}

/// Does work while this thread blocks every signal. Threads that are started by it block them for good.
pub fn without_signals<T>(work: impl FnOnce() -> T) -> T {
    let _blocked = blocked::Blocked::all();
    work()
}

#[cfg(unix)]
mod blocked {
    use nix::sys::signal::{SigSet, SigmaskHow};

    /// Signals are blocked until this is dropped. It has what was blocked before.
    pub struct Blocked(Option<SigSet>);

    impl Blocked {
        pub fn all() -> Self {
            Self(SigSet::all().thread_swap_mask(SigmaskHow::SIG_BLOCK).ok())
        }
    }

    impl Drop for Blocked {
        fn drop(&mut self) {
            if let Some(before) = self.0 {
                let _ = before.thread_set_mask();
            }
        }
    }
}

#[cfg(not(unix))]
mod blocked {
    pub struct Blocked;

    impl Blocked {
        pub fn all() -> Self {
            Self
        }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use nix::sys::signal::{SigSet, Signal};
    use std::thread;

    fn blocks(signal: Signal) -> bool {
        SigSet::thread_get_mask().unwrap().contains(signal)
    }

    #[test]
    fn signals_are_blocked_during_work_and_for_good_in_threads_that_it_starts() {
        let of_thread = undisturbed(|| {
            assert!(blocks(Signal::SIGUSR1) && blocks(Signal::SIGINT));
            thread::spawn(|| blocks(Signal::SIGTERM))
        });
        assert!(!blocks(Signal::SIGUSR1) && !blocks(Signal::SIGINT));
        assert!(of_thread.join().unwrap());
    }
}
