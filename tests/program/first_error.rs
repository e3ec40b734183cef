//! Errors in the files that a scene names, and in the name of the scene.

use crate::support::{CAMERA, Folder};
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
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert!(message.starts_with("s.txt:4:25: error: in the mesh `a.obj`: line 2: "), "{message}");
    let place = "\n    4 | TriangleMesh { obj_file a.obj } }\n      |                         ^\n";
    let own = "\n  a.obj:2:5:\n    2 | v 1 x 0\n      |     ^\n";
    assert!(message.contains(place) && message.ends_with(own), "{message}");
    folder.write("s.txt", scene("goood"));
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert!(message.starts_with("s.txt:4:25: error: cannot read the mesh `goood.obj`: "), "{message}");
    assert!(message.ends_with("\n  hint: did you mean `good.obj`?\n"), "{message}");
}

#[test]
fn a_scene_s_name_that_is_nearly_right_is_corrected() {
    let folder = Folder::new();
    folder.write("scene_02_plane.txt", "");
    std::fs::create_dir(folder.path().join("more")).expect("a folder");
    folder.write("more/teapot.txt", "");
    for (name, near) in [("scene_02.txt", "scene_02_plane.txt"), ("teapot.txt", "more/teapot.txt")] {
        let message = folder.run(&format!("-input {name} -output o.tga")).message(1);
        let message = message.replace(MAIN_SEPARATOR, "/");
        assert!(message.ends_with(&format!("\n  hint: did you mean `{near}`?\n")), "{message}");
    }
    let message = folder.run("-input cup.txt -output o.tga").message(1);
    assert!(!message.contains("hint"), "{message}");
}
