//! Measures the tightness of the error bounds of [`triangle_bounds`](crate::fast::raster::triangle_bounds).

use super::{SIZE, view};
use crate::fast::raster::Viewport;
use crate::fast::raster::triangle_bounds::{
    BEHIND_ROUNDINGS, MAX_STEEPNESS, SCREEN_ROUNDINGS, SIDE_ROUNDINGS, pixel_coordinates,
};
use crate::math::double_double::{Dd, difference, dot};
use crate::math::robust::UNIT_ROUNDOFF as U;
use crate::math::worst_case::{Input, Rng, search};
use glam::DVec3;
use std::f64::consts::FRAC_1_SQRT_2;

/// A view and a point of it: the camera's centre, direction and up vector, a vector of the decimal logarithm of the
/// viewing angle, and the point.
type PointInView = Input<5>;

const STARTS: u64 = 16;
const STEPS: usize = 100_000;

/// Returns a view close to this one, from close to the origin, and a point close to this one.
fn near(rng: &mut Rng, direction: DVec3, up: DVec3, angle: f64, point: DVec3) -> PointInView {
    let mut about = |v: DVec3| v + 1e-3 * rng.vector();
    [about(DVec3::ZERO), about(direction), about(up), DVec3::X * libm::log10(angle), about(point)]
}

/// Returns the viewport, and the scaled point relative to the eye, as the program computes it and exactly.
fn placed(&[center, direction, up, frame, point]: &PointInView) -> Option<(Viewport, DVec3, [Dd; 3])> {
    let (_, viewport) = view(SIZE, [center, direction, up], frame.x, [point; 3])?;
    let scale = Dd::from(viewport.scale);
    let exact = difference(point, center).map(|x| x * scale);
    let computed = viewport.eye_space(point);
    Some((viewport, computed, exact))
}

fn exact_dot(point: [Dd; 3], vector: DVec3) -> Dd {
    dot(point, vector.to_array().map(Dd::from))
}

/// Returns the ratio of an error to its bound, for a number whose sign matters, if the number is so close to zero that
/// the error may change its sign. Farther from zero, returns a negative value, so that the search comes closer.
fn near_zero(computed: f64, exact: Dd, error_bound: f64) -> f64 {
    if computed.abs() > 2.0 * error_bound {
        -computed.abs() / error_bound
    } else {
        (exact - computed.into()).value().abs() / error_bound
    }
}

/// Returns the ratio for the depth of a point beside the eye.
fn behind(input: &PointInView) -> Option<f64> {
    let (viewport, point, exact) = placed(input)?;
    let direction = viewport.eye.direction;
    let error_bound = BEHIND_ROUNDINGS * U * point.length();
    Some(near_zero(point.dot(direction), exact_dot(exact, direction), error_bound))
}

/// Returns the ratio for the signed distance of a point from a side plane close to it.
fn beyond_side(input: &PointInView) -> Option<f64> {
    let (viewport, point, exact) = placed(input)?;
    let (axis, direction) = (viewport.axes[0], viewport.eye.direction);
    let border = viewport.eye.middle.x + 1.5;
    let exact = exact_dot(exact, axis) - exact_dot(exact, direction) * border.into();
    let error_bound = SIDE_ROUNDINGS * U * (axis.length() + border) * point.length();
    Some(near_zero(point.dot(axis) - border * point.dot(direction), exact, error_bound))
}

/// Returns the ratio of the error of a screen coordinate in the picture to its bound.
fn screen(input: &PointInView) -> Option<f64> {
    let (viewport, point, exact) = placed(input)?;
    let (axis, direction) = (viewport.axes[0], viewport.eye.direction);
    let depth = point.dot(direction);
    let x = pixel_coordinates(point, 1.0 / depth, &viewport).x;
    let is_projected =
        MAX_STEEPNESS * depth > point.length() && (-0.5..viewport.screen.width as f64 - 0.5).contains(&x);
    let from_middle = Dd::difference(x, viewport.eye.middle.x);
    let error = (exact_dot(exact, axis) - exact_dot(exact, direction) * from_middle).value().abs() / depth;
    let length = viewport.max_direction_length * viewport.axes[0].length().max(viewport.axes[1].length());
    is_projected.then(|| error / (SCREEN_ROUNDINGS * MAX_STEEPNESS * U * length))
}

/// Directions at right angles. All terms of their dot products with the point are large, and most are just above a
/// power of two, where roundings are largest.
const ALONG: DVec3 = DVec3::new(0.5, 0.5, FRAC_1_SQRT_2);
const ACROSS: DVec3 = DVec3::new(0.5, 0.5, -FRAC_1_SQRT_2);
const ASIDE: DVec3 = DVec3::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0);

#[test]
fn error_bounds_hold_and_are_needed() {
    // The depth of one point is a thousandth of its distance, which is about the steepest that is projected. The other
    // point is on a side plane, which is 5.5 pixels beside the middle of 9.
    let border = libm::tan(f64::to_radians(0.5)) * 5.5 / 4.5;
    let found = [
        search(STARTS, STEPS, |rng| near(rng, ALONG, ASIDE, 60.0, ACROSS), behind).0,
        search(STARTS, STEPS, |rng| near(rng, ASIDE, ALONG, 1.0, ALONG + 0.001 * ASIDE), screen).0,
        search(STARTS, STEPS, |rng| near(rng, ALONG, ASIDE, 1.0, ALONG + border * ACROSS), beyond_side).0,
    ];
    let names = ["depth beside the eye", "screen coordinate", "distance from a side plane"];
    for (name, found) in names.iter().zip(found) {
        println!("{name}: {found:.3} of the error bound");
    }
    assert!(found.iter().all(|found| (0.5..1.0).contains(found)), "{found:?}");
}
