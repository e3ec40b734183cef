//! Some rows of pixels while they are drawn.
//!
//! Eight pixels side by side, in single precision around the first of them, and without a branch: where
//! triangles are small, a wrong guess would cost more than a pixel.

use super::outline::{ErrorBound, Layer, Outline};
use super::sprite::Sprite;
use super::{Affine, BAND, Canvas, UNSURE};
use crate::math::extremes::{greatest, least};
use crate::world::World;
use std::ops::Range;

/// Pixels side by side.
pub const LANES: usize = 8;

type Lanes = [f32; LANES];

pub struct Band<'c> {
    canvas: &'c Canvas,
    rows: Range<usize>,
    /// From one row to the next: a row and room for some pixels beyond it.
    stride: usize,
    /// The numbers between which the nearness of what is seen lies; 0 for nothing.
    least: Vec<f32>,
    most: Vec<f32>,
    seen: &'c mut [u32],
}

/// A function of the pixel along a row, and how far it may be off.
#[derive(Clone, Copy)]
struct Ramp {
    function: Affine,
    slope: f32,
    margin: f32,
}

impl Ramp {
    /// `error_bound` is that of the function in double precision.
    fn new(function: Affine, corner: [f64; 2], extent: [usize; 2], error_bound: ErrorBound) -> Self {
        /// How far single precision may be off, in roundings of the largest value: 3 for the value, and
        /// one for the sum of it and the error bound (`proofs/projection_single.g`).
        const SINGLE_ROUNDINGS: f64 = 5.0;
        const SINGLE_UNIT_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;
        let [x, y] = corner;
        let [columns, rows] = extent.map(|n| n as f64);
        let most = function.at(x, y).abs() + function.per_x.abs() * columns + function.per_y.abs() * rows;
        let margin = error_bound.at(most) + SINGLE_ROUNDINGS * SINGLE_UNIT_ROUNDOFF * most;
        Self { function, slope: function.per_x as f32, margin: margin as f32 }
    }

    /// In the pixels from the one at x and y on.
    fn from(&self, x: f64, y: f64) -> Lanes {
        let first = self.function.at(x, y) as f32;
        std::array::from_fn(|k| first + self.slope * k as f32)
    }
}

impl<'c> Band<'c> {
    pub fn new(canvas: &'c Canvas, first_row: usize, stride: usize, seen: &'c mut [u32]) -> Self {
        let rows = first_row..first_row + seen.len() / stride;
        let far = vec![0.0; BAND * stride];
        Self { canvas, rows, stride, least: far.clone(), most: far, seen }
    }

    /// Draws a triangle where its sprite stands in these rows.
    pub fn draw(&mut self, sprite: &Sprite, world: &World) {
        let (columns, rows) = (sprite.columns.range(), sprite.rows.range());
        let rows = rows.start.max(self.rows.start)..rows.end.min(self.rows.end);
        if rows.clone().all(|j| self.hides(columns.clone(), j, sprite.nearest)) {
            return;
        }
        match Outline::new(self.canvas, world.corners(sprite.number as usize)) {
            Some(outline) => self.draw_outline(&outline, columns, rows, sprite.number),
            None => self.leave_open(columns, rows),
        }
    }

    /// Whether all that is seen in these columns of row j surely is nearer than this.
    fn hides(&self, columns: Range<usize>, j: usize, nearest: f32) -> bool {
        let row = (j - self.rows.start) * self.stride;
        self.least[row + columns.start..row + columns.end].iter().all(|&least| least > nearest)
    }

    fn draw_outline(&mut self, outline: &Outline, columns: Range<usize>, rows: Range<usize>, number: u32) {
        let middle = self.canvas.eye.middle;
        let corner = [columns.start as f64 - middle.x, rows.start as f64 - middle.y];
        let extent = [columns.len() + LANES, rows.len()];
        let of_edges = ErrorBound([outline.edge_error_bound, 0.0, 0.0]);
        let edges = outline.edges.map(|edge| Ramp::new(edge, corner, extent, of_edges));
        let nearness = Ramp::new(outline.layer.nearness, corner, extent, outline.layer.error_bound);
        let margin = greatest(edges.map(|edge| edge.margin));
        for j in rows {
            let y = j as f64 - middle.y;
            for i in columns.clone().step_by(LANES) {
                let x = i as f64 - middle.x;
                let [p, q, r] = edges.each_ref().map(|edge| edge.from(x, y));
                let lowest = lanes(|k| least([p[k], q[k], r[k]]));
                self.offer([i, j], &lowest, margin, &nearness.from(x, y), nearness.margin, number);
            }
        }
    }

    /// Fills the rows with a plane.
    pub fn fill(&mut self, plane: &Layer, number: u32) {
        let (middle, width) = (self.canvas.eye.middle, self.canvas.width);
        let corner = [-middle.x, self.rows.start as f64 - middle.y];
        let extent = [width + LANES, self.rows.len()];
        let nearness = Ramp::new(plane.nearness, corner, extent, plane.error_bound);
        for j in self.rows.clone() {
            let y = j as f64 - middle.y;
            for i in (0..width).step_by(LANES) {
                let lanes = nearness.from(i as f64 - middle.x, y);
                self.offer([i, j], &[1.0; LANES], 0.0, &lanes, nearness.margin, number);
            }
        }
    }

    /// Something unknown may stand before these pixels.
    fn leave_open(&mut self, columns: Range<usize>, rows: Range<usize>) {
        for j in rows {
            for i in columns.clone().step_by(LANES) {
                let near = [f32::INFINITY; LANES];
                self.offer([i, j], &[0.0; LANES], f32::INFINITY, &near, 0.0, UNSURE);
            }
        }
    }

    /// Enters what is seen in the pixels from column i of row j on, where `lowest` is not below zero, as near
    /// as this; both may be off by so much.
    ///
    /// What surely is there, and surely the nearest, is what is seen; where it may be, nobody knows. A
    /// comparison with a NaN is false, and leaves the pixel open for good.
    #[inline(always)]
    fn offer(
        &mut self,
        [i, j]: [usize; 2],
        lowest: &Lanes,
        margin: f32,
        nearness: &Lanes,
        off: f32,
        number: u32,
    ) {
        let first = (j - self.rows.start) * self.stride + i;
        let lists = (&mut self.least[first..], &mut self.most[first..], &mut self.seen[first..]);
        let (Some(least), Some(most), Some(seen)) =
            (lists.0.first_chunk_mut(), lists.1.first_chunk_mut(), lists.2.first_chunk_mut())
        else {
            return;
        };
        // Each as a step of its own over all lanes, which then is a few vector instructions.
        let low = nearness.map(|n| n - off);
        let high = nearness.map(|n| n + off);
        let is_nearest = lanes(|k| mask(lowest[k] > margin) & mask(low[k] > most[k]));
        let is_missed = lanes(|k| !mask(lowest[k] >= -margin) | mask(high[k] < least[k]));
        let is_unsure: [u32; LANES] = lanes(|k| !(is_nearest[k] | is_missed[k]));
        let is_farther = lanes(|k| mask(high[k] <= most[k]));
        *least = lanes(|k| chosen(is_nearest[k], low[k], least[k]));
        *most = lanes(|k| chosen(is_nearest[k] | is_unsure[k] & !is_farther[k], high[k], most[k]));
        *seen = lanes(|k| {
            is_nearest[k] & number | is_unsure[k] & UNSURE | !(is_nearest[k] | is_unsure[k]) & seen[k]
        });
    }
}

#[inline(always)]
fn lanes<T>(lane: impl FnMut(usize) -> T) -> [T; LANES] {
    std::array::from_fn(lane)
}

/// All bits where it is so, none where not.
#[inline(always)]
fn mask(is_so: bool) -> u32 {
    u32::from(is_so).wrapping_neg()
}

#[inline(always)]
fn chosen(mask: u32, a: f32, b: f32) -> f32 {
    f32::from_bits(mask & a.to_bits() | !mask & b.to_bits())
}
