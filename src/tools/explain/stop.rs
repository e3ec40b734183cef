//! The end of work that takes too long.

use crate::render::Progress;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// When to stop.
#[derive(Debug)]
pub struct Stop {
    deadline: Instant,
    is_over: AtomicBool,
}

impl Stop {
    /// At this time.
    pub fn at(deadline: Instant) -> Self {
        Self { deadline, is_over: AtomicBool::new(false) }
    }

    /// Now.
    pub fn cancel(&self) {
        self.is_over.store(true, Ordering::Relaxed);
    }

    /// Whether it is time.
    pub fn is_over(&self) -> bool {
        if !self.is_over.load(Ordering::Relaxed) && Instant::now() >= self.deadline {
            self.cancel();
        }
        self.is_over.load(Ordering::Relaxed)
    }

    /// Ends a render when it is time. This is a [`Watch`](crate::render::Watch).
    pub fn watch(&self, _: Progress) -> ControlFlow<()> {
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
