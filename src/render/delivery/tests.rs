//! The order and the number of undelivered rows, and the end of a delivery.

use super::*;
use std::ops::ControlFlow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

const ROWS: usize = 1000;

/// Delivers rows on this number of threads, and returns the rows that are handed out and the result.
fn delivered(
    threads: usize,
    goes_on: impl Fn(usize) -> bool + Sync,
    trace: impl Fn(usize) -> usize + Sync,
    mut take: impl FnMut(usize) -> Result<(), Stopped> + Send,
) -> (Vec<usize>, Result<usize, Stopped>) {
    let watch = |progress: crate::render::Progress| match goes_on(progress.done) {
        true => ControlFlow::Continue(()),
        false => ControlFlow::Break(()),
    };
    let tally = Tally::new(ROWS, &watch);
    let trace = |row, _used| {
        let traced = trace(row);
        tally.row_is_done(0);
        Some(traced)
    };
    let mut rows = vec![];
    let hand_out = |row: &mut usize| {
        rows.push(*row);
        take(*row)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let result = pool.install(|| in_order(ROWS, &tally, trace, hand_out));
    (rows, result)
}

#[test]
fn rows_are_handed_out_in_order_and_not_many_wait_for_a_slow_one() {
    for threads in [1, 2, 5] {
        let (traced, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let trace = |row| {
            if row == 300 {
                std::thread::sleep(Duration::from_millis(20));
            }
            traced.fetch_add(1, Ordering::Relaxed);
            row
        };
        let take = |row| {
            most.fetch_max(traced.load(Ordering::Relaxed) - row, Ordering::Relaxed);
            Ok(())
        };
        let (rows, result) = delivered(threads, |_| true, trace, take);
        assert!(rows.into_iter().eq(0..ROWS));
        assert_eq!(result, Ok(ROWS));
        let most = most.into_inner();
        assert!(most <= ROWS_PER_THREAD * threads, "{most} rows with {threads} threads");
    }
}

#[test]
fn what_a_cancelled_render_has_traced_is_handed_out() {
    for threads in [1, 3] {
        let (rows, result) = delivered(threads, |done| done < 40, |row| row, |_| Ok(()));
        assert!((40..40 + threads).contains(&rows.len()), "{}", rows.len());
        assert_eq!(result, Ok(rows.len()));
        assert!(rows.iter().copied().eq(0..rows.len()));
    }
}

#[test]
fn the_first_failure_ends_the_delivery() {
    for threads in [1, 3] {
        let traced = AtomicUsize::new(0);
        let trace = |row| {
            traced.fetch_add(1, Ordering::Relaxed);
            row
        };
        let full = |row| if row == 200 { Err(Stopped::Output) } else { Ok(()) };
        let (rows, result) = delivered(threads, |_| true, trace, full);
        assert_eq!(result, Err(Stopped::Output));
        assert!(rows.into_iter().eq(0..=200));
        assert!(traced.into_inner() <= 201 + ROWS_PER_THREAD * threads);
    }
}

#[test]
fn no_thread_waits_for_a_row_that_has_panicked() {
    let trace = |row| {
        assert_ne!(row, 100, "on purpose");
        row
    };
    let delivery = || delivered(3, |_| true, trace, |_| Ok(()));
    assert!(catch_unwind(AssertUnwindSafe(delivery)).is_err());
}

#[test]
fn rows_that_are_handed_out_are_used_again() {
    let (new, goes_on) = (AtomicUsize::new(0), |_| ControlFlow::Continue(()));
    let tally = Tally::new(ROWS, &goes_on);
    let trace = |row, used: Option<usize>| {
        new.fetch_add(usize::from(used.is_none()), Ordering::Relaxed);
        assert!(used.is_none_or(|used| used < row));
        Some(row)
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let result = pool.install(|| in_order(ROWS, &tally, trace, |_| Ok::<(), Stopped>(())));
    assert_eq!((result, new.into_inner()), (Ok(ROWS), 1));
}
