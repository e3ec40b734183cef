//! Delivers rows in order from the threads that trace them to the callback that takes them. Each row is delivered as
//! soon as it and all rows before it are traced.

use super::Stopped;
use super::tally::Tally;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// The maximum number of undelivered rows per thread. It is small enough that the rows take little memory, and large
/// enough that threads seldom wait for a slow row.
const ROWS_PER_THREAD: usize = 64;

/// Returns the maximum number of rows that are in memory at the same time, out of `rows`.
pub fn most_at_once(rows: usize) -> usize {
    rows.min(ROWS_PER_THREAD * rayon::current_num_threads())
}

/// Traces this number of rows in parallel, and hands them out one after the other. Returns the number of rows that
/// have been handed out: all, unless the watch cancels the render.
///
/// The thread that traces the next row due hands it out, together with all rows after it that are traced by then. The
/// other threads continue. `trace` returns `None` if it is cancelled, which ends the delivery. Its second argument is
/// a row that has been handed out, whose memory it can reuse. The first access to new memory takes longer than tracing
/// a simple pixel, and threads that free each other's memory wait for each other.
pub fn in_order<T: Send>(
    rows: usize,
    tally: &Tally,
    trace: impl Fn(usize, Option<T>) -> Option<T> + Sync,
    hand_out: impl FnMut(&mut T) -> Result<(), Stopped> + Send,
) -> Result<usize, Stopped> {
    let threads = rayon::current_num_threads();
    let places = (0..most_at_once(rows)).map(|_| None).collect();
    let (used, hand_out) = (vec![], Some(hand_out));
    let progress =
        Progress { rows, taken: 0, handed_out: 0, places, used, hand_out, waiting: 0, failure: None };
    let delivery = Delivery { progress: Mutex::new(progress), goes_on: Condvar::new() };
    let take_rows = || {
        let _end = End(&delivery);
        while let Some((row, used)) = delivery.take(tally) {
            let Some(traced) = trace(row, used) else { break };
            delivery.put(row, traced);
        }
    };
    rayon::scope(|scope| {
        (1..threads.min(rows)).for_each(|_| scope.spawn(|_| take_rows()));
        take_rows();
    });
    let progress = delivery.progress.into_inner().unwrap_or_else(PoisonError::into_inner);
    progress.failure.map_or(Ok(progress.handed_out), Err)
}

struct Delivery<T, H> {
    progress: Mutex<Progress<T, H>>,
    /// Signals that rows have been handed out, or that no more rows are taken.
    goes_on: Condvar,
}

struct Progress<T, H> {
    /// The number of rows to trace. It is reduced if the render fails.
    rows: usize,
    /// The number of rows that threads have taken so far, and the number of rows that have been handed out.
    taken: usize,
    handed_out: usize,
    /// The rows that are traced and not yet handed out. Row k is at index k modulo the length.
    places: Vec<Option<T>>,
    /// Rows that have been handed out, whose memory can be reused.
    used: Vec<T>,
    /// The callback that hands out a row. `None` while a thread calls it.
    hand_out: Option<H>,
    /// The number of threads that wait for a place.
    waiting: usize,
    failure: Option<Stopped>,
}

impl<T, H: FnMut(&mut T) -> Result<(), Stopped>> Delivery<T, H> {
    /// Waits for a free place, and returns the next row to trace and a row that is no longer needed, if there is one.
    /// Returns `None` if all rows are taken or the watch has cancelled the render.
    fn take(&self, tally: &Tally) -> Option<(usize, Option<T>)> {
        let mut progress = self.progress();
        while progress.taken < progress.rows && progress.taken - progress.handed_out == progress.places.len()
        {
            progress.waiting += 1;
            progress = self.goes_on.wait(progress).unwrap_or_else(PoisonError::into_inner);
            progress.waiting -= 1;
        }
        let row = progress.taken;
        (row < progress.rows && !tally.is_cancelled()).then(|| {
            progress.taken += 1;
            (row, progress.used.pop())
        })
    }

    /// Stores a row that is traced. If it is due, hands it out together with the traced rows after it, unless another
    /// thread is handing out rows.
    fn put(&self, row: usize, traced: T) {
        let mut progress = self.progress();
        let place = row % progress.places.len();
        progress.places[place] = Some(traced);
        let Some(mut hand_out) = progress.hand_out.take() else { return };
        while let Some(mut due) = progress.due() {
            drop(progress);
            let result = hand_out(&mut due);
            progress = self.progress();
            progress.used.push(due);
            if let Err(failure) = result {
                progress.failure = Some(failure);
                return self.end(progress);
            }
            progress.handed_out += 1;
            if progress.waiting > 0 {
                // Avoid this system call if no thread waits.
                self.goes_on.notify_all();
            }
        }
        progress.hand_out = Some(hand_out);
    }
}

impl<T, H> Delivery<T, H> {
    /// Ends the delivery: no thread takes another row.
    fn end(&self, mut progress: MutexGuard<Progress<T, H>>) {
        progress.rows = progress.taken;
        self.goes_on.notify_all();
    }

    fn progress(&self) -> MutexGuard<'_, Progress<T, H>> {
        self.progress.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<T, H> Progress<T, H> {
    /// Takes the row that is due, if it is traced.
    fn due(&mut self) -> Option<T> {
        let place = self.handed_out % self.places.len();
        self.places[place].take()
    }
}

/// Ends the delivery when it is dropped. So a thread that panics in its row ends it, too. Otherwise other threads
/// would wait for that row.
struct End<'d, T, H>(&'d Delivery<T, H>);

impl<T, H> Drop for End<'_, T, H> {
    fn drop(&mut self) {
        self.0.end(self.0.progress());
    }
}

#[cfg(test)]
mod tests;
