//! Triangles in the picture: which pixels' rays may hit them.

use super::{Eye, Viewport};
use crate::math::extremes::{max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::World;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The place of a point in the picture.
#[derive(Clone, Copy)]
pub struct ScreenVertex {
    /// In [`SUBPIXELS`] of a pixel, cut.
    at: [i32; 2],
    /// One over its depth in front of the eye, or one of the two below.
    inv_depth: f32,
}

/// So many to a pixel. Whole numbers are compared faster than others.
const SUBPIXELS: i32 = 64;

/// Of a point so far aside of where the eye looks that its place is not known to a part of a pixel.
const ASIDE: f32 = 0.0;
/// Of a point that surely is behind the eye.
const BEHIND: f32 = -1.0;

/// Of a direction that runs farther than this for each unit ahead, no place is computed.
const STEEP: f64 = 1024.0;

/// How many roundings of a point's distance over its depth, times the length of an axis, a place is off: for
/// the axis, the products and the division.
const SCREEN_ROUNDINGS: f64 = 8.0;

/// How far a place may be off, in pixels: half of what [`Span::around`] allows; the other half is for cutting.
pub const MAX_SCREEN_ERROR: f64 = 1.0 / SUBPIXELS as f64;

/// How far the places in this view may be off, in pixels, by rounding and because the eye's vectors are not
/// quite at right angles: by much where it looks almost along the upward direction.
///
/// A place along the one axis is at most `max_direction_length` times the axis' length, or far outside the picture, and along
/// the other [`STEEP`] times. The depth changes by a cosine's part of both, and the place with it.
pub fn screen_error_bound(eye: &Eye, axes: [DVec3; 2], max_direction_length: f64) -> f64 {
    let [right, up] = [eye.right, eye.up].map(DVec3::normalize);
    let cosines = DVec3::new(right.dot(up), right.dot(eye.direction), up.dot(eye.direction));
    let skew = cosines.abs().element_sum() + SCREEN_ROUNDINGS * UNIT_ROUNDOFF;
    skew * (STEEP + max_direction_length) * max_direction_length * axes[0].length().max(axes[1].length())
}

impl ScreenVertex {
    pub fn of(point: DVec3, viewport: &Viewport) -> Self {
        let point = viewport.eye_space(point);
        let (depth, distance) = (point.dot(viewport.eye.direction), point.length());
        if STEEP * depth > distance {
            let ([right, up], inv_depth) = (viewport.axes, 1.0 / depth);
            let at = DVec2::new(point.dot(right), point.dot(up)) * inv_depth + viewport.eye.middle;
            // Far outside any place will do.
            let at = (at * f64::from(SUBPIXELS)).to_array().map(|x| x.clamp(-1e9, 1e9) as i32);
            Self { at, inv_depth: inv_depth as f32 }
        } else {
            let is_behind = depth < -8.0 * UNIT_ROUNDOFF * distance;
            Self { at: [0; 2], inv_depth: if is_behind { BEHIND } else { ASIDE } }
        }
    }
}

/// A triangle, and the pixels whose rays may hit it.
#[derive(Clone, Copy)]
pub struct TriangleBounds {
    pub id: u32,
    pub columns: Span,
    pub rows: Span,
    /// No point of it is nearer.
    pub max_inv_depth: f32,
}

impl TriangleBounds {
    /// None where it stands in no pixel's way. Says also whether the triangle seems to show its front.
    #[inline]
    pub fn new(
        viewport: &Viewport,
        world: &World,
        vertices: &[ScreenVertex],
        id: u32,
    ) -> Option<(Self, bool)> {
        let [a, b, c] = world.triangles[id as usize].map(|vertex| vertices[vertex as usize]);
        let (width, rows) = (0..viewport.width, &viewport.rows);
        let inv_depth = [a.inv_depth, b.inv_depth, c.inv_depth];
        if min3(inv_depth) > 0.0 {
            // Above what single precision may be off.
            let max_inv_depth = 1.000_001 * max3(inv_depth);
            let (columns, rows) = (Span::around([a, b, c], 0, &width), Span::around([a, b, c], 1, rows));
            let is_seen = !columns.is_empty() && !rows.is_empty();
            is_seen.then(|| (Self { id, columns, rows, max_inv_depth }, is_front([a, b, c])))
        } else if max3(inv_depth) < 0.0 || is_beyond_a_side(viewport, world.corners(id as usize)) {
            None
        } else {
            let (columns, rows) = (Span::new(&width), Span::new(rows));
            Some((Self { id, columns, rows, max_inv_depth: f32::INFINITY }, true))
        }
    }

    /// How many they are.
    pub fn pixels(&self) -> usize {
        self.columns.range().len() * self.rows.range().len()
    }
}

/// How many roundings of a point's distance, times the numbers it is multiplied by, its distance from a plane
/// through the eye is off.
const SIDE_ROUNDINGS: f64 = 6.0;

/// Whether a triangle surely lies beyond one of the planes through the eye and the picture's sides.
fn is_beyond_a_side(viewport: &Viewport, corners: [DVec3; 3]) -> bool {
    let points = corners.map(|corner| viewport.eye_space(corner));
    (0..2).any(|k| {
        let axis = viewport.axes[k];
        // A pixel and a half beyond the last centre, so that a pixel's own error does not count.
        let border = viewport.eye.middle[k] + 1.5;
        let inv_depth_error_bound = SIDE_ROUNDINGS * UNIT_ROUNDOFF * (axis.length() + border);
        let beyond = |point: DVec3, sign: f64| {
            sign * point.dot(axis)
                > border * point.dot(viewport.eye.direction) + inv_depth_error_bound * point.length()
        };
        [1.0, -1.0].into_iter().any(|sign| points.into_iter().all(|point| beyond(point, sign)))
    })
}

/// The pixels of a row or a column from the first to the one before the end.
#[derive(Clone, Copy)]
pub struct Span {
    first: u16,
    end: u16,
}

/// The most pixels that a row or a column may have.
pub const MAX_PIXELS: usize = u16::MAX as usize;

impl Span {
    fn new(pixels: &Range<usize>) -> Self {
        Self { first: pixels.start as u16, end: pixels.end as u16 }
    }

    /// The pixels among these whose centres lie between the places along an axis, or hardly beside them.
    #[inline(always)]
    fn around(vertices: [ScreenVertex; 3], axis: usize, pixels: &Range<usize>) -> Self {
        /// What the places may be off, and rounding.
        const BESIDE: i32 = 2;
        let vertices = vertices.map(|vertex| vertex.at[axis]);
        let first = (min3(vertices) - BESIDE + (SUBPIXELS - 1)) / SUBPIXELS;
        let last = (max3(vertices) + BESIDE).div_euclid(SUBPIXELS);
        let [low, high] = [pixels.start as i32, pixels.end as i32];
        Self { first: first.clamp(low, high) as u16, end: (last + 1).clamp(low, high) as u16 }
    }

    fn is_empty(self) -> bool {
        self.first >= self.end
    }

    pub fn range(self) -> Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }
}

/// Whether a triangle seems to run counter-clockwise.
fn is_front(corners: [ScreenVertex; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.at.map(i64::from));
    (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
}
