//! Prints `docs/sampling.md`: the error of pictures with few samples, for each sampler.
//!
//! `cargo run --release --example sampling_error > docs/sampling.md`

use glam::DVec2;
use raytracer::camera::Camera;
use raytracer::grid::Caster;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::scene::Color;
use raytracer::scene_io::load;
use raytracer::stats::Quiet;
use raytracer::trace::{Effects, Pending, Shadows, Tracer};
use raytracer::world::World;

use rayon::prelude::*;
use std::error::Error;
use std::path::Path;

/// The width and height of the pictures in pixels.
const SIDE: usize = 40;
const COUNTS: [u32; 5] = [1, 4, 16, 64, 256];
const PATTERNS: [(Pattern, &str); 3] =
    [(Pattern::Random, "random"), (Pattern::Uniform, "uniform"), (Pattern::Jittered, "jittered")];
/// The number of samples per pixel of the reference, and its seed, which makes them independent of the others.
const REFERENCE: (u32, u32) = (4096, 1);

/// A scene to measure. `flags` are the command-line flags for `effects`.
struct Subject {
    scene: &'static str,
    shows: &'static str,
    flags: &'static str,
    effects: Effects,
}

const SUBJECTS: [Subject; 2] = [
    Subject {
        scene: "scene6_13_checkerboard.txt",
        shows: "edges, and squares that become smaller than a pixel",
        flags: "-shadows",
        effects: Effects { shadows: Shadows::Opaque, shade_back: false, bounces: 0, min_weight: 0.0 },
    },
    Subject {
        scene: "scene6_14_glass_sphere.txt",
        shows: "a sphere that refracts what is behind it",
        flags: "-shadows -shade_back -bounces 5 -weight 0.01",
        effects: Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 5, min_weight: 0.01 },
    },
];

fn main() -> Result<(), Box<dyn Error>> {
    let (count, seed) = REFERENCE;
    println!(
        "# Error against samples

The error of a picture is the root mean square, over all pixels and channels, of its difference from a
reference, in units of 1/255. Colours are compared before they are converted to bytes, but clamped to the range
of a byte. The pictures have {SIDE} x {SIDE} pixels and the default filter, a box with a radius of half a pixel.
The reference has {count} jittered samples per pixel with `-seed {seed}`, and the other pictures use the course's
random numbers. The last column is the exponent p with which the error falls as n^(-p) from n = 4 to n = 256
samples."
    );
    for subject in &SUBJECTS {
        print_table(subject)?;
    }
    println!(
        "
A single uniform sample is at the pixel's centre. The error of n independent samples falls as n^(-1/2). Of the
jittered samples only those whose stratum contains an edge have an error, so p approaches 3/4 if the
edges are few and sharp. Uniform samples are not much better than random ones here, and their errors repeat from
pixel to pixel, which is visible as a pattern, while the errors of the others look like noise.

This file is the output of `cargo run --release --example sampling_error > docs/sampling.md`; it is the same
on every machine."
    );
    Ok(())
}

fn print_table(Subject { scene, shows, flags, effects }: &Subject) -> Result<(), Box<dyn Error>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let loaded = load(&folder.join(scene))?;
    let world = World::new(&loaded.scene, &loaded.meshes)?;
    let caster = Caster::new(&world, Some([10; 3]))?;
    let camera = Camera::new(&loaded.scene.camera, [SIDE; 2]);
    let tracer = Tracer { caster: &caster, effects: *effects };
    let picture = |sampler| picture(&tracer, &camera, sampler);
    let reference = picture(Sampler::new(Pattern::Jittered, REFERENCE.0, Drand48::seeded(REFERENCE.1)));

    let heads: String = COUNTS.iter().map(|count| format!(" {count} |")).collect();
    println!("\n## {scene}\n\nShows {shows}. Flags: `{flags}`.\n\n| samples |{heads} p |");
    println!("|---|{}---:|", "---:|".repeat(COUNTS.len()));
    for (pattern, name) in PATTERNS {
        let errors =
            COUNTS.map(|count| error(&picture(Sampler::new(pattern, count, Drand48::UNSEEDED)), &reference));
        let cells: String = errors.iter().map(|error| format!(" {error:.2} |")).collect();
        println!("| {name} |{cells} {:.2} |", power(errors));
    }
    Ok(())
}

/// The exponent with which the error falls from the second to the last of [`COUNTS`].
fn power(errors: [f64; COUNTS.len()]) -> f64 {
    let (first, last) = (1, COUNTS.len() - 1);
    (errors[first] / errors[last]).ln() / (f64::from(COUNTS[last]) / f64::from(COUNTS[first])).ln()
}

/// The root mean square of the difference, in units of 1/255.
fn error(picture: &[Color], reference: &[Color]) -> f64 {
    let squares: f64 = picture.iter().zip(reference).map(|(a, b)| (*a - *b).length_squared()).sum();
    255.0 * (squares / (3 * picture.len()) as f64).sqrt()
}

/// The mean of each pixel's samples, in the sampler's order of pixels.
fn picture(tracer: &Tracer, camera: &Camera, sampler: Sampler) -> Vec<Color> {
    let pixel = |pending: &mut Pending, index: usize| {
        let position = DVec2::new((index / SIDE) as f64, (index % SIDE) as f64);
        let color = |offset| color(tracer, &camera.ray(position, offset), pending);
        let sum: Color = sampler.offsets(index as u64).map(color).sum();
        (sum / f64::from(sampler.count())).clamp(Color::ZERO, Color::ONE)
    };
    (0..SIDE * SIDE).into_par_iter().map_init(Pending::default, pixel).collect()
}

fn color(tracer: &Tracer, ray: &raytracer::math::ray::Ray, pending: &mut Pending) -> Color {
    let hit = tracer.caster.closest(ray, &mut Quiet);
    let surface = hit.map(|hit| tracer.caster.world.surface(ray, &hit));
    tracer.color(ray, surface.as_ref(), pending, &mut Quiet)
}
