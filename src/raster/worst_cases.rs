//! How much of the error bounds is needed: a search for views and triangles whose errors come close to
//! them. The oracle computes with twice the digits.

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

/// A view, and a triangle in it: eye, direction, up, corners, and the pixel with the angle's logarithm.
#[derive(Clone, Copy)]
struct Input([DVec3; 7]);

/// Errors over their bounds, by these names.
type Ratios = [f64; 5];
const NAMES: [&str; 5] =
    ["edge function", "V", "nearness but for V", "t of the ray's test", "nearness of a plane"];

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
        // Compact triangles around the middle, and slivers that pass it.
        let size = if rng.below(2) == 0 { 1.0 } else { f64::powf(10.0, -9.0 * rng.signed().abs()) };
        let corners = [0; 3].map(|_| center + direction + rng.signed() * aside + size * rng.vector());
        Self([center, direction, up, corners[0], corners[1], corners[2], frame])
    }

    /// With one number, or all of a vector, changed a little or a lot.
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

/// What the exact functions are at the ray, in lengths of the direction that the projection means.
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
    let inv_depth_error_bound =
        |k: usize| (along[k] * sign - edge_functions.edges[k].at(pixel.x, pixel.y).into()).value().abs();
    let edge = (0..3).map(inv_depth_error_bound).fold(0.0, f64::max) / edge_functions.edge_error_bound;

    let visible_ids = corners.map(|corner| viewport.eye_space(corner));
    let (_, rounded) = normals_and_volume(visible_ids);
    let unit = viewport.scale * viewport.scale * viewport.scale;
    let longest = visible_ids.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let off_volume = (volume * unit.into() - rounded.into()).value().abs() / volume_error_bound(longest);

    let t = volume.value() / (along[0] + along[1] + along[2]).value();
    let InvDepthPlane { inv_depth, error_bound } = &edge_functions.inv_depth_plane;
    let exact = length / (t * viewport.scale);
    let [constant, _, square] = error_bound.0;
    // Times the V that was computed, whose own error is counted for itself.
    let sum =
        (along[0] + along[1] + along[2]) * sign - (inv_depth.at(pixel.x, pixel.y) * rounded.abs()).into();
    let near = sum.value().abs() / (constant * rounded.abs());

    let found = Shear::new(ray).intersect(corners.each_ref());
    let off_t = found.map_or(0.0, |found| (found / t - 1.0).abs() / (square * exact / length));
    [edge, off_volume, near, off_t, of_plane(viewport, ray, pixel, length, corners)]
}

/// The plane's oracle is the t of the ray's own test.
fn of_plane(viewport: &Viewport, ray: &Ray, pixel: DVec2, length: f64, corners: [DVec3; 3]) -> f64 {
    let normal = normal(corners);
    let plane = Plane { normal, offset: normal.dot(corners[0]) };
    let InvDepthPlane { inv_depth, error_bound } = InvDepthPlane::of_plane(viewport, &plane);
    let Some(t) = plane.intersect(ray) else { return 0.0 };
    (inv_depth.at(pixel.x, pixel.y) - length / (t * viewport.scale)).abs() / error_bound.at(0.0)
}

/// The largest ratio of a kind that hill climbing finds, from several starts.
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

/// Beside single precision, which has a bound of its own.
#[test]
fn error_bounds_hold_and_are_needed() {
    let found: Vec<f64> = (0..NAMES.len()).map(|kind| searched(kind, 16, 30_000)).collect();
    for (name, found) in NAMES.iter().zip(&found) {
        println!("{name}: {found:.3} of the error bound");
    }
    assert!(found.iter().all(|&found| found < 1.0), "{found:?}");
    // A tenth of any would not do, but for that of t, which is for the worst of every step at once.
    let needed = [0, 1, 2, 4].map(|kind| found[kind]);
    assert!(needed.iter().all(|&found| found > 0.1), "{found:?}");
}
