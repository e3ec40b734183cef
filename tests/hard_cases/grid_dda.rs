//! Section B, cases 26 and 27: the DDA itself, with up to 4096 cells along each axis.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::bunny;
use crate::support::product_grid::{Step, dda_error_bound, lattice, steps};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::textbook_grid::{TextbookGrid, traverse};
use crate::support::{failed_ray, rays};
use crate::{grid::frame, grid::push};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::caster::lattice::Lattice;
use raytracer::math::aabb::Aabb;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

/// The largest distance, in cells, of the ray from the cell that the DDA is in at the same t.
fn largest_error(lattice: &Lattice, ray: &Ray, entry: f64, steps: &[Step]) -> f64 {
    let outside = |cell: [usize; 3], t: f64| {
        let at = (ray.at(t) - lattice.bounds.min) / lattice.cell_size;
        let low = DVec3::from_array(cell.map(|i| i as f64));
        (low - at).max(at - low - 1.0).max_element()
    };
    let entries = std::iter::once(entry).chain(steps.iter().map(|step| step.1));
    entries
        .zip(steps)
        .map(|(entry, &(cell, exit))| outside(cell, entry).max(outside(cell, exit)))
        .fold(0.0, f64::max)
}

#[test]
fn case_26_the_cells_along_a_ray() {
    const SEED: u64 = 1026;
    let (center, radius) = crate::support::meshes::center_and_radius(&bunny("1k"));
    let boxes = [
        Aabb { min: DVec3::ZERO, max: DVec3::ONE },
        Aabb { min: center - radius, max: center + DVec3::new(1.0, 0.8, 0.7) * radius },
        Aabb { min: DVec3::splat(1000.0), max: DVec3::splat(1001.0) },
    ];
    let failures = Failures::default();
    let (mut inputs, mut ours, mut theirs) = (0, Vec::new(), Vec::new());
    for (side, ordinary) in [(64, 24_000), (256, 8_000), (1024, 1_500), (4096, 500)] {
        let n = rays(ordinary, 100 * ordinary);
        // There are fewer cells along z, so that the number of cells fits into 32 bits.
        let cells = [side, side, side.min(200)];
        let (mut counts, mut errors) = ([0; 3], [0.0f64; 3]);
        for bounds in boxes {
            let lattice = Lattice::new(bounds, cells);
            let error_bound = dda_error_bound(&lattice);
            let one = |index| {
                let rng = &mut Rng::at(SEED, index);
                let origin = bounds.min + bounds.extent() * (0.5 + 2.0 * rng.direction());
                let target = bounds.min + bounds.extent() * (0.5 + 0.4 * rng.in_cube());
                let ray = Ray::new(origin, (target - origin).normalize());
                let (entry, found) = steps(&lattice, &ray);
                let ours = largest_error(&lattice, &ray, entry, &found);
                let wrong = found.is_empty() || ours > error_bound;
                failures.note(wrong, || failed_ray(26, SEED, index, ray.origin, ray.direction));
                let textbook = |traverse: &dyn Fn(&mut Vec<Step>)| {
                    let mut steps = Vec::with_capacity(found.len());
                    traverse(&mut steps);
                    largest_error(&lattice, &ray, entry, &steps)
                };
                let in_f32 = textbook(&|steps| collect::<f32>(&lattice, &ray, steps));
                let asked = index.is_multiple_of(8);
                let in_f64 =
                    if asked { textbook(&|steps| collect::<f64>(&lattice, &ray, steps)) } else { 0.0 };
                ([1, wrong as u64, (in_f32 > error_bound) as u64], [ours, in_f32, in_f64])
            };
            let (more, largest) = measure::<3, 3>(n, one);
            counts = crate::grid::sum([counts, more]);
            errors = std::array::from_fn(|i| errors[i].max(largest[i]));
        }
        let error_bound = dda_error_bound(&Lattice::new(boxes[0], cells));
        ours.push(format!("{:.1e} of {error_bound:.1e} at {side}", errors[0]));
        theirs.push(format!(
            "{:.1}% of rays beyond the error bound at {side}, by up to {:.1e}, in f64 {:.1e}",
            100.0 * counts[2] as f64 / counts[0] as f64,
            errors[1],
            errors[2]
        ));
        inputs += counts[0];
        assert_eq!(counts[1], 0);
        assert!(counts[2] > 0, "the case tests nothing");
    }
    Record {
        case: 26,
        basis: Basis::Proved,
        name: "cells along a ray, 64 to 4096 a side",
        inputs: format!("{inputs} rays"),
        measure: "largest distance of a cell from the ray at the same t, in cells",
        textbook: format!("f32 accumulated: {}", theirs.join("; ")),
        ours: ours.join(", "),
        target: "below the error bound by which cells are padded",
    }
    .write();
}

fn collect<T: num_traits::Float>(lattice: &Lattice, ray: &Ray, steps: &mut Vec<Step>) {
    traverse::<T>(lattice, ray, |cell, exit| {
        steps.push((cell, exit));
        true
    });
}

/// A number of cells along an axis, about `n`, for which the increment of t per cell is as far from an
/// integer as possible.
fn cells_with_large_errors(n: usize) -> usize {
    let increment = |n: usize| 2f64.powi(29) / n as f64;
    let from_half = |n: usize| (increment(n).fract() - 0.5).abs();
    (n..n + n / 4).min_by(|&a, &b| from_half(a).total_cmp(&from_half(b))).expect("some number")
}

/// A ray along an axis through all of its cells, with a rounding error of half a unit of t in each.
#[test]
fn the_dda_nearly_reaches_its_error_bound() {
    for n in [500, 1000, 3000, 8000, 20_000] {
        let cells = [cells_with_large_errors(n), 1, 1];
        let lattice = Lattice::new(Aabb { min: DVec3::ZERO, max: DVec3::ONE }, cells);
        let ray = Ray::new(DVec3::new(-0.5, 0.3, 0.6), DVec3::X);
        let (entry, steps) = steps(&lattice, &ray);
        let fraction = largest_error(&lattice, &ray, entry, &steps) / dda_error_bound(&lattice);
        println!("{} cells: {fraction:.3} of the error bound", cells[0]);
        assert!(fraction <= 1.0, "the error bound is broken");
        assert!(fraction > 0.5, "the error of the ray is too small");
    }
}

/// Objects that are in a visited cell only because the cells are padded by the error bound of the DDA.
#[test]
fn objects_where_the_dda_is_least_accurate() {
    const SEED: u64 = 3027;
    let n = rays(20_000, 2_000_000);
    let side = cells_with_large_errors(1000);
    let cells = [side, side, 1];
    let (world, positions) = triangles_where_the_dda_is_inaccurate(cells);
    let caster = Caster::new(&world, Some(cells)).expect("a grid that fits");
    let lattice = lattice(&world, cells);
    let failures = Failures::default();
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let position = positions[rng.below(positions.len())];
        // The ray runs along x through the whole grid, and passes one cell of y for two or three of x.
        let slope = rng.range(0.3, 0.5);
        let direction = DVec3::new(1.0, slope, 0.0);
        let ray = Ray::new(position - (position.x - lattice.bounds.min.x + 0.5) * direction, direction);
        let missed = caster.closest(&ray).is_none();
        failures.note(missed, || failed_ray(27, SEED, index, ray.origin, ray.direction));
        ([missed as u64], [])
    };
    let [missed] = measure::<1, 0>(n, one).0;
    println!("{n} rays at objects where the DDA is least accurate: {missed} missed");
    assert_eq!(missed, 0);
}

/// Tiny triangles near the far ends of rays along x, each in a corner of its cell that such a ray just cuts
/// off, and their positions.
fn triangles_where_the_dda_is_inaccurate(cells: [usize; 3]) -> (World, Vec<DVec3>) {
    const COUNT: usize = 2000;
    let mut mesh = frame();
    let lattice = lattice(&world_of_mesh(&mesh), cells);
    let (face_error_bound, rng) = (dda_error_bound(&lattice), &mut Rng::new(3027));
    // From half a cell on, the error of a ray along x exceeds this distance in cells, and so both distances
    // below.
    let near = |rng: &mut Rng| rng.range(0.13, 0.25) * face_error_bound;
    let mut positions = vec![];
    for _ in 0..COUNT {
        let corner = [9 * cells[0] / 10 + rng.below(cells[0] / 10), cells[1] / 2 + rng.below(cells[1] / 3)];
        // On either side, since the DDA may be early or late.
        let side = if rng.below(2) == 0 { 1.0 } else { -1.0 };
        let off = [-side * near(rng), side * near(rng)];
        let inside = |axis: usize| {
            lattice.bounds.min[axis] + lattice.cell_size[axis] * (corner[axis] as f64 + off[axis])
        };
        let position = DVec3::new(inside(0), inside(1), rng.range(0.1, 0.9));
        let size = 0.01 * face_error_bound * lattice.cell_size.x;
        // The triangle is perpendicular to the rays.
        push(
            &mut mesh,
            [DVec3::new(0.0, 1.0, -1.0), DVec3::new(0.0, -1.0, -1.0), DVec3::Z].map(|v| position + size * v),
        );
        positions.push(position);
    }
    (world_of_mesh(&mesh), positions)
}

/// Objects so close to a corner of a cell that an inaccurate DDA misses them.
#[test]
fn case_27_objects_at_cell_corners() {
    const SEED: u64 = 1027;
    let n = rays(10_000, 1_000_000);
    let failures = Failures::default();
    let (mut total, mut text) = ([0; 3], Vec::new());
    for side in [128, 256, 512, 1024] {
        // One layer of cells keeps the memory small, and the errors accumulate along x and y.
        let cells = [side, side, 1];
        for delta in [1e-2, 1e-3, 1e-4] {
            let (mesh, corners) = small_triangles(cells, delta);
            let world = world_of_mesh(&mesh);
            let caster = Caster::new(&world, Some(cells)).expect("a grid that fits");
            let textbook = TextbookGrid::over(&world, lattice(&world, cells));
            let one = |index| {
                let rng = &mut Rng::at(SEED, index);
                let i = rng.below(corners);
                let [a, b, c] = world.corners(2 + i);
                // A ray that rises to the left or falls to the right cuts off the corner with the object.
                let mut origin = DVec3::new(rng.range(-1.0, 0.0), rng.range(1.0, 2.0), rng.range(0.0, 1.0));
                if rng.below(2) == 0 {
                    (origin.x, origin.y) = (origin.y, origin.x);
                }
                let ray = Ray::new(origin, (a + b + c) / 3.0 - origin);
                let found = caster.closest(&ray).map(|h| h.primitive);
                // Another triangle may be in front of the target, but the ray never misses both.
                let missed = found.is_none();
                failures.note(missed, || failed_ray(27, SEED, index, ray.origin, ray.direction));
                let theirs = textbook.first_hit::<f32>(&ray).is_none();
                ([1, missed as u64, theirs as u64], [])
            };
            let (counts, []) = measure::<3, 0>(n, one);
            total = crate::grid::sum([total, counts]);
            text.push(format!("{} at {side} and {delta}", counts[2]));
        }
    }
    Record {
        case: 27,
        basis: Basis::Sampled,
        name: "objects near cell corners",
        inputs: format!("{} rays at objects 1e-2 to 1e-4 cells from a corner", total[0]),
        measure: "objects missed",
        textbook: format!("f32 accumulated: {}", text.join(", ")),
        ours: total[1].to_string(),
        target: "0",
    }
    .write();
    assert_eq!(total[1], 0);
    assert!(total[2] > 0, "the case tests nothing");
}

/// Small triangles near corners of cells, and their number. Two larger triangles before them fix the bounds
/// of the grid.
fn small_triangles(cells: [usize; 3], delta: f64) -> (Mesh, usize) {
    const COUNT: usize = 400;
    let mut mesh = frame();
    let lattice = lattice(&world_of_mesh(&mesh), cells);
    let rng = &mut Rng::new(2027);
    for _ in 0..COUNT {
        let corner = [0, 1].map(|axis| 1 + cells[axis] / 4 + rng.below(cells[axis] / 2));
        let inside =
            |axis: usize| lattice.bounds.min[axis] + lattice.cell_size[axis] * (corner[axis] as f64 + delta);
        let at = DVec3::new(inside(0), inside(1), rng.range(0.1, 0.9));
        let size = 0.3 * delta * lattice.cell_size.x;
        push(&mut mesh, [at + size * DVec3::X, at + size * DVec3::Y, at - size * DVec3::ONE]);
    }
    (mesh, COUNT)
}
