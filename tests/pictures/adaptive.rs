//! Adaptive samples where they are hardest: small things, which the first samples of a pixel may miss.

use raytracer::caster::choose::Structure;
use raytracer::picture::Color;
use raytracer::render::adaptive::Adaptive;
use raytracer::render::renderer::Renderer;
use raytracer::render::{Request, Tracing};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::trace::{Effects, Shadows};
use std::ops::ControlFlow;

const SIDE: usize = 64;

/// Needles a fifth of a pixel wide that point everywhere, and spheres with highlights of half a pixel.
fn needles_and_highlights() -> Renderer {
    let mut objects = String::new();
    let count = 11;
    for k in 0..count {
        let angle = (f64::from(k) + 0.3) * std::f64::consts::PI / f64::from(count);
        let (sin, cos) = angle.sin_cos();
        let (length, half_width) = (1.9, 0.1 * 4.0 / SIDE as f64);
        let [x, y, dx, dy] = [length * cos, length * sin, -half_width * sin, half_width * cos];
        let corners = [[x + dx, y + dy], [x - dx, y - dy], [-x, -y]];
        let [a, b, c] = corners.map(|[x, y]| format!("{x} {y} 1"));
        objects += &format!("Triangle {{ vertex0 {a} vertex1 {b} vertex2 {c} }}\n");
    }
    let spheres = [(-1.2, -1.3), (1.3, -1.2), (1.2, 1.3), (-1.3, 1.2)];
    for (x, y) in spheres {
        objects += &format!("Sphere {{ center {x} {y} 0 radius .4 }}\n");
    }
    let all = count as usize + spheres.len();
    let text = format!(
        "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
         Background {{ color 0 0 0 }}
         Lights {{ numLights 1 DirectionalLight {{ direction .3 -.4 -1 color 1 1 1 }} }}
         Materials {{ numMaterials 1 Material {{ diffuseColor .7 .6 .5 specularColor 5 5 5 exponent 3000 }} }}
         Group {{ numObjects {all} MaterialIndex 0 {objects} }}"
    );
    opened(text)
}

/// Opens a scene.
pub fn opened(text: String) -> Renderer {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("scene.txt");
    std::fs::write(&path, text).expect("a file");
    Renderer::open(&path).expect("a scene")
}

/// The colours of a request, and the camera rays of a pixel on average.
fn rendered(renderer: &Renderer, request: &Request) -> (Vec<Color>, f64) {
    let request = &Request { structure: Structure::List, tracing: Tracing::Counted, ..request.clone() };
    let prepared = renderer.prepare(request).expect("no grid");
    let mut colors = vec![];
    let mut take_row = |_: usize, row: &[Color]| {
        colors.extend_from_slice(row);
        Ok(())
    };
    let rendered =
        prepared.render_rows(request, &|_| ControlFlow::Continue(()), &mut take_row).expect("a picture");
    (colors, rendered.counts.non_shadow_rays as f64 / (SIDE * SIDE) as f64)
}

/// The root mean square of the difference of pictures, in levels.
fn error(a: &[Color], b: &[Color]) -> f64 {
    let clamped = |color: &Color| color.clamp(Color::ZERO, Color::ONE);
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (clamped(a) - clamped(b)).length_squared()).sum();
    255.0 * (squares / (3 * a.len()) as f64).sqrt()
}

fn jittered(size: usize, count: u32, seed: u32) -> Request {
    let sampler = Sampler::new(Pattern::Jittered, count, Drand48::seeded(seed));
    Request { sampler, structure: Structure::List, ..Request::new([size; 2]) }
}

fn adaptive(size: usize, (most, error): (u32, f64), seed: u32) -> Request {
    let sampler = Sampler::of_adaptive(Drand48::seeded(seed));
    Request { sampler, adaptive: Some(Adaptive { most, error }), ..Request::new([size; 2]) }
}

#[test]
fn needles_and_highlights_are_found() {
    let renderer = needles_and_highlights();
    let (reference, _) = rendered(&renderer, &jittered(SIDE, 1024, 1));
    for seed in 2..5 {
        let (even, _) = rendered(&renderer, &jittered(SIDE, 32, seed));
        let of_even = error(&even, &reference);
        for asked in [2.0, 1.0] {
            let (colors, rays) = rendered(&renderer, &adaptive(SIDE, (256, asked), seed));
            let own = error(&colors, &reference);
            // The error of jittered samples is about n^-3/4.
            let rays_of_even = 32.0 * (of_even / own).powf(4.0 / 3.0);
            assert!(own < asked && rays < rays_of_even, "{asked}: {own} {of_even} {rays}");
            // Where the reference shows something, so does this.
            let is_missed = |(color, reference): (&Color, &Color)| color.x == 0.0 && reference.x > 0.05;
            let missed = colors.iter().zip(&reference).filter(|pair| is_missed(*pair)).count();
            assert_eq!(missed, 0, "of {}", colors.len());
        }
    }
}

/// A scene of so many objects.
fn scene(head: &str, materials: &str, objects: &[String]) -> Renderer {
    let text = format!(
        "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }} {head}
         Materials {{ numMaterials 2 {materials} }} Group {{ numObjects {} {} }}",
        objects.len(),
        objects.join(" ")
    );
    opened(text)
}

/// What shades the ground, with a lamp or the sun, so that shadows are smaller than a pixel.
fn shaded(light: &str, shading: &[String]) -> Renderer {
    let text = format!(
        "PerspectiveCamera {{ center 0 1 6 direction 0 -0.15 -1 up 0 1 0 angle 40 }}
         Background {{ color .1 .2 .4 ambientLight 0 0 0 }} Lights {{ numLights 1 {light} }}
         Materials {{ numMaterials 2 Material {{ diffuseColor 1 1 1 }} Material {{ diffuseColor .1 .1 .1 }} }}
         Group {{ numObjects {} MaterialIndex 0 Plane {{ normal 0 1 0 offset -1 }} MaterialIndex 1 {} }}",
        1 + shading.len(),
        shading.join(" ")
    );
    opened(text)
}

/// The error is the one that is asked for where few samples see what makes it: shadows of dots, light
/// through a sieve, in bytes and in floats, where a lamp is brighter than white.
#[test]
fn some_small_shadows_are_seen() {
    cast_small_shadows(3);
}

#[test]
#[ignore = "slow: ten seconds"]
fn small_shadows_are_seen() {
    cast_small_shadows(1);
}

/// Tries every `step`th scene.
fn cast_small_shadows(step: usize) {
    let at = |k: usize, step: f64| (0.5 + k as f64 * step).fract();
    let dot = |k: usize| {
        let [x, z] = [6.4 * at(k, 0.754_877_666) - 3.2, 6.0 * at(k, 0.569_840_291) - 4.2];
        format!("Sphere {{ center {x} 3.7 {z} radius .018 }}")
    };
    let bar = |k: usize| {
        let from = (k % 30) as f64 * 0.21 - 3.15;
        let to = from + 0.188;
        if k < 30 {
            format!("Box {{ min {from} 1.8 -4 max {to} 1.81 2.2 }}")
        } else {
            format!("Box {{ min -3.2 1.83 {from} max 3.2 1.84 {to} }}")
        }
    };
    let (dots, sieve): (Vec<_>, Vec<_>) = ((0..450).map(dot).collect(), (0..60).map(bar).collect());
    let sun = "DirectionalLight { direction -.15 -1 .1 color 1 1 1 }";
    let lamp = "PointLight { position .4 4.7 -.3 color 5 5 5 attenuation 1 0 .03 }";
    for (name, light, shading, has_floats) in [
        ("dots", sun, &dots, false),
        ("sieve", sun, &sieve, false),
        ("dots below a lamp", lamp, &dots, true),
        ("sieve below a lamp", lamp, &sieve, true),
    ]
    .into_iter()
    .step_by(step)
    {
        let renderer = shaded(light, shading);
        let prepared = renderer.prepare(&jittered(40, 1, 1)).expect("a list");
        let effects = Effects { shadows: Shadows::Opaque, ..Effects::default() };
        let colors = |request: Request| {
            let request = Request { effects, has_floats, ..request };
            let colors = prepared.render(&request).expect("memory").remove(0).colors;
            let shown = |color: Color| if has_floats { color } else { color.min(Color::ONE) };
            colors.into_iter().map(shown).collect::<Vec<_>>()
        };
        let [a, b] = [1, 2].map(|seed| colors(jittered(40, 200, seed)));
        for asked in [8.0, 3.0] {
            let mut sum = 0.0;
            for seed in [11, 12] {
                let found = colors(adaptive(40, (1024, asked), seed));
                let products = found.iter().zip(a.iter().zip(&b)).map(|(own, (a, b))| (own - a).dot(own - b));
                sum += products.sum::<f64>() / (2 * 3 * found.len()) as f64;
            }
            let error = 255.0 * sum.max(0.0).sqrt();
            assert!(error < 1.1 * asked, "{name}: {error} for {asked}");
        }
    }
}

/// The mean level of a picture.
fn mean(colors: &[Color]) -> f64 {
    255.0 * colors.iter().map(|color| color.element_sum()).sum::<f64>() / (3 * colors.len()) as f64
}

/// The mean of some numbers, and the square of its standard error.
fn statistics(numbers: &[f64]) -> [f64; 2] {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let squares: f64 = numbers.iter().map(|number| (number - mean) * (number - mean)).sum();
    [mean, squares / (count - 1.0) / count]
}

#[test]
fn no_light_is_lost_or_won() {
    sum_light(8);
}

#[test]
#[ignore = "slow: a quarter of a minute"]
fn no_light_is_lost_or_won_over_many_seeds() {
    sum_light(40);
}

/// Over this number of seeds the pictures have all the light that those of jittered samples have: of dots and needles
/// smaller than a pixel, which samples find by chance, and of a lamp that is seen in mirrors and of highlights, which are
/// found in no other way.
fn sum_light(seeds: u32) {
    let at = |k: usize| {
        let part = |step: f64| 3.6 * (0.5 + k as f64 * step).fract() - 1.8;
        [part(0.754_877_666), part(0.569_840_291)]
    };
    let plain = "Background { color 0 0 0 ambientLight 1 1 1 }";
    let dots = (0..60).map(|k| {
        let [x, y] = at(k);
        format!("MaterialIndex 0 Sphere {{ center {x} {y} 0 radius 0.012 }}")
    });
    let white = "Material { diffuseColor 1 1 1 } Material { }";
    let mirrors = (0..20).map(|k| {
        let [x, y] = at(k);
        format!("MaterialIndex 0 Sphere {{ center {x} {y} {} radius 0.3 }}", -0.7 * k as f64)
    });
    let mut mirrors: Vec<String> = mirrors.collect();
    mirrors.push("MaterialIndex 1 Sphere { center 4 6 20 radius 0.5 }".to_owned());
    let shiny = "Material { diffuseColor .1 .1 .1 reflectiveColor 1 1 1 specularColor 1 1 1 exponent 9000 }
                 Material { diffuseColor 20 20 20 }";
    let lit = "Background { color 0 0 0 ambientLight 1 1 1 }
               Lights { numLights 1 DirectionalLight { direction .3 -.4 -1 color 1 1 1 } }";
    let scenes = [
        ("dots", scene(plain, white, &dots.collect::<Vec<_>>()), 0),
        ("mirrors", scene(lit, shiny, &mirrors), 1),
        ("needles", needles_and_highlights(), 0),
    ];
    for (name, renderer, bounces) in scenes {
        let means = |request: &dyn Fn(u32) -> Request| -> [f64; 2] {
            let effects = Effects { bounces, ..Effects::default() };
            let requests = (1..=seeds).map(|seed| Request { effects, ..request(seed) });
            let means: Vec<f64> = requests.map(|request| mean(&rendered(&renderer, &request).0)).collect();
            statistics(&means)
        };
        let [expected, variance] = means(&|seed| jittered(30, 64, seed));
        for (most, error) in [(64, 2.0), (256, 8.0)] {
            let [found, own_variance] = means(&|seed| adaptive(30, (most, error), 1000 + seed));
            let deviations = (found - expected) / (variance + own_variance).sqrt();
            assert!(
                deviations.abs() < 3.5,
                "{name} {most} {error}: {found} for {expected}, {deviations} standard errors"
            );
        }
    }
}

/// The error that is estimated for `-stats` is about the true one. Where needles are the most of a picture, it is up to
/// half too large.
#[test]
fn the_error_is_estimated() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/scene6_03_sphere_plane.txt");
    let renderer = Renderer::open(&path).expect("a scene");
    let prepared = renderer.prepare(&jittered(SIDE, 1, 1)).expect("a list");
    let reference = prepared.render(&jittered(SIDE, 1024, 1)).expect("memory").remove(0).colors;
    for asked in [4.0, 1.0] {
        let [mut estimated, mut found] = [0.0; 2];
        for seed in 2..6 {
            let request = adaptive(SIDE, (1024, asked), seed);
            let mut colors = vec![];
            let mut take_row = |_: usize, row: &[Color]| {
                colors.extend_from_slice(row);
                Ok(())
            };
            let go_on = |_| ControlFlow::Continue(());
            let rendered = prepared.render_rows(&request, &go_on, &mut take_row).expect("a picture");
            estimated += 255.0 * (rendered.squared_error / (SIDE * SIDE) as f64).sqrt();
            found += error(&colors, &reference);
        }
        assert!((0.75..1.25).contains(&(estimated / found)), "{asked}: {estimated} for {found}");
    }
}
