//! The single-precision filter by itself, beside case 19: what it rejects is missed, and what it is
//! certain of is hit, between the depths that it names. The oracle is the exact test.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::world_of;
use crate::support::rays;
use crate::support::rng::Rng;
use glam::DVec3;
use raytracer::caster::Instructions;
use raytracer::caster::block::{Block, Frame, LANES, Slack};
use raytracer::caster::filter::{self, FilterRay, Verdict};
use raytracer::math::ray::Ray;
use raytracer::primitive::triangle::Shear;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

const SEED: u64 = 3019;
const RAYS_PER_BLOCK: u64 = 100;

/// A frame anywhere and of any size.
fn frame(rng: &mut Rng) -> Frame {
    let center = if rng.below(2) == 0 { DVec3::ZERO } else { 1e4 * rng.in_cube() };
    let [x, y, z] = center.to_array();
    let scale = f64::powi(2.0, rng.below(40) as i32 - 20);
    Frame { center: [x, y, z, 0.0], scale, unit: 1.0 / scale }
}

/// Eight triangles of one size, needles among them, in a frame's box or out to four times as far; one
/// of them at times farther than the filter takes any.
fn triangles(rng: &mut Rng, frame: &Frame) -> World {
    let size = f64::powf(10.0, rng.range(-6.0, 0.3));
    let reach = if rng.below(2) == 0 { 1.0 } else { 4.0 };
    let stray = if rng.below(10) == 0 { 1e3 } else { 1.0 };
    let mut mesh = Mesh::default();
    for lane in 0..LANES as u32 {
        let size = if lane == 7 { size * stray } else { size };
        let corner = reach * rng.in_cube();
        let narrow = f64::powf(10.0, rng.range(-4.0, 0.0));
        let (along, aside) = (size * rng.direction(), size * narrow * rng.direction());
        let corners = [corner, corner + along, corner + rng.unit() * along + aside];
        mesh.vertices.extend(corners.map(|p| {
            center(frame) + p.clamp(-reach * DVec3::splat(stray), reach * DVec3::splat(stray)) / frame.scale
        }));
        mesh.triangles.push([3 * lane, 3 * lane + 1, 3 * lane + 2]);
    }
    world_of(&mesh)
}

fn center(frame: &Frame) -> DVec3 {
    let [x, y, z, _] = frame.center;
    DVec3::new(x, y, z)
}

/// A ray from within the frame's box that passes an edge, a vertex or the inside of a triangle, closely
/// or at random.
fn ray(rng: &mut Rng, frame: &Frame, corners: [DVec3; 3]) -> Ray {
    let origin = center(frame) + rng.in_cube() / frame.scale;
    let [a, b, c] = corners;
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

/// As the search makes it, for a ray that begins in the frame's box.
fn filter_ray(frame: &Frame, ray: &Ray, farthest: f32) -> FilterRay {
    let single = |v: DVec3| [v.x as f32, v.y as f32, v.z as f32, 0.0];
    let direction = ray.direction / ray.direction.abs().max_element();
    FilterRay { origin: single(frame.point(ray.origin)), direction: single(direction), farthest }
}

/// The filter's t at which the exact test hits each lane; none where it does not, or farther than this.
fn hits(world: &World, frame: &Frame, ray: &Ray, farthest: f32) -> [Option<f64>; LANES] {
    let shear = Shear::new(ray);
    let per_t = ray.direction.abs().max_element() * frame.scale;
    std::array::from_fn(|lane| {
        let depth = shear.intersect(world.corners(lane).each_ref())? * per_t;
        (depth >= 0.0 && depth <= f64::from(farthest)).then_some(depth)
    })
}

/// The lanes of which a verdict is wrong.
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

fn verdicts(block: &Block, ray: &FilterRay) -> Vec<Verdict> {
    Instructions::available().into_iter().map(|with| filter::test(with, block, ray)).collect()
}

#[test]
fn the_filter_is_never_wrong() {
    let blocks = rays(1250, 125_000);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let frame = frame(rng);
        let world = triangles(rng, &frame);
        let mut block: Block = bytemuck::Zeroable::zeroed();
        let all_within = frame.holds(&world.bounds);
        block.fill(&world, &frame, all_within, &std::array::from_fn(|lane| lane as u32));
        let mut without_margin = block;
        without_margin.slack = Slack { edge: 0.0, depth: 0.0 };
        let mut counts = [0; 4];
        for k in 0..RAYS_PER_BLOCK {
            let aim = world.corners(rng.below(LANES));
            let ray = ray(rng, &frame, aim);
            let farthest = if rng.below(2) == 0 { 2.5 } else { rng.range(0.0, 2.5) as f32 };
            let hits = hits(&world, &frame, &ray, farthest);
            let single = filter_ray(&frame, &ray, farthest);
            for verdict in verdicts(&block, &single) {
                let wrong = wrong_lanes(&verdict, &block, &hits);
                counts[0] += wrong as u64;
                counts[1] += u64::from(verdict.possible.count_ones());
                failures.note(wrong != 0, || format!("seed {SEED}, block {index}, ray {k}: {wrong} lanes"));
            }
            let textbook = filter::test(Instructions::Portable, &without_margin, &single);
            counts[2] += wrong_lanes(&textbook, &without_margin, &hits) as u64;
            counts[3] += hits.iter().flatten().count() as u64;
        }
        (counts, [])
    };
    let [wrong, open, textbook, hits] = measure::<4, 0>(blocks, one).0;
    let pairs = blocks * RAYS_PER_BLOCK * LANES as u64;
    println!("{pairs} pairs, {hits} hits, {open} left open; wrong: {wrong}, without a margin {textbook}");
    assert_eq!(wrong, 0);
    assert!(textbook > 0 && hits > pairs / 100, "the test tests nothing");
}
