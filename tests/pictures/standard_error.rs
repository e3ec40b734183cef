//! The standard error of pictures, against what they are off from converged ones.

use crate::adaptive::opened;
use raytracer::caster::choose::Structure;
use raytracer::picture::Color;
use raytracer::render::Request;
use raytracer::render::adaptive::Adaptive;
use raytracer::render::renderer::{Prepared, Renderer};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::tools::standard_error::standard_error;
use raytracer::trace::{Effects, Shadows};
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
fn it_is_that_against_a_converged_picture() {
    converge(4);
}

#[test]
#[ignore = "slow: a minute"]
fn it_is_that_against_converged_pictures() {
    converge(1);
}

/// Tries every `step`th kind of samples, and with a step of more than one each scene with one filter.
fn converge(step: usize) {
    let sampled = |pattern, count| (Sampler::new(pattern, count, Drand48::UNSEEDED), None);
    let adaptive = |most, error| (Sampler::of_adaptive(Drand48::UNSEEDED), Some(Adaptive { most, error }));
    for (scene, bounces) in [("scene6_10_nested_transformations.txt", 0), ("scene6_14_glass_sphere.txt", 4)] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
        let renderer = Renderer::open(&path).expect("a scene");
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces, ..Effects::default() };
        let filters = [Filter::PIXEL, Filter::Tent { radius: 1.0 }];
        let of_scene = &filters[usize::from(bounces > 0)..][..1];
        for &filter in if step == 1 { &filters } else { of_scene } {
            let base = Request { effects, filter, ..Request::new([44, 32]) };
            let prepared = renderer
                .prepare(&Request { structure: Structure::List, ..Request::new([1; 2]) })
                .expect("no grid");
            let references = [11, 12].map(|seed| {
                let sampler = Sampler::new(Pattern::Jittered, 400, Drand48::seeded(seed));
                colors(&prepared, &Request { sampler, ..base.clone() })
            });
            for (sampler, adaptive) in [
                sampled(Pattern::Random, 6),
                sampled(Pattern::Jittered, 1),
                sampled(Pattern::Jittered, 16),
                sampled(Pattern::Uniform, 9),
                sampled(Pattern::Sobol, 8),
                (Sampler::DISPLACED, None),
                adaptive(64, 8.0),
                adaptive(256, 2.0),
            ]
            .into_iter()
            .skip(step / 2)
            .step_by(step)
            {
                let request = Request { sampler, adaptive, ..base.clone() };
                let estimated = standard_error(&prepared, &request);
                let estimated = estimated.expect("memory").expect("an error");
                let found = error(&prepared, &request, &references, 4);
                let ratio = estimated / found;
                assert!(
                    (0.8..1.2).contains(&ratio),
                    "{scene} {sampler:?} {adaptive:?}: {estimated} for {found}"
                );
            }
        }
        let centers = Request { effects, ..Request::new([4, 4]) };
        let of_centers = standard_error(&renderer.prepare(&centers).expect("no grid"), &centers);
        assert_eq!(of_centers.expect("memory"), None);
    }
}

/// A picture of white bars on black, and of a row of lamps brighter than white.
fn bars(rows: usize, bars: &[[f64; 2]], white: f64) -> Renderer {
    let boxes: String =
        bars.iter().map(|[from, to]| format!("Box {{ min -999 {from} 0 max 999 {to} 1 }} ")).collect();
    let text = format!(
        "OrthographicCamera {{ center 0 {} 9 direction 0 0 -1 up 0 1 0 size {rows} }}
         Background {{ color 0 0 0 ambientLight 1 1 1 }}
         Materials {{ numMaterials 1 Material {{ diffuseColor {white} {white} {white} }} }}
         Group {{ numObjects {} MaterialIndex 0 {boxes} }}",
        rows as f64 / 2.0,
        bars.len()
    );
    opened(text)
}

/// Rows are taken where much differs, whatever the period of the picture's structure, by the seed of the samples, and
/// colours are those of the picture, in floats too.
#[test]
fn that_of_some_rows_is_that_of_all_where_few_differ() {
    const ROWS: usize = 256;
    let every_16th: Vec<[f64; 2]> =
        (0..16).map(|k| [16.0 * f64::from(k) + 0.11, 16.0 * f64::from(k) + 13.89]).collect();
    for (all, white, has_floats) in
        [(&every_16th[..], 1.0, false), (&[[0.0, 128.3]], 1.0, false), (&every_16th, 40.0, true)]
    {
        let renderer = bars(ROWS, all, white);
        let prepared = renderer
            .prepare(&Request { structure: Structure::List, ..Request::new([1; 2]) })
            .expect("no grid");
        let estimated = |seed| {
            let sampler = Sampler::new(Pattern::Random, 4, Drand48::seeded(seed));
            let request = Request { sampler, has_floats, ..Request::new([ROWS; 2]) };
            let found = standard_error(&prepared, &request);
            found.expect("memory").expect("an error")
        };
        // A row of which a part p is covered has the variance p (1 - p) / 4 with four samples.
        let parts = all.iter().flatten().map(|at| at.fract());
        let variance = parts.map(|p| p * (1.0 - p) / 4.0).sum::<f64>() / ROWS as f64;
        let expected = 255.0 * white * variance.sqrt();
        let [one, other] = [1, 2].map(estimated);
        assert!(
            [one, other].iter().all(|found| (0.8..1.2).contains(&(found / expected))),
            "{one} {other} {expected}"
        );
        assert!(one != other);
    }
}
