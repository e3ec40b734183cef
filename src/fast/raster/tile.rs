//! A tile of the visibility buffer: some rows of pixels that one thread rasterizes with a depth test.
//!
//! Eight adjacent pixels are processed at a time, in single precision relative to the first pixel, and without
//! branches. Triangles often cover so few pixels that a mispredicted branch would cost more than the pixels it skips.
//! For each pixel the tile keeps an interval that contains the inverse depth of the nearest primitive. If the
//! intervals of two primitives overlap, or an edge function is within its error bound of zero, the pixel is marked as
//! unsure, and its ray is cast. `proofs/raster_single.g` proves the error bound of single precision.

use super::edge_functions::{EdgeFunctions, ErrorBound, InvDepthPlane};
use super::triangle_bounds::TriangleBounds;
use super::{Affine, Screen, TILE_ROWS, UNSURE};
use crate::math::extremes::min3;
use std::ops::Range;

/// The number of adjacent pixels that are processed at a time.
pub const LANES: usize = 8;

type Lanes = [f32; LANES];

/// Some rows of pixels while they are rasterized.
pub struct Tile<'c> {
    screen: Screen,
    rows: Range<usize>,
    /// The distance in the lists from one row to the next, which leaves room for `LANES` pixels after a row.
    stride: usize,
    /// A lower bound on the inverse depth of the nearest primitive in each pixel, or the screen's `nothing` if the
    /// pixel shows no primitive.
    min_inv_depths: Vec<f32>,
    /// An upper bound on the inverse depth of the nearest primitive in each pixel.
    max_inv_depths: Vec<f32>,
    /// The id of the nearest primitive in each pixel.
    visible_ids: &'c mut [u32],
}

/// An affine function of the pixel that is evaluated along rows in single precision, with its error bound.
#[derive(Clone, Copy)]
struct AffineRow {
    function: Affine,
    slope: f32,
    error_bound: f32,
}

impl AffineRow {
    /// Returns the function for `extent` columns and rows of pixels from `corner` on, and for rays up to `reach` from
    /// the pixels' centres. `error_bound` is the function's bound in double precision.
    fn new(
        function: Affine,
        corner: [f64; 2],
        extent: [usize; 2],
        reach: f64,
        error_bound: ErrorBound,
    ) -> Self {
        /// The error bound of single precision, in roundings of the largest value: 3 roundings of the value, one of
        /// its sum with the error bound, and a margin (`proofs/raster_single.g`).
        const SINGLE_ROUNDINGS: f64 = 5.0;
        const SINGLE_UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
        let [x, y] = corner;
        let [columns, rows] = extent.map(|n| n as f64);
        let max_abs = function.at(x, y).abs() + function.per_x.abs() * columns + function.per_y.abs() * rows;
        let variation = function.variation(reach);
        let error_bound = error_bound.at(max_abs + variation)
            + SINGLE_ROUNDINGS * SINGLE_UNIT_ROUNDOFF * max_abs
            + variation;
        Self { function, slope: function.per_x as f32, error_bound: error_bound as f32 }
    }

    /// Returns the values at `LANES` pixels of a row, from the pixel at `x` and `y` on.
    fn from(&self, x: f64, y: f64) -> Lanes {
        let first = self.function.at(x, y) as f32;
        std::array::from_fn(|k| first + self.slope * k as f32)
    }
}

/// The coverage of some pixels by a triangle: bounds on the least of the three edge functions.
struct Coverage {
    /// A lower bound. The triangle certainly covers a pixel if this is positive.
    least: Lanes,
    /// An upper bound. The triangle certainly misses a pixel if this is negative.
    most: Lanes,
}

impl Coverage {
    const FULL: Self = Self { least: [1.0; LANES], most: [1.0; LANES] };
    const UNKNOWN: Self = Self { least: [-1.0; LANES], most: [1.0; LANES] };

    /// Returns the coverage by these edges, from the pixel at `x` and `y` on.
    #[inline(always)]
    fn new(edges: &[AffineRow; 3], x: f64, y: f64) -> Self {
        let [p, q, r] = edges.each_ref().map(|edge| edge.from(x, y));
        let [ep, eq, er] = edges.each_ref().map(|edge| edge.error_bound);
        Self {
            least: lanes(|k| min3([p[k] - ep, q[k] - eq, r[k] - er])),
            most: lanes(|k| min3([p[k] + ep, q[k] + eq, r[k] + er])),
        }
    }
}

impl<'c> Tile<'c> {
    pub fn new(screen: Screen, first_row: usize, stride: usize, visible_ids: &'c mut [u32]) -> Self {
        let rows = first_row..first_row + visible_ids.len() / stride;
        let far = vec![screen.nothing; TILE_ROWS * stride];
        Self { screen, rows, stride, min_inv_depths: far.clone(), max_inv_depths: far, visible_ids }
    }

    /// Draws a triangle into the pixels of the tile that its bounds cover, unless all of them are occluded. If it has
    /// no edge functions, the pixels become unsure.
    pub fn draw(
        &mut self,
        triangle_bounds: &TriangleBounds,
        edge_functions: impl FnOnce() -> Option<EdgeFunctions>,
    ) {
        let (columns, rows) = (triangle_bounds.columns.range(), triangle_bounds.rows.range());
        let rows = rows.start.max(self.rows.start)..rows.end.min(self.rows.end);
        if rows.clone().all(|j| self.occludes(columns.clone(), j, triangle_bounds.max_inv_depth)) {
            return;
        }
        match edge_functions() {
            Some(edge_functions) => self.rasterize(&edge_functions, columns, rows, triangle_bounds.id),
            None => self.mark_unsure(columns, rows, f32::INFINITY),
        }
    }

    /// Returns true if every pixel in these columns of row j certainly shows something nearer than `max_inv_depth`.
    fn occludes(&self, columns: Range<usize>, j: usize, max_inv_depth: f32) -> bool {
        let row = (j - self.rows.start) * self.stride;
        self.min_inv_depths[row + columns.start..row + columns.end].iter().all(|&min| min > max_inv_depth)
    }

    /// Evaluates the edge functions and the inverse depth at the pixels, and updates them.
    fn rasterize(
        &mut self,
        edge_functions: &EdgeFunctions,
        columns: Range<usize>,
        rows: Range<usize>,
        id: u32,
    ) {
        let error_bound = ErrorBound([edge_functions.edge_error_bound, 0.0, 0.0]);
        let edges = edge_functions.edges.map(|edge| self.row(edge, error_bound, &columns, &rows));
        let coverage = |x: f64, y: f64| Coverage::new(&edges, x, y);
        self.draw_part(&edge_functions.inv_depth_plane, coverage, columns, rows, id);
    }

    /// Draws a plane, which may cover any pixel.
    pub fn fill(&mut self, plane: &InvDepthPlane, id: u32) {
        self.draw_part(plane, |_, _| Coverage::FULL, 0..self.screen.width, self.rows.clone(), id);
    }

    /// Draws the part of a plane that covers pixels by `coverage`.
    #[inline(always)]
    fn draw_part(
        &mut self,
        plane: &InvDepthPlane,
        coverage: impl Fn(f64, f64) -> Coverage,
        columns: Range<usize>,
        rows: Range<usize>,
        id: u32,
    ) {
        let middle = self.screen.middle;
        let error_bound = plane.error_bound.plus(self.screen.same_place);
        let inv_depth = self.row(plane.inv_depth, error_bound, &columns, &rows);
        for j in rows {
            let y = j as f64 - middle.y;
            for i in columns.clone().step_by(LANES) {
                let x = i as f64 - middle.x;
                let lanes = inv_depth.from(x, y);
                self.update([i, j], &coverage(x, y), &lanes, inv_depth.error_bound, id);
            }
        }
    }

    /// Returns a function of the pixel with this error bound, to evaluate it in these columns and rows.
    fn row(
        &self,
        function: Affine,
        error_bound: ErrorBound,
        columns: &Range<usize>,
        rows: &Range<usize>,
    ) -> AffineRow {
        let Screen { middle, reach, .. } = self.screen;
        let corner = [columns.start as f64 - middle.x, rows.start as f64 - middle.y];
        AffineRow::new(function, corner, [columns.len() + LANES, rows.len()], reach, error_bound)
    }

    /// Marks pixels as unsure, so that their rays are cast: a primitive with at most this inverse depth may cover
    /// them. Does not mark pixels that show something certainly nearer.
    pub fn mark_unsure(&mut self, columns: Range<usize>, rows: Range<usize>, max_inv_depth: f32) {
        let rows = rows.start.max(self.rows.start)..rows.end.min(self.rows.end);
        for j in rows {
            for i in columns.clone().step_by(LANES) {
                self.update([i, j], &Coverage::UNKNOWN, &[max_inv_depth; LANES], 0.0, UNSURE);
            }
        }
    }

    /// Does the depth test of primitive `id` at the pixels from column i of row j on, with this coverage.
    ///
    /// A pixel shows the primitive if the primitive certainly covers it and is certainly the nearest so far. The pixel
    /// is unchanged if the primitive certainly misses it or is certainly farther. Otherwise it becomes unsure. The
    /// comparisons are written so that a NaN makes the pixel unsure for good.
    #[inline(always)]
    fn update(
        &mut self,
        [i, j]: [usize; 2],
        coverage: &Coverage,
        inv_depth: &Lanes,
        inv_depth_error_bound: f32,
        id: u32,
    ) {
        let first = (j - self.rows.start) * self.stride + i;
        let lists = (
            &mut self.min_inv_depths[first..],
            &mut self.max_inv_depths[first..],
            &mut self.visible_ids[first..],
        );
        let (Some(min_inv_depths), Some(max_inv_depths), Some(visible_ids)) =
            (lists.0.first_chunk_mut(), lists.1.first_chunk_mut(), lists.2.first_chunk_mut())
        else {
            return;
        };
        // Run every step over all lanes before the next, so that it compiles to a few vector instructions.
        let min = inv_depth.map(|n| n - inv_depth_error_bound);
        let max = inv_depth.map(|n| n + inv_depth_error_bound);
        let is_nearest = lanes(|k| mask(coverage.least[k] > 0.0) & mask(min[k] > max_inv_depths[k]));
        let is_hidden = lanes(|k| !mask(coverage.most[k] >= 0.0) | mask(max[k] < min_inv_depths[k]));
        let is_unsure: [u32; LANES] = lanes(|k| !(is_nearest[k] | is_hidden[k]));
        let is_farther = lanes(|k| mask(max[k] <= max_inv_depths[k]));
        *min_inv_depths = lanes(|k| select(is_nearest[k], min[k], min_inv_depths[k]));
        *max_inv_depths =
            lanes(|k| select(is_nearest[k] | is_unsure[k] & !is_farther[k], max[k], max_inv_depths[k]));
        *visible_ids = lanes(|k| {
            is_nearest[k] & id | is_unsure[k] & UNSURE | !(is_nearest[k] | is_unsure[k]) & visible_ids[k]
        });
    }
}

#[inline(always)]
fn lanes<T>(lane: impl FnMut(usize) -> T) -> [T; LANES] {
    std::array::from_fn(lane)
}

/// Returns all bits set for true, no bit set for false.
#[inline(always)]
fn mask(condition: bool) -> u32 {
    u32::from(condition).wrapping_neg()
}

#[inline(always)]
fn select(mask: u32, a: f32, b: f32) -> f32 {
    f32::from_bits(mask & a.to_bits() | !mask & b.to_bits())
}

#[cfg(test)]
mod tests;
