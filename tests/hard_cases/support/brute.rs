//! Every triangle against a ray, without any grid: the oracle of the grid's cases.
//!
//! Triangles stand in clusters of neighbours. A cluster is skipped when the ray's line keeps clear
//! of a ball half as large again as it needs to be, which no rounding can undo; apart from that
//! nothing is left out.

use glam::DVec3;
use raytracer::math::ray::{Hit, Ray};
use raytracer::primitive::triangle::Shear;
use raytracer::world::World;

pub struct Brute<'w> {
    world: &'w World,
    clusters: Vec<Cluster>,
}

struct Cluster {
    center: DVec3,
    radius: f64,
    triangles: Vec<u32>,
}

impl<'w> Brute<'w> {
    pub fn new(world: &'w World) -> Self {
        let mut clusters = Vec::new();
        split(world, (0..world.triangles.len() as u32).collect(), &mut clusters);
        Self { world, clusters }
    }

    /// The nearest hit, and of equally near ones that of the lowest number.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.each_hit(ray, |hit| {
            if best.is_none_or(|b| hit.t < b.t || (hit.t == b.t && hit.primitive < b.primitive)) {
                best = Some(hit);
            }
        });
        best
    }

    /// How many triangles the ray crosses.
    pub fn crossings(&self, ray: &Ray) -> u64 {
        let mut count = 0;
        self.each_hit(ray, |_| count += 1);
        count
    }

    /// The triangles that stand near the ray's line, in no order.
    pub fn near(&self, ray: &Ray) -> impl Iterator<Item = u32> {
        let line = ray.direction.normalize();
        let origin = ray.origin;
        let is_near = move |c: &&Cluster| {
            let from_line = line.cross(c.center - origin).length();
            from_line <= 1.5 * c.radius + 1e-9 * (c.center - origin).length()
        };
        self.clusters.iter().filter(is_near).flat_map(|c| c.triangles.iter().copied())
    }

    fn each_hit(&self, ray: &Ray, mut visit: impl FnMut(Hit)) {
        let shear = Shear::new(ray);
        for primitive in self.near(ray) {
            let crossing = shear.intersect(self.world.corners(primitive as usize));
            if let Some(t) = crossing.map(|c| c.t).filter(|&t| ray.covers(t)) {
                visit(Hit { t, primitive });
            }
        }
    }
}

fn split(world: &World, mut triangles: Vec<u32>, clusters: &mut Vec<Cluster>) {
    const LARGEST: usize = 32;
    let corners = |i: u32| world.corners(i as usize);
    let points = || triangles.iter().flat_map(|&i| corners(i));
    let low = points().fold(DVec3::INFINITY, |a, b| a.min(b));
    let high = points().fold(DVec3::NEG_INFINITY, |a, b| a.max(b));
    let extent = high - low;
    if triangles.len() <= LARGEST {
        clusters.push(Cluster { center: low + 0.5 * extent, radius: 0.5 * extent.length(), triangles });
        return;
    }
    let axis = (0..3).fold(0, |best, i| if extent[i] > extent[best] { i } else { best });
    let place = |i: u32| corners(i).iter().map(|v| v[axis]).sum::<f64>();
    triangles.sort_by(|&i, &j| place(i).total_cmp(&place(j)));
    let rest = triangles.split_off(triangles.len() / 2);
    split(world, triangles, clusters);
    split(world, rest, clusters);
}
