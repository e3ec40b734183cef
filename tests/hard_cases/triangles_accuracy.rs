//! Section A, cases 9 to 13: the t of a triangle and the decision whether it is hit, compared with exact
//! rationals.

use crate::support::exact_triangle::{Exact, intersect, relative_error};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, aimed, bunny, center_and_radius, moved, point_in, rounded};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::textbook::{Edges, baldwin_weber, lower, lower_triangle, moller_trumbore, woop};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use num_traits::ToPrimitive;
use raytracer::math::ray::Ray;
use raytracer::world::triangle::Shear;

/// The errors of the methods: ours, Moeller-Trumbore, Woop and Baldwin-Weber, the last three in f32.
#[derive(Debug)]
struct Measured {
    /// Hits where there is none, and misses where there is one.
    wrong: [u64; 4],
    /// The largest relative errors of t, where both a method and the reference have a hit.
    error: [f64; 4],
    /// The number of pairs of a ray and a triangle that were compared.
    pairs: u64,
}

/// Compares each triangle that `draw` returns with its ray with the exact answer.
fn compare(
    case: u32,
    n: u64,
    draw: impl Fn(&mut Rng, u64) -> (Ray, Vec<[DVec3; 3]>) + Sync,
    worst: f64,
) -> Measured {
    let seed = 1000 + case as u64;
    let failures = Failures::default();
    let one = |index| {
        let (ray, triangles) = draw(&mut Rng::at(seed, index), index);
        let (mut counts, mut errors) = ([0; 5], [0.0f64; 4]);
        for t in triangles {
            let found = answers(&ray, t);
            let exact = match intersect(&ray, t) {
                Exact::Inside(t) => Some(t),
                Exact::Outside => None,
                // Here the rule for edges decides, which the watertight cases test.
                Exact::Boundary(_) | Exact::Coplanar => continue,
            };
            counts[4] += 1;
            let nearest = exact.as_ref().and_then(|t| t.to_f64()).unwrap_or(f64::NAN);
            for (method, found) in found.into_iter().enumerate() {
                counts[method] += (found.is_some() != exact.is_some()) as u64;
                if let (Some(found), Some(exact)) = (found, &exact) {
                    let error = match method {
                        0 => relative_error(found, exact),
                        // An exact computation is not needed for these.
                        _ => ((found - nearest) / nearest).abs(),
                    };
                    errors[method] = errors[method].max(error);
                }
            }
        }
        let failed = counts[0] > 0 || errors[0] > worst;
        failures.note(failed, || failed_ray(case, seed, index, ray.origin, ray.direction));
        (counts, errors)
    };
    let ([a, b, c, d, pairs], error) = measure(n, one);
    Measured { wrong: [a, b, c, d], error, pairs }
}

fn answers(ray: &Ray, triangle: [DVec3; 3]) -> [Option<f64>; 4] {
    let (o, d, t) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction), lower_triangle::<f32>(triangle));
    [
        Shear::new(ray).intersect(triangle.each_ref()),
        moller_trumbore(o, d, t, 0.0).map(f64::from),
        woop(o, d, t, Edges::Inclusive).map(f64::from),
        baldwin_weber(o, d, t).map(f64::from),
    ]
}

impl Measured {
    fn record(&self, case: u32, name: &str, target: &str) {
        let [ours, mt, woop, bw] =
            [0, 1, 2, 3].map(|i| format!("{} wrong, t off by {:.1e}", self.wrong[i], self.error[i]));
        Record {
            case,
            basis: Basis::Sampled,
            name,
            inputs: format!("{} pairs of ray and triangle", self.pairs),
            measure: "wrong decisions, largest relative error of t",
            textbook: format!("Moeller-Trumbore f32 {mt}; Woop f32 {woop}; Baldwin-Weber f32 {bw}"),
            ours,
            target,
        }
        .write();
    }
}

#[test]
fn case_09_needles() {
    let draw = |rng: &mut Rng, index: u64| {
        let along = rng.direction();
        let across = along.cross(rng.direction()).normalize();
        let start = rng.in_cube();
        let needle = [start, start + along, start + rng.unit() * along + 1e-4 * across].map(rounded);
        let target = point_in(needle, rng);
        let origin = rounded(target + rng.range(1.0, 5.0) * rng.direction());
        (aimed(origin, target, index.is_multiple_of(2)), vec![needle])
    };
    let m = compare(9, rays(100_000, 10_000_000), draw, 1e-11);
    m.record(9, "needles, 1 by 1e-4", "0 wrong, t within 1e-11");
    assert!(m.wrong[0] == 0 && m.error[0] <= 1e-11, "{m:?}");
    assert!(m.wrong[1] > 0 && m.error[1] > 1e-3, "the case tests nothing: {m:?}");
}

#[test]
fn case_10_grazing() {
    let draw = |rng: &mut Rng, index: u64| {
        let normal = rng.direction();
        let x = normal.cross(rng.direction()).normalize();
        let y = normal.cross(x);
        let corner = rng.in_cube();
        let triangle = [corner, corner + 4.0 * x, corner + 4.0 * y].map(rounded);
        let target = point_in(triangle, rng);
        let angle = rng.range(0.0, std::f64::consts::TAU);
        let level = libm::cos(angle) * x + libm::sin(angle) * y;
        let origin = rounded(target + 5.0 * (level + 1e-3 * normal));
        (aimed(origin, target, index.is_multiple_of(2)), vec![triangle])
    };
    let m = compare(10, rays(100_000, 10_000_000), draw, 1e-12);
    m.record(10, "grazing at 1e-3", "0 wrong, t within 1e-12");
    assert!(m.wrong[0] == 0 && m.error[0] <= 1e-12, "{m:?}");
    assert!(m.error[1] > 1e-6, "the case tests nothing: {m:?}");
}

/// Rays from a distance around a mesh to random points on it, with the triangles around the point.
fn at_surface(mesh: &Closed, distance: f64) -> impl Fn(&mut Rng, u64) -> (Ray, Vec<[DVec3; 3]>) + Sync {
    let (center, _) = center_and_radius(&mesh.mesh);
    move |rng, index| {
        let target = rng.below(mesh.mesh.triangles.len());
        let point = point_in(mesh.corners(target as u32), rng);
        let origin = rounded(center + distance * rng.direction());
        let d = point - origin;
        // The direction is not rounded to f32: from far away no such direction would hit its target.
        let ray = Ray::new(origin, if index.is_multiple_of(2) { d.normalize() } else { d });
        let [a, b, _] = mesh.mesh.triangles[target];
        (ray, mesh.around([a, b]).into_iter().map(|i| mesh.corners(i)).collect())
    }
}

#[test]
fn case_11_distance_of_a_mesh() {
    let mesh = Closed::new(bunny("40k"));
    let m = compare(11, rays(12_000, 1_000_000), at_surface(&mesh, 1.6), 1e-13);
    m.record(11, "distance of the rabbit, seen from 1.6", "0 wrong, t within 1e-13");
    assert!(m.wrong[0] == 0 && m.error[0] <= 1e-13, "{m:?}");
    assert!(m.error[1] > 1e-6, "the case tests nothing: {m:?}");
}

#[test]
fn case_12_a_mesh_seen_from_afar() {
    let mesh = Closed::new(bunny("40k"));
    let m = compare(12, rays(12_000, 1_000_000), at_surface(&mesh, 1e4), 1e-13);
    m.record(12, "the rabbit seen from 1e4", "0 wrong");
    assert!(m.wrong[0] == 0, "{m:?}");
    assert!(m.wrong[1] > 0 && m.wrong[2] > 0, "the case tests nothing: {m:?}");
}

#[test]
fn case_13_a_mesh_far_from_the_origin() {
    let mesh = Closed::new(moved(&bunny("40k"), |v| rounded(v + 1e3)));
    let m = compare(13, rays(12_000, 1_000_000), at_surface(&mesh, 1.6), 1e-13);
    m.record(13, "the rabbit at (1e3, 1e3, 1e3)", "0 wrong, t within 1e-13");
    assert!(m.wrong[0] == 0 && m.error[0] <= 1e-13, "{m:?}");
    assert!(m.wrong[3] > m.pairs / 100, "the case tests nothing: {m:?}");
}
