//! Signals that ask the program to end: Ctrl-C, SIGTERM, and SIGHUP of a terminal that closes.
//!
//! A signal ends it at once, also while it waits for a pipe. While rows are rendered, the first signal is only noted:
//! the watch of the render sees it, and the complete rows are kept.

use super::End;
use crate::base::lock;
use crate::image_io::NAMING;
use signal_hook::consts::{SIGINT, SIGTERM};
use std::io;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

/// A task that is done before a signal ends the program.
type Task = Box<dyn FnOnce() + Send>;

/// The reaction to signals.
#[derive(Clone, Default)]
pub struct Signals {
    /// The last signal that came; 0 for none.
    received: Arc<AtomicUsize>,
    /// True if the first signal is only noted.
    is_first_noted: Arc<AtomicBool>,
    before_end: Arc<Mutex<Option<Task>>>,
}

impl Signals {
    /// From now on, a signal ends the program at once, with the status that shells give it.
    pub fn watch() -> io::Result<Self> {
        let signals = Self::default();
        signals.clone().take()?;
        Ok(signals)
    }

    /// Returns the end of the run if a signal came.
    pub fn received(&self) -> Option<End> {
        match self.received.load(Ordering::SeqCst) {
            0 => None,
            // The status that shells give it.
            signal => Some(End { error: None, status: (128 + signal) as u8 }),
        }
    }

    /// Returns `Break` if a signal came, for the watch of a render.
    pub fn goes_on(&self) -> ControlFlow<()> {
        if self.received().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// From now on, the first signal is noted, and the second one ends the program at once.
    pub fn note_first(&self) {
        self.is_first_noted.store(true, Ordering::SeqCst);
    }

    /// From now on, a signal ends the program at once. Returns an error if one was noted before.
    pub fn end_at_once(&self) -> Result<(), End> {
        self.is_first_noted.store(false, Ordering::SeqCst);
        self.received().map_or(Ok(()), Err)
    }

    /// From now on, this task is done before a signal ends the program, in place of an earlier one.
    pub fn before_end(&self, task: impl FnOnce() + Send + 'static) {
        *lock(&self.before_end) = Some(Box::new(task));
    }

    fn on_signal(&self, signal: i32) {
        let is_first = self.received.swap(signal as usize, Ordering::SeqCst) == 0;
        if is_first && self.is_first_noted.load(Ordering::SeqCst) {
            return;
        }
        let task = lock(&self.before_end).take();
        task.into_iter().for_each(|task| task());
        let _naming = lock(&NAMING);
        signal_hook::low_level::exit(128 + signal)
    }

    /// Starts a thread that takes the signals.
    #[cfg(unix)]
    fn take(self) -> io::Result<()> {
        use signal_hook::consts::{SIGHUP, SIGXFSZ};
        use signal_hook::iterator::Signals;
        // A file that grows beyond the limit of `ulimit -f` is an error of the write, and not the end of the program.
        signal_hook::flag::register(SIGXFSZ, Arc::default())?;
        let hangup = (!ignores_hangup()).then_some(SIGHUP);
        let mut taken = Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup))?;
        const STACK: usize = 1 << 18;
        let thread = std::thread::Builder::new().name("signals".into()).stack_size(STACK);
        // It has all its memory before others take the rest.
        let (start, started) = std::sync::mpsc::sync_channel(1);
        thread.spawn(move || {
            let _ = start.send(());
            taken.forever().for_each(|signal| self.on_signal(signal));
        })?;
        started.recv().map_err(|_| io::ErrorKind::OutOfMemory.into())
    }

    /// Handles the signals where they come, which is a thread of its own.
    #[cfg(not(unix))]
    fn take(self) -> io::Result<()> {
        use signal_hook::low_level::register;
        for signal in [SIGINT, SIGTERM] {
            let signals = self.clone();
            // SAFETY: this system calls the handler on a thread of its own, where it may do what any thread may.
            unsafe { register(signal, move || signals.on_signal(signal)) }?;
        }
        Ok(())
    }
}

/// Returns true if the program was started to outlive its terminal, as by `nohup`.
#[cfg(unix)]
fn ignores_hangup() -> bool {
    // SAFETY: all zeros are a valid value of the structure, and the call only writes the present action to it.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        libc::sigaction(libc::SIGHUP, std::ptr::null(), &mut action) == 0
            && action.sa_sigaction == libc::SIG_IGN
    }
}
