//! Section D, lights: close to a surface, on it and behind it; and the terminator of a coarse mesh.

use crate::support::double_double::{self as dd, Dd};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::unit_icosphere;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_with;
use crate::support::{failed_ray, rays};
use glam::{DVec3, Vec3};
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::scene::{Light, Object};
use raytracer::trace::Quiet;
use raytracer::trace::{Effects, RayStack, Shadows, Tracer};

fn point_light(position: DVec3) -> Light {
    Light::Point { position, color: DVec3::ONE, attenuation: [1.0, 0.0, 0.0] }
}

/// The colour that a ray returns in a world of one object and one light, with hard shadows and both sides
/// lit.
fn seen(object: &Object, light: Light, ray: &Ray) -> DVec3 {
    let world = world_with(vec![object.clone()], vec![light], &[]);
    let caster = Caster::new(&world, None).expect("no grid");
    let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 0, min_weight: 0.0 };
    caster.closest(ray).expect("the ray is aimed at the object");
    Tracer::new(&caster, effects).color(ray, &mut RayStack::default(), &mut Quiet)
}

/// A plane of any orientation, two unit vectors along it, and one of its points.
fn any_plane(rng: &mut Rng) -> (Object, DVec3, [DVec3; 2], DVec3) {
    let normal = rng.direction();
    let along = normal.cross(rng.direction()).normalize();
    let across = normal.cross(along);
    let offset = rng.range(-3.0, 3.0);
    let foot = offset * normal + rng.range(-3.0, 3.0) * along;
    (Object::Plane { normal, offset, material: 0 }, normal, [along, across], foot)
}

/// A light 1e-9 above a plane, and the colour at a point up to 10 away. Returns whether ours misses the
/// light, whether an f32 tracer does, and our relative error.
fn light_above_plane(rng: &mut Rng) -> ([u64; 2], f64, Ray) {
    let (object, normal, [along, across], foot) = any_plane(rng);
    let position = foot + 1e-9 * normal;
    let distance = 10f64.powf(rng.range(-6.0, 1.0));
    let target = foot + distance * along;
    let eye = target + 2.0 * normal + rng.range(-1.0, 1.0) * across;
    let ray = Ray::new(eye, (target - eye).normalize());
    let color = seen(&object, point_light(position), &ray).x;
    let Object::Plane { offset, .. } = object else { unreachable!("a plane") };
    let height = dd::dot(&dd::vector(normal), &dd::vector(position)) - Dd::from(offset);
    let expected = height.value() / distance.hypot(height.value());
    let unlit = textbook_unlit(&ray, normal, offset, position);
    ([(color == 0.0) as u64, unlit as u64], (color - expected).abs() / expected, ray)
}

/// Whether an f32 tracer with a t_min of 1e-4 takes the plane to be in shadow.
fn textbook_unlit(ray: &Ray, normal: DVec3, offset: f64, light: DVec3) -> bool {
    let (n, o, d): (Vec3, Vec3, Vec3) = (normal.as_vec3(), ray.origin.as_vec3(), ray.direction.as_vec3());
    let point = o + (offset as f32 - n.dot(o)) / n.dot(d) * d;
    let to_light = light.as_vec3() - point;
    let t = (offset as f32 - n.dot(point)) / n.dot(to_light.normalize());
    n.dot(to_light) <= 0.0 || (t > 1e-4 && t < to_light.length())
}

/// The colour of a plane with a light exactly in its surface, in half of the cases at the very point that is
/// shaded.
fn light_in_plane(rng: &mut Rng) -> (DVec3, Ray) {
    let height = (rng.below(64) as f64 - 32.0) / 8.0;
    let object = Object::Plane { normal: DVec3::Y, offset: height, material: 0 };
    let on_plane = |p: DVec3| DVec3::new(p.x, height, p.z);
    let target = on_plane(3.0 * rng.in_cube());
    let position = if rng.below(2) == 0 { target } else { on_plane(3.0 * rng.in_cube()) };
    let ray = Ray::new(target + 2.0 * DVec3::Y, -DVec3::Y);
    (seen(&object, point_light(position), &ray), ray)
}

/// A light inside a sphere: the colour seen from outside, and our relative error seen from inside.
fn light_in_sphere(rng: &mut Rng) -> (DVec3, f64, Ray) {
    let radius = 10f64.powf(rng.range(-3.0, 3.0));
    let center = 10.0 * radius * rng.in_cube();
    let object = Object::Sphere { center, radius, material: 0 };
    let [eye, position] = [0; 2].map(|_| center + 0.99 * radius * rng.in_ball());
    let inner = Ray::new(eye, rng.direction());
    let outer = Ray::new(center + 3.0 * radius * inner.direction, -inner.direction);
    // The surface point in plain f64, which is accurate enough to tell shadow from light.
    let f = eye - center;
    let b = f.dot(inner.direction);
    let point = eye + ((b * b - f.length_squared() + radius * radius).sqrt() - b) * inner.direction;
    let expected = ((center - point) / radius).dot((position - point).normalize());
    let [inside, outside] = [inner, outer].map(|ray| seen(&object, point_light(position), &ray));
    (outside, (inside.x - expected).abs(), inner)
}

#[test]
fn case_44_lights_at_surfaces() {
    let inputs = rays(40_000, 4_000_000);
    let failures = Failures::default();
    let (counts, worst) = measure(inputs, |index| {
        let mut rng = Rng::at(44, index);
        let ([unlit, textbook], error, ray) = light_above_plane(&mut rng);
        let (in_plane, _) = light_in_plane(&mut rng);
        let (outside, inside, _) = light_in_sphere(&mut rng);
        let black = |c: DVec3| (c != DVec3::ZERO) as u64;
        let wrong = [unlit, black(in_plane), black(outside)];
        failures.note(wrong != [0; 3] || error > 1e-4 || inside > 1e-9, || {
            format!("{} {wrong:?} {error} {inside}", failed_ray(44, 44, index, ray.origin, ray.direction))
        });
        ([unlit, black(in_plane), black(outside), textbook], [error, inside])
    });
    let [unlit, in_plane, outside, textbook] = counts;
    Record {
        case: 44,
        basis: Basis::Sampled,
        name: "light 1e-9 above a plane, in a plane, inside a sphere",
        inputs: format!("{} points", 4 * inputs),
        measure: "points wrongly dark / wrongly lit or NaN; errors of the lit ones' cosine above the plane, in the sphere",
        textbook: format!("f32 with t_min 1e-4: {textbook} wrongly dark above the plane"),
        ours: format!("{unlit} / {}; {:.1e}, {:.1e}", in_plane + outside, worst[0], worst[1]),
        target: "0 / 0; no NaN",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!([unlit, in_plane, outside], [0; 3]);
    // A shadow would be an error of 1. The height of 1e-9 is accurate to 1e-6 of itself.
    assert!(worst[0] < 1e-4 && worst[1] < 1e-9);
}

/// The shading of a point of a coarse sphere: lit by its flat and by its interpolated normal, and occluded
/// from the light at its own position and at the rounded position of Hanika ("Hacking the Shadow Terminator",
/// Ray Tracing Gems II, ch. 4).
struct Terminator {
    flat_dark: bool,
    smooth_lit: bool,
    blocked: bool,
    blocked_from_rounded: bool,
}

fn terminator(caster: &Caster, to_light: DVec3, ray: &Ray) -> Option<Terminator> {
    let hit = caster.closest(ray)?;
    let world = caster.world;
    let surface = world.surface(ray, &hit);
    let corners = world.corners(hit.primitive as usize);
    let weights = barycentric(corners, surface.position);
    let normals = corners.map(DVec3::normalize);
    let mixed = |of: [DVec3; 3]| (0..3).map(|i| weights[i] * of[i]).sum::<DVec3>();
    let lifted = [0, 1, 2].map(|i| {
        let below = (surface.position - corners[i]).dot(normals[i]).min(0.0);
        surface.position - below * normals[i]
    });
    let lit = |normal: DVec3| normal.dot(to_light) > 0.0;
    let blocked =
        |from: DVec3| caster.any(&Ray::new(from + 1e-9 * surface.normal, to_light), RayOrigin::FREE);
    let flat_lit = lit(surface.normal);
    let effects = Effects { shadows: Shadows::Opaque, shade_back: false, bounces: 0, min_weight: 0.0 };
    let color = Tracer::new(caster, effects).color(ray, &mut RayStack::default(), &mut Quiet);
    Some(Terminator {
        flat_dark: flat_lit && color == DVec3::ZERO,
        smooth_lit: lit(mixed(normals)),
        blocked: blocked(surface.position),
        blocked_from_rounded: blocked(mixed(lifted)),
    })
}

fn barycentric([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    [(b, c), (c, a), (a, b)].map(|(q, r)| (q - p).cross(r - p).dot(normal) / area)
}

#[test]
fn case_45_terminator() {
    let inputs = rays(100_000, 10_000_000);
    let angle = 85f64.to_radians();
    // The cameras look along -z.
    let to_light = DVec3::new(angle.sin(), 0.0, angle.cos());
    let light = Light::Directional { direction: -to_light, color: DVec3::ONE };
    let objects = vec![Object::Mesh { mesh: 0, material: 0 }];
    let world = world_with(objects, vec![light], &[unit_icosphere(1)]);
    let caster = Caster::new(&world, None).expect("no grid");
    let (counts, []) = measure(inputs, |index| {
        let mut rng = Rng::at(45, index);
        let ray = Ray::new(DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), 3.0), -DVec3::Z);
        let Some(t) = terminator(&caster, to_light, &ray) else { return ([0; 4], []) };
        let dark = |blocked: bool| (t.smooth_lit && blocked) as u64;
        ([1, t.flat_dark as u64, dark(t.blocked), dark(t.blocked_from_rounded)], [])
    });
    let [hits, ours, smooth, hanika] = counts;
    Record {
        case: 45,
        basis: Basis::Sampled,
        name: "terminator of an icosahedron divided once",
        inputs: format!("{hits} points"),
        measure: "points that face the light and are dark",
        textbook: format!("interpolated normals: {smooth}, with Hanika's offset {hanika}"),
        ours: format!("flat normals, as in the course: {ours}"),
        target: "report only",
    }
    .write();
    assert!(smooth > 0, "the textbook method does not fail");
    assert_eq!(ours, 0, "a convex body shadows itself");
}
