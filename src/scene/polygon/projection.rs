//! The projection of a polygon along a coordinate axis, in which what it covers is decided. It rounds nothing.

use super::outline::{Corner, Outline};
use crate::math::exact_sum::ExactSum;
use crate::math::predicate::{area_vector, projected_area};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::scaled::Scaled;
use glam::{DVec3, Vec3Swizzles};
use std::cmp::Ordering;

/// The projection along one of the coordinate axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedAxis {
    axis: usize,
}

impl DroppedAxis {
    /// Along the axis that the polygon faces most. None if the polygon has no area.
    pub fn facing(outline: &Outline) -> Option<Self> {
        let axis = faced_by_whole(outline).or_else(|| faced_by_largest_triangle(outline))?;
        Some(Self { axis })
    }

    /// The projected point. The two coordinates are such that turns to the left, seen along the axis from its
    /// positive end, are turns to the left.
    pub fn of(self, point: DVec3) -> [f64; 2] {
        [point[(self.axis + 1) % 3], point[(self.axis + 2) % 3]]
    }

    /// The point whose second projected coordinate is this number, and whose other coordinates are those of `point`.
    pub fn with_second(self, mut point: DVec3, second: f64) -> DVec3 {
        point[(self.axis + 2) % 3] = second;
        point
    }

    /// The exact sign of the projected triangle's area: 1 if its corners turn to the left, -1 to the right, and 0 on
    /// one line.
    pub fn orientation(self, corners: [DVec3; 3]) -> i32 {
        let [[ax, ay], [bx, by], [cx, cy]] = corners.map(|corner| self.of(corner));
        let (left, right) = ((ax - cx) * (by - cy), (ay - cy) * (bx - cx));
        let (area, sum) = (left - right, left.abs() + right.abs());
        // Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", Discrete &
        // Computational Geometry 18(3), 1997, section 4.1. The bound holds without underflow.
        const BOUND: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;
        const NO_UNDERFLOW: f64 = 1e-290;
        if area.abs() > BOUND * sum && sum > NO_UNDERFLOW {
            return if area > 0.0 { 1 } else { -1 };
        }
        projected_area(DVec3::AXES[self.axis], corners).sign()
    }

    /// Whether a point of the projected line through two others lies between them, and is neither of the two.
    pub fn is_between(self, point: DVec3, ends: [DVec3; 2]) -> bool {
        let [p, [ax, ay], [bx, by]] = [point, ends[0], ends[1]].map(|point| self.of(point));
        let is_within = |a: f64, p: f64, b: f64| (a < p && p < b) || (b < p && p < a);
        is_within(ax, p[0], bx) || is_within(ay, p[1], by)
    }

    /// In which direction a projected edge goes along each of the two axes: -1, 0 or 1.
    pub fn directions(self, edge: [DVec3; 2]) -> [i32; 2] {
        let [from, to] = edge.map(|end| self.of(end));
        [0, 1].map(|axis| i32::from(from[axis] < to[axis]) - i32::from(from[axis] > to[axis]))
    }

    /// Whether two edges on one projected line have more than a point in common.
    pub fn overlap(self, one: [DVec3; 2], other: [DVec3; 2]) -> bool {
        let [[a, b], [c, d]] = [one, other].map(|edge| edge.map(|end| self.of(end)));
        let has_common = |axis: usize| {
            let (lower, upper) = (
                a[axis].min(b[axis]).max(c[axis].min(d[axis])),
                a[axis].max(b[axis]).min(c[axis].max(d[axis])),
            );
            lower < upper
        };
        has_common(0) || has_common(1)
    }

    /// The exact sign of the projected area that an outline goes around: 1 if it turns to the left on the whole.
    pub fn turn(self, corners: &[Corner]) -> i32 {
        let mut area = ExactSum::default();
        for (k, corner) in corners.iter().enumerate() {
            let [ax, ay] = self.of(corner.point);
            let [bx, by] = self.of(corners[(k + 1) % corners.len()].point);
            area.add_product([ax, by, 1.0]);
            area.add_product([-ay, bx, 1.0]);
        }
        area.value().sign()
    }
}

/// The axis along which the polygon's area vector (Newell's normal) is longest; none if rounding may be as large.
fn faced_by_whole(outline: &Outline) -> Option<usize> {
    let count = outline.in_file_order().len();
    let first = outline.at(0).point;
    let (mut area, mut size) = (DVec3::ZERO, DVec3::ZERO);
    for k in 1..count.max(2) - 1 {
        let (p, q) = (outline.at(k).point - first, outline.at(k + 1).point - first);
        let (positive, negative) = (p.yzx() * q.zxy(), p.zxy() * q.yzx());
        area += positive - negative;
        size += positive.abs() + negative.abs();
    }
    // Three roundings for each product, one for their difference, and one for each sum.
    let bound = (count + 4) as f64 * UNIT_ROUNDOFF * size.max_element();
    let area = area.abs();
    let axis = area.max_position();
    // No bound holds for numbers that overflow or underflow.
    (area[axis] > 2.0 * bound && area[axis] > f64::MIN_POSITIVE && size.is_finite()).then_some(axis)
}

/// The axis along which the largest projected triangle of the first corner and an edge is; none if they all have no
/// area. It tells also for an outline whose parts cancel, such as an eight.
fn faced_by_largest_triangle(outline: &Outline) -> Option<usize> {
    let (mut largest, mut axis) = (Scaled::ZERO, None);
    for k in 1..outline.in_file_order().len().max(2) - 1 {
        let areas = area_vector([0, k, k + 1].map(|place| outline.at(place).point));
        for (candidate, area) in areas.into_iter().enumerate() {
            if by_size(area, largest) == Ordering::Greater {
                (largest, axis) = (area, Some(candidate));
            }
        }
    }
    axis
}

fn by_size(a: Scaled, b: Scaled) -> Ordering {
    let size = |x: Scaled| (x.exponent, x.significand.abs());
    size(a).partial_cmp(&size(b)).unwrap_or(Ordering::Equal)
}
