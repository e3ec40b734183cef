//! `-cost_map`: what each pixel costs.

use crate::support::{Folder, Run};
use raytracer::tools::explain::cubehelix;

const SCENE: &str = "PerspectiveCamera { center 0 0 9 direction 0 0 -1 up 0 1 0 angle 30 }
    Lights { numLights 2 DirectionalLight { direction 0 -1 -1 color 1 1 1 }
             PointLight { position 3 4 5 color 1 1 1 } }
    Materials { numMaterials 1 Material { diffuseColor 1 .5 .25 reflectiveColor .5 .5 .5 } }
    Group { numObjects 3 MaterialIndex 0 Sphere { center -1 0 0 radius 1 } Sphere { center 1 .5 0 radius .5 }
            Triangle { vertex0 -2 -2 -1 vertex1 2 -2 -1 vertex2 0 2 -1 } }";

/// The number after a label, in the statistics or in the block of the map.
fn number(run: &Run, label: &str) -> u64 {
    let line = run.stdout.lines().find(|line| line.trim_start().starts_with(label));
    let line = line.unwrap_or_else(|| panic!("no {label}: {}", run.stdout));
    line.split_whitespace().find_map(|word| word.parse().ok()).expect("a number")
}

#[test]
fn the_costs_of_all_pixels_are_those_of_the_statistics() {
    let folder = Folder::with_scene(SCENE);
    for flags in [
        "",
        "-shadows",
        "-shadows -grid 5 6 7",
        "-shadows -bounces 3 -grid 5 6 7 -jittered_samples 5",
        "-shadows -grid 5 6 7 -adaptive_samples 30 2",
        "-shadows -bounces 2 -adaptive_samples 30 2 -gaussian_filter 0.6 -depth 5 9 d.tga",
        "-grid 5 6 7 -jittered_samples 20 -gaussian_filter 0.6 -normals n.tga",
    ] {
        for kind in ["rays", "tests", "cells"] {
            let run =
                folder.run(&format!("-input s.txt -size 23 17 -stats {flags} -cost_map {kind} m.png")).ok();
            let stats = match kind {
                "rays" => number(&run, "num non-shadow rays") + number(&run, "num shadow rays"),
                "tests" => number(&run, "total intersections"),
                _ => number(&run, "total cells traversed"),
            };
            let total =
                run.stdout.lines().find(|line| line.starts_with("  total   ")).expect("the map's total");
            assert_eq!(total.split_whitespace().last(), Some(stats.to_string().as_str()), "{kind} {flags}");
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
    for samples in ["-jittered_samples 7", "-adaptive_samples 40 1"] {
        counting_changes_nothing(&folder, samples);
    }
}

fn counting_changes_nothing(folder: &Folder, samples: &str) {
    let flags = format!("-input s.txt -size 23 17 -stats -shadows -bounces 2 {samples} -gaussian_filter 0.6");
    let plain = folder.run(&format!("{flags} -output a.tga")).ok();
    let mapped = folder.run(&format!("{flags} -output b.tga -cost_map rays m.tga")).ok();
    assert_eq!(folder.read("a.tga"), folder.read("b.tga"));
    for label in ["num non-shadow rays", "num shadow rays", "total intersections"] {
        assert_eq!(number(&plain, label), number(&mapped, label));
    }
}

#[test]
fn the_most_expensive_pixel_is_white_and_the_background_black() {
    let folder = Folder::with_scene(SCENE);
    let run = folder.run("-input s.txt -size 60 60 -grid 4 4 4 -cost_map cells m.tga").ok();
    let line = run.stdout.lines().find(|line| line.contains("most expensive pixel")).expect("a line");
    let numbers: Vec<usize> =
        line.split(|c: char| !c.is_ascii_digit()).filter_map(|word| word.parse().ok()).collect();
    let picture = folder.tga("m.tga");
    assert_eq!((picture.at(numbers[1], numbers[2]), picture.at(0, 0)), ([255; 3], [0; 3]));
    // The scale at the right is white at its top and black at its bottom.
    assert_eq!((picture.at(66, 0), picture.at(66, 59)), (cubehelix(1.0), cubehelix(0.0)));
    assert!(
        run.stdout.contains("empty cells") && run.stdout.matches("full cell").count() == 5,
        "{}",
        run.stdout
    );
}
