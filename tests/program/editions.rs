//! The later editions of the course: their words and flags, and the pictures that their own programs made.
//!
//! `EDITIONS_DIR` names a folder with scenes and pictures of 2012 and 2019, which are not part of this project. Without
//! it the tests of pictures print that they are skipped.

use crate::support::{CAMERA, Folder, finish, program, says, sphere};
use raytracer::caster::choose::Structure;
use raytracer::image_io::read_picture;
use raytracer::picture::Picture;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Layer, Request};
use raytracer::scene::load::load;
use raytracer::scene::material::Material;
use raytracer::scene::model::{FaceWeights, Highlight, MeshNormals, Screen};
use raytracer::scene::{Light, Scene};
use raytracer::tools::causes::{Mistake, Original};
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
    for (text, edition) in [
        (later("shininess 5", "", ""), "2012a4, because of `shininess`"),
        (later("shininess 5", "falloff 1", ""), "2019, because of `shininess` with `falloff`"),
        (
            later("shininess 5 refractionIndex 1.5", "", ""),
            "2012a5, because of `shininess`, and `refractionIndex`",
        ),
        (later("refractionIndex 1.5", "", ""), "2012a5, because of `refractionIndex`"),
        // Without `falloff` a point light of 2019 would be infinitely bright.
        (later("bump none.bmp", "", ""), "2012a5, because of `bump`"),
    ] {
        let note =
            format!("note: the scene is taken as one of the edition {edition}; `-edition` names another\n");
        // The pictures tell nothing.
        for picture in ["o.tga", "o.png", "o.bmp"] {
            let run = Folder::with_scene(&text).run(&format!("-input s.txt -output {picture}")).ok();
            assert_eq!(run.stderr, note, "{text}");
        }
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
            &later("shininess 5 exponent 3", "falloff 1", ""),
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
    assert!(says(&message("-edition 2005"), "'2005' ... -edition ... 2004, 2012a4, 2012a5, 2019, aalto"));
    assert!(
        message("-jitter -edition aalto").contains("-jitter is a flag of the edition 2012a5, not of aalto")
    );
    assert!(message("-regular_samples 4 -edition 2004").contains("flag of the edition aalto, not of 2004"));
    assert!(
        message("-filter -size 2 9")
            .contains("-filter: a third of the picture's width or height is no pixel")
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
}

/// Without a group, or with `-uv`, a picture of Aalto's program shows where its pixels are.
#[test]
fn aalto_s_places_of_pixels() {
    let folder = Folder::with_scene(&sphere());
    let places = folder.render("-uv -size 4 2");
    let levels = |at: usize, count: usize| (255 * at / count) as u8;
    let expected: Vec<_> = (0..8).map(|index| [levels(index % 4, 4), levels(index / 4, 2), 255]).collect();
    assert_eq!(places.pixels, expected);
    // Samples and structures change nothing.
    for flags in ["-edition aalto", "-regular_samples 4", "-shadows -grid 3 3 3", "-stats"] {
        assert_eq!(folder.render(&format!("-uv -size 4 2 {flags}")).pixels, expected, "{flags}");
    }
    // Depths and normals are those of the scene.
    let normals = |flags: &str| {
        folder.run(&format!("-input s.txt -size 9 9 -normals n.tga {flags}")).ok();
        folder.read("n.tga")
    };
    assert!(normals("-uv") == normals(""));
    let message = |flags: &str| folder.run(&format!("-input s.txt -output o.tga {flags}")).message(2);
    assert!(message("-uv -edition 2004").contains("-uv is a flag of the edition aalto, not of 2004"));
    assert!(message("-uv -pixel 1 1").contains("cannot be used with '-pixel"));
    folder.write("s.txt", CAMERA);
    let run = folder.run("-edition aalto -input s.txt -size 4 2 -output o.tga").ok();
    assert_eq!(run.stderr, "WARNING:  No lights specified\n");
    assert_eq!(folder.tga("o.tga").pixels, expected);
}

/// Aalto's program reads textures, and shows the diffuse colour.
#[test]
fn aalto_s_textures_are_read() {
    let scene = |material: &str, coordinates: [&str; 3]| {
        let [a, b, c] = coordinates;
        format!(
            "{CAMERA}Materials {{ numMaterials 1 Material {{ diffuseColor .5 .6 .7 {material} }} }}
            Group {{ numObjects 1 MaterialIndex 0
            Triangle {{ {a} vertex0 -1 -1 0 {b} vertex1 1 -1 0 {c} vertex2 0 1 0 }} }}"
        )
    };
    let plain = scene("", [""; 3]);
    let textured =
        scene("texture none.tga mipmap linearInterpolation", ["textCoord0 0 0", "", "textCoord2 .5 1"]);
    let bytes = |text: &str| Folder::with_scene(text).render("-size 9 9 -edition aalto").pixels;
    assert_eq!(bytes(&textured), bytes(&plain));
    for (text, word) in [(&scene("mipmap", [""; 3]), "mipmap"), (&textured, "texture")] {
        let message = Folder::with_scene(text).run("-input s.txt -output o.tga").message(1);
        assert!(message.contains(&format!("`{word}` is a word of other editions: ")), "{message}");
        assert!(message.contains("`-edition aalto`"), "{message}");
    }
}

/// The cells of 2003 are those whose centre lies in the sphere.
#[test]
fn cells_of_2003_are_boxes_without_walls_between_them() {
    let looking = "PerspectiveCamera { center 3 4 6 direction -3 -4 -6 up 0 1 0 angle 40 }
        Lights { numLights 1 PointLight { position 4 5 3 color 1 1 1 } }
        Materials { numMaterials 1 Material { diffuseColor .8 .6 .4 specularColor .3 .3 .3 exponent 8 } }\n";
    let scene = |count: usize, objects: &str| {
        format!("{looking}Group {{ numObjects {count} MaterialIndex 0 {objects} }}")
    };
    let cells = "Grid { min -1.5 -1.5 -1.5 max 1.5 1.5 1.5 numCells 3 3 3
        rasterizeSphere { center 0 0 0 radius 1 } }";
    let boxes = "Box { min -1.5 -.5 -.5 max 1.5 .5 .5 } Box { min -.5 -1.5 -.5 max .5 1.5 .5 }
        Box { min -.5 -.5 -1.5 max .5 .5 1.5 }";
    let turned = |count: usize, objects: &str| {
        format!("Transform {{ YRotate 20 Group {{ numObjects {count} {objects} }} }}")
    };
    let pictures = |text: &str| {
        let folder = Folder::with_scene(text);
        let flags = "-size 40 30 -shadows -normals n.tga -depth 5 10 d.tga";
        folder.run(&format!("-input s.txt -output o.tga {flags}")).ok();
        ["o.tga", "d.tga", "n.tga"].map(|name| folder.read(name))
    };
    assert!(pictures(&scene(1, cells)) == pictures(&scene(3, boxes)));
    // The normals of turned faces are rounded by their corners.
    let [cells_turned, boxes_turned] =
        [turned(1, cells), turned(3, boxes)].map(|objects| pictures(&scene(1, &objects)));
    assert!(cells_turned[..2] == boxes_turned[..2]);
    let folder = Folder::with_scene(&scene(1, cells));
    let seen = |flags: &str| folder.render(&format!("-size 40 30 {flags}")).pixels;
    let counted = seen("-grid 4 4 4 -visualize_grid_count");
    assert_eq!(counted, seen("-grid 4 4 4 -visualize_grid"));
    assert_ne!(counted, seen(""));
    // An object of no cell is nothing.
    let empty = scene(1, &cells.replace("radius 1", "radius 1e-3").replace("3 3 3", "2 2 2"));
    let run = Folder::with_scene(&empty).run("-input s.txt -output o.tga").ok();
    assert!(run.stderr.contains("no ray hits anything"), "{}", run.stderr);
}

#[test]
fn statistics_name_another_edition_than_that_of_2004() {
    let named = |text: &str, flags: &str| {
        let stdout = Folder::with_scene(text).run(&format!("-input s.txt -stats {flags}")).ok().stdout;
        stdout.lines().find(|line| line.contains("edition")).map(str::to_owned)
    };
    let later = later("", "falloff 1", "");
    assert_eq!(named(&later, ""), Some("  edition                    2012a5".into()));
    assert_eq!(named(&later, "-edition 2019"), Some("  edition                    2019".into()));
    assert_eq!(named(&sphere(), "-edition aalto"), Some("  edition                    aalto".into()));
    assert_eq!([named(&sphere(), ""), named(&sphere(), "-edition 2004")], [None, None]);
}

#[test]
fn help_tells_the_defaults_of_editions() {
    let help = |flag: &str| {
        let text = Folder::new().run(&format!("-help {flag}")).ok().stdout;
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert!(help("bounces").contains("Default: 0; in the edition 2012a5, 4."));
    assert!(help("weight").contains("Default: 0; in Aalto's edition, 0.1."));
}

/// Warnings know what the edition's pictures mean.
#[test]
fn warnings_of_editions() {
    let warned =
        |text: &str, flags: &str| Folder::with_scene(text).run(&format!("-input s.txt {flags}")).ok().stderr;
    // The colour of a pixel without a normal is grey in 2019.
    let away = later("shininess 5", "falloff 1", "").replace("direction 0 0 -1", "direction 0 0 1");
    let behind = "no ray hits anything: the scene is behind the camera";
    for flags in
        ["-edition 2019 -output o.tga", "-edition 2019 -normals n.tga", "-edition 2012a5 -output o.tga"]
    {
        let stderr = warned(&away, flags);
        assert!(stderr.contains(behind), "{flags}: {stderr}");
    }
    // Between the columns, and not higher than a pixel of a picture that is stretched.
    let narrow = format!(
        "{EYE}Materials {{ numMaterials 1 Material {{ }} }} Group {{ numObjects 1 MaterialIndex 0
        Triangle {{ vertex0 -.02 -.1 0 vertex1 .02 -.1 0 vertex2 0 .1 0 }} }}"
    );
    let small = "no ray hits anything: the scene is smaller than a pixel";
    assert!(warned(&narrow, "-edition 2012a4 -size 30 10 -output o.tga").contains(small));
    assert!(!warned(&narrow, "-edition 2004 -size 30 10 -output o.tga").contains(small));
    let both = "`-shade_back` has no effect in this edition: surfaces look the same from both sides";
    let shiny = later("shininess 5", "", "");
    assert!(warned(&shiny, "-edition 2012a4 -shade_back -output o.tga").contains(both));
    assert!(!warned(&sphere(), "-edition aalto -shade_back -output o.tga").contains("-shade_back"));
    // A default is no flag, and flags have the names that they have in the edition.
    let unseen = |flags: &str| warned(&sphere(), &format!("-normals n.tga -edition aalto {flags}"));
    assert_eq!(unseen(""), "");
    assert_eq!(
        unseen("-uniform_samples 4"),
        "warning: `-uniform_samples 4` has no effect: no picture of colours is asked for\n"
    );
    assert_eq!(
        unseen("-regular_samples 4 -weight 0"),
        "warning: `-weight 0`, `-regular_samples 4` have no effect: no picture of colours is asked for\n"
    );
}

/// The commands of a report are read in the edition that was measured.
#[test]
fn a_report_has_the_flags_of_its_edition() {
    let text = sphere();
    let folder = Folder::with_scene(&text);
    folder.run("-edition aalto -input s.txt -size 4 3 -uniform_samples 4 -error_report r").ok();
    let page = String::from_utf8(folder.read("r/report.html")).expect("text");
    assert!(page.contains("-edition aalto -uniform_samples 4 -box_filter 0.5"), "{page}");
    let table = String::from_utf8(folder.read("r/report.csv")).expect("text");
    assert!(table.contains("-regular_samples 16") && !table.contains("-random_samples"), "{table}");
}

/// Where the words of a scene leave open which later edition is meant, a warning names the flags.
#[test]
fn words_that_leave_the_edition_open_are_a_warning_with_the_flags() {
    let sun = |text: &str| text.replace("PointLight { position 0 0 5", "DirectionalLight { direction 0 0 -1");
    for (text, edition, flags) in [
        (sun(&later("shininess 5", "", "")), "2012a4, but `shininess`", "2012a4`, or `-edition 2019`"),
        (sun(&later("bump none.bmp", "", "")), "2012a5, but `bump`", "2012a5`, or `-edition 2019`"),
        (later("", "falloff 1", ""), "2012a5, but `falloff`", "2012a5`, or `-edition 2019`"),
    ] {
        let folder = Folder::with_scene(&text);
        for picture in ["-output o.tga", "-output o.png", "-normals o.bmp", "-stats"] {
            let stderr = folder.run(&format!("-input s.txt -size 9 9 {picture}")).ok().stderr;
            let warning = format!(
                "warning: the scene is taken as one of the edition {edition} may be of others
  hint: add `-edition {flags} for another picture\n"
            );
            assert_eq!(stderr, warning);
            let message = folder.run(&format!("-input s.txt -size 9 9 {picture} -strict")).message(1);
            assert!(message.starts_with(warning.replace("warning", "error").trim_end()), "{message}");
            let named = folder.run(&format!("-input s.txt -size 9 9 {picture} -edition 2012a5")).ok();
            assert_eq!(named.stderr, "");
        }
    }
}

/// A scene that 2004 reads is one of 2004, whatever later editions would make of it and whatever is written.
#[test]
fn scenes_of_2004_are_not_doubted() {
    let scene = |material: &str, object: &str| {
        format!(
            "{EYE}Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 -1 color 1 1 1 }} }}
            Materials {{ numMaterials 1 Material {{ {material} }} }}
            Group {{ numObjects 1 MaterialIndex 0 {object} }}"
        )
    };
    let ball = "Sphere { center 0 0 0 radius 1 }";
    for (text, flags) in [
        (scene("diffuseColor .9 .8 .7", ball), "-output o.tga"),
        (scene("diffuseColor .9 .8 .7", ball), "-output o.png -normals o.bmp"),
        (scene("diffuseColor .9 .8 .7", ball), "-stats"),
        (scene("exponent 5", ball), "-output o.png"),
        (scene("", "Box { min -1 -1 -1 max 1 1 1 }"), "-output o.png"),
        (sphere(), "-output o.png"),
    ] {
        let stderr = Folder::with_scene(&text).run(&format!("-input s.txt -size 9 9 {flags}")).ok().stderr;
        assert_eq!(stderr, "", "{text} {flags}");
    }
}

/// A text that ended no edition's reading: its block is another one's.
#[test]
fn a_block_of_another_edition_ends_reading() {
    let folder = Folder::with_scene("OrthographicCamera {");
    for flags in ["-edition 2019", "-edition 2012a4", "-edition 2012a5", "-jitter", "-filter"] {
        let message = folder.run(&format!("-input s.txt -output o.tga {flags}")).message(1);
        assert!(message.starts_with("s.txt:1:1: error: expected a camera, `Background`"), "{message}");
        assert!(
            message.ends_with("is a word of other editions: `-edition 2004`, `-edition aalto`\n"),
            "{message}"
        );
    }
}

/// No message suggests a word that the edition does not have.
#[test]
fn messages_suggest_words_of_the_edition_only() {
    for (text, edition, lacks) in [
        (later("", "falloff 1", ""), "2012a4", "attenuation"),
        (later("", "colour 1 1 1", ""), "2012a4", "attenuation"),
        (later("", "attenuatoin 1 0 0", "").replacen("falloff", "", 1), "2012a4", "`attenuation`"),
        ("Camera { }".into(), "2019", "Orthographic"),
        ("OrthographicCamra { }".into(), "2012a5", "`OrthographicCamera`"),
        (later("", "", "cubemap tex"), "2012a4", "`cubeMap`"),
        (later("exponant 3", "falloff 1", ""), "2019", "`exponent`"),
        (later("shinines 3", "", ""), "2004", "`shininess`"),
    ] {
        let line = format!("-input s.txt -output o.tga -edition {edition}");
        let message = Folder::with_scene(&text).run(&line).message(1);
        let said = message.lines().filter(|line| !line.contains('|')).collect::<String>();
        assert!(!said.contains(lacks), "{message}");
    }
    let aalto = Folder::with_scene(&sphere()).run("-input s.txt -output o.tga -specular_fix").ok();
    assert_eq!(aalto.stderr, "");
}

/// A square with texture coordinates, and a texture of one colour.
fn textured() -> Folder {
    let folder = Folder::new();
    folder.write(
        "square.obj",
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n",
    );
    folder.write("green.ppm", [&b"P6\n2 2\n255\n"[..], &[0, 255, 0].repeat(4)].concat());
    folder
}

/// In the program of 2012a5 a noise takes the place of the texture's colour, in whichever order they stand.
#[test]
fn a_noise_wins_over_a_texture() {
    let folder = textured();
    let noise = "Noise { color 1 0 0 color 0 0 1 octaves 2 frequency 3 amplitude 1 }";
    for object in ["TriangleMesh { obj_file square.obj }", "Sphere { center 0 0 0 radius 1 }"] {
        let picture = |material: &str| {
            let scene = later(material, "falloff 0", "ambientLight .1 .1 .1");
            folder.write("s.txt", scene.replace("Sphere { center 0 0 0 radius 1 }", object));
            folder.render("-size 20 20 -edition 2012a5")
        };
        let expected = picture(noise);
        assert_eq!(picture(&format!("texture green.ppm {noise}")), expected);
        assert_eq!(picture(&format!("{noise} texture green.ppm")), expected);
        assert_ne!(picture("texture green.ppm"), expected);
    }
}

/// Ambient light is reflected by the texture's colour in assignment 4 of 2012, and by the diffuse colour in assignment 5.
#[test]
fn ambient_light_on_a_texture() {
    let folder = textured();
    let scene = later("diffuseColor 1 0 .2 texture green.ppm", "", "color 0 0 0 ambientLight .5 .5 .5");
    let mesh = "TriangleMesh { obj_file square.obj }";
    let scene = scene.replace("color 1 1 1", "color 0 0 0").replace("Sphere { center 0 0 0 radius 1 }", mesh);
    folder.write("s.txt", scene);
    let centre = |edition: &str| folder.render(&format!("-size 9 9 -edition {edition}")).at(4, 4);
    assert_eq!([centre("2012a4"), centre("2012a5")], [[0, 127, 0], [127, 0, 25]]);
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
    assert_eq!([stderr("-output o.tga"), stderr("-output o.png -edition 2004")], ["", ""]);
    assert_eq!(bytes(""), bytes("-edition 2004"));
    assert_ne!(bytes(""), bytes("-edition 2012a4"));
    assert_eq!(bytes("-edition 2012a4"), bytes("-edition 2012a5"));
}

/// What `-pixel` says is said in the language of the scene.
#[test]
fn the_words_of_a_pixel_are_those_of_its_edition() {
    let pixel = |name: &str, flags: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/editions").join(name);
        let mut run = program(Path::new("."), flags.split_whitespace());
        run.arg("-input").arg(path);
        finish(&mut run).ok().stdout
    };
    for (name, flags, said) in [
        (
            "screen_2012a4.txt",
            "-size 60 40 -pixel 15 20",
            "156862751) of the texture tiles.bmp, specular (0.6, 0.6, 0.6) with shininess 30\n",
        ),
        ("screen_2012a4.txt", "-size 60 40 -pixel 15 20", "no refracted ray: the material is opaque\n"),
        (
            "glass_2012a5.txt",
            "-size 60 40 -pixel 22 18",
            "diffuse (0.05, 0.05, 0.05), specular (0.9, 0.9, 0.9) with index of refraction 1.5\n",
        ),
        (
            "glass_2012a5.txt",
            "-size 60 40 -pixel 32 20",
            "0647727153) of the noise, specular (0.1, 0.1, 0.1)\n",
        ),
        ("mirrors_2019.txt", "-size 60 40 -pixel 0 0", "sees nothing but the face back of the cube map\n"),
        ("mirrors_2019.txt", "-size 60 40 -pixel 20 38 -bounces 1", "no reflected ray: no specular colour\n"),
        // The picture has three times the width and height.
        ("glass_2012a5.txt", "-size 20 20 -jitter -pixel 59 59", "PIXEL (59, 59)"),
    ] {
        let text = pixel(name, flags);
        assert!(text.contains(said), "{name} {flags}\n{text}");
        assert!(!text.contains("reflective colour") && !text.contains("transparent"), "{text}");
    }
    // By the law of the later editions a surface that faces away from the light has a highlight, too.
    let behind = later("diffuseColor .5 .5 .5 specularColor .6 .6 .6 shininess 0", "", "");
    let folder = Folder::with_scene(&behind.replace("position 0 0 5", "position 0 0 -5"));
    let text = folder.run("-input s.txt -size 9 9 -pixel 4 4").ok().stdout;
    assert!(text.contains("light 0: diffuse (0, 0, 0), specular (0.6, 0.6, 0.6), cosine -1\n"), "{text}");
}

fn with_constant(light: &mut Light, constant: f64) {
    if let Light::Point { attenuation, .. } = light {
        attenuation[0] = constant;
    }
}

fn with_highlights(material: &mut Material) {
    if let Material::Phong(phong) | Material::Painted(phong, _) = material {
        phong.specular = phong.reflective;
    }
}

/// A scene of each edition with a mistake that is common in it, and the mistake.
#[test]
fn mistakes_of_the_editions_are_found() {
    type Change = fn(&mut Scene);
    let cases: [(&str, Change, &str); 10] = [
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
            "all opposite faces of the cube map swapped",
        ),
        (
            "glass_2012a5",
            |scene| scene.cube_map = scene.cube_map.map(|[a, b, c, d, e, f]| [a, b, c, d, f, e]),
            "the faces front and back of the cube map swapped",
        ),
        (
            "mirrors_2019",
            |scene| scene.lights.iter_mut().for_each(|light| with_constant(light, 1.0)),
            "1 + falloff d^2 instead of falloff d^2",
        ),
        (
            "glass_2012a5",
            |scene| scene.lights.iter_mut().for_each(|light| with_constant(light, 0.0)),
            "falloff d^2 instead of 1 + falloff d^2",
        ),
        (
            "glass_2012a5",
            |scene| scene.materials.iter_mut().for_each(with_highlights),
            "picture with highlights",
        ),
        ("mirrors_2019", |scene| scene.model.epsilon = Some(1e-4), "an epsilon of 0.0001"),
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
            let prepared = renderer.prepare(&request).expect("a structure");
            prepared.render(&request).expect("a picture").remove(0).to_picture()
        };
        let (wrong, right) = (render(wrong), render(load()));
        let renderer = Renderer::new(load(), Meshes::Kept).expect("a scene");
        let original = Original::new(&renderer, Structure::Any, &request).expect("memory");
        let found = original.explain(&wrong, &right).to_string();
        assert!(found.contains(cause), "{name}: {found}");
    }
}

/// Assignment 5 of 2012 has no highlights, which a program that has grown out of assignment 4 has.
#[test]
fn highlights_of_the_assignment_before_are_found() {
    let folder =
        Folder::with_scene(&later("diffuseColor .4 .3 .2 specularColor .5 .5 .5 shininess 9", "", ""));
    folder.run("-input s.txt -size 40 30 -edition 2012a4 -output a.png").ok();
    let run = folder.run("-input s.txt -size 40 30 -edition 2012a5 -bounces 0 -compare a.png").ok();
    assert!(
        run.stdout.contains("equals this program's picture with highlights (0 pixels differ)"),
        "{}",
        run.stdout
    );
}

/// The mistakes that show in the distances and normals of 2019, whose greys and colours are its own.
#[test]
fn mistakes_in_depths_and_normals_are_found() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/editions/mirrors_2019.txt");
    let renderer = Renderer::new(load(&path).expect("a scene"), Meshes::Kept).expect("a scene");
    let one_pixel_right = Mistake::Shifted { half_pixels: [2, 0] };
    for (layer, causes) in [
        (Layer::Depth { near: 3.0, far: 9.0 }, vec![one_pixel_right, Mistake::NearWhite]),
        (
            Layer::Normals,
            vec![one_pixel_right, Mistake::AbsoluteNormals, Mistake::FlatMeshes, Mistake::NormalsByMatrix],
        ),
    ] {
        let request = Request { layers: vec![layer], ..Request::new([60, 40]) };
        let original = Original::new(&renderer, Structure::Any, &request).expect("memory");
        let right = original.picture(Mistake::Unchanged).expect("a picture");
        for cause in causes {
            let wrong = original.picture(cause).expect("a mistake that shows");
            let found = original.explain(&wrong, &right).to_string();
            assert_eq!(found, format!("equals this program's picture{cause} (0 pixels differ)"));
            assert_ne!(wrong, right);
        }
        // The shifted picture is the other one, one column further on.
        let moved = original.picture(one_pixel_right).expect("a picture");
        let rows = |picture: &Picture| -> Vec<Vec<u8>> {
            picture.pixels().chunks_exact(3 * 60).map(<[u8]>::to_vec).collect()
        };
        let pairs = rows(&moved).into_iter().zip(rows(&right));
        let differing: usize =
            pairs.map(|(m, r)| (0..3 * 59).filter(|&i| m[i].abs_diff(r[i + 3]) > 1).count()).sum();
        assert!(differing < 40 * 3 * 59 / 50, "{differing}");
    }
    let colors = Original::new(&renderer, Structure::Any, &Request::new([9, 9])).expect("memory");
    assert_eq!(colors.picture(Mistake::NearWhite), None);
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
