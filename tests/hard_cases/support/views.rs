//! Views with triangles that are hard to rasterize.

use super::rng::Rng;
use super::scenes::world_of_mesh;
use glam::{DMat3, DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::scene;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use raytracer::world::ellipsoid::Ellipsoid;
use raytracer::world::plane::Plane;
use raytracer::world::shape::Shape;
use raytracer::world::sphere::Sphere;

/// A view from an eye, or the middle of an orthographic camera, at any position.
pub struct View {
    pub size: [usize; 2],
    pub eye: DVec3,
    pub direction: DVec3,
    pub camera: Camera,
    /// The scale of the scene around the eye.
    pub scale: f64,
}

impl View {
    pub fn new(rng: &mut Rng) -> Self {
        let size = [8 + rng.below(40), 8 + rng.below(40)];
        let scale = f64::powi(2.0, rng.below(60) as i32 - 30);
        let eye = scale * if rng.below(2) == 0 { DVec3::ZERO } else { 1e4 * rng.in_cube() };
        // It is along an axis in a third of the cases, so that the edges of boxes go through pixel centres.
        let direction = if rng.below(3) == 0 { DVec3::NEG_Z } else { rng.direction() };
        let up = if rng.below(3) == 0 { DVec3::Y } else { rng.direction() };
        let angle = match rng.below(8) {
            0 => f64::powf(10.0, rng.range(-18.0, 0.0)),
            1 => 180.0 - f64::powf(10.0, rng.range(-14.0, 0.0)),
            _ => rng.range(1.0, 170.0),
        };
        Self::of(eye, direction, up, angle, size, scale)
    }

    pub fn of(eye: DVec3, direction: DVec3, up: DVec3, angle: f64, size: [usize; 2], scale: f64) -> Self {
        let camera = scene::Camera::Perspective { center: eye, direction, up, angle };
        Self { size, eye, direction, camera: Camera::new(&camera, size), scale }
    }

    /// Of an orthographic camera, mostly about as large as the scene around it.
    pub fn parallel(rng: &mut Rng) -> Self {
        let direction = if rng.below(3) == 0 { DVec3::NEG_Z } else { rng.direction() };
        let up = if rng.below(3) == 0 { DVec3::Y } else { rng.direction() };
        Self::parallel_along(rng, direction, up)
    }

    /// The same with this direction and this way up.
    pub fn parallel_along(rng: &mut Rng, direction: DVec3, up: DVec3) -> Self {
        let size = [8 + rng.below(40), 8 + rng.below(40)];
        let scale = f64::powi(2.0, rng.below(60) as i32 - 30);
        let farthest = [0.0, 0.0, 4.0, 9.0][rng.below(4)];
        let eye = scale * (f64::powf(10.0, rng.range(0.0, farthest)) - 1.0) * rng.in_cube();
        let exponent = if rng.below(4) == 0 { rng.range(-6.0, 6.0) } else { rng.range(-0.5, 0.5) };
        let across = scale * f64::powf(10.0, exponent);
        let camera = scene::Camera::Orthographic { center: eye, direction, up, size: across };
        Self { size, eye, direction, camera: Camera::new(&camera, size), scale }
    }

    pub fn some_pixel(&self, rng: &mut Rng) -> [usize; 2] {
        self.size.map(|n| rng.below(n))
    }

    /// Triangles with vertices at the centres of pixels, or within a pixel of these.
    pub fn small_triangles(&self, rng: &mut Rng) -> World {
        let mut mesh = Mesh::default();
        for first in (0..3 * (1 + rng.below(8) as u32)).step_by(3) {
            let pixel = DVec2::from_array(self.some_pixel(rng).map(|i| i as f64));
            let depth = rng.range(0.5, 2.0);
            for _ in 0..3 {
                let beside = DVec2::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
                let beside = if rng.below(4) == 0 { DVec2::ZERO } else { beside };
                let ray = self.camera.ray(pixel + beside, DVec2::ZERO);
                mesh.vertices.push(ray.at(self.depth_unit() * depth * rng.range(0.99, 1.01)));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        world_of_mesh(&mesh)
    }

    /// The unit of depths at which small triangles are.
    fn depth_unit(&self) -> f64 {
        let corners = [[0, 0], self.size].map(|pixel| self.ray(pixel).origin);
        let across = (corners[1] - corners[0]).length();
        if across > 0.0 { across } else { 1.0 }
    }

    pub fn pixels(&self) -> impl Iterator<Item = [usize; 2]> {
        let [width, height] = self.size;
        (0..height).flat_map(move |j| (0..width).map(move |i| [i, j]))
    }

    pub fn ray(&self, [i, j]: [usize; 2]) -> raytracer::math::ray::Ray {
        self.camera.ray(DVec2::new(i as f64, j as f64), DVec2::ZERO)
    }

    /// A point on the ray through a pixel's centre, or anywhere, also behind the eye.
    pub fn point(&self, rng: &mut Rng) -> DVec3 {
        match rng.below(8) {
            0 => self.eye + self.scale * rng.in_cube(),
            1 => self.eye + self.scale * (self.direction + 0.3 * rng.in_cube()),
            _ => {
                let pixel = self.some_pixel(rng);
                self.ray(pixel).at(self.scale * rng.range(0.1, 1.0))
            }
        }
    }

    /// Large and small triangles and needles, of which some are duplicated and some have no area.
    pub fn world(&self, rng: &mut Rng) -> World {
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
        let mut world = world_of_mesh(&mesh);
        for _ in 0..rng.below(4).saturating_sub(1) {
            let size = self.scale * f64::powf(10.0, rng.range(-4.0, 0.0));
            let center = self.point(rng);
            if rng.below(2) == 0 {
                world.shapes.push(Shape::Sphere(Sphere { center, radius: size }));
            } else {
                let axes = [rng.direction(), rng.direction(), rng.direction()].map(|axis| size * axis);
                let linear = DMat3::from_cols(axes[0], axes[1], axes[2]);
                world.shapes.push(Shape::Ellipsoid(Box::new(Ellipsoid::new(center, linear))));
            }
        }
        world.bounds = world.boxes().fold(world.bounds, |all, bounds| all.union(bounds));
        for _ in 0..rng.below(3) {
            let normal = if rng.below(2) == 0 { DVec3::Y } else { rng.direction() };
            world.planes.push(Plane { normal, offset: normal.dot(self.point(rng)) });
        }
        world
    }

    /// The triangle that the textbook's rasterizer shows in a pixel: vertices and edges are projected in
    /// single precision.
    pub fn textbook(&self, world: &World, [i, j]: [usize; 2]) -> Option<u32> {
        let [right, up] = [[1.0, 0.0], [0.0, 1.0]].map(|[x, y]| {
            let middle = 0.5 * DVec2::new(self.size[0] as f64, self.size[1] as f64) - 0.5;
            let through = |pixel: DVec2| {
                let d = self.camera.ray(pixel, DVec2::ZERO).direction;
                d / d.dot(self.direction)
            };
            through(middle + DVec2::new(x, y)) - through(middle)
        });
        let projected = |point: DVec3| {
            let p = (point - self.eye) / self.scale;
            let depth = p.dot(self.direction);
            let along = |axis: DVec3| (p.dot(axis) / (depth * axis.length_squared())) as f32;
            (along(right), along(up), (1.0 / depth) as f32)
        };
        let x = i as f32 - 0.5 * (self.size[0] as f32 - 1.0);
        let y = j as f32 - 0.5 * (self.size[1] as f32 - 1.0);
        let mut best = (0.0, None);
        for k in 0..world.triangles.len() {
            let [a, b, c] = world.corners(k).map(projected);
            let edge = |p: (f32, f32, f32), q: (f32, f32, f32)| (p.0 - x) * (q.1 - y) - (p.1 - y) * (q.0 - x);
            let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
            let inv_depth = (u * a.2 + v * b.2 + w * c.2) / (u + v + w);
            let inside = (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0);
            if inside && inv_depth > best.0 {
                best = (inv_depth, Some(k as u32));
            }
        }
        best.1
    }
}

/// Coordinates around the ray through a pixel's centre.
pub struct Frame {
    pub eye: DVec3,
    pub across: DVec3,
    pub up: DVec3,
    pub center: DVec3,
}

impl Frame {
    pub fn around_a_pixel(view: &View, rng: &mut Rng) -> Self {
        let [i, j] = view.some_pixel(rng);
        let center = view.ray([i, j]).direction;
        // In half of the cases along a row of pixels.
        let aside = if rng.below(2) == 0 { view.ray([i + 1, j]).direction } else { rng.direction() };
        let up = aside.cross(center).normalize();
        let across = center.cross(up).normalize();
        Self { eye: view.eye, across, up: center.cross(across), center }
    }

    pub fn point(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.eye + x * self.across + y * self.up + z * self.center
    }
}

pub fn triangles<const N: usize>(corners: [[DVec3; 3]; N]) -> World {
    let triangles = (0..3 * N as u32).step_by(3).map(|first| [first, first + 1, first + 2]).collect();
    world_of_mesh(&Mesh { vertices: corners.as_flattened().to_vec(), triangles })
}

/// A view whose pixels have this size at distance 1.
pub fn narrow(rng: &mut Rng, pixel: f64) -> View {
    let size = [2 + rng.below(6), 2 + rng.below(6)];
    let screen = pixel * size[0].max(size[1]) as f64;
    let angle = (2.0 * (0.5 * screen).atan()).to_degrees();
    View::of(rng.in_cube(), rng.direction(), rng.direction(), angle, size, 1.0)
}
