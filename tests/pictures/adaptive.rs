//! Adaptive samples where they are hardest: small things, which four samples of a pixel may miss.

use raytracer::render::{Request, Tracing};
use raytracer::renderer::{Meshes, Renderer};
use raytracer::sampling::adaptive::Adaptive;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Color;
use raytracer::scene_io::{self, LoadedScene};
use raytracer::stats::Counts;
use std::fmt::Write;
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
        writeln!(
            objects,
            "Triangle {{ vertex0 {} {} 1 vertex1 {} {} 1 vertex2 {} {} 1 }}",
            x + dx,
            y + dy,
            x - dx,
            y - dy,
            -x,
            -y
        )
        .expect("a string takes it");
    }
    let spheres = [(-1.2, -1.3), (1.3, -1.2), (1.2, 1.3), (-1.3, 1.2)];
    for (x, y) in spheres {
        writeln!(objects, "Sphere {{ center {x} {y} 0 radius .4 }}").expect("a string takes it");
    }
    let all = count as usize + spheres.len();
    let text = format!(
        "OrthographicCamera {{ center 0 0 5 direction 0 0 -1 up 0 1 0 size 4 }}
         Background {{ color 0 0 0 }}
         Lights {{ numLights 1 DirectionalLight {{ direction .3 -.4 -1 color 1 1 1 }} }}
         Materials {{ numMaterials 1 Material {{ diffuseColor .7 .6 .5 specularColor 5 5 5 exponent 3000 }} }}
         Group {{ numObjects {all} MaterialIndex 0 {objects} }}"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("needles.txt");
    std::fs::write(&path, text).expect("a file");
    let loaded: LoadedScene = scene_io::load(&path).expect("a scene");
    Renderer::new(loaded, Meshes::Moved).expect("a world")
}

/// The colours of a request, and the camera rays of a pixel on average.
fn rendered(renderer: &Renderer, request: &Request) -> (Vec<Color>, f64) {
    let prepared = renderer.prepare(None, 1, Tracing::Counted).expect("no grid");
    let mut colors = vec![];
    let mut take_row = |_: usize, row: &[Color]| {
        colors.extend_from_slice(row);
        ControlFlow::Continue(())
    };
    let counts: Counts =
        prepared.render_rows(request, &|_| ControlFlow::Continue(()), &mut take_row).expect("a picture");
    (colors, counts.non_shadow_rays as f64 / (SIDE * SIDE) as f64)
}

/// The root mean square of the difference of pictures, in levels.
fn error(a: &[Color], b: &[Color]) -> f64 {
    let clamped = |color: &Color| color.clamp(Color::ZERO, Color::ONE);
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (clamped(a) - clamped(b)).length_squared()).sum();
    255.0 * (squares / (3 * a.len()) as f64).sqrt()
}

#[test]
fn needles_and_highlights_are_found() {
    let renderer = needles_and_highlights();
    let jittered = |count, seed| Request {
        sampler: Sampler::new(Pattern::Jittered, count, Drand48::seeded(seed)),
        ..Request::new([SIDE; 2])
    };
    let adaptive = |most, error, seed| Request {
        sampler: Sampler::first_of_adaptive(Drand48::seeded(seed)),
        adaptive: Some(Adaptive { most, error }),
        ..Request::new([SIDE; 2])
    };
    let (reference, _) = rendered(&renderer, &jittered(1024, 1));
    // With less than a fifth of the samples the error is about that of 64 everywhere.
    for seed in 2..5 {
        let (even, _) = rendered(&renderer, &jittered(64, seed));
        let (colors, rays) = rendered(&renderer, &adaptive(64, 1.0, seed));
        let errors = [&colors, &even].map(|colors| error(colors, &reference));
        assert!(errors[0] < 1.5 * errors[1] && rays < 12.0, "{errors:?} {rays}");
        // Where the reference shows something, so does this.
        let is_missed = |(color, reference): (&Color, &Color)| color.x == 0.0 && reference.x > 0.02;
        let missed = colors.iter().zip(&reference).filter(|pair| is_missed(*pair)).count();
        assert_eq!(missed, 0, "of {}", colors.len());
    }
}
