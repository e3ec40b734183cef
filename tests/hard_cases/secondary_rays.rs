//! Section D, cases 43 and 46: paths of refracted rays through thin shells of glass, and of reflected rays
//! between two mirrors.

use crate::support::double_double::{self as dd, Dd};
use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of;
use crate::support::secondary::secondary;
use crate::support::textbook_offsets::FIXED;
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::scene::Object;
use raytracer::trace::{reflected, refracted};
use raytracer::world::{SurfacePoint, World};

/// Indices of refraction: air, then glass, then the material of the inner sphere.
const INDICES: [f64; 3] = [1.0, 1.5, 1.2];

/// The surfaces that a ray crosses, 0 for the outer sphere and 1 for the inner one, in closed form: in
/// concentric spheres the product of the index and the distance of the ray's line from the centre is constant
/// (Bouguer). None for rays within 1e-7 of a tangent of the inner sphere or of total reflection at it.
fn shell_path(impact: f64, inner: f64) -> Option<Vec<u32>> {
    let [_, glass, core] = INDICES;
    let (in_glass, in_core) = (impact / glass, impact / core);
    if (in_glass - inner).abs() < 1e-7 || (in_core - inner).abs() < 1e-7 {
        return None;
    }
    Some(if in_glass > inner {
        vec![0, 0]
    } else if in_core > inner {
        // At total reflection the path of the transmitted light ends.
        vec![0, 1]
    } else {
        vec![0, 1, 1, 0]
    })
}

/// The surfaces that a ray crosses, followed as in the tracer. `next` returns the ray that continues behind a
/// surface.
fn followed(world: &World, ray: Ray, next: impl Fn(&SurfacePoint, DVec3) -> Ray) -> Vec<u32> {
    let caster = Caster::new(world, None).expect("no grid");
    let (mut ray, mut path, mut inside) = (ray, vec![], 0usize);
    while let Some(hit) = caster.closest(&ray) {
        path.push(hit.primitive);
        let surface = world.surface(&ray, &hit);
        let entering = surface.normal.dot(ray.direction) < 0.0;
        let normal = if entering { surface.normal } else { -surface.normal };
        let behind = if entering { hit.primitive as usize + 1 } else { hit.primitive as usize };
        let Some(direction) = refracted(ray.direction, normal, INDICES[inside] / INDICES[behind]) else {
            break;
        };
        inside = behind;
        ray = next(&surface, direction);
        if path.len() > 8 {
            break;
        }
    }
    path
}

#[test]
fn case_43_shells_of_glass() {
    let inputs = rays(50_000, 5_000_000);
    let (mut ours, mut textbook) = (0, 0);
    for (k, thickness) in [1e-6, 1e-9].into_iter().enumerate() {
        let sphere = |radius| Object::Sphere { center: DVec3::ZERO, radius, material: 0 };
        let world = world_of(vec![sphere(1.0), sphere(1.0 - thickness)]);
        let failures = Failures::default();
        let seed = 4300 + k as u64;
        let (counts, []) = measure(inputs, |index| {
            let mut rng = Rng::at(seed, index);
            let (away, impact) = (rng.direction(), rng.unit());
            let across = away.cross(rng.direction()).normalize();
            let ray = Ray::new(3.0 * away + impact * across, -away);
            let Some(expected) = shell_path(impact, 1.0 - thickness) else { return ([0; 2], []) };
            let path = followed(&world, ray, secondary);
            let plain =
                followed(&world, ray, |surface, d| Ray { t_min: FIXED, ..Ray::new(surface.position, d) });
            failures.note(path != expected, || {
                format!("{} {path:?}", failed_ray(43, seed, index, ray.origin, ray.direction))
            });
            ([(path != expected) as u64, (plain != expected) as u64], [])
        });
        ours += counts[0];
        textbook += counts[1];
    }
    Record {
        case: 43,
        basis: Basis::Sampled,
        name: "nested shells of glass, 1e-6 and 1e-9 thick",
        inputs: format!("{} refracted paths", 2 * inputs),
        measure: "paths that meet other surfaces, or in another order, than the closed form",
        textbook: format!("t_min 1e-4: {textbook}"),
        ours: ours.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!(ours, 0);
}

/// The deviation of the path between two mirrors, at y = 0 and y = 1, from the closed form after many
/// bounces: ours in units of the mirrors' distance for paths that advance by less than 1/100 per bounce, ours
/// relative to the length of the path, and that of an f32 path in units of the distance.
///
/// For other paths an absolute 1e-10 cannot be reached with positions stored as floats: adding the same step
/// to a coordinate around 1000 has the same rounding error each time, up to 6e-14, and 1e4 bounces add up to
/// 6e-10.
fn mirror_error(rng: &mut Rng, bounces: u64) -> ([u64; 0], [f64; 3]) {
    let plane = |offset| Object::Plane { normal: DVec3::Y, offset, material: 0 };
    let world = world_of(vec![plane(0.0), plane(1.0)]);
    let caster = Caster::new(&world, None).expect("no grid");
    let (sine, cosine) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
    let slope = 10f64.powf(rng.range(-3.0, 0.0));
    let start =
        Ray::new(DVec3::new(0.0, 0.25, 0.0), DVec3::new(slope * cosine, -1.0, slope * sine).normalize());
    let (mut ray, mut place) = (start, DVec3::ZERO);
    let (mut place32, mut direction32) = (start.origin.as_vec3(), start.direction.as_vec3());
    for _ in 0..bounces {
        let hit = caster.closest(&ray).expect("a mirror");
        let surface = world.surface(&ray, &hit);
        place = surface.position;
        ray = secondary(&surface, reflected(ray.direction, surface.normal));
        let to = if direction32.y < 0.0 { -place32.y } else { 1.0 - place32.y };
        place32 += to / direction32.y * direction32;
        direction32.y = -direction32.y;
        place32 += 1e-4 * direction32;
    }
    // The unfolded path: 1/4 down to the first mirror, then 1 for each bounce.
    let height = Dd::from(0.25) + Dd::from((bounces - 1) as f64);
    let d = dd::vector(start.direction);
    let exact = [0, 2].map(|axis| d[axis] * height / -d[1]);
    let distance = |p: DVec3| (Dd::from(p.x) - exact[0]).value().hypot((Dd::from(p.z) - exact[1]).value());
    let length = height.value() / -start.direction.y;
    let ours = distance(place);
    ([], [if slope < 0.01 { ours } else { 0.0 }, ours / length, distance(place32.as_dvec3())])
}

#[test]
fn case_46_mirror_hall() {
    const BOUNCES: u64 = 10_000;
    let inputs = rays(100, 10_000);
    let (_, [ours, relative, textbook]) =
        measure(inputs, |index| mirror_error(&mut Rng::at(46, index), BOUNCES));
    Record {
        case: 46,
        basis: Basis::Sampled,
        name: "two parallel mirrors, 10000 bounces",
        inputs: format!("{} bounces", inputs * BOUNCES),
        measure: "largest error, in units of the mirrors' distance; relative to the path's length for all slopes up to 45 degrees",
        textbook: format!("f32 with an offset of 1e-4 along the ray: {textbook:.1e}"),
        ours: format!("{ours:.1e}; {relative:.1e}"),
        target: "<= 1e-10",
    }
    .write();
    assert!(textbook > 1e-2, "the textbook method does not fail");
    assert!(ours <= 1e-10 && relative <= 1e-10);
}
