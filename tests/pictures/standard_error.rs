//! The standard error of pictures, against what they are off from converged ones.

use raytracer::render::{Request, Tracing};
use raytracer::renderer::{Meshes, Prepared, Renderer};
use raytracer::sampling::adaptive::Adaptive;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Color;
use raytracer::tools::standard_error::{has_standard_error, standard_error};
use raytracer::trace::{Effects, Shadows};
use std::ops::ControlFlow;
use std::path::Path;

fn colors(prepared: &Prepared, request: &Request) -> Vec<Color> {
    let picture = prepared.render(request).expect("memory").remove(0);
    picture.colors.iter().map(|color| color.clamp(Color::ZERO, Color::ONE)).collect()
}

/// The root mean square error of a request's picture in levels: over `seeds` pictures with other random numbers, and
/// against two references, whose own noise cancels.
fn error(prepared: &Prepared, request: &Request, references: &[Vec<Color>; 2], seeds: u32) -> f64 {
    let [a, b] = references;
    let mut sum = 0.0;
    for seed in 1..=seeds {
        let sampler = request.sampler.with_rng(Drand48::seeded(seed));
        let picture = colors(prepared, &Request { sampler, ..request.clone() });
        let products = picture.iter().zip(a.iter().zip(b)).map(|(own, (a, b))| (*own - *a).dot(*own - *b));
        sum += products.sum::<f64>() / (3 * picture.len()) as f64;
    }
    255.0 * (sum / f64::from(seeds)).sqrt()
}

#[test]
fn it_is_that_against_converged_pictures() {
    let sampled = |pattern, count| (Sampler::new(pattern, count, Drand48::UNSEEDED), None);
    let adaptive = |most, error| (Sampler::of_adaptive(Drand48::UNSEEDED), Some(Adaptive { most, error }));
    for (scene, bounces) in [("scene6_10_nested_transformations.txt", 0), ("scene6_14_glass_sphere.txt", 4)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::open(&path).expect("a scene");
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces, ..Effects::default() };
        for filter in [Filter::PIXEL, Filter::Tent { radius: 1.0 }] {
            let base = Request { effects, filter, ..Request::new([60, 44]) };
            let prepared = renderer.prepare(None, 1, Tracing::Fast).expect("no grid");
            let references = [11, 12].map(|seed| {
                let sampler = Sampler::new(Pattern::Jittered, 400, Drand48::seeded(seed));
                colors(&prepared, &Request { sampler, ..base.clone() })
            });
            for (sampler, adaptive) in [
                sampled(Pattern::Random, 6),
                sampled(Pattern::Jittered, 1),
                sampled(Pattern::Jittered, 16),
                sampled(Pattern::Uniform, 9),
                adaptive(64, 8.0),
                adaptive(256, 2.0),
            ] {
                let request = Request { sampler, adaptive, ..base.clone() };
                assert!(has_standard_error(&request));
                let estimated = standard_error(&prepared, &request, &|_| ControlFlow::Continue(()));
                let estimated = estimated.expect("memory").expect("not cancelled");
                let found = error(&prepared, &request, &references, 4);
                let ratio = estimated / found;
                assert!(
                    (0.8..1.2).contains(&ratio),
                    "{scene} {sampler:?} {adaptive:?}: {estimated} for {found}"
                );
            }
        }
        assert!(!has_standard_error(&Request { effects, ..Request::new([4, 4]) }));
    }
}

/// Of a large picture some bands stand for all.
#[test]
fn that_of_bands_is_about_that_of_all_rows() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene6_10_nested_transformations.txt");
    let renderer =
        Renderer::new(raytracer::scene_io::load(&path).expect("a scene"), Meshes::Moved).expect("a world");
    let prepared = renderer.prepare(None, 1, Tracing::Fast).expect("no grid");
    let request = |count, seed| {
        let sampler = Sampler::new(Pattern::Jittered, count, Drand48::seeded(seed));
        Request { sampler, ..Request::new([300, 300]) }
    };
    let of_bands = standard_error(&prepared, &request(4, 0), &|_| ControlFlow::Continue(()));
    let of_bands = of_bands.expect("memory").expect("not cancelled");
    let references = [21, 22].map(|seed| colors(&prepared, &request(64, seed)));
    let of_all = error(&prepared, &request(4, 0), &references, 1);
    assert!((0.8..1.2).contains(&(of_bands / of_all)), "{of_bands} {of_all}");
}
