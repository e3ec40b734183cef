//! The edge functions of a triangle seen along a ray, and the bound on their rounding errors.
//!
//! This is the double-precision step of the ray-triangle test. It decides a ray if all its edge functions are larger
//! than the error bound, and leaves the others to exact arithmetic. The vertices are sheared, so that the ray is the z
//! axis, and x and y are a vertex's distances from it (Woop, Benthin and Wald, JCGT 2(1), 2013).
//! `proofs/edge_functions.g` proves the error bound.

use crate::math::extremes::{max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::simd::Number;
use crate::math::vector::Vector;

/// The side of a triangle's edges on which a ray passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sides {
    /// The ray's line certainly passes through the triangle.
    Inside,
    /// The ray's line certainly misses the triangle.
    Outside,
    /// The rounding errors are too large to tell.
    Unsure,
}

impl Sides {
    /// Classifies a ray by its edge functions for a triangle with these sheared vertices.
    #[inline(always)]
    pub(crate) fn new(edge_functions: [f64; 3], sheared: [Vector<f64>; 3]) -> Self {
        let range = EdgeRange::new(edge_functions, sheared);
        if range.outside() != 0 {
            Self::Outside
        } else if range.inside() != 0 {
            Self::Inside
        } else {
            Self::Unsure
        }
    }
}

/// The least and the greatest edge function of a triangle, and the bound on their errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeRange<N> {
    min: N,
    max: N,
    error_bound: N,
}

impl<N: Number> EdgeRange<N> {
    /// Returns the range of these edge functions, for a triangle with these sheared vertices.
    #[inline(always)]
    pub fn new([u, v, w]: [N; 3], sheared: [Vector<N>; 3]) -> Self {
        Self { min: u.min(v).min(w), max: u.max(v).max(w), error_bound: edge_error_bound(sheared) }
    }

    /// Returns the set of the lanes in which the ray's line certainly passes through the triangle.
    #[inline(always)]
    pub fn inside(self) -> u32 {
        self.error_bound.lt_mask(self.min) | self.max.lt_mask(-self.error_bound)
    }

    /// Returns the set of the lanes in which the ray's line certainly misses the triangle.
    #[inline(always)]
    pub fn outside(self) -> u32 {
        self.min.lt_mask(-self.error_bound) & self.error_bound.lt_mask(self.max)
    }
}

/// The error bound of a hit's depth times the sum of the edge functions, in units of the edge functions' error bound
/// times the depth of the farthest vertex.
const DEPTH_BOUNDS: f64 = 5.0;

/// The largest ratio of a triangle's extent to its depth. A larger triangle would lose too many digits of the depth.
const MAX_EXTENT_PER_DEPTH: f64 = (1 << 20) as f64;

/// Returns true if the computed depth tells the side of the triangle on which the ray begins, and has most of its
/// digits. `area` is the sum of the edge functions, whose signs are certain. `proofs/depth_sign.g` proves the bound.
#[inline(always)]
pub(crate) fn is_depth_certain(depth: f64, area: f64, sheared: [Vector<f64>; 3]) -> bool {
    let [a, b, c] = sheared;
    let Vector { x, y, z } = a.abs().max(b.abs()).max(c.abs());
    (depth * area).abs() > DEPTH_BOUNDS * edge_error_bound(sheared) * z
        && MAX_EXTENT_PER_DEPTH * depth.abs() > x + y + z
}

/// Maps a vertex to the sheared space of a ray. The ray's direction has these slopes along x and y per unit of z, and
/// the vertex is relative to the ray's origin.
#[inline(always)]
pub(crate) fn sheared<N: Number>(vertex: Vector<N>, [x, y]: [N; 2]) -> Vector<N> {
    Vector { x: vertex.x - x * vertex.z, y: vertex.y - y * vertex.z, z: vertex.z }
}

/// Returns the edge functions of the edges opposite to each vertex: twice the signed areas of the triangles that each
/// edge spans with the ray in the sheared plane.
#[inline(always)]
pub(crate) fn edge_functions<N: Number>([a, b, c]: [Vector<N>; 3]) -> [N; 3] {
    let cross = |p: Vector<N>, q: Vector<N>| p.x * q.y - p.y * q.x;
    [cross(b, c), cross(c, a), cross(a, b)]
}

/// Returns the error bound of the edge functions of sheared vertices, compared with the exact values for the vertices
/// and the ray as given. If an edge function exceeds the bound, its sign is right.
///
/// Let u be the unit roundoff. A sheared coordinate is x = X - s Z, where X and Z are the vertex's
/// coordinates relative to the ray's origin, and s is the ray's slope, which is at most 1. X, Z, s, the
/// product and the difference each have a relative error of u, except that the slope's error is at most u / 2
/// because it is at most 1. Since X = x + s Z, the error of x is 2 u |x| + 3.5 u |Z|. Let M be the largest
/// |x| plus the largest |y|, and Z the largest |z| of the three vertices. Then the sign can be wrong only
/// if the edge function is at most 7 u M Z + 4 u M^2, because of the vertices, plus u M^2, because of its
/// own roundings. This has no terms of second order, although the error of an edge function has some:
/// `proofs/edge_functions.g` shows why, and adds the roundings of the bound.
///
/// Products that underflow add less than 2^-1072 (1 + M) to the error. `MIN_EDGE_ERROR_BOUND` is far larger, so
/// underflow does not matter if an edge function exceeds the bound. The bound overflows to infinity long before the
/// edge functions, or anything computed from them, could overflow.
#[inline(always)]
pub(crate) fn edge_error_bound<N: Number>([a, b, c]: [Vector<N>; 3]) -> N {
    let Vector { x, y, z } = a.abs().max(b.abs()).max(c.abs());
    let across = x + y;
    let extent = across + z;
    let splat = |number: f64| x.broadcast(number);
    splat(SCALED_EDGE_ROUNDINGS) * (splat(HUGE) * extent * across) + splat(MIN_EDGE_ERROR_BOUND)
}

/// The error bound of an edge function in units of u M (M + Z). The thousandth is for the roundings of the
/// bound.
const EDGE_ROUNDINGS: f64 = 7.001;

/// A factor that makes the bound overflow before the edge functions do.
const HUGE: f64 = power_of_two(500);

/// The error bound in units of `HUGE` M (M + Z).
const SCALED_EDGE_ROUNDINGS: f64 = EDGE_ROUNDINGS * UNIT_ROUNDOFF / HUGE;

/// The least error bound, which covers underflow.
const MIN_EDGE_ERROR_BOUND: f64 = power_of_two(-300);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// The error bound of a t that is interpolated, in units of u times the distance of the farthest vertex over the
/// length of the ray's direction: see `is_interpolation_accurate`.
pub const T_ROUNDINGS: f64 = 238.0;

/// The steepest triangle whose depth is interpolated.
const MAX_INTERPOLATED_STEEPNESS: f64 = 32.0;

/// Returns true if a triangle that the ray hits is not too steep for interpolating its depth along the ray. The error
/// of t is then at most [`T_ROUNDINGS`]. `area` is the sum of the edge functions.
///
/// Let e be the triangle's extents. As a function of x and y, the depth changes by at most e_z e_y / area per unit of x
/// and e_z e_x / area per unit of y. Together these are at most `MAX_INTERPOLATED_STEEPNESS`, which is the factor of
/// the vertices' errors, and no more for the errors of the edge functions. `proofs/triangle_t.g` adds them up for
/// triangles of an area of more than 10,000 u times the squared distance of the farthest vertex. For smaller triangles
/// the area's own error makes the error of t several times as large.
#[inline(always)]
pub(crate) fn is_interpolation_accurate([a, b, c]: [Vector<f64>; 3], area: f64) -> bool {
    let extent = |p: f64, q: f64, r: f64| max3([p, q, r]) - min3([p, q, r]);
    (extent(a.x, b.x, c.x) + extent(a.y, b.y, c.y)) * extent(a.z, b.z, c.z)
        <= MAX_INTERPOLATED_STEEPNESS * area.abs()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const CORNERS: [DVec3; 3] =
        [DVec3::new(-1.0, -1.0, 3.0), DVec3::new(2.0, -1.0, 4.0), DVec3::new(0.0, 2.0, 5.0)];

    #[test]
    fn a_clear_case_needs_no_exact_arithmetic() {
        let [a, b, c] = CORNERS;
        for [a, b, c] in [[a, b, c], [a, c, b]] {
            let sides = |corners: [DVec3; 3]| {
                let sheared = corners.map(Vector::from);
                Sides::new(edge_functions(sheared), sheared)
            };
            assert_eq!(sides([a, b, c]), Sides::Inside);
            for aside in [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y] {
                let moved = [a, b, c].map(|v| v + 5.0 * aside);
                assert_eq!(sides(moved), Sides::Outside);
            }
        }
    }

    #[test]
    fn one_unsure_edge_makes_the_result_unsure() {
        let corners = CORNERS.map(Vector::from);
        let half_error_bound = 0.5 * edge_error_bound(corners);
        for k in 0..3 {
            for (sign, unclear) in [
                (1.0, half_error_bound),
                (1.0, -half_error_bound),
                (-1.0, half_error_bound),
                (-1.0, -half_error_bound),
                (1.0, 0.0),
            ] {
                let mut found = [sign; 3];
                found[k] = unclear;
                assert_eq!(Sides::new(found, corners), Sides::Unsure, "{found:?}");
            }
        }
    }

    #[test]
    fn the_error_bound_is_that_of_the_proof_at_every_scale() {
        let u = UNIT_ROUNDOFF;
        for far in [1e-20, 1.0, 1e6, 1e60] {
            for (x, y, z) in [(1.0, 2.0, 3.0), (0.0, 0.0, 1.0), (1e-17, 1e-16, 1.0), (3.0, 1.0, 0.0)] {
                let (across, extent) = (far * (x + y), far * (x + y + z));
                let expected = EDGE_ROUNDINGS * u * extent * across;
                let corners = [DVec3::new(-x, 0.0, 0.0), DVec3::new(0.0, y, 0.0), DVec3::new(0.0, 0.0, -z)];
                let found = edge_error_bound(corners.map(|v| Vector::from(far * v)));
                let least = MIN_EDGE_ERROR_BOUND;
                assert!((found - least - expected).abs() <= 1e-12 * expected, "{found} {expected}");
            }
        }
        assert!(edge_error_bound([Vector::from(DVec3::ZERO); 3]) > 0.0);
    }

    #[test]
    fn interpolation_is_accurate_up_to_a_steepness() {
        for (x, y) in [(1.0, 1.0), (1.0, 2.0), (5.0, 0.5)] {
            let steepest = MAX_INTERPOLATED_STEEPNESS * x * y / (x + y);
            for from in [DVec3::ZERO, DVec3::new(-0.3, -0.2, 40.0), DVec3::new(0.0, 0.0, -7.0)] {
                let corners = |z: f64| {
                    let aside = [DVec3::ZERO, DVec3::new(x, 0.0, -z), DVec3::new(0.0, y, 0.0)];
                    aside.map(|aside| Vector::from(from + aside))
                };
                for area in [x * y, -x * y] {
                    assert!(is_interpolation_accurate(corners(0.99 * steepest), area), "{x} {y} {from}");
                    assert!(!is_interpolation_accurate(corners(1.01 * steepest), area), "{x} {y} {from}");
                }
            }
        }
    }
}
