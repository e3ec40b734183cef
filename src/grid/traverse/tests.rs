use super::*;
use crate::grid::options::{CellRule, GridOptions};
use crate::grid::{Caster, Instructions};
use crate::math::f64x4::Scalar;
use crate::scene::parser::parse;
use crate::stats::Quiet;
use crate::world::World;
use glam::DVec3;

#[test]
fn a_ray_is_in_the_proven_range_by_its_distance_from_the_centre() {
    let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
         Group { numObjects 1 Material { } Sphere { center 1000 0 0 radius 0.0005 } }";
    let world = World::new(&parse(text).unwrap(), &[]).unwrap();
    let structure = AccelerationStructure::new(&world, GridOptions::uniform([1; 3])).unwrap();
    let is_in_proven_range = |x: f64| {
        let ray = Ray::new(DVec3::X * x, DVec3::Y);
        structure.is_in_proven_range(&RayLanes::<Scalar>::all_axes(Portable, &ray))
    };
    assert!([1000.0, 600.0, 1400.0].into_iter().all(is_in_proven_range));
    assert!(![-1000.0, 0.0, 400.0, 1600.0, f64::NAN].into_iter().any(is_in_proven_range));
}

/// Crowded cells have a list of the triangles that span them beside a nested grid of the others.
#[test]
fn a_crowded_cell_is_searched_in_its_list_and_in_its_nested_grid() {
    let text = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }
         Group { numObjects 1 Material { } TriangleMesh { obj_file a.obj } }";
    let mut vertices = vec![];
    for k in 0..600 {
        let corner = (DVec3::new(0.618_034, 0.754_878, 0.569_840_3) * f64::from(k)).fract();
        vertices.extend([DVec3::ZERO, DVec3::X, DVec3::Y].map(|side| corner + 0.04 * side));
    }
    for z in [0.3, 0.7] {
        vertices.extend([DVec3::new(-0.2, -0.2, z), DVec3::new(0.9, 0.1, z), DVec3::new(0.2, 0.8, z + 0.1)]);
    }
    let triangles = (0..602).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = crate::scene::mesh::Mesh { vertices, triangles };
    let world = World::new(&parse(text).unwrap(), &[mesh]).unwrap();
    let options = GridOptions { cells: Some([2; 3]), rule: CellRule::Nested { max_per_cell: 20 } };
    let [plain, nested] = [GridOptions::NONE, options]
        .map(|options| Caster::with(&world, options, Instructions::Portable).unwrap());
    let structure = nested.structure.as_ref().unwrap();
    assert!(structure.nested.iter().any(|nested| nested.spanning.is_some()));
    let mut hits = 0;
    for k in 0..4000 {
        let point = |k: f64| (DVec3::new(0.618_034, 0.754_878, 0.569_840_3) * k).fract();
        let [from, to] = [3.0 * point(f64::from(k)) - 1.0, point(7.3 * f64::from(k) + 0.5)];
        let ray = Ray { t_max: 1.2, ..Ray::new(from, to - from) };
        let expected = plain.closest(&ray, &mut Quiet);
        assert_eq!(nested.closest(&ray, &mut Quiet), expected, "{ray:?}");
        assert_eq!(nested.any(&ray, &mut Quiet), expected.is_some(), "{ray:?}");
        hits += usize::from(expected.is_some());
    }
    assert!((1000..3900).contains(&hits), "{hits}");
}
