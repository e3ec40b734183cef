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

#[test]
fn a_list_is_a_cell_with_everything_in_it() {
    let list = AccelerationStructure::new(&identical(5), Layout::List).unwrap();
    assert_eq!(list.size(), StructureSize { cells: 1, references: 6, blocks: 1 });
}

/// Every third triangle is a line.
#[test]
fn triangles_without_area_are_in_the_structures_of_the_course_alone() {
    let world = world(30, |i| {
        let corner = DVec3::splat(f64::from(i) / 30.0);
        [DVec3::ZERO, DVec3::X, if i % 3 == 0 { 0.5 * DVec3::X } else { DVec3::Y }].map(|side| corner + side)
    });
    assert_eq!((world.finite_count(), world.hittable_count()), (31, 21));
    for (layout, references) in [
        (Layout::List, 21),
        (Layout::Grid([1; 3]), 21),
        (Layout::Tree, 21),
        (Layout::Course(None), 31),
        (Layout::Course(Some([1; 3])), 31),
    ] {
        let structure = AccelerationStructure::new(&world, layout).unwrap();
        assert_eq!(structure.size().references, references, "{layout:?}");
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
fn every_primitive_is_once_in_a_leaf() {
    const COUNT: u32 = 4000;
    let world = corner_crowd(COUNT);
    let structure = AccelerationStructure::new(&world, Layout::Tree).unwrap();
    let blocks = structure.blocks.iter();
    let mut ids: Vec<u32> = blocks.flat_map(|block| structure.cells.primitives_of(block)).collect();
    assert_eq!(ids.len(), structure.size().references);
    ids.sort_unstable();
    assert_eq!(ids, (0..=COUNT).collect::<Vec<_>>());
}
