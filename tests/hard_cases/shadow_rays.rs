//! Section D, cases 40 to 42: shadow rays from a surface, at every scale, far from the origin, and under a
//! sheet close above the ground.

use crate::support::double_double::{self as dd, Dd};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::mesh;
use crate::support::occlusion::Occluders;
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::{world_of, world_with};
use crate::support::secondary::blocked;
use crate::support::textbook_offsets::{FIXED, integer_offset};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::{Hit, Ray};
use raytracer::scene::Object;
use raytracer::scene::mesh::Mesh;
use raytracer::world::{SurfacePoint, World};

/// The rabbit on a plane, scaled and translated, with what determines its shadows.
struct Stage {
    world: World,
    occluders: Occluders,
    ground: f64,
    extent: f64,
    middle: DVec3,
}

fn stage(scale: f64, shift: DVec3) -> Stage {
    let Mesh { vertices, triangles } = mesh("bunny_40k.obj");
    let vertices: Vec<DVec3> = vertices.into_iter().map(|v| scale * v + shift).collect();
    let ground = vertices.iter().map(|v| v.y).fold(f64::INFINITY, f64::min);
    let corners = triangles.iter().map(|t| t.map(|i| vertices[i as usize])).collect();
    let objects = vec![
        Object::Mesh { mesh: 0, material: 0 },
        Object::Plane { normal: DVec3::Y, offset: ground, material: 0 },
    ];
    let world = world_with(objects, vec![], &[Mesh { vertices, triangles }]);
    let extent = world.bounds.extent().max_element();
    let middle = (world.bounds.min + world.bounds.max) / 2.0;
    Stage { world, occluders: Occluders::new(corners), ground, extent, middle }
}

/// Whether a shadow ray is blocked: exactly, by ours, and from an f32 point with a fixed t_min and with the
/// integer offset.
struct Shadow {
    truth: bool,
    found: [bool; 3],
}

impl Stage {
    /// A ray from around the stage towards its middle, and a direction that leaves the surface on the side it
    /// hits: a random one, or in half of the cases one almost parallel to the surface.
    fn draw(&self, caster: &Caster, rng: &mut Rng) -> Option<(Ray, Hit, SurfacePoint, DVec3)> {
        let out = rng.direction();
        let eye = self.middle + 2.0 * self.extent * DVec3::new(out.x, out.y.abs() + 0.1, out.z);
        let target = self.middle + 0.6 * self.extent * rng.in_cube();
        let ray = Ray::new(eye, (target - eye).normalize());
        let hit = caster.closest(&ray)?;
        let surface = self.world.surface(&ray, &hit);
        let side = if surface.normal.dot(ray.direction) < 0.0 { surface.normal } else { -surface.normal };
        let along = side.cross(rng.direction()).normalize();
        let cosine = 10f64.powf(rng.range(-4.0, -1.0));
        let anywhere = rng.direction();
        let half = anywhere * anywhere.dot(side).signum();
        let direction = if rng.below(2) == 0 { half } else { (along + cosine * side).normalize() };
        Some((ray, hit, surface, direction))
    }

    /// Whether anything blocks `direction` from the exact point that `ray` hits; none where this is too close
    /// to decide.
    fn truth(&self, ray: &Ray, hit: Hit, direction: DVec3) -> Option<bool> {
        if hit.primitive == self.world.first_plane() {
            let (o, d) = (dd::vector(ray.origin), dd::vector(ray.direction));
            let t = (Dd::from(self.ground) - o[1]) / d[1];
            let mut point = dd::add(&o, &dd::scaled(&d, t));
            point[1] = self.ground.into();
            return self.occluders.block(&point, direction, None);
        }
        let point = self.occluders.point_on(hit.primitive, ray.origin, ray.direction);
        if direction.y < 0.0 {
            return Some(true);
        }
        self.occluders.block(&point, direction, Some(hit.primitive))
    }

    fn shadow(&self, caster: &Caster, rng: &mut Rng) -> Option<Shadow> {
        let (ray, hit, surface, direction) = self.draw(caster, rng)?;
        let truth = self.truth(&ray, hit, direction)?;
        let side = surface.normal * surface.normal.dot(direction).signum();
        let [fixed, integer] = [
            Ray { t_min: FIXED, ..Ray::new(ray.at(hit.t).as_vec3().as_dvec3(), direction) },
            Ray::new(integer_offset(ray.at(hit.t).as_vec3(), side.as_vec3()).as_dvec3(), direction),
        ]
        .map(|r| caster.any(&r, RayOrigin::FREE));
        Some(Shadow { truth, found: [blocked(caster, &surface, direction), fixed, integer] })
    }
}

/// Counts over many shadow rays: those that were decided, and for each method the false and the missed
/// shadows.
fn acne(case: u32, seed: u64, inputs: u64, scale: f64, shift: DVec3) -> [u64; 7] {
    let stage = stage(scale, shift);
    let caster = Caster::new(&stage.world, Some([60; 3])).expect("a grid");
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let Some(shadow) = stage.shadow(&caster, &mut Rng::at(seed, index)) else { return ([0; 7], []) };
        let [ours, ..] = shadow.found;
        failures.note(ours != shadow.truth, || {
            let drawn = stage.draw(&caster, &mut Rng::at(seed, index));
            let (ray, _, _, out) = drawn.expect("it was drawn before");
            let text = failed_ray(case, seed, index, ray.origin, ray.direction);
            format!("{text}, shadow ray {out:?}, truth {}", shadow.truth)
        });
        let wrong = |found: bool, truth: bool| [(found && !truth) as u64, (!found && truth) as u64];
        let [a, b, c] = shadow.found.map(|found| wrong(found, shadow.truth));
        ([1, a[0], a[1], b[0], b[1], c[0], c[1]], [])
    });
    assert!(counts[0] > inputs / 3, "too few rays hit");
    counts
}

#[test]
fn case_40_shadows_at_every_scale() {
    let inputs = rays(40_000, 4_000_000);
    let (mut texts, mut total) = (vec![], [0; 7]);
    for (k, scale) in [1e-6, 1e-3, 1.0, 1e3, 1e6].into_iter().enumerate() {
        let counts = acne(40, 4000 + k as u64, inputs, scale, DVec3::ZERO);
        let [_, _, _, fixed_false, fixed_missed, integer_false, integer_missed] = counts;
        texts.push(format!("{scale:e}: {fixed_false}/{fixed_missed}, {integer_false}/{integer_missed}"));
        total = std::array::from_fn(|i| total[i] + counts[i]);
        assert!(fixed_false + fixed_missed > 0, "the textbook method does not fail at {scale}");
    }
    Record {
        case: 40,
        basis: Basis::Proved,
        name: "acne, scale sweep",
        inputs: format!("{} shadow rays at 5 scales", total[0]),
        measure: "false/missed shadows",
        textbook: format!(
            "f32 points with t_min 1e-4, with the Waechter-Binder offset; {}",
            texts.join("; ")
        ),
        ours: format!("{}/{}", total[1], total[2]),
        target: "0/0 at every scale",
    }
    .write();
    assert_eq!([total[1], total[2]], [0, 0]);
}

#[test]
fn case_41_shadows_far_from_the_origin() {
    let inputs = rays(60_000, 5_000_000);
    let (mut texts, mut total) = (vec![], [0; 7]);
    for (k, shift) in [1e2, 1e4].into_iter().enumerate() {
        let counts = acne(41, 4100 + k as u64, inputs, 1.0, DVec3::splat(shift));
        let [_, _, _, fixed_false, fixed_missed, integer_false, integer_missed] = counts;
        texts.push(format!("+{shift:e}: {fixed_false}/{fixed_missed}, {integer_false}/{integer_missed}"));
        total = std::array::from_fn(|i| total[i] + counts[i]);
        assert!(integer_false + integer_missed > 0, "the textbook method does not fail at {shift}");
    }
    Record {
        case: 41,
        basis: Basis::Proved,
        name: "acne, translated",
        inputs: format!("{} shadow rays at 2 places", total[0]),
        measure: "false/missed shadows",
        textbook: format!(
            "f32 points with t_min 1e-4, with the Waechter-Binder offset; {}",
            texts.join("; ")
        ),
        ours: format!("{}/{}", total[1], total[2]),
        target: "0/0",
    }
    .write();
    assert_eq!([total[1], total[2]], [0, 0]);
}

/// A square sheet of side 2, `gap` above the ground.
fn sheet(height: f64, gap: f64, as_triangles: bool) -> World {
    let corner = |x: f64, z: f64, y: f64, size: f64| DVec3::new(size * x, y, size * z);
    let square = |y: f64, size: f64| {
        let [a, b, c, d] =
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| corner(x, z, y, size));
        [[a, b, c], [a, c, d]].map(|vertices| Object::Triangle { vertices, material: 0 })
    };
    let ground = Object::Plane { normal: DVec3::Y, offset: height, material: 0 };
    let mut objects: Vec<Object> = square(height + gap, 1.0).into();
    if as_triangles {
        objects.extend(square(height, 3.0))
    } else {
        objects.push(ground)
    };
    world_of(objects)
}

#[test]
fn case_42_contact_gaps() {
    let inputs = rays(10_000, 1_000_000);
    let mut lost = [0; 4];
    let mut smallest_kept = [1.0f64; 4];
    for exponent in 2..=12 {
        let gap = 10f64.powi(-exponent);
        let mut here = [0; 4];
        for (k, height) in [0.0, 1.0].into_iter().enumerate() {
            for as_triangles in [false, true] {
                let world = sheet(height, gap, as_triangles);
                let seed = 4200 + 4 * exponent as u64 + 2 * k as u64 + as_triangles as u64;
                let counts = gap_shadows(&world, height, inputs, seed);
                here = std::array::from_fn(|i| here[i] + counts[i]);
            }
        }
        for i in 0..4 {
            lost[i] += here[i];
            if here[i] == 0 {
                smallest_kept[i] = smallest_kept[i].min(gap);
            }
        }
    }
    Record {
        case: 42,
        basis: Basis::Sampled,
        name: "contact gap, 1e-2 to 1e-12 under a sheet",
        inputs: format!("{} shadow rays at 11 gaps", 44 * inputs),
        measure: "lost or false shadows",
        textbook: format!(
            "t_min 1e-3: {} lost, none only down to {:e}; t_min 1e-4: {}, {:e}; Waechter-Binder: {}, {:e}",
            lost[1], smallest_kept[1], lost[2], smallest_kept[2], lost[3], smallest_kept[3]
        ),
        ours: format!("{}", lost[0]),
        target: "0 down to 1e-12 of the extent",
    }
    .write();
    assert!(lost[1..].iter().all(|&n| n > 0), "the textbook method does not fail");
    assert_eq!(lost[0], 0);
}

/// Wrong shadows on the ground below and beside a sheet: ours, with a t_min of 1e-3 and of 1e-4, and with the
/// integer offset. The light comes from above at less than 80 degrees from the vertical.
fn gap_shadows(world: &World, height: f64, inputs: u64, seed: u64) -> [u64; 4] {
    let caster = Caster::new(world, Some([5, 1, 5])).expect("a grid");
    let failures = Failures::default();
    let (counts, []) = measure(inputs, |index| {
        let mut rng = Rng::at(seed, index);
        let covered = rng.below(2) == 0;
        let across = if covered { 0.9 } else { 2.9 } * rng.in_cube();
        let beside = !covered && across.x.abs().max(across.z.abs()) > 1.1;
        if covered == beside {
            return ([0; 4], []);
        }
        // The point is seen from below, where nothing is in the way.
        let eye = DVec3::new(rng.range(-1.0, 1.0), height - 2.0, rng.range(-1.0, 1.0));
        let ray = Ray::new(eye, DVec3::new(across.x, height, across.z) - eye);
        let hit = caster.closest(&ray).expect("the ground");
        let surface = world.surface(&ray, &hit);
        let (sine, cosine) = rng.range(0.0, std::f64::consts::TAU).sin_cos();
        let tangent = rng.range(0.0, if covered { 5.6 } else { 0.05 });
        // The light is not so slanted that it passes the sheet's border.
        let slant = if covered { tangent.min(0.05 / 1e-2) } else { tangent };
        let direction = DVec3::new(slant * cosine, 1.0, slant * sine).normalize();
        let up = DVec3::Y;
        let [a, b, c] = [
            Ray { t_min: 1e-3, ..Ray::new(ray.at(hit.t), direction) },
            Ray { t_min: FIXED, ..Ray::new(ray.at(hit.t), direction) },
            Ray::new(integer_offset(ray.at(hit.t).as_vec3(), up.as_vec3()).as_dvec3(), direction),
        ]
        .map(|r| caster.any(&r, RayOrigin::FREE));
        let wrong = [blocked(&caster, &surface, direction), a, b, c].map(|b| (b != covered) as u64);
        failures.note(wrong[0] > 0, || failed_ray(42, seed, index, ray.origin, ray.direction));
        (wrong, [])
    });
    counts
}
