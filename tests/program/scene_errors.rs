//! Malformed scenes: each has an error at the right position.

use crate::support::unmark;
use raytracer::diagnostic::Diagnostic;
use raytracer::scene::Position;
use raytracer::scene::parser::parse;
use std::path::Path;

const CAMERA: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }";

/// Scenes, with `@` before the word of the error.
const WHOLE: &[&str] = &[
    "@",
    "Group { numObjects 0 }@",
    "@Grupe { numObjects 0 }",
    "Group { numObjects 0 } @}",
    "@Sphere { center 0 0 0 radius 1 }",
    "OrthographicCamera @center 0 0 0",
    "OrthographicCamera { center 0 0 @direction 0 0 1",
    "OrthographicCamera { center 0 0 0 direction @0 0 0 up 0 1 0",
    "OrthographicCamera { center 0 0 0 direction 0 0 1 up @0 0 0 size 1 }",
    "OrthographicCamera { center 0 0 0 direction 0 2 0 up @0 -1 0 size 1 }",
    "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size @0 }",
    "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 @angle 1 }",
    "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size 1@",
    "PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @0 }",
    "PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @180 }",
    "PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @wide }",
    "PerspectiveCamera { center @1e999 0 0",
    "PerspectiveCamera { center @nan 0 0",
];

/// The same after a valid camera.
const WITH_CAMERA: &[&str] = &[
    "Background { color 0 0 0 }@",
    "Background { @colour 0 0 0 }",
    "Background { color 0 0 @}",
    "Background {@",
    "Lights { @PointLight {",
    "Lights { numLights @-1 }",
    "Lights { numLights 4000000000 @}",
    "Lights { numLights 0 PointLight {@",
    "Lights { numLights 1 @SpotLight {",
    "Lights { numLights 1 DirectionalLight { direction @0 0 0 color 1 1 1 } }",
    "Lights { numLights 1 PointLight { @direction 0 1 0 } }",
    "Lights { numLights 1 PointLight { position 0 0 0 color 1 1 1 attenuation 1 0 @} }",
    "Lights { numLights 1 PointLight { position 0 0 0 color 1 1 1 @atenuation 1 0 0 } }",
    "Background { color @0 2e30 0 }",
    "Materials { numMaterials 1 Material { diffuseColor @2e30 0 0 } }",
    "Materials { numMaterials 1 Material { } @Noise { materialIndex 0 materialIndex 0 octaves 1 } }",
    "Materials { numMaterials 1 Material { @shiny 1 } }",
    "Materials { numMaterials 1 PhongMaterial { exponent @-1 } }",
    "Materials { numMaterials 1 Material { indexOfRefraction @0 } }",
    "Materials { numMaterials 1 Noise { materialIndex @0 } }",
    "Materials { numMaterials 2 Material { } Wood { materialIndex 0 materialIndex @1 } }",
    "Materials { numMaterials 2 Material { } Wood { @MaterialIndex 0 } }",
    "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 octaves @65 } }",
    "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 @} }",
    "Materials { numMaterials 2 Material { } Marble { materialIndex 0 materialIndex 0 octaves 1 @amplitude 1 } }",
    "Materials { numMaterials 2 Material { } Checkerboard { materialIndex 0 materialIndex 0 size @0 } }",
    "Materials { numMaterials 2 Material { } Checkerboard { materialIndex 0 materialIndex 0 size @1e-320 } }",
    "Materials { numMaterials 2 Material { } Checkerboard { Transform { @Turn 1 } } }",
    "Group { numObjects 0 } @Materials { numMaterials 0 }",
    "Group { @Sphere { } }",
    "Group { numObjects 1 @}",
    "Group { numObjects @99999999999999999999999 }",
    "Group { numObjects 1 Group { numObjects 0 } @Group { numObjects 0 } }",
    "Materials { numMaterials 1 Material { } } Group { numObjects 0 @MaterialIndex 0 }",
    "Group { numObjects 0 @Material { } }",
    "Group { numObjects 1 MaterialIndex @0 }",
    "Group { numObjects 1 @Sphere { center 0 0 0 radius 1 } }",
    "Group { numObjects 1 Transform { @Box { } } }",
    "Group { numObjects 1 Material { } MaterialIndex @0 }",
    "Group { numObjects 1@",
];

/// The same in place of the only object of a scene with the materials 0 and 1, of which the first is current.
const OBJECTS: &[&str] = &[
    "MaterialIndex @2 ",
    "@Sphre { center 0 0 0 radius 1 }",
    "Grid { min 0 0 0 max 1 @0 1 }",
    "Grid { min 0 0 0 max 1 1 1 numCells 5 @257 5 }",
    "Grid { min 0 0 0 max 1 1 1 numCells 5 @0 5 }",
    "Grid { min 0 0 0 max 1 1 1 numCells 5 5 5 @}",
    "Sphere @center 0 0 0 radius 1 }",
    "Sphere { center 0 0 0 radius @} }",
    "Sphere { center 0 0 0 radius @-1 }",
    "Sphere { center 0 0 0 radius @1# one }",
    "Plane { normal @0 0 0 offset 1 }",
    "Triangle { vertex0 0 0 0 @vertex2 1 1 1",
    "Box { min 0 0 0 max 1 @-1 1 }",
    "TriangleMesh { obj_file @a.ply }",
    "TriangleMesh { obj_file @\"a.obj\" }",
    "TriangleMesh { obj_file @} }",
    "TriangleMesh { obj_file a.obj @b.obj }",
    "Transform { Scale 1 1 1 @} }",
    "Transform { @MaterialIndex 0 Sphere",
    "Transform { Group { numObjects 0 } @Group { numObjects 0 } }",
    "Transform { Scale 1 1 @Translate 1 1 1",
    "Transform { Translate { 1 1 1 @Scale",
    "Transform { Translate { 1 1 @} Scale",
    "Transform { Rotate @1 0 0 90",
    "Transform { Rotate { @0 0 0 90 }",
    "Transform { Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 @1 0 1 }",
    "Transform { Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 @1 }",
    "Sphere { center 0 0 0 radius @1e-101 }",
    "Transform { Scale 1e99 1 1 Scale 1e99 1 1 Scale 1e99 1 1 @Scale 1e99 1 1 Sphere",
];

fn refuse(text: &str) -> Diagnostic {
    parse(text).map(|_| ()).expect_err(text)
}

/// Checks the place of the error.
fn check(marked: &str) {
    let (text, line, column) = unmark(marked);
    let at = Position { line: line as u32, column: column as u32 };
    let error = refuse(&text);
    assert_eq!(error.position(), Some(at), "place of: {error}\n{text}");
    let rendered = error.in_text(Path::new("scene.txt"), &text).to_string();
    assert!(rendered.starts_with(&format!("scene.txt:{}:{}: error: ", at.line, at.column)), "{rendered}");
}

#[test]
fn malformed_blocks_are_refused_where_they_are_wrong() {
    for marked in WHOLE {
        check(marked);
    }
    for marked in WITH_CAMERA {
        check(&format!("{CAMERA}\n{marked}"));
        check(&format!("{CAMERA} // comment\r\n\t{marked}"));
    }
}

#[test]
fn malformed_objects_are_refused_where_they_are_wrong() {
    for marked in OBJECTS {
        let around =
            format!("{CAMERA}\nMaterials {{ numMaterials 2 Material {{ }} Material {{ }} }}\nGroup {{");
        check(&format!("{around} numObjects 1 MaterialIndex 0\n  {marked} }}"));
        check(&format!("{around} numObjects 1 Group {{ numObjects 1 MaterialIndex 0\n {marked} }} }}"));
    }
}

#[test]
fn hints_name_what_was_meant() {
    for (text, hint) in [
        ("Grupe", "did you mean `Group`?"),
        ("}", "this brace closes nothing"),
        ("Sphere { }", "objects and their materials go inside a `Group`"),
        ("Materials { numMaterials 1 Material { difuse_color 1 1 1 } }", "did you mean `diffuseColor`?"),
        ("Group { numobjects 1 }", "did you mean `numObjects`?"),
        ("Group { numObjects 1 Transform { Translat 1 1 1 } }", "did you mean `Translate`?"),
        (
            "Group { numObjects 1 Transform { MaterialIndex 0 } }",
            "choose the material before the `Transform`",
        ),
        ("Group { numObjects 1 Sphere { } }", "put a `MaterialIndex` before it"),
        ("PerspectiveCamera { center 1 2 direction", "`center` takes three numbers"),
    ] {
        assert_eq!(refuse(text).hint.as_deref(), Some(hint), "{text}");
    }
}
