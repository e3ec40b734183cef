//! Warnings about valid input that is probably a mistake: each in full, `-strict`, and silence where nothing is wrong.

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

/// Scenes with `@` at the position of a warning, flags, and the message behind the position, line by line
/// without the two lines of the excerpt.
fn located() -> Vec<(String, &'static str, &'static str)> {
    let white = materials("Material { }");
    let light = |light: &str| {
        format!("Lights {{ numLights 2\nDirectionalLight {{ direction 0 0 -1 color 1 1 1 }}\n{light} }}\n")
    };
    vec![
        (format!("{CAMERA}@{}", sphere()), "", "a second camera: it replaces the one in line 1"),
        (
            with(LIGHT, &white, BALL) + "Background { }\n@Background { color 0 0 0 }",
            "",
            "a second `Background`: it replaces the one in line 8",
        ),
        (
            with(&format!("{LIGHT}@{LIGHT}"), &white, BALL),
            "",
            "a second list of lights: it replaces the one in line 2",
        ),
        (
            with(LIGHT, &format!("{white}@{white}"), BALL),
            "",
            "a second list of materials: it replaces the one in line 3",
        ),
        (
            with(LIGHT, &materials("@Material { transparentColor 1 1 1 indexOfRefraction 1.5 }"), BALL),
            "-bounces 3",
            "the material transmits light, but without `-shade_back` it is black from inside\n  \
             hint: add `-shade_back`",
        ),
        (
            with(LIGHT, &materials("Material { diffuseColor @255 128 0 }"), BALL),
            "",
            "`diffuseColor` is above 1, the brightest that a picture shows\n  hint: is it meant as 0 to 255?",
        ),
        (
            with(LIGHT, &materials("Material { diffuseColor @1.5 0 0 specularColor 0 2 0 }"), BALL),
            "",
            "`diffuseColor` is above 1, the brightest that a picture shows; so is another colour",
        ),
        (
            with("Lights { numLights 1 PointLight { position 0 0 9 color @255 255 255 } }\n", &white, BALL),
            "",
            "`color` is above 1, the brightest that a picture shows\n  hint: is it meant as 0 to 255?",
        ),
        (
            scene(2, &format!("{BALL}\n@Triangle {{ vertex0 0 0 0 vertex1 1 1 1 vertex2 2 2 2 }}")),
            "",
            "the triangle has no area\n  hint: no ray hits a triangle whose corners lie on one line",
        ),
        (
            scene(3, &format!("{BALL}\n@{0}\n{0}", "Triangle { vertex0 0 0 0 vertex1 1 1 1 vertex2 2 2 2 }")),
            "",
            "2 triangles have no area; this is the first\n  hint: no ray hits a triangle whose corners lie on one line",
        ),
        (
            scene(1, "TriangleMesh { obj_file @flat.obj }"),
            "",
            "2 of the 3 triangles of the mesh have no area\n  hint: no ray hits a triangle whose corners lie on one line",
        ),
        (
            scene(1, "TriangleMesh { obj_file @bow.obj }"),
            "",
            "in the mesh `bow.obj`: line 5: the outline of the polygon crosses itself (and 1 more)\n  \
             bow.obj:5:1:\n  hint: its triangles are a guess: export the mesh as triangles",
        ),
        (
            scene(1, "TriangleMesh { obj_file @word.obj }"),
            "",
            "in the mesh `word.obj`: line 4: `face` is not a keyword of OBJ; its line is ignored (and 2 more)\n  \
             word.obj:4:1:",
        ),
        (
            scene(1, "TriangleMesh { obj_file @surface.obj }"),
            "",
            "in the mesh `surface.obj`: line 5: a curved surface is ignored\n  surface.obj:5:2:\n  \
             hint: export the mesh as polygons",
        ),
        (
            with(&light("@DirectionalLight { direction 0 0 -1 color 0 0 0 }"), &white, BALL),
            "",
            "the light has no effect: its colour is 0 0 0",
        ),
        (
            with(&light("@PointLight { position 0 0 9 color 1 1 1 attenuation -1 0 0 }"), &white, BALL),
            "",
            "the light has no effect: it is attenuated to nothing at every distance",
        ),
        (
            with(LIGHT, &materials("@Material { diffuseColor .1 .1 .1 transparentColor .9 .9 .9 }"), BALL),
            "-shadows",
            "the material transmits light, but without `-bounces` no ray is followed\n  hint: add `-bounces 5`, or \
             `-bounces 0` if that is meant",
        ),
        (
            with(LIGHT, &materials("@Material { diffuseColor 0 0 0 reflectiveColor 1 1 1 }"), BALL),
            "-jittered_samples 4",
            "the material reflects light, but without `-bounces` no ray is followed\n  hint: add `-bounces 5`, or \
             `-bounces 0` if that is meant",
        ),
        (
            with(
                "Lights { numLights 1 @PointLight { position 0 -1 0 color 1 1 1 } }\n",
                &white,
                "Triangle { \
                  vertex0 -1 -1 0 vertex1 1 -1 0 vertex2 0 1 0 }",
            ),
            "-shadows",
            "the light has no effect: it lies on a surface, which shadows everything from it",
        ),
        (
            format!("@{}", view("PerspectiveCamera { center 0 0 9 direction 0 0 1 up 0 1 0 angle 30 }")),
            "",
            "no ray hits anything: the scene is behind the camera\n  hint: `direction 0 0 -1` looks at the middle of the scene",
        ),
        (
            format!("@{}", view("PerspectiveCamera { center 0 3 9 direction 1 0 -1 up 0 1 0 angle 30 }")),
            "-normals n.png",
            "no ray hits anything: the camera looks away from the scene\n  hint: `direction 0 -0.333 -1` looks at the middle of the scene",
        ),
        (
            format!("@{}", view("OrthographicCamera { center 9 0 0 direction 0 0 -1 up 0 1 0 size 3 }")),
            "-depth 0 20 d.tga",
            "no ray hits anything: the camera looks away from the scene\n  hint: move the camera's `center`",
        ),
        (
            format!("@{}", view("PerspectiveCamera { center 1e3 0 1e5 direction 0 0 -1 up 0 1 0 angle 30 }")),
            "",
            "no ray hits anything: the scene is smaller than a pixel\n  hint: a smaller `angle` or `size` of the camera shows it larger",
        ),
        (
            format!("@{}", view("PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }"))
                .replace(BALL, "Plane { normal 0 0 1 offset 20 }"),
            "-jittered_samples 4",
            "no ray hits anything",
        ),
        (
            format!("@{CAMERA}{LIGHT}Group {{ numObjects 0 }}"),
            "",
            "no ray hits anything: the scene has no objects",
        ),
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

/// A message without its excerpt.
fn without_excerpt(text: &str) -> String {
    let is_excerpt = |line: &&str| {
        let (number, rest) = line.split_once(" |").unwrap_or(("x", ""));
        number.trim().chars().all(|c| c.is_ascii_digit()) && (rest.is_empty() || rest.starts_with(' '))
    };
    text.lines().filter(|line| !is_excerpt(line)).collect::<Vec<_>>().join("\n")
}

#[test]
fn each_warning_has_its_place_and_words() {
    let folder = folder();
    let mut wrong = String::new();
    for (marked, flags, expected) in located() {
        let (text, line, column) = unmark(&marked);
        folder.write("s.txt", &text);
        let run = folder.run(&format!("-input s.txt -edition 2004 -output o.tga -size 9 9 {flags}"));
        let shown = without_excerpt(&run.stderr);
        let wanted = format!("s.txt:{line}:{column}: warning: {expected}");
        if run.status != Some(0) || shown != wanted {
            wrong += &format!("{marked}\n  expected {wanted}\n  actual   {shown}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn warnings_about_flags_are_one_line() {
    let folder = Folder::with_scene(&sphere());
    for (flags, expected) in [
        ("-size 3 3", "warning: nothing is written: add `-output file.tga`\n"),
        (
            "-output o.tga -bounces 3",
            "warning: `-bounces 3` has no effect: no object reflects or transmits light\n",
        ),
        ("-output o.tga -weight 0.01", "warning: `-weight 0.01` has no effect without `-bounces`\n"),
        ("-output o.tga -seed 7", "warning: `-seed 7` has no effect: no samples are random\n"),
        (
            "-output o.tga -uniform_samples 9 -seed 0",
            "warning: `-seed 0` has no effect: no samples are random\n",
        ),
        (
            "-output o.tga -tent_filter 0.7",
            "warning: `-tent_filter 0.7` has no effect: only the sample at the pixel's centre has weight\n",
        ),
        (
            "-output o.tga -gaussian_filter 0.1 -uniform_samples 1",
            "warning: `-gaussian_filter 0.1` has no effect: only the sample at the pixel's centre has weight\n",
        ),
        (
            "-output o.tga -transparent_shadows",
            "warning: `-transparent_shadows` has no effect beyond that of `-shadows`: no object transmits light\n",
        ),
        (
            "-normals n.tga -shadows -bounces 4 -jittered_samples 4",
            "warning: `-shadows`, `-bounces 4`, `-jittered_samples 4` have no effect: no colour picture is rendered\n",
        ),
        (
            "-output o.tga -uniform_samples 4 -tent_filter 0.1",
            "warning: `-tent_filter 0.1` is too narrow: in some pixels no sample has weight, or the weights nearly \
             cancel\n  hint: `-tent_filter 0.354` is wide enough\n",
        ),
    ] {
        assert_eq!(folder.run(&format!("-input s.txt {flags}")).ok().stderr, expected, "{flags}");
    }
}

#[test]
fn rays_that_nothing_lets_through_are_a_warning() {
    let glass = materials("Material { diffuseColor 0 0 0 transparentColor 1 1 1 indexOfRefraction 1.5 }");
    let folder = Folder::with_scene(&with(LIGHT, &glass, BALL));
    let run = |flags: &str| folder.run(&format!("-input s.txt -output o.tga -size 9 9 {flags}")).ok().stderr;
    assert_eq!(
        run("-bounces 5 -weight 2"),
        "warning: `-bounces 5` has no effect: `-weight 2` ends all rays that are reflected or transmitted\n"
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
    for samples in
        ["-uniform_samples 4", "-jittered_samples 6", "-random_samples 2", "-adaptive_samples 16 2"]
    {
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

/// With a filter that is named every pixel of a pattern of 0 and 1 is within half of that range.
#[test]
fn a_filter_whose_weights_cancel_is_named_with_one_whose_do_not() {
    let checkers = "Materials { numMaterials 3 Material { } Material { diffuseColor 0 0 0 }
        Checkerboard { Transform { UniformScale 7 } materialIndex 0 materialIndex 1 } }";
    let camera = "OrthographicCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 size 4 }";
    let folder = Folder::with_scene(&format!(
        "{camera} {LIGHT}{checkers} Group {{ numObjects 1 MaterialIndex 2 Plane {{ normal 0 0 1 offset 0 }} }}"
    ));
    let worst = |flags: &str| {
        let run = folder.run(&format!("-input s.txt -output o.pfm -size 60 60 {flags}")).ok();
        let bytes = folder.read("o.pfm");
        let colors = bytes[bytes.len() - 12 * 3600..].chunks_exact(4);
        let colors = colors.map(|bytes| f32::from_le_bytes(bytes.try_into().expect("four bytes")));
        (run.stderr, colors.map(|x| (x - 0.5).abs()).fold(0.0, f32::max))
    };
    for samples in ["-jittered_samples 4", "-jittered_samples 1", "-random_samples 1", "-random_samples 4"] {
        let (stderr, off) = worst(&format!("{samples} -mitchell_filter 0.8"));
        assert!(off > 1.0 && stderr.contains("is too narrow"), "{off} {stderr}");
        let smallest = named(&stderr).expect("a filter").to_owned();
        let (stderr, off) = worst(&format!("{samples} {smallest} -strict"));
        assert!(off <= 1.0 && stderr.is_empty(), "{samples} {smallest}: {off} {stderr}");
    }
    for flags in ["-uniform_samples 4", "-adaptive_samples 16 2", "-jittered_samples 16"] {
        let (stderr, off) = worst(&format!("{flags} -mitchell_filter 1"));
        assert!(off <= 1.0 && stderr.is_empty(), "{flags}: {off} {stderr}");
    }
}

/// Of warnings of a kind the first 20 are shown, and then their number.
#[test]
fn at_most_twenty_warnings_of_a_kind_are_shown() {
    let black = "DirectionalLight { direction 0 0 -1 color 0 0 0 }\n".repeat(20_000);
    let lights = format!("Lights {{ numLights 20000\n{black} }}\n");
    let blocks = "Background { }\n".repeat(90_000);
    let white = materials("Material { }");
    for (text, shown, more) in [
        (with(&lights, &white, BALL), "the light has no effect", 19_980),
        (blocks + &with(LIGHT, &white, BALL), "a second `Background`", 89_979),
    ] {
        let folder = Folder::with_scene(&text);
        let stderr = folder.run("-input s.txt -output o.tga -size 4 4").ok().stderr;
        assert_eq!(stderr.matches(shown).count(), 20);
        assert!(stderr.ends_with(&format!("\nwarning: {more} more like these\n")), "{stderr}");
        let message = folder.run("-input s.txt -output p.tga -size 4 4 -strict").message(1);
        assert!(message.ends_with(&format!("\nerror: {more} more like these\n")), "{message}");
    }
}

#[test]
fn strict_takes_each_for_an_error_and_writes_nothing() {
    let folder = folder();
    for (marked, flags, _) in located() {
        let (text, line, column) = unmark(&marked);
        folder.write("s.txt", &text);
        let line_of_flags = format!("-input s.txt -edition 2004 -output o.tga -size 9 9 -strict {flags}");
        let message = folder.run(&line_of_flags).message(1);
        assert!(message.starts_with(&format!("s.txt:{line}:{column}: error: ")), "{message}");
        assert_eq!(folder.names(), ["bow.obj", "flat.obj", "s.txt", "surface.obj", "word.obj"], "{marked}");
    }
    folder.write("s.txt", sphere());
    let message = folder.run("-input s.txt -strict").message(1);
    assert_eq!(message, "error: nothing is written: add `-output file.tga`\n");
    folder.write("s.txt", sphere().replace(LIGHT, ""));
    let message = folder.run("-input s.txt -output o.tga -strict").message(1);
    assert_eq!(message, "error: No lights specified\n");
}

#[test]
fn strict_is_silent_where_nothing_is_wrong() {
    let folder = Folder::with_scene(&sphere());
    for flags in ["-output o.tga", "-stats", "-pixel 0 0", "-json -", "-normals n.tga -depth 0 9 d.tga"] {
        let run = folder.run(&format!("-input s.txt -strict {flags}")).ok();
        assert_eq!(run.stderr, "", "{flags}");
    }
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
