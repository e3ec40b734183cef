//! `-pixel`: the tree of rays behind one pixel.

use crate::pixel_scenes::{BOARD, GLASS, MARBLE, MESH, OBJ, numbers};
use crate::support::{Folder, Tga};
use rayon::prelude::*;
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::picture::Color;
use raytracer::render::adaptive::Adaptive;
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::render::{Request, Stop, Tracing};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::load;
use raytracer::stats::Counts;
use raytracer::tools::explain::{Explainer, PixelTree};
use raytracer::trace::{Effects, Shadows};
use std::collections::HashSet;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

const SIZE: [usize; 2] = [24, 17];

/// A scene with its request, and the flags that ask for the same.
struct Case {
    text: &'static str,
    flags: &'static str,
    request: Request,
    grid: Option<Resolution>,
}

fn request(effects: Effects) -> Request {
    Request { effects, ..Request::new(SIZE) }
}

fn shadows(shadows: Shadows, bounces: u32) -> Effects {
    Effects { shadows, bounces, ..Effects::default() }
}

fn cases() -> Vec<Case> {
    let board = Request {
        sampler: Sampler::new(Pattern::Jittered, 3, Drand48::UNSEEDED),
        filter: Filter::Gaussian { sigma: 0.6 },
        ..request(shadows(Shadows::Opaque, 0))
    };
    let weighed = Effects { min_weight: 0.2, shade_back: true, ..shadows(Shadows::Transparent, 5) };
    let marble = Request {
        sampler: Sampler::new(Pattern::Uniform, 4, Drand48::UNSEEDED),
        ..request(shadows(Shadows::None, 0))
    };
    let box_filter = Request {
        sampler: Sampler::new(Pattern::Random, 5, Drand48::UNSEEDED),
        filter: Filter::Box { radius: 0.3 },
        ..request(shadows(Shadows::Opaque, 2))
    };
    // Each pixel plans the samples of those around it again.
    let adaptive = Request {
        size: [12, 9],
        sampler: Sampler::of_adaptive(Drand48::UNSEEDED),
        adaptive: Some(Adaptive { most: 20, error: 3.0 }),
        ..request(shadows(Shadows::Opaque, 2))
    };
    let adaptive_spread = Request { filter: Filter::Gaussian { sigma: 0.5 }, ..adaptive.clone() };
    let grid = Some(Resolution::Cells([3, 4, 5]));
    let case = |text, flags, request, grid| Case { text, flags, request, grid };
    vec![
        case(GLASS, "-shadows -bounces 3", request(shadows(Shadows::Opaque, 3)), None),
        case(
            GLASS,
            "-transparent_shadows -bounces 5 -weight .2 -shade_back -grid 3 4 5",
            request(weighed),
            grid,
        ),
        case(GLASS, "-shadows -bounces 2 -random_samples 5 -box_filter .3", box_filter, None),
        case(BOARD, "-shadows -jittered_samples 3 -gaussian_filter .6", board, None),
        case(MESH, "-shadows -grid 3 4 5", request(shadows(Shadows::Opaque, 0)), grid),
        case(MARBLE, "-uniform_samples 4", marble, None),
        case(GLASS, "-shadows -bounces 2 -adaptive_samples 20 3", adaptive.clone(), None),
        case(GLASS, "-shadows -bounces 2 -adaptive_samples 20 3 -gaussian_filter .5", adaptive_spread, None),
    ]
}

/// Nobody waits so long.
fn far_off() -> Stop {
    Stop::at(Instant::now() + Duration::from_secs(3600))
}

/// What each case shows. Three tests read it, and the search for it takes seconds.
static EXPLAINED: LazyLock<Vec<Explained>> =
    LazyLock::new(|| cases().into_par_iter().map(explained).collect());

struct Explained {
    case: Case,
    /// The whole picture by the program, and its statistics.
    picture: Tga,
    statistics: String,
    /// The pixels, row by row from the top.
    trees: Vec<PixelTree>,
}

fn explained(case: Case) -> Explained {
    let folder = Folder::with_scene(case.text);
    folder.write("m.obj", OBJ);
    let [width, height] = case.request.size;
    let flags = format!("-input s.txt -output o.tga -size {width} {height} {}", case.flags);
    folder.run(&flags).ok();
    let statistics = folder.run(&format!("{flags} -stats")).ok().stdout;
    let loaded = load::load(&folder.path().join("s.txt")).expect("a scene");
    let renderer = Renderer::new(loaded, Meshes::Kept).expect("a world");
    let structure = case.grid.map_or(Structure::List, Structure::Grid);
    let request = Request { structure, tracing: Tracing::Counted, ..case.request.clone() };
    let prepared = renderer.prepare(&request).expect("a grid");
    let explainer = Explainer::new(&prepared).expect("objects");
    let stop = far_off();
    let places = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let trees: Vec<PixelTree> =
        places.map(|place| explainer.pixel(&case.request, place, &stop).expect("a pixel")).collect();
    let rendered = prepared.render(&case.request).expect("a picture");
    let sums: Vec<Color> = trees.iter().map(|tree| tree.color).collect();
    assert!(rendered[0].colors == sums, "{}: the sums are not the rendered colours", case.flags);
    Explained { picture: folder.tga("o.tga"), statistics, trees, case }
}

#[test]
fn the_sum_that_is_printed_is_cut_to_the_byte_of_every_pixel() {
    for Explained { case, picture, trees, .. } in EXPLAINED.iter() {
        let mut colors = HashSet::new();
        for tree in trees {
            let [x, y] = tree.pixel;
            let text = tree.to_string();
            let cut: Vec<u8> = numbers(&text, "sum").iter().map(|channel| (255.0 * channel) as u8).collect();
            assert_eq!(cut, picture.at(x, y), "{} at ({x}, {y}): {text}", case.flags);
            assert_eq!(numbers(&text, "bytes"), cut.iter().map(|&byte| f64::from(byte)).collect::<Vec<_>>());
            colors.insert(cut);
        }
        assert!(colors.len() > 20, "{} shows little", case.flags);
    }
}

#[test]
fn the_parts_of_every_ray_add_up_to_its_colour() {
    for Explained { case, trees, .. } in EXPLAINED.iter() {
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
                    assert!((color - node.color).length() <= 1e-14, "{}: {tree}", case.flags);
                }
                assert!((sum - sample.color).length() <= 1e-13, "{}: {tree}", case.flags);
            }
        }
    }
}

#[test]
fn the_work_of_all_pixels_is_that_of_the_statistics() {
    for Explained { case, statistics, trees, .. } in EXPLAINED.iter() {
        // Where a filter reaches, or leaves samples out, pixels have other samples than their own.
        if case.request.filter != Filter::PIXEL {
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
            assert_eq!(counted, Some(count), "{label} {}", case.flags);
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
    let renderer = Renderer::new(load::load(&folder.path().join("s.txt")).expect("a scene"), Meshes::Kept);
    let renderer = renderer.expect("a world");
    let sampler = Sampler::new(Pattern::Random, samples, Drand48::UNSEEDED);
    let request = Request { sampler, ..request(shadows(Shadows::Opaque, bounces)) };
    let (structure, tracing) = (Structure::List, Tracing::Counted);
    let prepared = renderer.prepare(&Request { structure, tracing, ..request.clone() }).expect("no grid");
    work(&Explainer::new(&prepared).expect("objects"), &request)
}

#[test]
fn a_tree_of_many_rays_is_bounded_and_says_what_it_left_out() {
    let folder = Folder::with_scene(HALL);
    let flags = "-input s.txt -size 24 17 -shadows -bounces 9 -random_samples 16";
    folder.run(&format!("{flags} -output o.tga")).ok();
    let picture = folder.tga("o.tga");
    let tree = explained_hall(9, 16, |explainer, request| explainer.pixel(request, [12, 8], &far_off()));
    let tree = tree.expect("a pixel");
    assert_eq!(tree.bytes, picture.at(12, 8));
    let kept: usize = tree.samples.iter().map(|sample| sample.rays.len()).sum();
    assert!(kept <= 4096 && tree.left_out.rays > 1000, "{kept} {:?}", tree.left_out);
    // What is counted is the work of all rays, kept or not.
    assert_eq!(tree.counts().non_shadow_rays, kept as u64 + tree.left_out.rays);
    let text = folder.run(&format!("{flags} -pixel 12 8")).ok().stdout;
    assert!(text.lines().count() < 10_000, "{}", text.lines().count());
    assert_eq!(text.matches("camera ray\n").count(), 1, "the first sample is whole");
    assert_eq!(text.lines().filter(|line| line.starts_with("  sample ")).count(), 16);
    let more =
        text.lines().find_map(|line| line.trim_start().strip_prefix("and ")?.strip_suffix(" more rays"));
    let shown =
        text.lines().filter(|line| line.contains(" ray, bounce ") || line.ends_with("camera ray")).count();
    let more: usize = more.expect("rays are left out").replace(',', "").parse().expect("a number");
    let first = &tree.samples[0];
    assert_eq!(shown + more, first.rays.len() + first.left_out.rays as usize);
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
        "material 1 in line 5 weighs 0.5: diffuse (0, 0.4, 0), specular (0, 0, 1) with exponent 30, ",
        "material 2 in line 6, mixed: diffuse (0.4, 0.2, 0), specular (0.25, 0.25, 0.75), reflective ",
    ] {
        assert!(text.lines().any(|shown| shown.trim_start().starts_with(line)), "{line}\n{text}");
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
