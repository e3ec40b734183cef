//! Exact orientations of points: first rounded, then in double-double arithmetic, and then without rounding.

use crate::math::double_double::{Dd, cross, difference, dot};
use crate::math::predicate::{projected_area, volume};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::DVec3;

/// The error of a rounded determinant, in units of the product of the largest coordinates of its vectors. It is the sum
/// of six products with at most seven roundings each, or of two with four.
const ROUNDED: f64 = 64.0 * UNIT_ROUNDOFF;

/// The same in double-double arithmetic, each operation of which has an error below 2^-100.
const DOUBLED: f64 = 1.0 / (1u128 << 90) as f64;

/// Products below this are left to exact arithmetic, so that underflow matters in no other.
const SMALLEST: f64 = 1e-200;

/// The sign of a number whose error is at most this part of a magnitude; none if it is not certain.
#[inline]
fn sign(value: f64, error: f64, magnitude: f64) -> Option<i32> {
    (value.abs() > error * magnitude).then_some(if value > 0.0 { 1 } else { -1 })
}

/// On which side of a triangle's plane a point is: 1 in front, where the vertices are seen counter-clockwise, -1
/// behind, and 0 in the plane.
#[inline]
pub fn side([a, b, c]: [DVec3; 3], p: DVec3) -> i32 {
    let vectors = [b - a, c - a, p - a];
    let [u, v, w] = vectors;
    let [x, y, z] = vectors.map(|vector| vector.abs().max_element());
    let magnitude = x * y * z;
    if (x * y).min(magnitude) > SMALLEST
        && let Some(sign) = sign(u.cross(v).dot(w), ROUNDED, magnitude)
    {
        return sign;
    }
    if are_in_simple_plane([a, b, c, p]) { 0 } else { exact_side([a, b, c], p, magnitude) }
}

/// Whether points are in a plane across an axis, or on two lines along an axis, as most points are that are in a plane.
fn are_in_simple_plane([a, b, c, p]: [DVec3; 4]) -> bool {
    let same = |one: DVec3, other: DVec3| one.cmpeq(other).bitmask();
    let (all_b, all_c, all_p) = (same(a, b), same(a, c), same(a, p));
    // Two points are on one line along an axis if their other two coordinates are equal.
    let pairs = [all_b & same(c, p), all_c & same(b, p), all_p & same(b, c)];
    let triples = [all_b & all_c, all_b & all_p, all_c & all_p, same(b, c) & same(c, p)];
    all_b & all_c & all_p != 0 || pairs.iter().chain(&triples).any(|axes| axes.count_ones() >= 2)
}

#[cold]
fn exact_side([a, b, c]: [DVec3; 3], p: DVec3, magnitude: f64) -> i32 {
    let [u, v, w] = [b, c, p].map(|point| difference(point, a));
    let doubled = dot(cross(u, v), w).value();
    let decided = sign(doubled, DOUBLED, magnitude).filter(|_| magnitude > SMALLEST);
    decided.unwrap_or_else(|| -volume(p, [a, b, c]).sign())
}

/// How three points turn, seen against an axis: 1 counter-clockwise, -1 clockwise, and 0 if they are on one line.
#[inline]
pub fn turn(axis: usize, [a, b, c]: [DVec3; 3]) -> i32 {
    let (u, v) = (b - a, c - a);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let magnitude = u[i].abs().max(u[j].abs()) * v[i].abs().max(v[j].abs());
    let rounded = u[i] * v[j] - u[j] * v[i];
    match sign(rounded, ROUNDED, magnitude) {
        Some(sign) if magnitude > SMALLEST => sign,
        // Most lines of three points are along an axis.
        _ if u[i].abs() + v[i].abs() == 0.0 || u[j].abs() + v[j].abs() == 0.0 => 0,
        _ => exact_turn(axis, [a, b, c], magnitude),
    }
}

#[cold]
fn exact_turn(axis: usize, [a, b, c]: [DVec3; 3], magnitude: f64) -> i32 {
    let [u, v] = [b, c].map(|point| difference(point, a));
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let doubled: Dd = u[i] * v[j] - u[j] * v[i];
    let decided = sign(doubled.value(), DOUBLED, magnitude).filter(|_| magnitude > SMALLEST);
    decided.unwrap_or_else(|| projected_area(DVec3::AXES[axis], [a, b, c]).sign())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points whose coordinates are multiples of a third, moved by up to two units in the last place, so that many are
    /// nearly or exactly in one plane or on one line.
    fn point(k: u32) -> DVec3 {
        let digit = |shift: u32, base: u32| (k.wrapping_mul(2_654_435_761) >> shift) % base;
        let coordinate = |shift| {
            let x = f64::from(digit(shift, 3)) / 3.0 - 0.3;
            f64::from_bits(x.to_bits() + u64::from(digit(shift + 6, 3) / 2))
        };
        DVec3::new(coordinate(2), coordinate(11), coordinate(20))
    }

    #[test]
    fn orientations_are_exact() {
        let mut counts = [[0; 3]; 2];
        for k in 0..60_000 {
            let [a, b, c, p] = [0, 1, 2, 3].map(|i| point(4 * k + i));
            // Powers of two do not change the orientation.
            let scale = 2f64.powi([0, 300, -300, -345, -350, -355, -515, -525, -700][k as usize % 9]);
            let [a, b, c, p] = [a, b, c, p].map(|v| scale * v);
            let (found, turned) = (side([a, b, c], p), turn(k as usize % 3, [a, b, c]));
            assert_eq!(found, -volume(p, [a, b, c]).sign(), "{a} {b} {c} {p}");
            let axis = DVec3::AXES[k as usize % 3];
            assert_eq!(turned, projected_area(axis, [a, b, c]).sign(), "{a} {b} {c}");
            counts[0][(found + 1) as usize] += 1;
            counts[1][(turned + 1) as usize] += 1;
        }
        assert!(counts.iter().flatten().all(|&count| count > 1000), "{counts:?}");
    }

    #[test]
    fn only_points_of_one_plane_are_in_a_simple_one() {
        let (mut simple, mut flat) = (0, 0);
        for k in 0..60_000 {
            let points = [0, 1, 2, 3].map(|i| point(4 * k + i));
            let [a, b, c, p] = points;
            let is_flat = volume(p, [a, b, c]).sign() == 0;
            assert!(is_flat || !are_in_simple_plane(points), "{points:?}");
            simple += usize::from(are_in_simple_plane(points));
            flat += usize::from(is_flat);
        }
        assert!(simple > 300 && flat > 5 * simple, "{simple} of {flat}");
    }

    #[test]
    fn the_front_sees_the_vertices_counter_clockwise() {
        let [a, b, c] = [DVec3::ZERO, DVec3::X, DVec3::Y];
        assert_eq!([DVec3::Z, DVec3::ONE * 1e-9, -DVec3::Z].map(|p| side([a, b, c], p)), [1, 1, -1]);
        assert_eq!((turn(2, [a, b, c]), turn(2, [a, c, b]), turn(0, [a, b, c])), (1, -1, 0));
    }
}
