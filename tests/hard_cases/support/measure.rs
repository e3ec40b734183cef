//! Runs the inputs of a case in parallel. The results are sums of integers and maxima, which do not depend on
//! the order.

use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// The sums of the counts and the maxima of the values that `one` returns for each index below `inputs`. A
/// NaN counts as infinity.
pub fn measure<const N: usize, const M: usize>(
    inputs: u64,
    one: impl Fn(u64) -> ([u64; N], [f64; M]) + Sync,
) -> ([u64; N], [f64; M]) {
    measured(inputs, &one)
}

/// The loop over the inputs, which is compiled once for all cases with as many results.
fn measured<const N: usize, const M: usize>(
    inputs: u64,
    one: &(dyn Fn(u64) -> ([u64; N], [f64; M]) + Sync),
) -> ([u64; N], [f64; M]) {
    let none = || ([0; N], [0.0; M]);
    let merged = |(a, x): ([u64; N], [f64; M]), (b, y): ([u64; N], [f64; M])| {
        let sums = std::array::from_fn(|i| a[i] + b[i]);
        let larger = |x: f64, y: f64| if x.is_nan() || y.is_nan() { f64::INFINITY } else { x.max(y) };
        (sums, std::array::from_fn(|i| larger(x[i], y[i])))
    };
    (0..inputs as usize)
        .into_par_iter()
        .with_min_len(64)
        .map(|i| one(i as u64))
        .fold(none, merged)
        .reduce(none, merged)
}

/// Prints the first few failures of a case, so that they can be reproduced individually.
#[derive(Default)]
pub struct Failures(AtomicU32);

impl Failures {
    const SHOWN: u32 = 3;

    /// Returns 1 for a failure, and prints its message if it is among the first.
    pub fn note(&self, failed: bool, message: impl FnOnce() -> String) -> u64 {
        if failed && self.0.fetch_add(1, Ordering::Relaxed) < Self::SHOWN {
            println!("{}", message());
        }
        failed as u64
    }
}

/// An error in units in the last place of an f32 of the magnitude of `exact`.
pub fn ulps32(error: f64, exact: f64) -> f64 {
    let exponent = exact.abs().max(f32::MIN_POSITIVE as f64).log2().floor();
    error.abs() / (exponent - 23.0).exp2()
}
