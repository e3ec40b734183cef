//! Section A, cases 1 to 8 and 14: no ray slips between triangles, and none hits two of them.
//!
//! Every ray from inside a convex mesh leaves it through exactly one triangle, which is the reference.

use crate::support::brute::Brute;
use crate::support::leaks::{Aim, Inside, hits};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, aimed, bunny, center_and_radius, rounded};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{Edges, lower, lower_triangle, moller_trumbore, woop};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::math::ray::Ray;
use raytracer::world::triangle::Shear;

fn leak_case(case: u32, name: &str, inside: &Inside) {
    let n = rays(300_000, 100_000_000);
    let counts = inside.count(case, 1000 + case as u64, n);
    Record {
        case,
        basis: Basis::Proved,
        name,
        inputs: format!("{n} rays"),
        measure: "leaks",
        textbook: counts.textbook(),
        ours: format!("{} leaks, {} double hits", counts.leaks(), counts.doubles()),
        target: "0",
    }
    .write();
    assert_eq!((counts.leaks(), counts.doubles()), (0, 0));
    assert!(counts.moller_trumbore_f32() > 0, "the case tests nothing");
}

/// The position at which the tests of a well-known library check watertightness.
const FAR: DVec3 = DVec3::new(148_376.0, 1234.0, -223_423.0);

#[test]
fn case_01_vertices_of_a_unit_sphere() {
    leak_case(1, "vertex leak, unit sphere", &Inside::new(1.0, DVec3::ZERO, Aim::Vertex));
}

#[test]
fn case_02_edges_of_a_unit_sphere() {
    leak_case(2, "edge leak, unit sphere", &Inside::new(1.0, DVec3::ZERO, Aim::Edge));
}

#[test]
fn case_03_vertices_far_from_the_origin() {
    leak_case(3, "vertex leak, far from the origin", &Inside::new(2.0, FAR, Aim::Vertex));
}

#[test]
fn case_04_edges_far_from_the_origin() {
    leak_case(4, "edge leak, far from the origin", &Inside::new(2.0, FAR, Aim::Edge));
}

#[test]
fn case_05_exactly_one_hit() {
    let n = rays(100_000, 25_000_000);
    let places = [
        ("unit vertex", Inside::new(1.0, DVec3::ZERO, Aim::Vertex)),
        ("unit edge", Inside::new(1.0, DVec3::ZERO, Aim::Edge)),
        ("far vertex", Inside::new(2.0, FAR, Aim::Vertex)),
        ("far edge", Inside::new(2.0, FAR, Aim::Edge)),
    ];
    let counts: Vec<_> = places.iter().map(|(name, place)| (name, place.count(5, 1005, n))).collect();
    let wrong: u64 = counts.iter().map(|(_, c)| c.leaks() + c.doubles()).sum();
    let inclusive = counts.iter().map(|(name, c)| format!("{} ({name})", c.inclusive_doubles()));
    Record {
        case: 5,
        basis: Basis::Proved,
        name: "exactly one hit",
        inputs: format!("{} rays", 4 * n),
        measure: "rays with another number of hits than one",
        textbook: format!("Woop f64 inclusive: {}", inclusive.collect::<Vec<_>>().join(", ")),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    // In f64 a ray hits an edge of the unit sphere exactly too rarely to rely on it.
    let bites = |i: usize| counts[i].1.inclusive_doubles() > 0;
    assert!(bites(0) && bites(2) && bites(3), "the case tests nothing");
}

/// The number of triangles that a ray crosses: by ours, by Moeller-Trumbore in f32, and by the inclusive rule
/// in f64.
fn crossings(ray: &Ray, triangles: impl Iterator<Item = [DVec3; 3]>) -> [u64; 3] {
    let shear = Shear::new(ray);
    let (o, d) = (lower::<f64>(ray.origin), lower::<f64>(ray.direction));
    let (o32, d32) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
    let mut count = [0; 3];
    for t in triangles {
        count[0] += shear.intersect(t.each_ref()).is_some_and(|t| ray.covers(t)) as u64;
        count[1] += moller_trumbore(o32, d32, lower_triangle(t), 0.0).is_some_and(|t| t > 0.0) as u64;
        count[2] += woop(o, d, lower_triangle(t), Edges::Inclusive).is_some_and(|t| t > 0.0) as u64;
    }
    count
}

#[test]
fn case_06_a_closed_mesh_is_crossed_an_even_number_of_times() {
    const SEED: u64 = 1006;
    let mesh = Closed::new(bunny("40k"));
    let directed = mesh.mesh.triangles.len() * 3;
    assert_eq!(mesh.edges.len() * 2, directed, "every edge has two sides");
    let (center, _) = center_and_radius(&mesh.mesh);
    let world = world_of_mesh(&mesh.mesh);
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let n = rays(120_000, 10_000_000);
    let one = |index: u64| {
        let rng = &mut Rng::at(SEED, index);
        let origin = rounded(center + 0.6 * rng.direction());
        let ray = aimed(origin, mesh.random_point(rng, index), index.is_multiple_of(2));
        let crossings = crossings(&ray, brute.near(&ray).map(|i| mesh.corners(i)));
        let [odd, moller_trumbore, inclusive] = crossings.map(|n| n % 2);
        failures.note(odd == 1, || failed_ray(6, SEED, index, ray.origin, ray.direction));
        ([odd, moller_trumbore, inclusive], [])
    };
    let ([odd, moller_trumbore, inclusive], []) = measure(n, one);
    Record {
        case: 6,
        basis: Basis::Proved,
        name: "parity of a closed mesh",
        inputs: format!("{n} rays at vertices, edges and random points of the rabbit"),
        measure: "odd numbers of crossings",
        textbook: format!("Moeller-Trumbore f32 {moller_trumbore}; Woop f64 inclusive {inclusive}"),
        ours: odd.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(odd, 0);
    assert!(moller_trumbore > 0 && inclusive > 0, "the case tests nothing");
}

#[test]
fn case_07_a_small_scale() {
    let inside = Inside::new(1e-3, DVec3::ZERO, Aim::Vertex);
    let n = rays(200_000, 10_000_000);
    let counts = inside.count(7, 1007, n);
    let one = |index| {
        let (ray, around) = inside.draw(1007, index);
        let (o, d) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
        let hit = around.iter().any(|&i| {
            moller_trumbore(o, d, lower_triangle(inside.mesh.corners(i)), 1e-6).is_some_and(|t| t > 0.0)
        });
        ([!hit as u64], [])
    };
    let ([missed], []) = measure(n, one);
    Record {
        case: 7,
        basis: Basis::Proved,
        name: "sphere of radius 1e-3",
        inputs: format!("{n} rays"),
        measure: "leaks",
        textbook: format!("Moeller-Trumbore f32 with the paper's epsilon of 1e-6: {missed}"),
        ours: format!("{} leaks, {} double hits", counts.leaks(), counts.doubles()),
        target: "0",
    }
    .write();
    assert_eq!((counts.leaks(), counts.doubles()), (0, 0));
    assert!(missed > n / 2, "the case tests nothing");
}

#[test]
fn case_08_a_large_scale() {
    leak_case(8, "sphere of radius 1e6", &Inside::new(1e6, DVec3::ZERO, Aim::Vertex));
}

/// A triangle of length 1e4 and one of width 1e-3 on the two sides of an edge of length 1e-3: the end points
/// of the edge, the apex of the small one, that of the large one, and the direction in which both are seen.
fn unequal_neighbours(rng: &mut Rng) -> ([DVec3; 4], DVec3) {
    let along = rng.direction();
    let across = along.cross(rng.direction()).normalize();
    let tilt = 0.2 * rng.in_ball();
    let start = rng.in_cube();
    let end = start + 1e-3 * along;
    let small = start + 1e-3 * (rng.unit() * along - across);
    let large = start + 1e4 * (across + tilt);
    ([start, end, small, large].map(rounded), along.cross(across))
}

#[test]
fn case_14_a_large_triangle_beside_a_small_one() {
    const SEED: u64 = 1014;
    let failures = Failures::default();
    let n = rays(200_000, 10_000_000);
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let ([p, q, small, large], front) = unequal_neighbours(rng);
        let target = p.lerp(q, rng.range(0.05, 0.95));
        let origin = rounded(target + rng.range(1.0, 5.0) * (front + 0.3 * rng.in_ball()));
        let ray = aimed(origin, target, index.is_multiple_of(2));
        let hits = hits(&ray, [[p, q, small], [q, p, large]].into_iter());
        failures.note(hits.ours != 1, || failed_ray(14, SEED, index, ray.origin, ray.direction));
        let missed = |hits: u64| (hits == 0) as u64;
        let counts =
            [(hits.ours != 1) as u64, missed(hits.moller_trumbore_f32), missed(hits.baldwin_weber_f32)];
        (counts, [])
    };
    let ([wrong, moller_trumbore, baldwin_weber], []) = measure(n, one);
    Record {
        case: 14,
        basis: Basis::Proved,
        name: "a triangle of 1e4 beside one of 1e-3",
        inputs: format!("{n} rays at the shared edge"),
        measure: "rays that do not hit exactly one",
        textbook: format!(
            "leaks of Moeller-Trumbore f32 {moller_trumbore}, Baldwin-Weber f32 {baldwin_weber}"
        ),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    assert!(moller_trumbore + baldwin_weber > 0, "the case tests nothing");
}
