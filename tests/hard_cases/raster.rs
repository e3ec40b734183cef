//! Visibility by rasterization, in addition to the cases: the primitive that a pixel shows is the one that
//! its ray hits. The reference is the ray, tested against every triangle.

use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::layers_and_nans;
use crate::support::views::{Frame, View, narrow, triangles};
use glam::DVec2;
use raytracer::caster::Caster;
use raytracer::fast::{Footprint, VisibilityBuffer};
use raytracer::math::ray::{Hit, Ray};
use raytracer::render::{Layer, Request, Tracing};
use raytracer::trace::FirstHit;
use raytracer::world::World;
use raytracer::world::plane::Plane;

const SEED: u64 = 3020;

/// Whether the buffer is sure of something other than the truth.
fn is_wrong(world: &World, ray: &Ray, seen: FirstHit, truth: Option<Hit>) -> bool {
    match seen {
        FirstHit::Nothing => truth.is_some(),
        FirstHit::Primitive(visible) => Some(world.hit(ray, visible)) != truth,
        FirstHit::Unknown => false,
    }
}

/// Compares every pixel of the visibility buffer with its rays; a view that is not rasterized passes. Returns
/// the numbers of wrong, unsure and all rays.
pub fn compare(
    view: &View,
    world: &World,
    footprint: Footprint,
    rng: &mut Rng,
    failures: &Failures,
) -> [u64; 3] {
    let caster = Caster::new(world, None).unwrap();
    let all = 0..view.size[1];
    let Some(buffer) = VisibilityBuffer::new(&view.camera, &caster, view.size, all, footprint) else {
        return [0; 3];
    };
    let mut counts = [0; 3];
    for [i, j] in view.pixels() {
        for offset in offsets(footprint, rng) {
            let ray = view.camera.ray(DVec2::new(i as f64, j as f64), offset);
            let truth = caster.closest(&ray);
            let seen = buffer.first_hit(world, &ray, [i, j]);
            let wrong = is_wrong(world, &ray, seen, truth);
            failures.note(wrong, || format!("{rng:?}, pixel {i} {j} {offset}: {seen:?} {truth:?}"));
            let one = [wrong, seen == FirstHit::Unknown, true].map(u64::from);
            counts = std::array::from_fn(|k| counts[k] + one[k]);
        }
    }
    counts
}

/// Offsets of rays that a pixel stands for, among them the corners of whole pixels.
fn offsets(footprint: Footprint, rng: &mut Rng) -> Vec<DVec2> {
    let half = [-0.5, 0.5];
    match footprint {
        Footprint::Center => vec![DVec2::ZERO],
        Footprint::Pixel => vec![
            DVec2::new(half[rng.below(2)], half[rng.below(2)]),
            DVec2::new(half[rng.below(2)], rng.range(-0.5, 0.5)),
            DVec2::new(rng.range(-0.5, 0.5), rng.range(-0.5, 0.5)),
        ],
    }
}

/// Runs pictures that are designed to cause errors, and asserts that none has one.
fn demand(seed: u64, pictures: u64, picture: impl Fn(&mut Rng) -> (View, World) + Sync) {
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(seed, index);
        let (view, world) = picture(rng);
        (compare(&view, &world, Footprint::Center, rng, &failures), [])
    };
    let [wrong, unsure, pixels] = measure::<3, 0>(pictures, one).0;
    println!("seed {seed}: {pixels} pixels, {unsure} unsure, {wrong} wrong");
    assert_eq!(wrong, 0);
    assert!(pixels > pictures && unsure < pixels, "the test tests nothing");
}

/// Long thin triangles in a narrow view, with an edge that passes a pixel's centre at a distance of a few
/// roundings. The edge functions are small differences of large terms, whose error is much larger than that
/// of single precision.
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

/// Edges that pass close to pixel centres, within the errors of single precision.
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

/// Long thin triangles just in front of or behind a plane. V is small, and so their depths are inaccurate.
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

/// Large triangles so close to the eye that rounding may put it on the wrong side of them.
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

/// Planes whose horizon passes a pixel's centre at a distance of a few roundings.
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

/// Triangles that face the eye, each a little nearer than the ones before it, which hide most of it.
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

/// Small triangles in views whose up vector is almost parallel to the direction, so that the axes are not
/// quite orthogonal.
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

/// Triangles of about a pixel's size, some of whose corners coincide with pixel centres.
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
        // Only some of the rows, as when a large picture is rendered.
        let first = rng.below(view.size[1]);
        let rows = first..view.size[1];
        let Some(buffer) = VisibilityBuffer::new(&view.camera, &caster, view.size, rows, Footprint::Center)
        else {
            return ([0, 0, 0, 0, 1], []);
        };
        let mut counts = [0; 5];
        for pixel in view.pixels().filter(|&[_, j]| j >= first) {
            let (ray, [i, j]) = (view.ray(pixel), pixel);
            let truth = caster.closest(&ray);
            let seen = buffer.first_hit(&world, &ray, [i, j]);
            let wrong = is_wrong(&world, &ray, seen, truth);
            failures
                .note(wrong, || format!("seed {SEED}, picture {index}, pixel {pixel:?}: {seen:?} {truth:?}"));
            let textbook =
                world.planes.is_empty() && { view.textbook(&world, pixel) != truth.map(|hit| hit.primitive) };
            counts[0] += u64::from(wrong);
            counts[1] += u64::from(textbook);
            counts[2] += u64::from(seen == FirstHit::Unknown);
            counts[3] += 1;
        }
        (counts, [])
    };
    let [wrong, textbook, unsure, pixels, undrawn] = measure::<5, 0>(pictures, one).0;
    println!(
        "{pixels} pixels, {unsure} unsure; {undrawn} pictures not drawn; wrong: {wrong}, textbook {textbook}"
    );
    assert_eq!(wrong, 0);
    assert!(
        textbook > 0 && unsure > 0 && unsure < pixels / 4 && undrawn < pictures / 4,
        "the test tests nothing"
    );
}

/// The visibility buffer leaves the t of a triangle open, so that pictures of depths have to compute it.
#[test]
fn depths_and_normals_are_those_of_the_rays() {
    demand_layers(3029, View::new, [0.1, 2.0]);
}

/// Demands the same bytes of depths, in this range, and of normals from rasterization as from rays.
pub fn demand_layers(seed: u64, view: impl Fn(&mut Rng) -> View + Sync, depths: [f64; 2]) {
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(seed, index);
        let view = view(rng);
        let world = if rng.below(2) == 0 { view.world(rng) } else { view.small_triangles(rng) };
        let caster = Caster::new(&world, None).unwrap();
        let [near, far] = depths.map(|t| t * view.scale);
        let layers = vec![Layer::Depth { near, far }, Layer::Normals];
        let request = Request { layers, ..Request::new(view.size) };
        let (rasterized, nans) = layers_and_nans(&view.camera, &caster, &request, Tracing::Fast);
        // The tracer casts every ray.
        let (cast, _) = layers_and_nans(&view.camera, &caster, &request, Tracing::Counted);
        let wrong = nans > 0 || rasterized != cast;
        let wrong = failures.note(wrong, || format!("picture {index}: {nans} not numbers"));
        let shown = cast[0].iter().any(|&byte| byte > 0);
        ([wrong, u64::from(shown)], [])
    };
    let pictures = rays(2_000, 200_000);
    let [wrong, shown] = measure::<2, 0>(pictures, one).0;
    assert_eq!(wrong, 0);
    assert!(shown > pictures / 4, "the test tests nothing: {shown}");
}

/// The same for rays through other points of the pixels, among them the corners.
#[test]
fn a_whole_pixel_sees_what_all_of_its_rays_hit() {
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED + 1, index);
        let view = View::new(rng);
        let world = view.world(rng);
        (compare(&view, &world, Footprint::Pixel, rng, &failures), [])
    };
    let [wrong, unsure, rays] = measure::<3, 0>(rays(2_000, 200_000), one).0;
    println!("{rays} rays, {unsure} unsure, {wrong} wrong");
    assert_eq!(wrong, 0);
    assert!(unsure < rays / 4 * 3, "the test tests nothing");
}
