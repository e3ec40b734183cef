//! Compares the visibility buffer with the rays that it replaces.

use super::*;
use crate::caster::RayOrigin;
use crate::scene;
use crate::scene::mesh::Mesh;
use crate::scene::model::Screen::BothSides;
use crate::scene::parser::parse;
use glam::DVec2;

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

/// Returns the offsets from a pixel's centre of some rays that a buffer replaces, including the farthest.
fn offsets(footprint: Footprint) -> Vec<DVec2> {
    let across = [-0.5, -0.3, 0.0, 0.2, 0.5];
    match footprint {
        Footprint::Center => vec![DVec2::ZERO],
        Footprint::Pixel => across.iter().flat_map(|&y| across.map(|x| DVec2::new(x, y))).collect(),
    }
}

/// Checks each pixel of these rows against its rays. Returns the number of pixels that show nothing, that show a
/// primitive, and that are unsure.
fn counts(
    camera: &Camera,
    world: &World,
    size: [usize; 2],
    rows: Range<usize>,
    footprint: Footprint,
) -> [usize; 3] {
    let caster = Caster::new(world, Some([20; 3])).unwrap();
    let buffer = VisibilityBuffer::new(camera, &caster, size, rows.clone(), footprint).unwrap();
    let offsets = offsets(footprint);
    let mut counts = [0; 3];
    for (i, j) in rows.flat_map(|j| (0..size[0]).map(move |i| (i, j))) {
        let mut kind = 0;
        for &offset in &offsets {
            let ray = camera.ray(DVec2::new(i as f64, j as f64), offset);
            let cast = caster.nearest(&ray, RayOrigin::FREE);
            kind = match buffer.first_hit(world, &ray, [i, j]) {
                FirstHit::Nothing => {
                    assert_eq!(cast, None, "{i} {j} {offset}");
                    0
                }
                FirstHit::Primitive(visible) => {
                    let hit = world.hit(&ray, visible);
                    assert_eq!(cast.map(|cast| world.hit(&ray, cast)), Some(hit), "{i} {j} {offset}");
                    1
                }
                FirstHit::Unknown => 2,
            };
        }
        counts[kind] += 1;
    }
    counts
}

#[test]
fn what_is_seen_is_what_rays_hit_and_little_is_unsure() {
    let planes = ["Plane { normal 0 1 0.1 offset -0.9 }", "Plane { normal 0.2 0 1 offset -0.5 }"];
    for (camera, (triangles, size, objects, rows)) in [
        (spread(40, 1.0), [70, 90], &[][..], 0..90),
        (spread(40, 1.0), [70, 90], &planes, 5..70),
        (spread(2000, 0.1), [90, 70], &planes[..1], 0..70),
        (spread(40, 1.0), [64, 64], &[], 0..64),
        (spread(20_000, 0.05), [200, 170], &[], 0..170),
    ]
    .into_iter()
    .flat_map(|case| [(CAMERA, case.clone()), (ORTHOGRAPHIC, case)])
    {
        // Every parallel ray hits a plane, since the camera also sees it behind itself.
        let fills = objects.len() > 1 || camera == ORTHOGRAPHIC && !objects.is_empty();
        // In perspective, nearer triangles are larger.
        let least_seen = if camera == CAMERA { 700 } else { 150 };
        let (camera, world) = scene(camera, &triangles, objects, size);
        let [nothing, seen, unsure] = counts(&camera, &world, size, rows.clone(), Footprint::Center);
        assert!(25 * unsure < seen, "{nothing} {seen} {unsure}");
        assert!(seen > 1000 && (fills || nothing > 200), "{nothing} {seen} {unsure}");
        // With whole pixels, the pixels at the edges of triangles are unsure.
        let [nothing, seen, unsure] = counts(&camera, &world, size, rows, Footprint::Pixel);
        assert!(triangles.len() > 40 || unsure < seen + nothing, "{nothing} {seen} {unsure}");
        assert!(seen > least_seen && (fills || nothing > 200), "{nothing} {seen} {unsure}");
    }
}

/// Covers a view whose sides span different angles per pixel, and views whose up vector leans ahead or back, among the
/// triangles.
#[test]
fn stretched_and_skew_views_are_rasterized() {
    let triangles = spread(300, 0.4);
    let up = |y: f64, z: f64| DVec3::new(0.1, y, z);
    for (height, up, up_as_written) in [
        (4.0, up(1.0, 0.0), false),
        (4.0, up(1.5, 0.9), true),
        (4.0, up(0.3, -0.5), true),
        (0.2, up(1.5, 0.9), true),
        (0.2, up(0.3, -0.5), true),
    ] {
        let direction = DVec3::new(0.1, -0.2, -1.0);
        let camera =
            scene::Camera::Perspective { center: DVec3::new(0.0, 0.1, height), direction, up, angle: 50.0 };
        for size in [[90, 40], [40, 90]] {
            let (_, world) = scene(CAMERA, &triangles, &["Plane { normal 0 1 0.1 offset -1.5 }"], size);
            let camera = Camera::with_screen(&camera, size, BothSides { up_as_written });
            for (footprint, least) in [(Footprint::Center, 9), (Footprint::Pixel, 1)] {
                let [_, seen, unsure] = counts(&camera, &world, size, 0..size[1], footprint);
                assert!(seen > least * unsure / 2 && seen > 1000, "{seen} {unsure} {camera:?}");
            }
        }
    }
}

/// Two triangles share an edge through the centres of a column, so nothing is certain there.
#[test]
fn pixels_on_an_edge_are_unsure() {
    assert_ne!(UNSURE, NOTHING);
    let [low, high, left, right] =
        [(0.0, -0.5), (0.0, 0.5), (-0.5, 0.0), (0.5, 0.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let parallel = "OrthographicCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 size 3 }";
    for camera in [CAMERA, parallel] {
        let (camera, world) = scene(camera, &[[low, high, left], [low, right, high]], &[], [33, 33]);
        let [nothing, seen, unsure] = counts(&camera, &world, [33, 33], 0..33, Footprint::Center);
        assert!(nothing > 500 && seen > 40 && (11..30).contains(&unsure), "{nothing} {seen} {unsure}");
    }
}

/// The pixels of a sphere's box are unsure, unless a triangle hides them.
#[test]
fn rays_are_cast_where_a_sphere_may_be_seen() {
    let parallel = "OrthographicCamera { center 0 0 4 direction 0 0 -1 up 0 1 0 size 3 }";
    let wall = [DVec3::new(-9.0, -9.0, 0.5), DVec3::new(9.0, -9.0, 0.5), DVec3::new(0.0, 9.0, 0.5)];
    let small = wall.map(|corner| DVec3::new(0.01 * corner.x + 1.0, 0.01 * corner.y, 0.5));
    for camera in [CAMERA, parallel] {
        let unsure = |triangle: [DVec3; 3], sphere: &str| {
            let (camera, world) = scene(camera, &[triangle], &[sphere], [33, 33]);
            counts(&camera, &world, [33, 33], 0..33, Footprint::Center)[2]
        };
        let (round, flat) = (
            "Sphere { center 0 0 0 radius 0.25 }",
            "Transform { Scale 1 0.5 1 Sphere { center 0 0 0 radius 0.25 } }",
        );
        let [found, found_flat] = [round, flat].map(|sphere| unsure(small, sphere));
        assert!((25..150).contains(&found) && (15..found).contains(&found_flat), "{found} {found_flat}");
        assert_eq!(unsure(wall, round), unsure(wall, "Sphere { center 99 0 0 radius 0.25 }"));
        assert!(unsure(wall, "Sphere { center 0 0 0.5 radius 0.25 }") >= found);
    }
    // The eye is within the sphere's box.
    let (camera, world) = scene(CAMERA, &[small], &["Sphere { center 0 0 4 radius 2 }"], [33, 33]);
    assert_eq!(counts(&camera, &world, [33, 33], 0..33, Footprint::Center)[2], 33 * 33);
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
