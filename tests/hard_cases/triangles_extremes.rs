//! Section A, case 20: numbers of any size, compared with exact rationals.

use crate::support::exact::exact;
use crate::support::exact_triangle::{self, intersect_by_rule};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, bunny, icosphere, moved, rounded};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::{layers, world_of_mesh};
use crate::support::textbook::{lower, lower_triangle, moller_trumbore};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use num_rational::BigRational;
use num_traits::{Signed, ToPrimitive};
use raytracer::caster::Caster;
use raytracer::caster::choose::Layout;
use raytracer::math::instructions;
use raytracer::math::ray::Ray;
use raytracer::render::{Layer, Request, Tracing};
use raytracer::scene::Scene;
use raytracer::scene::parser::parse;
use raytracer::world::World;
use raytracer::world::triangle::{Shear, normal, point};

/// A sphere whose coordinates, and a ray whose direction, are scaled by powers of two.
#[test]
fn case_20_a_sphere_of_many_sizes_in_a_grid() {
    const SEED: u64 = 1020;
    let n = rays(6_000, 1_000_000);
    let failures = Failures::default();
    let unit = icosphere(3, 1.0, DVec3::new(0.25, 0.5, -0.125));
    let mut sums = [0; 2];
    // 2^100 = 1.3e30, and below 2^-126 = 1.2e-38 f32 begins to lose bits.
    for exponent in [-126, -100, -60, 0, 60, 100] {
        let mesh = moved(&unit.mesh, |v| v * 2f64.powi(exponent));
        let world = world_of_mesh(&mesh);
        let caster = Caster::new(&world, Some([16; 3])).expect("a small grid");
        let closed = Closed::new(mesh);
        let one = |index: u64| {
            let rng = &mut Rng::at(SEED, index);
            let size = 2f64.powi(exponent);
            let origin = size * rounded(DVec3::new(0.25, 0.5, -0.125) + 0.5 * rng.in_ball());
            let i = rng.below(closed.mesh.vertices.len());
            let length = [1e-30, 1.0, 1e30][rng.below(3)];
            let ray = Ray::new(origin, length * (closed.mesh.vertices[i] - origin) / size);
            let shear = Shear::new(&ray);
            let hits = closed.rings[i].iter().filter_map(|&t| shear.intersect(closed.corners(t).each_ref()));
            let in_front = hits.filter(|&t| t > 0.0 && t.is_finite()).count();
            let wrong = in_front != 1 || caster.closest(&ray).is_none();
            failures.note(wrong, || failed_ray(20, SEED, index, ray.origin, ray.direction));
            let (o, d) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
            let textbook = closed.rings[i].iter().any(|&t| {
                moller_trumbore(o, d, lower_triangle(closed.corners(t)), 0.0).is_some_and(|t| t > 0.0)
            });
            ([wrong as u64, !textbook as u64], [])
        };
        let (counts, []) = measure(n, one);
        sums = [sums[0] + counts[0], sums[1] + counts[1]];
    }
    let [wrong, textbook] = sums;
    assert_eq!(wrong, 0);
    assert!(textbook > n, "the case tests nothing");
}

/// 2^n, or the nearest value in the range of floats.
fn power(n: i32) -> f64 {
    2f64.powi(n / 2) * 2f64.powi(n - n / 2)
}

/// The exponents by which the axes are scaled, all equal or independent: from the whole range, or from those
/// where products of two or three numbers, or with an inverse, begin to overflow or underflow.
fn exponents(rng: &mut Rng) -> [i32; 3] {
    let between = |rng: &mut Rng, low: i32, high: i32| low + rng.below((high - low) as usize) as i32;
    let around = [0, -300, -340, -500, -537, -1010, 250, 340, 500, 970][rng.below(10)];
    let near = between(rng, around - 20, around + 10);
    match rng.below(4) {
        0 => [near; 3],
        1 => [near, near, between(rng, -1000, 980)],
        2 => [0; 3].map(|_| between(rng, -1000, 980)),
        _ => [0; 3].map(|_| near + between(rng, -20, 20)).map(|n| n.clamp(-1050, 980)),
    }
}

fn integer_vector(rng: &mut Rng, n: usize) -> DVec3 {
    DVec3::from_array([0; 3].map(|_| rng.below(2 * n + 1) as f64 - n as f64))
}

/// The four faces of a tetrahedron, which may have no volume, and a ray that hits a vertex, an edge or a face
/// of it. All coordinates are integers first, so that the hit is exact, and then every axis is scaled by a
/// power of two.
fn scaled_tetrahedron(rng: &mut Rng) -> (Ray, [[DVec3; 3]; 4]) {
    // Integers of 31 bits, or so small ones that many edges are parallel to an axis.
    let (step, most) = if rng.below(3) == 0 { (8.0, 2) } else { (2f64.powi(23), 100) };
    let mut corners = [0; 4].map(|_| step * integer_vector(rng, most));
    match rng.below(8) {
        0 => corners[3] = corners[rng.below(3)],
        1 => corners[2] = 2.0 * corners[1] - corners[0],
        2 => corners[3] = corners[0] + 2.0 * (corners[1] - corners[2]),
        3 => corners = [corners[0]; 4],
        // A needle.
        4 => corners[2] = 2.0 * corners[1] - corners[0] + 8.0 * integer_vector(rng, 2),
        _ => {}
    }
    let [a, b, c, _] = corners;
    let part = |rng: &mut Rng| rng.below(9) as f64 / 8.0;
    let target = match rng.below(4) {
        0 => a,
        1 => a + part(rng) * (b - a),
        2 => a + 0.25 * (b - a) + 0.5 * (c - a),
        _ => step * integer_vector(rng, most),
    };
    let origin = if rng.below(8) == 0 { a } else { step * integer_vector(rng, most) };
    let exponents = exponents(rng);
    let scale = DVec3::from_array(exponents.map(power));
    let (low, high) = (exponents.iter().min().unwrap_or(&0), exponents.iter().max().unwrap_or(&0));
    // Whatever the length of the direction, its coordinates are exact.
    let (shortest, longest) = (-1074 - low, 990 - high);
    let length = shortest + rng.below((longest - shortest) as usize) as i32;
    let direction = DVec3::from_array([0, 1, 2].map(|k| (target - origin)[k] * power(exponents[k] + length)));
    let [a, b, c, d] = corners.map(|corner| corner * scale);
    (Ray::new(origin * scale, direction), [[a, b, c], [a, c, d], [a, d, b], [b, d, c]])
}

/// The error of t in roundings of the distance of the farthest vertex over the length of the direction. An
/// error below the smallest float does not count.
fn error_of_t(ray: &Ray, triangle: [DVec3; 3], found: f64, true_t: &BigRational) -> f64 {
    let longest = exact(ray.direction.abs().max_element());
    let away = |v: DVec3| [0, 1, 2].map(|k| (exact(v[k]) - exact(ray.origin[k])).abs());
    let farthest = triangle.into_iter().flat_map(away).max().expect("coordinates");
    let error = ((exact(found) - true_t).abs() - exact(f64::from_bits(1))) * longest;
    if error.is_positive() {
        (error / farthest).to_f64().expect("a number") / f64::EPSILON * 2.0
    } else {
        0.0
    }
}

/// For one triangle: whether it is hit, whether the textbook's answer differs, and whether the answer is
/// wrong in the decision, the normal or the point. Also returns the error of t.
fn errors(ray: &Ray, triangle: [DVec3; 3]) -> ([u64; 5], f64) {
    let shear = Shear::new(ray);
    let (t, weights) = (shear.intersect(triangle.each_ref()), shear.weights(triangle.each_ref()));
    let [o, d] = [ray.origin, ray.direction].map(lower::<f64>);
    let textbook = moller_trumbore(o, d, lower_triangle(triangle), 0.0).is_some();
    let Some(true_t) = intersect_by_rule(ray, triangle) else {
        return ([0, textbook as u64, (t.is_some() || weights.is_some()) as u64, 0, 0], 0.0);
    };
    let is_float = true_t.abs() <= exact(f64::MAX);
    let wrong = t.is_some() != is_float || weights.is_none();
    let along = normal(triangle);
    let bent = along.is_normalized() && along.distance(exact_triangle::normal(triangle).normalize()) < 1e-6;
    let position = point(triangle, weights.unwrap_or([f64::NAN; 3]));
    let largest = triangle.iter().fold(0.0, |largest: f64, v| largest.max(v.abs().max_element()));
    let [low, high] = [DVec3::min, DVec3::max].map(|pick| pick(pick(triangle[0], triangle[1]), triangle[2]));
    let outside = (position - high).max(low - position).max_element();
    let known = position.is_finite() && outside <= 4.0 * f64::EPSILON * largest;
    let lost = largest < 2f64.powi(500) && !known;
    let error = t.map_or(0.0, |t| error_of_t(ray, triangle, t, &true_t));
    ([1, !textbook as u64, wrong as u64, !bent as u64, lost as u64], error)
}

/// The largest error of t that samples may have. What is proved, the source's `T_ROUNDINGS`, allows for steeper
/// triangles than samples have.
const MOST_ROUNDINGS: f64 = 16.0;

#[test]
fn case_20_every_size_a_float_can_have() {
    const SEED: u64 = 2020;
    let n = rays(20_000, 2_000_000);
    let failures = Failures::default();
    let one = |index| {
        let (ray, faces) = scaled_tetrahedron(&mut Rng::at(SEED, index));
        let (mut counts, mut error) = ([0; 6], 0.0f64);
        for face in faces {
            let (of_face, error_of_t) = errors(&ray, face);
            (0..5).for_each(|k| counts[k] += of_face[k]);
            error = error.max(error_of_t);
        }
        let shear = Shear::new(&ray);
        counts[5] = faces.iter().filter(|face| shear.weights(face.each_ref()).is_some()).count() as u64 % 2;
        let wrong = counts[2..] != [0; 4] || error > MOST_ROUNDINGS;
        failures.note(wrong, || failed_ray(20, SEED, index, ray.origin, ray.direction));
        (counts, [error])
    };
    let ([hits, textbook, wrong, bent, lost, odd], [error]) = measure(n, one);
    Record {
        case: 20,
        basis: Basis::Proved,
        name: "floats of any size",
        inputs: format!("{} triangles, some without area, {hits} of which are hit", 4 * n),
        measure: "wrong decisions, normals and points, odd numbers of crossings; how far t is off",
        textbook: format!("Moeller-Trumbore f64: {textbook} wrong decisions"),
        ours: format!("{wrong}, {bent}, {lost}, {odd}; {error:.1} roundings"),
        target: "0; 16 roundings",
    }
    .write();
    assert_eq!([wrong, bent, lost, odd], [0; 4], "decisions, normals, points, crossings");
    assert!(error <= MOST_ROUNDINGS, "t is off by {error} roundings");
    assert!(hits > n / 4 && textbook > n / 2, "the case tests nothing");
}

/// Three points that are collinear except for rounding.
fn needle(rng: &mut Rng) -> [DVec3; 3] {
    let (a, b) = (rng.in_cube(), rng.in_cube());
    let c = a + rng.range(-2.0, 2.0) * (b - a);
    let scale = power(exponents(rng)[0]);
    [a, b, c].map(|v| scale * v)
}

#[test]
fn case_20_normals_of_needles() {
    let one = |index| {
        let needle = needle(&mut Rng::at(2021, index));
        let exact = exact_triangle::normal(needle);
        let found = normal(needle);
        let edges = [needle[1] - needle[0], needle[2] - needle[0]];
        let textbook = edges[0].normalize().cross(edges[1].normalize()).normalize();
        if exact == DVec3::ZERO {
            return ([found.is_finite() as u64, 0], []);
        }
        let right = |normal: DVec3| normal.distance(exact.normalize()) < 1e-6;
        ([!right(found) as u64, !right(textbook) as u64], [])
    };
    let n = rays(20_000, 2_000_000);
    let ([wrong, textbook], []) = measure(n, one);
    assert_eq!(wrong, 0);
    assert!(textbook > n / 2, "the case tests nothing");
}

#[test]
fn case_20_triangles_that_are_not_finite_are_missed() {
    let triangle = [DVec3::new(-1.0, -1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), DVec3::new(0.0, 1.0, 1.0)];
    let (inf, nan) = (f64::INFINITY, f64::NAN);
    for (origin, direction) in [
        (DVec3::ZERO, DVec3::new(0.0, 0.0, inf)),
        (DVec3::ZERO, DVec3::new(inf, 0.0, -inf)),
        (DVec3::ZERO, DVec3::new(0.0, 0.0, nan)),
        (DVec3::ZERO, DVec3::ZERO),
        (DVec3::new(nan, 0.0, 0.0), DVec3::Z),
        (DVec3::new(0.0, 0.0, -inf), 1e60 * DVec3::Z),
        (DVec3::new(0.0, -inf, -inf), 1e60 * DVec3::new(0.0, 1.0, 1.0)),
    ] {
        let ray = Ray::new(origin, direction);
        assert_eq!(Shear::new(&ray).intersect(triangle.each_ref()), None, "{ray:?}");
    }
}

/// The bytes of the colour, the depth and the normal picture.
fn pictures(scene: &Scene, caster: &Caster) -> [Vec<u8>; 3] {
    let wanted = vec![Layer::Color, Layer::Depth { near: -1.0, far: 1.0 }, Layer::Normals];
    let request = Request { layers: wanted, ..Request::new([12, 12]) };
    layers(scene, caster, &request, Tracing::Fast).try_into().expect("three layers")
}

/// A mesh shrunk to a point, or almost, seen along directions whose coordinates have very different sizes.
#[test]
fn case_20_a_mesh_without_extent_is_not_seen() {
    let directions = ["1 64 1e-300", "1 64 1e-320", "1e-300 64 1", "1 1e-160 1e-161", "1 64 1e-20"];
    for (scale, direction) in ["0", "1e-170"].into_iter().flat_map(|s| directions.map(|d| (s, d))) {
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction {direction} up 0 0 1 size 5 }}
             Background {{ color 0.25 0.5 1 }} Materials {{ numMaterials 1 Material {{ }} }}
             Group {{ numObjects 1 MaterialIndex 0
               Transform {{ UniformScale {scale} TriangleMesh {{ obj_file m.obj }} }} }}"
        );
        let scene = parse(&text).expect("a scene of one mesh");
        let world = World::new(&scene, &[bunny("200")]).expect("a world of one mesh");
        for options in [Layout::List, Layout::Grid([4; 3]), Layout::Tree] {
            let caster = Caster::with(&world, options, instructions::available()[0]);
            let [color, depth, normals] = pictures(&scene, &caster.expect("a small grid"));
            assert!(color.chunks(3).all(|pixel| pixel == [63, 127, 255]), "{scale} {direction}");
            assert!(depth.iter().chain(&normals).all(|&byte| byte == 0), "{scale} {direction}");
        }
    }
}
