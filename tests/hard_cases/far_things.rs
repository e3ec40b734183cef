//! Case 68: the shadows where things touch, beside a thing that is far away or reaches far away. Only the error of a
//! surface's own points may move the rays that leave it.

use crate::support::exact::{dot, exact, exact3, sub};
use crate::support::measure::{Failures, measure};
use crate::support::rays;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::scene_of;
use crate::support::secondary::blocked;
use glam::{DAffine3, DVec3};
use num_traits::Signed;
use raytracer::caster::choose::Layout;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::{Object, Position};
use raytracer::world::World;

/// Something whose nearest point is up to 1e30 away, below the ground or beside everything.
fn far_thing(rng: &mut Rng) -> Vec<Object> {
    let distance = 10f64.powf(rng.range(6.0, 30.0));
    let down = DVec3::new(rng.range(-1.0, 1.0), -rng.range(0.2, 1.0), rng.range(-1.0, 1.0));
    let center = distance * down.normalize();
    let (material, at) = (0, Position { line: 1, column: 1 });
    match rng.below(4) {
        0 => vec![Object::Sphere { center, radius: 1.0, material }],
        1 => {
            let corner = || center + DVec3::new(1.0, 2.0, 0.0);
            vec![Object::Triangle { vertices: [center, corner(), center + DVec3::Z * distance], material }]
        }
        2 => {
            let matrix = DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::new(1.0, 2.0, 3.0));
            vec![
                Object::Sphere { center: DVec3::ZERO, radius: 1.0, material },
                Object::Transform { matrix: matrix.into(), factors: Box::default(), child: 0, at },
            ]
        }
        // It begins near by, below the ground.
        _ => {
            let near = DVec3::new(rng.range(-1.0, 1.0), -3.0, rng.range(-1.0, 1.0));
            vec![Object::Triangle { vertices: [near, near + DVec3::X, center], material }]
        }
    }
}

/// The ground at y = 0, and whether it reaches far away: a plane, two triangles, or a ball whose top is at `top`.
fn ground(rng: &mut Rng, size: f64, top: DVec3) -> (Vec<Object>, bool) {
    let material = 0;
    let (far, kind) = (10f64.powf(rng.range(1.0, 14.0)), rng.below(4));
    match kind {
        0 => (vec![Object::Plane { normal: DVec3::Y, offset: 0.0, material }], false),
        1 | 2 => {
            let size = if kind == 1 { size } else { far * size };
            let corner = |x: f64, z: f64| size * DVec3::new(x, 0.0, z);
            let [a, b, c, d] = [corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0)];
            ([[a, b, c], [a, c, d]].map(|vertices| Object::Triangle { vertices, material }).into(), kind == 2)
        }
        _ => {
            let radius = 1e6 * far * size;
            (vec![Object::Sphere { center: top - radius * DVec3::Y, radius, material }], true)
        }
    }
}

/// Points of the ground near the spot where a ball touches it, as the world computes them, and the sun's direction. Counts
/// them, those in the shadow, and wrong shadows: ours, and with the offset by the world's largest coordinate.
fn one(index: u64, failures: &Failures) -> ([u64; 4], [f64; 0]) {
    let mut rng = Rng::at(68, index);
    let scale = 10f64.powf(rng.range(-3.0, 3.0));
    let radius = scale * rng.range(0.1, 1.0);
    let touched = scale * DVec3::new(rng.range(-2.0, 2.0), 0.0, rng.range(-2.0, 2.0));
    let ball = Object::Sphere { center: touched + radius * DVec3::Y, radius, material: 0 };
    let mut objects = far_thing(&mut rng);
    let is_transformed = objects.len() == 2;
    let (ground, is_far) = ground(&mut rng, 8.0 * scale, touched);
    objects.extend(ground);
    objects.push(ball);
    let mut scene = scene_of(objects, vec![]);
    if is_transformed && let Object::Group(children) = &mut scene.objects[scene.root] {
        // The child of the transform is not an object of the group itself.
        children.remove(0);
    }
    let world = World::new(&scene, &[]).expect("a sound scene");
    let layout = if rng.below(2) == 0 { Layout::List } else { Layout::Grid([3, 4, 5]) };
    let caster = Caster::with(&world, layout, raytracer::math::instructions::available()[0]).expect("a grid");
    let mut counts = [0; 4];
    for _ in 0..8 {
        // The gap between the ground and the ball is about half of the square of this. A point of ground that reaches a
        // million times as far has an error of about 1e-8.
        let away = radius * 10f64.powf(rng.range(if is_far { -2.0 } else { -5.0 }, 0.5));
        let (sine, cosine) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
        let target = touched + away * DVec3::new(cosine, 0.0, sine);
        let to_eye = DVec3::new(cosine, rng.range(0.05, 1.0), sine).normalize();
        let ray = Ray::new(target + 5.0 * scale * to_eye, -to_eye);
        let Some(hit) = caster.closest(&ray) else { continue };
        let surface = world.surface(&ray, &hit);
        // The ball is the last of the shapes.
        if hit.primitive + 1 == world.first_plane() {
            continue;
        }
        let direction =
            DVec3::new(rng.range(-1.0, 1.0), rng.range(0.0, 1.0), rng.range(-1.0, 1.0)).normalize();
        // Whether the line meets the ball, and how far from its rim.
        let (f, d, r) = (
            sub(&exact3(surface.position), &exact3(touched + radius * DVec3::Y)),
            exact3(direction),
            exact(radius),
        );
        let (a, b) = (dot(&d, &d), -dot(&f, &d));
        let discriminant = &b * &b - &a * (dot(&f, &f) - &r * &r);
        let rim = &r * &r * exact(1e-9);
        if discriminant.abs() < rim {
            continue;
        }
        let is_in_shadow = b.is_positive() && discriminant.is_positive();
        let is_blocked = blocked(&caster, &surface, direction);
        let wrong = failures.note(is_blocked != is_in_shadow, || {
            format!("68 {index} {} {direction} {is_in_shadow} {scene:?}", surface.position)
        });
        let by_world = 32.0 * UNIT_ROUNDOFF * (surface.position.abs().max_element() + world.max_abs_coord);
        let from = surface.position + by_world * DVec3::Y;
        let textbook = caster.any(&Ray::new(from, direction), RayOrigin::FREE) != is_in_shadow;
        let found = [1, is_in_shadow as u64, wrong, textbook as u64];
        counts = std::array::from_fn(|k| counts[k] + found[k]);
    }
    (counts, [])
}

#[test]
fn case_68_far_things() {
    let inputs = rays(10_000, 1_000_000);
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| one(index, &failures));
    let [points, in_shadow, wrong, textbook] = counts;
    Record {
        case: 68,
        basis: Basis::Proved,
        name: "contact shadows beside things that are or reach 1e6 to 1e30 away",
        inputs: format!("{points} points of the ground, {in_shadow} of them in the shadow"),
        measure: "false and lost shadows",
        textbook: format!("an offset by the largest coordinate of the world: {textbook}"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > points / 10, "the textbook method does not fail");
    assert!(points > 2 * inputs && in_shadow > points / 10, "{counts:?}");
    assert_eq!(wrong, 0);
}
