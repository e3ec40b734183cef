//! Pictures by tracers that break a rule, made without the library's textbook tracer: put together from pictures of
//! other scenes, or computed by hand. The broken rule must be named.

use crate::causes::{CUBE, FLAGS, SCENE, cause, equal, is_named, transformed, write};
use crate::support::{Folder, Tga};
use raytracer::picture::Picture;

/// A material that is lit by ambient light of 1 alone.
fn ambient(color: &str) -> String {
    format!("Material {{ diffuseColor {color} }}")
}

/// A scene without lights, and so with an ambient light of 1.
fn scene(camera: &str, background: &str, materials: &[String], objects: &str) -> String {
    let (count, materials) = (materials.len(), materials.join(" "));
    let objects_count = objects.matches("MaterialIndex").count();
    format!(
        "{camera} Background {{ color {background} }} Materials {{ numMaterials {count} {materials} }}
         Group {{ numObjects {objects_count} {objects} }}"
    )
}

const SQUARE: &str = "OrthographicCamera { center 0 5 0 direction 0 -1 0 up 0 0 -1 size 4 }";

fn constant(color: [u8; 3]) -> Picture {
    Picture::from_rgb(8, 8, color.repeat(64))
}

#[track_caller]
fn check(scene: &str, flags: &str, wrong: &Picture, words: &str) {
    let folder = Folder::with_scene(scene);
    write(&folder, wrong);
    let found = cause(&folder, flags);
    assert!(is_named(&found, words), "{words}: {found}");
}

/// The picture of a scene's text.
fn render(text: &str, flags: &str) -> Tga {
    let folder = Folder::with_scene(text);
    folder.write("cube.obj", CUBE);
    folder.render(flags)
}

#[test]
fn shifted_rays() {
    // A picture that is larger by one or two pixels of the same size has shifted pixels in it.
    let text = |size: &str| {
        let camera = SQUARE.replace("size 4", &format!("size {size}"));
        let objects =
            "MaterialIndex 0 Transform { YRotate 20 Scale 1 .3 .6 Sphere { center .3 0 .2 radius 1.1 } }
            MaterialIndex 1 Triangle { vertex0 -1.7 2 -.3 vertex1 .5 1 1.6 vertex2 1.1 1 -1.3 }";
        scene(&camera, ".1 .2 .3", &[ambient(".9 .8 .7"), ambient(".4 .5 .9")], objects)
    };
    let rows = [
        (
            33,
            "4.125",
            0,
            1,
            "with rays through the lower left corners of the pixels instead of their centres",
        ),
        (
            33,
            "4.125",
            1,
            0,
            "with rays through the upper right corners of the pixels instead of their centres",
        ),
        (34, "4.25", 2, 2, "with rays one pixel further down and to the right"),
    ];
    for (side, size, x, y, words) in rows {
        let large = render(&text(size), &format!("-size {side} {side}"));
        let cut = (y..y + 32).flat_map(|row| (x..x + 32).flat_map(move |column| [(column, row)]));
        let bytes = cut.flat_map(|(column, row)| large.at(column, row)).collect();
        check(&text("4"), "-size 32 32", &Picture::from_rgb(32, 32, bytes), words);
    }
}

#[test]
fn shadows_from_behind_the_light() {
    // A sphere behind the light is seen from below through the light where its mirror image before the light is.
    let text = |height: &str| {
        format!(
            "PerspectiveCamera {{ center 0 1.2 2.5 direction 0 -1 -1 up 0 1 0 angle 40 }}
             Background {{ color 0 0 0 ambientLight .1 .1 .1 }}
             Lights {{ numLights 1 PointLight {{ position 0 4 0 color 1 1 1 }} }}
             Materials {{ numMaterials 1 Material {{ diffuseColor .8 .7 .6 }} }}
             Group {{ numObjects 2 MaterialIndex 0 Plane {{ normal 0 1 0 offset 0 }}
                Sphere {{ center 0.1 {height} 0 radius .5 }} }}"
        )
    };
    let flags = "-size 30 30 -shadows";
    let mirrored = text("2").replace("center 0.1", "center -0.1");
    let wrong = render(&mirrored, flags);
    check(
        &text("6"),
        flags,
        &transformed(&wrong, |x, y| wrong.at(x, y)),
        "with shadows from behind the light",
    );
}

#[test]
fn reflections() {
    // A ray that comes down at 45 degrees, to the back, meets a mirror, behind which there is no more than a
    // floor far below and a wall in front.
    let camera = "PerspectiveCamera { center 0 .5 .5 direction 0 -1 -1 up 0 1 0 angle 2 }";
    let mirror = "Material { diffuseColor 0 0 0 reflectiveColor 1 1 1 }".to_owned();
    let text = scene(
        camera,
        ".2 .4 .6",
        &[mirror, ambient(".4 .8 .2"), ambient(".6 .6 .2")],
        "MaterialIndex 0 Plane { normal 0 1 0 offset 0 } MaterialIndex 1 Plane { normal 0 1 0 offset -5 }
         MaterialIndex 2 Plane { normal 0 0 -1 offset -1 }",
    );
    let flags = "-size 8 8 -bounces 1";
    // The wrong formula gives (0, -3, -1), which meets the floor.
    check(&text, flags, &constant([102, 204, 51]), "with reflections from the flipped normal");
    // The opposite of the mirrored ray is (0, -1, 1), which meets the wall.
    check(&text, flags, &constant([153, 153, 51]), "with reflected rays reversed");
}

#[test]
fn clamped_colours() {
    // The middle column of pixels is covered to one half by a surface of four times the brightest colour.
    let half = "MaterialIndex 0 Triangle { vertex0 0 0 -9 vertex1 0 0 9 vertex2 9 0 0 }";
    let text = scene(SQUARE, "0 0 0", &[ambient("4 4 4")], half);
    let wrong = Picture::from_rgb(3, 1, [[0; 3], [127; 3], [255; 3]].concat());
    let words = "with the colours of samples clamped before they are summed";
    check(&text, "-size 3 1 -uniform_samples 4", &wrong, words);

    // A mirror of one half that shows a background of four times the brightest colour.
    let mirror = "Material { diffuseColor 0 0 0 reflectiveColor .5 .5 .5 }".to_owned();
    let text = scene(SQUARE, "4 4 4", &[mirror], "MaterialIndex 0 Plane { normal 0 1 0 offset 0 }");
    let words = "with the colours of rays clamped before they are summed";
    check(&text, "-size 8 8 -bounces 1", &constant([127; 3]), words);

    // A mirror of 0.4 that shows a ceiling in a light of 2 and an ambient light of 0.5.
    let text = "PerspectiveCamera { center 0 1 0 direction 0 -1 0 up 0 0 -1 angle 20 }
        Background { ambientLight .5 .5 .5 }
        Lights { numLights 1 DirectionalLight { direction 0 1 0 color 2 2 2 } }
        Materials { numMaterials 2 Material { diffuseColor 0 0 0 reflectiveColor .4 .4 .4 } Material { } }
        Group { numObjects 2 MaterialIndex 0 Plane { normal 0 1 0 offset 0 }
            MaterialIndex 1 Triangle { vertex0 -99 3 -99 vertex1 99 3 -99 vertex2 0 3 99 } }";
    let words = "with the light of each source clamped before it is summed";
    check(text, "-size 8 8 -bounces 1", &constant([153; 3]), words);
}

#[test]
fn normals() {
    // Directions: the normal (0, 1, 1) becomes (0, 2, 1/2) by the inverse transpose, and (0, 1/2, 2) by the matrix.
    let text = "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }
        Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }
        Materials { numMaterials 1 Material { } }
        Group { numObjects 1 MaterialIndex 0
            Transform { Scale 1 .5 2 Plane { normal 0 1 1 offset -1 } } }";
    let byte = |z: f64, y: f64| [(255.0 * z / y.hypot(z)) as u8; 3];
    assert_eq!(render(text, "-size 8 8").at(0, 0), byte(0.5, 2.0));
    let words = "with normals transformed by the matrix instead of its inverse transpose";
    check(text, "-size 8 8", &constant(byte(2.0, 0.5)), words);
    check(text, "-size 8 8", &constant(byte(1.0, 1.0)), "with normals that are not transformed");
}

#[test]
fn the_checkerboard_around_zero() {
    let text = |children: &str| {
        let board = format!("Checkerboard {{ {children} }}");
        let camera = SQUARE.replace("center 0 5 0", "center 0 5 2.5");
        let floor = "MaterialIndex 2 Plane { normal 0 1 0 offset .5 }";
        scene(&camera, "0 0 0", &[ambient(".9 .8 .7"), ambient(".2 .3 .4"), board], floor)
    };
    let own = render(&text("materialIndex 0 materialIndex 1"), "-size 16 16");
    let swapped = render(&text("materialIndex 1 materialIndex 0"), "-size 16 16");
    // Cutting exchanges the squares where just one of the coordinates is negative, as x is on the left.
    let wrong = transformed(&own, |x, y| if x < 8 { swapped.at(x, y) } else { own.at(x, y) });
    let words = "with checkerboards whose coordinates are cut instead of floored";
    check(&text("materialIndex 0 materialIndex 1"), "-size 16 16", &wrong, words);
}

#[test]
fn the_background_of_secondary_rays() {
    let folder = Folder::with_scene(SCENE);
    folder.write("cube.obj", CUBE);
    let black = render(&SCENE.replace("color .10980392 .3 .5", "color 0 0 0"), FLAGS);
    let local = render(SCENE, "-size 48 36");
    let background = [27, 76, 127];
    let wrong =
        transformed(&black, |x, y| if local.at(x, y) == background { background } else { black.at(x, y) });
    write(&folder, &wrong);
    let expected = equal("with black where reflected or refracted rays hit nothing");
    assert_eq!(cause(&folder, FLAGS), expected);
}

#[test]
fn contact_shadows() {
    // Two plates above what is seen of the floor: one is too near to it to cast a shadow.
    let text = |near: &str| {
        format!(
            "PerspectiveCamera {{ center 0 .1 0 direction 0 -1 -1 up 0 1 0 angle 40 }}
             Background {{ ambientLight .1 .1 .1 }}
             Lights {{ numLights 1 DirectionalLight {{ direction 0 -1 0 color .8 .8 .8 }} }}
             Materials {{ numMaterials 1 Material {{ diffuseColor .8 .7 .6 }} }}
             Group {{ numObjects 3 MaterialIndex 0 Plane {{ normal 0 1 0 offset 0 }}
                Triangle {{ vertex0 .01 {near} -9 vertex1 9 {near} 0 vertex2 .01 {near} 9 }}
                Triangle {{ vertex0 -9 2 -.11 vertex1 9 2 -.11 vertex2 0 2 -9 }} }}"
        )
    };
    let flags = "-size 20 20 -shadows";
    let wrong = render(&text("-1"), flags);
    let wrong = transformed(&wrong, |x, y| wrong.at(x, y));
    check(&text(".2"), flags, &wrong, "with an epsilon of 0.3 for secondary rays");
}

#[test]
fn colours_to_bytes() {
    let colors = [0.3, 0.7, 0.9];
    let text =
        scene(SQUARE, ".3 .7 .9", &[ambient("1 1 1")], "MaterialIndex 0 Sphere { center 9 0 0 radius 1 }");
    type ToByte = fn(f64) -> f64;
    let bytes = |byte: ToByte| constant(colors.map(|channel| byte(channel) as u8));
    let rows: [(ToByte, &str); 5] = [
        (|channel| 255.0 * channel + 0.5, "with colours rounded to bytes instead of cut"),
        (|channel| 256.0 * channel, "with colours times 256 instead of 255"),
        (|channel| 255.0 * channel.powf(1.0 / 2.2), "with a gamma of 2.2"),
        (|channel| 255.0 * channel.powf(2.2), "with an inverse gamma of 2.2"),
        (
            |channel| (255.0 * ((255.0 * channel).floor() / 255.0).powf(1.0 / 2.2)).round(),
            "with a gamma of 2.2 applied to its bytes",
        ),
    ];
    assert_eq!(render(&text, "-size 8 8").at(0, 0), [76, 178, 229]);
    for (byte, words) in rows {
        check(&text, "-size 8 8", &bytes(byte), words);
    }
}

#[test]
fn reflections_from_below() {
    // The mirrored ray starts below the mirror, and meets it from its other side, which is lit as well.
    let mirror = "Material { diffuseColor .4 .2 .2 reflectiveColor .5 .5 .5 }".to_owned();
    let camera = "PerspectiveCamera { center 0 1 0 direction 0 -1 -1 up 0 1 0 angle 20 }";
    let text = scene(camera, ".2 .4 .6", &[mirror], "MaterialIndex 0 Plane { normal 0 1 0 offset 0 }");
    let flags = "-size 8 8 -bounces 1 -shade_back";
    assert_eq!(render(&text, flags).at(3, 3), [127, 102, 127]);
    let words = "with reflected rays that start below the surface";
    check(&text, flags, &constant([153, 76, 76]), words);
}
