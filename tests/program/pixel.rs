//! `-pixel`: the tree of rays behind one pixel.

use crate::command_line::parse_line;
use crate::pixel_scenes::{BOARD, GLASS, MARBLE, MESH, OBJ};
use crate::support::{Folder, Tga};
use rayon::prelude::*;
use raytracer::cli::Command;
use raytracer::picture::Color;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Layer, Request, Stop, Tracing};
use raytracer::sampling::filter::Filter;
use raytracer::scene::load;
use raytracer::stats::Counts;
use raytracer::tools::explain::{Explainer, PixelTree};
use std::collections::HashSet;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

/// Scenes, sizes of pictures, and flags. With adaptive samples each pixel plans the samples of those around it again.
const CASES: [(&str, &str, &str); 8] = [
    (GLASS, "24 17", "-shadows -bounces 3"),
    (GLASS, "24 17", "-transparent_shadows -bounces 5 -weight .2 -shade_back -grid 3 4 5"),
    (GLASS, "24 17", "-shadows -bounces 2 -random_samples 5 -box_filter .3"),
    (BOARD, "24 17", "-shadows -jittered_samples 3 -gaussian_filter .6"),
    (MESH, "24 17", "-shadows -grid 3 4 5"),
    (MARBLE, "24 17", "-uniform_samples 4"),
    (GLASS, "12 9", "-shadows -bounces 2 -adaptive_samples 20 3"),
    (GLASS, "12 9", "-shadows -bounces 2 -adaptive_samples 20 3 -gaussian_filter .5"),
];

/// Opens the scene of a folder, and returns what the flags ask for. Without a grid, every ray tests every primitive.
fn opened(folder: &Folder, flags: &str) -> (Renderer, Request) {
    let Ok(Command::Render(options)) = parse_line(&format!("-input s.txt {flags}")) else {
        panic!("{flags}")
    };
    let layers = vec![Layer::Color];
    let request = Request { layers, tracing: Tracing::Counted, ..options.request() };
    let loaded = load::load(&folder.path().join("s.txt")).expect("a scene");
    (Renderer::new(loaded, Meshes::Kept).expect("a world"), request)
}

/// A time that no test waits for.
fn far_off() -> Stop {
    Stop::at(Instant::now() + Duration::from_secs(3600))
}

/// What each case shows. Three tests read it, and the search for it takes seconds.
static EXPLAINED: LazyLock<Vec<Explained>> =
    LazyLock::new(|| CASES.into_par_iter().map(|(text, size, flags)| explained(text, size, flags)).collect());

struct Explained {
    flags: &'static str,
    request: Request,
    /// The whole picture by the program, and its statistics.
    picture: Tga,
    statistics: String,
    /// The pixels, row by row from the top.
    trees: Vec<PixelTree>,
}

fn explained(text: &str, size: &str, flags: &'static str) -> Explained {
    let folder = Folder::with_scene(text);
    folder.write("m.obj", OBJ);
    let line = format!("-size {size} {flags}");
    let picture = folder.render(&line);
    let statistics = folder.run(&format!("-input s.txt {line} -stats")).ok().stdout;
    let (renderer, request) = opened(&folder, &line);
    let prepared = renderer.prepare(&request).expect("a grid");
    let explainer = Explainer::new(&prepared).expect("objects");
    let stop = far_off();
    let [width, height] = request.size;
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let trees: Vec<PixelTree> =
        places.map(|place| explainer.pixel(&request, place, &stop).expect("a pixel")).collect();
    let rendered = prepared.render(&request).expect("a picture");
    let sums: Vec<Color> = trees.iter().map(|tree| tree.color).collect();
    assert!(rendered[0].colors == sums, "{flags}: the sums are not the rendered colours");
    Explained { flags, request, picture, statistics, trees }
}

/// The numbers in parentheses in the line of a text with this label.
fn numbers(text: &str, label: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.trim_start().starts_with(label));
    let line = line.unwrap_or_else(|| panic!("no {label}: {text}"));
    let (_, list) = line.split_once('(').expect("a list");
    list.trim_end_matches(')').split(", ").map(|word| word.parse().expect("a number")).collect()
}

#[test]
fn the_sum_that_is_printed_is_cut_to_the_byte_of_every_pixel() {
    for Explained { flags, picture, trees, .. } in EXPLAINED.iter() {
        let mut colors = HashSet::new();
        for tree in trees {
            let [x, y] = tree.pixel;
            let text = tree.to_string();
            let cut: Vec<u8> = numbers(&text, "sum").iter().map(|channel| (255.0 * channel) as u8).collect();
            assert_eq!(cut, picture.at(x, y), "{flags} at ({x}, {y}): {text}");
            assert_eq!(numbers(&text, "bytes"), cut.iter().map(|&byte| f64::from(byte)).collect::<Vec<_>>());
            colors.insert(cut);
        }
        assert!(colors.len() > 20, "{flags} shows little");
    }
}

#[test]
fn the_parts_of_every_ray_add_up_to_its_colour() {
    for Explained { flags, trees, .. } in EXPLAINED.iter() {
        for tree in trees {
            for sample in &tree.samples {
                let mut sum = Color::ZERO;
                for node in &sample.rays {
                    sum += node.filter * node.color;
                    let Some(surface) = &node.surface else { continue };
                    let mut color = surface.ambient.unwrap_or_default();
                    for light in surface.lights.iter().filter(|light| light.cosine > 0.0) {
                        color += light.passed * (light.parts[0] + light.parts[1]);
                    }
                    assert!((color - node.color).length() <= 1e-14, "{flags}: {tree}");
                }
                assert!((sum - sample.color).length() <= 1e-13, "{flags}: {tree}");
            }
        }
    }
}

#[test]
fn the_work_of_all_pixels_is_that_of_the_statistics() {
    for Explained { flags, request, statistics, trees, .. } in EXPLAINED.iter() {
        // Where a filter reaches, or leaves samples out, pixels have other samples than their own.
        if request.filter != Filter::PIXEL {
            continue;
        }
        let sum = trees.iter().fold(Counts::default(), |sum, tree| sum.merge(tree.counts()));
        for (label, count) in [
            ("num non-shadow rays", sum.non_shadow_rays),
            ("num shadow rays", sum.shadow_rays),
            ("total intersections", sum.intersections),
            ("total cells traversed", sum.cells_traversed),
        ] {
            let line = statistics.lines().find(|line| line.trim_start().starts_with(label));
            let words = line.unwrap_or_else(|| panic!("no {label}: {statistics}")).split_whitespace();
            let counted = words.last().and_then(|word| word.parse().ok());
            assert_eq!(counted, Some(count), "{label} {flags}");
        }
    }
}

/// Spheres of glass and mirrors within each other: every ray becomes two.
const HALL: &str = "
    PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 40 }
    Lights { numLights 1 DirectionalLight { direction -1 -1 -1 color 1 1 1 } }
    Materials { numMaterials 1 Material {
        diffuseColor 1 0 0 reflectiveColor .7 .7 .7 transparentColor .7 .7 .7 indexOfRefraction 1.5 } }
    Group { numObjects 3 MaterialIndex 0
        Sphere { center 0 0 0 radius 10 } Sphere { center 0 0 0 radius 5.5 } Sphere { center 1 0 0 radius 1 } }";

fn explained_hall<T>(bounces: u32, samples: u32, work: impl FnOnce(&Explainer, &Request) -> T) -> T {
    let folder = Folder::with_scene(HALL);
    let flags = format!("-size 24 17 -shadows -bounces {bounces} -random_samples {samples}");
    let (renderer, request) = opened(&folder, &flags);
    let prepared = renderer.prepare(&request).expect("no grid");
    work(&Explainer::new(&prepared).expect("objects"), &request)
}

#[test]
fn a_tree_of_many_rays_is_bounded_and_says_what_it_left_out() {
    let folder = Folder::with_scene(HALL);
    let flags = "-input s.txt -size 24 17 -shadows -bounces 9 -random_samples 16";
    folder.run(&format!("{flags} -output o.tga")).ok();
    let tree = explained_hall(9, 16, |explainer, request| explainer.pixel(request, [12, 8], &far_off()));
    let tree = tree.expect("a pixel");
    assert_eq!(tree.bytes, folder.tga("o.tga").at(12, 8));
    let kept: usize = tree.samples.iter().map(|sample| sample.rays.len()).sum();
    assert!(kept <= 4096 && tree.left_out.rays > 1000, "{kept} {:?}", tree.left_out);
    // What is counted is the work of all rays, kept or not.
    assert_eq!(tree.counts().non_shadow_rays, kept as u64 + tree.left_out.rays);
    let text = tree.to_string();
    assert!(text.lines().count() < 10_000, "{}", text.lines().count());
    assert_eq!(text.matches("camera ray\n").count(), 1, "the first sample is whole");
    assert_eq!(text.lines().filter(|line| line.starts_with("  sample ")).count(), 16);
    let more =
        text.lines().find_map(|line| line.trim_start().strip_prefix("and ")?.strip_suffix(" more rays"));
    let more: usize = more.expect("rays are left out").replace(',', "").parse().expect("a number");
    let shown = text.lines().filter(|line| line.contains(" ray, bounce ")).count() + 1;
    assert_eq!(shown + more, tree.samples[0].rays.len() + tree.samples[0].left_out.rays as usize);
}

#[test]
fn samples_beyond_those_that_are_kept_are_counted() {
    let tree = explained_hall(1, 5000, |explainer, request| explainer.pixel(request, [12, 8], &far_off()));
    let tree = tree.expect("a pixel");
    assert_eq!((tree.samples.len(), tree.more_samples), (4096, 904));
    assert!(tree.to_string().contains("  and 3,975 more samples\n"), "{tree}");
}

#[test]
fn an_explanation_ends_at_its_deadline() {
    let begun = Instant::now();
    let stop = Stop::at(begun + Duration::from_millis(200));
    let found = explained_hall(60, 1, |explainer, request| explainer.pixel(request, [12, 8], &stop));
    assert_eq!(found.expect_err("it is stopped").message, "the rays behind the pixel take too long");
    assert!(begun.elapsed() < Duration::from_secs(20), "{:?}", begun.elapsed());
}

#[test]
fn a_mixed_texture_shows_its_materials_and_what_they_make() {
    let folder = Folder::with_scene(
        "OrthographicCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 size 2 }
         Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }
         Materials { numMaterials 3
            Material { diffuseColor .8 0 0 specularColor .5 .5 .5 exponent 10 }
            Material { diffuseColor 0 .4 0 specularColor 0 0 1 exponent 30 }
            Noise { materialIndex 0 materialIndex 1 octaves 0 } }
         Group { numObjects 1 MaterialIndex 2 Plane { normal 0 0 1 offset 0 } }",
    );
    // Without octaves the noise is 0, and both weigh a half.
    let text = folder.run("-input s.txt -pixel 50 50").ok().stdout;
    for line in [
        "material 0 in line 4 weighs 0.5: diffuse (0.8, 0, 0), specular (0.5, 0.5, 0.5) with exponent 10, ",
        "material 2 in line 6, mixed: diffuse (0.4, 0.2, 0), specular (0.25, 0.25, 0.75), reflective ",
    ] {
        assert!(text.contains(line), "{line}\n{text}");
    }
}

#[test]
fn without_its_meshes_a_renderer_explains_nothing() {
    let folder = Folder::with_scene(MESH);
    folder.write("m.obj", OBJ);
    let renderer = Renderer::open(&folder.path().join("s.txt")).expect("a world");
    let prepared = renderer.prepare(&Request::new([1; 2])).expect("no grid");
    assert_eq!(Explainer::new(&prepared).expect_err("no meshes").message, "the meshes were not kept");
}
