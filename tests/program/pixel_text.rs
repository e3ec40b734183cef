//! What `-pixel` prints.

use crate::pixel_scenes::{GLASS, MESH, OBJ};
use crate::support::Folder;

/// What the program prints for a pixel.
fn said(text: &str, flags: &str) -> String {
    let folder = Folder::with_scene(text);
    folder.write("m.obj", OBJ);
    folder.run(&format!("-input s.txt {flags}")).ok().stdout
}

/// Demands that what the program prints for a pixel has a line that starts with each of these, in this order.
fn assert_says(text: &str, flags: &str, expected: &[&str]) {
    let said = said(text, flags);
    let mut lines = said.lines().map(str::trim_start);
    for start in expected {
        assert!(lines.any(|line| line.starts_with(start)), "{flags} lacks, in its place, {start}: {said}");
    }
}

#[test]
fn objects_are_named_with_the_line_in_which_they_stand() {
    for (text, pixel, words, name) in [
        (GLASS, "16 8", "Sphere { center 0 0 0 radius .5", "Sphere"),
        (GLASS, "14 10", "Plane", "Plane"),
        (GLASS, "5 10", "Box", "triangle 11 of Box"),
        (MESH, "7 10", "TriangleMesh", "triangle 3 of TriangleMesh m.obj"),
        (MESH, "14 10", "Triangle {", "Triangle"),
    ] {
        let line = 1 + text.lines().position(|line| line.contains(words)).expect("a line");
        let expected = format!("sees {name} in line {line} at t ");
        for grid in ["", "-grid 3 4 5", "-grid auto"] {
            assert_says(text, &format!("-size 20 20 -pixel {pixel} {grid}"), &["camera ray", &expected]);
        }
    }
    let expected = ["camera ray", "sees nothing", "own colour (0.2, 0.3, 0.6)"];
    assert_says(GLASS, "-size 20 20 -pixel 10 3", &expected);
}

#[test]
fn every_branch_says_why_it_ends() {
    let flags = |rest: &str| format!("-size 24 17 -pixel 11 8 -bounces {rest}");
    let ends = ["no reflected ray: no bounces left", "no refracted ray: no bounces left"];
    assert_says(GLASS, &flags("0"), &ends);
    let ends =
        ["no reflected ray: weight 0.519615242 is too little", "refracted ray, bounce 1, weight 1.27279221"];
    assert_says(GLASS, &flags("2 -weight .6"), &ends);
    let tree =
        ["reflected ray, bounce 1", "sees nothing", "refracted ray, bounce 1", "refracted ray, bounce 2"];
    let ends = ["no reflected ray: no reflective colour", "no refracted ray: no transparent colour"];
    assert_says(GLASS, &flags("2"), &[tree.as_slice(), &ends].concat());
    // From air into glass at 45 degrees and then on its side at 62, where no light leaves it.
    let inside = "OrthographicCamera { center -.7 1.5 0 direction 1 -1 0 up 0 0 1 size .1 }
        Group { numObjects 1 Material { transparentColor 1 1 1 indexOfRefraction 1.5 }
          Box { min -.5 -.5 -.5 max .5 .5 .5 } }";
    assert_says(
        inside,
        "-size 1 1 -pixel 0 0 -bounces 2",
        &["refracted ray, bounce 1", "seen from behind", "no refracted ray: total internal reflection"],
    );
}

#[test]
fn a_shadow_ray_names_what_blocks_or_tints_it() {
    let scene = "OrthographicCamera { center 0 1 5 direction 0 -1 -5 up 0 1 0 size 1 }
        Lights { numLights 2 DirectionalLight { direction 0 -1 0 color 1 1 1 }
          DirectionalLight { direction 0 1 0 color 1 1 1 } }
        Group { numObjects 2 Material { transparentColor .5 .5 .5 }
          Sphere { center 0 3 0 radius 1 }
          Plane { normal 0 1 0 offset 0 } }";
    let flags = |shadows: &str| format!("-size 1 1 -pixel 0 0 {shadows}");
    let blocked = [
        "light 0: diffuse (0, 0, 0)",
        "shadow ray blocked by Sphere in line 5 at t 2",
        "intersection tests 2",
    ];
    assert_says(
        scene,
        &flags("-shadows"),
        &[blocked.as_slice(), &["light 1 is behind the surface"]].concat(),
    );
    let tinted = [
        "light 0: diffuse (0.25, 0.25, 0.25)",
        "shadow ray enters Sphere in line 5 at t 2",
        "shadow ray leaves Sphere in line 5 after t 2, tinted (0.5, 0.5, 0.5) per unit",
    ];
    assert_says(scene, &flags("-transparent_shadows"), &tinted);
    let opaque = scene.replace("transparentColor .5 .5 .5", "");
    assert_says(&opaque, &flags("-transparent_shadows"), &blocked);
    assert_says(scene, &flags(""), &["light 0: diffuse (1, 1, 1), specular (0, 0, 0), cosine 1"]);
    assert!(!said(scene, &flags("")).contains("shadow ray"));
}

const CLOSE: &str = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 3 }
    Lights { numLights 1 LIGHT }
    Materials { numMaterials 3 Material { diffuseColor .25 .43 .3 } Material { diffuseColor 0 0 1 }
      Checkerboard { materialIndex 0 materialIndex 1 } }
    Group { numObjects 2 MaterialIndex 0
      OBJECTS }";

#[test]
fn decisions_that_roundings_could_turn_are_pointed_out() {
    let front = "DirectionalLight { direction 0 0 -1 color 1 1 1 }";
    let level = "PointLight { position 9 0 0 color 1 1 1 }";
    let near = "PointLight { position 3 0 4 color 1 1 1 }";
    let halves = "Triangle { vertex0 -2 -2 0 vertex1 2 2 0 vertex2 -2 2 0 }
        Triangle { vertex0 -2 -2 0 vertex1 2 -2 0 vertex2 2 2 0 }";
    let twice = "Plane { normal 0 0 1 offset 0.25 }
        Triangle { vertex0 -4 -4 .25 vertex1 4 -4 .25 vertex2 0 8 .25 }";
    let lamp = "Plane { normal 0 0 1 offset 0 } Sphere { center 6 0 8 radius 5 }";
    let spheres = "Sphere { center 0 0 0 radius 1 }
        Transform { Scale .5 1 1 Sphere { center 0 0 2 radius 1 } }";
    let along = "Plane { normal 1 0 0 offset 1 } Plane { normal 0 0 1 offset 0 }";
    let board = "MaterialIndex 2 Plane { normal 0 0 1 offset .5 } Sphere { center 9 9 9 radius 1 }";
    for (light, objects, pixel, call) in [
        (front, halves, "1 1", Some("the ray passes through an edge: Triangle in line 6")),
        (front, halves, "2 1", None),
        (level, halves, "2 1", Some("cosine between normal and direction is 0")),
        (front, twice, "1 1", Some("something else is as near: Triangle in line 7")),
        (front, twice, "2 2", Some("the ray starts in a surface: Triangle in line 7")),
        (front, spheres, "0 1", Some("the ray is tangent: Sphere in line 6")),
        (front, spheres, "1 0", Some("the ray is tangent: Sphere in line 7")),
        (front, spheres, "1 1", None),
        (front, along, "2 1", Some("the ray lies in a plane: Plane in line 6")),
        (front, along, "1 1", None),
        (front, board, "1 1", Some("in a boundary of the checkerboard")),
        (near, lamp, "1 1", Some("the ray ends in a surface: Sphere in line 6")),
    ] {
        let scene = CLOSE.replace("LIGHT", light).replace("OBJECTS", objects);
        let said = said(&scene, &format!("-size 3 3 -shadows -pixel {pixel}"));
        match call {
            None => assert!(!said.contains("close call"), "{objects} {pixel}: {said}"),
            Some(call) => {
                let mut lines = said.lines().filter(|line| line.trim_start().starts_with("close call: "));
                assert!(lines.any(|line| line.contains(call)), "{objects} {pixel} lacks {call}: {said}");
            }
        }
    }
}

#[test]
fn a_byte_that_roundings_could_turn_is_pointed_out() {
    let scene = |red: &str| {
        format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
             Background {{ color {red} .3 0 }} Group {{ numObjects 0 }}"
        )
    };
    let lines = |red| said(&scene(red), "-size 1 1 -pixel 0 0");
    // 51 / 255 is 0.2; one level is about 0.004.
    assert_eq!(lines(".2").matches("close call").count(), 1);
    assert!(lines(".2").contains("close call                 255 times red"));
    assert!(!lines(".2001").contains("close call") && !lines("0").contains("close call"));
}
