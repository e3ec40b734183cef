use super::*;
use crate::base::patience::Endless;
use crate::caster::cell_counts::CellCounts;
use crate::caster::{Caster, RayOrigin};
use crate::math::instructions::{self, Level};
use crate::math::ray::Ray;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use fearless_simd::dispatch;
use glam::DVec3;

/// Returns a world of `count` triangles, given by their numbers, and a sphere.
fn world(count: u32, corners: impl Fn(u32) -> [DVec3; 3]) -> World {
    let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 } Group { numObjects 2
         Material { } TriangleMesh { obj_file a.obj } Sphere { center 0.5 0.5 0.5 radius 0.125 } }";
    let vertices = (0..count).flat_map(corners).collect();
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    World::new(&parse(text).unwrap(), &[Mesh { vertices, triangles }]).unwrap()
}

#[test]
fn a_list_is_a_cell_with_everything_in_it() {
    let world = world(5, |i| [DVec3::ZERO, DVec3::ONE, f64::from(i + 1) * DVec3::Y]);
    let list = AccelerationStructure::new(&world, Layout::List, &Endless).unwrap();
    assert_eq!(list.size(), StructureSize { cells: 1, references: 6, blocks: 1 });
}

/// Every third triangle is a line, and the one after it equals the one behind that.
#[test]
fn primitives_that_no_ray_sees_are_in_no_structure() {
    let world = world(30, |i| {
        let corner = DVec3::splat(f64::from(i / 3) / 10.0);
        let sides = match i % 3 {
            0 => [DVec3::ZERO, DVec3::X, 0.5 * DVec3::X],
            1 => [DVec3::ZERO, DVec3::X, DVec3::Y],
            _ => [DVec3::ZERO, DVec3::Y, DVec3::X],
        };
        sides.map(|side| corner + side)
    });
    assert_eq!((world.finite_count(), world.visible_count()), (31, 11));
    for layout in [Layout::List, Layout::Grid([1; 3]), Layout::Tree] {
        let structure = AccelerationStructure::new(&world, layout, &Endless).unwrap();
        assert_eq!(structure.size().references, 11, "{layout:?}");
    }
    let counts = CellCounts::of_world(&world, [1; 3], &Endless).unwrap();
    assert_eq!(counts.fullness(1).fullest, [([0; 3], 31)]);
}

/// Returns a world with most of its triangles in a corner, so that this cell is crowded.
fn corner_crowd(count: u32) -> World {
    world(count, |i| {
        let corner = (DVec3::new(0.618_034, 0.754_878, 0.569_840) * f64::from(i)).fract();
        let scale = if i % 4 == 0 { 1.0 } else { 0.02 };
        [DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| 1.0 - scale * (corner + 0.01 * side))
    })
}

#[test]
fn every_primitive_is_once_in_a_leaf() {
    const COUNT: u32 = 4000;
    let world = corner_crowd(COUNT);
    let structure = AccelerationStructure::new(&world, Layout::Tree, &Endless).unwrap();
    let mut ids: Vec<u32> = structure.contents.primitives_of(0..structure.contents.len()).collect();
    assert_eq!(ids.len(), structure.size().references);
    ids.sort_unstable();
    assert_eq!(ids, (0..=COUNT).collect::<Vec<_>>());
}

#[test]
fn a_ray_is_in_the_proven_range_by_its_distance_from_the_centre() {
    let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
         Group { numObjects 1 Material { } Sphere { center 1000 0 0 radius 0.0005 } }";
    let world = World::new(&parse(text).unwrap(), &[]).unwrap();
    let structure = AccelerationStructure::new(&world, Layout::Grid([1; 3]), &Endless).unwrap();
    let is_in_proven_range = |x: f64| {
        let ray = Ray::new(DVec3::X * x, DVec3::Y);
        let last = f64::INFINITY;
        dispatch!(Level::baseline(), simd => !matches!(structure.region.entry(simd, &ray, last), Entry::TooFar))
    };
    assert!([1000.0, 600.0, 1400.0].into_iter().all(is_in_proven_range));
    assert!(![-1000.0, 0.0, 400.0, 1600.0, f64::NAN].into_iter().any(is_in_proven_range));
}

/// Returns a world of a unit cube of small triangles, two large ones and a few spheres, and a speck of tiny triangles
/// in its middle.
fn world_with_crowds() -> World {
    let spheres: String = (0..30)
        .map(|k| {
            let [x, y, z] = point(f64::from(k) + 0.25).to_array();
            format!("Sphere {{ center {x} {y} {z} radius 0.02 }}")
        })
        .collect();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Group {{ numObjects 31 Material {{ }} TriangleMesh {{ obj_file a.obj }} {spheres} }}"
    );
    let mut vertices = vec![];
    for k in 0..900 {
        let (corner, size) = match k % 3 {
            0 => (0.6 + 1e-6 * point(f64::from(k)), 3e-7),
            _ => (point(f64::from(k)), 0.04),
        };
        vertices.extend([DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| corner + size * side));
    }
    for z in [0.3, 0.7] {
        vertices.extend([DVec3::new(-0.2, -0.2, z), DVec3::new(0.9, 0.1, z), DVec3::new(0.2, 0.8, z + 0.1)]);
    }
    let triangles = (0..902).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = crate::scene::mesh::Mesh { vertices, triangles };
    World::new(&parse(&text).unwrap(), &[mesh]).unwrap()
}

/// Returns a point of a sequence that fills the unit cube evenly.
fn point(k: f64) -> DVec3 {
    (DVec3::new(0.618_034, 0.754_878, 0.569_840_3) * k).fract()
}

/// A branch of the tree has a frame of its own. Some rays start too far away for the error bounds there.
#[test]
fn a_tree_is_searched_where_testing_everything_finds_a_hit() {
    let world = world_with_crowds();
    let plain = Caster::with(&world, Layout::List, Level::baseline()).unwrap();
    for level in instructions::available() {
        let crowded = Caster::with(&world, Layout::Tree, level).unwrap();
        let structure = crowded.structure.as_ref().unwrap();
        let Order::Tree(tree) = &structure.order else { panic!("a tree was asked for") };
        assert!(!tree.small.is_empty() && tree.nodes.len() > 20);
        let (mut hits, mut tiny) = (0, 0);
        for k in 0..6000 {
            let target = match k % 3 {
                0 => 0.6 + 1e-6 * point(7.3 * f64::from(k) + 0.5),
                _ => point(7.3 * f64::from(k) + 0.5),
            };
            let far = if k % 30 == 0 { 1e6 } else { 1.0 };
            let from = far * (3.0 * point(f64::from(k)) - 1.0);
            let ray = Ray { t_max: 1.2, ..Ray::new(from, target - from) };
            let expected = plain.closest(&ray);
            assert_eq!(crowded.closest(&ray), expected, "{level:?} {ray:?}");
            assert_eq!(crowded.any(&ray, RayOrigin::FREE), expected.is_some(), "{level:?} {ray:?}");
            hits += usize::from(expected.is_some());
            tiny += usize::from(expected.is_some_and(|hit| hit.primitive % 3 == 0 && hit.primitive < 900));
        }
        assert!((1000..5900).contains(&hits) && tiny > 100, "{hits} {tiny}");
    }
}
