//! Compares the visibility buffer with the rays that it replaces.

use super::*;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;

const CAMERA: &str = "PerspectiveCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 angle 40 }";

/// A camera among the primitives, because it also sees objects behind it.
const ORTHOGRAPHIC: &str = "OrthographicCamera { center 0.1 0 0.2 direction 0.2 -0.1 -1 up 0 1 0 size 2.9 }";

/// Returns the camera of a scene, and its world of these triangles and objects.
fn scene(camera: &str, triangles: &[[DVec3; 3]], objects: &[&str], size: [usize; 2]) -> (Camera, World) {
    let text = format!(
        "{camera} Group {{ numObjects {} Material {{ }} TriangleMesh {{ obj_file a.obj }} {} }}",
        objects.len() + 1,
        objects.join(" ")
    );
    let scene = parse(&text).unwrap();
    let mesh = Mesh {
        vertices: triangles.as_flattened().to_vec(),
        triangles: (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect(),
    };
    (Camera::new(&scene.camera, size), World::new(&scene, &[mesh]).unwrap())
}

/// Returns triangles of this size, spread over a cube by golden ratios, with alternating orientation.
fn spread(count: u32, size: f64) -> Vec<[DVec3; 3]> {
    let corner = |k: f64| 2.0 * (DVec3::new(0.618_034, 0.754_878, 0.569_840_3) * k).fract() - 1.0;
    let triangle = |i: u32| {
        let k = f64::from(i);
        let [a, b, c] =
            [corner(k), corner(k) + size * corner(7.3 * k + 1.0), corner(k) + size * corner(3.7 * k + 2.0)];
        if i.is_multiple_of(2) { [a, b, c] } else { [a, c, b] }
    };
    (0..count).map(triangle).collect()
}

#[test]
fn rays_are_cast_where_that_is_less_work_or_the_world_has_other_things() {
    let is_drawn = |camera: &str, triangles: &[[DVec3; 3]], objects: &[&str], cells: Option<[usize; 3]>| {
        let (camera, world) = scene(camera, triangles, objects, [40, 30]);
        let caster = Caster::new(&world, cells).unwrap();
        VisibilityBuffer::new(&camera, &caster, [40, 30], 0..30, Footprint::Center).is_some()
    };
    let few = spread(40, 0.1);
    assert!(is_drawn(CAMERA, &few, &[], None));
    let sphere = "Sphere { center 0 0 0 radius 0.1 }";
    assert!(is_drawn(CAMERA, &few, &[sphere], None) && !is_drawn(CAMERA, &[], &[sphere], None));
    assert!(is_drawn(ORTHOGRAPHIC, &few, &[], None));
    // From this distance the errors of single rays exceed the triangles.
    let far = "OrthographicCamera { center 1e14 0 4 direction 0 0 -1 up 0 1 0 size 2 }";
    assert!(!is_drawn(far, &few, &[], None));
    // With a grid, rasterization pays for up to three triangles per four pixels, without a grid for many more.
    for (count, with_grid) in [(900, true), (901, false)] {
        let tiny = spread(count, 1e-3);
        assert!(is_drawn(CAMERA, &tiny, &[], None));
        assert_eq!(is_drawn(CAMERA, &tiny, &[], Some([5; 3])), with_grid, "{count}");
    }
    // Up to sixteen triangles over every pixel.
    let wide = |z: f64| [DVec3::new(-99.0, -99.0, z), DVec3::new(99.0, -99.0, z), DVec3::new(0.0, 99.0, z)];
    for (count, expected) in [(16, true), (17, false)] {
        let triangles: Vec<_> = (0..count).map(|k| wide(f64::from(k) * -0.1)).collect();
        assert_eq!(is_drawn(CAMERA, &triangles, &[], None), expected, "{count}");
    }
}
