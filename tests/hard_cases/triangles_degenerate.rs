//! Section A, cases 15 and 16: triangles seen edge on, and triangles without area.

use crate::support::exact_triangle::{Exact, intersect};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, VERTEX_ORDERS, bunny};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{lower, lower_triangle, moller_trumbore};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::triangle::Shear;

fn integer_vector(rng: &mut Rng, n: usize) -> DVec3 {
    DVec3::new(rng.integer(n), rng.integer(n), rng.integer(n))
}

/// A ray and a triangle that are exactly in one plane: all their vectors are integer combinations of two
/// integer vectors. Every other time two of the vertices are on the ray itself.
fn coplanar(rng: &mut Rng, direction: DVec3) -> (Ray, [DVec3; 3]) {
    let (origin, other) = (integer_vector(rng, 1000), integer_vector(rng, 1000));
    let through_edge = rng.below(2) == 0;
    let triangle = [0, 1, 2].map(|k| {
        let off = if through_edge && k < 2 { 0.0 } else { rng.integer(50) };
        origin + (60.0 + rng.integer(50)) * direction + off * other
    });
    (Ray::new(origin, direction), triangle)
}

/// The answers for a coplanar triangle in the six orders: whether they disagree, whether t is not finite,
/// whether it is hit, and whether the textbook's answers disagree.
fn coplanar_answers(ray: &Ray, triangle: [DVec3; 3]) -> [u64; 4] {
    let orders = VERTEX_ORDERS.map(|o| o.map(|k| triangle[k]));
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
    // The others keep their order, by which a vertex that several triangles share belongs to one of them.
    let places = (0..first).chain((0..first).map(|_| rng.below(first)));
    let mut placed: Vec<_> = places.zip(mixed.triangles).collect();
    placed.sort_by_key(|&(place, _)| place);
    mixed.triangles = placed.into_iter().map(|(_, triangle)| triangle).collect();
    mixed
}

#[test]
fn case_16_triangles_without_area() {
    const SEED: u64 = 1016;
    let plain = Closed::new(bunny("5k"));
    let mixed = with_degenerate_triangles(&plain.mesh, SEED);
    let (world, mixed_world) = (world_of_mesh(&plain.mesh), world_of_mesh(&mixed));
    let cells = Some([40; 3]);
    let caster = Caster::new(&world, cells).expect("a small grid");
    let mixed_caster = Caster::new(&mixed_world, cells).expect("a small grid");
    let failures = Failures::default();
    let n = rays(100_000, 10_000_000);
    let one = |index| {
        let ray = plain.ray_at(&mut Rng::at(SEED, index), index);
        let [without, with] = [&caster, &mixed_caster].map(|c| {
            let hit = c.closest(&ray)?;
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
