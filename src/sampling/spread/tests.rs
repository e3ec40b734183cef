//! Compares the sums of batches with sums of single samples.

use super::*;
use crate::math::instructions;
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};

/// Returns colours of every magnitude, and some infinite or NaN if `exceptions`.
fn color(k: usize, exceptions: bool) -> Color {
    let x = (k as f64 * 0.618_033_988_749_894_9).fract();
    match k % 19 {
        5 if exceptions => Color::new(f64::NAN, x, 0.0),
        11 if exceptions => Color::new(x, f64::NEG_INFINITY, f64::INFINITY),
        _ => Color::new(x, -x, libm::exp2(200.0 * x - 100.0)),
    }
}

/// Returns the part of its pixel that a sample represents.
fn area(k: usize) -> f64 {
    [1.0, 0.25, 0.0625, 1.0 / 1024.0][k % 4]
}

/// Adds the samples of a row one by one to a spread and to sums, and compares them bit by bit.
fn check_row(filter: Filter, sampler: Sampler, row: usize, size: [usize; 2], exceptions: bool) {
    let support = filter.support();
    let reached = |target: usize, own: usize| target.abs_diff(own) <= support;
    let samples: Vec<(usize, DVec2)> = (0..size[0])
        .flat_map(|x| sampler.offsets((x * size[1] + row) as u64).map(move |offset| (x, offset)))
        .collect();
    for level in instructions::available() {
        let mut spread = Spread::new(filter, level, row, size);
        for (k, (x, offset)) in samples.iter().enumerate() {
            spread.add(*x, *offset, color(k, exceptions), area(k));
        }
        let rows: Vec<usize> = spread.sums().map(|(target, _)| target).collect();
        assert_eq!(rows, (0..size[1]).filter(|target| reached(*target, row)).collect::<Vec<_>>());
        for (target_row, sums) in spread.sums() {
            for (target_column, sum) in sums.iter().enumerate() {
                let mut expected = Sum::default();
                for (k, (x, offset)) in
                    samples.iter().enumerate().filter(|(_, s)| reached(target_column, s.0))
                {
                    let weight = weight_for([target_column, target_row], filter, [*x, row], *offset);
                    expected.add(weight * area(k), color(k, exceptions), 1.0);
                }
                assert_eq!(sum.bits(), expected.bits(), "{filter:?} {sampler:?} {size:?} {target_column}");
            }
        }
    }
}

#[test]
fn batches_have_the_sums_of_single_samples() {
    for size in [[7, 5], [1, 9], [40, 1], [3, 3]] {
        for (pattern, count) in
            [(Pattern::Uniform, 1), (Pattern::Jittered, 3), (Pattern::Random, 16), (Pattern::Jittered, 21)]
        {
            let sampler = Sampler::new(pattern, count, Drand48::UNSEEDED);
            for radius in [0.51, 1.0, 2.7, 6.0] {
                let gaussian = Filter::Gaussian { sigma: radius / 2.0 };
                for filter in
                    [Filter::Box { radius }, Filter::Tent { radius }, gaussian, Filter::Mitchell { radius }]
                {
                    check_row(filter, sampler, size[1] / 2, size, false);
                    check_row(filter, sampler, size[1] - 1, size, true);
                }
            }
        }
    }
}

#[test]
fn the_largest_spread_takes_the_bytes_that_are_announced() {
    for (radius, size) in [(2.7, [3, 9]), (9.0, [3, 4])] {
        let filter = Filter::Box { radius };
        let spread = |row| Spread::new(filter, Level::baseline(), row, size);
        let largest = (0..size[1]).map(|row| size_of_val(&*spread(row).sums)).max();
        assert_eq!(largest, Some(Spread::bytes(filter, size)));
    }
}
