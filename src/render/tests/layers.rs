//! The contents of the layers of small pictures.

use super::*;
use crate::base::patience::Endless;

/// A view of cells casts no ray into the scene, unless a layer measures the scene's hits.
#[test]
fn a_view_of_cells_tests_no_primitive() {
    let text = parse(
        &scene("")
            .replace("Plane", "Transform { Scale 1 2 3 Sphere { center 0 0 0 radius 1 } } Plane")
            .replace("Objects 4", "Objects 5"),
    )
    .unwrap();
    let world = World::new(&text, &[]).unwrap();
    let caster = LazyCaster::new(Caster::of_planes(&world), Layout::List);
    let occupancy = grid_view::Occupancy::new(&text, &[], world.bounds, [4; 3], &Endless).unwrap();
    for (layers, tests) in [(vec![Layer::Color], false), (vec![Layer::Color, Layer::Normals], true)] {
        let request = Request { layers, tracing: Tracing::Counted, ..Request::new([9, 8]) };
        let (camera, view) = (Camera::new(&text.camera, request.size), View::Cells(&occupancy));
        let (pictures, counts) =
            render_in_memory(&Shot { camera, caster: &caster, view }, &request, &goes_on).unwrap();
        assert_eq!((counts.non_shadow_rays, counts.intersections > 0), (72, tests));
        assert!(pictures[0].colors.iter().any(|&color| color != world.background));
    }
}
