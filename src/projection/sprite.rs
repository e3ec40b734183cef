//! Triangles in the picture: which pixels' rays may hit them.

use super::{Canvas, Eye};
use crate::math::extremes::{greatest, least};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::World;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The place of a point in the picture.
#[derive(Clone, Copy)]
pub struct Place {
    /// In [`PARTS`] of a pixel, cut.
    at: [i32; 2],
    /// One over its depth in front of the eye, or one of the two below.
    nearness: f32,
}

/// So many to a pixel. Whole numbers are compared faster than others.
const PARTS: i32 = 64;

/// Of a point so far aside of where the eye looks that its place is not known to a part of a pixel.
const ASIDE: f32 = 0.0;
/// Of a point that surely is behind the eye.
const BEHIND: f32 = -1.0;

/// Of a direction that runs farther than this for each unit ahead, no place is computed.
const STEEP: f64 = 1024.0;

/// How many roundings of a point's distance over its depth, times the length of an axis, a place is off: for
/// the axis, the products and the division.
const PLACE_ROUNDINGS: f64 = 8.0;

/// How far a place may be off, in pixels: half of what [`Span::around`] allows; the other half is for cutting.
pub const MOST_OFF: f64 = 1.0 / PARTS as f64;

/// How far the places in this view may be off, in pixels, by rounding and because the eye's vectors are not
/// quite at right angles: by much where it looks almost along the upward direction.
///
/// A place along the one axis is at most `reach` times the axis' length, or far outside the picture, and along
/// the other [`STEEP`] times. The depth changes by a cosine's part of both, and the place with it.
pub fn place_error_bound(eye: &Eye, axes: [DVec3; 2], reach: f64) -> f64 {
    let [right, up] = [eye.right, eye.up].map(DVec3::normalize);
    let cosines = DVec3::new(right.dot(up), right.dot(eye.direction), up.dot(eye.direction));
    let skew = cosines.abs().element_sum() + PLACE_ROUNDINGS * UNIT_ROUNDOFF;
    skew * (STEEP + reach) * reach * axes[0].length().max(axes[1].length())
}

impl Place {
    pub fn of(point: DVec3, canvas: &Canvas) -> Self {
        let point = canvas.seen(point);
        let (depth, distance) = (point.dot(canvas.eye.direction), point.length());
        if STEEP * depth > distance {
            let ([right, up], nearness) = (canvas.axes, 1.0 / depth);
            let at = DVec2::new(point.dot(right), point.dot(up)) * nearness + canvas.eye.middle;
            // Far outside any place will do.
            let at = (at * f64::from(PARTS)).to_array().map(|x| x.clamp(-1e9, 1e9) as i32);
            Self { at, nearness: nearness as f32 }
        } else {
            let is_behind = depth < -8.0 * UNIT_ROUNDOFF * distance;
            Self { at: [0; 2], nearness: if is_behind { BEHIND } else { ASIDE } }
        }
    }
}

/// A triangle, and the pixels whose rays may hit it.
#[derive(Clone, Copy)]
pub struct Sprite {
    pub number: u32,
    pub columns: Span,
    pub rows: Span,
    /// No point of it is nearer.
    pub nearest: f32,
}

impl Sprite {
    /// None where it stands in no pixel's way. Says also whether the triangle seems to show its front.
    #[inline]
    pub fn new(canvas: &Canvas, world: &World, places: &[Place], number: u32) -> Option<(Self, bool)> {
        let [a, b, c] = world.triangles[number as usize].map(|vertex| places[vertex as usize]);
        let (width, rows) = (0..canvas.width, &canvas.rows);
        let nearness = [a.nearness, b.nearness, c.nearness];
        if least(nearness) > 0.0 {
            // Above what single precision may be off.
            let nearest = 1.000_001 * greatest(nearness);
            let (columns, rows) = (Span::around([a, b, c], 0, &width), Span::around([a, b, c], 1, rows));
            let is_seen = !columns.is_empty() && !rows.is_empty();
            is_seen.then(|| (Self { number, columns, rows, nearest }, is_front([a, b, c])))
        } else if greatest(nearness) < 0.0 || is_beyond_a_side(canvas, world.corners(number as usize)) {
            None
        } else {
            let (columns, rows) = (Span::new(&width), Span::new(rows));
            Some((Self { number, columns, rows, nearest: f32::INFINITY }, true))
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
fn is_beyond_a_side(canvas: &Canvas, corners: [DVec3; 3]) -> bool {
    let points = corners.map(|corner| canvas.seen(corner));
    (0..2).any(|k| {
        let axis = canvas.axes[k];
        // A pixel and a half beyond the last centre, so that a pixel's own error does not count.
        let border = canvas.eye.middle[k] + 1.5;
        let off = SIDE_ROUNDINGS * UNIT_ROUNDOFF * (axis.length() + border);
        let beyond = |point: DVec3, sign: f64| {
            sign * point.dot(axis) > border * point.dot(canvas.eye.direction) + off * point.length()
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
pub const MOST: usize = u16::MAX as usize;

impl Span {
    fn new(pixels: &Range<usize>) -> Self {
        Self { first: pixels.start as u16, end: pixels.end as u16 }
    }

    /// The pixels among these whose centres lie between the places along an axis, or hardly beside them.
    #[inline(always)]
    fn around(places: [Place; 3], axis: usize, pixels: &Range<usize>) -> Self {
        /// What the places may be off, and rounding.
        const BESIDE: i32 = 2;
        let places = places.map(|place| place.at[axis]);
        let first = (least(places) - BESIDE + (PARTS - 1)) / PARTS;
        let last = (greatest(places) + BESIDE).div_euclid(PARTS);
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
fn is_front(corners: [Place; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.at.map(i64::from));
    (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
}
