//! The later editions of the course: their words and flags, and the pictures that their own programs made.
//!
//! `EDITIONS_DIR` names a folder with scenes and pictures of 2012 and 2019, which are not part of this project. Without
//! it the tests of pictures print that they are skipped.

use crate::support::{CAMERA, Folder, finish, program, sphere};
use raytracer::caster::choose::Structure;
use raytracer::image_io::read_picture;
use raytracer::picture::Picture;
use raytracer::render::{Request, Tracing};
use raytracer::renderer::{Meshes, Renderer};
use raytracer::scene::Scene;
use raytracer::scene::model::{FaceWeights, Highlight, MeshNormals, Screen};
use raytracer::scene_io::load;
use raytracer::tools::causes::Original;
use raytracer::trace::{Effects, Shadows};
use std::fs;
use std::path::{Path, PathBuf};

const EYE: &str = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 40 }\n";

/// A white sphere in the language of 2012 and later, with these words in its material, its light and its background.
fn later(material: &str, light: &str, background: &str) -> String {
    format!(
        "{EYE}Background {{ {background} }}\nLights {{ numLights 1 PointLight {{ position 0 0 5 color 1 1 1 {light} }} }}
Materials {{ numMaterials 1 Material {{ {material} }} }}
Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}\n"
    )
}

#[test]
fn a_note_says_which_edition_is_taken_and_why() {
    for (text, flags, edition) in [
        (later("shininess 5", "", ""), "", "2012a4, because of `shininess`"),
        (later("shininess 5", "falloff 1", ""), "", "2019, because of `shininess` with `falloff`"),
        (later("", "falloff 1", ""), "", "2012a5, because of `falloff`"),
        (later("refractionIndex 1.5", "", ""), "", "2012a5, because of `refractionIndex`"),
    ] {
        let run = Folder::with_scene(&text).run(&format!("-input s.txt -output o.tga {flags}")).ok();
        let note =
            format!("note: the scene is taken as one of the edition {edition}; `-edition` names another\n");
        assert_eq!(run.stderr, note, "{text}");
    }
    // Nothing is to be said of what somebody has named, or of a scene of 2004.
    let folder = Folder::with_scene(&later("shininess 5", "", ""));
    assert_eq!(folder.run("-input s.txt -output o.tga -edition 2012a4").ok().stderr, "");
    assert_eq!(Folder::with_scene(&sphere()).run("-input s.txt -output o.tga").ok().stderr, "");
}

#[test]
fn words_of_another_edition_name_it_and_the_flag() {
    let later_word = later("shininess 5 exponent 3", "", "");
    for (text, flags, message) in [
        (
            &later_word,
            "",
            "`shininess` is a word of other editions: `-edition 2012a4`, `-edition 2012a5`, `-edition 2019`",
        ),
        (
            &later_word,
            "-edition 2019",
            "`exponent` is a word of other editions: `-edition 2004`, `-edition aalto`",
        ),
        (
            &format!("{CAMERA}{}", sphere()),
            "-edition 2012a5",
            "`OrthographicCamera` is a word of other editions: ",
        ),
        (
            &later("refractionIndex 2", "falloff 1", ""),
            "-edition 2019",
            "`refractionIndex` is a word of other editions: `-edition 2012a5`",
        ),
        (
            &later("shininess 5 Noize", "", ""),
            "",
            "the scene is read as one of `-edition 2012a4`, because of `shininess`",
        ),
        (
            &later("shininess 5", "", ""),
            "-edition 2019",
            "without `falloff` the light is infinitely bright in the edition 2019",
        ),
    ] {
        let message_found =
            Folder::with_scene(text).run(&format!("-input s.txt -output o.tga {flags}")).message(1);
        assert!(message_found.contains(message), "{message_found}");
    }
}

#[test]
fn flags_of_editions() {
    let folder = Folder::with_scene(&later("", "falloff 1", ""));
    let message = |flags: &str| folder.run(&format!("-input s.txt -output o.tga {flags}")).message(2);
    assert!(
        message("-edition 2005").contains("`2005` is none of the editions 2004, 2012a4, 2012a5, 2019, aalto")
    );
    assert!(
        message("-jitter -edition aalto").contains("`-jitter` is a flag of the edition 2012a5, not of aalto")
    );
    assert!(message("-regular_samples 4 -edition 2004").contains("flag of the edition aalto, not of 2004"));
    assert!(
        message("-filter -size 2 9")
            .contains("`-filter`: a third of the picture's width or height is no pixel")
    );
    let size = |flags: &str| {
        let picture = folder.render(&format!("-size 12 9 {flags}"));
        [picture.width, picture.height]
    };
    assert_eq!(size("-jitter"), [36, 27]);
    assert_eq!(size("-filter"), [4, 3]);
    assert_eq!(size("-jitter -filter"), [12, 9]);
    // The program of 2019 accepts both and does nothing.
    assert_eq!(size("-jitter -filter -edition 2019"), [12, 9]);
    let json = |flags: &str| folder.run(&format!("-input s.txt -size 9 9 -json - {flags}")).ok().stdout;
    assert!(json("").contains("\"edition\":\"2012a5\"") && json("").contains("\"bounces\":4"));
    assert!(json("-bounces 1").contains("\"bounces\":1"));
    assert!(json("-edition 2019").contains("\"bounces\":0"));
}

#[test]
fn aalto_s_samples_and_scenes() {
    let folder = Folder::with_scene(&sphere());
    let bytes = |flags: &str| folder.render(&format!("-size 20 20 {flags}")).pixels;
    assert_eq!(bytes("-edition aalto -uniform_samples 4"), bytes("-random_samples 4"));
    assert_eq!(bytes("-regular_samples 4"), bytes("-uniform_samples 4"));
    assert_ne!(bytes("-regular_samples 4"), bytes("-random_samples 4"));
    folder.write("s.txt", CAMERA);
    assert!(folder.run("-input s.txt -output o.tga").message(1).contains("the scene has no group"));
    assert!(folder.render("-edition aalto -size 3 3").pixels.iter().all(|pixel| *pixel == [127; 3]));
}

/// Two programs of 2012 make another picture of a scene than that of 2004, which reads it too.
#[test]
fn a_scene_of_all_editions_looks_different_in_each() {
    let text = format!(
        "{EYE}Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 -1 color 1 1 1 }} }}
        Materials {{ numMaterials 1 Material {{ diffuseColor .9 .8 .7 }} }}
        Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
    );
    let folder = Folder::with_scene(&text);
    let bytes = |flags: &str| folder.render(&format!("-size 40 20 {flags}")).pixels;
    let stderr = |flags: &str| folder.run(&format!("-input s.txt -size 9 9 {flags}")).ok().stderr;
    let note = "note: the scene is the same text in several editions of the course";
    assert!(stderr("-output o.png").starts_with(note));
    assert_eq!([stderr("-output o.tga"), stderr("-output o.png -edition 2004")], ["", ""]);
    assert_eq!(bytes(""), bytes("-edition 2004"));
    assert_ne!(bytes(""), bytes("-edition 2012a4"));
    assert_eq!(bytes("-edition 2012a4"), bytes("-edition 2012a5"));
}

/// A scene of each edition with a mistake that is common in it, and the mistake.
#[test]
fn mistakes_of_the_editions_are_found() {
    type Change = fn(&mut Scene);
    let cases: [(&str, Change, &str); 5] = [
        (
            "screen_2012a4",
            |scene| scene.model.highlight = Highlight::Blinn,
            "highlights by the half-way vector",
        ),
        ("screen_2012a4", |scene| scene.model.screen = Screen::LongerSide, "which is not stretched"),
        ("mirrors_2019", |scene| scene.model.normals = MeshNormals::Flat, "the normals of the faces"),
        (
            "mirrors_2019",
            |scene| scene.model.normals = MeshNormals::Smooth { weights: FaceWeights::Area, flat_up_to: 0 },
            "other weights of the faces around a vertex",
        ),
        (
            "glass_2012a5",
            |scene| scene.cube_map = scene.cube_map.map(|[a, b, c, d, e, f]| [b, a, d, c, f, e]),
            "cube map swapped",
        ),
    ];
    for (name, change, cause) in cases {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/editions/{name}.txt"));
        let load = || load(&path).unwrap_or_else(|error| panic!("{error}"));
        let effects = Effects { bounces: 2, shadows: Shadows::Opaque, ..Effects::default() };
        let request = Request { effects, ..Request::new([60, 40]) };
        let mut wrong = load();
        change(&mut wrong.scene);
        let render = |loaded| {
            let renderer = Renderer::new(loaded, Meshes::Kept).expect("a scene");
            let prepared =
                renderer.prepare_for(Structure::Any, &request, Tracing::Fast).expect("a structure");
            prepared.render(&request).expect("a picture").remove(0).to_picture()
        };
        let (wrong, right) = (render(wrong), render(load()));
        let renderer = Renderer::new(load(), Meshes::Kept).expect("a scene");
        let original = Original::new(&renderer, Structure::Any, &request).expect("memory");
        let found = original.explain(&wrong, &right).to_string();
        assert!(found.contains(cause), "{name}: {found}");
    }
}

/// The folder of the editions, from `EDITIONS_DIR`.
fn editions() -> Option<PathBuf> {
    let folder = std::env::var_os("EDITIONS_DIR").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: EDITIONS_DIR is not set");
    }
    folder
}

/// A command line of an edition, the picture that its program made, and what is to be the same.
struct Official {
    line: String,
    picture: String,
    /// The share of bytes that are identical, at least.
    identical: f64,
    /// The largest difference, at most.
    levels: u8,
}

fn official(line: String, picture: &str, identical: f64, levels: u8) -> Official {
    Official { line, picture: picture.into(), identical, levels }
}

/// Those of 2019. The scenes' own cube map is not among them, so that colours are compared with a smaller one.
fn of_2019() -> Vec<Official> {
    let mut all = vec![];
    let sizes = [("200 200", "staff200/s", ""), ("800 800", "sample_out/a", "only number")];
    for (size, prefix, number_only) in sizes {
        for name in ["01_plane", "02_cube", "03_sphere", "04_axes"] {
            let scene = format!("-edition 2019 -input scene{name}.txt -size {size}");
            let name = if number_only.is_empty() { name } else { &name[..2] };
            for (layer, flag) in [("", "-output"), ("d", "-depth 8 18"), ("n", "-normals")] {
                // Two pixels of a plane's horizon and of two spheres' outlines are of the sky in the one and not in the other.
                let levels = if layer == "d" && number_only.is_empty() { 1 } else { u8::MAX };
                all.push(official(
                    format!("{scene} {flag} @"),
                    &format!("{prefix}{name}{layer}"),
                    0.9994,
                    levels,
                ));
            }
        }
    }
    for (scene, number) in [("small_06_bunny_1k", "06"), ("small_07_arch", "07")] {
        for (layer, flag) in [("d", "-depth 8 18"), ("n", "-normals")] {
            let line = format!("-edition 2019 -input {scene}.txt -size 800 800 {flag} @");
            all.push(official(line, &format!("sample_out/a{number}{layer}"), 0.9994, 1));
        }
        let line = format!("-edition 2019 -input {scene}.txt -size 200 200 -bounces 4 -output @");
        let line = if number == "07" { format!("{line} -shadows") } else { line };
        all.push(official(line, &format!("staff200/{scene}"), 0.994, 1));
    }
    all.push(official(
        "-edition 2019 -input scene01_plane.txt -size 300 200 -output @".into(),
        "staff200/scene01_300x200",
        0.9994,
        1,
    ));
    all
}

/// Those of assignment 4 of 2012. The textured scenes 8 and 9 are left out, whose ambient light depends on the order of
/// pixels.
fn of_2012a4() -> Vec<Official> {
    let mut all = vec![];
    let names = ["01_plane", "02_cube", "03_sphere", "04_axes", "05_bunny_200", "06_bunny_1k", "07_shine"];
    for (number, name) in (1..).zip(names) {
        let depths = match number {
            5 => "-depth .8 1.0",
            6 => "-depth 3 8",
            _ => "-depth 8 18",
        };
        let scene = format!("-edition 2012a4 -input scene{name}.txt -size 200 200");
        for (layer, flag) in [("", "-output"), ("d", depths), ("n", "-normals")] {
            all.push(official(format!("{scene} {flag} @"), &format!("staff/a4_{number}{layer}"), 0.999, 1));
        }
    }
    for (size, name) in [("300 200", "1w"), ("200 300", "1h")] {
        let line = format!("-edition 2012a4 -input scene01_plane.txt -size {size} -output @");
        all.push(official(line, &format!("staff/a4_{name}"), 0.999, 1));
    }
    all
}

/// Those of assignment 5 of 2012.
fn of_2012a5() -> Vec<Official> {
    let diamond = "-edition 2012a5 -input a5_scene13_diamond.txt -output @";
    let small =
        |name: &str, flags: &str| format!("-edition 2012a5 -input a5_small_{name}.txt -output @ {flags}");
    let four = "-size 100 100 -shadows -bounces 4";
    vec![
        official(format!("{diamond} -size 200 200 -bounces 0"), "staff/a5_13_b0", 0.999, 1),
        official(format!("{diamond} -size 200 200 -bounces 0 -shadows"), "staff/a5_13_b0s", 0.999, 1),
        official(format!("{diamond} -size 200 200 -bounces 1 -shadows"), "staff/a5_13_b1", 0.999, 1),
        official(format!("{diamond} -size 200 200 -shadows"), "staff/a5_13_plain", 0.999, 1),
        official(format!("{diamond} -size 60 60 -shadows -jitter -filter"), "staff/a5_13_60_jf", 0.999, 1),
        official(format!("{diamond} -size 300 300 -shadows -jitter -filter"), "staff/a5_13", 0.999, 1),
        official(small("06_bunny_1k", four), "staff/a5_small_06_bunny_1k", 0.993, 1),
        // Edges are seen through a ball, which magnifies the roundings of the other program's single precision.
        official(small("10_sphere", four), "staff/a5_small_10_sphere", 0.993, u8::MAX),
        official(small("11_cube", four), "staff/a5_small_11_cube", 0.999, 1),
        official(small("12_vase", "-size 60 60 -shadows -bounces 2"), "staff/a5_small_12_vase", 0.999, 1),
        official(
            small("06_bunny_1k", "-size 40 40 -shadows -jitter -filter"),
            "staff/a5_small_06_bunny_1k_jf",
            0.999,
            1,
        ),
        official(
            small("11_cube", "-size 40 40 -shadows -jitter -filter"),
            "staff/a5_small_11_cube_jf",
            0.999,
            1,
        ),
    ]
}

#[test]
fn pictures_of_2019() {
    let Some(folder) = editions() else { return };
    compare(&folder.join("f19"), of_2019());
}

#[test]
fn pictures_of_2012() {
    let Some(folder) = editions() else { return };
    compare(&folder.join("f12"), of_2012a4());
    compare(&folder.join("f12"), of_2012a5());
}

/// Aalto's scenes are those of 2004, with its flags.
#[test]
fn scenes_of_aalto() {
    let Some(folder) = editions() else { return };
    let scenes = folder.join("aalto");
    let entries = fs::read_dir(&scenes).expect("EDITIONS_DIR has aalto");
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    let mut count = 0;
    for path in paths.filter(|path| path.extension().is_some_and(|end| end == "txt")) {
        let to = Folder::new();
        let picture = to.path().join("o.tga");
        let mut run =
            program(&scenes, ["-edition", "aalto", "-size", "20", "20", "-shadows", "-regular_samples", "4"]);
        run.arg("-input").arg(&path).arg("-output").arg(picture);
        finish(&mut run).ok();
        count += 1;
    }
    assert!(count > 0);
}

/// Renders each line in the folder. Pictures that are not there are counted as well, and not all may be missing.
fn compare(folder: &Path, all: Vec<Official>) {
    let to = Folder::new();
    let (mut compared, mut faults) = (0, vec![]);
    for Official { line, picture, identical, levels } in all {
        let expected = folder.join(format!("{picture}.png"));
        if !expected.is_file() {
            continue;
        }
        let own = to.path().join("o.png");
        let line = line.replace('@', &own.to_string_lossy());
        finish(&mut program(folder, line.split_whitespace())).ok();
        let [own, expected] = [own.as_path(), &expected].map(|path| read_picture(path).expect("a picture"));
        let (share, largest) = difference(&own, &expected);
        println!("{picture}: {:.3}% of bytes identical, largest difference {largest}", 100.0 * share);
        if share < identical || largest > levels {
            faults.push(format!("{picture}: {share} {largest}"));
        }
        compared += 1;
    }
    assert!(compared > 0 && faults.is_empty(), "{compared} {faults:?}");
}

/// The share of bytes that are identical, and the largest difference.
fn difference(one: &Picture, other: &Picture) -> (f64, u8) {
    assert_eq!([one.width(), one.height()], [other.width(), other.height()]);
    let differences = || one.pixels().iter().zip(other.pixels()).map(|(a, b)| a.abs_diff(*b));
    let identical = differences().filter(|difference| *difference == 0).count();
    (identical as f64 / one.pixels().len() as f64, differences().max().unwrap_or(0))
}
