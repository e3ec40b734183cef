//! Visibility by rasterization for orthographic cameras: the primitive that a pixel shows is the one that its ray hits.

use crate::raster::{compare, demand_layers};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::views::{View, triangles};
use glam::DVec2;
use raytracer::fast::Footprint;
use raytracer::world::World;
use raytracer::world::plane::Plane;

/// Runs pictures for both footprints, and asserts that none is wrong and that more than this part of the rays is sure.
fn demand(seed: u64, pictures: u64, least_sure: f64, picture: impl Fn(&mut Rng) -> (View, World) + Sync) {
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(seed, index);
        let (view, world) = picture(rng);
        let [a, b] = [Footprint::Center, Footprint::Pixel]
            .map(|footprint| compare(&view, &world, footprint, rng, &failures));
        ([a[0], a[1], a[2], b[0], b[1], b[2], u64::from(a[2] == 0)], [])
    };
    let [wrong, unsure, rays, wrong_of_pixels, unsure_of_pixels, rays_of_pixels, undrawn] =
        measure::<7, 0>(pictures, one).0;
    println!("{unsure} of {rays} and {unsure_of_pixels} of {rays_of_pixels} unsure, {undrawn} not drawn");
    assert_eq!([wrong, wrong_of_pixels], [0; 2]);
    let sure = |unsure: u64, rays: u64| 1.0 - unsure as f64 / rays as f64;
    assert!(sure(unsure, rays) > least_sure, "{}", sure(unsure, rays));
    assert!(unsure > 0 && sure(unsure_of_pixels, rays_of_pixels) > 0.0 && undrawn < pictures / 2);
}

/// Triangles, needles and planes of all sizes, from anywhere.
#[test]
fn pixels_see_what_their_rays_hit() {
    demand(3040, rays(2_000, 200_000), 0.7, |rng| {
        let view = View::parallel(rng);
        let world = view.world(rng);
        (view, world)
    });
}

/// Some of their corners coincide with pixel centres.
#[test]
fn triangles_as_small_as_pixels() {
    demand(3041, rays(3_000, 300_000), 0.7, |rng| {
        let view = View::parallel(rng);
        let world = view.small_triangles(rng);
        (view, world)
    });
}

/// Triangles just in front of or behind a plane, up to the errors of their depths.
#[test]
fn triangles_at_almost_the_depth_of_a_plane() {
    demand(3042, rays(3_000, 300_000), 0.2, |rng| {
        let view = View::parallel(rng);
        let mut world = view.small_triangles(rng);
        let [a, b, c] = world.corners(0);
        let normal = (b - a).cross(c - a).normalize();
        let aside = (b - a).length() * f64::powf(10.0, rng.range(-18.0, -3.0)) * rng.range(-1.0, 1.0);
        if normal.is_finite() {
            world.planes.push(Plane { normal, offset: normal.dot(a) + aside });
        }
        (view, world)
    });
}

/// Long thin triangles through the centre of a pixel, parallel to a plane just before or behind them. Their areas are
/// small differences of large numbers, and so are the depths that are interpolated.
#[test]
fn slivers_at_almost_the_depth_of_a_plane() {
    demand(3046, rays(20_000, 2_000_000), 0.2, |rng| {
        let view = View::parallel(rng);
        let pixel = DVec2::from_array(view.some_pixel(rng).map(|i| i as f64));
        let (length, width) = (f64::powf(10.0, rng.range(0.0, 4.5)), f64::powf(10.0, rng.range(-12.0, -3.0)));
        let corners = [(-1.0, -1.0), (1.0, rng.range(-1.0, 1.0)), (rng.range(-1.0, 1.0), 1.0)];
        let depth = view.scale * rng.range(-1.0, 1.0);
        let sliver = corners.map(|(x, y)| {
            let aside = if view.size[0].is_multiple_of(2) {
                DVec2::new(x * length, y * width)
            } else {
                DVec2::new(y * width, x * length)
            };
            view.camera.ray(pixel, aside).at(depth)
        });
        let ahead =
            (sliver[1] - sliver[0]).length() * f64::powf(10.0, rng.range(-10.0, -3.0)) * rng.range(-1.0, 1.0);
        let mut world = triangles([sliver]);
        let normal = view.direction.normalize();
        world.planes.push(Plane { normal, offset: normal.dot(view.ray([0, 0]).at(depth)) + ahead });
        (view, world)
    });
}

/// Planes that are almost parallel to the rays, which hit them very far away, if at all.
#[test]
fn planes_along_the_rays() {
    demand(3043, rays(3_000, 300_000), 0.1, |rng| {
        let view = View::parallel(rng);
        let mut world = view.small_triangles(rng);
        let across = view.direction.cross(rng.direction());
        let tilt = f64::powf(10.0, rng.range(-18.0, 0.0)) * [1.0, -1.0, 0.0][rng.below(3)];
        let normal = (across + tilt * view.direction).normalize();
        let pixel = view.some_pixel(rng);
        world.planes.push(Plane { normal, offset: normal.dot(view.ray(pixel).origin) });
        (view, world)
    });
}

/// Cameras whose up vector is almost parallel to the direction, so that the axes are not quite orthogonal.
#[test]
fn views_almost_along_their_up() {
    demand(3044, rays(3_000, 300_000), 0.5, |rng| {
        let direction = rng.direction();
        let up = direction + f64::powf(10.0, rng.range(-11.0, -2.0)) * rng.direction();
        let view = View::parallel_along(rng, direction, up);
        let world = view.small_triangles(rng);
        (view, world)
    });
}

/// Pictures of depths and normals, against the course's mode, which casts every ray.
#[test]
fn depths_and_normals_are_those_of_the_rays() {
    demand_layers(3045, View::parallel, [-2.0, 2.0]);
}
