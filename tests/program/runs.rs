//! The program as a user meets it: what it prints where, how it ends, and what it leaves on disk.

use crate::support::{Folder, finish, nobody, program};
use raytracer::image_io;

const CAMERA: &str = "OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 2 }\n";
const LIGHT: &str = "Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }\n";
const WHITE: &str = "Materials { numMaterials 1 Material { } }\n";

/// A scene in white under one light, with these objects.
fn scene(count: usize, objects: &str) -> String {
    format!("{CAMERA}{LIGHT}{WHITE}Group {{ numObjects {count} MaterialIndex 0\n{objects}\n}}\n")
}

fn sphere() -> String {
    scene(1, "Sphere { center 0 0 0 radius .7 }")
}

/// The only line of `message`, without the newline.
fn only_line(message: &str) -> &str {
    let line = message.strip_suffix('\n').expect("a line ends with a newline");
    assert!(!line.contains('\n'), "{message}");
    line
}

#[test]
fn a_faulty_command_line_is_status_2_and_one_line() {
    let folder = Folder::with_scene(&sphere());
    for (line, expected) in [
        ("", "error: no scene: `-input file` is required (`-help` lists every flag)"),
        ("-input s.txt -shadow", "error: unknown flag `-shadow`; did you mean `-shadows`?"),
        ("-input s.txt -visualize_grid", "error: `-visualize_grid` needs `-grid nx ny nz`"),
        ("-input s.txt -size 10", "error: `-size` takes 2 values, 1 given"),
        ("-input s.txt -stats -stats", "error: `-stats` given twice"),
        ("-input s.txt -bounces many", "error: `-bounces`: `many` is not a whole number"),
        (
            "-input s.txt -random_samples 4 -jittered_samples 4",
            "error: `-random_samples` cannot be combined with `-jittered_samples`",
        ),
    ] {
        assert_eq!(only_line(&folder.run(line).message(2)), expected, "{line}");
    }
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn a_missing_scene() {
    let folder = Folder::new();
    let message = folder.run("-input no-such.txt -output o.tga").message(1);
    assert!(only_line(&message).starts_with("no-such.txt: error: cannot read the scene: "), "{message}");
    assert!(folder.names().is_empty());
}

#[test]
fn a_malformed_scene_is_shown_with_its_place() {
    let folder = Folder::with_scene("PerspectiveCamera {\n  center 0 0 0 direction 0 zero 1\n}\n");
    let message = folder.run("-input s.txt -output o.tga").message(1);
    let lines: Vec<&str> = message.lines().collect();
    assert_eq!(lines[0], "s.txt:2:28: error: expected a number for `direction`, found `zero`");
    assert_eq!(lines[1], "    2 |   center 0 0 0 direction 0 zero 1");
    let caret = lines[2].find('^').expect("a caret");
    assert_eq!(&lines[1][caret..caret + 4], "zero");
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn a_missing_mesh_is_named_where_the_scene_names_it() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file no-such.obj }"));
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert!(message.starts_with("s.txt:5:25: error: cannot read the mesh `no-such.obj`"), "{message}");
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn a_mesh_is_found_beside_the_scene_from_any_folder() {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file one.obj }"));
    folder.write("one.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    let elsewhere = Folder::new();
    let input = folder.path().join("s.txt");
    finish(
        program(elsewhere.path(), ["-input".as_ref(), input.as_os_str()])
            .args(["-output", "o.tga", "-size", "3", "3"]),
    )
    .ok();
    assert_eq!(elsewhere.tga("o.tga").at(1, 1), [255; 3]);
}

#[test]
fn a_singular_transform_under_a_sphere_is_shown() {
    let folder =
        Folder::with_scene(&scene(1, "Transform { Scale 1 0 1\n  Sphere { center 0 0 0 radius 1 } }"));
    let message = folder.run("-input s.txt -output o.tga").message(1);
    assert!(message.starts_with("s.txt:5:1: error: the transformation is singular"), "{message}");
    assert!(message.contains('^'), "{message}");
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn a_triangle_under_a_singular_transform_is_still_a_triangle() {
    let flattened = "Transform { Scale 1 1 0 Triangle { vertex0 -1 -1 5 vertex1 1 -1 -3 vertex2 0 1 2 } }";
    let plain = "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }";
    let pictures = [flattened, plain].map(|o| Folder::with_scene(&scene(1, o)).render("-size 20 20"));
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0].at(10, 10), [255; 3]);
}

#[test]
fn a_target_that_cannot_be_written_is_reported_before_anything_else() {
    // The missing scene would be reported if the targets were not looked at first.
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("folder.tga")).unwrap();
    for flags in ["-output", "-depth 1 2", "-normals"] {
        let message = folder.run(&format!("-input s.txt {flags} no/such/o.tga")).message(1);
        assert!(only_line(&message).starts_with("error: cannot write `no/such/o.tga`: "), "{message}");
    }
    for flags in ["-render_samples folder.tga 2", "-render_filter folder.tga 2"] {
        let message = folder.run(&format!("-input s.txt {flags}")).message(1);
        assert_eq!(only_line(&message), "error: cannot write `folder.tga`: it is a folder");
    }
    assert_eq!(folder.names(), ["folder.tga"]);
}

#[test]
fn a_failed_run_leaves_an_earlier_picture_alone() {
    let folder = Folder::with_scene("PerspectiveCamera {");
    folder.write("o.tga", "an earlier picture");
    folder.run("-input s.txt -output o.tga -normals n.tga").message(1);
    assert_eq!(folder.read("o.tga"), b"an earlier picture");
    assert_eq!(folder.names(), ["o.tga", "s.txt"]);
}

#[test]
fn a_run_leaves_the_pictures_and_nothing_else() {
    let folder = Folder::with_scene(&sphere());
    folder.write("c.tga", "an earlier picture");
    folder
        .run("-input s.txt -size 5 4 -output c.tga -depth 0 9 d.png -normals n.tga -render_samples s.tga 3 -render_filter f.tga 2")
        .ok();
    assert_eq!(folder.names(), ["c.tga", "d.png", "f.tga", "n.tga", "s.tga", "s.txt"]);
    let size = |name| {
        let tga = folder.tga(name);
        (tga.width, tga.height)
    };
    assert_eq!(["c.tga", "n.tga", "s.tga", "f.tga"].map(size), [(5, 4), (5, 4), (15, 12), (11, 9)]);
}

#[test]
fn png_and_tga_hold_the_same_pixels() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -size 9 7 -output a.tga -normals n.png").ok();
    folder.run("-input s.txt -size 9 7 -output a.png -normals n.tga").ok();
    for name in ["a", "n"] {
        let [tga, png] = ["tga", "png"].map(|end| folder.path().join(name).with_extension(end));
        assert_eq!(image_io::read_picture(&tga).unwrap(), image_io::read_picture(&png).unwrap());
    }
}

#[test]
fn silence_is_the_rule() {
    let folder = Folder::with_scene(&sphere());
    let run = folder.run("-input s.txt -output o.tga -shadows -bounces 2 -grid 3 3 3").ok();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", ""));
}

#[test]
fn a_scene_without_lights_warns_on_standard_error_and_is_lit_evenly() {
    let lit = "Group { numObjects 1 Material { diffuseColor 1 .5 0 } Plane { normal 0 0 1 offset 0 } }";
    let folder = Folder::with_scene(&format!("{CAMERA}{lit}"));
    let run = folder.run("-input s.txt -output o.tga -size 2 2").ok();
    assert_eq!((run.stdout.as_str(), run.stderr.as_str()), ("", "WARNING:  No lights specified\n"));
    assert_eq!(folder.tga("o.tga").pixels, [[255, 127, 0]; 4]);
}

#[test]
fn the_preview_is_declined_on_standard_error_once() {
    let folder = Folder::with_scene(&sphere());
    let plain = folder.render("");
    let run = folder.run("-input s.txt -output p.tga -gui -tessellation 10 5 -gouraud").ok();
    assert_eq!(only_line(&run.stderr), "note: this build has no preview; the picture is rendered directly");
    assert_eq!(run.stdout, "");
    assert_eq!(folder.tga("p.tga"), plain);
}

#[test]
fn standard_output_carries_what_was_asked_for() {
    let folder = Folder::with_scene(&sphere());
    let help = folder.run("-help").ok();
    assert!(help.stdout.contains("Usage: raytracer -input scene.txt") && help.stderr.is_empty());
    let version = folder.run("-version").ok();
    assert_eq!(version.stdout, format!("raytracer {}\n", env!("CARGO_PKG_VERSION")));
    let stats = folder.run("-input s.txt -stats").ok();
    assert!(
        stats.stdout.starts_with("********************************************\nRAY TRACING STATISTICS\n")
    );
    assert!(stats.stderr.is_empty());
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn readers_that_went_away_are_no_reason_to_panic() {
    let folder = Folder::with_scene(&sphere());
    for line in ["-help", "-version", "-input s.txt -output o.tga -stats"] {
        let run = finish(folder.command(line).stdout(nobody()));
        assert_eq!((run.status, run.stderr.as_str()), (Some(1), ""), "{line}");
    }
    assert_eq!(folder.names(), ["o.tga", "s.txt"], "the picture is written before the statistics");
    for (line, status) in [("-nonsense", 2), ("-input no-such.txt", 1), ("-input s.txt -gui", 0)] {
        let run = finish(folder.command(line).stderr(nobody()));
        assert_eq!(run.status, Some(status), "{line}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_grid_that_does_not_fit_into_memory_is_one_line() {
    let spanning = "Triangle { vertex0 -1 -1 -1 vertex1 1 -1 1 vertex2 -1 1 1 }\n";
    let folder = Folder::with_scene(&scene(40, &spanning.repeat(40)));
    // The cells alone fit; what stands in them does not, however it is entered.
    for flags in ["-stats", "-output o.tga -visualize_grid"] {
        let line = format!("-input s.txt -grid 300 300 300 -threads 1 {flags}");
        let mut command = std::process::Command::new("sh");
        command.args(["-c", "ulimit -v 180000 && exec \"$@\"", "sh", env!("CARGO_BIN_EXE_raytracer")]);
        let run = finish(command.args(line.split_whitespace()).current_dir(folder.path()));
        let expected = "error: the grid does not fit into memory: use fewer cells";
        assert_eq!(only_line(&run.message(1)), expected, "{flags}");
    }
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn a_picture_may_have_fewer_rows_than_there_are_threads() {
    let folder = Folder::with_scene(&sphere());
    let row = folder.render("-size 9 1 -threads 64");
    assert_eq!(row, folder.render("-size 9 1 -threads 1"));
    assert!(row.at(4, 0) > row.at(0, 0));
}

#[test]
fn a_hundred_thousand_nested_transforms_render() {
    const DEPTH: usize = 100_000;
    let identity = "Transform { Scale 1 1 1 Translate 0 0 0 ";
    let nested = identity.repeat(DEPTH) + "Sphere { center 0 0 0 radius .7 }" + &"}".repeat(DEPTH);
    let picture = Folder::with_scene(&scene(1, &nested)).render("-size 20 20");
    assert_eq!(picture, Folder::with_scene(&sphere()).render("-size 20 20"));
    assert_ne!(picture.at(10, 10), picture.at(0, 0));
}

#[test]
fn planes_alone_render_with_a_grid() {
    let folder = Folder::with_scene(&scene(1, "Plane { normal 0 1 1 offset 0 }"));
    let plain = folder.render("-size 8 8");
    let run = folder.run("-input s.txt -output g.tga -size 8 8 -grid 4 4 4 -stats").ok();
    assert!(run.stdout.contains("\n  scene bounds               NULL\n"), "{}", run.stdout);
    assert_eq!(folder.tga("g.tga"), plain);
    assert!(plain.pixels.iter().all(|&pixel| pixel == [180; 3]), "255 cos 45 degrees");
    let cells = folder.render("-size 8 8 -grid 4 4 4 -visualize_grid");
    assert!(cells.pixels.iter().all(|&pixel| pixel == [127; 3]), "no cell, only background");
}

#[test]
fn an_empty_scene_is_all_background() {
    let text = format!("{CAMERA}Background {{ color .2 .4 1 }} Group {{ numObjects 0 }}");
    let folder = Folder::with_scene(&text);
    for flags in ["", "-grid 2 2 2", "-grid 2 2 2 -visualize_grid", "-uniform_samples 4 -shadows"] {
        let picture = folder.render(&format!("-size 3 2 {flags}"));
        assert_eq!(picture.pixels, [[51, 102, 255]; 6], "{flags}");
    }
    folder.run("-input s.txt -size 3 2 -depth 0 1 d.tga -normals n.tga").ok();
    assert_eq!([folder.tga("d.tga"), folder.tga("n.tga")].map(|p| p.pixels), [[[0; 3]; 6], [[0; 3]; 6]]);
}

/// A camera within a mirroring sphere.
fn hall_of_mirrors(reflective: &str) -> String {
    format!(
        "PerspectiveCamera {{ center .1 .2 .3 direction 0 0 -1 up 0 1 0 angle 90 }}
         Background {{ color 0 0 0 ambientLight 1 1 1 }}
         Lights {{ numLights 1 PointLight {{ position 0 0 0 color 0 0 0 }} }}
         Group {{ numObjects 1 Material {{ diffuseColor .5 .5 .5 reflectiveColor {reflective} }}
           Sphere {{ center 0 0 0 radius 1 }} }}"
    )
}

#[test]
fn a_hall_of_mirrors_ends_by_weight() {
    // Each bounce has .5 times the light; its weight falls by the colour's length .5 sqrt(3).
    let folder = Folder::with_scene(&hall_of_mirrors(".5 .5 .5"));
    let line = "-input s.txt -output o.tga -size 4 4 -shade_back -bounces 2147483647 -weight 1e-6 -stats";
    let run = folder.run(line).ok();
    let bounces = (0..).take_while(|&n| 0.75f64.sqrt().powi(n) > 1e-6).count();
    let rays = format!("\n  num non-shadow rays        {}\n", 16 * bounces);
    assert!(run.stdout.contains(&rays), "{}\nexpected{rays}", run.stdout);
    assert!(folder.tga("o.tga").greys().iter().all(|&grey| grey >= 254), "1/2 + 1/4 + ... = 1");
}

#[test]
fn a_hall_of_perfect_mirrors_ends_by_bounces() {
    let folder = Folder::with_scene(&hall_of_mirrors("1 1 1"));
    let run = folder.run("-input s.txt -size 2 2 -shade_back -bounces 100000 -stats").ok();
    assert!(run.stdout.contains("\n  num non-shadow rays        400004\n"), "{}", run.stdout);
}

/// The rows `y` of a picture from the top, each cut to `columns`.
fn cut(
    picture: &crate::support::Tga,
    columns: std::ops::Range<usize>,
    rows: std::ops::Range<usize>,
) -> Vec<[u8; 3]> {
    rows.flat_map(|y| columns.clone().map(move |x| picture.at(x, y))).collect()
}

#[test]
fn the_longer_side_spans_the_view_and_the_shorter_is_cropped() {
    let perspective =
        sphere().replace(CAMERA, "PerspectiveCamera { center .2 .1 3 direction 0 0 -1 up 0 1 0 angle 30 }");
    for text in [sphere(), perspective] {
        let folder = Folder::with_scene(&text);
        let square = folder.render("-size 20 20");
        let (tall, wide) = (folder.render("-size 8 20"), folder.render("-size 20 8"));
        assert_eq!((tall.width, tall.height, wide.width, wide.height), (8, 20, 20, 8));
        assert_eq!(tall.pixels, cut(&square, 6..14, 0..20));
        assert_eq!(wide.pixels, cut(&square, 0..20, 6..14));
    }
}

/// A wall lit through a sphere of radius 1 along its axis.
fn lit_through_glass() -> Folder {
    Folder::with_scene(
        "PerspectiveCamera { center 3 0 0 direction 1 0 0 up 0 1 0 angle 10 }
         Lights { numLights 1 DirectionalLight { direction 1 0 0 color 1 1 1 } }
         Materials { numMaterials 2 Material { } Material { transparentColor .5 .25 1 } }
         Group { numObjects 2
           MaterialIndex 0 Plane { normal -1 0 0 offset -5 }
           MaterialIndex 1 Sphere { center 0 0 0 radius 1 } }",
    )
}

#[test]
fn transparent_shadows_are_tinted_by_the_way_through() {
    let folder = lit_through_glass();
    assert_eq!(folder.render("-size 1 1").pixels, [[255; 3]]);
    assert_eq!(folder.render("-size 1 1 -no_shadows").pixels, [[255; 3]]);
    assert_eq!(folder.render("-size 1 1 -shadows").pixels, [[0; 3]]);
    // The colour to the power of 2, the length of the way inside.
    let tinted = [[63, 15, 255]];
    assert_eq!(folder.render("-size 1 1 -transparent_shadows").pixels, tinted);
    assert_eq!(folder.render("-size 1 1 -transparent_shadows -shadows -grid 3 3 3").pixels, tinted);
}

/// Malformed scenes with `@` where each is refused.
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

/// The line and column of the mark, counted from 1, and the text without it. A scene that does not start with
/// its camera gets one, where the missing camera is not what the row is about.
fn unmark(marked: &str) -> (String, usize, usize) {
    let has_camera = marked == "@" || marked.contains("Camera {");
    let marked = if has_camera { marked.to_owned() } else { format!("{CAMERA}{marked}") };
    let (before, behind) = marked.split_once('@').expect("every row has a mark");
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
    (format!("{before}{behind}"), line, column)
}

#[test]
fn every_malformed_scene_ends_with_its_place_and_status_1() {
    let folder = Folder::new();
    folder.write("broken.obj", "v 0 0 0\nf 1 2 3\n");
    let mut wrong = String::new();
    for marked in MALFORMED {
        let (text, line, column) = unmark(marked);
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
