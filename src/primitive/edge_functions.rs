//! The edge functions of a triangle that is seen along a ray, and how far rounding may have moved them.
//!
//! The vertices are sheared: the ray is the z axis, and x and y are a vertex' distance from it. They, and what
//! is computed of them, are double precision.

use crate::math::extremes::{max3, min3};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// Where the ray lies, seen along itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sides {
    /// It surely passes within the triangle.
    Inside,
    /// It surely passes beside the triangle.
    Outside,
    /// Rounding leaves a doubt.
    Unsure,
}

/// On which sides of a triangle's edges the ray lies that has these edge functions for these sheared vertices.
#[inline(always)]
pub fn sides(edge_functions: [f64; 3], sheared: [DVec3; 3]) -> Sides {
    let (lowest, highest) = (min3(edge_functions), max3(edge_functions));
    let error_bound = edge_error_bound(sheared);
    if lowest < -error_bound && highest > error_bound {
        Sides::Outside
    } else if lowest > error_bound || highest < -error_bound {
        Sides::Inside
    } else {
        Sides::Unsure
    }
}

/// Of the edges opposite to the vertices: twice the areas that they span with the ray in the sheared plane.
#[inline(always)]
pub fn edge_functions([a, b, c]: [DVec3; 3]) -> [f64; 3] {
    let cross = |p: DVec3, q: DVec3| p.x * q.y - p.y * q.x;
    [cross(b, c), cross(c, a), cross(a, b)]
}

/// How far rounding may have moved an edge function from that of the vertices and the ray as they are.
///
/// Let u be the unit roundoff. A vertex' place across the ray is x = X - s Z, of its distances X and Z from the
/// ray's origin and the ray's slope s, which is at most 1. X, Z, s, the product and the difference are rounded
/// by u each, the slope, as a number up to 1, by u / 2. Because X is x + s Z, x is off by 2 u |x| + 3.5 u |Z|. So
/// with M the most that |x| is, plus the most that |y| is, and Z the most that |z| is, an edge function is off by
/// 7 u M Z and 2 u M^2 to first order, and by another u M^2 of its own roundings. The second order is less than
/// 24.5 u^2 Z^2 where M is small. `proofs/edge_functions.g` adds it all up, with the roundings of the bound itself.
///
/// Products that underflow move it by less than 2^-1072 (1 + M) more. `LEAST_EDGE_BOUND` is far above that, so
/// that where the edge functions are above the bound nothing underflows that matters; and the bound overflows
/// long before they do, or what is computed of them.
#[inline(always)]
pub fn edge_error_bound([a, b, c]: [DVec3; 3]) -> f64 {
    let largest = |p: f64, q: f64, r: f64| max3([p.abs(), q.abs(), r.abs()]);
    let across = largest(a.x, b.x, c.x) + largest(a.y, b.y, c.y);
    let extent = across + largest(a.z, b.z, c.z);
    let square = HUGE * extent * (across + SHEAR_ROUNDINGS * UNIT_ROUNDOFF * extent);
    EDGE_ROUNDINGS * UNIT_ROUNDOFF / HUGE * square + LEAST_EDGE_BOUND
}

/// Roundings of M (M + Z) by which an edge function may be off.
const EDGE_ROUNDINGS: f64 = 7.0;

/// Roundings of M + Z that count as part of M, for errors of the second order. The proof needs them; a search found
/// no input that does.
const SHEAR_ROUNDINGS: f64 = 5.0;

/// 2^500.
const HUGE: f64 = power_of_two(500);

/// 2^-300.
const LEAST_EDGE_BOUND: f64 = power_of_two(-300);

const fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// Whether the weights of a triangle that is hit, with this sum, give its depth along the ray to within 320
/// roundings of M + Z, which are those of the error bound. Samples stay below 10.
///
/// Let e be the extents. As a function of x and y, the depth rises by no more than e_z e_y / area along x and
/// e_z e_x / area along y. So the errors of the vertices, 2 u M + 3.5 u Z, move it by at most G times as much, with
/// G = (e_x + e_y) e_z / area. The edge functions' own roundings, 4 u X Y each, move it by at most 6 G u M together:
/// the ray passes within, so that X <= e_x <= 2 X. G is at most 32, or 38 with what the area is off. That makes
/// 304 u M + 133 u Z, and the rest of the formula adds 15 u (M + Z). No machine has checked this derivation.
#[inline(always)]
pub fn is_well_seen([a, b, c]: [DVec3; 3], area: f64) -> bool {
    // By axis: the vectors' own selections share registers, and become four times as many steps.
    let extent = |p: f64, q: f64, r: f64| max3([p, q, r]) - min3([p, q, r]);
    (extent(a.x, b.x, c.x) + extent(a.y, b.y, c.y)) * extent(a.z, b.z, c.z) <= 32.0 * area.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [DVec3; 3] =
        [DVec3::new(-1.0, -1.0, 3.0), DVec3::new(2.0, -1.0, 4.0), DVec3::new(0.0, 2.0, 5.0)];

    #[test]
    fn a_clear_case_needs_no_more_digits() {
        let [a, b, c] = CORNERS;
        for [a, b, c] in [[a, b, c], [a, c, b]] {
            assert_eq!(sides(edge_functions([a, b, c]), [a, b, c]), Sides::Inside);
            for aside in [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y] {
                let moved = [a, b, c].map(|v| v + 5.0 * aside);
                assert_eq!(sides(edge_functions(moved), moved), Sides::Outside);
            }
        }
    }

    #[test]
    fn a_doubt_about_any_edge_is_a_doubt() {
        let half_error_bound = 0.5 * edge_error_bound(CORNERS);
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
                assert_eq!(sides(found, CORNERS), Sides::Unsure, "{found:?}");
            }
        }
    }

    #[test]
    fn the_error_bound_is_that_of_the_proof_at_every_scale() {
        let u = UNIT_ROUNDOFF;
        for far in [1e-20, 1.0, 1e6, 1e60] {
            for (x, y, z) in [(1.0, 2.0, 3.0), (0.0, 0.0, 1.0), (1e-17, 1e-16, 1.0), (3.0, 1.0, 0.0)] {
                let (across, extent) = (far * (x + y), far * (x + y + z));
                let expected = EDGE_ROUNDINGS * u * extent * (across + SHEAR_ROUNDINGS * u * extent);
                let corners = [DVec3::new(-x, 0.0, 0.0), DVec3::new(0.0, y, 0.0), DVec3::new(0.0, 0.0, -z)];
                let found = edge_error_bound(corners.map(|v| far * v));
                assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
            }
        }
        assert!(edge_error_bound([DVec3::ZERO; 3]) > 0.0);
    }

    #[test]
    fn a_triangle_is_well_seen_up_to_a_steepness() {
        for (x, y) in [(1.0, 1.0), (1.0, 2.0), (5.0, 0.5)] {
            let steepest = 32.0 * x * y / (x + y);
            for from in [DVec3::ZERO, DVec3::new(-0.3, -0.2, 40.0), DVec3::new(0.0, 0.0, -7.0)] {
                let corners = |z: f64| [from, from + DVec3::new(x, 0.0, -z), from + DVec3::new(0.0, y, 0.0)];
                for area in [x * y, -x * y] {
                    assert!(is_well_seen(corners(0.99 * steepest), area), "{x} {y} {from}");
                    assert!(!is_well_seen(corners(1.01 * steepest), area), "{x} {y} {from}");
                }
            }
        }
    }
}
