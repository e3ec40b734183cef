//! Meshes from outside: pictures of polygons, what other programs write, and the names of files.

use crate::support::{CAMERA, Folder, scene};
use std::fmt::Write as _;
use std::path::MAIN_SEPARATOR;

/// A scene of a white mesh before black, seen along the z axis: the square from 0 to 4.
fn picture_of(name: &str) -> String {
    format!(
        "OrthographicCamera {{ center 2 2 10 direction 0 0 -1 up 0 1 0 size 4 }}
        Background {{ color 0 0 0 ambientLight 1 1 1 }} Materials {{ numMaterials 1 Material {{ }} }}
        Group {{ numObjects 1 MaterialIndex 0 TriangleMesh {{ obj_file {name} }} }}"
    )
}

/// An OBJ text of one polygon.
fn polygon(corners: &[[f64; 2]]) -> String {
    let mut text = String::new();
    corners.iter().for_each(|[x, y]| writeln!(text, "v {x} {y} 0").unwrap());
    text + "f" + &(1..=corners.len()).map(|k| format!(" {k}")).collect::<String>()
}

/// The number of lit pixels of 100 x 100.
fn lit(folder: &Folder, mesh: &str) -> (usize, String) {
    folder.write("m.obj", mesh);
    folder.write("s.txt", picture_of("m.obj"));
    let run = folder.run("-input s.txt -size 100 100 -shade_back -output o.tga").ok();
    let warning = run.stderr.replace("WARNING:  No lights specified\n", "");
    (folder.tga("o.tga").greys().into_iter().filter(|&grey| grey > 0).count(), warning)
}

/// The number of pixels whose centres are inside a polygon of multiples of 0.02, by the crossings of a ray to the right,
/// in whole numbers. No centre is on an edge.
fn pixels(corners: &[[f64; 2]]) -> usize {
    let corners: Vec<[i64; 2]> = corners.iter().map(|corner| corner.map(|x| (x * 50.0) as i64)).collect();
    let is_inside = |x: i64, y: i64| {
        let edges = corners.iter().zip(corners.iter().cycle().skip(1));
        let crossed = edges.filter(|&(&[ax, ay], &[bx, by])| {
            let side = (bx - ax) * (y - ay) - (by - ay) * (x - ax);
            (ay > y) != (by > y) && (side > 0) == (by > ay)
        });
        crossed.count() % 2 == 1
    };
    (0..10_000).filter(|k| is_inside(2 * (k % 100) + 1, 2 * (k / 100) + 1)).count()
}

#[test]
fn concave_polygons_cover_their_area_from_every_corner_and_in_both_directions() {
    let shapes: [&[[f64; 2]]; 5] = [
        &[[0.0, 0.0], [4.0, 2.0], [0.0, 4.0], [1.5, 2.0]],
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]],
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [3.0, 4.0], [3.0, 1.0], [1.0, 1.0], [1.0, 4.0], [0.0, 4.0]],
        // A hole that is joined to the outside, and a corner on an edge.
        &[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.04],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.04],
            [1.0, 1.04],
        ],
        &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.0], [0.0, 4.0]],
    ];
    let folder = Folder::new();
    for shape in shapes {
        let mut corners = shape.to_vec();
        for _ in 0..shape.len() {
            corners.rotate_left(1);
            for _ in 0..2 {
                corners.reverse();
                let (count, warning) = lit(&folder, &polygon(&corners));
                assert_eq!((count, warning.as_str()), (pixels(shape), ""), "{corners:?}");
            }
        }
    }
}

#[test]
fn a_polygon_that_crosses_itself_is_drawn_alike_from_every_corner() {
    let folder = Folder::new();
    let mut corners = vec![[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]];
    let mut counts = vec![];
    for _ in 0..corners.len() {
        corners.rotate_left(1);
        for _ in 0..2 {
            corners.reverse();
            let (count, warning) = lit(&folder, &polygon(&corners));
            counts.push(count);
            assert!(
                warning.contains("m.obj`: line 5: the outline of the polygon crosses itself\n"),
                "{warning}"
            );
        }
    }
    assert!(counts[0] > 0 && counts.iter().all(|&count| count == counts[0]), "{counts:?}");
}

#[test]
fn an_outline_that_encloses_nothing_is_not_drawn() {
    let folder = Folder::new();
    let there_and_back: [&[[f64; 2]]; 2] = [
        &[[0.0, 0.0], [4.0, 0.0], [2.0, 3.0], [4.0, 0.0]],
        &[[0.0, 2.0], [2.0, 4.0], [4.0, 2.0], [2.0, 0.0], [0.0, 2.0], [2.0, 0.0], [4.0, 2.0], [2.0, 4.0]],
    ];
    for outline in there_and_back {
        let mut corners = outline.to_vec();
        for _ in 0..corners.len() {
            corners.rotate_left(1);
            let (count, warning) = lit(&folder, &polygon(&corners));
            assert_eq!(count, 0, "{corners:?}");
            assert!(warning.contains(": the outline of the polygon encloses nothing\n"), "{warning}");
        }
    }
}

/// Rays along an edge that two polygons share, on which both have a corner that lies between two others.
#[test]
fn nothing_shows_through_along_an_edge_of_two_polygons() {
    let folder = Folder::new();
    // An edge from -4 to 4 with a corner at 0.1, below a house and above a trough.
    let outlines = [
        [[-4.0, 0.0], [0.1, 0.0], [4.0, 0.0], [4.0, 4.0], [-4.0, 4.0]],
        [[4.0, 0.0], [0.1, 0.0], [-4.0, 0.0], [-4.0, -4.0], [4.0, -4.0]],
    ];
    for (turn, start) in (1..=8).flat_map(|turn| (0..5).map(move |start| (turn, start))) {
        let (sin, cos) = (f64::from(turn) * 0.227).sin_cos();
        let mut mesh = String::new();
        for [x, y] in outlines.as_flattened() {
            writeln!(mesh, "v {} {} 0", cos * x - sin * y, sin * x + cos * y).unwrap();
        }
        for first in [1, 6] {
            let corners = (0..5).map(|k| format!(" {}", first + (start + k) % 5)).collect::<String>();
            writeln!(mesh, "f{corners}").unwrap();
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

#[test]
fn convex_polygons_are_the_fans_they_were() {
    let folder = Folder::new();
    let corners: Vec<[f64; 2]> = (0..9)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 9.0)
        .map(|angle| [2.0 + 1.9 * angle.cos(), 2.0 + 1.7 * angle.sin()])
        .collect();
    let text = polygon(&corners);
    let (vertices, _) = text.split_once('f').unwrap();
    let fan: String = (2..9).map(|k| format!("f 1 {k} {}\n", k + 1)).collect();
    let picture = |mesh: &str| {
        lit(&folder, mesh);
        folder.run("-input s.txt -size 200 200 -normals n.png -output o.png -jittered_samples 4").ok();
        (folder.read("o.png"), folder.read("n.png"))
    };
    assert!(picture(&text) == picture(&format!("{vertices}{fan}")));
    // The statistics count the triangles.
    folder.write("m.obj", &text);
    let stats = folder.run("-input s.txt -size 9 9 -stats -output o.tga").ok();
    assert!(stats.stdout.contains("7"), "{}", stats.stdout);
}

#[test]
fn a_quad_with_a_corner_on_its_edge_or_twice_is_no_cause_for_a_warning() {
    let folder = Folder::new();
    for face in ["f 1 2 3 4 5", "f 2 3 4 5 1", "f 1 3 4 5 5", "f 1 1 3 4 4 5"] {
        let mesh = format!("v 0 0 0\nv 2 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\n{face}\n");
        assert_eq!(lit(&folder, &mesh), (10_000, String::new()), "{face}");
    }
    let (count, warning) = lit(&folder, "v 0 0 0\nv 4 4 0\nf 1 2 1 2\n");
    assert_eq!(count, 0);
    assert!(warning.contains("2 of the 2 triangles of the mesh have no area"), "{warning}");
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
        ("/home/somebody/a2/cube.obj", "cube.obj"),
        ("data/cube.obj", "cube.obj"),
        (r"..\MODEL\cube.obj", "cube.obj"),
        ("file:///C:/a/cube.obj", "cube.obj"),
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
fn hints_stand_below_the_line_of_the_mesh() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file m.obj }"));
    folder.write("m.obj", "v 0 0 0\rv 1,5 0 0\r");
    let message = folder.run("-input s.txt -output o.tga").message(1);
    let expected =
        "  m.obj:2:3:\n    2 | v 1,5 0 0\n      |   ^\n  hint: a decimal point is needed, not a comma\n";
    assert!(message.contains("m.obj`: line 2: a vertex needs three numbers, found `1,5`\n"), "{message}");
    assert!(message.ends_with(expected), "{message}");
    folder.write("m.obj", b"\xff\xfev\0 \0");
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert!(message.contains("m.obj`: the file is UTF-16 or UTF-32 text, not OBJ\n"), "{message}");
    assert!(message.ends_with("\n  hint: save the file as UTF-8\n"), "{message}");
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
        ("parts/Cube.obj", "did you mean `parts/Cube.OBJ`?"),
        ("parts/cube.obj", "did you mean `parts/Cube.OBJ`?"),
        (".\\parts\\cubes.obj", "did you mean `./parts/Cube.OBJ`?"),
        ("\"parts/Cube.OBJ\"", "a name has neither quotes nor blanks"),
        ("'my parts/Cube.OBJ'", "a name has neither quotes nor blanks"),
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
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    check("(it is a pipe or a device, not a regular file)");
    std::fs::create_dir(&path).expect("a folder");
    check("(it is a folder)");
    std::os::unix::fs::symlink("gone.obj", &path).expect("a link");
    check("(No such file or directory");
}
