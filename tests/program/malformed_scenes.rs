//! Malformed scenes, given to the program: each ends with the position of its error and status 1.

use crate::support::{CAMERA, Folder, unmark};

/// Malformed scenes, with `@` at the position of the error.
const MALFORMED: &[&str] = &[
    "@",
    "@Grupe { numObjects 0 }",
    "@} Group { numObjects 0 }",
    "OrthographicCamera { center 0 0 0 direction 0 0 1 up 0 1 0 size @-1 }",
    "PerspectiveCamera { center 0 0 0 direction @0 0 0 up 0 1 0 angle 30 }",
    "PerspectiveCamera { center 0 0 @1e400 direction 0 0 1 up 0 1 0 angle 30 }",
    "PerspectiveCamera { center 0 0 0\n  direction 0 0 1\n  up 0 1 0\n  angle @200 }",
    "Background { @colour 0 0 0 }",
    "Lights { numLights 2 DirectionalLight { direction 0 0 1 color 1 1 1 } @}",
    "Lights { numLights @-1 }",
    "Lights { numLights 1 @SpotLight { } }",
    "Materials { numMaterials 1 Material { diffuseColor 1 1 @} }",
    "Materials { numMaterials 2 Material { } Checkerboard { materialIndex 0 materialIndex @1 } }",
    "Materials { numMaterials 99999999999 @}",
    "Group { numObjects @1.5 }",
    "Group { numObjects 1 @}",
    "Group { numObjects 1 @Sphere { center 0 0 0 radius 1 } }",
    "Group { numObjects 1 MaterialIndex @0 Sphere { center 0 0 0 radius 1 } }",
    "Group { numObjects 1 Material { } Sphere { center 0 0 0 radius @-1 } }",
    "Group { numObjects 1 Material { } Plane { normal @0 0 0 offset 1 } }",
    "Group { numObjects 1 Material { } Triangle { vertex0 0 0 0 vertex1 1 0 @vertex2 0 1 0 } }",
    "Group { numObjects 1 Material { } TriangleMesh { obj_file @gone.obj } }",
    "Group { numObjects 1 Material { } TriangleMesh { obj_file @broken.obj } }",
    "Group { numObjects 1 Material { } Transform { Rotate { @0 0 0 30 } Sphere { center 0 0 0 radius 1 } } }",
    "Group { numObjects 1 Material { } @Transform { Scale 0 1 1 Sphere { center 0 0 0 radius 1 } } }",
    "Group { numObjects 1 Material { } @Transform { UniformScale 0 Plane { normal 0 1 0 offset 0 } } }",
    "Group { numObjects 0@",
];

/// The text of a row without its mark, and the line and column of the mark. A scene that does not start with
/// its camera gets one, unless the missing camera is the error.
fn row(marked: &str) -> (String, usize, usize) {
    let has_camera = marked == "@" || marked.contains("Camera {");
    if has_camera { unmark(marked) } else { unmark(&format!("{CAMERA}{marked}")) }
}

#[test]
fn every_malformed_scene_ends_with_its_place_and_status_1() {
    let folder = Folder::new();
    folder.write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    let mut wrong = String::new();
    for marked in MALFORMED {
        let (text, line, column) = row(marked);
        folder.write("s.txt", &text);
        let message = folder.run("-input s.txt -output o.tga -grid 2 2 2").message(1);
        let start = format!("s.txt:{line}:{column}: error: ");
        if !message.lines().any(|line| line.starts_with(&start)) || !message.contains('^') {
            wrong += &format!("{marked}\n  expected {line}:{column}\n  {message}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
    assert_eq!(folder.names(), ["broken.obj", "s.txt"]);
}
