//! The contributions of one row's samples to the picture.
//!
//! Computing weights costs more than summing: most need an exponential or a square root for every pixel within the
//! filter's reach. So samples are weighted in batches, with one sample in each SIMD lane.

use super::filter::Filter;
use super::sum::Sum;
use crate::math::instructions::Level;
use crate::math::simd::{FourLanes, LANES, Number};
use crate::picture::Color;
use fearless_simd::{Simd, SimdFrom, dispatch, f64x4};
use glam::DVec2;
use std::ops::RangeInclusive;

/// Returns the weight for the pixel `target` of a sample in the pixel `own`, at `offset` from the centre of `own`.
pub fn weight_for(target: [usize; 2], filter: Filter, own: [usize; 2], offset: DVec2) -> f64 {
    let from_target = DVec2::new(own[0] as f64 - target[0] as f64, own[1] as f64 - target[1] as f64);
    filter.weight(from_target + offset)
}

/// The number of samples weighted together, in groups of one sample per SIMD lane.
const BATCH: usize = GROUPS * LANES;
const GROUPS: usize = 4;

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
    /// The colours times the areas, each followed by the area, so that weights are summed like colours.
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

/// A column of the picture that a batch's samples contribute to, relative to each sample's own column.
#[derive(Clone, Debug, Default)]
struct TargetColumn {
    /// The terms of the samples' weights along x.
    x_terms: PerSample,
    /// The samples' weights in the current row of the picture.
    weights: PerSample,
}

/// The contributions of the samples in one row of pixels to that row and the rows around it.
#[derive(Clone, Debug)]
pub struct Spread {
    filter: Filter,
    level: Level,
    width: usize,
    /// The row of pixels that contains the samples.
    row: usize,
    /// The rows of the picture that the samples contribute to.
    target_rows: RangeInclusive<usize>,
    /// The number of columns on either side that a sample contributes to.
    reach: usize,
    /// The sums of these rows, in row-major order.
    sums: Vec<Sum>,
    batch: Box<Batch>,
    /// The columns that a sample contributes to, from left to right.
    target_columns: Vec<TargetColumn>,
}

impl Spread {
    /// Creates an empty spread for the row `row` of a picture with this width and height.
    pub fn new(filter: Filter, level: Level, row: usize, [width, height]: [usize; 2]) -> Self {
        // A support beyond the picture's size makes no difference.
        let support = filter.support().min(width.max(height));
        let target_rows = row.saturating_sub(support)..=(row + support).min(height - 1);
        let rows = target_rows.end() - target_rows.start() + 1;
        let reach = support.min(width - 1);
        Self {
            filter,
            level,
            width,
            row,
            target_rows,
            reach,
            sums: vec![Sum::default(); rows * width],
            batch: Box::default(),
            target_columns: vec![TargetColumn::default(); 2 * reach + 1],
        }
    }

    /// Returns the largest memory in bytes of one spread's sums.
    pub fn bytes(filter: Filter, [width, height]: [usize; 2]) -> usize {
        (2 * filter.support() + 1).min(height) * width * size_of::<Sum>()
    }

    /// Adds a sample of the pixel in column `x`, at `offset` from the pixel's centre. Its weight is multiplied by
    /// `area`, the part of the pixel that it represents.
    #[inline]
    pub fn add(&mut self, x: usize, offset: DVec2, color: Color, area: f64) {
        self.batch.push(x, offset, color, area);
        if self.batch.count == BATCH {
            self.weigh();
        }
    }

    /// Returns the row of pixels that contains the samples.
    pub(super) fn row(&self) -> usize {
        self.row
    }

    /// Returns the rows of the picture that the samples contribute to, each with its sums.
    pub(super) fn sums(&mut self) -> impl Iterator<Item = (usize, &[Sum])> {
        self.weigh();
        self.target_rows.clone().zip(self.sums.chunks(self.width))
    }

    /// Adds the samples of the batch to the sums.
    fn weigh(&mut self) {
        dispatch!(self.level, simd => self.weigh_at(simd));
    }

    #[inline(always)]
    fn weigh_at<S: Simd>(&mut self, simd: S) {
        let filter = self.filter;
        let Batch { count, columns, offsets: [x, y], colors } = &*self.batch;
        let columns = &columns[..*count];
        for (k, target) in self.target_columns.iter_mut().enumerate() {
            let distance = f64x4::splat(simd, self.reach as f64 - k as f64);
            for (x_terms, x) in target.x_terms.iter_mut().zip(x) {
                *x_terms = filter.axis_term(f64x4::simd_from(simd, *x) + distance).to_array();
            }
        }
        let are_finite = colors[..*count].iter().all(|color| is_finite(f64x4::simd_from(simd, *color)));
        for target_row in self.target_rows.clone() {
            let distance = f64x4::splat(simd, self.row as f64 - target_row as f64);
            let mut y_terms = [distance; GROUPS];
            for (y_terms, y) in y_terms.iter_mut().zip(y) {
                *y_terms = filter.axis_term(f64x4::simd_from(simd, *y) + distance);
            }
            for TargetColumn { x_terms, weights } in &mut self.target_columns {
                for ((weights, x_terms), y_terms) in weights.iter_mut().zip(x_terms).zip(y_terms) {
                    *weights = filter.weights(f64x4::simd_from(simd, *x_terms), y_terms).to_array();
                }
            }
            let start = (target_row - self.target_rows.start()) * self.width;
            let row = &mut self.sums[start..start + self.width];
            let mut first = 0;
            for run in columns.chunk_by(|a, b| a == b) {
                let samples = first..first + run.len();
                for (sum, target) in reached(row, &self.target_columns, run[0]) {
                    let weights = &target.weights.as_flattened()[samples.clone()];
                    sum.add_all::<S>(simd, weights, &colors[samples.clone()], are_finite);
                }
                first = samples.end;
            }
        }
        self.batch.count = 0;
    }
}

/// Returns the sums in a row of the picture that a sample in this column contributes to, each with its target column.
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

/// Returns true if all lanes are finite.
#[inline(always)]
fn is_finite<S: Simd>(x: f64x4<S>) -> bool {
    let zeros = x * x.broadcast(0.0);
    zeros.le_mask(zeros) == 0b1111
}

#[cfg(test)]
mod tests;
