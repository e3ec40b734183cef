//! Tests of the parser.

use super::*;
use crate::base::patience::Endless;
use crate::base::patience::tests::Counted;
use crate::scene::material::{Material, Phong};
use crate::scene::{MeshFile, Object, Position};
use glam::DVec3;

const CAMERA: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }";

fn objects(group: &str) -> Scene {
    let materials = "Materials { numMaterials 2 Material { } Material { } }";
    parse(&format!("{CAMERA} {materials} {group}")).unwrap()
}

#[test]
fn every_object_has_the_position_of_its_keyword() {
    let group = "Group { numObjects 2 MaterialIndex 1 Sphere { center 0 0 0 radius 1 }
            Transform { Scale 1 1 1 Group { numObjects 1 Box { min 0 0 0 max 1 1 0 } } } }";
    // The later group replaces the earlier one.
    let scene = objects(&format!("{group}\n\n{group}"));
    let at = |line, column| Position { line, column };
    // Sphere, box, inner group, transform, outer group: each comes after its children.
    assert_eq!(scene.positions.objects, [at(4, 38), at(5, 58), at(5, 37), at(5, 13), at(4, 1)]);
}

#[test]
fn a_material_outlasts_its_group() {
    let scene = objects(
        "Group { numObjects 2 Group { numObjects 1 MaterialIndex 1 Plane { normal 0 1 0 offset 0 } }
         Plane { normal 0 1 0 offset 0 } }",
    );
    assert_eq!(scene.objects[2], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 1 });
}

#[test]
fn materials_inside_groups_follow_the_declared_ones() {
    let scene = objects(
        "Group { num_objects 2 Material { diffuse_color 1 0 0 } Plane { normal 0 1 0 offset 0 }
         Material { diffuseColor 0 1 0 } Material { diffuseColor 0 0 1 } Plane { normal 0 1 0 offset 0 } }",
    );
    let material = |diffuse| Material::Phong(Phong { diffuse, ..Phong::default() });
    assert_eq!(scene.materials[2..], [material(DVec3::X), material(DVec3::Y), material(DVec3::Z)]);
    assert_eq!(scene.positions.materials.len(), scene.materials.len());
    assert_eq!(scene.objects[0], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 2 });
    assert_eq!(scene.objects[1], Object::Plane { normal: DVec3::Y, offset: 0.0, material: 4 });
}

#[test]
fn each_mesh_is_named_once() {
    let mesh = |name: &str| format!("TriangleMesh {{ obj_file {name}.obj }}");
    let scene = objects(&format!(
        "Group {{ numObjects 3 MaterialIndex 0\n{} {} {} }}",
        mesh("a"),
        mesh("b"),
        mesh("a")
    ));
    let at = |column| Position { line: 2, column };
    let named = |name: &str, column| MeshFile { name: name.into(), at: at(column), ..MeshFile::default() };
    assert_eq!(scene.meshes, [named("a.obj", 25), named("b.obj", 57)]);
    assert_eq!(scene.objects[2], Object::Mesh { mesh: 0, material: 0 });
}

#[test]
fn later_blocks_replace_earlier_ones() {
    let scene = parse(&format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 1 up 0 1 0 size 1 }} {CAMERA}
         Materials {{ numMaterials 1 Material {{ }} }} Materials {{ numMaterials 0 }}
         Group {{ numObjects 1 Material {{ }} TriangleMesh {{ obj_file a.obj }} }} Group {{ numObjects 0 }}"
    ))
    .unwrap();
    assert!(matches!(scene.camera, Camera::Perspective { .. }));
    assert_eq!((scene.objects, scene.meshes), (vec![Object::Group(vec![])], vec![]));
}

fn grids(cells: &[[usize; 3]]) -> String {
    let grid = |[x, y, z]: &[usize; 3]| {
        format!(
            "Grid {{ min 0 0 0 max 1 1 1 numCells {x} {y} {z}
             rasterizeSphere {{ center 0 0 0 radius 1e-9 }} }}\n"
        )
    };
    let grids: String = cells.iter().map(grid).collect();
    format!(
        "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
Group {{ numObjects {} Material {{ }}\n{grids}}}",
        cells.len()
    )
}

#[test]
fn the_cells_of_all_grids_are_counted_before_any_are_made() {
    assert!(parse(&grids(&[[255, 256, 256], [1, 255, 256], [1, 1, 256]])).is_ok());
    let patience = Counted::up_to(usize::MAX);
    let text = grids(&[[255, 256, 256], [1, 256, 256], [1, 1, 1], [2, 2, 2]]);
    let error = read_words(Edition::Y2004, &text, &patience).unwrap_err();
    assert_eq!(error.position().map(|at| at.line), Some(7));
    assert_eq!(
        (error.message.as_str(), patience.asked()),
        ("up to here, the grids of the scene have 16777217 cells", 0)
    );
}

#[test]
fn the_steps_of_reading_grow_with_the_text() {
    let nested = |count: usize| {
        let groups = "Group { numObjects 1 ".repeat(count);
        format!(
            "Group {{ numObjects 1 Material {{ }} {groups} Sphere {{ center 0 0 0 radius 1 }} {} }}",
            "}".repeat(count)
        )
    };
    let many = |count: usize| {
        let spheres = "Sphere { center 0 0 0 radius 1 } ".repeat(count);
        format!("Group {{ numObjects {count} Material {{ }} {spheres} }}")
    };
    let warnings = |count: usize| {
        let one = "Background { color 0 0 0 } ";
        format!("{} Group {{ numObjects 0 }}", one.repeat(count))
    };
    let transforms = |count: usize| {
        let factors = "ZRotate 30 Scale 1 1 1 Translate 0 0 0 ".repeat(count);
        format!(
            "Group {{ numObjects 1 Material {{ }} Transform {{ {factors} Sphere {{ center 0 0 0 radius 1 }} }} }}"
        )
    };
    for scene in [nested as fn(usize) -> String, many, warnings, transforms] {
        let questions = |count: usize| {
            let camera = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }";
            let patience = Counted::up_to(usize::MAX);
            read_words(Edition::Y2004, &format!("{camera} {}", scene(count)), &patience).unwrap();
            patience.asked()
        };
        let [few, more] = [10_000, 40_000].map(questions);
        assert!(few > 10 && (4 * few).abs_diff(more) < 10, "{few} {more}");
    }
}

#[test]
fn the_steps_of_grids_grow_with_their_cells() {
    let questions = |cells: &[[usize; 3]]| {
        let patience = Counted::up_to(usize::MAX);
        read_words(Edition::Y2004, &grids(cells), &Endless).unwrap().finish(&patience).unwrap();
        patience.asked()
    };
    let [one, long, four] = [&[[64; 3]][..], &[[256, 64, 64]], &[[64; 3]; 4]].map(questions);
    assert!(one >= 64, "{one}");
    assert_eq!([long, four], [4 * one; 2]);
}

#[test]
fn long_words_are_read_in_few_steps() {
    let camera = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }";
    let long = "1".repeat(1 << 20);
    let group = |object: &str| format!("{camera} Group {{ numObjects 1 Material {{ }} {object} }}");
    for text in [
        group(&format!("#{long}\nSphere {{ center 0 0 0 radius 0.{long} }}")),
        format!("{camera} x{long}"),
        group(&format!("x{long} {{ }}")),
        group(&format!("Sphere {{ center 0 0 0 radius {long}x }}")),
    ] {
        let patience = Counted::up_to(usize::MAX);
        // The message shows the beginning of the word only.
        if let Err(error) = read_words(Edition::Y2004, &text, &patience) {
            assert!(error.message.len() < 1000, "{}", error.message.len());
        }
        assert!(patience.asked() < 2, "{}", patience.asked());
    }
}

#[test]
fn reading_ends_at_any_question() {
    let spheres = "Sphere { center 0 0 0 radius 1 } ".repeat(2000);
    let text = grids(&[[16, 16, 16]])
        .replace("numObjects 1 Material { }", &format!("numObjects 2001 Material {{ }} {spheres}"));
    let mut read = (0..).map(|most| {
        let patience = Counted::up_to(most);
        read_words(Edition::Y2004, &text, &patience).and_then(|unfinished| unfinished.finish(&patience))
    });
    assert!(read.by_ref().take_while(Result::is_err).count() > 3);
}
