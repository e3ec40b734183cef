//! Section B, cases 28 to 32: large and flat things in a grid, grids far from the origin, rays from
//! far away, and every number of cells.

use crate::grid::{conclude, differences, frame, outside, push, sum};
use crate::support::meshes::{Closed, bunny, moved, point_in, world_of};
use crate::support::product_grid::lattice;
use crate::support::rays;
use crate::support::rng::Rng;
use glam::DVec3;
use raytracer::math::ray::Ray;
use raytracer::scene::mesh::Mesh;

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
    let world = world_of(&mesh);
    let n = rays(50_000, 5_000_000);
    let aim = |rng: &mut Rng, _| {
        let origin = 0.5 + 1.5 * rng.direction();
        Ray::new(origin, point_in(world.corners(rng.below(world.triangles.len())), rng) - origin)
    };
    let counts = [[30; 3], [7, 90, 16]].map(|cells| differences(28, &world, cells, n, aim));
    conclude(28, "a quad through the whole grid among small triangles", 2 * n, sum(counts));
}

/// A flat square of 100 by 100 quads at the height `z`.
fn flat(mesh: &mut Mesh, z: f64) {
    let at = |i: usize, j: usize| DVec3::new(0.02 + 0.0096 * i as f64, 0.02 + 0.0096 * j as f64, z);
    for i in 0..100 {
        for j in 0..100 {
            push(mesh, [at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            push(mesh, [at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
}

/// A flat mesh alone, whose box has no thickness; in a plane between cells; and on the box' side.
fn flat_meshes(cells: [usize; 3]) -> [Mesh; 3] {
    let lattice = lattice(&world_of(&frame()), cells);
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
        let world = world_of(&mesh);
        let counts = differences(29, &world, cells, n, |rng, index| {
            let i = rng.below(world.triangles.len());
            let [a, b, _] = world.corners(i);
            let target =
                if index.is_multiple_of(2) { a.lerp(b, rng.unit()) } else { point_in(world.corners(i), rng) };
            let height = if rng.below(2) == 0 { 1.0 } else { -1.0 };
            let origin = target + DVec3::new(rng.range(-1.0, 1.0), rng.range(-1.0, 1.0), height);
            Ray::new(origin, target - origin)
        });
        // All but the rays at the outermost edges hit.
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
        differences(30, &world_of(&mesh.mesh), [50; 3], n, outside(&mesh, 4.0))
    });
    conclude(30, "the rabbit at 1e4 and 1e6", 2 * n, sum(counts));
}

#[test]
fn case_31_rays_from_far_away() {
    let mesh = Closed::new(bunny("1k"));
    let world = world_of(&mesh.mesh);
    let n = rays(80_000, 8_000_000);
    // The last two are so far that the caster goes back to testing everything.
    let farther = [(3e5, n), (1e6, n / 4), (1e9, n / 80)];
    let counts = farther.map(|(distance, n)| differences(31, &world, [50; 3], n, outside(&mesh, distance)));
    conclude(31, "origins 3e5, 1e6 and 1e9 extents away", farther.iter().map(|f| f.1).sum(), sum(counts));
}

#[test]
fn case_32_any_number_of_cells() {
    let mesh = Closed::new(bunny("200"));
    let world = world_of(&mesh.mesh);
    let n = rays(12_000, 1_500_000);
    let sizes =
        [[1; 3], [2; 3], [3; 3], [7; 3], [64; 3], [1, 500, 1], [500, 1, 3], [400, 2, 500], [13, 200, 77]];
    let counts = sizes.map(|cells| differences(32, &world, cells, n, outside(&mesh, 4.0)));
    conclude(32, "1 to 500 cells along an axis", sizes.len() as u64 * n, sum(counts));
}
