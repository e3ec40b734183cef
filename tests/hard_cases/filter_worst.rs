//! How tight the error bounds of the single-precision filter are: hill climbing searches for inputs that need
//! a large fraction of the bound. The reference is the exact test.

use crate::filter::verdicts;
use crate::support::hex;
use crate::support::rays;
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use glam::DVec3;
use rayon::prelude::*;
use raytracer::caster::block::{Block, FilterErrorBounds, Frame, LANES, NONE};
use raytracer::caster::filter::{FilterRay, MAX_DEPTH, Verdict};
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use raytracer::world::triangle::Shear;

/// A frame in which coordinates are those of world space.
const FRAME: Frame = Frame { center: [0.0; 4], scale: 1.0, unit: 1.0 };

/// The error bound whose tightness is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bound {
    /// That of w.
    W,
    /// That of v, and so of u, where w is clearly not negative. It is a part of that of w, which the kernels use
    /// for all three.
    V,
    /// That of depths, in the comparison with the end of the ray and in the depths that the filter returns.
    Depth,
}

/// The error bound of v, in roundings of an edge and of an edge squared.
const V_EDGE_ROUNDINGS: f32 = 18.5;
const V_AREA_ROUNDINGS: f32 = 20.5;

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
    /// Whether a wrong verdict is due to the quantity whose bound is measured.
    is_alone: bool,
}

impl Trial {
    fn random(rng: &mut Rng, bound: Bound) -> Self {
        let mut weights = [rng.unit(), rng.unit(), rng.unit()];
        match bound {
            Bound::W => weights[0] = 0.0,
            Bound::V => weights[1] = 0.0,
            Bound::Depth => {}
        }
        let sign = |rng: &mut Rng| if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let end = [End::Before, End::At, End::Beyond][rng.below(3)];
        if bound == Bound::Depth && rng.below(2) == 0 {
            return Self::with_large_normal(rng, weights, end);
        }
        // The triangle has any size and is at the other end of the box, sometimes along its diagonal.
        let size = libm::pow(10.0, rng.range(-3.0, 0.3));
        let signs = |rng: &mut Rng| DVec3::new(sign(rng), sign(rng), sign(rng));
        let origin = 0.99 * signs(rng);
        let is_diagonal = rng.below(2) == 0;
        let corners = [0; 3].map(|_| {
            let corner = if is_diagonal { signs(rng) } else { rng.in_cube() };
            (size * corner - origin).clamp(DVec3::NEG_ONE, DVec3::ONE)
        });
        Self { corners, origin, weights, end }
    }

    /// A small triangle at the far end of the box's diagonal whose normal is as long as its edges allow, and
    /// just above a power of two, where roundings are largest.
    fn with_large_normal(rng: &mut Rng, weights: [f64; 3], end: End) -> Self {
        let flips = DVec3::from_array([0; 3].map(|_| if rng.below(2) == 0 { 1.0 } else { -1.0 }));
        let turn = rng.below(3);
        // The normal of the edges is (2, 2, 0), up to the order of the axes and the signs.
        let turned = |v: [f64; 3]| flips * DVec3::from_array([0, 1, 2].map(|k| v[(k + turn) % 3]));
        let size =
            libm::exp2(-0.5 * rng.range(2.0, 20.0).round()) * (1.0 + libm::pow(10.0, rng.range(-6.0, -2.0)));
        let (far, origin) = ((1.0 - size) * flips, -flips);
        let corners = [far, far - size * turned([1.0, -1.0, 1.0]), far + size * turned([1.0, -1.0, -1.0])];
        Self { corners, origin, weights, end }
    }

    /// A copy with one coordinate changed a little.
    fn mutated(mut self, rng: &mut Rng) -> Self {
        for _ in 0..1 + rng.below(3) {
            let step = libm::pow(10.0, rng.range(-9.0, 0.0));
            if rng.below(4) == 0 {
                self.moved(rng, step);
                continue;
            }
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

    /// Moves the whole triangle a little along an axis, which leaves its normal as it is.
    fn moved(&mut self, rng: &mut Rng, step: f64) {
        let (axis, step) = (rng.below(3), step * rng.range(-1.0, 1.0));
        self.corners.iter_mut().for_each(|corner| corner[axis] = (corner[axis] + step).clamp(-1.0, 1.0));
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
        let mut ids = [NONE; LANES];
        ids[0] = id;
        let mut block = Block::new(ids);
        block.fill(world, &FRAME);
        let ray = self.ray();
        let is_alone = bound != Bound::V || self.w() > f64::from(-block.error_bounds.edge);
        if bound == Bound::V {
            let longest =
                block.edges.as_flattened().iter().fold(0.0, |longest, row| f32::max(longest, row[0].abs()));
            block.error_bounds.edge =
                -(V_EDGE_ROUNDINGS + V_AREA_ROUNDINGS * longest) * longest / (1u32 << 24) as f32;
        }
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
        let hit = t.filter(|&t| t >= 0.0 && t <= last).map(|t| t * per_t);
        Question { block, ray, hit, is_alone }
    }

    /// The absolute value of w, in double precision.
    fn w(&self) -> f64 {
        let [a, b, c] = self.corners;
        let direction = self.ray().direction;
        let det = (a - b).cross(c - a).dot(direction) / direction.abs().max_element();
        (det * self.weights[0] / self.weights.iter().sum::<f64>()).abs()
    }
}

impl Question {
    /// Whether the verdict of a kernel is wrong if the error bound is multiplied by `fraction`.
    fn is_wrong(&self, kernel: usize, bound: Bound, fraction: f32) -> bool {
        let mut block = self.block;
        let FilterErrorBounds { edge, depth } = &mut block.error_bounds;
        *(if bound == Bound::Depth { depth } else { edge }) *= fraction;
        is_wrong(&verdicts(&block, &self.ray)[kernel], &block, self.hit)
    }

    /// The largest fraction of the error bound with which the verdict is wrong.
    fn fraction(&self, kernel: usize, bound: Bound) -> f32 {
        let (mut wrong, mut right) = (0.0, 2.0);
        if !(self.is_alone && self.is_wrong(kernel, bound, wrong)) {
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
    // All kernels but the first, which fuses multiplications and additions, round alike.
    let rng = &mut Rng::at(seed, kernel.min(1) as u64);
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
    let generations = rays(400, 20_000);
    let still = FilterRay { origin: [0.0; 4], direction: [0.0; 4], max_depth: 0.0 };
    let kernels = verdicts(&bytemuck::Zeroable::zeroed(), &still).len();
    for kernel in 0..kernels {
        for bound in [Bound::W, Bound::V, Bound::Depth] {
            let climbs = (0..8u64).into_par_iter().map(|i| climb(SEED + i, generations, kernel, bound));
            let (fraction, trial) = climbs.max_by(|a, b| a.0.total_cmp(&b.0)).expect("climbs");
            println!("kernel {kernel}, {bound:?}: {fraction} of the error bound, by {}", trial.bits());
            assert!(fraction < 1.0, "the error bound is broken");
            assert!(fraction > 0.5, "the search finds nothing near the error bound");
        }
    }
}
