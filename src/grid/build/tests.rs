use super::*;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use glam::DVec3;

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
fn a_list_is_a_cell_with_everything_in_it() {
    let list = AccelerationStructure::new(&identical(5), GridOptions::NONE).unwrap();
    assert_eq!(list.size(), StructureSize { cells: 1, references: 6, blocks: 1, cost: 6 * REFERENCE_COST });
}

/// Every third triangle is a line.
#[test]
fn triangles_without_area_are_in_the_structures_of_the_course_alone() {
    let world = world(30, |i| {
        let corner = DVec3::splat(f64::from(i) / 30.0);
        [DVec3::ZERO, DVec3::X, if i % 3 == 0 { 0.5 * DVec3::X } else { DVec3::Y }].map(|side| corner + side)
    });
    assert_eq!((world.finite_count(), world.hittable_count()), (31, 21));
    let course = CellRule::Course { is_bounded: true };
    for (cells, rule, references) in [
        (None, CellRule::Exact, 21),
        (None, course, 31),
        (Some([1; 3]), CellRule::Exact, 21),
        (Some([1; 3]), CellRule::Trees { max_per_cell: 99 }, 21),
        (Some([1; 3]), course, 31),
    ] {
        let structure = AccelerationStructure::new(&world, GridOptions { cells, rule }).unwrap();
        assert_eq!(structure.size().references, references, "{cells:?} {rule:?}");
    }
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
        let rule = CellRule::Trees { max_per_cell: CROWD };
        let fitted = FittedLattice::new(&world, bounds, cells, rule, allowance).unwrap();
        let built = AccelerationStructure::automatic(&world, bounds, cells, allowance).unwrap();
        assert_eq!(built.table.is_none(), is_list, "{count}");
        let list_cost = if is_list { REFERENCE_COST * count } else { 0 };
        assert!(is_list || fitted.abandoned_cost > 1 || count > CROWD);
        assert_eq!(built.cost, fitted.abandoned_cost + fitted.cell_lists.cost() + list_cost, "{count}");
    }
}

/// Most triangles are in a corner, so that its cell is crowded.
fn corner_crowd(count: u32) -> World {
    world(count, |i| {
        let corner = (DVec3::new(0.618, 0.754, 0.569) * f64::from(i)).fract();
        let scale = if i % 4 == 0 { 1.0 } else { 0.02 };
        [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| 1.0 - scale * (corner + 0.01 * side))
    })
}

#[test]
fn the_blocks_of_cells_and_trees_are_in_one_list_with_every_primitive() {
    const COUNT: u32 = 4000;
    let world = corner_crowd(COUNT);
    let options = GridOptions { cells: Some([3; 3]), rule: CellRule::Trees { max_per_cell: 20 } };
    let structure = AccelerationStructure::new(&world, options).unwrap();
    assert!(!structure.trees.nodes.is_empty());
    let blocks = structure.blocks.iter();
    let mut ids: Vec<u32> = blocks.flat_map(|block| structure.cells.primitives_of(block)).collect();
    assert_eq!(ids.len(), structure.size().references);
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids, (0..=COUNT).collect::<Vec<_>>());
}

#[test]
fn a_reference_in_a_tree_costs_as_much_as_one_in_a_cell() {
    let world = corner_crowd(1000);
    let cost = |max_per_cell: usize| {
        let options = GridOptions { cells: Some([2; 3]), rule: CellRule::Trees { max_per_cell } };
        let structure = AccelerationStructure::new(&world, options).unwrap();
        (structure.cost, structure.size().references)
    };
    let [(without, references), (with, in_trees)] = [cost(2000), cost(0)];
    assert_eq!(references, in_trees);
    assert_eq!(with, without + REFERENCE_COST * references);
}
