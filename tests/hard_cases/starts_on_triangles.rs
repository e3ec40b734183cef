//! Case 70: rays that start on a triangle, or a few roundings beside it.

use crate::support::exact::{cross, dot, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of;
use glam::DVec3;
use num_rational::BigRational;
use num_traits::{Signed, Zero};
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::instructions::available;
use raytracer::math::ray::Ray;
use raytracer::scene::Object;
use raytracer::world::triangle::Shear;

/// The exact sign of t where the line of a ray crosses a triangle in its inside; none where it does not, or meets its edge.
fn sign(ray: &Ray, corners: [DVec3; 3]) -> Option<i32> {
    let [a, b, c] = corners.map(exact3);
    let (o, d) = (exact3(ray.origin), exact3(ray.direction));
    let sides = [[&a, &b], [&b, &c], [&c, &a]].map(|[p, q]| dot(&cross(&sub(p, &o), &sub(q, &o)), &d));
    let inside = !sides.iter().any(Zero::is_zero)
        && sides[0].is_positive() == sides[1].is_positive()
        && sides[1].is_positive() == sides[2].is_positive();
    let normal = cross(&sub(&b, &a), &sub(&c, &a));
    let (height, rate) = (dot(&normal, &sub(&a, &o)), dot(&normal, &d));
    let sign = |x: BigRational| i32::from(x.is_positive()) - i32::from(x.is_negative());
    inside.then(|| sign(height) * sign(rate))
}

/// A triangle with the centre of gravity `at`, which is a float, or nearly so.
fn triangle_around(at: DVec3, rng: &mut Rng) -> [DVec3; 3] {
    match rng.below(3) {
        0 => {
            let mut whole = || DVec3::new(rng.integer(9), rng.integer(9), rng.integer(9));
            let (u, v) = (whole(), whole());
            [at + u, at + v, at - u - v]
        }
        1 => {
            let (u, v) = (rng.in_cube(), rng.in_cube());
            [at + u, at + v, at - u - v]
        }
        // One corner is far away.
        _ => {
            let (u, v) = (rng.in_cube(), rng.in_cube());
            let far = 10f64.powf(rng.range(1.0, 14.0));
            [at + u, at + v, at - far * (u + v)]
        }
    }
}

/// Counts a ray that crosses the triangle, one that starts on it exactly, and wrong answers: ours, and Moeller and
/// Trumbore's.
fn one(index: u64, failures: &Failures) -> ([u64; 4], [f64; 0]) {
    let mut rng = Rng::at(70, index);
    let at = DVec3::new(rng.integer(9), rng.integer(9), rng.integer(9));
    let corners = triangle_around(at, &mut rng);
    let ulps = |x: f64, rng: &mut Rng| x + f64::EPSILON * 8.0 * rng.integer(3);
    let origin = match rng.below(2) {
        0 => at,
        _ => DVec3::new(ulps(at.x, &mut rng), ulps(at.y, &mut rng), ulps(at.z, &mut rng)),
    };
    let ray = Ray::new(origin, rng.direction());
    let Some(sign) = sign(&ray, corners) else { return ([0; 4], []) };
    let world = world_of(vec![Object::Triangle { vertices: corners, material: 0 }]);
    let [a, b, c] = &corners;
    let t = Shear::new(&ray).intersect([a, b, c]).expect("a crossing");
    let mut wrong = i32::from(t > 0.0) - i32::from(t < 0.0) != sign;
    for level in available() {
        for layout in [Layout::List, Layout::Grid([3, 2, 4])] {
            let caster = Caster::with(&world, layout, level).expect("a grid");
            wrong |= caster.closest(&ray).is_some() != (sign >= 0);
            wrong |= caster.any(&ray, RayOrigin::FREE) != (sign >= 0);
        }
    }
    failures.note(wrong, || format!("70 {index} {ray:?} {corners:?}: {t} {sign}"));
    let [p, q, s] = [*b - *a, *c - *a, origin - *a];
    let t = q.dot(s.cross(p)) / p.dot(ray.direction.cross(q));
    let textbook = (t >= 0.0) != (sign >= 0);
    ([1, u64::from(sign == 0), u64::from(wrong), u64::from(textbook)], [])
}

#[test]
fn case_70_starts_on_triangles() {
    let inputs = rays(40_000, 4_000_000);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| one(index, &failures));
    let [cast, on, wrong, textbook] = counts;
    Record {
        case: 70,
        basis: Basis::Proved,
        name: "rays that start on a triangle, or a few roundings beside it",
        inputs: format!("{cast} rays, {on} of them exactly on it"),
        measure: "wrong signs of t; hits behind the start, and lost ones",
        textbook: format!("Moeller-Trumbore f64: {textbook}"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > cast / 100, "the textbook method does not fail");
    assert!(cast > inputs / 2 && on > cast / 10, "{counts:?}");
    assert_eq!(wrong, 0);
}
