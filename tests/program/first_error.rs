//! Errors in the files that a scene names, and in the name of the scene.

use crate::support::{CAMERA, Folder};
use std::fs::File;
use std::path::MAIN_SEPARATOR;

const WHITE: &str = "Materials { numMaterials 1 Material { } }\n";

/// The error in a mesh file shows the mesh's own line.
#[test]
fn a_mesh_with_an_error_shows_its_own_line() {
    let scene = |name: &str| {
        format!(
            "{CAMERA}{WHITE}Group {{ numObjects 1 MaterialIndex 0\nTriangleMesh {{ obj_file {name}.obj }} }}"
        )
    };
    let folder = Folder::new();
    folder.write("a.obj", "v 0 0 0\nv 1 x 0\n");
    folder.write("good.obj", "v 0 0 0\nf 1 1 1\n");
    folder.write("s.txt", scene("a"));
    let expected = "\
s.txt:4:25: error: in the mesh `a.obj`: line 2: a vertex needs three numbers, found `x`
    4 | TriangleMesh { obj_file a.obj } }
      |                         ^
  a.obj:2:5:
    2 | v 1 x 0
      |     ^
";
    assert_eq!(folder.run("-input s.txt -output o.tga").message(1), expected);
    folder.write("s.txt", scene("goood"));
    // Each system has words of its own for a file that is not there.
    let gone = File::open("goood.obj").expect_err("no file").to_string();
    let expected = format!(
        "\
s.txt:4:25: error: cannot read the mesh `goood.obj`: tried `goood.obj` ({gone})
    4 | TriangleMesh {{ obj_file goood.obj }} }}
      |                         ^
  hint: did you mean `good.obj`?
"
    );
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
