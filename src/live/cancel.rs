//! Whether somebody still waits for an answer.

use std::sync::atomic::{AtomicU64, Ordering};

/// Tells whether work on a question is for nobody any more.
pub struct Cancel<'a> {
    /// The last question for whose answer nobody waits.
    stopped: &'a AtomicU64,
    number: u64,
}

impl<'a> Cancel<'a> {
    /// For the question with this number.
    pub fn new(stopped: &'a AtomicU64, number: u64) -> Self {
        Self { stopped, number }
    }

    /// Whether the work should stop.
    pub fn is_over(&self) -> bool {
        self.stopped.load(Ordering::Relaxed) >= self.number
    }
}
