use super::*;
use crate::caster::Caster;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use glam::DVec3;

/// Returns a world of `count` triangles, given by their numbers, and a sphere.
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

/// Returns a world with most of its triangles in a corner, so that this cell is crowded.
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
    let blocks = structure.contents.blocks.iter();
    let mut ids: Vec<u32> = blocks.flat_map(|block| structure.contents.primitives_of(block)).collect();
    assert_eq!(ids.len(), structure.size().references);
    ids.sort_unstable();
    assert_eq!(ids, (0..=COUNT).collect::<Vec<_>>());
}

/// Three crossed triangles near the origin and one triangle far away, with a small sphere beside it.
fn crossed() -> World {
    let triangle = |p: &str, q: &str, r: &str| format!("Triangle {{ vertex0 {p} vertex1 {q} vertex2 {r} }}");
    let objects = [
        triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.4 0.1"),
        triangle("0.1 0.1 0.1", "0.4 0.1 0.1", "0.1 0.1 0.4"),
        triangle("0.1 0.1 0.1", "0.1 0.4 0.1", "0.1 0.1 0.4"),
        triangle("3.6 3.6 3.6", "3.9 3.6 3.6", "3.6 3.9 3.9"),
        "Sphere { center 3.8 3.8 3.8 radius 0.1 }".into(),
    ];
    let text = format!(
        "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 5 }}
         Materials {{ numMaterials 1 Material {{ }} }}
         Group {{ numObjects 5 MaterialIndex 0 {} }}",
        objects.join(" ")
    );
    World::new(&parse(&text).unwrap(), &[]).unwrap()
}

#[test]
fn the_fullest_cells_come_first() {
    let world = crossed();
    let of = |caster: &Caster, most| caster.fullness(most).unwrap();
    let uniform = Caster::new(&world, Some([4, 4, 4])).unwrap();
    let expected = Fullness { fullest: vec![([0; 3], 3), ([3; 3], 2)], empty: 62, cells: 64 };
    assert_eq!(of(&uniform, 5), expected);
    assert_eq!(of(&uniform, 1), Fullness { fullest: vec![([0; 3], 3)], ..expected.clone() });
    assert_eq!(Caster::new(&world, None).unwrap().fullness(5), None);
}
