//! `-pixel`: the tree of rays behind one pixel.

use crate::pixel_scenes::{BOARD, GLASS, MARBLE, MESH, OBJ, numbers};
use crate::support::{Folder, Tga};
use raytracer::caster::choose::Resolution;
use raytracer::render::{Request, Tracing};
use raytracer::renderer::{Meshes, Renderer};
use raytracer::sampling::adaptive::Adaptive;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Color;
use raytracer::scene_io;
use raytracer::stats::Counts;
use raytracer::tools::explain::{Explainer, PixelTree};
use raytracer::trace::{Effects, Shadows};
use std::collections::HashSet;

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
    let adaptive = Request {
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

/// The whole picture by the program, its statistics, and the trees of its pixels, row by row from the top.
fn explained(case: &Case) -> (Tga, String, Vec<PixelTree>) {
    let folder = Folder::with_scene(case.text);
    folder.write("m.obj", OBJ);
    let flags = format!("-input s.txt -output o.tga -size {} {} {}", SIZE[0], SIZE[1], case.flags);
    folder.run(&flags).ok();
    let statistics = folder.run(&format!("{flags} -stats")).ok().stdout;
    let loaded = scene_io::load(&folder.path().join("s.txt")).expect("a scene");
    let renderer = Renderer::new(loaded, Meshes::Kept).expect("a world");
    let rays = SIZE[0] * SIZE[1] * case.request.sampler.count() as usize;
    let prepared = renderer.prepare(case.grid, rays, Tracing::Counted).expect("a grid");
    let explainer = Explainer::new(&prepared).expect("objects");
    let places = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let trees: Vec<PixelTree> =
        places.map(|place| explainer.pixel(&case.request, place).expect("a pixel")).collect();
    let rendered = prepared.render(&case.request).expect("a picture");
    let sums: Vec<Color> = trees.iter().map(|tree| tree.color).collect();
    assert!(rendered[0].colors == sums, "{}: the sums are not the rendered colours", case.flags);
    (folder.tga("o.tga"), statistics, trees)
}

#[test]
fn the_sum_that_is_printed_is_cut_to_the_byte_of_every_pixel() {
    for case in cases() {
        let (picture, _, trees) = explained(&case);
        let mut colors = HashSet::new();
        for tree in &trees {
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
    for case in cases() {
        for tree in explained(&case).2 {
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
    for case in cases() {
        // Where a filter reaches, or leaves samples out, pixels have other samples than their own.
        if case.request.filter != Filter::PIXEL {
            continue;
        }
        let (_, statistics, trees) = explained(&case);
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
            if case.request.adaptive.is_some() {
                // The rays that decide how many samples pixels get are behind none of them.
                assert!(counted >= Some(count), "{label} {}", case.flags);
                assert!(label != "num non-shadow rays" || counted > Some(count), "{}", case.flags);
            } else {
                assert_eq!(counted, Some(count), "{label} {}", case.flags);
            }
        }
    }
}

#[test]
fn without_its_meshes_a_renderer_explains_nothing() {
    let folder = Folder::with_scene(MESH);
    folder.write("m.obj", OBJ);
    let renderer = Renderer::open(&folder.path().join("s.txt")).expect("a world");
    let prepared = renderer.prepare(None, 1, Tracing::Counted).expect("no grid");
    assert_eq!(Explainer::new(&prepared).expect_err("no meshes").to_string(), "the meshes were not kept");
}
