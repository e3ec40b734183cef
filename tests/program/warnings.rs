//! Warnings about valid input that is probably a mistake: the place of each, `-strict`, and silence where nothing is wrong.

use crate::support::{CAMERA, Folder, scene, sphere, unmark};

const LIGHT: &str = "Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }\n";
const BALL: &str = "Sphere { center 0 0 0 radius .7 }";

/// The scene of `sphere` with these materials and lights.
fn with(lights: &str, materials: &str, objects: &str) -> String {
    format!("{CAMERA}{lights}{materials}Group {{ numObjects 1\nMaterialIndex 0\n{objects} }}\n")
}

fn materials(all: &str) -> String {
    format!("Materials {{ numMaterials 1\n{all} }}\n")
}

/// Scenes with `@` at the position of their only warning, flags, and whether the warning has a hint.
fn located() -> Vec<(String, &'static str, bool)> {
    let white = materials("Material { }");
    let of_material = |material: &str| with(LIGHT, &materials(material), BALL);
    let lit_by = |light: &str| with(&format!("Lights {{ numLights 1 {light} }}\n"), &white, BALL);
    let lit_by_two = |light: &str| {
        let other = "DirectionalLight { direction 0 0 -1 color 1 1 1 }";
        with(&format!("Lights {{ numLights 2\n{other}\n{light} }}\n"), &white, BALL)
    };
    let mesh = |name: &str| scene(1, &format!("TriangleMesh {{ obj_file @{name}.obj }}"));
    let perspective =
        |view: &str| format!("@{}", self::view(&format!("PerspectiveCamera {{ {view} up 0 1 0 angle 30 }}")));
    let flat = "Triangle { vertex0 0 0 0 vertex1 1 1 1 vertex2 2 2 2 }";
    let beside = "OrthographicCamera { center 9 0 0 direction 0 0 -1 up 0 1 0 size 3 }";
    let plane = "Plane { normal 0 0 1 offset 20 }";
    let facing = "Triangle { vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }";
    let below = "@PointLight { position 0 -1 0 color 1 1 1 }";
    vec![
        (format!("{CAMERA}@{}", sphere()), "", false),
        (with(&format!("{LIGHT}@{LIGHT}"), &white, BALL), "", false),
        (with(LIGHT, &format!("{white}@{white}"), BALL), "", false),
        (of_material("@Material { transparentColor 1 1 1 indexOfRefraction 1.5 }"), "-bounces 3", true),
        (of_material("Material { diffuseColor @255 128 0 }"), "", true),
        (of_material("Material { diffuseColor @1.5 0 0 specularColor 0 2 0 }"), "", false),
        (of_material("@Material { diffuseColor .1 .1 .1 transparentColor .9 .9 .9 }"), "-shadows", true),
        (of_material("@Material { diffuseColor 0 0 0 reflectiveColor 1 1 1 }"), "-jittered_samples 4", true),
        (lit_by("PointLight { position 0 0 9 color @255 255 255 }"), "", true),
        (lit_by_two("@DirectionalLight { direction 0 0 -1 color 0 0 0 }"), "", false),
        (lit_by_two("@PointLight { position 0 0 9 color 1 1 1 attenuation -1 0 0 }"), "", false),
        (lit_by(below).replace(BALL, facing), "-shadows", false),
        (scene(2, &format!("{BALL}\n@{flat}")), "", true),
        (mesh("flat"), "", true),
        (mesh("bow"), "", true),
        (mesh("word"), "", false),
        (mesh("surface"), "", true),
        (perspective("center 0 0 9 direction 0 0 1"), "", true),
        (perspective("center 0 3 9 direction 1 0 -1"), "-normals n.png", true),
        (perspective("center 1e3 0 1e5 direction 0 0 -1"), "", true),
        (perspective("center 0 0 9 direction 0 0 -1").replace(BALL, plane), "-jittered_samples 4", false),
        (format!("@{}", view(beside)), "-depth 0 20 d.tga", true),
        (format!("@{CAMERA}{LIGHT}Group {{ numObjects 0 }}"), "", false),
    ]
}

/// A scene of a white ball that is seen by this camera.
fn view(camera: &str) -> String {
    format!("{camera}\n{}", with(LIGHT, &materials("Material { }"), BALL).replace(CAMERA, ""))
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\nf 3 3 1\n");
    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    folder.write("bow.obj", format!("{SQUARE}f 1 3 2 4\nf 1 2 3 4\nf 2 4 1 3\n"));
    folder.write("word.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nface 1 2 3\nf 1 2 3\nface 1\n  V 1 2 3\n");
    folder.write("surface.obj", format!("{SQUARE} surf 0 1 0 1 1 2 3 4\nf 1 2 3\n"));
    folder
}

#[test]
fn each_warning_has_its_place_and_is_an_error_if_all_are_taken_strictly() {
    let folder = folder();
    for (marked, flags, has_hint) in located() {
        let (text, line, column) = unmark(&marked);
        folder.write("s.txt", &text);
        let line_of_flags = format!("-input s.txt -edition 2004 -output o.tga -size 9 9 {flags}");
        let said = folder.run(&format!("{line_of_flags} -strict")).message(1);
        assert!(said.starts_with(&format!("s.txt:{line}:{column}: error: ")), "{said}");
        assert_eq!(folder.names(), ["bow.obj", "flat.obj", "s.txt", "surface.obj", "word.obj"], "{marked}");
        let said = folder.run(&line_of_flags).ok().stderr;
        assert!(said.starts_with(&format!("s.txt:{line}:{column}: warning: ")), "{said}");
        assert_eq!(said.matches("warning: ").count(), 1, "{said}");
        assert_eq!(said.contains("\n  hint: "), has_hint, "{said}");
        for name in ["o.tga", "n.png", "d.tga"] {
            let _ = std::fs::remove_file(folder.path().join(name));
        }
    }
}

#[test]
fn warnings_about_flags_name_them() {
    let folder = Folder::with_scene(&sphere());
    for (flags, named) in [
        ("-size 3 3", "nothing is written: add `-output file.tga`\n"),
        ("-output o.tga -bounces 3", "`-bounces 3` has no effect"),
        ("-output o.tga -weight 0.01", "`-weight 0.01` has no effect"),
        ("-output o.tga -uniform_samples 9 -seed 0", "`-seed 0` has no effect"),
        ("-output o.tga -tent_filter 0.7", "`-tent_filter 0.7` has no effect"),
        ("-output o.tga -gaussian_filter 0.1 -uniform_samples 1", "`-gaussian_filter 0.1` has no effect"),
        ("-output o.tga -transparent_shadows", "`-transparent_shadows` has no effect"),
        (
            "-normals n.tga -shadows -bounces 4 -jittered_samples 4",
            "`-shadows`, `-bounces 4`, `-jittered_samples 4` have no effect",
        ),
    ] {
        let said = folder.run(&format!("-input s.txt {flags}")).ok().stderr;
        assert!(said.starts_with(&format!("warning: {named}")) && said.lines().count() == 1, "{said}");
    }
}

#[test]
fn rays_that_nothing_lets_through_are_a_warning() {
    let glass = materials("Material { diffuseColor 0 0 0 transparentColor 1 1 1 indexOfRefraction 1.5 }");
    let folder = Folder::with_scene(&with(LIGHT, &glass, BALL));
    let run = |flags: &str| folder.run(&format!("-input s.txt -output o.tga -size 9 9 {flags}")).ok().stderr;
    assert!(
        run("-bounces 5 -weight 2").starts_with("warning: `-bounces 5` has no effect: `-weight 2` ends all")
    );
    // Whoever says 0 means it.
    for flags in
        ["-bounces 5 -weight 0.01 -shade_back", "-bounces 0", "-bounces 0 -weight 0.01 -transparent_shadows"]
    {
        assert_eq!(run(flags), "", "{flags}");
    }
}

/// The smallest filter that the hint of a warning names.
fn named(stderr: &str) -> Option<&str> {
    Some(stderr.split_once("hint: `")?.1.split_once('`')?.0)
}

#[test]
fn the_smallest_filter_that_is_named_loses_no_pixel_and_a_smaller_one_warns() {
    let folder = Folder::with_scene(&scene(1, "Plane { normal 0 0 1 offset 0 }"));
    let run =
        |flags: &str| folder.run(&format!("-input s.txt -output o.tga -size 40 30 {flags}")).ok().stderr;
    // The tests of the warning try more of them.
    for samples in ["-uniform_samples 4", "-jittered_samples 6", "-adaptive_samples 16 2"] {
        for filter in ["-box_filter", "-tent_filter", "-mitchell_filter", "-gaussian_filter"] {
            let narrow = if filter == "-gaussian_filter" { "0.001" } else { "0.02" };
            let warning = run(&format!("{samples} {filter} {narrow}"));
            let smallest = named(&warning).unwrap_or_else(|| panic!("{samples} {filter}: {warning}"));
            assert!(folder.tga("o.tga").pixels.contains(&[0; 3]), "{samples} {filter}");
            assert_eq!(run(&format!("{samples} {smallest} -strict")), "", "{samples}");
            assert!(
                folder.tga("o.tga").pixels.iter().all(|&pixel| pixel == [255; 3]),
                "{samples} {smallest}"
            );
            let size: f64 = smallest.split_once(' ').expect("a size").1.parse().expect("a number");
            let less = run(&format!("{samples} {filter} {}", size - 0.001));
            assert!(less.contains("is too narrow"), "{samples} {less}");
        }
    }
}

/// Of warnings of a kind the first 20 are shown, and then their number.
#[test]
fn at_most_twenty_warnings_of_a_kind_are_shown() {
    let folder = Folder::with_scene(&("Background { }\n".repeat(90_000) + &sphere()));
    let stderr = folder.run("-input s.txt -output o.tga -size 4 4").ok().stderr;
    assert_eq!(stderr.matches("a second `Background`").count(), 20);
    assert!(stderr.ends_with("\nwarning: 89979 more like these\n"), "{stderr}");
    let message = folder.run("-input s.txt -output p.tga -size 4 4 -strict").message(1);
    assert!(message.ends_with("\nerror: 89979 more like these\n"), "{message}");
}

#[test]
fn strict_takes_what_flags_and_lights_lack_for_an_error() {
    let folder = Folder::with_scene(&sphere());
    assert!(folder.run("-input s.txt -strict").message(1).contains("error: nothing is written"));
    folder.write("s.txt", sphere().replace(LIGHT, ""));
    assert!(
        folder.run("-input s.txt -output o.tga -strict").message(1).contains("error: No lights specified")
    );
    assert_eq!(folder.names(), ["s.txt"]);
}

#[test]
fn what_is_meant_is_no_warning() {
    let folder = folder();
    let white = materials("Material { }");
    let glass = "Material { diffuseColor 0 0 0 transparentColor 1 1 1 indexOfRefraction 1.5 }";
    let point = |rest: &str| format!("Lights {{ numLights 1 PointLight {{ position 0 0 {rest} }} }}\n");
    for (text, flags) in [
        // A bright light that is not written in bytes.
        (with(&point("30 color 2 2 2"), &white, BALL), ""),
        // No ray comes into the glass, or out of it.
        (with(LIGHT, &materials(glass), BALL), "-bounces 0"),
        // Beside the picture's edge, in part of it, or as a picture of samples.
        (view("OrthographicCamera { center .95 0 0 direction 0 0 -1 up 0 1 0 size 1 }"), ""),
        (view("OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 9 }"), "-region 0 0 2 2"),
        // White before white.
        (with(LIGHT, &white, BALL) + "Background { color 1 1 1 ambientLight 1 1 1 }", ""),
    ] {
        folder.write("s.txt", &text);
        let run = folder.run(&format!("-input s.txt -output o.tga -size 9 9 {flags}")).ok();
        assert_eq!(run.stderr, "", "{text} {flags}");
    }
}

#[test]
fn the_project_s_own_scenes_are_silent() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let commands = std::fs::read_to_string(root.join("reference_images/commands.txt")).expect("commands");
    let mut scenes: Vec<&str> = commands.split_whitespace().filter(|word| word.ends_with(".txt")).collect();
    scenes.sort_unstable();
    scenes.dedup();
    assert!(scenes.len() > 15, "{scenes:?}");
    let folder = Folder::new();
    for scene in scenes {
        let path = root.join("scenes").join(scene);
        let path = if path.is_file() { path } else { root.join(scene) };
        // What a mirror shows depends on the bounces.
        let flags = ["-output", "o.tga", "-bounces", "0"].map(Into::into);
        let line = ["-input".into(), path.into_os_string()].into_iter().chain(flags);
        let run = crate::support::finish(&mut crate::support::program(folder.path(), line)).ok();
        // The first assignment has no lights, and later editions are told by their words.
        let is_expected = |line: &str| {
            line == "WARNING:  No lights specified" || line.starts_with("note: the scene is read as edition")
        };
        assert!(run.stderr.lines().all(is_expected), "{scene}: {}", run.stderr);
    }
}
