//! Measures how tight the error bounds are: hill climbing searches for views and triangles whose errors come
//! close to the bounds. The reference values are computed in double-double arithmetic.

use super::Viewport;
use super::edge_functions::{EdgeFunctions, InvDepthPlane, normals_and_volume, volume_error_bound};
use crate::camera::{Camera, Eye};
use crate::math::aabb::Aabb;
use crate::math::double_double::{Dd, cross, difference, dot};
use crate::math::ray::Ray;
use crate::primitive::plane::Plane;
use crate::primitive::triangle::{Shear, normal};
use crate::scene;
use glam::{DVec2, DVec3};

const SIZE: [usize; 2] = [9, 7];

/// A view and a triangle in it: the camera's centre, direction and up vector, the three corners, and a vector
/// of the pixel's x and y and the decimal logarithm of the viewing angle.
#[derive(Clone, Copy)]
struct Input([DVec3; 7]);

/// The ratio of each error to its bound, in the order of [`NAMES`].
type Ratios = [f64; 5];
const NAMES: [&str; 5] = [
    "edge function",
    "V",
    "inverse depth without V's error",
    "t of the ray's test",
    "inverse depth of a plane",
];

/// Splitmix64 (Steele, Lea, Flood, OOPSLA 2014).
struct Rng(u64);

impl Rng {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    /// Uniform in [-1, 1).
    fn signed(&mut self) -> f64 {
        (self.next() >> 10) as f64 / (1u64 << 53) as f64 - 1.0
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
}

impl Input {
    fn random(rng: &mut Rng) -> Self {
        let [center, direction, up] = [rng.vector(), rng.vector(), rng.vector()];
        let frame = DVec3::new(rng.signed() * 4.0, rng.signed() * 3.0, -6.0 + 8.0 * rng.signed().abs());
        let aside = direction.cross(rng.vector());
        // Half of the triangles are compact and near the middle of the picture, half are thin and cross it.
        let size = if rng.below(2) == 0 { 1.0 } else { f64::powf(10.0, -9.0 * rng.signed().abs()) };
        let corners = [0; 3].map(|_| center + direction + rng.signed() * aside + size * rng.vector());
        Self([center, direction, up, corners[0], corners[1], corners[2], frame])
    }

    /// A copy in which one coordinate, or all three of one vector, are changed by a random amount.
    fn changed(mut self, rng: &mut Rng) -> Self {
        let vector = &mut self.0[rng.below(7) as usize];
        let size = f64::powf(10.0, -17.0 * rng.signed().abs());
        match rng.below(3) {
            0 => *vector += size * rng.vector(),
            1 => vector[rng.below(3) as usize] += size * rng.signed(),
            _ => {
                let x = &mut vector[rng.below(3) as usize];
                *x = f64::from_bits((x.to_bits() as i64 + rng.below(17) as i64 - 8) as u64);
            }
        }
        self
    }

    fn ratios(&self) -> Option<Ratios> {
        let Self([center, direction, up, a, b, c, frame]) = *self;
        let angle = f64::powf(10.0, frame.z).min(170.0);
        let pixel = frame.truncate().round().clamp(DVec2::new(-4.0, -3.0), DVec2::new(4.0, 3.0));
        let camera = Camera::new(&scene::Camera::Perspective { center, direction, up, angle }, SIZE);
        let ray = camera.ray(pixel + DVec2::new(4.0, 3.0), DVec2::ZERO);
        let eye = camera.eye()?;
        let corners = [a, b, c];
        let viewport = Viewport::new(eye, Aabb::around(corners), SIZE[0], 0..SIZE[1])?;
        let edge_functions = EdgeFunctions::new(&viewport, corners)?;
        Some(measured(&viewport, &edge_functions, &ray, pixel, corners))
    }
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
    let length = (direction + pixel.x * right + pixel.y * up).length();
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

    let t = volume.value() / (along[0] + along[1] + along[2]).value();
    let InvDepthPlane { inv_depth, error_bound } = &edge_functions.inv_depth_plane;
    let exact = length / (t * viewport.scale);
    let [constant, _, square] = error_bound.0;
    // Multiplied by the computed V, whose own error is measured separately.
    let sum =
        (along[0] + along[1] + along[2]) * sign - (inv_depth.at(pixel.x, pixel.y) * rounded.abs()).into();
    let inv_depth_ratio = sum.value().abs() / (constant * rounded.abs());

    let found = Shear::new(ray).intersect(corners.each_ref());
    let t_ratio = found.map_or(0.0, |found| (found / t - 1.0).abs() / (square * exact / length));
    [edge, volume_ratio, inv_depth_ratio, t_ratio, of_plane(viewport, ray, pixel, length, corners)]
}

/// The ratio for a plane's inverse depth, whose reference is the t of the ray's own test.
fn of_plane(viewport: &Viewport, ray: &Ray, pixel: DVec2, length: f64, corners: [DVec3; 3]) -> f64 {
    let normal = normal(corners);
    let plane = Plane { normal, offset: normal.dot(corners[0]) };
    let InvDepthPlane { inv_depth, error_bound } = InvDepthPlane::of_plane(viewport, &plane);
    let Some(t) = plane.intersect(ray) else { return 0.0 };
    (inv_depth.at(pixel.x, pixel.y) - length / (t * viewport.scale)).abs() / error_bound.at(0.0)
}

/// The largest ratio at index `kind` that hill climbing from several random inputs finds.
fn searched(kind: usize, starts: u64, steps: u64) -> f64 {
    let climbed = |start| {
        let rng = &mut Rng(start);
        let mut input = Input::random(rng);
        let value = |input: &Input| input.ratios().map_or(-1.0, |ratios| ratios[kind]);
        let mut best = value(&input);
        for _ in 0..steps {
            let next = if best < 0.0 { Input::random(rng) } else { input.changed(rng) };
            let found = value(&next);
            if found >= best {
                (input, best) = (next, found);
            }
        }
        best
    };
    (0..starts).map(climbed).fold(0.0, f64::max)
}

/// The errors of single precision are not part of this: they have a bound of their own.
#[test]
fn error_bounds_hold_and_are_needed() {
    let found: Vec<f64> = (0..NAMES.len()).map(|kind| searched(kind, 16, 30_000)).collect();
    for (name, found) in NAMES.iter().zip(&found) {
        println!("{name}: {found:.3} of the error bound");
    }
    assert!(found.iter().all(|&found| found < 1.0), "{found:?}");
    // No bound could be ten times smaller, except that of t, which assumes the worst of every step at once.
    let needed = [0, 1, 2, 4].map(|kind| found[kind]);
    assert!(needed.iter().all(|&found| found > 0.1), "{found:?}");
}
