//! The pictures of the later editions: known bugs, and the pictures that the editions' own programs made.
//!
//! `EDITIONS_DIR` names a folder with scenes and pictures of 2012 and 2019, which are not part of this project. Without
//! it the tests of pictures print that they are skipped.

use crate::support::{Folder, finish, outer_folder, program};
use raytracer::image_io::read_picture;
use raytracer::picture::Picture;
use raytracer::render::Request;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::scene::load::load;
use raytracer::scene::material::Material;
use raytracer::scene::model::{FaceWeights, Highlight, MeshNormals, Screen};
use raytracer::scene::{Light, Scene};
use raytracer::tools::causes::Original;
use raytracer::trace::{Effects, Shadows};
use std::fs;
use std::path::{Path, PathBuf};

fn set_constant(scene: &mut Scene, constant: f64) {
    for light in &mut scene.lights {
        if let Light::Point { attenuation, .. } = light {
            attenuation[0] = constant;
        }
    }
}

fn add_highlights(scene: &mut Scene) {
    for material in &mut scene.materials {
        if let Material::Phong(phong) | Material::Painted(phong, _) = material {
            phong.specular = phong.reflective;
        }
    }
}

fn weigh_by_area(scene: &mut Scene) {
    scene.mesh_normals = MeshNormals::Smooth { weights: FaceWeights::Area, flat_up_to: 0 };
}

/// Swaps each of these faces of the cube map with the next one.
fn swap_faces(scene: &mut Scene, faces: &[usize]) {
    if let Some(cube) = &mut scene.cube_map {
        faces.iter().for_each(|&face| cube.swap(face, face + 1));
    }
}

#[test]
fn a_mistake_of_each_edition_is_found() {
    find_mistakes(4);
}

#[test]
#[ignore = "slow: twenty seconds"]
fn mistakes_of_the_editions_are_found() {
    find_mistakes(1);
}

/// Makes every `step`th of the mistakes that are common in the editions, each of which must be found.
fn find_mistakes(step: usize) {
    type Change = fn(&mut Scene);
    let cases: [(&str, Change, &str); 10] = [
        ("screen_2012a4", |scene| scene.lighting.highlight = Highlight::Blinn, "the half-way vector"),
        ("screen_2012a4", |scene| scene.screen = Screen::LongerSide, "which is not stretched"),
        ("mirrors_2019", |scene| scene.mesh_normals = MeshNormals::Flat, "the normals of the faces"),
        ("mirrors_2019", weigh_by_area, "other weights of the faces around a vertex"),
        ("glass_2012a5", |scene| swap_faces(scene, &[0, 2, 4]), "all opposite faces of the cube map swapped"),
        ("glass_2012a5", |scene| swap_faces(scene, &[4]), "the faces front and back of the cube map swapped"),
        ("mirrors_2019", |scene| set_constant(scene, 1.0), "1 + falloff d^2 instead of falloff d^2"),
        ("glass_2012a5", |scene| set_constant(scene, 0.0), "falloff d^2 instead of 1 + falloff d^2"),
        ("glass_2012a5", add_highlights, "picture with highlights"),
        ("mirrors_2019", |scene| scene.lighting.epsilon = Some(1e-4), "the course's own epsilon of 0.0001"),
    ];
    for (name, change, cause) in cases.into_iter().step_by(step) {
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
        let wrong = render(wrong);
        let renderer = Renderer::new(load(), Meshes::Kept).expect("a scene");
        let original = Original::new(&renderer, &request).expect("memory");
        let found = original.explain(&wrong).to_string();
        assert!(found.contains(cause), "{name}: {found}");
    }
}

/// The folder of the editions.
fn editions() -> Option<PathBuf> {
    outer_folder("EDITIONS_DIR")
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
    let line = "-edition 2019 -input scene01_plane.txt -size 300 200 -output @".into();
    all.push(official(line, "staff200/scene01_300x200", 0.9994, 1));
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
        official(format!("{diamond} -size 200 200 -bounces 0 -shadows"), "staff/a5_13_b0s", 0.999, 1),
        official(format!("{diamond} -size 200 200 -bounces 1 -shadows"), "staff/a5_13_b1", 0.999, 1),
        official(format!("{diamond} -size 200 200 -shadows"), "staff/a5_13_plain", 0.999, 1),
        official(format!("{diamond} -size 300 300 -shadows -jitter -filter"), "staff/a5_13", 0.999, 1),
        official(small("06_bunny_1k", four), "staff/a5_small_06_bunny_1k", 0.993, 1),
        // Edges are seen through a ball, which magnifies the roundings of the other program's single precision.
        official(small("10_sphere", four), "staff/a5_small_10_sphere", 0.993, u8::MAX),
        official(small("11_cube", four), "staff/a5_small_11_cube", 0.999, 1),
        official(small("12_vase", "-size 60 60 -shadows -bounces 2"), "staff/a5_small_12_vase", 0.999, 1),
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
