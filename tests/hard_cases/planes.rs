//! Section C, cases 38 and 39: planes seen at a grazing angle, and planes far from the origin.

use crate::support::double_double::{self as dd, Dd};
use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::math::ray::Ray;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::world::plane::Plane;

/// A plane and a ray at an elevation of 1e-1 to 1e-12 above it. In half of the cases the plane is y = 0, in
/// half it has any orientation.
fn grazing(rng: &mut Rng) -> (Plane, Ray) {
    let tilted = rng.below(2) == 0;
    let normal = if tilted { rng.direction() } else { DVec3::Y };
    let along = normal.cross(rng.direction()).normalize();
    let elevation = 10f64.powf(rng.range(-12.0, -1.0));
    let (height, offset) =
        (10f64.powf(rng.range(-3.0, 1.0)), if tilted { rng.range(-3.0, 3.0) } else { 0.0 });
    let origin = (offset + height) * normal + rng.range(-5.0, 5.0) * along;
    (Plane { normal, offset }, Ray::new(origin, along - elevation * normal))
}

/// The exact t in double-double, and the condition number of the formula: the relative error that one
/// rounding of its terms may cause.
fn plane_oracle(plane: &Plane, ray: &Ray) -> (Dd, f64) {
    let n = dd::vector(plane.normal);
    let above = Dd::from(plane.offset) - dd::dot(&n, &dd::vector(ray.origin));
    let speed = dd::dot(&n, &dd::vector(ray.direction));
    let terms = |v: DVec3| (plane.normal * v).abs().element_sum();
    let condition = (plane.offset.abs() + terms(ray.origin)) / above.value().abs()
        + terms(ray.direction) / speed.value().abs();
    (above / speed, condition)
}

#[test]
fn case_38_planes_at_a_grazing_angle() {
    let inputs = rays(200_000, 50_000_000);
    let failures = Failures::default();
    let (counts, worst) = measure(inputs, |index| {
        let (plane, ray) = grazing(&mut Rng::at(38, index));
        let (exact, condition) = plane_oracle(&plane, &ray);
        // The rounding of a tilted plane may turn the most grazing rays away from it.
        if exact.sign() < 0 {
            return ([0, (plane.intersect(&ray).is_some()) as u64, 0], [0.0; 2]);
        }
        let relative = |t: f64| (Dd::from(t) - exact).abs().value() / exact.value();
        let ours = plane.intersect(&ray);
        let (n, o, d) = (plane.normal.as_vec3(), ray.origin.as_vec3(), ray.direction.as_vec3());
        // The textbook takes a small product to mean parallel.
        let speed = n.dot(d);
        let t32 = (plane.offset as f32 - n.dot(o)) / speed;
        let error = ours.map_or(f64::INFINITY, relative) / (condition * UNIT_ROUNDOFF);
        let wrong = failures.note(error > 4.0, || failed_ray(38, 38, index, ray.origin, ray.direction));
        (
            [(speed.abs() < 1e-6) as u64, wrong, 1],
            [error, if speed == 0.0 { 0.0 } else { relative(t32 as f64) }],
        )
    });
    let alongside = parallel_rays();
    Record {
        case: 38,
        basis: Basis::Sampled,
        name: "plane at a grazing angle",
        inputs: format!("{inputs} rays at elevations 1e-1 to 1e-12"),
        measure: "largest relative error of t in roundings times the formula's condition; NaN or hits of parallel rays",
        textbook: format!("f32 with |n.d| < 1e-6 as parallel: {} hits lost, t off by a factor {:.1e}", counts[0], worst[1]),
        ours: format!("{:.2}; {} outside; {alongside}", worst[0], counts[1]),
        target: "<= 4; 0",
    }
    .write();
    assert!(counts[0] > 0 && worst[1] > 1e-3, "the textbook method does not fail");
    assert!(worst[0] <= 4.0 && counts[1] == 0 && alongside == 0);
}

/// The number of hits among rays that are exactly parallel to a plane, in it or outside it.
fn parallel_rays() -> u64 {
    let (counts, []) = measure(100_000, |index| {
        let mut rng = Rng::at(380, index);
        let axis = rng.below(3);
        let mut normal = DVec3::ZERO;
        normal[axis] = if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let (mut origin, mut direction) = (rng.in_cube(), rng.direction());
        direction[axis] = if rng.below(2) == 0 { 0.0 } else { -0.0 };
        origin[axis] = [0.0, 0.5, -0.5][rng.below(3)];
        let t_min = if rng.below(2) == 0 { 0.0 } else { f64::NEG_INFINITY };
        let ray = Ray { t_min, ..Ray::new(origin, direction) };
        ([Plane { normal, offset: 0.0 }.intersect(&ray).is_some() as u64], [])
    });
    counts[0]
}

/// A plane `offset` away from the origin, and a ray from within that distance to a point of it.
fn far_plane(offset: f64, rng: &mut Rng) -> (Plane, Ray) {
    let normal = rng.direction();
    let along = normal.cross(rng.direction()).normalize();
    let target = offset * normal + rng.range(0.0, offset) * along;
    let origin = target + rng.range(1.0, offset) * (normal + rng.in_ball()).normalize();
    (Plane { normal, offset }, Ray::new(origin, (target - origin).normalize()))
}

#[test]
fn case_39_planes_far_away() {
    let inputs = rays(100_000, 20_000_000);
    let (mut ours, mut textbook) = (0.0f64, [0.0f64; 2]);
    for (seed, offset) in [(390, 1e6), (391, 1e8)] {
        let failures = Failures::default();
        let (_, worst) = measure(inputs, |index| {
            let (plane, ray) = far_plane(offset, &mut Rng::at(seed, index));
            let n = dd::vector(plane.normal);
            let off = |p: DVec3| {
                (dd::dot(&n, &dd::vector(p)) - plane.offset.into()).abs().value() / (UNIT_ROUNDOFF * offset)
            };
            let Some(t) = plane.intersect(&ray) else { return ([1], [f64::INFINITY; 3]) };
            let ours = off(plane.project(ray.at(t)));
            failures.note(ours > 4.0, || failed_ray(39, seed, index, ray.origin, ray.direction));
            let single = ray.origin.as_vec3() + t as f32 * ray.direction.as_vec3();
            ([0], [ours, off(ray.at(t)), off(single.as_dvec3())])
        });
        ours = ours.max(worst[0]);
        textbook = [textbook[0].max(worst[1]), textbook[1].max(worst[2])];
    }
    Record {
        case: 39,
        basis: Basis::Sampled,
        name: "plane far from the origin",
        inputs: format!("{inputs} rays at each of the offsets 1e6 and 1e8"),
        measure: "largest distance of the hit from the plane, in roundings of the offset",
        textbook: format!("o + t d: f64 {:.1}, f32 {:.1e}", textbook[0], textbook[1]),
        ours: format!("{ours:.2}"),
        target: "<= 4",
    }
    .write();
    assert!(textbook[0] > 4.0 && textbook[1] > 1e6, "the textbook method does not fail");
    assert!(ours <= 4.0);
}
