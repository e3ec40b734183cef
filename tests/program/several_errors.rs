//! Scenes with several errors: all of them are reported, and nothing that only follows from one of them.

use crate::support::{CAMERA, Folder};
use raytracer::scene::parser;
use std::fs::File;
use std::path::MAIN_SEPARATOR;

const WHITE: &str = "Materials { numMaterials 1 Material { } }\n";

/// A text with `@` before each error.
fn unmarked(marked: &str) -> (String, Vec<(u32, u32)>) {
    let (mut text, mut places, mut line, mut column) = (String::new(), vec![], 1, 1);
    for character in marked.chars() {
        match character {
            '@' => {
                places.push((line, column));
                continue;
            }
            '\n' => (line, column) = (line + 1, 1),
            _ => column += 1,
        }
        text.push(character);
    }
    (text, places)
}

/// Checks where the errors of a scene are.
fn check(marked: &str) {
    let (text, expected) = unmarked(marked);
    let errors = parser::read(&text).map(|_| ()).expect_err(marked);
    let found: Vec<(u32, u32)> = errors.iter().map(|error| (error.at.line, error.at.column)).collect();
    assert_eq!(found, expected, "{marked}\n{errors:#?}");
}

#[test]
fn values_that_break_a_rule_are_all_reported() {
    check("PerspectiveCamera { center 0 0 0 direction @0 0 0 up 0 1 0 angle @190 } Group { numObjects 0 }");
    check(&format!(
        "{CAMERA}Lights {{ numLights 2 DirectionalLight {{ direction @0 0 0 color @2e30 0 0 }}
         PointLight {{ position @1e101 0 0 color 1 1 1 }} }} Group {{ numObjects 0 }}"
    ));
    check(&format!(
        "{CAMERA}Materials {{ numMaterials 3 Material {{ exponent @-1 indexOfRefraction @0 }}
         Checkerboard {{ materialIndex @1 materialIndex 0 }}
         Noise {{ materialIndex 0 materialIndex @7 octaves @99 }} }}
         Group {{ numObjects 2 MaterialIndex @3 Sphere {{ center 0 0 0 radius @-1 }}
         Transform {{ Rotate {{ @0 0 0 1 }} Matrix {{ 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 @2 }}
         TriangleMesh {{ obj_file @a.ply }} }} }}"
    ));
}

#[test]
fn an_item_with_an_error_still_counts() {
    check(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 4 MaterialIndex 0
         Sphere {{ center 0 0 0 @raduis 1 }}
         @Sphre {{ center 0 0 0 radius 1 }}
         Group {{ @Sphere {{ }} }}
         Transform {{ Scale 1 2 @Sphere {{ center 0 0 0 radius 1 }} }} }}"
    ));
    check(&format!(
        "{CAMERA}Lights {{ numLights 3 @SpotLight {{ }} PointLight {{ @direction 0 0 1 }} DirectionalLight {{ direction 0 0 1 color 1 1 @}} }}
         Materials {{ numMaterials 3 @Metal {{ }} Material {{ @shiny 1 }} Noise {{ materialIndex 0 materialIndex 1 @}} }}
         Group {{ numObjects 1 MaterialIndex 2 Sphere {{ center 0 0 0 radius 1 }} }}"
    ));
}

#[test]
fn a_wrong_number_names_the_count() {
    let objects = "Sphere { center 0 0 0 radius 1 } ".repeat(2);
    let text =
        |number: u32| format!("{CAMERA}{WHITE}Group {{ numObjects {number} MaterialIndex 0 {objects}}}");
    let error = |number| parser::read(&text(number)).map(|_| ()).unwrap_err().remove(0).problem.to_string();
    assert_eq!(error(0), "`numObjects` announces 0, but 2 found");
    assert_eq!(error(1), "`numObjects` announces 1, but 2 found");
    assert_eq!(error(5), "`numObjects` announces 5, but only 2 found");
    check(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 1 MaterialIndex 0 Group {{ numObjects 2 @}} @Group {{ numObjects 0 }} }}"
    ));
    // Another material, and then an object: only the object is too many.
    check(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 1 MaterialIndex 0 Group {{ numObjects 0 }} MaterialIndex 0 @Group {{ numObjects 0 }} }}"
    ));
}

#[test]
fn blocks_are_independent() {
    check(
        "@Camera { center 0 0 0 } @Ligths { numLights 1 } Background { @colour 0 0 0 } Group { numObjects @-1 }",
    );
    check(&format!("{CAMERA}Background {{ color 0 0 @}} Lights {{ @PointLight {{ }} }} Group {{ @}}"));
    check(&format!(
        "{CAMERA}Group {{ numObjects 0 }} @Materials {{ numMaterials 1 Material {{ exponent @-1 }} }}"
    ));
}

#[test]
fn a_missing_brace_hides_only_its_block() {
    check(
        "PerspectiveCamera { center 0 0 @x direction 0 0 1\nLights { numLights @-2 }\nGroup { numObjects 0 }",
    );
    check(&format!(
        "{CAMERA}Lights {{ numLights 1 PointLight {{ position 0 0 0 color 1 1 1\n@Group {{ numObjects 0 }}"
    ));
    check(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 2 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1
         @Sphere {{ center 0 0 0 radius 1 }} }}\nBackground {{ @colour 0 0 0 }}"
    ));
    check(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 2 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} @}} }}
         Sphere {{ center 0 0 0 radius 1 }} }}"
    ));
    check(&format!("{CAMERA}{WHITE}Group {{ numObjects 1 MaterialIndex 0 Transform {{ Scale 1 1 1@"));
}

#[test]
fn what_follows_from_an_error_is_not_reported() {
    // Neither are the materials missing, nor does the group lack a material.
    check(&format!(
        "{CAMERA}Materials {{ @numMaterial 1 Material {{ }} }} Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
    ));
    check(&format!(
        "{CAMERA}Materials {{ numMaterials 2 Material {{ }} @}} Group {{ numObjects 1 MaterialIndex 1 Sphere {{ center 0 0 0 radius 1 }} }}"
    ));
    check(&format!(
        "{CAMERA}Group {{ numObjects 2 MaterialIndex @x {0} {0} }}",
        "Sphere { center 0 0 0 radius 1 }"
    ));
    // Two objects without a material are one mistake.
    check(&format!("{CAMERA}Group {{ numObjects 2 @{0} {0} }}", "Sphere { center 0 0 0 radius 1 }"));
    // So are two objects outside of any group.
    check(&format!("{CAMERA}@{0} {0}", "Sphere { center 0 0 0 radius 1 }"));
    check(&format!("{CAMERA}{WHITE}Group {{ numObjects @many MaterialIndex 0 Group {{ numObjects 0 }} }}"));
}

#[test]
fn ten_errors_are_enough() {
    let objects = "Sphere { center 0 0 0 radius 0 }\n".repeat(12);
    let folder =
        Folder::with_scene(&format!("{CAMERA}{WHITE}Group {{ numObjects 12 MaterialIndex 0\n{objects}}}"));
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert_eq!(message.matches("error: `radius` must be positive").count(), 10);
    assert!(message.ends_with("\n10 errors are shown; there may be more\n"), "{message}");
    assert_eq!(message.lines().count(), 31);
}

#[test]
fn every_mesh_with_an_error_shows_its_own_line() {
    let folder = Folder::with_scene(&format!(
        "{CAMERA}{WHITE}Group {{ numObjects 3 MaterialIndex 0\nTriangleMesh {{ obj_file a.obj }}\nTriangleMesh {{ obj_file b.obj }}\nTriangleMesh {{ obj_file goood.obj }} }}"
    ));
    folder.write("a.obj", "v 0 0 0\nv 1 x 0\n");
    folder.write("b.obj", "v 0 0 0\nf 1 1 9 # nine\n");
    folder.write("good.obj", "v 0 0 0\nf 1 1 1\n");
    let expected = "\
s.txt:4:25: error: in the mesh `a.obj`: line 2: a vertex needs three numbers, and `x` is none
    4 | TriangleMesh { obj_file a.obj }
      |                         ^
  a.obj:2:5:
    2 | v 1 x 0
      |     ^
s.txt:5:25: error: in the mesh `b.obj`: line 2: a face names a vertex that does not exist; the mesh has 1
    5 | TriangleMesh { obj_file b.obj }
      |                         ^
  b.obj:2:7:
    2 | f 1 1 9 # nine
      |       ^
s.txt:6:25: error: cannot read the mesh `goood.obj`: tried `goood.obj` (No such file or directory (os error 2))
    6 | TriangleMesh { obj_file goood.obj } }
      |                         ^
  hint: did you mean `good.obj`?
";
    // Each system has words of its own for that.
    let gone = File::open("goood.obj").expect_err("no file").to_string();
    let expected = expected.replace("No such file or directory (os error 2)", &gone);
    assert_eq!(folder.run("-input s.txt -output o.tga").message(1), expected);
}

#[test]
fn a_scene_s_name_that_is_nearly_right_is_corrected() {
    let folder = Folder::new();
    for name in ["scene_01_sphere.txt", "scene_02_plane.txt"] {
        folder.write(name, "");
    }
    std::fs::create_dir(folder.path().join("more")).expect("a folder");
    folder.write("more/teapot.txt", "");
    for (name, near) in [
        ("scene_1_sphere.txt", "scene_01_sphere.txt"),
        ("scene_02.txt", "scene_02_plane.txt"),
        ("teapot.txt", "more/teapot.txt"),
        ("more/tepot.txt", "more/teapot.txt"),
    ] {
        let message = folder.run(&format!("-input {name} -output o.tga")).message(1);
        let message = message.replace(MAIN_SEPARATOR, "/");
        assert!(message.ends_with(&format!("\n  hint: did you mean `{near}`?\n")), "{message}");
    }
    let message = folder.run("-input cup.txt -output o.tga").message(1);
    assert!(!message.contains("hint"), "{message}");
}
