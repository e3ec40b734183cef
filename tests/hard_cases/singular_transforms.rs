//! Section E, case 48: transforms that flatten, wholly or almost, and which of them are refused.

use crate::support::double_double::{self as dd, Dd, Dd3};
use crate::support::exact::{dot, exact3};
use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::{failed_ray, rays};
use crate::transforms::{ROUNDING, length, nested, rotation};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use num_rational::BigRational;
use num_traits::ToPrimitive;
use raytracer::caster::Caster;
use raytracer::diagnostic::Diagnostic;
use raytracer::math::ray::{Ray, Visible};
use raytracer::math::robust::{DETERMINANT_ROUNDINGS, unit};
use raytracer::world::World;

/// The number of roundings that the tests assume. It is stated here independently of the source.
const SINGULAR_ROUNDINGS: f64 = 16.0;

/// The angle between two directions, which is accurate also for small angles.
fn angle(a: &Dd3, b: &Dd3) -> f64 {
    let unit = |v: &Dd3| dd::scaled(v, Dd::from(1.0) / length(v));
    let apart = length(&dd::sub(&unit(a), &unit(b))).value();
    if apart.is_nan() { f64::INFINITY } else { 2.0 * (apart / 2.0).min(1.0).asin() }
}

/// The cofactor matrix times a normal, in double-double.
fn exact_normal(m: &DMat3, normal: &Dd3) -> Dd3 {
    let columns = [0, 1, 2].map(|k| dd::vector(m.col(k)));
    let cross =
        |a: &Dd3, b: &Dd3| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let cofactors = [0, 1, 2].map(|k| cross(&columns[(k + 1) % 3], &columns[(k + 2) % 3]));
    let part = |k: usize| dd::scaled(&cofactors[k], normal[k]);
    dd::add(&dd::add(&part(0), &part(1)), &part(2))
}

/// A map that flattens along its z axis, almost or completely, followed by a rotation, and every other time
/// preceded by one as well.
fn flattening(rng: &mut Rng, index: u64) -> (DMat3, f64) {
    const EXPONENTS: [i32; 8] = [-2, -4, -6, -8, -10, -15, -20, -30];
    let s = if index % 9 == 8 { 0.0 } else { 10f64.powi(EXPONENTS[index as usize % 9]) };
    let flat = rotation(rng, rng.clone().range(0.0, 360.0)) * DMat3::from_diagonal(DVec3::new(1.0, 1.0, s));
    let before = rotation(rng, 50.0);
    (if index.is_multiple_of(2) { flat } else { flat * before }, s)
}

/// Whether a matrix must be refused as singular, or must not be; none where both are right.
///
/// The rule is that a matrix is refused if its computed determinant is at most [`SINGULAR_ROUNDINGS`] times
/// the unit roundoff times the largest determinant that columns of these lengths allow, and the same for
/// rows. The error of what is computed is at most [`DETERMINANT_ROUNDINGS`], so within that distance of the
/// bound both answers are right.
fn must_refuse(determinant: f64, columns: f64, rows: f64) -> Option<bool> {
    let in_roundings = determinant.abs() / (ROUNDING * columns.min(rows));
    match in_roundings {
        _ if in_roundings < SINGULAR_ROUNDINGS - DETERMINANT_ROUNDINGS => Some(true),
        _ if in_roundings > SINGULAR_ROUNDINGS + DETERMINANT_ROUNDINGS => Some(false),
        _ => None,
    }
}

/// The same for a matrix, in double-double, with an error of 1e-30 of the largest possible determinant.
fn must_refuse_in_double_double(m: &DMat3) -> Option<bool> {
    let product = |m: &DMat3| {
        let lengths = [0, 1, 2].map(|k| length(&dd::vector(m.col(k))));
        (lengths[0] * lengths[1] * lengths[2]).value()
    };
    let determinant = dd::dot(&exact_normal(m, &dd::vector(DVec3::X)), &dd::vector(m.x_axis));
    must_refuse(determinant.value(), product(m), product(&m.transpose()))
}

/// The same in rational arithmetic, where only the last quotients are rounded.
fn must_refuse_exactly(m: &DMat3) -> Option<bool> {
    let [x, y, z] = [0, 1, 2].map(|k| exact3(m.col(k)));
    let minor = |i: usize, j: usize| &x[i] * &y[j] - &x[j] * &y[i];
    let determinant = dot(&z, &[minor(1, 2), minor(2, 0), minor(0, 1)]);
    let squares =
        |m: &DMat3| [0, 1, 2].map(|k| exact3(m.col(k))).iter().map(|v| dot(v, v)).product::<BigRational>();
    // The ratio of the determinant to its bound, whose square is rational.
    let share = |bound: BigRational| {
        let square = &determinant * &determinant / bound;
        square.to_f64().expect("a float").sqrt()
    };
    let largest = f64::max(share(squares(m)), share(squares(&m.transpose())));
    must_refuse(largest, 1.0, 1.0)
}

/// Whether a scene with this object is refused as singular. Any other error is a failure.
fn is_refused(built: &Result<World, Diagnostic>) -> bool {
    match built {
        Ok(_) => false,
        Err(error) => {
            assert!(error.message.contains("singular"), "{error}");
            true
        }
    }
}

/// For planes and spheres under matrices whose determinants are a few roundings of the largest possible one,
/// counts those refused that must not be, those placed that must be refused, those placed with a NaN in the
/// normal, those for which both answers are right, and those refused.
fn near_the_bound_of_singular(n: u64) -> [u64; 5] {
    const SEED: u64 = 3048;
    let failures = Failures::default();
    let one = |index: u64| {
        let rng = &mut Rng::at(SEED, index);
        let thin = DMat3::from_diagonal(DVec3::new(1.0, 1.0, rng.range(0.0, 32.0) * ROUNDING));
        let mut m = rotation(rng, rng.clone().range(0.0, 360.0)) * thin * rotation(rng, 50.0);
        // The scales of columns or rows, which come from similarities and scalings, do not matter.
        let mut far =
            || DMat3::from_diagonal(DVec3::from_array([0; 3].map(|_| 10f64.powf(rng.range(-20.0, 20.0)))));
        match index % 3 {
            0 => m *= far(),
            1 => m = far() * m,
            _ => m *= 10f64.powf(rng.range(-80.0, 80.0)),
        }
        let transform = [DAffine3::from_mat3(m)];
        let plane = World::new(&nested("Plane { normal 1 2 3 offset 0 }", &transform), &[]);
        let sphere = World::new(&nested("Sphere { center 0 0 0 radius 1 }", &transform), &[]);
        let refused = [is_refused(&plane), is_refused(&sphere)];
        let expected = must_refuse_exactly(&m);
        let count = |wrong: bool| match expected {
            Some(must) if must == wrong => refused.iter().filter(|&&refused| refused != must).count() as u64,
            _ => 0,
        };
        let (lost, kept) = (count(false), count(true));
        failures.note(lost + kept > 0, || {
            format!("seed {SEED}, index {index}: {expected:?}, {refused:?}, {m:?}")
        });
        let broken = plane.is_ok_and(|world| !is_unit(world.planes[0].normal)) as u64
            + sphere.is_ok_and(|world| !has_sound_normal(&world, m)) as u64;
        (
            [
                lost,
                kept,
                broken,
                2 * expected.is_none() as u64,
                refused.iter().filter(|&&r| r).count() as u64,
            ],
            [],
        )
    };
    measure(n, one).0
}

fn is_unit(v: DVec3) -> bool {
    (v.length() - 1.0).abs() < 1e-12
}

/// Whether a ray from outside hits a transformed unit sphere, with a normal of unit length.
fn has_sound_normal(world: &World, m: DMat3) -> bool {
    let ray = Ray::new(DVec3::ZERO, unit(m * DVec3::new(0.3, 0.4, 0.5)));
    let hit = Caster::new(world, None).expect("no grid").closest(&ray);
    hit.is_some_and(|hit| is_unit(world.surface(&ray, &hit).normal))
}

/// For planes flattened more or less, counts those refused, those refused or placed wrongly, those whose
/// normal is NaN by the textbook and by ours, and those placed. Also returns the largest angle between a
/// normal and the exact one.
fn flattened_planes(n: u64) -> ([u64; 5], [f64; 1]) {
    const SEED: u64 = 1048;
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let (m, _) = flattening(rng, index);
        let normal = rng.direction();
        let in_f32 = (m.as_mat3().inverse().transpose() * normal.as_vec3()).normalize();
        let broken = (in_f32.is_nan() || in_f32 == Vec3::ZERO) as u64;
        let text = format!("Plane {{ normal {} {} {} offset 0 }}", normal.x, normal.y, normal.z);
        let built = World::new(&nested(&text, &[DAffine3::from_mat3(m)]), &[]);
        let refused = is_refused(&built);
        let wrong = must_refuse_in_double_double(&m).is_some_and(|must| must != refused) as u64;
        let Ok(world) = built else { return ([1, wrong, broken, 0, 0], [0.0]) };
        let side = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
        let expected = dd::scaled(&exact_normal(&m, &dd::vector(normal.normalize())), side.into());
        let found = world.planes[0].normal;
        let off = angle(&dd::vector(found), &expected);
        failures.note(off > 1e-10, || format!("seed {SEED}, index {index}: {m:?}, {normal:?}, {off:e}"));
        ([0, wrong, broken, found.is_nan() as u64, 1], [off])
    };
    measure(n, one)
}

/// The nearest crossing with the unit sphere, and its normal in world space, in double-double.
fn exact_ellipsoid(m: &DMat3, ray: &Ray) -> Option<(Dd, Dd3)> {
    // The inverse is the transposed cofactor matrix over the determinant. The unnormalised one is enough.
    let inverse = |v: &Dd3| {
        let basis = [DVec3::X, DVec3::Y, DVec3::Z].map(|e| exact_normal(m, &dd::vector(e)));
        [dd::dot(&basis[0], v), dd::dot(&basis[1], v), dd::dot(&basis[2], v)]
    };
    let determinant = dd::dot(&exact_normal(m, &dd::vector(DVec3::X)), &dd::vector(m.x_axis));
    let (o, d) = (inverse(&dd::vector(ray.origin)), inverse(&dd::vector(ray.direction)));
    let (a, b) = (dd::dot(&d, &d), dd::dot(&o, &d));
    let nearest = dd::sub(&o, &dd::scaled(&d, b / a));
    let discriminant = determinant * determinant - dd::dot(&nearest, &nearest);
    if discriminant.sign() <= 0 {
        return None;
    }
    let t = -(b / a) - (discriminant / a).sqrt();
    let unit = dd::sub(&nearest, &dd::scaled(&d, (discriminant / a).sqrt()));
    Some((t, exact_normal(m, &unit)))
}

/// For ellipsoids that should be hit, counts the hits, the misses by ours and by the textbook, those refused
/// or seen almost edge on, and those refused or placed wrongly. Also returns the largest angle between a
/// normal and the exact one, and the largest relative error of t.
fn flattened_ellipsoids(n: u64) -> ([u64; 5], [f64; 2]) {
    const SEED: u64 = 2048;
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let (m, s) = flattening(rng, index);
        let scene = nested("Sphere { center 0 0 0 radius 1 }", &[DAffine3::from_mat3(m)]);
        // The point is well inside the outline.
        let target = m * (0.9 * rng.in_ball());
        let ray = Ray::new(target + 4.0 * rng.direction(), DVec3::ZERO);
        let ray = Ray { direction: target - ray.origin, ..ray };
        let face = exact_normal(&m, &dd::vector(DVec3::Z));
        let slanted = angle(&face, &dd::vector(ray.direction)).cos().abs() < 0.03;
        let built = World::new(&scene, &[]);
        let refused = is_refused(&built);
        let wrong = must_refuse_in_double_double(&m).is_some_and(|must| must != refused) as u64;
        let Some(world) = built.ok().filter(|_| !slanted) else { return ([0, 0, 0, 1, wrong], [0.0; 2]) };
        let textbook = !quadratic_hits(&m, &ray) as u64;
        let Some(t) = world.shapes[0].intersect(&ray) else {
            failures.note(true, || failed_ray(48, SEED, index, ray.origin, ray.direction));
            return ([0, 1, textbook, 0, wrong], [0.0; 2]);
        };
        let (exact_t, exact_normal) = match exact_ellipsoid(&m, &ray) {
            Some(exact) if s >= 1e-12 => exact,
            _ => (Dd::from(1.0), disc_normal(&ray, face)),
        };
        let normal = world.visible_surface(&ray, Visible { primitive: 0, t_bound: t }).normal;
        let off = angle(&dd::vector(normal), &exact_normal);
        let error = (Dd::from(t) - exact_t).abs().value();
        failures.note(off > 1e-10, || failed_ray(48, SEED, index, ray.origin, ray.direction));
        ([1, 0, textbook, 0, wrong], [off, error])
    };
    measure(n, one)
}

/// An ellipsoid thinner than double-double resolves is a disc, whose normal is on the ray's side. All rays
/// are aimed to hit it at t = 1.
fn disc_normal(ray: &Ray, face: Dd3) -> Dd3 {
    let turned_away = dd::dot(&face, &dd::vector(ray.direction)).sign() > 0;
    if turned_away { face.map(|x| -x) } else { face }
}

/// Whether the plain quadratic in the space of the inverted matrix hits the unit sphere, in f64.
fn quadratic_hits(m: &DMat3, ray: &Ray) -> bool {
    let inverse = m.inverse();
    let (o, d) = (inverse * ray.origin, inverse * ray.direction);
    o.dot(d) * o.dot(d) - d.length_squared() * (o.length_squared() - 1.0) >= 0.0
}

#[test]
fn case_48_nearly_singular_scales() {
    let n = rays(50_000, 5_000_000);
    let near = rays(6_000, 600_000);
    let [lost, kept, not_numbers, either, near_refused] = near_the_bound_of_singular(near);
    let ([refused, wrong_planes, broken, nans, placed], [plane_angle]) = flattened_planes(n);
    let ([hits, missed, textbook, unclear, wrong_spheres], [angle, t]) = flattened_ellipsoids(n);
    Record {
        case: 48,
        basis: Basis::Proved,
        name: "planes and ellipsoids scaled by 1e-2 to 1e-30 along one axis, and by 0",
        inputs: format!(
            "{n} planes, {refused} refused as singular; {n} ellipsoids, {unclear} refused or seen edge on; {near} of \
             each whose determinant is a few roundings of the largest, {near_refused} refused"
        ),
        measure: "wrongly refused or placed by exact determinants, normals that are not a number, misses, angle of \
                  normals in radians",
        textbook: format!(
            "inverse transpose in f32: {broken} not a number; quadratic in f64: {textbook} misses"
        ),
        ours: format!(
            "{}, {}, {missed}, planes {plane_angle:.1e}, ellipsoids {angle:.1e} with t off by {t:.1e}",
            lost + kept + wrong_planes + wrong_spheres,
            nans + not_numbers,
        ),
        target: "0, 0, 0, 1e-10",
    }
    .write();
    assert_eq!([lost, kept, wrong_planes, wrong_spheres], [0; 4], "wrongly refused or placed");
    assert_eq!((nans, not_numbers, missed), (0, 0, 0));
    assert!(plane_angle <= 1e-10 && angle <= 1e-10, "{plane_angle:e} {angle:e}");
    assert!(either < near && near_refused > near / 4 && near_refused < near, "the case tests nothing");
    assert!(broken > 0 && textbook > 0 && placed > n / 3 && hits > n / 3, "the case tests nothing");
}
