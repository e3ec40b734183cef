//! Ends work that takes too long.

use super::Progress;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A deadline that can be moved to now.
#[derive(Debug)]
pub struct Stop {
    deadline: Instant,
    is_cancelled: AtomicBool,
}

impl Stop {
    /// Stops at this time.
    pub fn at(deadline: Instant) -> Self {
        Self { deadline, is_cancelled: AtomicBool::new(false) }
    }

    /// Stops now.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Returns true if the work should end.
    pub fn is_over(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed) || Instant::now() >= self.deadline
    }

    /// Ends a render after the deadline. This is a [`Watch`](super::Watch).
    pub fn watch(&self, _: Progress) -> ControlFlow<()> {
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
