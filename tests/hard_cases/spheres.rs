//! Section C, cases 33 to 37: distant, tiny, huge and tangent spheres, and rays that leave a sphere.

use crate::support::double_double::{self as dd, Dd};
use crate::support::measure::{Failures, measure, ulps32};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of;
use crate::support::secondary::secondary;
use crate::support::spheres::{nearest, tangency, textbook32, textbook64};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::Object;
use raytracer::world::shape::Form;
use raytracer::world::sphere::Sphere;

/// The counts of a sphere case: wrong decisions of three methods, then their largest errors in t.
#[derive(Default)]
struct SphereTally {
    wrong: [u64; 3],
    worst: [f64; 3],
}

/// Compares the nearest hit with the exact one: ours, the textbook's in f32 and in f64.
fn compare(sphere: &Sphere, ray: &Ray) -> SphereTally {
    let exact = nearest(sphere, ray);
    let found = [sphere.intersect(ray), textbook32(sphere, ray, 0.0).map(f64::from), textbook64(sphere, ray)];
    let mut tally = SphereTally::default();
    for (i, found) in found.into_iter().enumerate() {
        match (found, exact) {
            (Some(t), Some(exact)) => {
                tally.worst[i] = ulps32((Dd::from(t) - exact).value(), exact.value());
            }
            (None, None) => {}
            _ => tally.wrong[i] = 1,
        }
    }
    tally
}

/// A ray from `distance` away, aimed uniformly at the disc of 1.02 radii. Half of the directions are unit
/// vectors.
fn ray_at_disc(sphere: &Sphere, distance: f64, rng: &mut Rng) -> Ray {
    let away = rng.direction();
    let origin = sphere.center + distance * away;
    let across = away.any_orthonormal_vector();
    let (sine, cosine) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
    let radius = 1.02 * sphere.radius * rng.unit().sqrt();
    let target = sphere.center + radius * (cosine * across + sine * away.cross(across));
    let direction = target - origin;
    Ray::new(origin, if rng.below(2) == 0 { direction } else { direction.normalize() })
}

/// Runs a sphere case with inputs from `draw`.
fn sphere_case(
    case: u32,
    seed: u64,
    inputs: u64,
    draw: impl Fn(&mut Rng) -> (Sphere, Ray) + Sync,
) -> SphereTally {
    let failures = Failures::default();
    let (wrong, worst) = measure(inputs, |index| {
        let (sphere, ray) = draw(&mut Rng::at(seed, index));
        let tally = compare(&sphere, &ray);
        failures.note(tally.wrong[0] > 0 || tally.worst[0] > 0.01, || {
            let input = failed_ray(case, seed, index, ray.origin, ray.direction);
            format!("{input}, error {} ulp32", tally.worst[0])
        });
        (tally.wrong, tally.worst)
    });
    SphereTally { wrong, worst }
}

#[test]
fn case_33_spheres_far_away() {
    let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
    let inputs = rays(100_000, 20_000_000);
    let (mut texts, mut ours) = (vec![], SphereTally::default());
    for (k, distance) in [1e2, 1e3, 1e4, 1e6, 1e7].into_iter().enumerate() {
        let draw = |rng: &mut Rng| (sphere, ray_at_disc(&sphere, distance, rng));
        let SphereTally { wrong, worst } = sphere_case(33, 3300 + k as u64, inputs, draw);
        texts.push(format!(
            "{distance:e}: f32 {} wrong, t off by {:.0} ulp32, f64 {} wrong",
            wrong[1], worst[1], wrong[2]
        ));
        ours.wrong[0] += wrong[0];
        ours.worst[0] = ours.worst[0].max(worst[0]);
        assert!(wrong[1] > 0, "the textbook method does not fail at {distance}");
    }
    Record {
        case: 33,
        basis: Basis::Sampled,
        name: "sphere, distance sweep",
        inputs: format!("{inputs} rays at each of 5 distances"),
        measure: "wrong hits and misses; largest error of t",
        textbook: format!("plain quadratic; {}", texts.join("; ")),
        ours: format!("{} wrong, {:.1e} ulp32", ours.wrong[0], ours.worst[0]),
        target: "0 wrong, <= 0.01 ulp32 up to 1e7 radii",
    }
    .write();
    assert!(ours.wrong[0] == 0 && ours.worst[0] <= 0.01);
}

#[test]
fn case_34_tiny_sphere() {
    let sphere = Sphere { center: DVec3::new(300.0, -500.0, 700.0), radius: 1e-3 };
    let inputs = rays(200_000, 50_000_000);
    let tally = sphere_case(34, 34, inputs, |rng| (sphere, ray_at_disc(&sphere, 1e3, rng)));
    Record {
        case: 34,
        basis: Basis::Sampled,
        name: "tiny sphere, 1e-3 at 1e3",
        inputs: format!("{inputs} rays"),
        measure: "wrong hits and misses; largest error of t",
        textbook: format!("plain quadratic: f32 {} wrong, f64 {} wrong", tally.wrong[1], tally.wrong[2]),
        ours: format!("{} wrong, {:.1e} ulp32", tally.wrong[0], tally.worst[0]),
        target: "0 wrong, <= 0.01 ulp32",
    }
    .write();
    assert!(tally.wrong[1] > 0, "the textbook method does not fail");
    assert!(tally.wrong[0] == 0 && tally.worst[0] <= 0.01);
}

/// A planet of radius 1e6 seen from 1 to 10 above its ground: half of the rays go down in any direction, half
/// just below the horizon.
fn planet(rng: &mut Rng) -> (Sphere, Ray) {
    let sphere = Sphere { center: DVec3::new(0.0, -1e6, 0.0), radius: 1e6 };
    let height = rng.range(1.0, 10.0);
    let (sine, cosine) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
    let horizon = (2.0 * height / 1e6).sqrt();
    let down = if rng.below(2) == 0 { horizon * rng.range(0.9, 2.0) } else { rng.range(0.0, 1.5) };
    let ahead = down.cos();
    let direction = DVec3::new(ahead * cosine, -down.sin(), ahead * sine);
    (sphere, Ray::new(DVec3::new(rng.range(-5.0, 5.0), height, rng.range(-5.0, 5.0)), direction))
}

#[test]
fn case_35_planet() {
    let inputs = rays(200_000, 50_000_000);
    let tally = sphere_case(35, 35, inputs, planet);
    Record {
        case: 35,
        basis: Basis::Sampled,
        name: "planet of radius 1e6 seen from 1 to 10 above",
        inputs: format!("{inputs} rays"),
        measure: "largest error of t; wrong hits and misses",
        textbook: format!(
            "plain quadratic: f32 {:.0} ulp32, {} wrong; f64 {:.1e} ulp32, {} wrong",
            tally.worst[1], tally.wrong[1], tally.worst[2], tally.wrong[2]
        ),
        ours: format!("{:.1e} ulp32, {} wrong", tally.worst[0], tally.wrong[0]),
        target: "<= 0.01 ulp32",
    }
    .write();
    assert!(tally.wrong[1] > 0 && tally.worst[1] > 1e3, "the textbook method does not fail");
    assert!(tally.worst[0] <= 0.01 && tally.wrong[0] == 0);
}

/// The range of each sweep over a tangent, in units in the last place of the origin.
const SWEEP: i64 = 64;

/// A sphere, a ray that is tangent to it up to rounding, and the axis along which moving its origin changes
/// the distance from the centre the most.
fn tangent(rng: &mut Rng) -> (Sphere, Ray, usize) {
    let sphere = Sphere { center: 10.0 * rng.in_cube(), radius: rng.range(0.1, 10.0) };
    let direction = rng.direction();
    let out = direction.cross(rng.direction()).normalize();
    let back = sphere.radius * 10f64.powf(rng.range(-1.0, 2.0));
    let origin = sphere.center + sphere.radius * out - back * direction;
    let ray = Ray { t_min: f64::NEG_INFINITY, ..Ray::new(origin, direction) };
    (sphere, ray, out.abs().max_position())
}

/// Moves the origin of a tangent over neighbouring floats. Counts wrong decisions farther than four roundings
/// from the tangent, and whether the decision changes more than once, for ours and then for f64.
fn sweep(rng: &mut Rng) -> [u64; 4] {
    let (sphere, ray, axis) = tangent(rng);
    let (mut wrong, mut changes, mut before) = ([0; 2], [0u64; 2], [None; 2]);
    let bits = ray.origin[axis].to_bits() as i64;
    for step in -SWEEP..=SWEEP {
        let mut moved = ray;
        moved.origin[axis] = f64::from_bits((bits + step) as u64);
        let (meets, margin) = tangency(&sphere, &moved);
        let plain = textbook_meets(&sphere, &moved);
        for (i, decision) in [sphere.intersect(&moved).is_some(), plain].into_iter().enumerate() {
            wrong[i] += (decision != meets && margin > 4.0 * UNIT_ROUNDOFF) as u64;
            changes[i] += before[i].is_some_and(|b: bool| b != decision) as u64;
            before[i] = Some(decision);
        }
    }
    [wrong[0], (changes[0] > 1) as u64, wrong[1], (changes[1] > 1) as u64]
}

fn textbook_meets(sphere: &Sphere, ray: &Ray) -> bool {
    let f = ray.origin - sphere.center;
    let b = 2.0 * f.dot(ray.direction);
    let c = f.length_squared() - sphere.radius * sphere.radius;
    b * b - 4.0 * ray.direction.length_squared() * c >= 0.0
}

#[test]
fn case_36_tangents() {
    let sweeps = rays(1_500, 150_000);
    let failures = Failures::default();
    let (counts, []) = measure(sweeps, |index| {
        let counts = sweep(&mut Rng::at(36, index));
        failures.note(counts[0] + counts[1] > 0, || {
            let (_, ray, _) = tangent(&mut Rng::at(36, index));
            format!("{}, {counts:?}", failed_ray(36, 36, index, ray.origin, ray.direction))
        });
        (counts, [])
    });
    let [wrong, turns, textbook_wrong, textbook_turns] = counts;
    Record {
        case: 36,
        basis: Basis::Sampled,
        name: "tangents",
        inputs: format!("{sweeps} sweeps of {} neighbouring origins", 2 * SWEEP + 1),
        measure: "wrong decisions farther than 4 roundings from the tangent; sweeps that change their mind",
        textbook: format!("plain quadratic f64: {textbook_wrong} wrong, {textbook_turns} sweeps"),
        ours: format!("{wrong} wrong, {turns} sweeps"),
        target: "0 wrong, 0 sweeps",
    }
    .write();
    assert!(textbook_wrong > 0 && textbook_turns > 0, "the textbook method does not fail");
    assert_eq!((wrong, turns), (0, 0));
}

/// A sphere far from or near the origin, a ray that hits it, and the direction in which another ray leaves
/// the hit, in half of the cases almost parallel to the surface.
fn leaving(rng: &mut Rng) -> (Sphere, Ray, DVec3) {
    let radius = 10f64.powf(rng.range(-3.0, 3.0));
    let center = rng.direction() * 10f64.powf(rng.range(-3.0, 4.0));
    let sphere = Sphere { center, radius };
    let origin = center + rng.direction() * radius * rng.range(1.5, 20.0);
    let target = center + 0.9 * radius * rng.in_ball();
    let normal = (target - center).normalize();
    let along = normal.cross(rng.direction()).normalize();
    let grazing = 10f64.powf(rng.range(-12.0, 0.0)) * if rng.below(2) == 0 { 1.0 } else { -1.0 };
    let out = if rng.below(2) == 0 { rng.direction() } else { (along + grazing * normal).normalize() };
    (sphere, Ray::new(origin, (target - origin).normalize()), out)
}

/// The hit of a ray that leaves a point of the sphere: nothing outside, and the far side inside, at this t.
/// None where this is too close to decide. The point is not the one that the program computes, but the
/// nearest on the sphere.
fn far_side(sphere: &Sphere, point: DVec3, out: DVec3) -> Option<Option<f64>> {
    let from_center = dd::sub(&dd::vector(point), &dd::vector(sphere.center));
    let length = dd::dot(&from_center, &from_center).sqrt();
    let cosine = (dd::dot(&from_center, &dd::vector(out)) / length).value();
    let chord = -2.0 * sphere.radius * cosine;
    // The offset is less than a hundred roundings of these numbers.
    let size = point.abs().max_element() + sphere.center.abs().max_element() + sphere.radius;
    (chord.abs() > 1e4 * UNIT_ROUNDOFF * size).then(|| (chord > 0.0).then_some(chord))
}

/// Counts for one secondary ray: whether ours finds a crossing close by, whether it misses the far side, and
/// whether the f32 textbook finds a crossing close by. Then our error in t at the far side.
fn leave(rng: &mut Rng) -> Option<([u64; 3], [f64; 1])> {
    let (sphere, ray, out) = leaving(rng);
    let object = Object::Sphere { center: sphere.center, radius: sphere.radius, material: 0 };
    let world = world_of(vec![object]);
    let caster = Caster::new(&world, None).expect("no grid");
    let hit = caster.closest(&ray)?;
    let surface = world.surface(&ray, &hit);
    let truth = far_side(&sphere, surface.position, out)?;
    let secondary = secondary(&surface, out);
    let origin = RayOrigin::on(&world, surface.triangle);
    let found = caster.nearest(&secondary, origin).map(|visible| visible.t_bound);
    let spurious = found.is_some_and(|t| truth.is_none_or(|far| t < 0.5 * far));
    let lost = found.is_none() && truth.is_some();
    let error = match (found, nearest(&sphere, &secondary)) {
        (Some(t), Some(exact)) => {
            (Dd::from(t) - exact).abs().value() / (sphere.radius + secondary.origin.length())
        }
        _ => 0.0,
    };
    let point = ray.origin.as_vec3() + hit.t as f32 * ray.direction.as_vec3();
    let from32 = Ray::new(point.as_dvec3(), out);
    let textbook = textbook32(&sphere, &from32, 0.0).is_some_and(|t| (t as f64) < 1e-3 * sphere.radius);
    Some(([spurious as u64, lost as u64, textbook as u64], [error]))
}

#[test]
fn case_37_rays_that_leave_a_sphere() {
    let inputs = rays(200_000, 20_000_000);
    let failures = Failures::default();
    let (counts, [error]) = measure(inputs, |index| {
        let (counts, errors) = leave(&mut Rng::at(37, index)).unwrap_or_default();
        failures.note(counts[0] + counts[1] > 0, || {
            let (_, ray, _) = leaving(&mut Rng::at(37, index));
            format!("{}, {counts:?}", failed_ray(37, 37, index, ray.origin, ray.direction))
        });
        (counts, errors)
    });
    let [spurious, lost, textbook] = counts;
    Record {
        case: 37,
        basis: Basis::Sampled,
        name: "rays that leave a sphere",
        inputs: format!("{inputs} secondary rays"),
        measure: "crossings found at the surface left; far sides missed; error of t over the size",
        textbook: format!("plain quadratic f32 from an f32 point: {textbook} spurious crossings"),
        ours: format!("{spurious} spurious, {lost} missed, {error:.1e}"),
        target: "0 spurious",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!((spurious, lost), (0, 0));
}
