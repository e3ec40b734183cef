//! How tight the error bounds of the single-precision filter are: hill climbing searches for inputs that need
//! a large fraction of the bound. The reference is the exact test.

use crate::filter::verdicts;
use crate::support::hex;
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use glam::DVec3;
use rayon::prelude::*;
use raytracer::grid::filter::{FilterRay, MAX_DEPTH, Verdict};
use raytracer::grid::triangle8::{Block, FilterErrorBounds, Frame, LANES, NONE};
use raytracer::math::ray::Ray;
use raytracer::primitive::triangle::Shear;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

/// A frame in which coordinates are those of world space.
const FRAME: Frame = Frame { center: [0.0; 4], scale: 1.0, unit: 1.0 };

/// The error bound whose tightness is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// That of an edge function, for the edge opposite this corner.
    Edge(usize),
    /// That of depths, in the comparison with the end of the ray and in the depths that the filter returns.
    Depth,
}

/// The end of the ray.
#[derive(Clone, Copy, Debug)]
enum End {
    /// Just in front of the triangle.
    Before,
    /// The last position at which the hit counts.
    At,
    Beyond,
}

/// A triangle in the box, and a ray whose decision is within the error bound.
#[derive(Clone, Copy, Debug)]
struct Trial {
    corners: [DVec3; 3],
    origin: DVec3,
    /// The barycentric weights of the point that the ray is aimed at.
    weights: [f64; 3],
    /// The end of the ray, for the bound of depths.
    end: End,
}

/// The input of the kernels, and the right answer.
struct Question {
    block: Block,
    ray: FilterRay,
    /// The filter's t of the hit, if the ray hits.
    hit: Option<f64>,
}

impl Trial {
    fn random(rng: &mut Rng, bound: Bound) -> Self {
        let mut weights = [rng.unit(), rng.unit(), rng.unit()];
        if let Bound::Edge(corner) = bound {
            weights[corner] = 0.0;
        }
        // The triangle has any size and is at the other end of the box, sometimes along its diagonal.
        let size = libm::pow(10.0, rng.range(-3.0, 0.3));
        let sign = |rng: &mut Rng| if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let signs = |rng: &mut Rng| DVec3::new(sign(rng), sign(rng), sign(rng));
        let origin = 0.99 * signs(rng);
        let is_diagonal = rng.below(2) == 0;
        let corners = [0; 3].map(|_| {
            let corner = if is_diagonal { signs(rng) } else { rng.in_cube() };
            (size * corner - origin).clamp(DVec3::NEG_ONE, DVec3::ONE)
        });
        let end = [End::Before, End::At, End::Beyond][rng.below(3)];
        Self { corners, origin, weights, end }
    }

    /// A copy with one coordinate changed a little.
    fn mutated(mut self, rng: &mut Rng) -> Self {
        for _ in 0..1 + rng.below(3) {
            let step = libm::pow(10.0, rng.range(-9.0, 0.0));
            let shift = |x: f64, rng: &mut Rng| (x + step * rng.range(-1.0, 1.0)).clamp(-1.0, 1.0);
            let axis = rng.below(3);
            match rng.below(5) {
                0 => self.origin[axis] = shift(self.origin[axis], rng),
                1 => self.weights[axis] *= 1.0 + step * rng.range(-1.0, 1.0),
                corner => self.corners[corner - 2][axis] = shift(self.corners[corner - 2][axis], rng),
            }
        }
        self
    }

    /// The bits of the input, so that it can be reproduced exactly.
    fn bits(&self) -> String {
        let coordinates = self.corners.iter().chain([&self.origin]).flat_map(|v| v.to_array());
        let numbers: Vec<String> = coordinates.chain(self.weights).map(hex).collect();
        format!("{} {:?}", numbers.join(", "), self.end)
    }

    fn ray(&self) -> Ray {
        let [a, b, c] = self.corners;
        let [u, v, w] = self.weights;
        Ray::new(self.origin, (u * a + v * b + w * c) / (u + v + w) - self.origin)
    }

    /// The question for the triangle with this id in a world.
    fn question(&self, world: &World, id: u32, bound: Bound) -> Question {
        let mut block: Block = bytemuck::Zeroable::zeroed();
        let mut ids = [NONE; LANES];
        ids[0] = id;
        block.fill(world, &FRAME, true, &ids);
        let ray = self.ray();
        let per_t = ray.direction.abs().max_element();
        let t = Shear::new(&ray).intersect(self.corners.each_ref());
        let last = match (bound, self.end, t) {
            (Bound::Depth, End::Before, Some(t)) => t.next_down(),
            (Bound::Depth, End::At, Some(t)) => t,
            _ => f64::INFINITY,
        };
        // The ray is converted as the query does it.
        let single = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
        let direction = ray.direction * (1.0 / per_t);
        let max_depth = (last * per_t).min(MAX_DEPTH) as f32;
        let ray = FilterRay { origin: single(ray.origin), direction: single(direction), max_depth };
        Question { block, ray, hit: t.filter(|&t| t >= 0.0 && t <= last).map(|t| t * per_t) }
    }
}

impl Question {
    /// Whether the verdict of a kernel is wrong if the error bound is multiplied by `fraction`.
    fn is_wrong(&self, kernel: usize, bound: Bound, fraction: f32) -> bool {
        let mut block = self.block;
        let FilterErrorBounds { edge, depth } = &mut block.error_bounds;
        *(if matches!(bound, Bound::Edge(_)) { edge } else { depth }) *= fraction;
        is_wrong(&verdicts(&block, &self.ray)[kernel], &block, self.hit)
    }

    /// The largest fraction of the error bound with which the verdict is wrong.
    fn fraction(&self, kernel: usize, bound: Bound) -> f32 {
        let (mut wrong, mut right) = (0.0, 2.0);
        if !self.is_wrong(kernel, bound, wrong) {
            return 0.0;
        }
        while right - wrong > 1e-3 {
            let middle = 0.5 * (wrong + right);
            *(if self.is_wrong(kernel, bound, middle) { &mut wrong } else { &mut right }) = middle;
        }
        wrong
    }
}

/// Whether the verdict for the first lane is wrong.
fn is_wrong(verdict: &Verdict, block: &Block, hit: Option<f64>) -> bool {
    let [possible, certain] = [verdict.possible, verdict.certain].map(|set| set & 1 == 1);
    let [min, max] = verdict.depths(0, block).map(f64::from);
    hit.map_or(certain, |t| !possible || certain && !(min <= t && t <= max))
}

/// A world of the triangles of these trials.
fn world(trials: &[Trial]) -> World {
    let vertices = trials.iter().flat_map(|trial| trial.corners).collect();
    world_of_mesh(&Mesh {
        vertices,
        triangles: (0..trials.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    })
}

fn fractions(trials: &[Trial], kernel: usize, bound: Bound) -> Vec<f32> {
    let world = world(trials);
    (0..).zip(trials).map(|(i, trial)| trial.question(&world, i, bound).fraction(kernel, bound)).collect()
}

/// The best of many random trials, improved by many mutations.
fn climb(seed: u64, generations: u64, kernel: usize, bound: Bound) -> (f32, Trial) {
    const CHILDREN: usize = 32;
    let rng = &mut Rng::at(seed, kernel as u64);
    let mut best = (-1.0, Trial::random(rng, bound));
    for generation in 0..generations {
        let children: Vec<Trial> = (0..CHILDREN)
            .map(|_| if generation < 10 { Trial::random(rng, bound) } else { best.1.mutated(rng) })
            .collect();
        for (fraction, child) in fractions(&children, kernel, bound).into_iter().zip(children) {
            if fraction >= best.0 {
                best = (fraction, child);
            }
        }
    }
    best
}

#[test]
fn the_filters_error_bounds_are_needed() {
    const SEED: u64 = 4019;
    let generations = rays(200, 20_000);
    let still = FilterRay { origin: [0.0; 4], direction: [0.0; 4], max_depth: 0.0 };
    let kernels = verdicts(&bytemuck::Zeroable::zeroed(), &still).len();
    // The fractions that must be needed: of w, which has the most roundings; of v, for which half of the
    // common bound suffices, as for u; and of depths, whose bound allows for hits at the far end of a box,
    // which the hits here are not.
    let bounds = [(Bound::Edge(0), 0.5), (Bound::Edge(1), 0.25), (Bound::Depth, 0.2)];
    for kernel in 0..kernels {
        for (bound, needed) in bounds {
            let climbs = (0..8u64).into_par_iter().map(|i| climb(SEED + i, generations, kernel, bound));
            let (fraction, trial) = climbs.max_by(|a, b| a.0.total_cmp(&b.0)).expect("climbs");
            println!("kernel {kernel}, {bound:?}: {fraction} of the error bound, by {}", trial.bits());
            assert!(fraction < 1.0, "the error bound is broken");
            assert!(fraction > needed, "the search finds nothing near the error bound");
        }
    }
}
