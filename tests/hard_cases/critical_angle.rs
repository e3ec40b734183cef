//! Case 66: the critical angle of total internal reflection.

use crate::support::exact::{cross, dot, exact, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use glam::DVec3;
use num_rational::BigRational;
use num_traits::Signed;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::picture::Color;
use raytracer::scene::Object;
use raytracer::scene::material::{Material, Phong};
use raytracer::stats::Counts;
use raytracer::trace::{Effects, RayStack, Tracer};
use raytracer::world::World;

type Exact3 = [BigRational; 3];

/// A surface through the origin, and its normal by its author's numbers.
fn any_surface(rng: &mut Rng) -> (Object, Exact3) {
    let mut whole = || DVec3::new(rng.integer(9), rng.integer(9), 1.0 + rng.integer(9).abs());
    let (u, v) = (whole(), whole());
    let kind = rng.below(3);
    if kind == 2 {
        // The radius is a whole number, too.
        let [x, y, z] = [[2.0, 3.0, 6.0], [1.0, 4.0, 8.0], [8.0, 9.0, 12.0], [2.0, 6.0, 9.0]][rng.below(4)];
        let mut side = |x: f64| if rng.below(2) == 0 { x } else { -x };
        let outward = DVec3::new(side(x), side(y), z);
        let sphere = Object::Sphere { center: -outward, radius: outward.length(), material: 0 };
        return (sphere, exact3(outward));
    }
    if kind == 0 {
        let scale = 10f64.powf(rng.range(-3.0, 3.0));
        let normal = scale * u;
        return (Object::Plane { normal, offset: 0.0, material: 0 }, exact3(normal));
    }
    // The origin is the centre of gravity.
    let vertices = [u, v, -u - v];
    let [a, b, c] = vertices.map(exact3);
    (Object::Triangle { vertices, material: 0 }, cross(&sub(&b, &a), &sub(&c, &a)))
}

/// The square of a refracted ray's normal component, times those of both vectors' lengths and of the index.
fn radicand(direction: DVec3, normal: &Exact3, index: f64) -> BigRational {
    let (direction, index) = (exact3(direction), exact(index));
    let across = cross(&direction, normal);
    &index * &index * dot(&direction, &direction) * dot(normal, normal) - dot(&across, &across)
}

/// The same by the usual formula: none at total internal reflection.
fn textbook(direction: DVec3, normal: DVec3, index: f64) -> bool {
    let (eta, cosine) = (1.0 / index, direction.dot(normal).abs());
    1.0 - eta * eta * (1.0 - cosine * cosine) >= 0.0
}

/// Whether a ray is transmitted by the surface, so that a second ray is cast.
fn is_transmitted(object: &Object, index: f64, ray: &Ray) -> Option<bool> {
    let mut scene = scene_of(vec![object.clone()], vec![]);
    let glass = Phong { transparent: Color::ONE, index_of_refraction: index, ..Phong::default() };
    scene.materials = vec![Material::Phong(Phong { diffuse: Color::ZERO, ..glass })];
    let world = World::new(&scene, &[]).expect("a valid scene");
    let caster = Caster::new(&world, None).expect("no grid");
    caster.closest(ray)?;
    let effects = Effects { bounces: 1, shade_back: true, ..Effects::default() };
    let mut counts = Counts::default();
    Tracer::new(&caster, effects).color(ray, &mut RayStack::default(), &mut counts);
    Some(counts.non_shadow_rays > 0)
}

/// Whether a ray was cast, a decision was wrong, the textbook's was, and both answers are met. The index is that of the
/// critical angle to within some ulps.
fn one(index: u64, failures: &Failures) -> ([u64; 4], [f64; 0]) {
    let mut rng = Rng::at(66, index);
    let (object, normal) = any_surface(&mut rng);
    let rounded = normal.clone().map(|x| num_traits::ToPrimitive::to_f64(&x).expect("a float"));
    let unit = DVec3::from_array(rounded).normalize();
    if !unit.is_finite() {
        return ([0; 4], []);
    }
    // A direction against the normal with short coordinates, or with long ones.
    let direction = match rng.below(2) {
        0 => rng.direction(),
        _ => DVec3::new(rng.integer(9), rng.integer(9), rng.integer(9)).normalize_or(DVec3::Z),
    };
    let direction = if direction.dot(unit) > 0.0 { -direction } else { direction };
    let sine = direction.cross(unit).length();
    let refraction = f64::from_bits((sine.to_bits() as i64 + rng.below(9) as i64 - 4) as u64);
    let grazing = direction.dot(unit).abs() < 1e-3 || sine < 1e-3;
    let ray = Ray::new(-direction, direction);
    let transmitted = if grazing { None } else { is_transmitted(&object, refraction, &ray) };
    let Some(is_transmitted) = transmitted else { return ([0; 4], []) };
    let expected = !radicand(direction, &normal, refraction).is_negative();
    let wrong = failures
        .note(is_transmitted != expected, || format!("66 {index} {object:?} {direction} {refraction}"));
    let textbook = textbook(direction, unit, refraction) != expected;
    ([1, wrong, textbook as u64, expected as u64], [])
}

#[test]
fn case_66_critical_angle() {
    let inputs = rays(40_000, 4_000_000);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| one(index, &failures));
    let [cast, wrong, textbook, transmitted] = counts;
    Record {
        case: 66,
        basis: Basis::Sampled,
        name: "rays within 4 ulps of the index at the critical angle, onto planes, triangles and spheres of whole numbers",
        inputs: format!("{cast} rays, {transmitted} of them transmitted"),
        measure: "rays wrongly transmitted or reflected",
        textbook: format!("1 - eta^2 (1 - cosine^2) in f64: {textbook}"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert!(cast > inputs / 2 && transmitted > cast / 4 && transmitted < 3 * cast / 4, "{counts:?}");
    assert_eq!(wrong, 0);
}
