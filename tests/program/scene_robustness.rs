//! No scene makes the reader panic, hang or exhaust memory, however damaged, deeply nested or long it is.

use rayon::prelude::*;
use raytracer::diagnostic::Diagnostic;
use raytracer::scene::edition::Edition;
use raytracer::scene::parser::{parse, read_in};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

const CAMERA: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }";

fn refuse(text: &str) -> Diagnostic {
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
fn no_deleted_doubled_or_replaced_word_panics() {
    let words: Vec<&str> = EVERYTHING.split_inclusive(char::is_whitespace).collect();
    for index in 0..words.len() {
        let (before, behind) = (words[..index].concat(), words[index + 1..].concat());
        let word = words[index];
        for changed in ["", &word.repeat(2), "{ ", "} ", "-1 ", "1e999 ", "\u{0} ", "MaterialIndex ", "# "] {
            let text = format!("{before}{changed}{behind}");
            if let Err(error) = parse(&text) {
                let _ = error.in_text(Path::new("a"), &text).to_string();
            }
        }
    }
}

/// All words of 2012 and later.
const LATER: &str = "\
PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
Background { color .2 0 1 cubeMap sky ambientLight 0 0 0 }
Lights { numLights 2 DirectionalLight { direction 0 -1 0 color 1 1 1 } PointLight { falloff 1 color 1 1 1 position 1 2 3 } }
Materials { numMaterials 2 PhongMaterial { shininess 5 specularColor 1 1 1 texture a.bmp refractionIndex 1.5 bump b.bmp }
  Material { Noise { color 1 0 0 octaves 3 frequency 2 amplitude 4 color 0 0 1 } diffuseColor 1 0 0 } }
Group { numObjects 1 MaterialIndex 1 Transform { Matrix4f { 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 } TriangleMesh { obj_file a.obj } } }
";

/// Those of 2003 and of Aalto.
const OTHERS: &str = "\
OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 5 }
Materials { num_materials 1 Material { texture a.bmp mipmap linearInterpolation } }
Group { num_objects 2 Material { } Grid { min 0 0 0 max 1 1 1 numCells 2 2 2 rasterizeSphere { center 0 0 0 radius 1 } }
  Triangle { textCoord0 0 0 vertex0 0 0 0 vertex1 1 0 0 textCoord2 1 1 vertex2 0 1 0 } }
";

/// Reads a text in every edition. The position of an error is in the text.
fn read_in_all(text: &str) {
    for edition in Edition::ALL {
        if let Err(error) = read_in(edition, text) {
            let line = error.position().expect("a position").line as usize;
            assert!(line <= text.matches('\n').count() + 1, "{edition}: {error}");
        }
    }
}

#[test]
fn reading_some_prefixes_of_every_scene_ends_in_every_edition() {
    read_prefixes(17);
}

#[test]
#[ignore = "slow: twenty seconds"]
fn reading_every_prefix_of_every_scene_ends_in_every_edition() {
    read_prefixes(1);
}

/// Reads every `step`th prefix of every scene. A loop that takes no word would run for ever here.
fn read_prefixes(step: usize) {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let files =
        [scenes.clone(), scenes.join("editions")].map(|folder| fs::read_dir(folder).expect("a folder"));
    let files = files.into_iter().flatten().map(|entry| entry.expect("a file").path());
    let files = files.filter(|file| file.extension().is_some_and(|ending| ending == "txt"));
    let mut texts: Vec<String> = files.map(|file| fs::read_to_string(file).expect("a scene")).collect();
    assert!(texts.len() > 80);
    texts.extend([EVERYTHING, LATER, OTHERS].map(str::to_owned));
    texts.par_iter().for_each(|text| {
        // A blank at the end is no other text.
        let ends = text.char_indices().filter(|(_, last)| !last.is_whitespace());
        ends.step_by(step).for_each(|(start, last)| read_in_all(&text[..start + last.len_utf8()]));
    });
}

/// Every word of every edition opens a block that is not closed, at every place of a scene.
#[test]
fn reading_ends_at_an_unfinished_block_of_any_word() {
    let all = [EVERYTHING, LATER, OTHERS].concat();
    let mut words: Vec<&str> = all.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    words.extend(["", "{", "}", "Sphre", "0", "-", "\u{0}"]);
    words.sort_unstable();
    words.dedup();
    assert!(words.len() > 80);
    words.par_iter().for_each(|word| {
        for before in [
            "",
            "}",
            "Background {",
            "Lights { numLights 2 PointLight {",
            "Materials { numMaterials 1",
            "Materials { numMaterials 2 Material { } Noise { Transform {",
            "Materials { numMaterials 1 Material { Noise {",
            "Group { numObjects 0",
            "Group { numObjects 2 Material { } Transform {",
            "Group { numObjects 1 Material { } Transform { Matrix4f {",
        ] {
            for after in ["", "{", "{ {", "{ }", "}", "} }"] {
                read_in_all(&format!("{before} {word} {after}"));
                read_in_all(&format!("{EVERYTHING} {before} {word} {after}"));
            }
        }
    });
}

/// A time that is far above that of a linear algorithm, and far below that of a quadratic one.
const LONG: Duration = Duration::from_secs(20);

#[test]
fn deep_nesting_needs_neither_stack_nor_time() {
    let start = Instant::now();
    for open in ["Transform { Translate 0 0 1 ", "Group { numObjects 1 "] {
        let nested = open.repeat(100_000);
        let unfinished = format!("{CAMERA} Group {{ numObjects 1 {nested} Group {{ numObjects 0 }}");
        assert!(refuse(&unfinished).to_string().contains("the end of the file"));
        let scene = parse(&(unfinished + &"} ".repeat(100_001))).unwrap();
        assert_eq!(scene.objects.len(), 100_002);
    }
    assert!(start.elapsed() < LONG);
}
