//! Leaks: rays from inside a convex mesh that leave it without a hit, counted for several methods.

use super::failed_ray;
use super::measure::{Failures, measure};
use super::meshes::{Closed, aimed, icosphere, rounded};
use super::rng::Rng;
use super::scenes::world_of_mesh;
use super::textbook::{Edges, baldwin_weber, lower, lower_triangle, moller_trumbore, plucker, woop};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::math::ray::Ray;
use raytracer::world::triangle::Shear;

/// What rays are aimed at.
#[derive(Clone, Copy)]
pub enum Aim {
    Vertex,
    Edge,
}

/// For each method, the number of triangles around a ray's target that it hits in front of the origin.
pub struct Hits {
    pub ours: u64,
    pub moller_trumbore_f32: u64,
    pub moller_trumbore_f64: u64,
    pub baldwin_weber_f32: u64,
    pub plucker_f32: u64,
    pub contracted_f32: u64,
    pub inclusive_f64: u64,
}

/// Counts the triangles that a ray hits, by each method.
pub fn hits(ray: &Ray, triangles: impl Iterator<Item = [DVec3; 3]>) -> Hits {
    let shear = Shear::new(ray);
    let (o, d) = (lower::<f64>(ray.origin), lower::<f64>(ray.direction));
    let (o32, d32) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
    let mut hits = Hits {
        ours: 0,
        moller_trumbore_f32: 0,
        moller_trumbore_f64: 0,
        baldwin_weber_f32: 0,
        plucker_f32: 0,
        contracted_f32: 0,
        inclusive_f64: 0,
    };
    let in_front = |t: Option<f64>| t.is_some_and(|t| t > 0.0) as u64;
    let in_front_f32 = |t: Option<f32>| t.is_some_and(|t| t > 0.0) as u64;
    for t in triangles {
        let (t64, t32) = (lower_triangle::<f64>(t), lower_triangle::<f32>(t));
        hits.ours += in_front(shear.intersect(t.each_ref()));
        hits.moller_trumbore_f32 += in_front_f32(moller_trumbore(o32, d32, t32, 0.0));
        hits.moller_trumbore_f64 += in_front(moller_trumbore(o, d, t64, 0.0));
        hits.baldwin_weber_f32 += in_front_f32(baldwin_weber(o32, d32, t32));
        hits.plucker_f32 += in_front_f32(plucker(o32, d32, t32));
        hits.contracted_f32 += in_front_f32(woop(o32, d32, t32, Edges::Contracted));
        hits.inclusive_f64 += in_front(woop(o, d, t64, Edges::Inclusive));
    }
    hits
}

/// A convex mesh with rays from inside it to its vertices or edges.
pub struct Inside {
    pub mesh: Closed,
    center: DVec3,
    radius: f64,
    aim: Aim,
}

impl Inside {
    pub fn new(radius: f64, center: DVec3, aim: Aim) -> Self {
        Self { mesh: icosphere(5, radius, center), center, radius, aim }
    }

    /// A ray from the inner half of the ball, and the triangles around its target.
    pub fn draw(&self, seed: u64, index: u64) -> (Ray, Vec<u32>) {
        let rng = &mut Rng::at(seed, index);
        let origin = rounded(self.center + 0.5 * self.radius * rng.in_ball());
        let vertex = |i: u32| self.mesh.mesh.vertices[i as usize];
        let (target, around) = match self.aim {
            Aim::Vertex => {
                let i = rng.below(self.mesh.mesh.vertices.len());
                (vertex(i as u32), self.mesh.rings[i].clone())
            }
            Aim::Edge => {
                let edge = self.mesh.edges[rng.below(self.mesh.edges.len())];
                (vertex(edge[0]).lerp(vertex(edge[1]), rng.unit()), self.mesh.around(edge))
            }
        };
        (aimed(origin, target, index.is_multiple_of(2)), around)
    }

    /// Counts the leaks of ours, with and without a grid, and of the textbook's methods. Then the rays with
    /// more than one hit, by ours and by the published rule.
    pub fn count(&self, case: u32, seed: u64, n: u64) -> Counts {
        let world = world_of_mesh(&self.mesh.mesh);
        let caster = Caster::new(&world, Some([24; 3])).expect("a small grid");
        let failures = Failures::default();
        let one = |index| {
            let (ray, around) = self.draw(seed, index);
            let hits = hits(&ray, around.iter().map(|&i| self.mesh.corners(i)));
            let through_grid = index % 8 != 0 || caster.closest(&ray).is_some();
            let leak = hits.ours == 0 || !through_grid;
            let double = hits.ours > 1;
            failures.note(leak || double, || failed_ray(case, seed, index, ray.origin, ray.direction));
            let missed = |hits: u64| (hits == 0) as u64;
            let counts = [
                leak as u64,
                double as u64,
                missed(hits.moller_trumbore_f32),
                missed(hits.moller_trumbore_f64),
                missed(hits.baldwin_weber_f32),
                missed(hits.plucker_f32),
                missed(hits.contracted_f32),
                (hits.inclusive_f64 > 1) as u64,
            ];
            (counts, [])
        };
        Counts(measure::<8, 0>(n, one).0)
    }
}

/// The counts of [`Inside::count`].
pub struct Counts([u64; 8]);

impl Counts {
    pub fn leaks(&self) -> u64 {
        self.0[0]
    }
    pub fn doubles(&self) -> u64 {
        self.0[1]
    }
    pub fn moller_trumbore_f32(&self) -> u64 {
        self.0[2]
    }
    pub fn inclusive_doubles(&self) -> u64 {
        self.0[7]
    }
    /// The leaks of the textbook's methods.
    pub fn textbook(&self) -> String {
        let [_, _, mt32, mt64, bw, pl, contracted, _] = self.0;
        format!(
            "Moeller-Trumbore f32 {mt32}, f64 {mt64}; Baldwin-Weber f32 {bw}; Pluecker with margin f32 {pl}; \
             Woop f32 contracted {contracted}"
        )
    }
}
