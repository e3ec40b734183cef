//! Measures the tightness of the error bounds. Hill climbing searches for views and triangles whose errors come close
//! to the bounds. The reference values are computed in double-double arithmetic.

mod worst_screens;

use super::edge_functions::{EdgeFunctions, InvDepthPlane, normals_and_volume, volume_error_bound};
use super::{Footprint, Viewport};
use crate::camera::{Camera, Eye, Projection};
use crate::math::aabb::Aabb;
use crate::math::double_double::{Dd, cross, difference, dot};
use crate::math::ray::Ray;
use crate::math::worst_case::{Input, Rng, search};
use crate::scene;
use crate::scene::model::Screen;
use crate::world::plane::Plane;
use crate::world::triangle::normal;
use glam::{DVec2, DVec3};

const SIZE: [usize; 2] = [9, 7];

/// A view and a triangle in it: the camera's centre, direction and up vector, the three corners, and a vector
/// of the pixel's x and y and the decimal logarithm of the viewing angle.
type TriangleInView = Input<7>;

/// The ratio of each error to its bound, in the order of [`NAMES`].
type Ratios = [f64; 4];
const NAMES: [&str; 4] =
    ["edge function", "V", "inverse depth without V's error", "inverse depth of a plane"];
/// The index of the inverse depth.
const INV_DEPTH: usize = 2;

/// Returns the camera at a centre with a direction and an up vector, and its viewport for a triangle. Returns `None`
/// if the view is not rasterized.
fn view(
    size: [usize; 2],
    axes: [DVec3; 3],
    log_angle: f64,
    corners: [DVec3; 3],
) -> Option<(Camera, Viewport)> {
    view_on(Screen::LongerSide, size, axes, log_angle, corners)
}

/// Returns the camera and the viewport like [`view`], for a screen that is spread over the pixels as `spread` says.
fn view_on(
    spread: Screen,
    size: [usize; 2],
    [center, direction, up]: [DVec3; 3],
    log_angle: f64,
    corners: [DVec3; 3],
) -> Option<(Camera, Viewport)> {
    let angle = libm::exp10(log_angle).min(179.0);
    let camera = scene::Camera::Perspective { center, direction, up, angle };
    let camera = Camera::with_screen(&camera, size, spread);
    let Projection::Perspective(eye) = camera.projection() else { return None };
    let viewport = Viewport::new(eye, Aabb::around(corners), size, Footprint::Center, [0.0; 2])?;
    Some((camera, viewport))
}

fn random(rng: &mut Rng) -> TriangleInView {
    let [center, direction, up] = [rng.vector(), rng.vector(), rng.vector()];
    let frame = DVec3::new(rng.signed() * 4.0, rng.signed() * 3.0, -6.0 + 8.0 * rng.unit());
    let aside = direction.cross(rng.vector());
    // Half of the triangles are compact and near the middle of the picture, half are thin and cross it.
    let size = if rng.below(2) == 0 { 1.0 } else { libm::exp10(-9.0 * rng.unit()) };
    let corners = [0; 3].map(|_| center + direction + rng.signed() * aside + size * rng.vector());
    [center, direction, up, corners[0], corners[1], corners[2], frame]
}

fn ratios(&[center, direction, up, a, b, c, frame]: &TriangleInView) -> Option<Ratios> {
    let pixel = frame.truncate().round().clamp(DVec2::new(-4.0, -3.0), DVec2::new(4.0, 3.0));
    let (camera, viewport) = view(SIZE, [center, direction, up], frame.z, [a, b, c])?;
    let ray = camera.ray(pixel + DVec2::new(4.0, 3.0), DVec2::ZERO);
    let edge_functions = EdgeFunctions::new(&viewport, [a, b, c])?;
    Some(measured(&viewport, &edge_functions, &ray, pixel, [a, b, c]))
}

/// Measures the ratios for a turned eye.
fn turned_ratios(&[center, direction, up, a, b, c, frame]: &TriangleInView) -> Option<Ratios> {
    let pixel = (frame.truncate().round() + DVec2::new(4.0, 3.0)).clamp(DVec2::ZERO, DVec2::new(8.0, 6.0));
    let spread = Screen::BothSides { up_as_written: true };
    let (camera, viewport) = view_on(spread, SIZE, [center, direction, up], frame.z, [a, b, c])?;
    let edge_functions = EdgeFunctions::new(&viewport, [a, b, c])?;
    let ray = camera.ray(pixel, DVec2::ZERO);
    let from_foot = pixel - viewport.eye.middle;
    viewport.eye.is_turned.then(|| measured(&viewport, &edge_functions, &ray, from_foot, [a, b, c]))
}

/// Compares the functions with their exact values along the ray, in units of the length of the direction that
/// the rasterizer assumes.
fn measured(
    viewport: &Viewport,
    edge_functions: &EdgeFunctions,
    ray: &Ray,
    pixel: DVec2,
    corners: [DVec3; 3],
) -> Ratios {
    let Eye { center, direction, right, up, .. } = viewport.eye;
    let to_pixel = direction + pixel.x * right + pixel.y * up;
    // The ray's length does not matter. With this length, the rest of its error is at right angles to it.
    let length = to_pixel.dot(ray.direction) / ray.direction.length_squared();
    let [a, b, c] = corners.map(|corner| difference(corner, center));
    let d = ray.direction.to_array().map(Dd::from);
    let normals = [cross(b, c), cross(c, a), cross(a, b)];
    let volume = dot(a, normals[0]);
    let along = normals.map(|normal| dot(normal, d));
    let sign = Dd::from(volume.value().signum() * length * viewport.scale * viewport.scale);
    let edge_error =
        |k: usize| (along[k] * sign - edge_functions.edges[k].at(pixel.x, pixel.y).into()).value().abs();
    let edge = (0..3).map(edge_error).fold(0.0, f64::max) / edge_functions.edge_error_bound;

    let scaled = corners.map(|corner| viewport.eye_space(corner));
    let (_, rounded) = normals_and_volume(scaled);
    let unit = viewport.scale * viewport.scale * viewport.scale;
    let longest = scaled.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let volume_ratio = (volume * unit.into() - rounded.into()).value().abs() / volume_error_bound(longest);

    let InvDepthPlane { inv_depth, error_bound } = &edge_functions.inv_depth_plane;
    let [constant, ..] = error_bound.0;
    // Multiply by the computed V, whose own error is measured separately.
    let sum =
        (along[0] + along[1] + along[2]) * sign - (inv_depth.at(pixel.x, pixel.y) * rounded.abs()).into();
    let inv_depth_ratio = sum.value().abs() / (constant * rounded.abs());

    [edge, volume_ratio, inv_depth_ratio, of_plane(viewport, ray, pixel, length, corners)]
}

/// Returns the ratio for a plane's inverse depth, whose reference is the t of the ray's own test.
fn of_plane(viewport: &Viewport, ray: &Ray, pixel: DVec2, length: f64, corners: [DVec3; 3]) -> f64 {
    let normal = normal(corners);
    let plane = Plane { normal, offset: normal.dot(corners[0]) };
    let InvDepthPlane { inv_depth, error_bound } = InvDepthPlane::of_plane(viewport, &plane);
    let Some(t) = plane.intersect(ray) else { return 0.0 };
    (inv_depth.at(pixel.x, pixel.y) - length / (t * viewport.scale)).abs() / error_bound.at(0.0)
}

/// Does not cover the errors of single precision, which have a separate bound.
#[test]
fn error_bounds_hold_and_are_needed() {
    let found: Vec<f64> = (0..NAMES.len())
        .map(|kind| search(16, 60_000, random, |input| Some(ratios(input)?[kind])).0)
        .collect();
    for (name, found) in NAMES.iter().zip(&found) {
        println!("{name}: {found:.3} of the error bound");
    }
    assert!(found.iter().all(|&found| found < 1.0), "{found:?}");
    // Inverse depths have a separate search.
    let needed = [0, 1, 3].map(|kind| found[kind]);
    assert!(needed.iter().all(|&found| found > 0.5), "{found:?}");
}

/// The bounds cover the roundings that turning the eye adds.
#[test]
fn error_bounds_hold_for_turned_eyes() {
    for (kind, name) in NAMES.iter().enumerate() {
        let (found, _) = search(8, 30_000, random, |input| Some(turned_ratios(input)?[kind]));
        println!("{name} of a turned eye: {found:.3} of the error bound");
        assert!((0.05..1.0).contains(&found), "{found}");
    }
}

/// The size of a picture of one row. In a wide view, the directions of its rays are close to the eye's steps.
const WIDE: [usize; 2] = [255, 1];

/// Returns the error of the inverse depth of a triangle whose corners are the cyclic permutations of one vector, seen
/// approximately along (1, 1, 1). So the same roundings occur in all three edges and along all three axes, and the
/// search can maximize them together. The input is the vector, and a vector of the centre, the pixel and the logarithm
/// of the angle.
fn in_turn(&[v, frame]: &Input<2>) -> Option<f64> {
    let center = DVec3::splat(frame.x);
    let corners = [v, DVec3::new(v.z, v.x, v.y), DVec3::new(v.y, v.z, v.x)].map(|corner| center + corner);
    let pixel = DVec2::new((300.0 * frame.y).round().clamp(-127.0, 127.0), 0.0);
    let axes = [center, DVec3::new(1.0, -1.0, 0.0), DVec3::new(1.0, 1.0, -2.0)];
    let (camera, viewport) = view(WIDE, axes, 2.0 + frame.z, corners)?;
    let ray = camera.ray(pixel + DVec2::new(127.0, 0.0), DVec2::ZERO);
    let edge_functions = EdgeFunctions::new(&viewport, corners)?;
    Some(measured(&viewport, &edge_functions, &ray, pixel, corners)[INV_DEPTH])
}

/// Returns a vector whose products are mostly near powers of two, where roundings are largest, and a pixel close to
/// the side of a picture of about 175 degrees.
fn random_in_turn(rng: &mut Rng) -> Input<2> {
    let v = DVec3::new(0.5, 0.5, -1.0) + 1e-3 * rng.vector();
    let center = 1e-3 * rng.signed();
    let side = if rng.below(2) == 0 { 1.0 } else { -1.0 };
    [v, DVec3::new(center, side * (0.42 - 0.05 * rng.unit()), 0.24 + 0.02 * rng.unit())]
}

#[test]
fn the_error_bound_of_inverse_depths_is_needed() {
    let (found, _) = search(48, 200_000, random_in_turn, in_turn);
    println!("inverse depth: {found:.3} of the error bound");
    assert!((0.5..1.0).contains(&found), "{found}");
}
