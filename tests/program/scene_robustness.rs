//! No scene makes the reader panic, hang or exhaust memory, however damaged, deeply nested or long it is.

use raytracer::scene::error::SceneError;
use raytracer::scene::parser::parse;
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

const CAMERA: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }";

fn refuse(text: &str) -> SceneError {
    parse(text).map(|_| ()).expect_err("the scene should be refused")
}

/// A scene with every element of the grammar.
const EVERYTHING: &str = "\
OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 5 }
PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
Background { color .2 0. +1 ambientLight 1e-1 0 0 }
Lights { numLights 2
  DirectionalLight { direction 0 -1 0 color 1 1 1 }
  PointLight { position 1 2 3 color 1 1 1 attenuation 1 0 0 } }
Materials { numMaterials 6
  Material { diffuseColor 1 0 0 specularColor 1 1 1 exponent 5 reflectiveColor 0 0 0 transparentColor 0 0 0
    indexOfRefraction 1.5 }
  PhongMaterial { diffuse_color 0 1 0 }
  Checkerboard { Transform { Scale 2 2 2 } materialIndex 0 materialIndex 1 size 2 }
  Noise { materialIndex 0 materialIndex 2 octaves 3 }
  Marble { materialIndex 1 materialIndex 3 octaves 3 frequency 2 amplitude 4 }
  Wood { Transform { ZRotate 90 } materialIndex 1 materialIndex 4 octaves 3 frequency 2 amplitude 4 } }
Group { numObjects 6 # primitives
  MaterialIndex 0 Sphere { center 0 0 0 radius 1 }
  MaterialIndex 5 Plane { normal 0 1 0 offset 0 }
  Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }
  Material { diffuseColor 0 0 1 } TriangleMesh { obj_file some.obj }
  Box{min -1 -1 -1 max 1 1 1}
  Transform { Translate 1 0 0 Scale { 1 2 3 } UniformScale 2 XRotate 30 YRotate 30 ZRotate 30
    Rotate { 1 0 0 30 } Matrix { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 }
    Group { numObjects 1 MaterialIndex 1 Transform { Group { numObjects 0 } } } }
}
";

#[test]
fn no_truncation_panics() {
    assert!(parse(EVERYTHING).is_ok());
    let group = EVERYTHING.find("Group {").unwrap();
    for end in 0..EVERYTHING.trim_end().len() {
        let at = parse(&EVERYTHING[..end]).map(|_| ());
        assert!(at.is_err(), "a scene cut off at {end} was accepted");
        assert!(end < group || at.unwrap_err().at.line > 12);
    }
}

#[test]
fn no_deleted_doubled_or_replaced_word_panics() {
    let words: Vec<&str> = EVERYTHING.split_inclusive(char::is_whitespace).collect();
    for index in 0..words.len() {
        let (before, behind) = (words[..index].concat(), words[index + 1..].concat());
        let word = words[index];
        for changed in [
            "",
            &word.repeat(2),
            "{ ",
            "} ",
            "0 ",
            "-1 ",
            "1e999 ",
            "\u{0} ",
            "MaterialIndex ",
            "Group ",
            "# ",
        ] {
            let text = format!("{before}{changed}{behind}");
            if let Err(error) = parse(&text) {
                let _ = error.render(Path::new("a"), &text);
            }
        }
    }
}

#[test]
fn windows_line_ends_change_nothing() {
    let scene = parse(&EVERYTHING.replace('\n', "\r\n")).unwrap();
    assert_eq!(format!("{scene:?}"), format!("{:?}", parse(EVERYTHING).unwrap()));
}

/// `depth` transforms around an empty group, in a scene.
fn nested(depth: usize, open: &str, close: &str) -> String {
    let mut text = format!("{CAMERA} Group {{ numObjects 1 {} Group {{ numObjects 0 }}", open.repeat(depth));
    let _ = write!(text, "{} }}", close.repeat(depth));
    text
}

/// A time that is far above that of a linear algorithm, and far below that of a quadratic one.
const LONG: Duration = Duration::from_secs(20);

#[test]
fn deep_nesting_needs_neither_stack_nor_time() {
    let start = Instant::now();
    for (open, close) in [("Transform { Translate 0 0 1 ", "} "), ("Group { numObjects 1 ", "}\n")] {
        let scene = parse(&nested(100_000, open, close)).unwrap();
        assert_eq!(scene.objects.len(), 100_002);
        let unfinished = nested(100_000, open, "");
        assert!(refuse(&unfinished).to_string().contains("the end of the file"));
    }
    assert!(start.elapsed() < LONG);
}

#[test]
fn many_objects_and_meshes_take_linear_time() {
    const COUNT: usize = 200_000;
    let start = Instant::now();
    let mut text = format!("{CAMERA} Group {{ numObjects {} Material {{ }}", 2 * COUNT);
    for index in 0..COUNT {
        let _ = writeln!(text, "Sphere {{ center 0 0 0 radius 1 }} TriangleMesh {{ obj_file {index}.obj }}");
    }
    let scene = parse(&(text + "}")).unwrap();
    assert_eq!((scene.objects.len(), scene.meshes.len()), (2 * COUNT + 1, COUNT));
    assert!(start.elapsed() < LONG);
}

#[test]
fn words_and_lines_of_a_megabyte_give_short_messages() {
    for text in
        ["x".repeat(1 << 20), format!("{}x", " ".repeat(1 << 20)), "}".repeat(1 << 20), "\n".repeat(1 << 20)]
    {
        let rendered = refuse(&text).render(Path::new("a"), &text);
        assert!(rendered.len() < 2_000, "{} bytes", rendered.len());
    }
}
