use super::*;
use crate::base::patience::Endless;
use crate::caster::cell_counts::CellCounts;
use crate::math::instructions::Level;
use crate::math::ray::Ray;
use crate::world::test_worlds::{world_of, world_of_triangles};
use fearless_simd::dispatch;
use glam::DVec3;

const BALL: &str = "Sphere { center 0.5 0.5 0.5 radius 0.125 }";

#[test]
fn a_list_is_a_cell_with_everything_in_it() {
    let triangle = |i: u32| [DVec3::ZERO, DVec3::ONE, f64::from(i + 1) * DVec3::Y];
    let world = world_of_triangles((0..5).map(triangle), &[BALL]);
    let list = AccelerationStructure::new(&world, Layout::List, &Endless).unwrap();
    assert_eq!(list.size(), StructureSize { cells: 1, references: 6, blocks: 1 });
}

/// Every third triangle is a line, and the one after it equals the one behind that.
#[test]
fn primitives_that_no_ray_sees_are_in_no_structure() {
    let triangle = |i: u32| {
        let corner = DVec3::splat(f64::from(i / 3) / 10.0);
        let sides = match i % 3 {
            0 => [DVec3::ZERO, DVec3::X, 0.5 * DVec3::X],
            1 => [DVec3::ZERO, DVec3::X, DVec3::Y],
            _ => [DVec3::ZERO, DVec3::Y, DVec3::X],
        };
        sides.map(|side| corner + side)
    };
    let world = world_of_triangles((0..30).map(triangle), &[BALL]);
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
    let world = world_of(&["Sphere { center 1000 0 0 radius 0.0005 }"]);
    let structure = AccelerationStructure::new(&world, Layout::Grid([1; 3]), &Endless).unwrap();
    let is_in_proven_range = |x: f64| {
        let ray = Ray::new(DVec3::X * x, DVec3::Y);
        let last = f64::INFINITY;
        dispatch!(Level::baseline(), simd => !matches!(structure.region.entry(simd, &ray, last), Entry::TooFar))
    };
    assert!([1000.0, 600.0, 1400.0].into_iter().all(is_in_proven_range));
    assert!(![-1000.0, 0.0, 400.0, 1600.0, f64::NAN].into_iter().any(is_in_proven_range));
}
