//! The later editions of the course: their words, flags, warnings and messages.

use crate::support::{CAMERA, Folder, says, sphere};

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
    let folder = Folder::with_scene(&later("shininess 5", "falloff 1", ""));
    let said = |flags: &str| folder.run(&format!("-input s.txt {flags}")).ok().stderr;
    for picture in ["-output o.tga", "-output o.png"] {
        assert!(
            said(picture)
                .starts_with("note: the scene is read as edition 2019, because of `shininess` with ")
        );
    }
    assert_eq!(said("-output o.tga -edition 2019"), "");
    assert_eq!(Folder::with_scene(&sphere()).run("-input s.txt -output o.tga").ok().stderr, "");
}

#[test]
fn words_of_another_edition_name_it_and_the_flag() {
    for (text, flags, expected) in [
        (
            &later("shininess 5 exponent 3", "", ""),
            "",
            "`shininess` ... `-edition 2012a4`, `-edition 2012a5`",
        ),
        (&format!("{CAMERA}{}", sphere()), "-edition 2012a5", "`OrthographicCamera` ... `-edition 2004`"),
        (
            &later("refractionIndex 2", "falloff 1", ""),
            "-edition 2019",
            "`refractionIndex` ... `-edition 2012a5`",
        ),
        (&later("shininess 5 Noize", "", ""), "", "`-edition 2012a4`, because of `shininess`"),
        (&later("shininess 5", "", ""), "-edition 2019", "without `falloff` the light is infinitely bright"),
    ] {
        let message = Folder::with_scene(text).run(&format!("-input s.txt -output o.tga {flags}")).message(1);
        assert!(expected.split(" ... ").all(|part| message.contains(part)), "{expected}: {message}");
    }
}

#[test]
fn flags_of_editions() {
    let folder = Folder::with_scene(&later("", "falloff 1", ""));
    let message = |flags: &str| folder.run(&format!("-input s.txt -output o.tga {flags}")).message(2);
    assert!(says(&message("-edition 2005"), "'2005' ... -edition ... 2004, 2012a4, 2012a5, 2019, aalto"));
    assert!(says(&message("-jitter -edition aalto"), "-jitter ... 2012a5, not of aalto"));
    assert!(says(&message("-regular_samples 4 -edition 2004"), "-regular_samples ... aalto, not of 2004"));
    assert!(says(&message("-filter -size 2 9"), "-filter needs at least 3 x 3 pixels ... -size"));
    let size = |flags: &str| {
        let picture = folder.render(&format!("-size 12 9 {flags}"));
        [picture.width, picture.height]
    };
    assert_eq!([size("-jitter"), size("-filter"), size("-jitter -filter")], [[36, 27], [4, 3], [12, 9]]);
    // The program of 2019 accepts both and does nothing.
    assert_eq!(size("-jitter -filter -edition 2019"), [12, 9]);
    let json = |flags: &str| folder.run(&format!("-input s.txt -size 9 9 -json - {flags}")).ok().stdout;
    assert!(json("").contains("\"edition\":\"2012a5\"") && json("").contains("\"bounces\":4"));
    assert!(json("-bounces 1").contains("\"bounces\":1"));
    assert!(json("-edition 2019").contains("\"bounces\":0"));
    let statistics = |flags: &str| folder.run(&format!("-input s.txt -size 9 9 -stats {flags}")).ok().stdout;
    assert!(statistics("-edition 2019").contains("\n  edition                    2019\n"));
    folder.write("s.txt", sphere());
    assert!(!statistics("").contains("edition"));
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
    let flags = "-edition aalto -regular_samples 4 -shadows -grid 3 3 3 -stats";
    assert_eq!(folder.render(&format!("-uv -size 4 2 {flags}")).pixels, expected);
    // Depths and normals are those of the scene.
    let normals = |flags: &str| {
        folder.run(&format!("-input s.txt -size 9 9 -normals n.tga {flags}")).ok();
        folder.read("n.tga")
    };
    assert!(normals("-uv") == normals(""));
    let message = |flags: &str| folder.run(&format!("-input s.txt -output o.tga {flags}")).message(2);
    assert!(says(&message("-uv -edition 2004"), "-uv ... aalto, not of 2004"));
    assert!(says(&message("-uv -pixel 1 1"), "-uv ... -pixel"));
    folder.write("s.txt", CAMERA);
    assert_eq!(folder.render("-edition aalto -size 4 2").pixels, expected);
}

/// Aalto's program reads textures, and shows the diffuse colour.
#[test]
fn aalto_s_textures_are_read() {
    let scene = |material: &str, [a, b]: [&str; 2]| {
        format!(
            "{CAMERA}Materials {{ numMaterials 1 Material {{ diffuseColor .5 .6 .7 {material} }} }}
            Group {{ numObjects 1 MaterialIndex 0
            Triangle {{ {a} vertex0 -1 -1 0 vertex1 1 -1 0 {b} vertex2 0 1 0 }} }}"
        )
    };
    let textured =
        scene("texture none.tga mipmap linearInterpolation", ["textCoord0 0 0", "textCoord2 .5 1"]);
    let bytes = |text: &str| Folder::with_scene(text).render("-size 9 9 -edition aalto").pixels;
    assert_eq!(bytes(&textured), bytes(&scene("", [""; 2])));
    for (text, word) in [(&scene("mipmap", [""; 2]), "mipmap"), (&textured, "texture")] {
        let message = Folder::with_scene(text).run("-input s.txt -output o.tga").message(1);
        assert!(message.contains(&format!("`{word}` is a word")) && message.contains("`-edition aalto`"));
    }
}

/// The cells of 2003 are those whose centre lies in the sphere.
#[test]
fn cells_of_2003_are_boxes_without_walls_between_them() {
    let pictures = |count: usize, objects: &str| {
        let folder = Folder::with_scene(&format!(
            "PerspectiveCamera {{ center 3 4 6 direction -3 -4 -6 up 0 1 0 angle 40 }}
            Lights {{ numLights 1 PointLight {{ position 4 5 3 color 1 1 1 }} }}
            Group {{ numObjects 1 Material {{ diffuseColor .8 .6 .4 specularColor .3 .3 .3 exponent 8 }}
            Transform {{ YRotate 20 Group {{ numObjects {count} {objects} }} }} }}"
        ));
        folder.run("-input s.txt -output c.tga -size 40 30 -shadows -depth 5 10 d.tga").ok();
        let counted = folder.render("-size 40 30 -grid 4 4 4 -visualize_grid_count").pixels;
        assert_eq!(counted, folder.render("-size 40 30 -grid 4 4 4 -visualize_grid").pixels);
        ["c.tga", "d.tga"].map(|name| folder.read(name))
    };
    let cells = "Grid { min -1.5 -1.5 -1.5 max 1.5 1.5 1.5 numCells 3 3 3
        rasterizeSphere { center 0 0 0 radius 1 } }";
    let boxes = "Box { min -1.5 -.5 -.5 max 1.5 .5 .5 } Box { min -.5 -1.5 -.5 max .5 1.5 .5 }
        Box { min -.5 -.5 -1.5 max .5 .5 1.5 }";
    assert!(pictures(1, cells) == pictures(3, boxes));
}

/// Warnings know the pictures of an edition.
#[test]
fn warnings_of_editions() {
    let warned =
        |text: &str, flags: &str| Folder::with_scene(text).run(&format!("-input s.txt {flags}")).ok().stderr;
    // The colour of a pixel without a normal is grey in 2019.
    let away = later("shininess 5", "falloff 1", "").replace("direction 0 0 -1", "direction 0 0 1");
    for flags in ["-edition 2019 -output o.tga", "-edition 2019 -normals n.tga"] {
        assert!(warned(&away, flags).contains("the scene is behind the camera"), "{flags}");
    }
    // Between the columns, and not higher than a pixel of a picture that is stretched.
    let narrow = format!(
        "{EYE}Materials {{ numMaterials 1 Material {{ }} }} Group {{ numObjects 1 MaterialIndex 0
        Triangle {{ vertex0 -.02 -.1 0 vertex1 .02 -.1 0 vertex2 0 .1 0 }} }}"
    );
    let small = "the scene is smaller than a pixel";
    assert!(warned(&narrow, "-edition 2012a4 -size 30 10 -output o.tga").contains(small));
    assert!(!warned(&narrow, "-edition 2004 -size 30 10 -output o.tga").contains(small));
    let shiny = later("shininess 5", "", "");
    let both = "`-shade_back` has no effect in this edition";
    assert!(warned(&shiny, "-edition 2012a4 -shade_back -output o.tga").contains(both));
    assert!(!warned(&sphere(), "-edition aalto -shade_back -output o.tga").contains("-shade_back"));
    // A default is no flag, and flags have the names that they have in the edition.
    let unseen = |flags: &str| warned(&sphere(), &format!("-normals n.tga -edition aalto {flags}"));
    assert_eq!(unseen(""), "");
    assert!(unseen("-uniform_samples 4").starts_with("warning: `-uniform_samples 4` has no effect"));
    assert!(
        unseen("-regular_samples 4 -weight 0").starts_with("warning: `-weight 0`, `-regular_samples 4` have")
    );
}

/// Where the words of a scene leave open which later edition is meant, a warning names the flags.
#[test]
fn words_that_leave_the_edition_open_are_a_warning_with_the_flags() {
    let folder = Folder::with_scene(&later("", "falloff 1", ""));
    for picture in ["-output o.tga", "-normals o.bmp", "-stats"] {
        let line = format!("-input s.txt -size 9 9 {picture}");
        let warning = folder.run(&line).ok().stderr;
        assert!(
            warning.starts_with("warning: the scene is read as edition 2012a5, but `falloff` may "),
            "{warning}"
        );
        assert!(warning.contains("\n  hint: add `-edition 2012a5`, or `-edition 2019` for "), "{warning}");
        let message = folder.run(&format!("{line} -strict")).message(1);
        assert!(message.starts_with(warning.replace("warning", "error").trim_end()), "{message}");
        assert_eq!(folder.run(&format!("{line} -edition 2012a5")).ok().stderr, "");
    }
}

/// No message suggests a word that the edition does not have.
#[test]
fn messages_suggest_words_of_the_edition_only() {
    for (text, edition, lacks) in [
        (later("", "falloff 1", ""), "2012a4", "attenuation"),
        (later("", "attenuatoin 1 0 0", "").replacen("falloff", "", 1), "2012a4", "`attenuation`"),
        ("Camera { }".into(), "2019", "Orthographic"),
        (later("", "", "cubemap tex"), "2012a4", "`cubeMap`"),
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
    let folder = Folder::with_scene(&format!(
        "{EYE}Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 -1 color 1 1 1 }} }}
        Group {{ numObjects 1 Material {{ diffuseColor .9 .8 .7 }} Sphere {{ center 0 0 0 radius 1 }} }}"
    ));
    let [own, first, second, third] = ["", "-edition 2004", "-edition 2012a4", "-edition 2012a5"]
        .map(|flags| folder.render(&format!("-size 40 20 {flags}")).pixels);
    assert!(own == first && own != second && second == third);
    assert_eq!(folder.run("-input s.txt -output o.tga").ok().stderr, "");
}

/// By the law of the later editions a surface that faces away from the light has a highlight, too.
#[test]
fn a_pixel_is_explained_by_the_law_of_its_edition() {
    let behind = later("diffuseColor .5 .5 .5 specularColor .6 .6 .6 shininess 0", "", "");
    let folder = Folder::with_scene(&behind.replace("position 0 0 5", "position 0 0 -5"));
    let text = folder.run("-input s.txt -size 9 9 -pixel 4 4").ok().stdout;
    assert!(text.contains("light 0: diffuse (0, 0, 0), specular (0.6, 0.6, 0.6), cosine -1\n"), "{text}");
}
