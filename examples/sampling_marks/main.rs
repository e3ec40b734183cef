//! Measures adaptive samples by their marks: without bias, as exact as they are asked to be, and no slower than jittered
//! samples at the same error.
//!
//! `cargo run --release --example sampling_marks -- [-size side] [-seeds count] [-most samples]
//! [-reference samples] [scene ...]`
//!
//! *bias* is the mean error of the picture's colours over all seeds with its standard error, in levels. *RMSE* is that of
//! the picture as it is shown. *speed-up* is the time that jittered samples take to the same error, interpolated, over the
//! time of the adaptive ones, and *fewer rays* is the same of rays. Times are those of one thread's processor.

mod scenes;

use rayon::{ThreadPool, ThreadPoolBuilder};
use raytracer::cli::{Command, Options, parse};
use raytracer::command::processor_time;
use raytracer::picture::{Color, FloatPicture};
use raytracer::render::renderer::{Meshes, Prepared, Renderer};
use raytracer::render::{Layer, Request};
use raytracer::sampling::adaptive::Adaptive;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::sampler::{Pattern, Sampler};
use scenes::{CASES, Case};
use std::error::Error;
use std::ops::ControlFlow;
use std::time::Duration;

/// The errors that are asked for, in levels.
const ERRORS: [f64; 6] = [16.0, 8.0, 4.0, 2.0, 1.0, 0.5];
/// The errors at which the bias is looked at.
const BIASED: [f64; 2] = [2.0, 16.0];
/// The numbers of jittered samples.
const COUNTS: [u32; 8] = [1, 2, 4, 8, 16, 64, 256, 1024];
/// The seeds over which errors are averaged.
const ERROR_SEEDS: u32 = 4;

struct Settings {
    side: usize,
    seeds: u32,
    most: u32,
    /// The samples of each half of the reference.
    reference: u32,
    names: Vec<String>,
}

fn settings() -> Result<Settings, Box<dyn Error>> {
    let mut settings = Settings { side: 60, seeds: 40, most: 1024, reference: 2048, names: vec![] };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number =
            || words.next().ok_or("a number is missing")?.parse::<u32>().map_err(Box::<dyn Error>::from);
        match word.as_str() {
            "-size" => settings.side = number()? as usize,
            "-seeds" => settings.seeds = number()?,
            "-most" => settings.most = number()?,
            "-reference" => settings.reference = number()?,
            _ => settings.names.push(word),
        }
    }
    Ok(settings)
}

fn main() -> Result<(), Box<dyn Error>> {
    let settings = settings()?;
    let mut speed_ups = vec![];
    println!(
        "| scene | asked for | bias | RMSE | RMSE / asked for | rays | s | fewer rays | speed-up |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|"
    );
    let is_wanted =
        |case: &&Case| settings.names.is_empty() || settings.names.iter().any(|name| name == case.name);
    for case in CASES.iter().filter(is_wanted) {
        let measured = measure(case, &settings)?;
        println!("| {} | all | | | | | | | **{:.2}** |", case.name, geometric_mean(&measured));
        speed_ups.push(geometric_mean(&measured));
    }
    println!("\nGeometric mean of the speed-ups: {:.2}.", geometric_mean(&speed_ups));
    Ok(())
}

fn geometric_mean(numbers: &[f64]) -> f64 {
    (numbers.iter().map(|x| x.ln()).sum::<f64>() / numbers.len() as f64).exp()
}

/// Prints the rows of a scene, and returns the speed-up at each error.
fn measure(case: &Case, settings: &Settings) -> Result<Vec<f64>, Box<dyn Error>> {
    let Settings { side, seeds, most, .. } = *settings;
    let words = format!("raytracer -input s -size {side} {side} {}", case.flags);
    let Command::Render(options) = parse(words.split_whitespace().map(Into::into))? else {
        return Err("no rendering".into());
    };
    let options: Options = *options;
    let renderer = Renderer::new(case.load()?, Meshes::Kept)?;
    let (many, one) = (ThreadPoolBuilder::new().build()?, ThreadPoolBuilder::new().num_threads(1).build()?);
    let base = Request { layers: vec![Layer::Color], ..options.request() };
    let jittered = |count, seed| Request {
        sampler: Sampler::new(Pattern::Jittered, count, Drand48::seeded(seed)),
        ..base.clone()
    };
    let adaptive = |error, seed| Request {
        sampler: Sampler::of_adaptive(Drand48::seeded(seed)),
        adaptive: Some(Adaptive { most, error }),
        ..base.clone()
    };
    let prepared = renderer.prepare(&jittered(settings.reference, 0))?;
    let halves =
        [1001, 2002].map(|seed| many.install(|| prepared.render(&jittered(settings.reference, seed))));
    let [a, b] = halves;
    let halves = [a?.remove(0), b?.remove(0)];

    let mut curve = vec![];
    for count in COUNTS.into_iter().filter(|&count| count <= settings.reference) {
        let requests: Vec<Request> = (1..=ERROR_SEEDS).map(|seed| jittered(count, seed)).collect();
        curve.push(time_and_error(&prepared, &one, &requests, &halves)?);
    }
    let mut speed_ups = vec![];
    for error in ERRORS {
        let requests: Vec<Request> = (1..=ERROR_SEEDS).map(|seed| adaptive(error, seed)).collect();
        let [time, found, rays] = time_and_error(&prepared, &one, &requests, &halves)?;
        let bias = if BIASED.contains(&error) && seeds > 0 {
            let requests = (1..=seeds).map(|seed| adaptive(error, 100 + seed));
            let [bias, deviation] = bias(&prepared, &many, requests, &halves)?;
            format!("{bias:+.4} ± {deviation:.4} ({:+.1})", bias / deviation)
        } else {
            String::new()
        };
        let (gain, shown) = match cost_of(found, &curve) {
            Some([cost, many]) => (cost / time, format!("{:.2} | {:.2}", many / rays, cost / time)),
            None => (f64::NAN, "- | -".into()),
        };
        if gain.is_finite() {
            speed_ups.push(gain);
        }
        println!(
            "| {} | {error} | {bias} | {found:.3} | {:.2} | {rays:.1} | {time:.4} | {shown} |",
            case.name,
            found / error
        );
    }
    Ok(speed_ups)
}

/// The least time of a render in seconds, the root mean square error of all, and the rays for a pixel.
fn time_and_error(
    prepared: &Prepared,
    one: &ThreadPool,
    requests: &[Request],
    halves: &[FloatPicture; 2],
) -> Result<[f64; 3], Box<dyn Error>> {
    let (mut least, mut sum) = (Duration::MAX, 0.0);
    for request in requests {
        let (picture, time) = one.install(|| {
            let start = processor_time();
            let rendered = prepared.render(request);
            (rendered, processor_time() - start)
        });
        least = least.min(time);
        sum += mean_square(&picture?[0], halves);
    }
    let go_on = |_| ControlFlow::Continue(());
    let rendered = prepared.render_rows(&requests[0], &go_on, &mut |_, _| ControlFlow::Continue(()))?;
    let pixels = requests[0].size.iter().product::<usize>() as f64;
    let error = 255.0 * (sum / requests.len() as f64).max(0.0).sqrt();
    Ok([least.as_secs_f64(), error, rendered.counts.rays() as f64 / pixels])
}

/// The mean square error, from which the noise of the reference's halves cancels.
fn mean_square(picture: &FloatPicture, [a, b]: &[FloatPicture; 2]) -> f64 {
    let shown = |color: Color| color.clamp(Color::ZERO, Color::ONE);
    let products = picture
        .colors
        .iter()
        .zip(&a.colors)
        .zip(&b.colors)
        .map(|((&color, &a), &b)| ((shown(color) - shown(a)) * (shown(color) - shown(b))).element_sum());
    products.sum::<f64>() / (3 * picture.colors.len()) as f64
}

/// The mean of a picture in levels.
fn mean(picture: &FloatPicture) -> f64 {
    255.0 * picture.colors.iter().map(|color| color.element_sum()).sum::<f64>()
        / (3 * picture.colors.len()) as f64
}

/// The mean error, and its standard error, which has that of the reference.
fn bias(
    prepared: &Prepared,
    many: &ThreadPool,
    requests: impl Iterator<Item = Request>,
    halves: &[FloatPicture; 2],
) -> Result<[f64; 2], Box<dyn Error>> {
    let mut means = vec![];
    for request in requests {
        means.push(mean(&many.install(|| prepared.render(&request))?[0]));
    }
    let count = means.len() as f64;
    let average = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|x| (x - average).powi(2)).sum::<f64>() / (count - 1.0) / count;
    let [a, b] = halves;
    // The noise of pixels is independent, so that their differences say how far the mean is off.
    let difference = |(a, b): (&Color, &Color)| (255.0 / 6.0 * (*a - *b).element_sum()).powi(2);
    let noise = a.colors.iter().zip(&b.colors).map(difference).sum::<f64>() / (a.colors.len() as f64).powi(2);
    Ok([average - 0.5 * (mean(a) + mean(b)), (variance + noise).sqrt()])
}

/// The time and the rays with which a curve has this error, interpolated in logarithms, and continued from its first two
/// or last two points.
fn cost_of(error: f64, curve: &[[f64; 3]]) -> Option<[f64; 2]> {
    let next = curve.iter().position(|point| point[1] <= error).unwrap_or(curve.len() - 1).max(1);
    let [one, other] = [curve[next - 1], curve[next]];
    let share = (one[1] / error).ln() / (one[1] / other[1]).ln();
    let cost = [0, 2].map(|k| (one[k].ln() + share * (other[k] / one[k]).ln()).exp());
    cost.iter().all(|cost| cost.is_finite()).then_some(cost)
}
