//! The causes of a difference: each wrong picture is made in an independent way where there is one, and its cause must
//! be named.

use crate::support::{Folder, Tga, write_picture};
use raytracer::cli::{self, Command};
use raytracer::picture::Picture;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::scene::load;
use raytracer::tools::causes::Original;

/// A little of everything: both kinds of lights, textures, mirrors, glass, transforms, and something behind a light.
pub const SCENE: &str = "
    PerspectiveCamera { center 0 2.5 8 direction 0 -.25 -1 up 0 1 0 angle 40 }
    Background { color .10980392 .3 .5 ambientLight .2 .15 .2 }
    Lights { numLights 2
        PointLight { position .5 3 2 color 2.2 2 1.8 attenuation 1 .2 0 }
        DirectionalLight { direction -1 -1 -.5 color .4 .4 .5 } }
    Materials { numMaterials 5
        Material { diffuseColor .8 .4 .2 specularColor .9 .9 .9 exponent 20 }
        Material { diffuseColor .1 .1 .2 reflectiveColor .7 .7 .7 }
        Material { diffuseColor .1 .1 .1 transparentColor .8 .9 .7 indexOfRefraction 1.5 }
        Material { diffuseColor .9 .9 .9 }
        Checkerboard { materialIndex 0 materialIndex 3 } }
    Group { numObjects 7
        MaterialIndex 4 Plane { normal 0 1 0 offset -.2 }
        MaterialIndex 1 Sphere { center -1.2 .6 0 radius .8 }
        MaterialIndex 2 Sphere { center .8 .4 1.5 radius .6 }
        MaterialIndex 0 Transform { Translate 1.6 .8 -1 ZRotate 30 Scale 1 .4 .6 Sphere { center 0 0 0 radius 1 } }
        MaterialIndex 0 Sphere { center .6 4.5 2 radius .7 }
        MaterialIndex 3 Triangle { vertex0 -2.5 .2 1.5 vertex1 -2.5 1.2 1.5 vertex2 -1.7 .2 1.5 }
        Transform { Translate -.3 .5 2 Group { numObjects 1 MaterialIndex 0
            Transform { YRotate 30 Scale .3 .5 .3 TriangleMesh { obj_file cube.obj } } } } }";

pub const CUBE: &str = include_str!("../../scenes/cube.obj");

pub const FLAGS: &str = "-size 48 36 -shadows -bounces 2";

pub fn folder() -> Folder {
    let folder = Folder::with_scene(SCENE);
    folder.write("cube.obj", CUBE);
    folder
}

/// What stands behind `cause` where `a.png` is compared with the scene's picture.
pub fn cause(folder: &Folder, flags: &str) -> String {
    let run = folder.run(&format!("-input s.txt {flags} -compare a.png")).ok();
    let line = run.stdout.lines().find_map(|line| line.strip_prefix("  cause "));
    line.map_or(String::new(), |line| line.trim_start().to_owned())
}

pub fn equal(words: &str) -> String {
    format!("equals this program's picture {words} (0 pixels differ)")
}

/// Returns true if the words are one of the causes that give exactly the picture.
pub fn is_named(found: &str, words: &str) -> bool {
    let names = found.strip_prefix("equals this program's picture ");
    let names = names.and_then(|names| names.strip_suffix(" (0 pixels differ)"));
    names.is_some_and(|names| names.split(", or ").any(|name| name == words))
}

pub fn write(folder: &Folder, picture: &Picture) {
    write_picture(&folder.path().join("a.png"), picture).unwrap();
}

#[test]
fn some_mistakes_are_named() {
    compare_command_lines(4);
    compare_scenes(4);
}

#[test]
#[ignore = "slow: twenty seconds"]
fn mistakes_are_named_in_every_case() {
    compare_command_lines(1);
    compare_scenes(1);
}

/// Compares with pictures of other command lines, in every `step`th case.
fn compare_command_lines(step: usize) {
    let rows = [
        ("-size 48 36", "-size 48 36 -shadows", "with -shadows"),
        (FLAGS, "-size 48 36 -transparent_shadows -bounces 2", "with -transparent_shadows"),
        (
            "-size 48 36 -transparent_shadows",
            "-size 48 36 -shadows",
            "with -shadows in place of -transparent_shadows",
        ),
        (FLAGS, "-size 48 36 -shadows -bounces 2 -shade_back", "with -shade_back"),
        ("-size 48 36 -shade_back", "-size 48 36", "without -shade_back"),
        (FLAGS, "-size 48 36 -shadows -bounces 1", "with one bounce fewer"),
        (FLAGS, "-size 48 36 -shadows -bounces 3", "with one bounce more"),
        ("-size 48 36 -bounces 2 -weight 1.3", "-size 48 36 -bounces 2", "without -weight"),
        (
            "-size 48 36 -shadows -uniform_samples 4 -tent_filter 1 -grid 5 5 5",
            "-size 48 36 -uniform_samples 4 -tent_filter 1",
            "without -shadows",
        ),
    ];
    let folder = folder();
    for (flags, wrong, words) in rows.into_iter().step_by(step) {
        folder.run(&format!("-input s.txt {wrong} -output a.png")).ok();
        let found = cause(&folder, flags);
        assert!(is_named(&found, words), "{words}: {found}");
    }
}

#[test]
fn depths_and_normals_have_causes() {
    let folder = folder();
    folder.write("turned.txt", SCENE.replace("up 0 1 0", "up 0 -1 0"));
    folder.write("unscaled.txt", SCENE.replace("Scale 1 .4 .6 ", ""));
    for flags in ["-depth 5 12", "-normals"] {
        let line = format!("-size 48 36 {flags} own.png");
        folder.run(&format!("-input turned.txt -size 48 36 {flags} a.png")).ok();
        let words = "by a camera of the other handedness (turned by 180 degrees)";
        assert_eq!(cause(&folder, &line), equal(words), "{flags}");
        folder.run(&format!("-input unscaled.txt -size 48 36 {flags} a.png")).ok();
        assert!(cause(&folder, &line).starts_with("none of "), "{flags}");
    }
}

/// Compares with pictures of other scenes, in every `step`th case.
fn compare_scenes(step: usize) {
    let rows: [(&[[&str; 2]], &str); 10] = [
        (&[["ambientLight .2 .15 .2", ""]], "without ambient light"),
        (&[["color .10980392 .3 .5 a", "color 0 0 0 a"]], "with a black background"),
        (&[["attenuation 1 .2 0", ""]], "with lights that are not attenuated"),
        (&[["direction -1 -1 -.5", "direction 1 1 .5"]], "with directional lights from the other side"),
        (&[["specularColor .9 .9 .9", ""]], "without highlights"),
        (
            &[["indexOfRefraction 1.5", "indexOfRefraction .6666666666666666"]],
            "with the index of refraction inverted",
        ),
        (
            &[["materialIndex 0 materialIndex 3", "materialIndex 3 materialIndex 0"]],
            "with the other parity of checkerboards",
        ),
        (
            &[
                [
                    "Translate 1.6 .8 -1 ZRotate 30 Scale 1 .4 .6",
                    "Scale 1 .4 .6 ZRotate 30 Translate 1.6 .8 -1",
                ],
                ["YRotate 30 Scale .3 .5 .3", "Scale .3 .5 .3 YRotate 30"],
            ],
            "with the transformations of a list multiplied in the other order",
        ),
        (
            &[
                ["Translate -.3 .5 2 G", "YRotate 30 Scale .3 .5 .3 G"],
                ["YRotate 30 Scale .3 .5 .3 T", "Translate -.3 .5 2 T"],
            ],
            "with nested transforms multiplied in the other order",
        ),
        // The longer side spans the tangent of twice the half angle times 48 / 36.
        (&[["angle 40", "angle 51.77400875924256"]], "with the camera's angle or size over the shorter side"),
    ];
    let folder = folder();
    for (edits, words) in rows.into_iter().step_by(step) {
        let edited = edits.iter().fold(SCENE.to_owned(), |text, [from, to]| {
            assert_eq!(text.matches(from).count(), 1, "{from}");
            text.replace(from, to)
        });
        folder.write("wrong.txt", edited);
        folder.run(&format!("-input wrong.txt {FLAGS} -output a.png")).ok();
        let found = cause(&folder, FLAGS);
        assert!(is_named(&found, words), "{words}: {found}");
    }
}

/// In the editions from 2012 on, a texture mixes two colours of one material.
#[test]
fn mistakes_in_the_noise_of_a_later_edition_are_named() {
    let noise = "Noise { color .9 .5 .3 color .1 .2 .6 octaves 3 frequency 4 amplitude 3 }";
    let scene = format!(
        "PerspectiveCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }}
         Lights {{ numLights 1 DirectionalLight {{ direction -.3 -.4 -1 color .9 .9 .9 }} }}
         Background {{ color .1 .2 .3 ambientLight .2 .2 .2 }}
         Materials {{ numMaterials 1 Material {{ shininess 5 {noise} }} }}
         Group {{ numObjects 1 MaterialIndex 0 Sphere {{ center 0 0 0 radius 1 }} }}"
    );
    let folder = Folder::with_scene(&scene);
    for (wrong, words) in [
        (noise.replace("octaves 3", "octaves 2"), "with one octave of noise fewer"),
        (noise.replace("octaves 3", "octaves 1"), "with one octave of noise alone"),
        (
            noise.replace("color .9 .5 .3 color .1 .2 .6", "color .1 .2 .6 color .9 .5 .3"),
            "with the two materials of textures swapped",
        ),
    ] {
        folder.write("wrong.txt", scene.replace(noise, &wrong));
        folder.run("-input wrong.txt -size 40 40 -output a.png").ok();
        let found = cause(&folder, "-size 40 40");
        assert!(is_named(&found, words), "{words}: {found}");
    }
}

#[test]
fn a_correct_picture_in_single_precision_has_no_cause() {
    let folder = folder();
    // 255 times the number is below 28, and 28 in single precision.
    folder.write("single.txt", SCENE.replace("color .10980392", "color .10980393"));
    folder.run(&format!("-input single.txt {FLAGS} -output a.png")).ok();
    let found = cause(&folder, FLAGS);
    assert!(found.starts_with("rounding: ") && found.ends_with(" by one level; nothing to fix"), "{found}");
}

#[test]
fn of_two_mistakes_both_are_named() {
    let folder = folder();
    folder.run("-input s.txt -size 48 36 -bounces 2 -output b.tga").ok();
    let wrong = folder.tga("b.tga");
    write(&folder, &transformed(&wrong, |x, y| wrong.at(x, y).map(|byte| byte.saturating_sub(1))));
    let found = cause(&folder, FLAGS);
    let names = ["without -shadows", " and ", "one level darker everywhere", "(0 pixels differ)"];
    assert!(names.iter().all(|name| found.contains(name)), "{found}");
}

/// Pixels of the true picture, moved or changed here.
pub fn transformed(tga: &Tga, at: impl Fn(usize, usize) -> [u8; 3]) -> Picture {
    let pixels = (0..tga.height).flat_map(|y| (0..tga.width).map(move |x| (x, y)));
    let bytes = pixels.flat_map(|(x, y)| at(x, y)).collect();
    Picture::from_rgb(tga.width as u32, tga.height as u32, bytes)
}

#[test]
fn pixels_that_are_moved_or_changed_are_named() {
    let folder = folder();
    let tga = folder.render(FLAGS);
    let (right, bottom) = (tga.width - 1, tga.height - 1);
    let swapped = |[red, green, blue]: [u8; 3]| [blue, green, red];
    for (picture, words) in [
        (transformed(&tga, |x, y| tga.at(x, bottom - y)), "upside down"),
        (transformed(&tga, |x, y| tga.at(right - x, y)), "mirrored left to right"),
        (transformed(&tga, |x, y| swapped(tga.at(x, y))), "with red and blue swapped"),
    ] {
        write(&folder, &picture);
        let found = cause(&folder, FLAGS);
        assert!(is_named(&found, words), "{words}: {found}");
    }
}

/// The colour picture of a scene by way of the library.
pub fn with_original<T>(folder: &Folder, flags: &str, work: impl FnOnce(&Original) -> T) -> T {
    let loaded = load::load(&folder.path().join("s.txt")).unwrap();
    let renderer = Renderer::new(loaded, Meshes::Kept).unwrap();
    let line = format!("raytracer -input s.txt {flags}");
    let Ok(Command::Render(options)) = cli::parse(line.split_whitespace().map(Into::into)) else {
        panic!("{line}")
    };
    work(&Original::new(&renderer, &options.request()).unwrap())
}
