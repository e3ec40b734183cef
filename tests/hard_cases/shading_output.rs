//! Section F, input and output: hostile input, bytes of colours, sums of samples.

use crate::support::double_double::Dd;
use crate::support::measure::{Failures, measure};
use crate::support::record::{Basis, Record};
use crate::support::rng::Rng;
use crate::support::scenes::{layers, scene_of};
use crate::support::{hex, rays};
use glam::{DVec2, DVec3};
use raytracer::caster::Caster;
use raytracer::math::instructions;
use raytracer::picture::FloatPicture;
use raytracer::render::{Request, Tracing};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::film::Film;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::sampling::spread::Spread;
use raytracer::scene::{Light, Object, Scene};
use raytracer::trace::{Effects, Shadows};
use raytracer::world::World;

/// The byte of an f32 textbook: 255 c converted to a 32-bit integer, as by a cast in C.
fn textbook_byte(c: f64) -> u8 {
    (c as f32 * 255.0) as i32 as u8
}

/// The exact byte: 255 c truncated and clamped. The product of two floats is exact in double-double.
fn exact_byte(c: f64) -> u8 {
    let Dd { hi, lo } = Dd::from(c) * Dd::from(255.0);
    let below = hi.floor() - if hi == hi.floor() && lo < 0.0 { 1.0 } else { 0.0 };
    below.clamp(0.0, 255.0) as u8
}

/// Whether `c` is the float nearest to `byte` / 255. Where that is below the fraction, truncating the exact
/// product gives the byte below, but the rounded product gives the byte that was meant.
fn means_byte(c: f64, byte: u8) -> bool {
    c == f64::from(byte) / 255.0
}

#[test]
fn case_62_bytes_of_colours() {
    const STEPS: u64 = 1_000_000;
    let failures = Failures::default();
    let (ramp, []) = measure(STEPS + 1, |i| {
        // Every step also as the float before and after it; every tenth step far outside 0 to 1.
        let c = i as f64 / STEPS as f64;
        let colors = [c, c.next_down(), c.next_up(), if i % 10 == 0 { 20.0 * (c - 0.5) } else { c }];
        let mut counts = [0; 3];
        for c in colors {
            let (byte, exact) = (bytes_of(vec![DVec3::splat(c)]).0[0], exact_byte(c));
            let meant = byte != exact && means_byte(c, byte);
            counts[0] +=
                failures.note(byte != exact && !meant, || format!("case 62: {} {byte} {exact}", hex(c)));
            counts[1] += meant as u64;
            counts[2] += (textbook_byte(c) != exact) as u64;
        }
        (counts, [])
    });
    let hostile = [f64::NAN, -f64::NAN].map(|c| DVec3::new(0.5, c, 0.5));
    let (bytes, nans) = bytes_of(hostile.into());
    let beyond =
        [f64::INFINITY, 1e300, f64::NEG_INFINITY, -1e300].map(|c| bytes_of(vec![DVec3::splat(c)]).0[0]);
    let meant = (0..=255u8).filter(|&b| exact_byte(f64::from(b) / 255.0) != b).count();
    Record {
        case: 62,
        basis: Basis::Sampled,
        name: "bytes of colours",
        inputs: format!("{} colours of a ramp, their neighbours, values from -10 to 10, NaN, infinities", 4 * (STEPS + 1)),
        measure: "bytes other than 255 c cut and clamped (not rounded: the course's rule); NaN not counted",
        textbook: format!("f32 and C's cast: {}; NaN a silent 0", ramp[2]),
        ours: format!(
            "{}; {}. The float nearest to k/255 becomes k also where it lies below k/255: {meant} of 256, met {} times",
            ramp[0],
            2 - nans,
            ramp[1]
        ),
        target: "0; 0",
    }
    .write();
    assert!(ramp[2] > 0, "the textbook method does not fail");
    assert_eq!((ramp[0], nans, bytes, beyond), (0, 2, [127, 0, 127].repeat(2), [255, 255, 0, 0]));
}

/// A scene with enough shadows and reflections for pixels to differ in every bit.
fn busy_scene() -> Scene {
    let sphere = |x: f64, z: f64| Object::Sphere { center: DVec3::new(x, 0.5, z), radius: 0.5, material: 0 };
    let objects = (0..9).map(|i| sphere((i % 3) as f64 - 1.0, -((i / 3) as f64)));
    let ground = Object::Plane { normal: DVec3::Y, offset: 0.0, material: 0 };
    let lights = [DVec3::new(3.0, 4.0, 2.0), DVec3::new(-2.0, 3.0, 1.0)].map(|position| Light::Point {
        position,
        color: DVec3::splat(0.7),
        attenuation: [1.0, 0.05, 0.01],
    });
    let mut scene = scene_of(objects.chain([ground]).collect(), lights.into());
    let (center, direction) = (DVec3::new(0.3, 2.0, 5.0), DVec3::new(0.0, -0.35, -1.0));
    scene.camera = raytracer::scene::Camera::Perspective { center, direction, up: DVec3::Y, angle: 40.0 };
    scene
}

fn bytes_of(colors: Vec<DVec3>) -> (Vec<u8>, u64) {
    FloatPicture { size: [colors.len(), 1], colors }.to_bytes()
}

/// The picture of the busy scene, rendered by this number of threads.
fn picture_by(threads: usize, size: [usize; 2], samples: u32, filter: Filter) -> Vec<u8> {
    let scene = busy_scene();
    let world = World::new(&scene, &[]).expect("a sound scene");
    let caster = Caster::new(&world, Some([4; 3])).expect("a grid");
    let effects = Effects { shadows: Shadows::Opaque, ..Effects::default() };
    let sampler = Sampler::new(Pattern::Jittered, samples, Drand48::UNSEEDED);
    let request = Request { effects, sampler, filter, ..Request::new(size) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| layers(&scene, &caster, &request, Tracing::Fast)).concat()
}

/// The number of sums that change when the same samples are added in another order by a textbook's f32
/// accumulator.
fn shuffled_sums(sums: u64, samples: usize) -> u64 {
    let (counts, []) = measure(sums, |index| {
        let mut rng = Rng::at(63, index);
        let mut values: Vec<f32> = (0..samples).map(|_| rng.unit() as f32).collect();
        let straight: f32 = values.iter().sum();
        for i in (1..values.len()).rev() {
            values.swap(i, rng.below(i + 1));
        }
        ([(values.iter().sum::<f32>() != straight) as u64], [])
    });
    counts[0]
}

#[test]
fn case_63_threads() {
    let scale = rays(1, 4) as usize;
    let (mut different, mut tried) = (0, 0);
    for (samples, side) in [(1, 160), (9, 60), (64, 24), (4096, 4)] {
        for filter in [Filter::PIXEL, Filter::Gaussian { sigma: 0.8 }] {
            let size = [side * scale, (side - 1) * scale];
            let one = picture_by(1, size, samples, filter);
            for threads in [2, 3, 7, 64] {
                let other = picture_by(threads, size, samples, filter);
                different += one.iter().zip(&other).filter(|(a, b)| a != b).count();
                tried += size[0] * size[1] * samples as usize;
            }
        }
    }
    let sums = 1000;
    let textbook = shuffled_sums(sums, 256);
    Record {
        case: 63,
        basis: Basis::Sampled,
        name: "1, 2, 3, 7 and 64 threads, 1 to 4096 samples a pixel",
        inputs: format!("{tried} samples"),
        measure: "bytes that differ from one thread's",
        textbook: format!("f32 sums of 256 samples in the order of arrival: {textbook} of {sums} differ"),
        ours: different.to_string(),
        target: "0",
    }
    .write();
    assert!(textbook > 0, "the textbook method does not fail");
    assert_eq!(different, 0);
}

/// The film's mean of a pixel's samples.
fn film_mean(values: &[f64]) -> f64 {
    let mut film = Film::new(Filter::PIXEL, [1, 1], 0);
    let mut spread = Spread::new(Filter::PIXEL, instructions::available()[0], 0, [1, 1]);
    values.iter().for_each(|&v| spread.add(0, DVec2::ZERO, DVec3::splat(v), 1.0));
    let mut mean = f64::NAN;
    let mut finish = |_: usize, colors: &mut dyn Iterator<Item = DVec3>| {
        mean = colors.next().map_or(f64::NAN, |c| c.x);
    };
    film.add(spread, &mut finish);
    mean
}

#[test]
fn case_64_long_sums() {
    const SAMPLES: usize = 4096;
    let inputs = rays(1000, 100_000);
    let (_, [ours, textbook]) = measure(inputs, |index| {
        let mut rng = Rng::at(64, index);
        // The bright sample comes first, which is the worst case, or in a random position.
        let bright = if index % 4 == 0 { 0 } else { rng.below(SAMPLES) };
        let dim = if index % 2 == 0 { 1e-4 } else { rng.range(0.5e-4, 2e-4) };
        let values: Vec<f64> = (0..SAMPLES).map(|i| if i == bright { 1e4 } else { dim }).collect();
        let sum = values.iter().fold(Dd::ZERO, |sum, &v| sum + v.into());
        let exact = sum / Dd::from(SAMPLES as f64);
        let mean32 = values.iter().map(|&v| v as f32).sum::<f32>() / SAMPLES as f32;
        let relative = |mean: f64| (Dd::from(mean) - exact).abs().value() / exact.value();
        ([], [relative(film_mean(&values)), relative(mean32.into())])
    });
    Record {
        case: 64,
        basis: Basis::Sampled,
        name: "mean of 4095 samples of 1e-4 and one of 1e4",
        inputs: format!("{inputs} means of {SAMPLES} samples"),
        measure: "largest relative error of the mean",
        textbook: format!("f32 accumulator: {textbook:.1e}"),
        ours: format!("{ours:.1e}"),
        target: "<= 1e-12",
    }
    .write();
    assert!(textbook > 1e-6, "the textbook method does not fail");
    assert!(ours <= 1e-12);
}
