//! Section B, cases 28 to 32: large and flat objects in a grid, grids far from the origin, rays from far
//! away, and any number of cells.

use crate::grid::{conclude, differences, frame, outside, push, sum};
use crate::support::brute::Brute;
use crate::support::measure::{Failures, measure};
use crate::support::meshes::{Closed, bunny, moved, point_in};
use crate::support::product_grid::{dda_error_bound, lattice, steps};
use crate::support::rng::Rng;
use crate::support::scenes::world_of_mesh;
use crate::support::{failed_ray, rays};
use glam::DVec3;
use raytracer::caster::Caster;
use raytracer::caster::insertion::of_ball;
use raytracer::caster::lattice::Lattice;
use raytracer::math::aabb::Aabb;
use raytracer::math::double_double::exact_product;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;
use raytracer::world::World;

#[test]
fn case_28_a_quad_through_all_cells() {
    let rng = &mut Rng::new(1028);
    let mut mesh = frame();
    let [a, b, c, d] =
        [[0.02, 0.1, 0.3], [0.97, 0.05, 0.2], [0.95, 0.98, 0.8], [0.05, 0.9, 0.9]].map(DVec3::from_array);
    push(&mut mesh, [a, b, c]);
    push(&mut mesh, [a, c, d]);
    for _ in 0..1000 {
        let center = 0.5 + 0.45 * rng.in_cube();
        push(&mut mesh, [0, 1, 2].map(|_| center + 0.03 * rng.in_cube()));
    }
    let world = world_of_mesh(&mesh);
    let n = rays(50_000, 5_000_000);
    let aim = |rng: &mut Rng, _| {
        let origin = 0.5 + 1.5 * rng.direction();
        Ray::new(origin, point_in(world.corners(rng.below(world.triangles.len())), rng) - origin)
    };
    let counts = [[30; 3], [7, 90, 16]].map(|cells| differences(28, &world, cells, n, aim));
    conclude(28, "a quad through the whole grid among small triangles", 2 * n, sum(counts));
}

/// Adds a flat square of 100 by 100 quads at the height `z`.
fn flat(mesh: &mut Mesh, z: f64) {
    let at = |i: usize, j: usize| DVec3::new(0.02 + 0.0096 * i as f64, 0.02 + 0.0096 * j as f64, z);
    for i in 0..100 {
        for j in 0..100 {
            push(mesh, [at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            push(mesh, [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
}

/// A flat mesh alone, whose box has no thickness; one in a plane between cells; and one on the side of the
/// box.
fn flat_meshes(cells: [usize; 3]) -> [Mesh; 3] {
    let lattice = lattice(&world_of_mesh(&frame()), cells);
    let plane = lattice.bounds.min.z + 5.0 * lattice.cell_size.z;
    let [mut alone, mut between, mut side] = [Mesh::default(), frame(), frame()];
    flat(&mut alone, 0.25);
    flat(&mut between, plane);
    flat(&mut side, 1.0);
    [alone, between, side]
}

#[test]
fn case_29_a_flat_mesh_on_cell_faces() {
    let cells = [32, 32, 16];
    let n = rays(40_000, 4_000_000);
    let counts = flat_meshes(cells).map(|mesh| {
        let world = world_of_mesh(&mesh);
        let counts = differences(29, &world, cells, n, |rng, index| {
            let i = rng.below(world.triangles.len());
            let [a, b, _] = world.corners(i);
            let target =
                if index.is_multiple_of(2) { a.lerp(b, rng.unit()) } else { point_in(world.corners(i), rng) };
            let height = if rng.below(2) == 0 { 1.0 } else { -1.0 };
            let origin = target + DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), height);
            Ray::new(origin, target - origin)
        });
        // All rays hit except those at the outermost edges.
        assert!(counts[3] > n * 97 / 100, "leaks: {counts:?}");
        counts
    });
    conclude(29, "a flat mesh on cell faces, and in a box without thickness", 3 * n, sum(counts));
}

#[test]
fn case_30_a_grid_far_from_the_origin() {
    let n = rays(50_000, 5_000_000);
    let counts = [1e4, 1e6].map(|shift| {
        let mesh = Closed::new(moved(&bunny("5k"), |v| v + shift));
        differences(30, &world_of_mesh(&mesh.mesh), [50; 3], n, outside(&mesh, 4.0))
    });
    conclude(30, "the rabbit at 1e4 and 1e6", 2 * n, sum(counts));
}

#[test]
fn case_31_rays_from_far_away() {
    let mesh = Closed::new(bunny("1k"));
    let world = world_of_mesh(&mesh.mesh);
    let n = rays(80_000, 8_000_000);
    // All distances but the first are so large that the caster tests every primitive. For the last two
    // distances the error of f64 exceeds what the filter can bound. With a single cell, this happens before
    // the DDA becomes inaccurate.
    let farther = [(3e5, n, 50), (1e6, n / 4, 50), (1e12, n / 80, 50), (2e9, n / 80, 1)];
    let counts =
        farther.map(|(distance, n, side)| differences(31, &world, [side; 3], n, outside(&mesh, distance)));
    conclude(31, "origins 3e5 to 1e12 extents away", farther.iter().map(|f| f.1).sum(), sum(counts));
}

/// Without a grid only the filter limits the distance of rays.
#[test]
fn rays_from_far_away_without_a_grid() {
    const SEED: u64 = 1031;
    let mesh = Closed::new(bunny("1k"));
    let world = world_of_mesh(&mesh.mesh);
    let caster = Caster::new(&world, None).expect("no grid");
    let (brute, aim, failures) = (Brute::new(&world), outside(&mesh, 1e12), Failures::default());
    let n = rays(1000, 100_000);
    let one = |index| {
        let ray = aim(&mut Rng::at(SEED, index), index);
        let expected = brute.closest(&ray);
        let differs = caster.closest(&ray) != expected;
        failures.note(differs, || failed_ray(31, SEED, index, ray.origin, ray.direction));
        ([differs, expected.is_some()].map(u64::from), [])
    };
    let [differences, hits] = measure::<2, 0>(n, one).0;
    println!("{n} rays from 1e12 extents away, {hits} of which hit: {differences} differ without a grid");
    assert_eq!(differences, 0);
    assert!(hits > n / 2, "the test tests nothing");
}

/// In cells that are so flat that a ray within the filter's range comes from too far away for the DDA: hits
/// whose cell depends on the last bits of t.
#[test]
fn rays_from_far_away_into_flat_cells() {
    const SEED: u64 = 2031;
    // The number of cells for which the product of the rounded cell size and its rounded inverse most exceeds
    // 1.
    let cells = (80..130).map(|n| [1, 1, n]).max_by(|&a, &b| excess(a).total_cmp(&excess(b)));
    let cells = cells.expect("some number");
    let (world, targets) = pairs_at_faces(cells);
    let caster = Caster::new(&world, Some(cells)).expect("a grid that fits");
    let brute = Brute::new(&world);
    let failures = Failures::default();
    let n = rays(2_000, 200_000);
    let lattice = lattice(&world, cells);
    let one = |index| {
        let rng = &mut Rng::at(SEED, index);
        let draw = || {
            let (face, target) = targets[rng.below(targets.len())];
            // The origins are up to 2^19 extents away, which is the limit of the filter.
            let away = DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), -rng.range(0.7, 1.0));
            let origin = target + 2f64.powi(19) * away;
            let ray = Ray::new(origin, 0.9 * (target - origin));
            (lateness(&lattice, &ray, face, target.z), ray)
        };
        let (late, ray) =
            std::iter::repeat_with(draw).take(200).max_by(|a, b| a.0.total_cmp(&b.0)).expect("a ray");
        let (found, expected) = (caster.closest(&ray), brute.closest(&ray));
        let differs = found != expected;
        failures.note(differs, || failed_ray(31, SEED, index, ray.origin, ray.direction));
        ([differs, expected.is_some(), late > 0.0].map(u64::from), [])
    };
    let [differences, hits, late] = measure::<3, 0>(n, one).0;
    println!("{n} rays from up to 2^19 extents into flat cells, {late} of them late: {differences} differ");
    assert_eq!(differences, 0);
    assert!(hits == n && late > n / 10, "the test tests nothing");
}

/// The difference between the t where the DDA leaves the cell before a face and the t where the ray reaches a
/// height.
fn lateness(lattice: &Lattice, ray: &Ray, face: usize, height: f64) -> f64 {
    let (_, steps) = steps(lattice, ray);
    let exit = steps.iter().find(|step| step.0[2] == face - 1).map_or(f64::NEG_INFINITY, |step| step.1);
    exit - (height - ray.origin.z) / ray.direction.z
}

/// The flattest box that does not count as one without thickness, divided into cells.
fn flat_frame() -> Mesh {
    let flat = DVec3::new(1.0, 1.0, 1.01 * 2f64.powi(-10));
    moved(&frame(), |v| v * flat)
}

/// The excess over 1 of the product of the rounded cell size and the rounded number of cells per unit.
fn excess(cells: [usize; 3]) -> f64 {
    let lattice = lattice(&world_of_mesh(&flat_frame()), cells);
    let per_unit = cells[2] as f64 / lattice.bounds.extent().z;
    let [product, error] = exact_product(lattice.cell_size.z, per_unit);
    (product - 1.0) + error
}

/// Just beyond each face of the flat cells, two triangles that cross a ray upwards: a level one that lies
/// only in the cell beyond the face, and a little behind it one that extends down into the cell before the
/// face. Returns the world and the points to aim at.
fn pairs_at_faces(cells: [usize; 3]) -> (World, Vec<(usize, DVec3)>) {
    let mut mesh = flat_frame();
    let lattice = lattice(&world_of_mesh(&mesh), cells);
    let rng = &mut Rng::new(2031);
    let mut targets = vec![];
    for face in 2..cells[2] {
        let height = |up: f64| lattice.bounds.min.z + (face as f64 + up) * lattice.cell_size.z;
        // This is slightly less than the padding of the cells.
        let beyond = dda_error_bound(&lattice) + 1.01e-5;
        let at = |x: f64, y: f64, up: f64| DVec3::new(x, y, height(up));
        let (x, y) = (rng.range(0.1, 0.9), rng.range(0.1, 0.9));
        let triangle = |to_left: f64, to_right: f64| {
            [at(x - 4e-3, y, to_left), at(x + 2e-3, y - 4e-3, to_right), at(x + 2e-3, y + 4e-3, to_right)]
        };
        push(&mut mesh, triangle(beyond, beyond));
        push(&mut mesh, triangle(-0.2, 0.1 + 1.5 * beyond + 3e-7));
        targets.push((face, at(x, y, beyond)));
    }
    (world_of_mesh(&mesh), targets)
}

#[test]
fn case_32_any_number_of_cells() {
    let mesh = Closed::new(bunny("200"));
    let world = world_of_mesh(&mesh.mesh);
    let n = rays(12_000, 1_500_000);
    let sizes =
        [[1; 3], [2; 3], [3; 3], [7; 3], [64; 3], [1, 500, 1], [500, 1, 3], [400, 2, 500], [13, 200, 77]];
    let counts = sizes.map(|cells| differences(32, &world, cells, n, outside(&mesh, 4.0)));
    conclude(32, "1 to 500 cells along an axis", sizes.len() as u64 * n, sum(counts));
}

/// The cells of a sphere are found even where the padding is smaller than the rounding error of the radius.
#[test]
fn a_sphere_that_is_huge_in_cells_stands_where_its_top_is() {
    let bounds = Aabb { min: DVec3::splat(-0.1), max: DVec3::splat(2.9) };
    let lattice = Lattice::new(bounds, [1, 7, 1]);
    for k in 0..20_000 {
        let radius = 2f64.powi(37) * (1.0 + f64::from(k) / 20_000.0);
        // The top of the sphere is close to a face.
        let face = bounds.min.y + f64::from(1 + k % 6) * lattice.cell_size.y;
        let center = DVec3::new(1.4, face - radius, 1.4);
        // This difference is exact, since the two numbers are almost equal.
        let top = center.y + radius;
        let [_, cell, _] = lattice.cell_at(lattice.to_cells(DVec3::splat(top)));
        let mut cells = vec![];
        of_ball(&lattice, center, radius, 1e-5, &mut cells);
        assert!(cells.contains(&(lattice.index([0, cell as usize, 0]) as u32)), "{radius}");
    }
}
