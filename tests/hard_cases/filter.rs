//! The single-precision filter by itself, in addition to case 19: a triangle that it rejects is missed, and
//! one that it accepts as certain is hit within the depths that it returns. The reference is the exact test.

use crate::grid::{outside, push, sum};
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, rounded};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook::{Edges, lower, lower_triangle, woop};
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::block::{Block, FilterErrorBounds, Frame, LANES, NONE};
use raytracer::caster::bounds::widened;
use raytracer::caster::filter::{self, FilterRay, MAX_DEPTH, Verdict};
use raytracer::math::aabb::Aabb;
use raytracer::math::instructions::{self, Level};
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;
use raytracer::world::triangle::Shear;

const SEED: u64 = 3019;
const RAYS_PER_BLOCK: u64 = 100;

/// A frame at any position and of any size.
fn frame(rng: &mut Rng) -> Frame {
    let center = if rng.below(2) == 0 { DVec3::ZERO } else { 1e4 * rng.in_cube() };
    let [x, y, z] = center.to_array();
    let scale = f64::powi(2.0, rng.below(40) as i32 - 20);
    Frame { center: [x, y, z, 0.0], scale, unit: 1.0 / scale }
}

/// Eight triangles of one size, some of them needles, within a frame's box. Some are in the middle of the box and so
/// small that products of their edges underflow in single precision.
fn triangles(rng: &mut Rng, frame: &Frame) -> World {
    let is_tiny = rng.below(4) == 0;
    let size = f64::powf(10.0, if is_tiny { rng.range(-22.5, -20.5) } else { rng.range(-6.0, 0.3) });
    let reach = if is_tiny { size } else { 1.0 };
    let mut mesh = Mesh::default();
    for lane in 0..LANES as u32 {
        let corner = reach * rng.in_cube();
        let narrow = f64::powf(10.0, rng.range(-4.0, 0.0));
        let (along, aside) = (size * rng.direction(), size * narrow * rng.direction());
        let corners = [corner, corner + along, corner + rng.unit() * along + aside];
        let in_box = |p: DVec3| p.clamp(DVec3::splat(-reach), DVec3::splat(reach));
        mesh.vertices.extend(corners.map(|p| center(frame) + in_box(p) / frame.scale));
        mesh.triangles.push([3 * lane, 3 * lane + 1, 3 * lane + 2]);
    }
    world_of_mesh(&mesh)
}

fn center(frame: &Frame) -> DVec3 {
    let [x, y, z, _] = frame.center;
    DVec3::new(x, y, z)
}

/// A ray from within the frame's box that passes close to an edge, a vertex or the inside of a triangle, or
/// to a random point, or to the middle of the box, around which the tiny triangles are.
fn ray(rng: &mut Rng, frame: &Frame, corners: [DVec3; 3]) -> Ray {
    let origin = center(frame) + rng.in_cube() / frame.scale;
    let [a, b, c] = corners;
    if (b - a).length() * frame.scale < 1e-15 && rng.below(4) > 0 {
        return Ray::new(origin, center(frame) - origin);
    }
    let target = match rng.below(4) {
        0 => a,
        1 => a.lerp(b, rng.unit()),
        2 => b.lerp(c, rng.unit()),
        _ => a.lerp(b, rng.unit()).lerp(c, rng.unit()),
    };
    let off = (b - a).length() * f64::powf(10.0, rng.range(-12.0, -1.0)) * rng.direction();
    let direction = target + off - origin;
    Ray::new(origin, if rng.below(8) == 0 { direction.normalize() } else { direction })
}

/// The filter's ray, as the query makes it for a ray that starts in the frame's box.
fn filter_ray(frame: &Frame, ray: &Ray, max_depth: f32) -> FilterRay {
    let single = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
    let direction = ray.direction / ray.direction.abs().max_element();
    FilterRay { origin: single(frame.point(ray.origin)), direction: single(direction), max_depth }
}

/// For each lane the filter's t at which the exact test hits the triangle; none where it misses, or hits
/// farther than `max_depth`.
fn hits(world: &World, frame: &Frame, ray: &Ray, max_depth: f32) -> [Option<f64>; LANES] {
    let shear = Shear::new(ray);
    let per_t = ray.direction.abs().max_element() * frame.scale;
    std::array::from_fn(|lane| {
        let depth = shear.intersect(world.corners(lane).each_ref())? * per_t;
        (depth >= 0.0 && depth <= f64::from(max_depth)).then_some(depth)
    })
}

/// The number of lanes whose verdict is wrong.
fn wrong_lanes(verdict: &Verdict, block: &Block, hits: &[Option<f64>; LANES]) -> usize {
    let is_wrong = |lane: &usize| {
        let [possible, certain] = [verdict.possible, verdict.certain].map(|set| set >> lane & 1 == 1);
        let between = |depth: f64| {
            let [least, most] = verdict.depths(*lane, block).map(f64::from);
            least <= depth && depth <= most
        };
        hits[*lane].map_or(certain, |depth| !possible || certain && !between(depth))
    };
    (0..LANES).filter(is_wrong).count()
}

/// The verdicts of all kernels, the portable one first.
pub fn verdicts(block: &Block, ray: &FilterRay) -> Vec<Verdict> {
    instructions::available()
        .into_iter()
        .rev()
        .map(|with| filter::test_at(with, block, ray, [NONE; 2]))
        .collect()
}

#[test]
fn the_filter_is_never_wrong() {
    let blocks = rays(1250, 125_000);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let frame = frame(rng);
        let world = triangles(rng, &frame);
        let mut block = Block::new(std::array::from_fn(|lane| lane as u32));
        block.fill(&world, &frame);
        let mut without_bounds = block;
        without_bounds.error_bounds = FilterErrorBounds { edge: 0.0, depth: 0.0 };
        let mut counts = [0; 4];
        for k in 0..RAYS_PER_BLOCK {
            let lane = rng.below(LANES);
            let ray = ray(rng, &frame, world.corners(lane));
            let max_depth = match rng.below(3) {
                0 => MAX_DEPTH as f32,
                1 => rng.range(0.0, MAX_DEPTH) as f32,
                // Here the ray ends just at the triangle.
                _ => hits(&world, &frame, &ray, MAX_DEPTH as f32)[lane].unwrap_or(MAX_DEPTH) as f32,
            };
            let hits = hits(&world, &frame, &ray, max_depth);
            let single = filter_ray(&frame, &ray, max_depth);
            for verdict in verdicts(&block, &single) {
                let wrong = wrong_lanes(&verdict, &block, &hits);
                counts[0] += wrong as u64;
                counts[1] += u64::from(verdict.possible.count_ones());
                failures.note(wrong != 0, || format!("seed {SEED}, block {index}, ray {k}: {wrong} lanes"));
            }
            let textbook = filter::test_at(Level::baseline(), &without_bounds, &single, [NONE; 2]);
            counts[2] += wrong_lanes(&textbook, &without_bounds, &hits) as u64;
            counts[3] += hits.iter().flatten().count() as u64;
        }
        (counts, [])
    };
    let [wrong, unsure, textbook, hits] = measure::<4, 0>(blocks, one).0;
    let pairs = blocks * RAYS_PER_BLOCK * LANES as u64;
    println!("{pairs} pairs, {hits} hits, {unsure} unsure; wrong: {wrong}, without error bounds {textbook}");
    assert_eq!(wrong, 0);
    assert!(textbook > 0 && hits > pairs / 100, "the test tests nothing");
}

/// Triangles around a common vertex, or a single triangle.
fn ring(corners: usize, rng: &mut Rng) -> Mesh {
    let mut mesh = Mesh::default();
    let (center, normal) = (rng.in_cube(), rng.direction());
    let x = normal.cross(rng.direction()).normalize();
    let rim = |k: usize| {
        let angle = k as f64 / corners as f64 * std::f64::consts::TAU;
        rounded(center + libm::cos(angle) * x + libm::sin(angle) * normal.cross(x))
    };
    for k in 0..corners {
        push(&mut mesh, [rounded(center), rim(k), rim((k + 1) % corners)]);
    }
    mesh
}

/// All triangles of a world in blocks, and the box that defines their frame.
struct Blocks {
    bounds: Aabb,
    frame: Frame,
    blocks: Vec<Block>,
}

impl Blocks {
    fn new(world: &World) -> Self {
        let bounds = widened(world.bounds);
        let frame = Frame::new(&bounds);
        let count = world.triangles.len() as u32;
        let block = |first: u32| {
            let number = |lane: usize| Some(first + lane as u32).filter(|&number| number < count);
            let mut block = Block::new(std::array::from_fn(|lane| number(lane).unwrap_or(NONE)));
            block.fill(world, &frame);
            block
        };
        Self { bounds, frame, blocks: (0..count).step_by(LANES).map(block).collect() }
    }

    /// The t where a ray enters the box, if it does.
    fn entry(&self, ray: &Ray) -> Option<f64> {
        let inverse = 1.0 / ray.direction;
        let [low, high] = [self.bounds.min, self.bounds.max].map(|corner| (corner - ray.origin) * inverse);
        let entry = low.min(high).max_element().max(ray.t_min);
        (entry <= low.max(high).min_element()).then_some(entry)
    }

    /// The filter's ray from the point where a ray enters the box, as the query makes it.
    fn ray(&self, ray: &Ray) -> Option<FilterRay> {
        let entry = self.entry(ray)?;
        let from_center = ray.origin - center(&self.frame) + entry * ray.direction;
        let single = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
        let direction = ray.direction * (1.0 / ray.direction.abs().max_element());
        let max_depth = MAX_DEPTH as f32;
        Some(FilterRay {
            origin: single(from_center * self.frame.scale),
            direction: single(direction),
            max_depth,
        })
    }

    /// Whether one of the kernels rejects a triangle, or the ray misses the box.
    fn reject(&self, ray: Option<&FilterRay>, triangle: usize) -> bool {
        let block = &self.blocks[triangle / LANES];
        let is_possible = |verdict: Verdict| verdict.possible >> (triangle % LANES) & 1 == 1;
        ray.is_none_or(|ray| !verdicts(block, ray).into_iter().all(is_possible))
    }
}

/// Rays at the edges and vertices of rings, each tested against all triangles of its ring.
#[test]
fn case_19_no_rejection_is_wrong() {
    let far = DVec3::new(148_376.0, 1234.0, -223_423.0);
    let per_ring = rays(2_500, 230_000);
    let mut counts = Vec::new();
    for (i, shift) in [DVec3::ZERO, far].into_iter().enumerate() {
        for corners in [1, 2, 3, 4, 7, 8, 30] {
            for turn in 0..4 {
                let mut mesh = ring(corners, &mut Rng::at(1019, (i * 1000 + corners * 10 + turn) as u64));
                mesh.vertices.iter_mut().for_each(|v| *v = rounded(*v + shift));
                counts.push(lost(&Closed::new(mesh), per_ring));
            }
        }
    }
    let [ours, textbook, hits, pairs] = sum(counts);
    Record {
        case: 19,
        basis: Basis::Proved,
        name: "no hit is rejected before the exact test",
        inputs: format!("{pairs} pairs of a ray at an edge or vertex and a triangle, {hits} of which hit"),
        measure: "hits that are lost",
        textbook: format!("filtered by the same test in f32 without error bounds: {textbook}"),
        ours: ours.to_string(),
        target: "0",
    }
    .write();
    assert_eq!(ours, 0);
    assert!(textbook > 0 && hits > pairs / 20, "the case tests nothing");
}

/// Counts, for `n` rays and all triangles, the hits that the filter loses, the hits that a filter in f32
/// without an error bound loses, all hits, and all pairs.
fn lost(ring: &Closed, n: u64) -> [u64; 4] {
    let (world, aim) = (world_of_mesh(&ring.mesh), outside(ring, 8.0));
    let (blocks, failures) = (Blocks::new(&world), Failures::default());
    let one = |index| {
        let ray = aim(&mut Rng::at(2019, index), index);
        let (shear, single) = (Shear::new(&ray), blocks.ray(&ray));
        let (o, d) = (lower::<f32>(ray.origin), lower::<f32>(ray.direction));
        let mut counts = [0, 0, 0, world.triangles.len() as u64];
        for triangle in 0..world.triangles.len() {
            if shear.intersect(world.corners_in_place(triangle)).is_some_and(|t| ray.covers(t)) {
                let is_lost = blocks.reject(single.as_ref(), triangle);
                counts[0] +=
                    failures.note(is_lost, || failed_ray(19, 2019, index, ray.origin, ray.direction));
                let corners = lower_triangle(world.corners(triangle));
                counts[1] += u64::from(woop(o, d, corners, Edges::Inclusive).is_none());
                counts[2] += 1;
            }
        }
        (counts, [])
    };
    measure::<4, 0>(n, one).0
}
