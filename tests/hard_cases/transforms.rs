//! Section E, cases 47 to 49 and 52: nested, nearly singular and mirroring transforms, and the same
//! scene without flattening.

use crate::support::brute::Brute;
use crate::support::double_double::{self as dd, Dd, Dd3};
use crate::support::exact::{dot, exact3};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, bunny, icosphere, point_in, world_of};
use crate::support::record::Record;
use crate::support::rng::Rng;
use crate::support::textbook::{Edges, lower_triangle, woop};
use crate::support::{failed_ray, rays};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use num_rational::BigRational;
use num_traits::ToPrimitive;
use raytracer::caster::Caster;
use raytracer::math::ray::{Hit, Ray};
use raytracer::math::robust::{DETERMINANT_ROUNDINGS, SINGULAR_ROUNDINGS, unit};
use raytracer::primitive::triangle;
use raytracer::scene::error::{Problem, SceneError};
use raytracer::scene::mesh::Mesh;
use raytracer::scene::parser::parse;
use raytracer::scene::{Object, Position, Scene};
use raytracer::stats::Quiet;
use raytracer::world::World;

/// The relative rounding of a double, as the targets count.
const ROUNDING: f64 = f64::EPSILON / 2.0;

fn rotation(rng: &mut Rng, degrees: f64) -> DMat3 {
    DMat3::from_axis_angle(rng.direction(), degrees.to_radians())
}

/// A scene of one object inside these transforms, the outermost first.
fn nested(object: &str, transforms: &[DAffine3]) -> Scene {
    let text = format!(
        "PerspectiveCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 angle 30 }}
         Materials {{ numMaterials 1 Material {{ }} }}
         Group {{ numObjects 1 MaterialIndex 0 {object} }}"
    );
    let mut scene = parse(&text).expect("a scene of one object");
    for &matrix in transforms.iter().rev() {
        let child = scene.root;
        scene.objects.push(Object::Transform { matrix, child, at: Position { line: 1, column: 1 } });
        scene.root = scene.objects.len() - 1;
    }
    scene
}

const MESH: &str = "TriangleMesh { obj_file m.obj }";

/// The linear part times `v` in double-double.
fn turned(m: &DMat3, v: &Dd3) -> Dd3 {
    let column = |k: usize| dd::scaled(&dd::vector(m.col(k)), v[k]);
    dd::add(&dd::add(&column(0), &column(1)), &column(2))
}

fn length(v: &Dd3) -> Dd {
    dd::dot(v, v).sqrt()
}

/// The angle between two directions, small ones in full precision.
fn angle(a: &Dd3, b: &Dd3) -> f64 {
    let unit = |v: &Dd3| dd::scaled(v, Dd::from(1.0) / length(v));
    let apart = length(&dd::sub(&unit(a), &unit(b))).value();
    if apart.is_nan() { f64::INFINITY } else { 2.0 * (apart / 2.0).min(1.0).asin() }
}

/// A level of case 47: turned by 37 degrees, moved by 10, and scaled by 10 and back in turn.
fn level(rng: &mut Rng, i: usize, scaled: bool) -> DAffine3 {
    let scale = match (scaled, i % 2) {
        (false, _) => 1.0,
        (true, 0) => 10.0,
        (true, _) => 0.1,
    };
    DAffine3::from_mat3_translation(rotation(rng, 37.0) * scale, 10.0 * rng.direction())
}

#[test]
fn case_47_deep_nesting() {
    const SEED: u64 = 1047;
    let n = rays(400, 40_000);
    let mut worst = [0.0f64; 2];
    for depth in [1, 4, 16, 64, 256] {
        let one = |index: u64| {
            let rng = &mut Rng::at(SEED, index);
            let levels: Vec<_> = (0..depth).map(|i| level(rng, i, index.is_multiple_of(2))).collect();
            let mesh = Mesh {
                vertices: (0..60).map(|_| 10.0 * rng.in_cube()).collect(),
                triangles: vec![[0, 1, 2]],
            };
            let world = World::new(&nested(MESH, &levels), std::slice::from_ref(&mesh)).expect("a world");
            let whole = levels.iter().fold(glam::Affine3A::IDENTITY, |m, l| m * l.as_affine3a());
            let mut errors = [0.0f64; 2];
            for (v, placed) in mesh.vertices.iter().zip(&world.vertices) {
                let (exact, largest) = exactly_placed(&levels, *v);
                let in_f32 = whole.transform_point3(v.as_vec3()).as_dvec3();
                for (error, found) in errors.iter_mut().zip([*placed, in_f32]) {
                    let off = length(&dd::sub(&dd::vector(found), &exact)).value() / largest;
                    *error = error.max(off / (depth as f64 * 4.0 * ROUNDING));
                }
            }
            ([], errors)
        };
        let ([], errors) = measure(n, one);
        worst = [0, 1].map(|i| worst[i].max(errors[i]));
    }
    Record {
        case: 47,
        name: "transforms nested 1 to 256 deep",
        inputs: format!("{} points", 5 * 60 * n),
        measure: "error relative to the largest intermediate length, in 4 roundings a level",
        textbook: format!("matrices multiplied in f32: {:.1e}", worst[1]),
        ours: format!("{:.2}", worst[0]),
        target: "1",
    }
    .write();
    assert!(worst[0] <= 1.0, "{worst:?}");
    assert!(worst[1] > 1.0, "the case tests nothing");
}

/// A point through all levels, and the largest length on its way, seen from outside.
fn exactly_placed(levels: &[DAffine3], v: DVec3) -> (Dd3, f64) {
    let mut point = dd::vector(v);
    let mut largest = v.length();
    for level in levels.iter().rev() {
        point = dd::add(&turned(&level.matrix3, &point), &dd::vector(level.translation));
        // In the outermost space lengths are what the scales outside make of them: at most 10 here.
        largest = largest.max(length(&point).value());
    }
    (point, largest)
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

/// Flattened almost, or wholly, along its z axis, then turned; every other time turned before, too.
fn flattening(rng: &mut Rng, index: u64) -> (DMat3, f64) {
    const EXPONENTS: [i32; 8] = [-2, -4, -6, -8, -10, -15, -20, -30];
    let s = if index % 9 == 8 { 0.0 } else { 10f64.powi(EXPONENTS[index as usize % 9]) };
    let flat = rotation(rng, rng.clone().range(0.0, 360.0)) * DMat3::from_diagonal(DVec3::new(1.0, 1.0, s));
    let before = rotation(rng, 50.0);
    (if index.is_multiple_of(2) { flat } else { flat * before }, s)
}

/// Whether a matrix must be refused as singular, or must not; where either is right, neither.
///
/// The rule: it is refused where the determinant, as computed, is at most [`SINGULAR_ROUNDINGS`] of the
/// largest that columns of these lengths allow, and rows likewise. What is computed is off by at most
/// [`DETERMINANT_ROUNDINGS`], so that only within so many of the bound either is right.
fn must_refuse(determinant: f64, columns: f64, rows: f64) -> Option<bool> {
    let in_roundings = determinant.abs() / (ROUNDING * columns.min(rows));
    match in_roundings {
        _ if in_roundings < SINGULAR_ROUNDINGS - DETERMINANT_ROUNDINGS => Some(true),
        _ if in_roundings > SINGULAR_ROUNDINGS + DETERMINANT_ROUNDINGS => Some(false),
        _ => None,
    }
}

/// The same of a matrix, in double-double: good to 1e-30 of the largest determinant there could be.
fn must_refuse_in_double_double(m: &DMat3) -> Option<bool> {
    let product = |m: &DMat3| {
        let lengths = [0, 1, 2].map(|k| length(&dd::vector(m.col(k))));
        (lengths[0] * lengths[1] * lengths[2]).value()
    };
    let determinant = dd::dot(&exact_normal(m, &dd::vector(DVec3::X)), &dd::vector(m.x_axis));
    must_refuse(determinant.value(), product(m), product(&m.transpose()))
}

/// The same by rational numbers: only the last quotients are rounded.
fn must_refuse_exactly(m: &DMat3) -> Option<bool> {
    let [x, y, z] = [0, 1, 2].map(|k| exact3(m.col(k)));
    let minor = |i: usize, j: usize| &x[i] * &y[j] - &x[j] * &y[i];
    let determinant = dot(&z, &[minor(1, 2), minor(2, 0), minor(0, 1)]);
    let squares =
        |m: &DMat3| [0, 1, 2].map(|k| exact3(m.col(k))).iter().map(|v| dot(v, v)).product::<BigRational>();
    // The determinant's share of the bound, whose square is rational.
    let share = |bound: BigRational| {
        let square = &determinant * &determinant / bound;
        square.to_f64().expect("a float").sqrt()
    };
    let largest = f64::max(share(squares(m)), share(squares(&m.transpose())));
    must_refuse(largest, 1.0, 1.0)
}

/// Whether a scene of this object is refused as singular; any other reason to refuse it is a failure.
fn is_refused(built: &Result<World, SceneError>) -> bool {
    match built {
        Ok(_) => false,
        Err(error) => {
            assert_eq!(error.problem, Problem::SingularTransform);
            true
        }
    }
}

/// Of planes and spheres under matrices whose determinants are a few roundings of the largest: those refused
/// that must not be, those placed that must be refused, those placed whose normal is not a number, those
/// within the bound's own error, and those refused.
fn near_the_bound_of_singular(n: u64) -> [u64; 5] {
    const SEED: u64 = 3048;
    let failures = Failures::default();
    let one = |index: u64| {
        let rng = &mut Rng::at(SEED, index);
        let thin = DMat3::from_diagonal(DVec3::new(1.0, 1.0, rng.range(0.0, 32.0) * ROUNDING));
        let mut m = rotation(rng, rng.clone().range(0.0, 360.0)) * thin * rotation(rng, 50.0);
        // Scales of columns or rows, which a similarity and a scale bring in, change nothing.
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

/// Whether a ray out of a transformed unit sphere meets it, with a normal that is one.
fn has_sound_normal(world: &World, m: DMat3) -> bool {
    let ray = Ray::new(DVec3::ZERO, unit(m * DVec3::new(0.3, 0.4, 0.5)));
    let hit = Caster::new(world, None).expect("no grid").closest(&ray, &mut Quiet);
    hit.is_some_and(|hit| is_unit(world.surface(&ray, hit).normal))
}

/// Of planes flattened more or less: those refused, and wrongly so or not; those whose normal is not a number, by
/// the textbook and by ours; all placed. And the largest angle of a normal.
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

/// The unit sphere's nearest crossing and its normal in the world, all in double-double.
fn exact_ellipsoid(m: &DMat3, ray: &Ray) -> Option<(Dd, Dd3)> {
    // The inverse is the transposed cofactors over the determinant; unnormalised is enough.
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

/// Ellipsoids that are hit where they should be, misses by ours and by the textbook, those refused or
/// seen nearly edge on, and those wrongly refused or not; the largest angle of a normal and relative error of t.
fn flattened_ellipsoids(n: u64) -> ([u64; 5], [f64; 2]) {
    const SEED: u64 = 2048;
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let (m, s) = flattening(rng, index);
        let scene = nested("Sphere { center 0 0 0 radius 1 }", &[DAffine3::from_mat3(m)]);
        // Well inside the outline.
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
        let Some(t) = world.ellipsoids[0].intersect(&ray) else {
            failures.note(true, || failed_ray(48, SEED, index, ray.origin, ray.direction));
            return ([0, 1, textbook, 0, wrong], [0.0; 2]);
        };
        let (exact_t, exact_normal) = match exact_ellipsoid(&m, &ray) {
            Some(exact) if s >= 1e-12 => exact,
            _ => (Dd::from(1.0), disc_normal(&ray, face)),
        };
        let normal = world.surface(&ray, Hit { t, primitive: 0 }).normal;
        let off = angle(&dd::vector(normal), &exact_normal);
        let error = (Dd::from(t) - exact_t).abs().value();
        failures.note(off > 1e-10, || failed_ray(48, SEED, index, ray.origin, ray.direction));
        ([1, 0, textbook, 0, wrong], [off, error])
    };
    measure(n, one)
}

/// Thinner than double-double resolves, the ellipsoid is a disc, with the normal on the ray's side.
/// All rays are aimed so that they meet it at t = 1.
fn disc_normal(ray: &Ray, face: Dd3) -> Dd3 {
    let turned_away = dd::dot(&face, &dd::vector(ray.direction)).sign() > 0;
    if turned_away { face.map(|x| -x) } else { face }
}

/// Whether the plain quadratic in the space of the inverted matrix sees the unit sphere, in f64.
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

/// Mirrored and sheared by up to 1e3, in some order, and turned.
fn mirroring(rng: &mut Rng, index: u64) -> DMat3 {
    let mirror = DMat3::from_diagonal(DVec3::new(if index % 3 < 2 { -1.0 } else { 1.0 }, 1.0, 1.0));
    let shear = DMat3::from_cols(DVec3::X, DVec3::new(10f64.powf(rng.range(0.0, 3.0)), 1.0, 0.0), DVec3::Z);
    rotation(rng, 77.0) * mirror * shear * rotation(rng, 31.0)
}

#[test]
fn case_49_normals_of_mirrored_objects_point_outwards() {
    const SEED: u64 = 1049;
    let ball = icosphere(2, 1.0, DVec3::ZERO);
    let n = rays(400, 40_000);
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let transform = [DAffine3::from_mat3_translation(mirroring(rng, index), DVec3::new(1.0, -2.0, 0.5))];
        let [m] = transform;
        let world = World::new(&nested(MESH, &transform), std::slice::from_ref(&ball.mesh)).expect("a world");
        // The image of a ball is convex, so the image of its middle is behind every face.
        let outward = |t: [DVec3; 3]| triangle::normal(t).dot(t[0] - m.translation) > 0.0;
        let wrong = (0..world.triangles.len()).filter(|&i| !outward(world.corners(i))).count();
        let unturned =
            ball.mesh.triangles.iter().map(|t| t.map(|v| m.transform_point3(ball.mesh.vertices[v as usize])));
        let textbook = unturned.filter(|&t| !outward(t)).count();
        let sphere =
            World::new(&nested("Sphere { center 0 0 0 radius 1 }", &transform), &[]).expect("a world");
        let inside_out = (0..200).filter(|_| !is_outward_seen(&sphere, &m, rng)).count();
        ([world.triangles.len() as u64 + 200, (wrong + inside_out) as u64, textbook as u64], [])
    };
    let ([inputs, wrong, textbook], []) = measure(n, one);
    Record {
        case: 49,
        name: "mirrored and sheared by up to 1e3",
        inputs: format!("{inputs} triangles and rays at ellipsoids"),
        measure: "normals that point inwards",
        textbook: format!("vertices transformed without turning the winding: {textbook}"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    assert!(textbook > 0, "the case tests nothing");
}

/// Whether a ray from outside sees a normal turned towards it, and one from within turned away.
fn is_outward_seen(world: &World, m: &DAffine3, rng: &mut Rng) -> bool {
    let inside = m.transform_point3(0.5 * rng.in_ball());
    let outside = m.transform_point3(3.0 * rng.direction());
    let normal = |ray: &Ray| {
        let t = world.ellipsoids[0].intersect(ray).expect("the line goes through the inside");
        world.surface(ray, Hit { t, primitive: 0 }).normal
    };
    let (into, out) = (Ray::new(outside, inside - outside), Ray::new(inside, outside - inside));
    normal(&into).dot(into.direction) < 0.0 && normal(&out).dot(out.direction) > 0.0
}

#[test]
fn case_52_flattened_and_hierarchical() {
    const SEED: u64 = 1052;
    let mesh = Closed::new(bunny("1k"));
    let local = world_of(&mesh.mesh);
    let local_brute = Brute::new(&local);
    let n = rays(100_000, 10_000_000);
    let rng = &mut Rng::new(SEED);
    let levels: Vec<_> = (0..8).map(|i| level(rng, i, true)).collect();
    let world = World::new(&nested(MESH, &levels), std::slice::from_ref(&mesh.mesh)).expect("a world");
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let i = rng.below(world.triangles.len());
        let target = point_in(world.corners(i), rng);
        let ray = Ray::new(target + rng.direction(), DVec3::ZERO);
        let ray = Ray { direction: target - ray.origin, ..ray };
        let flat = brute.closest(&ray).map(|h| h.primitive);
        let inward = levels.iter().fold(ray, |ray, level| {
            let inverse = level.inverse();
            Ray::new(inverse.transform_point3(ray.origin), inverse.transform_vector3(ray.direction))
        });
        let hierarchical = local_brute.closest(&inward).map(|h| h.primitive);
        let differs = flat != hierarchical;
        failures.note(differs, || failed_ray(52, SEED, index, ray.origin, ray.direction));
        ([differs as u64, (nearest_in_f32(&local, &local_brute, &levels, &ray) != flat) as u64], [])
    };
    let ([differ, textbook], []) = measure(n, one);
    Record {
        case: 52,
        name: "flattened and hierarchical",
        inputs: format!("{n} rays through eight levels"),
        measure: "rays that hit another triangle",
        textbook: format!("hierarchical in f32: {textbook}"),
        ours: differ.to_string(),
        target: "1 in 1e6",
    }
    .write();
    assert!(differ <= n / 1_000_000, "{differ}");
    assert!(textbook > 0, "the case tests nothing");
}

/// What a hierarchical tracer sees in single precision.
fn nearest_in_f32(local: &World, brute: &Brute, levels: &[DAffine3], ray: &Ray) -> Option<u32> {
    let (mut o, mut d) = (ray.origin.as_vec3(), ray.direction.as_vec3());
    for level in levels {
        let inverse = level.as_affine3a().inverse();
        (o, d) = (inverse.transform_point3(o), inverse.transform_vector3(d));
    }
    let ray = Ray::new(o.as_dvec3(), d.as_dvec3());
    let hit = |i: u32| {
        let t = woop(o.to_array(), d.to_array(), lower_triangle(local.corners(i as usize)), Edges::Inclusive);
        t.filter(|&t| t > 0.0).map(|t| (t, i))
    };
    brute.near(&ray).filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}
