//! Case 69: point lights on planes, spheres and ellipsoids, and close to them.

use crate::support::exact::{dot, exact, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use glam::{DAffine3, DQuat, DVec3};
use num_traits::Signed;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::scene::{Light, Object, Position};
use raytracer::stats::Counts;
use raytracer::trace::Quiet;
use raytracer::trace::{Effects, RayStack, Shadows, Tracer};
use raytracer::world::{Primitive, World};

/// The points of the screen that are looked at for one light.
const POINTS: usize = 16;

/// Whether each of these points of a screen, on its side to which `normal` points, is lit by the light; none where
/// something else is in front of it.
fn are_lit(
    objects: &[Object],
    screen: (DVec3, f64),
    light: DVec3,
    targets: &[DVec3],
    size: f64,
) -> (World, Vec<Option<bool>>) {
    let (normal, offset) = screen;
    let light = Light::Point { position: light, color: DVec3::ONE, attenuation: [1.0, 0.0, 0.0] };
    let mut objects = objects.to_vec();
    objects.push(Object::Plane { normal, offset, material: 0 });
    let is_transformed = objects.len() == 3;
    let mut scene = scene_of(objects, vec![light]);
    if is_transformed && let Object::Group(children) = &mut scene.objects[scene.root] {
        children.remove(0);
    }
    let world = World::new(&scene, &[]).expect("a sound scene");
    let caster = Caster::new(&world, None).expect("no grid");
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 0, min_weight: 0.0 };
    let screen = (world.finite_count() + world.planes.len() - 1) as u32;
    let lit = |target: &DVec3| {
        let ray = Ray::new(*target + 1e-3 * size * normal, -normal);
        let hit = caster.closest(&ray).filter(|hit| hit.primitive == screen)?;
        let tracer = Tracer::new(&caster, effects);
        let color = tracer.color(&ray, &mut RayStack::default(), &mut Quiet);
        assert_eq!(tracer.color(&ray, &mut RayStack::default(), &mut Counts::default()), color);
        assert_eq!(hit.primitive, screen);
        Some(color != DVec3::ZERO)
    };
    let lit = targets.iter().map(lit).collect();
    (world, lit)
}

/// Counts for one light on a surface: the points that were looked at, and those that are lit although the light lies on the
/// surface. Then the light is moved away from a sphere or a plane without a transform, by a billionth of the size or more,
/// and the points are counted whose shadow is not the exact one.
fn one(index: u64, failures: &Failures) -> ([u64; 5], [f64; 0]) {
    let mut rng = Rng::at(69, index);
    let scale = 10f64.powf(rng.range(-4.0, 4.0));
    let turn = DQuat::from_axis_angle(rng.direction(), rng.range(-3.0, 3.0));
    let center = scale * 3.0 * rng.in_cube();
    let radius = scale * rng.range(0.2, 1.0);
    let stretch = DVec3::new(1.0, 10f64.powf(rng.range(-3.0, 1.0)), rng.range(0.2, 3.0));
    let map = DAffine3::from_scale_rotation_translation(stretch, turn, center);
    let (material, at) = (0, Position { line: 1, column: 1 });
    let (on, direction) = (rng.direction(), rng.direction());
    let kind = rng.below(4);
    let (objects, place, outward) = match kind {
        0 => (vec![Object::Sphere { center, radius, material }], center + radius * on, on),
        1 => {
            let sphere = Object::Sphere { center: DVec3::ZERO, radius, material };
            let objects =
                vec![sphere, Object::Transform { matrix: map.into(), factors: Box::default(), child: 0, at }];
            let outward = (map.matrix3.inverse().transpose() * on).normalize();
            (objects, map.transform_point3(radius * on), outward)
        }
        2 => {
            let offset = direction.dot(center);
            (vec![Object::Plane { normal: direction, offset, material }], center, direction)
        }
        // A sphere whose surface has the light in short numbers, as written by hand.
        _ => {
            let short = DVec3::from([[2.0, 3.0, 6.0], [1.0, 4.0, 8.0], [2.0, 6.0, 9.0]][rng.below(3)]);
            let center = DVec3::new(rng.integer(9), rng.integer(9), rng.integer(9));
            let (radius, place) = (short.length(), center + short);
            (vec![Object::Sphere { center, radius, material }], place, short / radius)
        }
    };
    let size = if kind == 3 { 16.0 } else { 8.0 * scale };
    // A screen beside the object that the light would shine on, as if it were alone.
    let normal = (rng.direction() - 0.5 * outward).normalize();
    let offset = normal.dot(place) - size * rng.range(2.0, 5.0);
    let along = normal.cross(rng.direction()).normalize();
    let across = normal.cross(along);
    let foot = place + (offset - normal.dot(place)) * normal;
    let targets: [DVec3; POINTS] =
        std::array::from_fn(|_| foot + size * (rng.range(-4.0, 4.0) * along + rng.range(-4.0, 4.0) * across));
    let (world, lit) = are_lit(&objects, (normal, offset), place, &targets, size);
    let [mut points, mut wrongly_lit, mut textbook, mut wrong_away] = [0; 4];
    for (target, is_lit) in targets.iter().zip(lit) {
        let Some(is_lit) = is_lit else { continue };
        points += 1;
        wrongly_lit += failures.note(is_lit, || format!("69 {index} {target} {place} {objects:?}"));
        // The textbook stops just before the light.
        let way = place - *target;
        let ray = Ray { t_min: 1e-4, t_max: 1.0, ..Ray::new(*target, way) };
        textbook += u64::from(world.crossing(&ray, 0).is_none());
    }
    let speckled = u64::from(textbook > 0 && textbook < points);
    if kind == 1 {
        return ([1, points, wrongly_lit, speckled, 0], []);
    }
    let away = place + size * 10f64.powf(rng.range(-9.0, -1.0)) * rng.direction();
    let (world, lit) = are_lit(&objects, (normal, offset), away, &targets, size);
    for (target, is_lit) in targets.iter().zip(lit) {
        let Some(is_lit) = is_lit else { continue };
        let Some(expected) = is_lit_exactly(&world, *target, away) else { continue };
        wrong_away += failures
            .note(is_lit != expected, || format!("69 {index} {target} {away} {expected} {objects:?}"));
    }
    ([1, points, wrongly_lit, speckled, wrong_away], [])
}

/// Whether the world's first sphere or plane leaves the way from a point to a light free, without rounding; none within
/// a billionth of its rim.
fn is_lit_exactly(world: &World, from: DVec3, light: DVec3) -> Option<bool> {
    let (p, l) = (exact3(from), exact3(light));
    if let Primitive::Plane(_) = world.primitive(0) {
        let plane = &world.planes[0];
        let (n, offset) = (exact3(plane.normal), exact(plane.offset));
        return Some((dot(&n, &p) - &offset).is_positive() == (dot(&n, &l) - &offset).is_positive());
    }
    let raytracer::world::shape::Shape::Sphere(sphere) = &world.shapes[0] else { return None };
    let (c, r) = (exact3(sphere.center), exact(sphere.radius));
    let (f, d) = (sub(&p, &c), sub(&l, &p));
    let (a, b, power) = (dot(&d, &d), -dot(&f, &d), dot(&f, &f) - &r * &r);
    let ends_inside = (dot(&sub(&l, &c), &sub(&l, &c)) - &r * &r).is_negative();
    if power.is_negative() || ends_inside {
        return Some(power.is_negative() && ends_inside);
    }
    let discriminant = &b * &b - &a * &power;
    if discriminant.abs() < &a * &r * &r * exact(1e-9) {
        return None;
    }
    // Both ends are outside: the nearest point of the line is between them, or not.
    Some(discriminant.is_negative() || b.is_negative() || b > a)
}

#[test]
fn case_69_lights_on_surfaces() {
    let inputs = rays(4000, 400_000);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| one(index, &failures));
    let [lights, points, wrongly_lit, speckled, wrong_away] = counts;
    Record {
        case: 69,
        basis: Basis::Sampled,
        name: "light on a sphere, an ellipsoid or a plane, and close to it",
        inputs: format!("{lights} lights, {points} points"),
        measure: "points lit although the light lies on a surface; points whose shadow is not the exact one for a light 1e-9 to 0.1 sizes away",
        textbook: format!("f64, from 1e-4 up to the light: {speckled} lights have lit and dark points"),
        ours: format!("{wrongly_lit}; {wrong_away}"),
        target: "0; 0",
    }
    .write();
    assert!(speckled > lights / 10, "the textbook method does not fail");
    assert!(points > 8 * lights, "{counts:?}");
    assert_eq!([wrongly_lit, wrong_away], [0; 2]);
}
