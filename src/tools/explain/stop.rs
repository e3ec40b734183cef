//! Ends work that takes too long.

use crate::render::Progress;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// A deadline that can be moved to now.
#[derive(Debug)]
pub struct Stop {
    deadline: Instant,
    is_over: AtomicBool,
}

impl Stop {
    /// Stops at this time.
    pub fn at(deadline: Instant) -> Self {
        Self { deadline, is_over: AtomicBool::new(false) }
    }

    /// Stops now.
    pub fn cancel(&self) {
        self.is_over.store(true, Ordering::Relaxed);
    }

    /// Returns true if the work should end.
    pub fn is_over(&self) -> bool {
        if !self.is_over.load(Ordering::Relaxed) && Instant::now() >= self.deadline {
            self.cancel();
        }
        self.is_over.load(Ordering::Relaxed)
    }

    /// Ends a render after the deadline. This is a [`Watch`](crate::render::Watch).
    pub fn watch(&self, _: Progress) -> ControlFlow<()> {
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
