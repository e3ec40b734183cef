//! Section B, cases 26 and 27: the march itself, in up to 4096 cells along each axis.

use crate::support::measure::{Failures, measure};
use crate::support::meshes::{bunny, world_of};
use crate::support::product_grid::{Step, lattice, steps};
use crate::support::record::Record;
use crate::support::rng::Rng;
use crate::support::textbook_grid::{TextbookGrid, march};
use crate::support::{failed_ray, rays};
use crate::{grid::frame, grid::push};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::grid::Lattice;
use raytracer::math::aabb::Aabb;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::stats::Quiet;

/// The steps with every crossing computed from its face's index, so that no error adds up.
fn indexed_steps(lattice: &Lattice, ray: &Ray, first: [usize; 3]) -> Vec<Step> {
    let (mut cell, mut steps) = (first, Vec::new());
    let next = |cell: &[usize; 3], axis: usize| {
        let d = ray.direction[axis];
        let face = cell[axis] + (d > 0.0) as usize;
        let place = lattice.bounds.min[axis] + lattice.cell_size[axis] * face as f64;
        if d == 0.0 { f64::INFINITY } else { (place - ray.origin[axis]) / d }
    };
    loop {
        let times = [0, 1, 2].map(|axis| next(&cell, axis));
        let axis = (0..3).fold(0, |best, i| if times[i] < times[best] { i } else { best });
        steps.push((cell, times[axis]));
        let after = if ray.direction[axis] > 0.0 { Some(cell[axis] + 1) } else { cell[axis].checked_sub(1) };
        match after.filter(|&c| c < lattice.cells[axis]) {
            Some(after) => cell[axis] = after,
            None => return steps,
        }
    }
}

/// Whether two lists of cells differ, and how far apart their times are at most, in cells.
fn compare(lattice: &Lattice, ray: &Ray, found: &[Step], expected: &[Step]) -> (bool, f64) {
    let differs = found.len() != expected.len() || found.iter().zip(expected).any(|(a, b)| a.0 != b.0);
    // As fast as the ray runs through cells along any axis.
    let speed = (ray.direction.abs() / lattice.cell_size).max_element();
    let apart = |(a, b): (&Step, &Step)| (a.1 - b.1).abs() * speed;
    // Behind a difference the lists are shifted against each other; times still have to agree.
    (differs, found.iter().zip(expected).map(apart).fold(0.0, f64::max))
}

#[test]
fn case_26_the_cells_along_a_ray() {
    const SEED: u64 = 1026;
    let (middle, reach) = crate::support::meshes::middle_and_reach(&bunny("1k"));
    let boxes = [
        Aabb { min: DVec3::ZERO, max: DVec3::ONE },
        Aabb { min: middle - reach, max: middle + DVec3::new(1.0, 0.8, 0.7) * reach },
        Aabb { min: DVec3::splat(1000.0), max: DVec3::splat(1001.0) },
    ];
    let failures = Failures::default();
    let mut text = Vec::new();
    let (mut total, mut lists, mut worst) = (0, 0, 0.0f64);
    for (side, ordinary) in [(64, 16_000), (256, 12_000), (1024, 4_000), (4096, 1_500)] {
        let n = rays(ordinary, 100 * ordinary);
        let mut counts = [0; 3];
        for bounds in boxes {
            let lattice = Lattice::new(bounds, [side; 3]);
            let one = |index| {
                let rng = &mut Rng::at(SEED, index);
                let origin = bounds.min + bounds.extent() * (0.5 + 2.0 * rng.direction());
                let target = bounds.min + bounds.extent() * (0.5 + 0.4 * rng.in_cube());
                let ray = Ray::new(origin, (target - origin).normalize());
                let found = steps(&lattice, &ray);
                let Some(&(first, _)) = found.first() else { return ([0; 3], [0.0; 1]) };
                let expected = indexed_steps(&lattice, &ray, first);
                let (differs, drift) = compare(&lattice, &ray, &found, &expected);
                failures.note(drift > 1e-6, || failed_ray(26, SEED, index, ray.origin, ray.direction));
                let mut theirs = Vec::with_capacity(found.len());
                march::<f32>(&lattice, &ray, |cell, exit| {
                    theirs.push((cell, exit));
                    true
                });
                let (other, _) = compare(&lattice, &ray, &theirs, &expected);
                ([1, differs as u64, other as u64], [drift])
            };
            let (more, [drift]) = measure::<3, 1>(n, one);
            counts = crate::grid::sum([counts, more]);
            worst = worst.max(drift);
        }
        text.push(format!("{:.1}% at {side}", 100.0 * counts[2] as f64 / counts[0] as f64));
        total += counts[0];
        lists += counts[1];
        assert!(counts[2] > 0, "the case tests nothing");
    }
    Record {
        case: 26,
        name: "cells along a ray, 64 to 4096 a side",
        inputs: format!("{total} rays"),
        measure: "rays with another list of cells; largest drift in cells",
        textbook: format!("f32 accumulated: {}", text.join(", ")),
        ours: format!("{lists}; {worst:.1e}"),
        target: "drift 1e-6",
    }
    .write();
    assert!(worst <= 1e-6, "{worst}");
}

/// Objects so near to a cell's corner that a march which drifts passes them by.
#[test]
fn case_27_objects_at_cell_corners() {
    const SEED: u64 = 1027;
    let n = rays(10_000, 1_000_000);
    let failures = Failures::default();
    let (mut total, mut text) = ([0; 3], Vec::new());
    for side in [128, 256, 512, 1024] {
        // One layer of cells keeps the memory small; the errors add up along x and y.
        let cells = [side, side, 1];
        for delta in [1e-2, 1e-3, 1e-4] {
            let (mesh, corners) = specks(cells, delta);
            let world = world_of(&mesh);
            let caster = Caster::new(&world, Some(cells)).expect("a grid that fits");
            let textbook = TextbookGrid::over(&world, lattice(&world, cells));
            let one = |index| {
                let rng = &mut Rng::at(SEED, index);
                let i = rng.below(corners);
                let [a, b, c] = world.corners(2 + i);
                // Upwards to the left or downwards to the right, a ray cuts the object's corner off.
                let mut origin = DVec3::new(rng.range(-1.0, 0.0), rng.range(1.0, 2.0), rng.range(0.0, 1.0));
                if rng.below(2) == 0 {
                    (origin.x, origin.y) = (origin.y, origin.x);
                }
                let ray = Ray::new(origin, (a + b + c) / 3.0 - origin);
                let found = caster.closest(&ray, &mut Quiet).map(|h| h.primitive);
                // Another speck may stand in front, but the target is never passed.
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

/// Small triangles near corners of cells, and how many; two larger ones before them span the grid.
fn specks(cells: [usize; 3], delta: f64) -> (Mesh, usize) {
    const COUNT: usize = 400;
    let mut mesh = frame();
    let lattice = lattice(&world_of(&mesh), cells);
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
