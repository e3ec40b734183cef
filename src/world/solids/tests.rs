use super::*;
use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::math::robust::offset_origin;
use crate::scene::mesh::Mesh;
use crate::scene::parser::parse;
use crate::stats::Quiet;

const GLASS: &str = "Material { transparentColor 1 1 1 }";
pub const SUN: &str = "DirectionalLight { direction 0 -1 0 color 1 1 1 }";

/// The world of these lights and objects, where `mesh.obj` is this mesh.
pub fn world(lights: &[&str], objects: &[&str], mesh: &Mesh) -> World {
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
         Lights {{ numLights {} {} }} Group {{ numObjects {} {} }}",
        lights.len(),
        lights.concat(),
        objects.len(),
        objects.concat()
    );
    let scene = parse(&text).unwrap();
    let meshes = vec![mesh.clone(); scene.meshes.len()];
    World::new(&scene, &meshes).unwrap()
}

pub fn glass(object: &str) -> String {
    format!("{GLASS} {object}")
}

/// The number of primitives whose inside is dark, for one object of glass.
fn dark(lights: &[&str], object: &str, mesh: &Mesh) -> usize {
    let world = world(lights, &[&glass(object)], mesh);
    (0..world.first_plane()).filter(|&id| world.solids.are_dark_within(id)).count()
}

/// A prism over a polygon in the plane z = 0, which is seen counter-clockwise from above, without its base if it is
/// open. The polygon's fan around its first corner must cover it.
pub fn prism(polygon: &[[f64; 2]], is_open: bool) -> Mesh {
    let n = polygon.len() as u32;
    let level = |z: f64| polygon.iter().map(move |&[x, y]| DVec3::new(x, y, z));
    let sides = (0..n).flat_map(|i| {
        let j = (i + 1) % n;
        [[i, j, j + n], [i, j + n, i + n]]
    });
    let top = (1..n - 1).map(|i| [n, n + i, n + i + 1]);
    let base = (1..if is_open { 1 } else { n - 1 }).map(|i| [0, i + 1, i]);
    Mesh {
        vertices: level(0.0).chain(level(1.0)).collect(),
        triangles: sides.chain(top).chain(base).collect(),
    }
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
/// It is not convex, but its middle sees all of it.
const ARROW: [[f64; 2]; 4] = [[0.0, -1.6], [2.0, -2.0], [0.0, 2.0], [-2.0, -2.0]];
/// Its corners have their mean outside of it.
const HOOK: [[f64; 2]; 6] = [[0.0, 0.0], [4.0, 0.0], [4.0, 0.5], [0.5, 0.5], [0.5, 4.0], [0.0, 4.0]];
pub const MESH: &str = "TriangleMesh { obj_file mesh.obj }";

#[test]
fn the_inside_of_spheres_and_of_closed_meshes_around_a_point_is_dark() {
    let square = prism(&SQUARE, false);
    assert_eq!(dark(&[SUN], "Sphere { center 0 0 0 radius 1 }", &square), 1);
    assert_eq!(dark(&[], "Box { min 0 0 0 max 1 2 3 }", &square), 12);
    for (polygon, count) in [(&SQUARE[..], 12), (&ARROW, 12), (&HOOK, 0)] {
        let mesh = prism(polygon, false);
        assert_eq!(dark(&[SUN], MESH, &mesh), count, "{polygon:?}");
        let turned = "Transform { YRotate 33 XRotate 21 Scale 1 -2 3 TriangleMesh { obj_file mesh.obj } }";
        assert_eq!(dark(&[SUN], turned, &mesh), count, "{polygon:?}");
    }
}

#[test]
fn a_mesh_with_a_hole_or_inside_out_or_without_thickness_is_no_solid() {
    assert_eq!(dark(&[SUN], MESH, &prism(&SQUARE, true)), 0);
    let mut inside_out = prism(&SQUARE, false);
    inside_out.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    assert_eq!(dark(&[SUN], MESH, &inside_out), 0);
    let flat = "Transform { Scale 1 1 1e-9 TriangleMesh { obj_file mesh.obj } }";
    assert_eq!(dark(&[SUN], flat, &prism(&SQUARE, false)), 0);
    let mut one_side_turned = prism(&SQUARE, false);
    one_side_turned.triangles[0].swap(0, 1);
    assert_eq!(dark(&[SUN], MESH, &one_side_turned), 0);
    assert_eq!(dark(&[SUN], MESH, &Mesh::default()), 0);
}

#[test]
fn a_light_inside_or_too_close_to_be_sure_lights_the_inside() {
    let (square, sphere) = (prism(&SQUARE, false), "Sphere { center 0 0 0 radius 1 }");
    for (height, is_dark) in [("0.5", false), ("1", false), ("1.0000001", false), ("1.1", true), ("-9", true)]
    {
        let lamp = format!("PointLight {{ position .5 .5 {height} color 1 1 1 }}");
        let far = "PointLight { position 5 5 5 color 1 1 1 }";
        assert_eq!(dark(&[SUN, far, &lamp], MESH, &square) > 0, is_dark, "{height}");
        let above = format!("PointLight {{ position 0 0 {height} color 1 1 1 }}");
        assert_eq!(dark(&[SUN, &above, far], sphere, &square) > 0, is_dark, "{height}");
    }
}

#[test]
fn what_is_too_small_or_too_fine_is_no_solid() {
    let far = glass("Sphere { center 1000 0 0 radius 1 }");
    for (radius, is_dark) in [("1e-2", true), ("1e-4", false)] {
        let ball = glass(&format!("Sphere {{ center 0 0 0 radius {radius} }}"));
        let world = world(&[], &[&ball, &far], &Mesh::default());
        assert_eq!(world.solids.are_dark_within(0), is_dark, "{radius}");
    }
    for (corners, count) in [(1000, 3996), (1100, 0)] {
        let angle = |k: i32| f64::from(k) / f64::from(corners) * std::f64::consts::TAU;
        let polygon: Vec<[f64; 2]> =
            (0..corners).map(|k| [libm::cos(angle(k)), libm::sin(angle(k))]).collect();
        assert_eq!(dark(&[SUN], MESH, &prism(&polygon, false)), count, "{corners}");
    }
}

#[test]
fn only_what_is_transparent_is_a_solid() {
    let materials =
        "Materials { numMaterials 4 Material { reflectiveColor 1 1 1 } Material { transparentColor 0 1 0 }
         Checkerboard { materialIndex 0 materialIndex 1 } Checkerboard { materialIndex 0 materialIndex 0 } }";
    let opaque = [0, 3];
    let boxes = [0, 1, 0, 2, 3, 1, 3];
    let objects: Vec<String> = boxes
        .iter()
        .zip(0..)
        .map(|(material, x)| format!("MaterialIndex {material} Box {{ min {x} 0 0 max {x}.5 1 1 }}"))
        .chain(
            boxes
                .iter()
                .map(|material| format!("MaterialIndex {material} Sphere {{ center 99 9 9 radius 1 }}")),
        )
        .collect();
    let text = format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }} {materials}
         Group {{ numObjects {} {} }}",
        objects.len(),
        objects.concat()
    );
    let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
    assert_eq!(world.first_plane(), 12 * 7 + 7);
    for id in 0..world.first_plane() {
        let is_transparent = !opaque.contains(&world.material_of(id));
        assert_eq!(world.solids.are_dark_within(id), is_transparent, "{id}");
        assert!(!world.solids.stands_alone(id), "{id}");
    }
}

#[test]
fn a_sphere_stands_alone_unless_another_box_touches_its_own() {
    let mesh = prism(&SQUARE, false);
    let stands_alone = |others: &[&str]| {
        let sphere = glass("Sphere { center 0 0 0 radius 1 }");
        let world = world(&[], &[&[sphere.as_str()], others].concat(), &mesh);
        let id = (0..world.first_plane()).find(|&id| world.box_of(id).min == DVec3::NEG_ONE);
        world.solids.stands_alone(id.unwrap())
    };
    let plane = "Plane { normal 0 1 0 offset 0 }";
    assert!(stands_alone(&[plane, "Sphere { center 3 0 0 radius 1.5 }"]));
    assert!(!stands_alone(&["Sphere { center 2 0 0 radius 1 }"]));
    assert!(!stands_alone(&["Sphere { center 0 0 0 radius .5 }"]));
    assert!(!stands_alone(&["Triangle { vertex0 .9 .9 .9 vertex1 5 5 5 vertex2 5 5 6 }"]));
    assert!(!stands_alone(&["Transform { Scale 9 1 1 Sphere { center 0 0 0 radius .5 } }"]));
}

/// The number of primitives with nothing in them, for a first object of glass and others.
fn empty(first: &str, others: &[&str], mesh: &Mesh) -> usize {
    let world = world(&[SUN], &[&[glass(first).as_str()], others].concat(), mesh);
    (0..world.first_plane()).filter(|&id| world.solids.are_empty_within(id)).count()
}

#[test]
fn a_solid_is_empty_unless_another_box_or_a_plane_touches_its_own() {
    let square = prism(&SQUARE, false);
    let tall = "Transform { Scale 1 2 1 Sphere { center .5 .5 .5 radius .5 } }";
    let opaque = |object: &str| format!("Material {{ }} {object}");
    for (object, count) in [(MESH, 12), ("Sphere { center .5 .5 .5 radius .5 }", 1), (tall, 0)] {
        let with = |other: &str| empty(object, &[&opaque(other)], &square);
        assert_eq!(empty(object, &[], &square), count);
        assert_eq!(with("Sphere { center 5 5 5 radius 1 }"), count);
        assert_eq!(with("Sphere { center .5 .5 .5 radius .1 }"), 0);
        assert_eq!(with("Triangle { vertex0 .9 .9 .9 vertex1 5 5 5 vertex2 5 5 6 }"), 0);
        assert_eq!(with("Plane { normal 0 1 1 offset -.1 }"), count);
        assert_eq!(with("Plane { normal 0 -1 -1 offset 0 }"), 0);
        assert_eq!(with("Plane { normal 1 0 0 offset .5 }"), 0);
        assert_eq!(with("Plane { normal 1 0 0 offset 1 }"), 0);
        assert_eq!(with("Plane { normal 1 0 0 offset 1.1 }"), count);
    }
}

#[test]
fn a_solid_of_a_texture_or_with_two_surfaces_is_not_empty() {
    let square = prism(&SQUARE, false);
    let checkerboard = "Checkerboard { materialIndex 0 materialIndex 0 }";
    for (materials, count) in [(glass(""), 12), (format!("{GLASS} {checkerboard}"), 0)] {
        let last = if count > 0 { 0 } else { 1 };
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Materials {{ numMaterials {} {materials} }} Group {{ numObjects 1 MaterialIndex {last} {MESH} }}",
            last + 1
        );
        let world = World::new(&parse(&text).unwrap(), std::slice::from_ref(&square)).unwrap();
        assert_eq!((0..12).filter(|&id| world.solids.are_empty_within(id)).count(), count, "{materials}");
        assert!(world.solids.are_dark_within(0));
    }
    let mut double = square.clone();
    double.triangles.extend(square.triangles);
    assert_eq!((dark(&[SUN], MESH, &double), empty(MESH, &[], &double)), (24, 0));
}

#[test]
fn too_many_spheres_are_not_compared() {
    for (count, known) in [(200, 200), (300, MAX_COMPARISONS as u32 / 300)] {
        let spheres: Vec<String> =
            (0..count).map(|i| glass(&format!("Sphere {{ center {} 0 0 radius 1 }}", 3 * i))).collect();
        let spheres: Vec<&str> = spheres.iter().map(String::as_str).collect();
        let world = world(&[SUN], &spheres, &Mesh::default());
        assert!((0..count).all(|id| world.solids.stands_alone(id) == (id < known)), "{count}");
    }
}

#[test]
fn too_many_meshes_are_not_compared() {
    let cubes: Vec<String> =
        (0..100).map(|i| glass(&format!("Box {{ min {} 0 0 max {} 1 1 }}", 2 * i, 2 * i + 1))).collect();
    let cubes: Vec<&str> = cubes.iter().map(String::as_str).collect();
    let world = world(&[SUN], &cubes, &Mesh::default());
    let known = 12 * (MAX_COMPARISONS as u32 / 1200);
    assert!((0..1200).all(|id| world.solids.are_empty_within(id) == (id < known)));
}

/// Every ray from the inside of a solid to the outside is blocked, so nothing is lost where it is not cast.
#[test]
fn rays_from_inside_of_solids_are_blocked() {
    let fraction = |i: u32, step: f64| (f64::from(i) * step).fract();
    let mut cast = 0;
    for object in [
        "Sphere { center .3 -.2 7 radius 1 }",
        "Transform { XRotate 40 ZRotate 9 TriangleMesh { obj_file mesh.obj } }",
    ] {
        let world = world(&[SUN], &[&glass(object)], &prism(&ARROW, false));
        let caster = Caster::new(&world, Some([5, 4, 3])).unwrap();
        let middle = 0.5 * (world.bounds.min + world.bounds.max);
        for i in (1..80_000).step_by(2) {
            let point = |steps: [f64; 3]| DVec3::from(steps.map(|step| 2.0 * fraction(i, step) - 1.0));
            let target = middle + point([0.569, 0.819, 0.214]);
            let origin = 9.0 * point([0.618, 0.324, 0.754]);
            let ray = Ray::new(origin, (target - origin).normalize());
            let Some(hit) = caster.closest(&ray, &mut Quiet) else { continue };
            let surface = world.surface(&ray, &hit);
            let inwards = point([0.137, 0.273, 0.391]).normalize();
            let inwards = if inwards.dot(surface.normal) < 0.0 { inwards } else { -inwards };
            let origin = offset_origin(surface.position, surface.normal, inwards, world.max_abs_coord);
            let shadow = Ray::new(origin, inwards);
            assert!(world.solids.are_dark_within(hit.primitive));
            assert!(caster.any_from(&shadow, surface.primitive, &mut Quiet), "{shadow:?}");
            cast += 1;
        }
    }
    assert!(cast > 40_000, "{cast}");
}
