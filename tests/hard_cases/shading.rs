//! Section F, directions: total reflection, glass without refraction, normal and grazing incidence.

use crate::support::double_double::{self as dd, Dd, Dd3};
use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::{render_picture, scene_of};
use crate::support::{failed_ray, rays};
use glam::{DVec3, Vec3};
use raytracer::math::robust::UNIT_ROUNDOFF;
use raytracer::scene::material::{Material, Pattern, Phong, Texture};
use raytracer::scene::{Camera, Light, Object};
use raytracer::trace::{Effects, Shadows, refracted};

/// The index of refraction of glass relative to air.
const GLASS: f64 = 1.5;

/// A unit vector that meets the surface with the unit normal `normal` at an angle with this sine.
fn incoming(normal: DVec3, sine: f64, rng: &mut Rng) -> DVec3 {
    let along = normal.cross(rng.direction()).normalize();
    (sine * along - (1.0 - sine * sine).sqrt() * normal).normalize()
}

/// The distance from total reflection: the squared sine of the refracted ray minus one. It is computed for
/// the directions as given, whose lengths are one only up to rounding.
fn beyond_critical(direction: DVec3, normal: DVec3, ratio: f64) -> Dd {
    let (d, n) = (dd::vector(direction), dd::vector(normal));
    let c = dd::cross(&d, &n);
    let sine_squared = dd::dot(&c, &c) / (dd::dot(&d, &d) * dd::dot(&n, &n));
    Dd::from(ratio) * ratio.into() * sine_squared - 1.0.into()
}

/// Whether the textbook's formula in f32 decides for total reflection: 1 - eta^2 (1 - c^2) < 0.
fn textbook_reflects(direction: DVec3, normal: DVec3, ratio: f64) -> bool {
    let (d, n, eta): (Vec3, Vec3, f32) = (direction.as_vec3(), normal.as_vec3(), ratio as f32);
    let c = d.dot(n);
    1.0 - eta * eta * (1.0 - c * c) < 0.0
}

#[test]
fn case_53_critical_angle() {
    let inputs = rays(200_000, 50_000_000);
    let failures = Failures::default();
    let (counts, [length]) = measure(inputs, |index| {
        let mut rng = Rng::at(53, index);
        let normal = rng.direction();
        // The sine differs from the critical one by a relative 1e-2 down to its last bits.
        let away = 10f64.powf(rng.range(-16.0, -2.0)) * if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let ratio = if rng.below(2) == 0 { GLASS } else { 1.0 + 10f64.powf(rng.range(-3.0, 0.3)) };
        let direction = incoming(normal, ((1.0 + away) / ratio).min(1.0), &mut rng);
        let beyond = beyond_critical(direction, normal, ratio);
        // The relative difference of the sine is half of that of its square.
        if beyond.value().abs() / 2.0 <= 4.0 * UNIT_ROUNDOFF {
            return ([0; 5], [0.0]);
        }
        let total = beyond.sign() > 0;
        let found = refracted(direction, normal, ratio);
        let textbook = textbook_reflects(direction, normal, ratio);
        let wrong = |reflects: bool| [(reflects && !total) as u64, (!reflects && total) as u64];
        let ([a, b], [c, d]) = (wrong(found.is_none()), wrong(textbook));
        failures.note(a + b > 0, || failed_ray(53, 53, index, normal, direction));
        ([a, b, c, d, 1], [found.map_or(0.0, length_error)])
    });
    let [false_reflection, false_passage, textbook_reflection, textbook_passage, tried] = counts;
    Record {
        case: 53,
        basis: Basis::Sampled,
        name: "critical angle of glass and of ratios 1.001 to 3, from 1e-2 to 4 roundings away",
        inputs: format!("{tried} directions"),
        measure: "false total reflections / false passages; length of the refracted direction off 1, in roundings",
        textbook: format!("1 - eta^2 (1 - c^2) in f32: {textbook_reflection} / {textbook_passage}"),
        ours: format!("{false_reflection} / {false_passage}; {length:.1}"),
        target: "0 / 0 outside 4 roundings; <= 4",
    }
    .write();
    assert!(textbook_reflection > 0 && textbook_passage > 0, "the textbook method does not fail");
    assert_eq!([false_reflection, false_passage], [0, 0]);
    assert!(length <= 4.0);
}

/// The difference of a vector's length from one, in roundings.
fn length_error(v: DVec3) -> f64 {
    let v = dd::vector(v);
    (dd::dot(&v, &v) - 1.0.into()).value().abs() / 2.0 / UNIT_ROUNDOFF
}

/// A picture of a checkered ground, with or without a transparent ball of index 1 in front of it.
fn picture_behind_ball(with_ball: bool) -> Vec<u8> {
    let size = [400, 400];
    let mut objects = vec![Object::Plane { normal: DVec3::Y, offset: -1.0, material: 3 }];
    if with_ball {
        objects.push(Object::Sphere { center: DVec3::new(0.1, 0.2, 0.3), radius: 1.2, material: 1 });
    }
    let light =
        Light::Point { position: DVec3::new(2.0, 5.0, 1.0), color: DVec3::ONE, attenuation: [1.0, 0.1, 0.0] };
    let mut scene = scene_of(objects, vec![light]);
    let clear = Phong { diffuse: DVec3::ZERO, transparent: DVec3::ONE, ..Phong::default() };
    let red = Phong { diffuse: DVec3::new(0.9, 0.2, 0.1), ..Phong::default() };
    scene.materials.extend([clear, red].map(Material::Phong));
    scene.materials.push(Material::Texture(Texture {
        pattern: Pattern::Checkerboard,
        world_to_texture: glam::DAffine3::from_scale(DVec3::splat(3.0)).into(),
        factors: Box::default(),
        children: [0, 2],
    }));
    let (center, direction) = (DVec3::new(0.0, 1.0, 6.0), DVec3::new(0.03, -0.25, -1.0));
    scene.camera = Camera::Perspective { center, direction, up: DVec3::Y, angle: 35.0 };
    let effects = Effects { shadows: Shadows::None, shade_back: true, bounces: 4, min_weight: 0.0 };
    render_picture(&scene, &[], None, size, effects)
}

#[test]
fn case_54_glass_of_index_one() {
    let inputs = rays(100_000, 50_000_000);
    let failures = Failures::default();
    let (counts, [ours, textbook]) = measure(inputs, |index| {
        let mut rng = Rng::at(54, index);
        let normal = rng.direction();
        let direction = incoming(normal, 1.0 - 10f64.powf(rng.range(-14.0, 0.0)), &mut rng);
        let off = |out: DVec3| (out - direction).length() / UNIT_ROUNDOFF;
        let Some(out) = refracted(direction, normal, 1.0) else { return ([1], [0.0; 2]) };
        failures.note(off(out) > 4.0, || failed_ray(54, 54, index, normal, direction));
        ([0], [off(out), off(textbook_refracted(direction, normal, 1.0))])
    });
    let [with, without] = [true, false].map(picture_behind_ball);
    let pixels = with.chunks(3).zip(without.chunks(3)).filter(|(a, b)| a != b).count();
    Record {
        case: 54,
        basis: Basis::Sampled,
        name: "glass of index 1",
        inputs: format!("{inputs} directions, {} pixels", with.len() / 3),
        measure: "directions lost; largest change of a direction in roundings; pixels that a ball of it changes",
        textbook: format!("f32: {textbook:.1e}"),
        ours: format!("{}; {ours:.1}; {pixels}", counts[0]),
        target: "0; <= 4; 0",
    }
    .write();
    assert!(textbook > 1e6, "the textbook method does not fail");
    assert!(counts[0] == 0 && ours <= 4.0 && pixels == 0);
}

/// The textbook's refraction in f32: eta d - (eta d.n + sqrt(1 - eta^2 (1 - c^2))) n.
fn textbook_refracted(direction: DVec3, normal: DVec3, ratio: f64) -> DVec3 {
    let (d, n, eta): (Vec3, Vec3, f32) = (direction.as_vec3(), normal.as_vec3(), ratio as f32);
    let c = -d.dot(n);
    let k = (1.0 - eta * eta * (1.0 - c * c)).max(0.0);
    (eta * d + (eta * c - k.sqrt()) * n).as_dvec3()
}

/// The refracted direction in double-double, for the exact lengths of the directions.
fn exact_refraction(direction: DVec3, normal: DVec3, ratio: f64) -> Dd3 {
    let unit = |v: DVec3| {
        let v = dd::vector(v);
        let length = dd::dot(&v, &v).sqrt();
        v.map(|x| x / length)
    };
    let (d, n) = (unit(direction), unit(normal));
    let along = dd::scaled(&dd::sub(&d, &dd::scaled(&n, dd::dot(&d, &n))), ratio.into());
    let inward = (Dd::from(1.0) - dd::dot(&along, &along)).sqrt();
    dd::sub(&along, &dd::scaled(&n, inward))
}

#[test]
fn case_55_normal_and_grazing_incidence() {
    let inputs = rays(100_000, 20_000_000);
    let failures = Failures::default();
    let (counts, [ours, textbook]) = measure(inputs, |index| {
        let mut rng = Rng::at(55, index);
        let normal = rng.direction();
        let power = 0.5f64.powi(1 + rng.below(60) as i32);
        // A cosine of 2^-k, or one of 1 - 2^-k, which is given by its sine to keep its accuracy.
        let along = normal.cross(rng.direction()).normalize();
        let grazing = rng.below(2) == 0;
        let sine = if grazing { (1.0 - power * power).sqrt() } else { (power * (2.0 - power)).sqrt() };
        let cosine = if grazing { power } else { 1.0 - power };
        let direction = (sine * along - cosine * normal).normalize();
        // Rounding may turn the most grazing direction to the other side.
        if direction.dot(normal) >= 0.0 {
            return ([0], [0.0; 2]);
        }
        let exact = exact_refraction(direction, normal, 1.0 / GLASS);
        let off = |out: DVec3| {
            let error = dd::sub(&dd::vector(out), &exact);
            dd::dot(&error, &error).value().sqrt() / UNIT_ROUNDOFF
        };
        let Some(out) = refracted(direction, normal, 1.0 / GLASS) else { return ([1], [0.0; 2]) };
        failures.note(off(out) > 4.0, || failed_ray(55, 55, index, normal, direction));
        ([!out.is_finite() as u64], [off(out), off(textbook_refracted(direction, normal, 1.0 / GLASS))])
    });
    Record {
        case: 55,
        basis: Basis::Sampled,
        name: "normal and grazing incidence on glass",
        inputs: format!("{inputs} directions with cosines 2^-k and 1 - 2^-k"),
        measure: "directions lost or NaN; largest error of the refracted direction in roundings (reflected and \
                  passed light are colours of the material in the course's model, not Fresnel's terms)",
        textbook: format!("f32: {textbook:.1e}"),
        ours: format!("{}; {ours:.1}", counts[0]),
        target: "0; <= 4",
    }
    .write();
    assert!(textbook > 1e6, "the textbook method does not fail");
    assert!(counts[0] == 0 && ours <= 4.0);
}
