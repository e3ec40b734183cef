//! `-cost_map`: what each pixel costs.

use crate::support::Folder;

const SCENE: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
    Lights { numLights 2 DirectionalLight { direction 0 -1 -1 color 1 1 1 }
             PointLight { position 3 4 5 color 1 1 1 } }
    Materials { numMaterials 1 Material { diffuseColor 1 .5 .25 reflectiveColor .5 .5 .5 } }
    Group { numObjects 3 MaterialIndex 0 Sphere { center -1 0 0 radius 1 } Sphere { center 1 .5 0 radius .5 }
            Triangle { vertex0 -2 -2 -1 vertex1 2 -2 -1 vertex2 0 2 -1 } }";

#[test]
fn the_costs_of_all_pixels_are_those_of_the_statistics() {
    let folder = Folder::with_scene(SCENE);
    for flags in [
        "",
        "-shadows -bounces 3 -grid 5 6 7 -jittered_samples 5",
        "-shadows -grid 5 6 7 -adaptive_samples 30 2",
        "-shadows -bounces 2 -adaptive_samples 30 2 -gaussian_filter 0.6 -depth 5 9 d.tga",
        "-grid 5 6 7 -jittered_samples 20 -gaussian_filter 0.6 -normals n.tga",
    ] {
        for kind in ["rays", "tests", "cells"] {
            let run =
                folder.run(&format!("-input s.txt -size 23 17 -stats {flags} -cost_map {kind} m.png")).ok();
            let count = |label| run.value(label).parse::<u64>().expect("a number");
            let stats = match kind {
                "rays" => count("num non-shadow rays") + count("num shadow rays"),
                "tests" => count("total intersections"),
                _ => count("total cells traversed"),
            };
            let total = run.value("total   ").split_whitespace().last();
            assert_eq!(total, Some(stats.to_string().as_str()), "{kind} {flags}");
        }
    }
}

#[test]
fn a_map_has_all_pixels_of_which_a_reduced_picture_is_made() {
    let scene = SCENE.replace("reflectiveColor .5 .5 .5", "").replace("Material {", "PhongMaterial {");
    let folder = Folder::with_scene(&scene);
    folder.run("-input s.txt -edition 2012a5 -size 24 18 -cost_map rays whole.tga").ok();
    folder.run("-input s.txt -edition 2012a5 -size 24 18 -filter -cost_map rays reduced.tga").ok();
    assert_eq!(folder.read("whole.tga"), folder.read("reduced.tga"));
}

#[test]
fn counting_by_pixels_changes_neither_counters_nor_pictures() {
    let folder = Folder::with_scene(SCENE);
    for samples in ["-jittered_samples 7", "-adaptive_samples 40 4"] {
        let flags = format!("-input s.txt -size 23 17 -stats -shadows {samples} -gaussian_filter 0.6");
        let plain = folder.run(&format!("{flags} -output a.tga")).ok();
        let mapped = folder.run(&format!("{flags} -output b.tga -cost_map rays m.tga")).ok();
        assert_eq!(folder.read("a.tga"), folder.read("b.tga"));
        for label in ["num non-shadow rays", "num shadow rays", "total intersections"] {
            assert_eq!(plain.value(label), mapped.value(label));
        }
    }
}
