//! Projects a polygon along a coordinate axis without rounding. The area it covers is decided there.

use crate::math::exact::{ExactSum, Scaled, area_vector, projected_area};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::{DVec3, Vec3Swizzles};

/// The projection along one of the coordinate axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DroppedAxis {
    axis: usize,
}

impl DroppedAxis {
    /// Returns the projection along the axis that the polygon faces most. `None` if the polygon has no area.
    pub fn facing(outline: &[DVec3]) -> Option<Self> {
        let axis = faced_by_whole(outline).or_else(|| faced_by_largest_triangle(outline))?;
        Some(Self { axis })
    }

    /// Projects a point. A left turn of the projection is a left turn seen from the positive end of the axis.
    pub fn of(self, point: DVec3) -> [f64; 2] {
        [point[(self.axis + 1) % 3], point[(self.axis + 2) % 3]]
    }

    /// Returns the projected corners, scaled by a power of two that brings all coordinates below 1.
    pub fn flattened(self, corners: &[DVec3]) -> Vec<[f64; 2]> {
        let points = || corners.iter().map(|&corner| self.of(corner));
        let largest = points().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let (_, exponent) = libm::frexp(largest);
        points().map(|point| point.map(|x| libm::ldexp(x, -exponent))).collect()
    }

    /// Returns the exact sign of the projected triangle's area: 1 if its corners turn left, -1 if right, and 0 if they
    /// are on one line.
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

    /// Returns the exact sign of the outline's projected area: 1 if it turns left overall.
    pub fn turn(self, outline: &[DVec3]) -> i32 {
        let mut area = ExactSum::default();
        for (&from, &to) in outline.iter().zip(outline.iter().cycle().skip(1)) {
            let ([ax, ay], [bx, by]) = (self.of(from), self.of(to));
            area.add_product([ax, by, 1.0]);
            area.add_product([-ay, bx, 1.0]);
        }
        area.value().sign()
    }
}

/// Returns the axis along which the polygon's area vector (Newell's normal) is longest. `None` if rounding may be as
/// large.
fn faced_by_whole(outline: &[DVec3]) -> Option<usize> {
    let (mut area, mut size) = (DVec3::ZERO, DVec3::ZERO);
    for edge in outline.windows(2) {
        let (p, q) = (edge[0] - outline[0], edge[1] - outline[0]);
        let (positive, negative) = (p.yzx() * q.zxy(), p.zxy() * q.yzx());
        area += positive - negative;
        size += positive.abs() + negative.abs();
    }
    // Three roundings for each product, one for their difference, and one for each sum.
    let bound = (outline.len() + 4) as f64 * UNIT_ROUNDOFF * size.max_element();
    let area = area.abs();
    let axis = area.max_position();
    // The bound does not hold for numbers that overflow or underflow.
    (area[axis] > 2.0 * bound && area[axis] > f64::MIN_POSITIVE && size.is_finite()).then_some(axis)
}

/// Returns the axis of the largest projected triangle of the first corner and an edge. `None` if all triangles have no
/// area. This also works for an outline whose parts cancel, such as a figure eight.
fn faced_by_largest_triangle(outline: &[DVec3]) -> Option<usize> {
    let (mut largest, mut axis) = (Scaled::ZERO, None);
    for edge in outline.windows(2) {
        for (candidate, area) in area_vector([outline[0], edge[0], edge[1]]).into_iter().enumerate() {
            if area.magnitude() > largest.magnitude() {
                (largest, axis) = (area, Some(candidate));
            }
        }
    }
    axis
}
