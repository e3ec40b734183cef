//! The progress of a render, and the threads that trace its rows.

use super::{Progress, Stopped, Watch};
use crate::base::patience::Patience;
use crate::trace::MOST_WAITING;
use rayon::iter::{ParallelBridge, ParallelIterator};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// Counts the rows that have been traced, and records whether the watch has cancelled the render.
pub struct Tally<'a> {
    rows: usize,
    done: AtomicUsize,
    handed_out: AtomicUsize,
    /// The rays of the rows that have been traced.
    rays: AtomicU64,
    is_cancelled: AtomicBool,
    has_too_many_rays: AtomicBool,
    watch: Watch<'a>,
}

impl<'a> Tally<'a> {
    pub fn new(rows: usize, watch: Watch<'a>) -> Self {
        let (done, handed_out, rays, is_cancelled, has_too_many_rays) = Default::default();
        Self { rows, done, handed_out, rays, is_cancelled, has_too_many_rays, watch }
    }

    /// Cancels the render.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// Notes that a row has been traced with this number of rays.
    pub fn row_is_done(&self, rays: u64) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        let rays = self.rays.fetch_add(rays, Ordering::Relaxed) + rays;
        self.tell(done, rays);
    }

    /// Notes that a row has been handed out.
    pub fn row_is_handed_out(&self) {
        self.handed_out.fetch_add(1, Ordering::Relaxed);
    }

    /// Asks the watch to cancel or continue, and cancels the render if too many secondary rays of a camera ray wait.
    /// Returns true if the render is cancelled.
    pub fn asks(&self, waiting: usize) -> bool {
        if waiting > MOST_WAITING {
            self.has_too_many_rays.store(true, Ordering::Relaxed);
            self.cancel();
        }
        if !self.is_cancelled() {
            self.tell(self.done.load(Ordering::Relaxed), self.rays.load(Ordering::Relaxed));
        }
        self.is_cancelled()
    }

    /// Returns the reason why the render was cancelled.
    pub fn reason(&self) -> Stopped {
        let rows = self.handed_out.load(Ordering::Relaxed);
        let has_too_many_rays = self.has_too_many_rays.load(Ordering::Relaxed);
        if has_too_many_rays { Stopped::Rays } else { Stopped::Cancelled { rows } }
    }

    /// Calls `work` for each row, and returns the results in the order of the rows. Threads take the rows from the top.
    /// So if the render is cancelled, the topmost rows have results.
    pub fn in_parallel<T: Send>(
        &self,
        rows: Range<usize>,
        work: impl Fn(usize) -> Option<T> + Sync,
    ) -> Vec<Option<T>> {
        let work = |j| if self.is_cancelled() { None } else { Some((j, work(j)?)) };
        let done: Vec<(usize, T)> = rows.clone().rev().par_bridge().filter_map(work).collect();
        let mut results: Vec<Option<T>> = rows.clone().map(|_| None).collect();
        done.into_iter().for_each(|(j, result)| results[j - rows.start] = Some(result));
        results
    }

    /// Returns true if the render is cancelled. Work in progress may be incomplete then.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    fn tell(&self, done: usize, rays: u64) {
        if (self.watch)(Progress { done, rows: self.rows, rays }).is_break() {
            self.cancel();
        }
    }
}

impl Patience for Tally<'_> {
    fn is_over(&self) -> bool {
        self.asks(0)
    }
}
