//! Meshes from outside: pictures of polygons, what other programs write, and the names of files.

use crate::support::{CAMERA, Folder, scene};
use std::path::MAIN_SEPARATOR;

/// Casts rays along an edge that two polygons share, on which both have a corner that lies between two others.
#[test]
fn nothing_shows_through_along_an_edge_of_two_polygons() {
    let folder = Folder::new();
    // An edge from -4 to 4 with a corner at 0.1, below a house and above a trough.
    let outlines = [
        [[-4.0, 0.0], [0.1, 0.0], [4.0, 0.0], [4.0, 4.0], [-4.0, 4.0]],
        [[4.0, 0.0], [0.1, 0.0], [-4.0, 0.0], [-4.0, -4.0], [4.0, -4.0]],
    ];
    for (turn, start) in (1..=8).map(|turn| (turn, turn as usize % 5)) {
        let (sin, cos) = (f64::from(turn) * 0.227).sin_cos();
        let mut mesh = String::new();
        for [x, y] in outlines.as_flattened() {
            mesh += &format!("v {} {} 0\n", cos * x - sin * y, sin * x + cos * y);
        }
        for first in [1, 6] {
            let corners = (0..5).map(|k| format!(" {}", first + (start + k) % 5)).collect::<String>();
            mesh += &format!("f{corners}\n");
        }
        folder.write("m.obj", mesh);
        // The picture's row of pixels runs along the edge.
        folder.write(
            "s.txt",
            format!(
                "OrthographicCamera {{ center 0 0 10 direction 0 0 -1 up {} {cos} 0 size 7.9 }}
                Background {{ color 0 0 0 ambientLight 1 1 1 }} Materials {{ numMaterials 1 Material {{ }} }}
                Group {{ numObjects 1 MaterialIndex 0 TriangleMesh {{ obj_file m.obj }} }}",
                -sin
            ),
        );
        folder.run("-input s.txt -size 4001 1 -shade_back -output o.tga").ok();
        let dark = folder.tga("o.tga").greys().into_iter().filter(|&grey| grey == 0).count();
        assert_eq!(dark, 0, "turn {turn}, first corner {start}");
    }
}

/// A path of another machine: the hint names the file that lies beside the scene, with as much of the path as is there.
#[test]
fn a_file_beside_the_scene_is_named_whatever_path_is_written() {
    let folder = Folder::new();
    std::fs::create_dir_all(folder.path().join("p/parts")).expect("folders");
    for name in ["p/cube.obj", "p/parts/leg.obj"] {
        folder.write(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    }
    folder.write("p/wood.bmp", "");
    let objects = |name: &str| {
        format!("{CAMERA}Group {{ numObjects 1 Material {{ }} TriangleMesh {{ obj_file {name} }} }}")
    };
    let hint = |text: &str, flags: &str| {
        folder.write("p/s.txt", text);
        let message = folder.run(&format!("-input p/s.txt -output o.tga {flags}")).message(1);
        message.trim_end().split_once("\n  hint: ").map(|(_, hint)| hint.to_owned())
    };
    for (name, found) in [
        (r"C:\course\a2\cube.obj", "cube.obj"),
        ("data/cube.obj", "cube.obj"),
        (r"..\MODEL\cube.obj", "cube.obj"),
        (r"D:\a2\parts\leg.obj", "parts/leg.obj"),
        ("a/../../parts/leg.obj", "parts/leg.obj"),
    ] {
        assert_eq!(hint(&objects(name), ""), Some(format!("`{found}` lies beside the scene")), "{name}");
    }
    assert_eq!(hint(&objects("/a/cub.obj"), ""), Some("did you mean `cube.obj`?".into()));
    assert_eq!(hint(&objects("/a/teapot.obj"), ""), None);
    let texture = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
        Materials { numMaterials 1 Material { texture C:/a/wood.bmp } } Group { numObjects 0 }";
    assert_eq!(hint(texture, "-edition 2012a4"), Some("`wood.bmp` lies beside the scene".into()));
}

#[test]
fn names_of_other_systems_are_read_or_corrected() {
    const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("parts")).expect("a folder");
    folder.write("parts/Cube.OBJ", MESH);
    let run = |name: &str| {
        folder.write("s.txt", scene(1, &format!("TriangleMesh {{ obj_file {name} }}")));
        folder.run("-input s.txt -size 9 9 -output o.tga")
    };
    for name in ["parts/Cube.OBJ", "parts\\Cube.OBJ", ".\\parts\\Cube.OBJ"] {
        assert_eq!(run(name).ok().stderr, "", "{name}");
    }
    // Some disks do not tell capitals from small letters.
    let tells_capitals = !folder.path().join("parts/cube.obj").exists();
    for (name, hint) in [
        ("parts/cube.obj", "did you mean `parts/Cube.OBJ`?"),
        (".\\parts\\cubes.obj", "did you mean `./parts/Cube.OBJ`?"),
        ("\"parts/Cube.OBJ\"", "a name has neither quotes nor blanks"),
    ] {
        if !tells_capitals && name.eq_ignore_ascii_case("parts/Cube.OBJ") {
            assert_eq!(run(name).ok().stderr, "", "{name}");
            continue;
        }
        let message = run(name).message(1).replace(MAIN_SEPARATOR, "/");
        assert!(message.ends_with(&format!("\n  hint: {hint}\n")), "{name}: {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{name}: {message}");
    }
}

/// What is there but is no file is not corrected to its own name, nor to another.
#[cfg(unix)]
#[test]
fn a_mesh_that_is_there_but_cannot_be_read_has_no_other_name() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file m.obj }"));
    folder.write("n.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let path = folder.path().join("m.obj");
    let check = |reason: &str| {
        let message = folder.run("-input s.txt -output o.tga").message(1);
        assert!(message.contains(reason) && !message.contains("hint"), "{message}");
        std::fs::remove_file(&path).or_else(|_| std::fs::remove_dir(&path)).expect("removed");
    };
    folder.make_pipe("m.obj");
    check("(it is a pipe or a device, not a regular file)");
    std::fs::create_dir(&path).expect("a folder");
    check("(it is a folder)");
    std::os::unix::fs::symlink("gone.obj", &path).expect("a link");
    check("(No such file or directory");
}
