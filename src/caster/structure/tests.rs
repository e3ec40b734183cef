use super::*;
use crate::base::patience::Endless;
use crate::caster::cell_counts::CellCounts;
use crate::math::instructions::Level;
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
