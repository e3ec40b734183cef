//! Malformed scenes: each has an error at the right position and with the right message.

use crate::support::unmark;
use raytracer::diagnostic::Diagnostic;
use raytracer::scene::Position;
use raytracer::scene::parser::parse;
use std::path::Path;

const CAMERA: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }";

/// Scenes, with `@` before the word of the error, and a part of the message.
const WHOLE: &[(&str, &str)] = &[
    ("@", "the scene has no camera"),
    ("Group { numObjects 0 }@", "the scene has no camera"),
    ("Group { numObjects 0 }@ \n# the end\n\n", "the scene has no camera"),
    (
        "@Grupe { numObjects 0 }",
        "expected a camera, `Background`, `Lights`, `Materials` or `Group`, found `Grupe`",
    ),
    ("@}", "expected a camera"),
    ("Group { numObjects 0 } @}", "expected a camera"),
    ("@Sphere { center 0 0 0 radius 1 }", "expected a camera"),
    ("OrthographicCamera @center 0 0 0", "expected `{` after `OrthographicCamera`, found `center`"),
    ("OrthographicCamera { @direction 0 0 1", "expected `center`, found `direction`"),
    ("OrthographicCamera { center 0 0 @direction 0 0 1", "expected a number for `center`, found `direction`"),
    (
        "OrthographicCamera { center 0 0 0 direction @0 0 0 up 0 1 0",
        "`direction` must not be the zero vector",
    ),
    (
        "OrthographicCamera { center 0 0 0 direction 0 0 1 up @0 0 0 size 1 }",
        "`up` must not be the zero vector",
    ),
    ("OrthographicCamera { center 0 0 0 direction 0 2 0 up @0 -1 0 size 1 }", "`up` must not be parallel"),
    (
        "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size @0 }",
        "`size` must be positive, found `0`",
    ),
    (
        "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 @angle 1 }",
        "expected `size`, found `angle`",
    ),
    (
        "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size 1 @2 }",
        "expected `}` at the end of `Ortho",
    ),
    ("OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size 1@", "found the end of the file"),
    ("PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @0 }", "must be above 0 and below 180"),
    (
        "PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @180 }",
        "must be above 0 and below 180",
    ),
    (
        "PerspectiveCamera { center 0 0 0 direction 0 0 1 up 0 1 0 angle @wide }",
        "expected a number for `angle`",
    ),
    ("PerspectiveCamera { center @1e999 0 0", "the number `1e999` is too large: the largest is 1e100"),
    ("PerspectiveCamera { center @nan 0 0", "expected a number for `center`, found `nan`"),
    ("PerspectiveCamera { center @-inf 0 0", "expected a number for `center`, found `-inf`"),
    ("PerspectiveCamera { center 1 @0x10 0", "expected a number for `center`, found `0x10`"),
];

/// The same after a valid camera.
const WITH_CAMERA: &[(&str, &str)] = &[
    ("Background { color 0 0 0 }@", "the scene has no group"),
    ("Background { @colour 0 0 0 }", "expected `color`, `ambientLight` or `}`, found `colour`"),
    ("Background { color 0 0 @}", "expected a number for `color`, found `}`"),
    ("Background { color 0 0 0 @0 }", "expected `color`, `ambientLight` or `}`, found `0`"),
    ("Background {@", "found the end of the file"),
    ("Lights { @PointLight {", "expected `numLights`, found `PointLight`"),
    ("Lights { numLights @}", "expected a whole number for `numLights`, found `}`"),
    ("Lights { numLights @-1 }", "`numLights` must not be negative, found `-1`"),
    ("Lights { numLights @1.5 }", "`numLights` must be a whole number, found `1.5`"),
    ("Lights { numLights 1 @}", "`numLights` announces 1, but only 0 found"),
    ("Lights { numLights 4000000000 @}", "`numLights` announces 4000000000, but only 0 found"),
    ("Lights { numLights 0 PointLight {@", "expected `position`, found the end of the file"),
    ("Lights { numLights 0 @SpotLight {", "expected `}` at the end of `Lights`, found `SpotLight`"),
    ("Lights { numLights 1 @SpotLight {", "expected a light, found `SpotLight`"),
    (
        "Lights { numLights 1 DirectionalLight { direction @0 0 0 color 1 1 1 } }",
        "`direction` must not be the zero",
    ),
    ("Lights { numLights 1 DirectionalLight { direction 0 1 0 @} }", "expected `color`, found `}`"),
    ("Lights { numLights 1 PointLight { @direction 0 1 0 } }", "expected `position`, found `direction`"),
    (
        "Lights { numLights 1 PointLight { position 0 0 0 color 1 1 1 attenuation 1 0 @} }",
        "expected a number for `att",
    ),
    (
        "Lights { numLights 1 PointLight { position 0 0 0 color 1 1 1 @atenuation 1 0 0 } }",
        "expected `attenuation` or `}`",
    ),
    ("Background { color @0 2e30 0 }", "`color` must be at most 1e30 in each channel, found `0`"),
    (
        "Materials { numMaterials 1 Material { diffuseColor @2e30 0 0 } }",
        "`diffuseColor` must be at most 1e30",
    ),
    ("Materials { numMaterials 2 Material { } @}", "`numMaterials` announces 2, but only 1 found"),
    (
        "Materials { numMaterials 1 Material { } @Noise { materialIndex 0 materialIndex 0 octaves 1 } }",
        "`numMaterials` announces 1, but 2 found",
    ),
    ("Materials { numMaterials 1 @Metal { } }", "expected a material, found `Metal`"),
    (
        "Materials { numMaterials 1 Material { @shiny 1 } }",
        "expected a field of `Material` or `}`, found `shiny`",
    ),
    (
        "Materials { numMaterials 1 PhongMaterial { exponent @-1 } }",
        "`exponent` must not be negative, found `-1`",
    ),
    (
        "Materials { numMaterials 1 Material { indexOfRefraction @0 } }",
        "`indexOfRefraction` must be positive",
    ),
    (
        "Materials { numMaterials 1 Noise { materialIndex @0 } }",
        "texture 0 may mix only materials before it, found index 0",
    ),
    ("Materials { numMaterials 2 Material { } Wood { materialIndex 0 materialIndex @1 } }", "found index 1"),
    ("Materials { numMaterials 2 Material { } Wood { materialIndex @-1 } }", "must not be negative"),
    (
        "Materials { numMaterials 2 Material { } Wood { @MaterialIndex 0 } }",
        "expected `materialIndex`, found `Mat",
    ),
    (
        "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 octaves @65 } }",
        "at most 64",
    ),
    (
        "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 octaves @2.5 } }",
        "whole number",
    ),
    (
        "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 octaves @-2 } }",
        "negative",
    ),
    (
        "Materials { numMaterials 2 Material { } Noise { materialIndex 0 materialIndex 0 @} }",
        "expected `octaves`",
    ),
    (
        "Materials { numMaterials 2 Material { } Marble { materialIndex 0 materialIndex 0 octaves 1 @amplitude 1 } }",
        "expected `frequency`",
    ),
    (
        "Materials { numMaterials 2 Material { } Checkerboard { materialIndex 0 materialIndex 0 size @0 } }",
        "`size` must be positive",
    ),
    (
        "Materials { numMaterials 2 Material { } Checkerboard { materialIndex 0 materialIndex 0 size @1e-320 } }",
        "`size` must be positive",
    ),
    (
        "Materials { numMaterials 2 Material { } Checkerboard { Transform { @Turn 1 } } }",
        "expected a transformation or `}`",
    ),
    ("Group { numObjects 0 } @Materials { numMaterials 0 }", "`Materials` must come before the `Group`"),
    ("Group { @Sphere { } }", "expected `numObjects`, found `Sphere`"),
    ("Group { numObjects @many }", "expected a whole number for `numObjects`, found `many`"),
    ("Group { numObjects 1 @}", "`numObjects` announces 1, but only 0 found"),
    (
        "Group { numObjects @99999999999999999999999 }",
        "`numObjects` must be below 2^64, found `99999999999999999999999`",
    ),
    (
        "Group { numObjects 1 Group { numObjects 0 } @Group { numObjects 0 } }",
        "`numObjects` announces 1, but 2 found",
    ),
    ("Group { numObjects 1 Material { } @}", "`numObjects` announces 1, but only 0 found"),
    (
        "Materials { numMaterials 1 Material { } } Group { numObjects 0 @MaterialIndex 0 }",
        "`MaterialIndex` must come before an object",
    ),
    ("Group { numObjects 0 @Material { } }", "`Material` must come before an object"),
    ("Group { numObjects 1 MaterialIndex @0 }", "there is no material 0: none is declared"),
    ("Group { numObjects 1 @Sphere { center 0 0 0 radius 1 } }", "the `Sphere` has no material"),
    ("Group { numObjects 1 Transform { @Box { } } }", "the `Box` has no material"),
    ("Group { numObjects 1 Material { } MaterialIndex @0 }", "there is no material 0"),
    ("Group {@", "expected `numObjects`, found the end of the file"),
    ("Group { numObjects 1@", "expected an object, found the end of the file"),
    ("Group { numObjects 0@", "expected `}` at the end of `Group`, found the end of the file"),
];

/// The same in place of the only object of a scene with the materials 0 and 1, of which the first is current.
const OBJECTS: &[(&str, &str)] = &[
    ("MaterialIndex @2 ", "there is no material 2: materials 0 to 1 are declared"),
    ("MaterialIndex @4000000000 ", "there is no material 4000000000"),
    ("@Sphre { center 0 0 0 radius 1 }", "expected an object, found `Sphre`"),
    ("Grid { min 0 0 0 max 1 @0 1 }", "`max` must be above `min`, found `0`"),
    ("Grid { min 0 0 0 max 1 1 1 numCells 5 @257 5 }", "`numCells` must be from 1 to 256, found `257`"),
    ("Grid { min 0 0 0 max 1 1 1 numCells 5 @0 5 }", "`numCells` must be from 1 to 256, found `0`"),
    ("Grid { min 0 0 0 max 1 1 1 numCells 5 5 @.5 }", "`numCells` must be a whole number, found `.5`"),
    ("Grid { min 0 0 0 max 1 1 1 numCells 5 5 5 @}", "expected `rasterizeSphere`, found `}`"),
    ("Sphere @center 0 0 0 radius 1 }", "expected `{` after `Sphere`"),
    ("Sphere { @radius 1 center 0 0 0 }", "expected `center`, found `radius`"),
    ("Sphere { center 0 0 0 radius @} }", "expected a number for `radius`, found `}`"),
    ("Sphere { center 0 0 0 radius @-1 }", "`radius` must be positive, and at least 1e-100, found `-1`"),
    ("Sphere { center 0 0 0 radius @0 }", "`radius` must be positive, and at least 1e-100, found `0`"),
    ("Sphere { center 0 0 0 radius @1# one }", "expected a number for `radius`, found `1#`"),
    ("Sphere { center 0 0 0 radius 1 @radius 2 }", "expected `}` at the end of `Sphere`, found `radius`"),
    ("Plane { normal @0 0 0 offset 1 }", "`normal` must not be the zero vector"),
    ("Plane { normal 0 1 0 @distance 1 }", "expected `offset`, found `distance`"),
    ("Triangle { vertex0 0 0 0 @vertex2 1 1 1", "expected `vertex1`, found `vertex2`"),
    ("Triangle { vertex0 0 0 0 vertex1 @, 1 1", "expected a number for `vertex1`, found `,`"),
    ("Box { min 0 0 0 max 1 @-1 1 }", "`max` must not be below `min`, found `-1`"),
    ("TriangleMesh { @file a.obj }", "expected `obj_file`, found `file`"),
    ("TriangleMesh { obj_file @a.ply }", "`obj_file` must end in `.obj`, found `a.ply`"),
    ("TriangleMesh { obj_file @\"a.obj\" }", "`obj_file` must be a name without quotes, found `\"a.obj\"`"),
    ("TriangleMesh { obj_file @'my cube.obj' }", "`obj_file` must be a name without quotes, found `'my`"),
    ("TriangleMesh { obj_file @} }", "expected a file name for `obj_file`, found `}`"),
    ("TriangleMesh { obj_file a.obj @b.obj }", "expected `}` at the end of `TriangleMesh`"),
    ("Transform { Scale 1 1 1 @} }", "expected a transformation or an object, found `}`"),
    ("Transform { @MaterialIndex 0 Sphere", "expected a transformation or an object, found `MaterialIndex`"),
    (
        "Transform { Group { numObjects 0 } @Group { numObjects 0 } }",
        "expected `}` at the end of `Transform`",
    ),
    ("Transform { Group { numObjects 0 } @Scale 1 1 1 }", "expected `}` at the end of `Transform`"),
    ("Transform { Scale 1 1 @Translate 1 1 1", "expected a number for `Scale`, found `Translate`"),
    ("Transform { Translate { 1 1 1 @Scale", "expected `}` at the end of `Translate`, found `Scale`"),
    ("Transform { Translate { 1 1 @} Scale", "expected a number for `Translate`, found `}`"),
    ("Transform { XRotate @x", "expected a number for `XRotate`, found `x`"),
    ("Transform { Rotate @1 0 0 90", "expected `{` after `Rotate`, found `1`"),
    ("Transform { Rotate { @0 0 0 90 }", "`Rotate` must not be the zero vector"),
    ("Transform { Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 @1 0 1 }", "the last row of a `Matrix` must be 0 0 0 1"),
    ("Transform { Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 @}", "expected a number for `Matrix`, found `}`"),
    ("Transform { Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 @1 }", "expected `}` at the end of `Matrix`"),
    ("Sphere { center 0 0 0 radius @1e-101 }", "`radius` must be positive, and at least 1e-100"),
    ("Sphere { center 0 @-1.1e100 0 radius 1 }", "the number `-1.1e100` is too large"),
    (
        "Transform { Scale 1e99 1 1 Scale 1e99 1 1 Scale 1e99 1 1 @Scale 1e99 1 1 Sphere",
        "the transformation's numbers grow too large",
    ),
];

fn refuse(text: &str) -> Diagnostic {
    parse(text).map(|_| ()).expect_err(text)
}

fn check(marked: &str, fragment: &str) {
    let (text, line, column) = unmark(marked);
    let at = Position { line: line as u32, column: column as u32 };
    let error = refuse(&text);
    assert_eq!(error.position(), Some(at), "place of: {error}\n{text}");
    assert!(error.message.contains(fragment), "{error}\nshould contain: {fragment}\n{text}");
    let rendered = error.in_text(Path::new("scene.txt"), &text).to_string();
    assert!(rendered.starts_with(&format!("scene.txt:{}:{}: error: ", at.line, at.column)), "{rendered}");
}

#[test]
fn malformed_blocks_are_refused_where_they_are_wrong() {
    for (marked, fragment) in WHOLE {
        check(marked, fragment);
    }
    for (marked, fragment) in WITH_CAMERA {
        check(&format!("{CAMERA}\n{marked}"), fragment);
        check(&format!("{CAMERA} // comment\r\n\t{marked}"), fragment);
    }
}

#[test]
fn malformed_objects_are_refused_where_they_are_wrong() {
    for (marked, fragment) in OBJECTS {
        let around =
            format!("{CAMERA}\nMaterials {{ numMaterials 2 Material {{ }} Material {{ }} }}\nGroup {{");
        check(&format!("{around} numObjects 1 MaterialIndex 0\n  {marked} }}"), fragment);
        check(
            &format!("{around} numObjects 1 Group {{ numObjects 1 MaterialIndex 0\n {marked} }} }}"),
            fragment,
        );
    }
}

#[test]
fn hints_name_what_was_meant() {
    for (text, hint) in [
        ("Grupe", "did you mean `Group`?"),
        ("perspectivecamera", "did you mean `PerspectiveCamera`?"),
        (
            "Teapot",
            "possible here: OrthographicCamera, PerspectiveCamera, Background, Lights, Materials, Group",
        ),
        ("}", "this brace closes nothing"),
        ("Sphere { }", "objects and their materials go inside a `Group`"),
        ("Materials { numMaterials 1 Material { difuse_color 1 1 1 } }", "did you mean `diffuseColor`?"),
        ("Group { numobjects 1 }", "did you mean `numObjects`?"),
        ("Group { numObjects 1 Trianglemesh { } }", "did you mean `TriangleMesh`?"),
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
