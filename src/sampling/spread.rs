//! What the samples of one row of pixels contribute to the picture.
//!
//! Weights cost more than the sums: most need an exponential function or a square root for every pixel within
//! the filter's reach. So samples are weighted in batches, with one sample in each SIMD lane.

use super::filter::Filter;
use super::sum::Sum;
use crate::math::f64x4::F64x4;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::memory::{self, NoMemory};
use crate::scene::Color;
use glam::DVec2;
use std::ops::RangeInclusive;

/// The weight for the pixel `target` of a sample of the pixel `own`, at `offset` from the latter's centre.
pub fn weight_for(target: [usize; 2], filter: Filter, own: [usize; 2], offset: DVec2) -> f64 {
    let from_target = DVec2::new(own[0] as f64 - target[0] as f64, own[1] as f64 - target[1] as f64);
    filter.weight(from_target + offset)
}

/// The number of samples that are weighted together, in groups of as many as there are SIMD lanes.
const BATCH: usize = GROUPS * LANES;
const GROUPS: usize = 4;
const LANES: usize = 4;

/// One number for each sample of a batch.
type PerSample = [[f64; LANES]; GROUPS];

/// Samples of a row that have not been weighted yet.
#[derive(Clone, Debug, Default)]
struct Batch {
    count: usize,
    /// The columns of the samples' pixels.
    columns: [usize; BATCH],
    /// The samples' offsets from their pixels' centres, along x and along y.
    offsets: [PerSample; 2],
    /// Their colours times their areas, each followed by the area, so that the weights are added up as the colours
    /// are.
    colors: [[f64; 4]; BATCH],
}

impl Batch {
    #[inline(always)]
    fn push(&mut self, column: usize, offset: DVec2, color: Color, area: f64) {
        let k = self.count;
        self.columns[k] = column;
        for (offsets, offset) in self.offsets.iter_mut().zip(offset.to_array()) {
            offsets[k / LANES][k % LANES] = offset;
        }
        let color = area * color;
        self.colors[k] = [color.x, color.y, color.z, area];
        self.count = k + 1;
    }
}

/// A column of the picture that the samples of a batch contribute to, relative to each sample's own.
#[derive(Clone, Debug, Default)]
struct TargetColumn {
    /// The terms of the samples' weights along x.
    x_terms: PerSample,
    /// Their weights in the row of the picture at hand.
    weights: PerSample,
}

/// The contributions of the samples in one row of pixels to that row and the rows around it.
#[derive(Clone, Debug)]
pub struct Spread {
    filter: Filter,
    instructions: Instructions,
    width: usize,
    /// The row of pixels that the samples lie in.
    row: usize,
    /// The rows of the picture that the samples contribute to.
    target_rows: RangeInclusive<usize>,
    /// The number of columns on either side that a sample contributes to.
    reach: usize,
    /// The sums of these rows, one row after the other.
    sums: Vec<Sum>,
    batch: Box<Batch>,
    /// The columns that a sample contributes to, from left to right.
    target_columns: Vec<TargetColumn>,
}

impl Spread {
    /// An empty spread for row `row` of a picture with this width and height.
    pub fn new(
        filter: Filter,
        instructions: Instructions,
        row: usize,
        [width, height]: [usize; 2],
    ) -> Result<Self, NoMemory> {
        // A support beyond the picture's size makes no difference.
        let support = filter.support().min(width.max(height));
        let target_rows = row.saturating_sub(support)..=(row + support).min(height - 1);
        let rows = target_rows.end() - target_rows.start() + 1;
        let reach = support.min(width - 1);
        Ok(Self {
            filter,
            instructions,
            width,
            row,
            target_rows,
            reach,
            sums: memory::filled(Sum::default(), rows * width)?,
            batch: Box::default(),
            target_columns: memory::filled(TargetColumn::default(), 2 * reach + 1)?,
        })
    }

    /// The memory in bytes that the sums of one spread take at most.
    pub fn bytes(filter: Filter, [width, height]: [usize; 2]) -> usize {
        (2 * filter.support() + 1).min(height) * width * size_of::<Sum>()
    }

    /// Adds a sample of the pixel in column `x`, at `offset` from the pixel's centre. `area` is the part of the pixel
    /// that it stands for, which multiplies its weight; it is a power of 2, so that the product is exact.
    #[inline]
    pub fn add(&mut self, x: usize, offset: DVec2, color: Color, area: f64) {
        self.batch.push(x, offset, color, area);
        if self.batch.count == BATCH {
            self.weigh();
        }
    }

    /// The row of pixels that the samples lie in.
    pub(super) fn row(&self) -> usize {
        self.row
    }

    /// The rows of the picture that the samples contribute to, each with its sums.
    pub(super) fn sums(&mut self) -> impl Iterator<Item = (usize, &[Sum])> {
        self.weigh();
        self.target_rows.clone().zip(self.sums.chunks(self.width))
    }

    /// Adds the samples of the batch to the sums.
    fn weigh(&mut self) {
        match self.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) => unsafe { weigh_avx2(avx2, self) },
            Instructions::Portable => self.weigh_with::<crate::math::f64x4::Scalar>(Portable),
        }
    }

    /// Each filter has a loop of its own, whose constants stay in registers.
    #[inline(always)]
    fn weigh_with<F: F64x4>(&mut self, proof: F::Proof) {
        match self.filter {
            Filter::Box { radius } => self.weigh_by::<F>(proof, Filter::Box { radius }),
            Filter::Tent { radius } => self.weigh_by::<F>(proof, Filter::Tent { radius }),
            Filter::Gaussian { sigma } => self.weigh_by::<F>(proof, Filter::Gaussian { sigma }),
            Filter::Mitchell { radius } => self.weigh_by::<F>(proof, Filter::Mitchell { radius }),
        }
    }

    #[inline(always)]
    fn weigh_by<F: F64x4>(&mut self, proof: F::Proof, filter: Filter) {
        let Batch { count, columns, offsets: [x, y], colors } = &*self.batch;
        let columns = &columns[..*count];
        for (k, target) in self.target_columns.iter_mut().enumerate() {
            let distance = F::splat(proof, self.reach as f64 - k as f64);
            for (x_terms, x) in target.x_terms.iter_mut().zip(x) {
                *x_terms = filter.axis_terms(F::new(proof, *x) + distance).to_array();
            }
        }
        let are_finite = colors[..*count].iter().all(|color| is_finite(F::new(proof, *color)));
        for target_row in self.target_rows.clone() {
            let distance = F::splat(proof, self.row as f64 - target_row as f64);
            let mut y_terms = [distance; GROUPS];
            for (y_terms, y) in y_terms.iter_mut().zip(y) {
                *y_terms = filter.axis_terms(F::new(proof, *y) + distance);
            }
            for TargetColumn { x_terms, weights } in &mut self.target_columns {
                for ((weights, x_terms), y_terms) in weights.iter_mut().zip(x_terms).zip(y_terms) {
                    *weights = filter.weights(F::new(proof, *x_terms), y_terms).to_array();
                }
            }
            let start = (target_row - self.target_rows.start()) * self.width;
            let row = &mut self.sums[start..start + self.width];
            let mut first = 0;
            for run in columns.chunk_by(|a, b| a == b) {
                let samples = first..first + run.len();
                first = samples.end;
                for (sum, target) in reached(row, &self.target_columns, run[0]) {
                    let weights = &target.weights.as_flattened()[samples.clone()];
                    sum.add_all::<F>(proof, weights, &colors[samples.clone()], are_finite);
                }
            }
        }
        self.batch.count = 0;
    }
}

/// The sums in a row of the picture that a sample in this column contributes to, each with its target column.
#[inline(always)]
fn reached<'a>(
    row: &'a mut [Sum],
    targets: &'a [TargetColumn],
    column: usize,
) -> impl Iterator<Item = (&'a mut Sum, &'a TargetColumn)> {
    let reach = targets.len() / 2;
    let first = column.saturating_sub(reach);
    row[first..].iter_mut().zip(&targets[first + reach - column..])
}

/// Whether no lane is infinite or NaN.
#[inline(always)]
fn is_finite<F: F64x4>(x: F) -> bool {
    let zeros = x * x.broadcast(0.0);
    zeros.le_mask(zeros) == 0b1111
}

/// Weighs the samples of a spread's batch, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn weigh_avx2(avx2: Avx2, spread: &mut Spread) {
    spread.weigh_with::<crate::math::avx::Avx>(avx2);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::drand48::Drand48;
    use crate::sampling::sampler::{Pattern, Sampler};

    #[test]
    fn a_sample_counts_by_its_distance_from_each_pixel_s_centre() {
        let (filter, size) = (Filter::Tent { radius: 2.5 }, [5, 5]);
        let (x, y, offset) = (1, 3, DVec2::new(0.25, -0.375));
        let mut spread = Spread::new(filter, Instructions::Portable, y, size).unwrap();
        spread.add(x, offset, Color::splat(2.0), 1.0);
        assert_eq!(spread.target_rows, 1..=4);
        for (row, sums) in spread.sums() {
            for (column, sum) in sums.iter().enumerate() {
                let position = DVec2::new(1.0 - column as f64, 3.0 - row as f64) + offset;
                // The support is two pixels along each axis.
                let weight = if column <= 3 { filter.weight(position) } else { 0.0 };
                let mut expected = Sum::default();
                expected.add(weight, Color::splat(2.0));
                assert_eq!(*sum, expected, "{column} {row}");
            }
        }
    }

    /// Colours of every magnitude, and some that are infinite or NaN if `exceptions` says so.
    fn color(k: usize, exceptions: bool) -> Color {
        let x = (k as f64 * 0.618_033_988_749_894_9).fract();
        match k % 19 {
            5 if exceptions => Color::new(f64::NAN, x, 0.0),
            11 if exceptions => Color::new(x, f64::NEG_INFINITY, f64::INFINITY),
            _ => Color::new(x, -x, libm::exp2(200.0 * x - 100.0)),
        }
    }

    /// The part of its pixel that a sample stands for.
    fn area(k: usize) -> f64 {
        [1.0, 0.25, 0.0625, 1.0 / 1024.0][k % 4]
    }

    /// Adds the samples of a row one by one to a spread and to sums, and compares these to the bit.
    fn check_row(filter: Filter, sampler: Sampler, row: usize, size: [usize; 2], exceptions: bool) {
        let support = filter.support();
        let reached = |target: usize, own: usize| target.abs_diff(own) <= support;
        let samples: Vec<(usize, DVec2)> = (0..size[0])
            .flat_map(|x| sampler.offsets((x * size[1] + row) as u64).map(move |offset| (x, offset)))
            .collect();
        for instructions in Instructions::available() {
            let mut spread = Spread::new(filter, instructions, row, size).unwrap();
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
                        expected.add(weight * area(k), color(k, exceptions));
                    }
                    assert_eq!(
                        sum.bits(),
                        expected.bits(),
                        "{filter:?} {sampler:?} {size:?} {target_column}"
                    );
                }
            }
        }
    }

    #[test]
    fn batches_have_the_sums_of_single_samples() {
        for size in [[7, 5], [1, 9], [40, 1], [3, 3]] {
            for (pattern, count) in [
                (Pattern::Uniform, 1),
                (Pattern::Jittered, 3),
                (Pattern::Random, 16),
                (Pattern::Jittered, 21),
            ] {
                let sampler = Sampler::new(pattern, count, Drand48::UNSEEDED);
                for radius in [0.51, 1.0, 2.7, 6.0] {
                    let gaussian = Filter::Gaussian { sigma: radius / 2.0 };
                    for filter in [
                        Filter::Box { radius },
                        Filter::Tent { radius },
                        gaussian,
                        Filter::Mitchell { radius },
                    ] {
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
            let spread = |row| Spread::new(filter, Instructions::Portable, row, size).unwrap();
            let largest = (0..size[1]).map(|row| size_of_val(&*spread(row).sums)).max();
            assert_eq!(largest, Some(Spread::bytes(filter, size)));
        }
    }
}
