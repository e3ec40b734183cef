//! First hits by projection, beside the cases: what a pixel is said to see is what its ray hits. The
//! oracle is the ray, cast at every triangle.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::world_of;
use crate::support::rays;
use crate::support::rng::Rng;
use glam::{DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::caster::Caster;
use raytracer::primitive::plane::Plane;
use raytracer::projection::Projection;
use raytracer::scene;
use raytracer::scene::mesh::Mesh;
use raytracer::stats::Quiet;
use raytracer::world::World;

const SEED: u64 = 3020;

/// An eye somewhere, with a picture before it and triangles around.
struct View {
    size: [usize; 2],
    eye: DVec3,
    direction: DVec3,
    camera: Camera,
    /// The scene's length.
    scale: f64,
}

impl View {
    fn new(rng: &mut Rng) -> Self {
        let size = [8 + rng.below(40), 8 + rng.below(40)];
        let scale = f64::powi(2.0, rng.below(60) as i32 - 30);
        let eye = scale * if rng.below(2) == 0 { DVec3::ZERO } else { 1e4 * rng.in_cube() };
        // At times along an axis, so that the edges of boxes meet the pixels' centres.
        let direction = if rng.below(3) == 0 { DVec3::NEG_Z } else { rng.direction() };
        let up = if rng.below(3) == 0 { DVec3::Y } else { rng.direction() };
        let angle = match rng.below(8) {
            0 => f64::powf(10.0, rng.range(-18.0, 0.0)),
            1 => 180.0 - f64::powf(10.0, rng.range(-14.0, 0.0)),
            _ => rng.range(1.0, 170.0),
        };
        let camera = scene::Camera::Perspective { center: eye, direction, up, angle };
        Self { size, eye, direction, camera: Camera::new(&camera, size), scale }
    }

    fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        let [width, height] = self.size;
        (0..height).flat_map(move |j| (0..width).map(move |i| [i, j]))
    }

    fn ray(&self, [i, j]: [usize; 2]) -> raytracer::math::ray::Ray {
        self.camera.ray(DVec2::new(i as f64, j as f64), DVec2::ZERO)
    }

    /// A point on the ray through some pixel's centre, or anywhere, also behind the eye.
    fn point(&self, rng: &mut Rng) -> DVec3 {
        match rng.below(8) {
            0 => self.eye + self.scale * rng.in_cube(),
            1 => self.eye + self.scale * (self.direction + 0.3 * rng.in_cube()),
            _ => {
                let pixel = self.size.map(|n| rng.below(n));
                self.ray(pixel).at(self.scale * rng.range(0.1, 1.0))
            }
        }
    }

    /// Large and small triangles, needles, some twice, some without area.
    fn world(&self, rng: &mut Rng) -> World {
        let mut mesh = Mesh::default();
        for _ in 0..rng.below(13) {
            let a = self.point(rng);
            let [b, c] = if rng.below(3) == 0 {
                [self.point(rng), self.point(rng)]
            } else {
                let size = self.scale * f64::powf(10.0, rng.range(-6.0, 0.0));
                [a + size * rng.direction(), a + size * rng.direction()]
            };
            let c = if rng.below(20) == 0 { b } else { c };
            let first = mesh.vertices.len() as u32;
            mesh.vertices.extend([a, b, c]);
            mesh.triangles.push([first, first + 1, first + 2]);
            match rng.below(10) {
                0 => mesh.triangles.push([first, first + 1, first + 2]),
                // A neighbour across an edge.
                1..4 => {
                    mesh.vertices.push(self.point(rng));
                    mesh.triangles.push([first + 2, first + 1, first + 3]);
                }
                _ => {}
            }
        }
        let mut world = world_of(&mesh);
        for _ in 0..rng.below(3) {
            let normal = if rng.below(2) == 0 { DVec3::Y } else { rng.direction() };
            world.planes.push(Plane { normal, offset: normal.dot(self.point(rng)) });
        }
        world
    }

    /// What the textbook sees in a pixel: corners and edges in the picture, in single precision.
    fn textbook(&self, world: &World, [i, j]: [usize; 2]) -> Option<u32> {
        let [right, up] = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| {
            let middle = 0.5 * DVec2::new(self.size[0] as f64, self.size[1] as f64) - 0.5;
            let through = |place: DVec2| {
                let d = self.camera.ray(place, DVec2::ZERO).direction;
                d / d.dot(self.direction)
            };
            through(middle + DVec2::new(x, y)) - through(middle)
        });
        let place = |point: DVec3| {
            let p = (point - self.eye) / self.scale;
            let depth = p.dot(self.direction);
            let along = |axis: DVec3| (p.dot(axis) / (depth * axis.length_squared())) as f32;
            (along(right), along(up), (1.0 / depth) as f32)
        };
        let x = i as f32 - 0.5 * (self.size[0] as f32 - 1.0);
        let y = j as f32 - 0.5 * (self.size[1] as f32 - 1.0);
        let mut best = (0.0, None);
        for k in 0..world.triangles.len() {
            let [a, b, c] = world.corners(k).map(place);
            let edge = |p: (f32, f32, f32), q: (f32, f32, f32)| (p.0 - x) * (q.1 - y) - (p.1 - y) * (q.0 - x);
            let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
            let nearness = (u * a.2 + v * b.2 + w * c.2) / (u + v + w);
            let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            if inside && nearness > best.0 {
                best = (nearness, Some(k as u32));
            }
        }
        best.1
    }
}

#[test]
fn a_pixel_sees_what_its_ray_hits() {
    let pictures = rays(2_000, 200_000);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let view = View::new(rng);
        let world = view.world(rng);
        let caster = Caster::new(&world, None).unwrap();
        // Some of the rows, as a large picture is rendered.
        let first = rng.below(view.size[1]);
        let Some(projection) = Projection::new(&view.camera, &caster, view.size, first..view.size[1]) else {
            return ([0, 0, 0, 0, 1], []);
        };
        let mut counts = [0; 5];
        for pixel in view.pixels().filter(|&[_, j]| j >= first) {
            let (ray, [i, j]) = (view.ray(pixel), pixel);
            let truth = caster.closest(&ray, &mut Quiet);
            let seen = projection.hit(&world, &ray, i, j);
            let wrong = seen.is_some_and(|seen| seen.map(|hit| world.exact(&ray, hit)) != truth);
            failures
                .note(wrong, || format!("seed {SEED}, picture {index}, pixel {pixel:?}: {seen:?} {truth:?}"));
            let textbook =
                world.planes.is_empty() && { view.textbook(&world, pixel) != truth.map(|hit| hit.primitive) };
            counts[0] += u64::from(wrong);
            counts[1] += u64::from(textbook);
            counts[2] += u64::from(seen.is_none());
            counts[3] += 1;
        }
        (counts, [])
    };
    let [wrong, textbook, open, pixels, undrawn] = measure::<5, 0>(pictures, one).0;
    println!(
        "{pixels} pixels, {open} left open; {undrawn} pictures not drawn; wrong: {wrong}, textbook {textbook}"
    );
    assert_eq!(wrong, 0);
    assert!(
        textbook > 0 && open > 0 && open < pixels / 4 && undrawn < pictures / 4,
        "the test tests nothing"
    );
}
