//! Tests how tight the error bound of t is, by a search for rays and triangles whose error of t is a large part of the
//! bound. The reference is computed in double-double arithmetic.

use super::Shear;
use crate::math::double_double::{Dd, cross, difference, dot};
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::worst_case::{Input, Rng, search};
use crate::world::edge_functions::{T_ROUNDINGS, edge_functions, is_interpolation_accurate};
use glam::DVec3;

/// Returns a ray's origin and direction, and a triangle. The ray passes close to a corner, so that the roundings of
/// this corner matter most and the others little. The triangle is narrow along x and about as steep as allowed. The
/// corner's coordinates are just above a power of two, and the slopes just below one. The depth is interpolated from
/// the corner that lies farthest away behind the origin. So the difference of their depths, the sum of the weights and
/// the product of the two are large, and all are just above a power of two. The origin is not small, so that the
/// differences of the corners from it are rounded.
fn near_a_corner(rng: &mut Rng) -> Input<5> {
    let origin = DVec3::splat(0.3) + 0.1 * rng.vector();
    let mut above_one = || 1.0 + 1e-3 * rng.unit();
    let near = DVec3::new(above_one(), above_one(), above_one());
    let direction = 1.999 * near / (near.z * above_one());
    let behind = DVec3::new(-0.93, -1.04, -1.0) - 0.01 * DVec3::new(rng.unit(), rng.signed(), 0.0);
    let aside = DVec3::new(-0.79, 1.1, -0.775) + 0.01 * rng.vector();
    let [a, b, c] = [behind, near, aside].map(|corner| origin + corner);
    [origin, direction, a, b, c]
}

/// Returns the error of t over its bound, if t is interpolated.
fn ratio(&[origin, direction, a, b, c]: &Input<5>) -> Option<f64> {
    let ray = Ray::new(origin, direction);
    let shear = Shear::new(&ray);
    let t = shear.intersect([&a, &b, &c])?;
    let sheared = [a, b, c].map(|corner| shear.apply(&corner));
    if !is_interpolation_accurate(sheared, edge_functions(sheared).iter().sum()) {
        return None;
    }
    let [p, q, r] = [a, b, c].map(|corner| difference(corner, origin));
    let d = direction.to_array().map(Dd::from);
    let [of_p, of_q, of_r] = [cross(q, r), cross(r, p), cross(p, q)];
    let along = dot(of_p, d) + dot(of_q, d) + dot(of_r, d);
    let error = (dot(p, of_p) - along * t.into()).value() / along.value();
    let longest = [a, b, c].map(|corner| (corner - origin).length()).into_iter().fold(0.0, f64::max);
    Some(error.abs() * direction.length() / (T_ROUNDINGS * UNIT_ROUNDOFF * longest))
}

#[test]
fn the_error_of_an_interpolated_t_needs_half_of_its_bound() {
    let (found, _) = search(16, 100_000, near_a_corner, ratio);
    println!("t is off by {found:.3} of its error bound");
    assert!((0.5..1.0).contains(&found), "{found}");
}
