//! First hits by projection, beside the cases: what a pixel is said to see is what its ray hits. The
//! oracle is the ray, cast at every triangle.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::world_of;
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::color_request;
use glam::{DVec2, DVec3};
use raytracer::camera::Camera;
use raytracer::caster::Caster;
use raytracer::primitive::plane::Plane;
use raytracer::projection::Projection;
use raytracer::render::{Pictures, Request, render};
use raytracer::scene;
use raytracer::scene::mesh::Mesh;
use raytracer::stats::{Counts, Quiet};
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
        Self::of(eye, direction, up, angle, size, scale)
    }

    fn of(eye: DVec3, direction: DVec3, up: DVec3, angle: f64, size: [usize; 2], scale: f64) -> Self {
        let camera = scene::Camera::Perspective { center: eye, direction, up, angle };
        Self { size, eye, direction, camera: Camera::new(&camera, size), scale }
    }

    fn some_pixel(&self, rng: &mut Rng) -> [usize; 2] {
        self.size.map(|n| rng.below(n))
    }

    /// Triangles whose corners are at, or within a pixel of, the centres of pixels.
    fn small_triangles(&self, rng: &mut Rng) -> World {
        let mut mesh = Mesh::default();
        for first in (0..3 * (1 + rng.below(8) as u32)).step_by(3) {
            let pixel = DVec2::from_array(self.some_pixel(rng).map(|i| i as f64));
            let depth = rng.range(0.5, 2.0);
            for _ in 0..3 {
                let beside = DVec2::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
                let beside = if rng.below(4) == 0 { DVec2::ZERO } else { beside };
                let ray = self.camera.ray(pixel + beside, DVec2::ZERO);
                mesh.vertices.push(ray.at(depth * rng.range(0.99, 1.01)));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
        }
        world_of(&mesh)
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
                let pixel = self.some_pixel(rng);
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

/// Whether the projection says in any pixel something else than its ray; a view that is not drawn is no
/// failure. Gives the pixels that are wrong, open and all.
fn compare(view: &View, world: &World, failures: &Failures, index: u64) -> [u64; 3] {
    let caster = Caster::new(world, None).unwrap();
    let all = 0..view.size[1];
    let Some(projection) = Projection::new(&view.camera, &caster, view.size, all) else { return [0; 3] };
    let mut counts = [0; 3];
    for pixel in view.pixels() {
        let (ray, [i, j]) = (view.ray(pixel), pixel);
        let truth = caster.closest(&ray, &mut Quiet);
        let seen = projection.hit(world, &ray, i, j);
        let wrong = seen.is_some_and(|seen| seen.map(|hit| world.exact(&ray, hit)) != truth);
        failures.note(wrong, || format!("picture {index}, pixel {pixel:?}: {seen:?} {truth:?}"));
        let one = [wrong, seen.is_none(), true].map(u64::from);
        counts = std::array::from_fn(|k| counts[k] + one[k]);
    }
    counts
}

/// Runs pictures that are made to be misjudged, and demands that none is.
fn demand(seed: u64, pictures: u64, picture: impl Fn(&mut Rng) -> (View, World) + Sync) {
    let failures = Failures::default();
    let one = |index| {
        let (view, world) = picture(&mut Rng::at(seed, index));
        (compare(&view, &world, &failures, index), [])
    };
    let [wrong, open, pixels] = measure::<3, 0>(pictures, one).0;
    println!("seed {seed}: {pixels} pixels, {open} left open, {wrong} wrong");
    assert_eq!(wrong, 0);
    assert!(pixels > pictures && open < pixels, "the test tests nothing");
}

/// Coordinates around the ray through a pixel's centre.
struct Frame {
    eye: DVec3,
    across: DVec3,
    up: DVec3,
    center: DVec3,
}

impl Frame {
    fn around_a_pixel(view: &View, rng: &mut Rng) -> Self {
        let [i, j] = view.some_pixel(rng);
        let center = view.ray([i, j]).direction;
        // In half of the cases along a row of pixels.
        let aside = if rng.below(2) == 0 { view.ray([i + 1, j]).direction } else { rng.direction() };
        let up = aside.cross(center).normalize();
        let across = center.cross(up).normalize();
        Self { eye: view.eye, across, up: center.cross(across), center }
    }

    fn point(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.eye + x * self.across + y * self.up + z * self.center
    }
}

fn triangles<const N: usize>(corners: [[DVec3; 3]; N]) -> World {
    let triangles = (0..3 * N as u32).step_by(3).map(|first| [first, first + 1, first + 2]).collect();
    world_of(&Mesh { vertices: corners.as_flattened().to_vec(), triangles })
}

/// A view whose pixels are so large, in the distance 1.
fn narrow(rng: &mut Rng, pixel: f64) -> View {
    let size = [2 + rng.below(6), 2 + rng.below(6)];
    let screen = pixel * size[0].max(size[1]) as f64;
    let angle = (2.0 * (0.5 * screen).atan()).to_degrees();
    View::of(rng.in_cube(), rng.direction(), rng.direction(), angle, size, 1.0)
}

/// Long slivers in a narrow view, one of whose edges passes a pixel's centre within some roundings: edge
/// functions of large terms that cancel, beside which single precision counts for little.
#[test]
fn long_edges_through_the_centres_of_pixels() {
    demand(3021, rays(60_000, 6_000_000), |rng| {
        let view = narrow(rng, 1e-10);
        let frame = Frame::around_a_pixel(&view, rng);
        let width = f64::powf(10.0, rng.range(-11.0, -9.5)) * [1.0, -1.0][rng.below(2)];
        let nudge = |rng: &mut Rng| rng.range(-2.0, 2.0) * f64::EPSILON;
        let left = frame.point(-rng.range(0.1, 1.0), nudge(rng), rng.range(0.1, 1.0));
        let right = frame.point(rng.range(0.1, 1.0), nudge(rng), rng.range(0.1, 1.0));
        let beside = frame.point(rng.range(-0.5, 0.5), width, rng.range(0.1, 1.0));
        (view, triangles([[left, right, beside]]))
    });
}

/// Edges that pass near pixels' centres within the errors of single precision.
#[test]
fn short_edges_through_the_centres_of_pixels() {
    demand(3025, rays(60_000, 6_000_000), |rng| {
        let view = narrow(rng, 1e-3);
        let frame = Frame::around_a_pixel(&view, rng);
        let [a, b] = [-1.0, 1.0].map(|side| {
            let z = rng.range(0.9, 1.1);
            frame.point(z * side * rng.range(1e-3, 1e-2), z * rng.range(-1e-9, 1e-9), z)
        });
        let c = frame.point(rng.range(-3e-3, 3e-3), rng.range(1e-3, 6e-3), rng.range(0.9, 1.1));
        (view, triangles([[a, b, c]]))
    });
}

/// Long slivers right before or behind a plane: V is small, and so their depths are badly known.
#[test]
fn slivers_at_almost_the_depth_of_a_plane() {
    demand(3022, rays(60_000, 6_000_000), |rng| {
        let view = narrow(rng, 1e-10);
        let frame = Frame::around_a_pixel(&view, rng);
        let width = f64::powf(10.0, rng.range(-12.0, -11.0));
        let ahead = rng.range(-2.0, 2.0) * f64::powf(10.0, rng.range(-16.0, -14.0)) / width;
        let (depth, slope) = (rng.range(0.3, 0.6), rng.range(-0.5, 0.5));
        let sliver = [(-1.0, -1.0), (1.0, -1.0), (rng.range(-0.5, 0.5), 1.0)].map(|(x, y)| {
            let (x, y) = (x * rng.range(0.3, 0.6), y * width * rng.range(0.5, 1.0));
            frame.point(x, y, depth + slope * x)
        });
        let mut world = triangles([sliver]);
        let offset = frame.center.dot(frame.point(0.0, 0.0, depth * (1.0 + ahead)));
        world.planes.push(Plane { normal: frame.center, offset });
        (view, world)
    });
}

/// Large triangles that the eye all but touches, so that rounding may put it on the wrong side of them.
#[test]
fn eyes_almost_in_a_triangle() {
    demand(3028, rays(30_000, 3_000_000), |rng| {
        let pixel = f64::powf(10.0, rng.range(-3.0, 0.0));
        let view = narrow(rng, pixel);
        let frame = Frame::around_a_pixel(&view, rng);
        let away = f64::powf(10.0, rng.range(-17.0, -12.0));
        let slope = DVec2::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0));
        let corners = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, y)| {
            let (x, y) = (x * rng.range(0.3, 1.0), y * rng.range(0.3, 1.0));
            frame.point(x, y, away + slope.dot(DVec2::new(x, y)))
        });
        (view, triangles([corners]))
    });
}

/// Planes whose horizon passes a pixel's centre within some roundings.
#[test]
fn horizons_through_the_centres_of_pixels() {
    demand(3026, rays(60_000, 6_000_000), |rng| {
        let view = narrow(rng, 1e-10);
        let frame = Frame::around_a_pixel(&view, rng);
        let normal = (frame.up + 4.0 * f64::EPSILON * rng.in_cube()).normalize();
        let below = rng.range(0.1, 1.0) * [1.0, -1.0][rng.below(2)];
        let mut world = triangles([]);
        world.planes.push(Plane { normal, offset: normal.dot(view.eye) - below });
        (view, world)
    });
}

/// Triangles that face the eye, the later in the list a little nearer than what hides most of it.
#[test]
fn triangles_that_are_almost_hidden() {
    demand(3027, rays(10_000, 1_000_000), |rng| {
        let view = narrow(rng, 0.1);
        let frame = Frame::around_a_pixel(&view, rng);
        let nearer = 1.0 - f64::powf(10.0, rng.range(-8.0, -3.0));
        let facing = |size: f64, depth: f64| {
            [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)].map(|(x, y)| frame.point(size * x, size * y, depth))
        };
        let world = triangles([facing(3.0, 1.0), facing(0.5, nearer)]);
        (view, world)
    });
}

/// Small triangles in views whose up is almost the direction itself, so that right angles are none.
#[test]
fn views_almost_along_their_up() {
    demand(3023, rays(3_000, 300_000), |rng| {
        let direction = rng.direction();
        let up = direction + f64::powf(10.0, rng.range(-16.0, -6.0)) * rng.direction();
        let size = [8 + rng.below(40), 8 + rng.below(40)];
        let small = f64::powf(10.0, rng.range(-5.0, 2.0));
        let angle = if rng.below(2) == 0 { small } else { 180.0 - small };
        let view = View::of(rng.in_cube(), direction, up, angle, size, 1.0);
        let world = view.small_triangles(rng);
        (view, world)
    });
}

/// Triangles of a pixel's size, some of whose corners coincide with pixels' centres.
#[test]
fn triangles_as_small_as_pixels() {
    demand(3024, rays(3_000, 300_000), |rng| {
        let pixel = f64::powf(10.0, rng.range(-9.0, -1.0));
        let view = narrow(rng, pixel);
        let world = view.small_triangles(rng);
        (view, world)
    });
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

/// The t of a projected triangle is left open, as a NaN; pictures of depths have to find it out.
#[test]
fn depths_and_normals_are_those_of_the_rays() {
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(3029, index);
        let view = View::new(rng);
        let world = if rng.below(2) == 0 { view.world(rng) } else { view.small_triangles(rng) };
        let caster = Caster::new(&world, None).unwrap();
        let depth = Some([0.1, 2.0].map(|t| t * view.scale));
        let request = Request { color: false, depth, normals: true, ..color_request(view.size) };
        // A probe that counts has every ray cast.
        let projected = render::<Quiet>(&view.camera, &caster, &request).expect("a picture").0;
        let cast = render::<Counts>(&view.camera, &caster, &request).expect("a picture").0;
        let bytes = |pictures: &Pictures| {
            [&pictures.depth, &pictures.normals].map(|p| p.as_ref().map(|p| p.pixels().to_vec()))
        };
        let wrong = projected.nans > 0 || bytes(&projected) != bytes(&cast);
        let wrong = failures.note(wrong, || format!("picture {index}: {} not numbers", projected.nans));
        let shown = cast.depth.is_some_and(|picture| picture.pixels().iter().any(|&byte| byte > 0));
        ([wrong, u64::from(shown)], [])
    };
    let pictures = rays(2_000, 200_000);
    let [wrong, shown] = measure::<2, 0>(pictures, one).0;
    assert_eq!(wrong, 0);
    assert!(shown > pictures / 4, "the test tests nothing: {shown}");
}
