//! Triangles in the picture: which pixels' rays may hit them.

use super::Canvas;
use crate::math::extremes::{greatest, least};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::{DVec2, DVec3, Vec2};
use std::ops::Range;

/// The place of a point in the picture.
#[derive(Clone, Copy)]
pub struct Place {
    /// In pixels.
    at: Vec2,
    /// One over its depth in front of the eye, or one of the two below.
    nearness: f32,
}

/// Of a point so far aside of where the eye looks that its place is not known to a small part of a pixel.
const ASIDE: f32 = 0.0;
/// Of a point that surely is behind the eye.
const BEHIND: f32 = -1.0;

impl Place {
    pub fn of(point: DVec3, canvas: &Canvas) -> Self {
        const STEEP: f64 = 1024.0;
        let point = canvas.seen(point);
        let (depth, distance) = (point.dot(canvas.eye.direction), point.length());
        if STEEP * depth > distance {
            let ([right, up], nearness) = (canvas.axes, 1.0 / depth);
            let at = DVec2::new(point.dot(right), point.dot(up)) * nearness + canvas.eye.middle;
            Self { at: at.as_vec2(), nearness: nearness as f32 }
        } else {
            let is_behind = depth < -8.0 * UNIT_ROUNDOFF * distance;
            Self { at: Vec2::ZERO, nearness: if is_behind { BEHIND } else { ASIDE } }
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
    pub fn new(canvas: &Canvas, [a, b, c]: [Place; 3], number: u32) -> Option<(Self, bool)> {
        let (columns, rows) = (0..canvas.width, &canvas.rows);
        let nearness = [a.nearness, b.nearness, c.nearness];
        if least(nearness) > 0.0 {
            // Above what single precision may be off.
            let nearest = 1.000_001 * greatest(nearness);
            let (a, b, c) = (a.at, b.at, c.at);
            let columns = Span::around([a.x, b.x, c.x]).within(&columns);
            let rows = Span::around([a.y, b.y, c.y]).within(rows);
            let is_seen = !columns.is_empty() && !rows.is_empty();
            is_seen.then(|| (Self { number, columns, rows, nearest }, (b - a).perp_dot(c - a) > 0.0))
        } else if greatest(nearness) < 0.0 {
            None
        } else {
            let all = Span { first: 0, end: u16::MAX };
            let (columns, rows) = (all.within(&columns), all.within(rows));
            Some((Self { number, columns, rows, nearest: f32::INFINITY }, true))
        }
    }

    /// How many they are.
    pub fn pixels(&self) -> usize {
        self.columns.range().len() * self.rows.range().len()
    }
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
    /// The pixels whose centres lie between the places, or hardly beside them.
    #[inline(always)]
    fn around(places: [f32; 3]) -> Self {
        // What single precision may be off at the far end of the longest row.
        const BESIDE: f32 = 1.0 / 64.0;
        Self { first: first_from(least(places) - BESIDE), end: first_from(greatest(places) + BESIDE) }
    }

    fn within(self, all: &Range<usize>) -> Self {
        Self { first: self.first.max(all.start as u16), end: self.end.min(all.end as u16) }
    }

    fn is_empty(self) -> bool {
        self.first >= self.end
    }

    pub fn range(self) -> Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }
}

/// The first pixel whose centre is not before a place; the last of all where none is.
#[inline(always)]
fn first_from(place: f32) -> u16 {
    let pixel = place as u16;
    pixel.saturating_add(u16::from(f32::from(pixel) < place))
}
