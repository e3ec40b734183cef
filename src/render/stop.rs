//! Ends work that takes too long.

use super::Progress;
use crate::base::patience::Patience;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A deadline that can be moved to now.
#[derive(Debug)]
pub struct Stop {
    deadline: Instant,
    has_stopped: AtomicBool,
}

impl Stop {
    /// Stops at this time.
    pub fn at(deadline: Instant) -> Self {
        Self { deadline, has_stopped: AtomicBool::new(false) }
    }

    /// Stops now.
    pub fn cancel(&self) {
        self.has_stopped.store(true, Ordering::Relaxed);
    }

    /// Returns true, and remembers it, if the work should end. Its result is incomplete then.
    pub fn is_over(&self) -> bool {
        if Instant::now() >= self.deadline {
            self.cancel();
        }
        self.has_stopped()
    }

    /// Returns true if `is_over` has returned true, or the work was cancelled. Work that never asked after the deadline
    /// is complete.
    pub fn has_stopped(&self) -> bool {
        self.has_stopped.load(Ordering::Relaxed)
    }

    /// Ends a render after the deadline. This is a [`Watch`](super::Watch).
    pub fn watch(&self, _: Progress) -> ControlFlow<()> {
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Patience for Stop {
    fn is_over(&self) -> bool {
        Self::is_over(self)
    }
}
