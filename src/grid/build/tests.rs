use super::*;
use crate::grid::triangle8::NONE;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;

/// A world of `count` triangles by their numbers, and of a sphere.
fn world(count: u32, corners: impl Fn(u32) -> [DVec3; 3]) -> World {
    let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 } Group { numObjects 2
         Material { } TriangleMesh { obj_file a.obj } Sphere { center 0.5 0.5 0.5 radius 0.125 } }";
    let vertices = (0..count).flat_map(corners).collect();
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    World::new(&parse(text).unwrap(), &[Mesh { vertices, triangles }]).unwrap()
}

fn identical(count: u32) -> World {
    world(count, |_| [DVec3::ZERO, DVec3::ONE, DVec3::Y])
}

/// Small triangles, evenly spread over the unit cube.
fn scattered(count: u32) -> World {
    world(count, |i| {
        let corner = DVec3::new(0.618, 0.754, 0.569) * f64::from(i);
        [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| corner.fract() + 0.01 * side)
    })
}

#[test]
fn sizes_add_up() {
    let [one, other] =
        [1, 3].map(|n| StructureSize { cells: n, references: 10 * n, blocks: 20 * n, cost: 30 * n });
    assert_eq!(one + other, StructureSize { cells: 4, references: 40, blocks: 80, cost: 120 });
}

#[test]
fn a_list_is_a_cell_with_everything_in_it() {
    let list = AccelerationStructure::new(&identical(5), GridOptions::NONE).unwrap();
    assert_eq!(
        list.size(&list.blocks),
        StructureSize { cells: 1, references: 6, blocks: 1, cost: 6 * REFERENCE_COST }
    );
}

/// The cost of a structure counts abandoned attempts, the cell lists, and a list that takes their place.
#[test]
fn primitives_that_no_grid_separates_become_a_list_whose_cost_counts_every_attempt() {
    const CROWD: usize = 96;
    for (world, is_list) in [
        (identical(CROWD as u32), true),
        (identical(CROWD as u32 - 1), false),
        (identical(CROWD as u32 - 2), false),
        (scattered(CROWD as u32 + 10), false),
    ] {
        let (bounds, cells, count) = (bounds_of(&world), [400; 3], world.finite_count());
        let allowance = Allowance::new(CROWD, count);
        let rule = CellRule::Nested { max_per_cell: CROWD };
        let fitted = FittedLattice::new(&world, &PrimSet::All, bounds, cells, rule, allowance).unwrap();
        let built = AccelerationStructure::automatic(&world, PrimSet::All, bounds, cells, allowance).unwrap();
        assert_eq!(built.table.is_none(), is_list, "{count}");
        let list_cost = if is_list { REFERENCE_COST * count } else { 0 };
        assert!(is_list || fitted.abandoned_cost > 1 || count > CROWD);
        assert_eq!(built.cost, fitted.abandoned_cost + fitted.cell_lists.cost() + list_cost, "{count}");
    }
}

#[test]
fn an_origin_may_be_as_many_boxes_or_cells_away_as_the_proofs_hold_for() {
    let bounds = Aabb { min: DVec3::ONE, max: DVec3::new(2.0, 3.0, 5.0) };
    assert_eq!(max_origin_distance(&bounds, f64::INFINITY), 4.0 * MAX_ORIGIN_BOXES);
    assert_eq!(max_origin_distance(&bounds, 1.0 / 65536.0), MAX_ORIGIN_CELLS / 65536.0);
}

#[test]
fn what_covers_half_a_cell_along_an_axis_spans_it() {
    let cell = Aabb { min: DVec3::ONE, max: DVec3::splat(3.0) };
    let along_y =
        |low: f64, high: f64| Aabb { min: DVec3::new(1.25, low, 1.25), max: DVec3::new(1.5, high, 1.5) };
    for (low, high) in [(1.5, 2.5), (-9.0, 2.0), (2.0, 9.0), (-9.0, 9.0)] {
        assert!(spans(&along_y(low, high), &cell), "{low} {high}");
    }
    for (low, high) in [(1.5, 2.25), (-9.0, 1.75), (2.25, 9.0), (-9.0, 0.5)] {
        assert!(!spans(&along_y(low, high), &cell), "{low} {high}");
    }
}

#[test]
fn the_box_of_a_cell_is_padded_by_about_twice_the_padding_of_insertion() {
    let bounds = Aabb { min: DVec3::new(-1.0, 2.0, 5.0), max: DVec3::new(1.0, 6.0, 6.0) };
    let lattice = Lattice::new(bounds, [3, 4, 5]);
    let padding = padding(&lattice);
    for index in [[0, 0, 0], [2, 1, 3], [1, 3, 4]] {
        let cell = padded_cell(&lattice, lattice.index(index) as u32);
        let low = DVec3::from_array(index.map(|i| i as f64));
        let [below, above] = [low - lattice.to_cells(cell.min), lattice.to_cells(cell.max) - (low + 1.0)];
        for beyond in below.to_array().into_iter().chain(above.to_array()) {
            assert!((1.5 * padding..2.5 * padding).contains(&beyond), "{index:?} {beyond} {padding}");
        }
    }
}

#[test]
fn a_grid_within_a_cell_has_less_than_half_as_many_cells_as_primitives() {
    let cell = Aabb { min: DVec3::ZERO, max: DVec3::ONE };
    let (_, cells) = nested_cells(&scattered(1000), &PrimSet::All, &cell);
    assert!((300..500).contains(&cells.iter().product::<usize>()), "{cells:?}");
}

/// The triangles in the blocks of a structure and in those of all nested ones, with the number of levels. The blocks of
/// each structure hold triangles of that structure only.
fn triangles_in(structure: &AccelerationStructure, world: &World, blocks: &[Block]) -> (Vec<u32>, usize) {
    let ids = blocks[..structure.cells.block_count()].iter().flat_map(|block| block.index.ids);
    let mut triangles: Vec<u32> = ids.filter(|&id| id != NONE).collect();
    let own: Vec<u32> = (0..structure.prims.triangles(world)).map(|i| structure.prims.id(i)).collect();
    assert!(triangles.iter().all(|id| own.binary_search(id).is_ok()));
    let mut levels = 0;
    for nested in structure.nested.iter().flat_map(|nested| nested.spanning.iter().chain([&nested.grid])) {
        let (more, below) = triangles_in(nested, world, &blocks[nested.cells.first_block..]);
        triangles.extend(more);
        levels = levels.max(below);
    }
    (triangles, levels + 1)
}

#[test]
fn the_blocks_of_all_grids_are_in_one_list_in_which_each_grid_finds_its_own() {
    const COUNT: u32 = 4000;
    // Most triangles are in a corner, whose cell, the last one, therefore has a grid with crowded cells.
    let world = world(COUNT, |i| {
        let corner = (DVec3::new(0.618, 0.754, 0.569) * f64::from(i)).fract();
        let scale = if i % 4 == 0 { 1.0 } else { 0.02 };
        [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| 1.0 - scale * (corner + 0.01 * side))
    });
    let options = GridOptions { cells: Some([3; 3]), rule: CellRule::Nested { max_per_cell: 20 } };
    let structure = AccelerationStructure::new(&world, options).unwrap();
    let (mut triangles, levels) = triangles_in(&structure, &world, &structure.blocks);
    assert!(levels > 2, "{levels}");
    assert_eq!(structure.size(&structure.blocks).blocks, structure.blocks.len());
    triangles.sort_unstable();
    triangles.dedup();
    assert_eq!(triangles, (0..COUNT).collect::<Vec<_>>());
}
