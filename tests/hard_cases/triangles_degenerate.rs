//! Section A, cases 15 to 18: triangles seen edge on, without area, duplicated, and with their vertices in
//! another order.

use crate::support::brute::Brute;
use crate::support::exact::exact;
use crate::support::exact_triangle::{Exact, intersect, intersect_by_rule};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, aimed, bunny, middle_and_reach, point_in, rounded, shuffle, world_of};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::textbook::{lower, lower_triangle, moller_trumbore};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use num_traits::Signed;
use raytracer::grid::Caster;
use raytracer::math::ray::Ray;
use raytracer::primitive::triangle::Shear;
use raytracer::scene::mesh::Mesh;
use raytracer::stats::Quiet;
use raytracer::world::World;

/// The six orders of three vertices. The last three reverse the winding.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];

/// An integer from -n to n.
fn integer(rng: &mut Rng, n: usize) -> f64 {
    rng.below(2 * n + 1) as f64 - n as f64
}

fn integer_vector(rng: &mut Rng, n: usize) -> DVec3 {
    DVec3::new(integer(rng, n), integer(rng, n), integer(rng, n))
}

/// A ray and a triangle that are exactly in one plane: all their vectors are integer combinations of two
/// integer vectors. Every other time two of the vertices are on the ray itself.
fn coplanar(rng: &mut Rng, direction: DVec3) -> (Ray, [DVec3; 3]) {
    let (origin, other) = (integer_vector(rng, 1000), integer_vector(rng, 1000));
    let through_edge = rng.below(2) == 0;
    let triangle = [0, 1, 2].map(|k| {
        let off = if through_edge && k < 2 { 0.0 } else { integer(rng, 50) };
        origin + (60.0 + integer(rng, 50)) * direction + off * other
    });
    (Ray::new(origin, direction), triangle)
}

/// The answers for a coplanar triangle in the six orders: whether they disagree, whether t is not finite,
/// whether it is hit, and whether the textbook's answers disagree.
fn coplanar_answers(ray: &Ray, triangle: [DVec3; 3]) -> [u64; 4] {
    let orders = ORDERS.map(|o| o.map(|k| triangle[k]));
    let ours = orders.map(|t| Shear::new(ray).intersect(t.each_ref()));
    let (o, d) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
    let textbook = orders.map(|t| moller_trumbore(o, d, lower_triangle(t), 0.0).is_some());
    [
        ours.iter().any(|t| t.is_some() != ours[0].is_some()) as u64,
        ours.iter().flatten().any(|t| !t.is_finite()) as u64,
        ours[0].is_some() as u64,
        textbook.iter().any(|&hit| hit != textbook[0]) as u64,
    ]
}

#[test]
fn case_15_a_ray_in_the_plane_of_the_triangle() {
    const SEED: u64 = 1015;
    let n = rays(60_000, 6_000_000);
    let failures = Failures::default();
    let count = |sheared_exactly: bool| {
        let one = |index| {
            let rng = &mut Rng::at(SEED, index);
            // Divided by 64 the shear of the ray is exact, and divided by another length it is rounded.
            let longest = if sheared_exactly { 64.0 } else { 67.0 + rng.below(50) as f64 };
            let mut direction = integer_vector(rng, 60);
            direction[rng.below(3)] = longest;
            let (ray, triangle) = coplanar(rng, direction);
            assert_eq!(intersect(&ray, triangle), Exact::Coplanar);
            let counts = coplanar_answers(&ray, triangle);
            let wrong = counts[..3] != [0; 3];
            failures.note(wrong, || failed_ray(15, SEED, index, ray.origin, ray.direction));
            (counts, [])
        };
        measure::<4, 0>(n, one).0
    };
    let (exactly, roughly) = (count(true), count(false));
    Record {
        case: 15,
        basis: Basis::Sampled,
        name: "a ray in the triangle's plane",
        inputs: format!("{} rays, 6 orders of the vertices", 2 * n),
        measure: "answers that depend on the order, not a number; hits",
        textbook: format!("Moeller-Trumbore f32: {} depend on the order", exactly[3] + roughly[3]),
        ours: format!(
            "{} depend on the order, {} not a number, {} hits",
            exactly[0] + roughly[0],
            exactly[1] + roughly[1],
            exactly[2] + roughly[2],
        ),
        target: "0, miss by rule",
    }
    .write();
    assert_eq!((&exactly[..3], &roughly[..3]), (&[0; 3][..], &[0; 3][..]));
    assert!(exactly[3] + roughly[3] > 0, "the case tests nothing");
}

/// The mesh with as many triangles without area mixed in: a vertex repeated twice or three times, or three
/// points of one line.
fn with_degenerate_triangles(mesh: &Mesh, seed: u64) -> Mesh {
    let mut mixed = mesh.clone();
    let rng = &mut Rng::new(seed);
    let first = mesh.triangles.len();
    for i in 0..first {
        let [a, b, _] = mesh.triangles[i];
        let [p, q] = [a, b].map(|v| mesh.vertices[v as usize]);
        let degenerate = match rng.below(4) {
            0 => [a, a, a],
            1 => [a, b, a],
            2 => [b, a, a],
            _ => {
                // The far point is exact, since these are floats of 24 bits and the factor is small.
                mixed.vertices.push(p + (1.0 + rng.below(3) as f64) * (q - p));
                [a, b, mixed.vertices.len() as u32 - 1]
            }
        };
        mixed.triangles.push(degenerate);
    }
    shuffle(&mut mixed.triangles, rng);
    mixed
}

/// Rays from around a mesh to its vertices, edges and faces.
fn at_everything(mesh: &Closed, rng: &mut Rng, index: u64) -> Ray {
    let (middle, reach) = middle_and_reach(&mesh.mesh);
    let origin = rounded(middle + 4.0 * reach * rng.direction());
    let vertex = |i: u32| mesh.mesh.vertices[i as usize];
    let target = match index % 3 {
        0 => vertex(rng.below(mesh.mesh.vertices.len()) as u32),
        1 => {
            let [a, b] = mesh.edges[rng.below(mesh.edges.len())];
            vertex(a).lerp(vertex(b), rng.unit())
        }
        _ => point_in(mesh.corners(rng.below(mesh.mesh.triangles.len()) as u32), rng),
    };
    aimed(origin, target, index.is_multiple_of(2))
}

#[test]
fn case_16_triangles_without_area() {
    const SEED: u64 = 1016;
    let plain = Closed::new(bunny("5k"));
    let mixed = with_degenerate_triangles(&plain.mesh, SEED);
    let (world, mixed_world) = (world_of(&plain.mesh), world_of(&mixed));
    let cells = Some([40; 3]);
    let caster = Caster::new(&world, cells).expect("a small grid");
    let mixed_caster = Caster::new(&mixed_world, cells).expect("a small grid");
    let failures = Failures::default();
    let n = rays(100_000, 10_000_000);
    let one = |index| {
        let ray = at_everything(&plain, &mut Rng::at(SEED, index), index);
        let [without, with] = [&caster, &mixed_caster].map(|c| {
            let hit = c.closest(&ray, &mut Quiet)?;
            Some((hit.t.to_bits(), c.world.surface(&ray, &hit).normal))
        });
        let wrong = without != with || with.is_some_and(|(_, normal)| normal.is_nan());
        failures.note(wrong, || failed_ray(16, SEED, index, ray.origin, ray.direction));
        ([wrong as u64, textbook_breaks(&ray, &mixed, index) as u64], [])
    };
    let ([wrong, textbook], []) = measure(n, one);
    Record {
        case: 16,
        basis: Basis::Sampled,
        name: "triangles without area mixed in",
        inputs: format!("{n} rays, {} triangles of which half have no area", mixed.triangles.len()),
        measure: "hits that change, or have no normal",
        textbook: format!("Moeller-Trumbore f32 with no test of the determinant: {textbook} not a number"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    assert!(textbook > 0, "the case tests nothing");
}

/// Whether dividing by the determinant without a check gives NaN for some triangle.
fn textbook_breaks(ray: &Ray, mesh: &Mesh, index: u64) -> bool {
    let t = mesh.triangles[index as usize % mesh.triangles.len()].map(|v| mesh.vertices[v as usize]);
    let (o, d) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
    // An epsilon below zero accepts every determinant.
    let t = lower_triangle(t);
    let [e1, e2] = [1, 2].map(|k| glam::Vec3::from_array(t[k]) - glam::Vec3::from_array(t[0]));
    let determinant = e1.dot(glam::Vec3::from_array(d).cross(e2));
    let s = glam::Vec3::from_array(o) - glam::Vec3::from_array(t[0]);
    (e2.dot(s.cross(e1)) / determinant).is_nan()
}

/// The hit that the rule selects, computed exactly: the nearest one; of equally near ones the one whose
/// corners have the smaller coordinate at the first difference; of identical ones the one with the smallest
/// id.
fn canonical(world: &World, near: impl Iterator<Item = u32>, ray: &Ray) -> Option<u32> {
    let corners = |i: u32| world.corners(i as usize);
    let hits = near.filter(|&i| may_hit(ray, corners(i))).filter_map(|i| {
        let t = intersect_by_rule(ray, corners(i))?;
        (!t.is_negative()).then(|| (t, corners(i).map(|v| v.to_array().map(exact)), i))
    });
    hits.min().map(|(_, _, i)| i)
}

/// Whether a ray may hit a triangle. Plain arithmetic is accurate enough for this.
fn may_hit(ray: &Ray, triangle: [DVec3; 3]) -> bool {
    let [a, b, c] = triangle.map(|v| v - ray.origin);
    let longest = a.length().max(b.length()).max(c.length());
    let clear = 1e-9 * longest * longest * ray.direction.length();
    let edges = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(ray.direction));
    edges.iter().all(|&x| x < clear) || edges.iter().all(|&x| x > -clear)
}

/// Counts the rays for which the caster's hit is not the canonical one, and those for which the last of
/// equally near hits is another one.
fn count_other_hits(
    seed: u64,
    n: u64,
    world: &World,
    caster: &Caster,
    draw: impl Fn(&mut Rng, u64) -> Ray + Sync,
) -> [u64; 2] {
    let brute = Brute::new(world);
    let failures = Failures::default();
    let one = |index| {
        let ray = draw(&mut Rng::at(seed, index), index);
        let found = caster.closest(&ray, &mut Quiet).map(|hit| hit.primitive);
        let expected = canonical(world, brute.near(&ray), &ray);
        failures.note(found != expected, || failed_ray(17, seed, index, ray.origin, ray.direction));
        let last_wins = last_of_the_nearest(&brute, world, &ray);
        ([(found != expected) as u64, (last_wins != expected) as u64], [])
    };
    measure::<2, 0>(n, one).0
}

/// A mesh with every triangle twice, in random order.
fn doubled(mesh: &Mesh, seed: u64) -> Mesh {
    let mut triangles = [mesh.triangles.as_slice(); 2].concat();
    shuffle(&mut triangles, &mut Rng::new(seed));
    Mesh { vertices: mesh.vertices.clone(), triangles }
}

/// Triangles that overlap in one plane across an axis, each with its corners in any order. Some of them are
/// duplicated.
fn overlapping(seed: u64) -> Mesh {
    let rng = &mut Rng::new(seed);
    let vertices = (0..40).map(|_| DVec3::new(integer(rng, 20), integer(rng, 20), 0.0) / 7.0).collect();
    let triangles: Vec<_> = (0..300).map(|_| [0; 3].map(|_| rng.below(40) as u32)).collect();
    doubled(&Mesh { vertices, triangles }, seed)
}

/// A ray at a vertex, an edge or the inside of such a triangle. It is longest across the plane, so that t is
/// rounded in the same way for all.
fn at_overlapping(mesh: &Mesh, rng: &mut Rng) -> Ray {
    let corner = |i: usize| mesh.vertices[i];
    let [a, b, c] = mesh.triangles[rng.below(mesh.triangles.len())].map(|i| corner(i as usize));
    let target = [a, 0.5 * (a + b), (a + b + c) / 3.0][rng.below(3)];
    let origin = DVec3::new(integer(rng, 20), integer(rng, 20), 41.0 + rng.unit()) / 7.0;
    let across = rng.below(3) == 0;
    let origin = if across { DVec3::new(target.x, target.y, origin.z) } else { origin };
    Ray::new(origin, target - origin)
}

#[test]
fn case_17_every_triangle_twice() {
    const SEED: u64 = 1017;
    let plain = Closed::new(bunny("5k"));
    let cells = Some([40; 3]);
    let n = rays(20_000, 10_000_000);
    let twice = world_of(&doubled(&plain.mesh, SEED));
    let caster = Caster::new(&twice, cells).expect("a small grid");
    let of_mesh = count_other_hits(SEED, n, &twice, &caster, |rng, index| at_everything(&plain, rng, index));
    let overlapping = overlapping(SEED);
    let flat = world_of(&overlapping);
    let caster = Caster::new(&flat, Some([5, 5, 1])).expect("a small grid");
    let draw = |rng: &mut Rng, _| at_overlapping(&overlapping, rng);
    let of_plane = count_other_hits(SEED + 1, n / 4, &flat, &caster, draw);
    let [wrong, textbook] = [0, 1].map(|k| of_mesh[k] + of_plane[k]);
    Record {
        case: 17,
        basis: Basis::Sampled,
        name: "every triangle twice, shuffled, and overlapping ones in one plane",
        inputs: format!("{} rays", n + n / 4),
        measure: "rays whose hit is not the one of the rule",
        textbook: format!("the last of equal hits wins: {textbook} depend on the order of tests"),
        ours: wrong.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(wrong, 0);
    assert!(of_mesh[1] > 0 && of_plane[1] > 0, "the case tests nothing");
}

/// The hit that a loop with `t <= nearest` finds.
fn last_of_the_nearest(brute: &Brute, world: &World, ray: &Ray) -> Option<u32> {
    let shear = Shear::new(ray);
    let (mut nearest, mut found) = (f64::INFINITY, None);
    for i in brute.near(ray) {
        let t = shear.intersect(world.corners_in_place(i as usize));
        if let Some(t) = t.filter(|&t| ray.covers(t) && t <= nearest) {
            (nearest, found) = (t, Some(i));
        }
    }
    found
}

/// The number of floats between two floats of the same sign.
fn floats_between(a: f64, b: f64) -> u64 {
    a.to_bits().abs_diff(b.to_bits())
}

#[test]
fn case_18_the_order_of_the_vertices() {
    const SEED: u64 = 1018;
    let mesh = Closed::new(bunny("1k"));
    let world = world_of(&mesh.mesh);
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let n = rays(100_000, 10_000_000);
    let one = |index: u64| {
        let rng = &mut Rng::at(SEED, index);
        let ray = at_everything(&mesh, rng, index);
        let shear = Shear::new(&ray);
        let (o, d) = (lower::<f64>(ray.origin), lower::<f64>(ray.direction));
        let (mut changed, mut textbook, mut apart) = (0, 0, 0);
        for i in brute.near(&ray) {
            let corners = mesh.corners(i);
            let in_order = |[i, j, k]: [usize; 3]| [corners[i], corners[j], corners[k]];
            let first = shear.intersect(corners.each_ref());
            let their_first = moller_trumbore(o, d, lower_triangle(corners), 0.0).is_some();
            for order in ORDERS {
                let t = shear.intersect(in_order(order).each_ref());
                changed += (t.is_some() != first.is_some()) as u64;
                if let (Some(t), Some(first)) = (t, first) {
                    apart = apart.max(floats_between(t, first));
                }
                // A fifth of the rays is enough to see the textbook's method fail.
                if index.is_multiple_of(5) {
                    let theirs = moller_trumbore(o, d, lower_triangle(in_order(order)), 0.0).is_some();
                    textbook += (theirs != their_first) as u64;
                }
            }
        }
        let wrong = changed > 0 || apart > 4;
        failures.note(wrong, || failed_ray(18, SEED, index, ray.origin, ray.direction));
        ([changed, textbook], [apart as f64])
    };
    let ([changed, textbook], [apart]) = measure(n, one);
    Record {
        case: 18,
        basis: Basis::Sampled,
        name: "vertices in all six orders",
        inputs: format!("{n} rays"),
        measure: "hits that change; largest change of t, in units in the last place",
        textbook: format!("Moeller-Trumbore f64: {textbook} hits change on a fifth of the rays"),
        ours: format!("{changed}; {apart}"),
        target: "0; 4",
    }
    .write();
    assert!(changed == 0 && apart <= 4.0, "{changed} {apart}");
    assert!(textbook > 0, "the case tests nothing");
}
