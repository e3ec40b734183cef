//! How tight the error bound of t is: a search for rays and triangles whose t is off by a large part of it. The
//! reference is computed in double-double arithmetic.

use super::Shear;
use crate::math::double_double::{Dd, cross, difference, dot};
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::worst_case::{Input, Rng, search};
use crate::primitive::edge_functions::{T_ROUNDINGS, edge_functions, is_interpolation_accurate};
use glam::DVec3;

/// A ray's origin and direction, and a triangle. The ray passes close to a corner, where few roundings matter, and
/// those as much as they can: the triangle is narrow along x and about as steep as may be, and the corner's coordinates
/// are just above a power of two, the slope just below one.
fn near_a_corner(rng: &mut Rng) -> Input<5> {
    let origin = 1e-3 * rng.vector();
    let (x, z) = (1.0 + 1e-3 * rng.unit(), 1.0 + 1e-3 * rng.unit());
    let direction = DVec3::new(x, 1e-4 * rng.signed(), z * (1.0 + 1e-3 * rng.unit()));
    let corners = [
        DVec3::new(x, 0.0, z),
        DVec3::new(-0.5 - 0.06 * rng.unit(), 0.1 * rng.signed(), -0.5),
        DVec3::new(-0.1 - 0.06 * rng.unit(), 1.2, -0.1),
    ];
    let [a, b, c] = corners.map(|corner| origin + corner);
    [origin, direction, a, b, c]
}

/// The error of t over its bound, where t is interpolated.
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
fn the_error_of_an_interpolated_t_needs_nearly_half_of_its_bound() {
    let (found, _) = search(8, 200_000, near_a_corner, ratio);
    println!("t is off by {found:.3} of its error bound");
    assert!((0.44..1.0).contains(&found), "{found}");
}
