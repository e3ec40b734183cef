//! Section A, cases 17 and 18: the hit depends neither on the order of equal triangles nor on the order of a
//! triangle's vertices.

use crate::support::brute::Brute;
use crate::support::exact_triangle::intersect_by_rule;
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, VERTEX_ORDERS, bunny, shuffle};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{lower, lower_triangle, moller_trumbore};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use num_traits::Signed;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use raytracer::world::triangle::Shear;

/// The hit that the rule selects, computed exactly: the nearest one; of equally near ones the lower triangle.
fn canonical(world: &World, near: impl Iterator<Item = u32>, ray: &Ray) -> Option<u32> {
    let corners = |i: u32| world.corners(i as usize);
    let hits = near.filter(|&i| may_hit(ray, corners(i))).filter_map(|i| {
        let t = intersect_by_rule(ray, corners(i))?;
        (!t.is_negative()).then_some((t, i))
    });
    hits.min().map(|(_, i)| i)
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
        let found = caster.closest(&ray).map(|hit| hit.primitive);
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
    let vertices = (0..40).map(|_| DVec3::new(rng.integer(20), rng.integer(20), 0.0) / 7.0).collect();
    let triangles: Vec<_> = (0..300).map(|_| [0; 3].map(|_| rng.below(40) as u32)).collect();
    doubled(&Mesh { vertices, triangles }, seed)
}

/// A ray at a vertex, an edge or the inside of such a triangle. It is longest across the plane, so that t is
/// rounded in the same way for all.
fn at_overlapping(mesh: &Mesh, rng: &mut Rng) -> Ray {
    let corner = |i: usize| mesh.vertices[i];
    let [a, b, c] = mesh.triangles[rng.below(mesh.triangles.len())].map(|i| corner(i as usize));
    let target = [a, 0.5 * (a + b), (a + b + c) / 3.0][rng.below(3)];
    let origin = DVec3::new(rng.integer(20), rng.integer(20), 41.0 + rng.unit()) / 7.0;
    let across = rng.below(3) == 0;
    let origin = if across { DVec3::new(target.x, target.y, origin.z) } else { origin };
    Ray::new(origin, target - origin)
}

#[test]
fn case_17_every_triangle_twice() {
    const SEED: u64 = 1017;
    let plain = Closed::new(bunny("5k"));
    let cells = Some([40; 3]);
    let n = rays(8_000, 10_000_000);
    let twice = world_of_mesh(&doubled(&plain.mesh, SEED));
    let caster = Caster::new(&twice, cells).expect("a small grid");
    let of_mesh = count_other_hits(SEED, n, &twice, &caster, |rng, index| plain.ray_at(rng, index));
    let overlapping = overlapping(SEED);
    let flat = world_of_mesh(&overlapping);
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
    let world = world_of_mesh(&mesh.mesh);
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let n = rays(100_000, 10_000_000);
    let one = |index: u64| {
        let rng = &mut Rng::at(SEED, index);
        let ray = mesh.ray_at(rng, index);
        let shear = Shear::new(&ray);
        let (o, d) = (lower::<f64>(ray.origin), lower::<f64>(ray.direction));
        let (mut changed, mut textbook, mut apart) = (0, 0, 0);
        for i in brute.near(&ray) {
            let corners = mesh.corners(i);
            let in_order = |[i, j, k]: [usize; 3]| [corners[i], corners[j], corners[k]];
            let first = shear.intersect(corners.each_ref());
            let their_first = moller_trumbore(o, d, lower_triangle(corners), 0.0).is_some();
            for order in VERTEX_ORDERS {
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
