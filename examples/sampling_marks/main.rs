//! Measures adaptive samples: how much error they leave for what was asked, and the rays and the time that samples of a
//! fixed number take to the same error.
//!
//! `cargo run --release --example sampling_marks -- [-size side] [-seeds count] [-most samples]
//! [-reference samples] [-fixed seeds] [-bias seeds] [scene ...]`
//!
//! *RMS* is the root mean square of the errors of all seeds over what was asked, *worst* is that of the worst seed.
//! *Estimated* is the error that the program estimates. The errors are those of the picture as it is shown. Times are
//! means of the processor times of one thread. `-bias` measures the mean error of the colours over this number of seeds,
//! with its standard error, in levels.

mod scenes;

use rayon::{ThreadPool, ThreadPoolBuilder};
use raytracer::base::processor_time::processor_time;
use raytracer::cli::{Command, Options, parse};
use raytracer::picture::{Color, FloatPicture};
use raytracer::render::adaptive::Adaptive;
use raytracer::render::renderer::{Meshes, Prepared, Renderer};
use raytracer::render::{Layer, Request};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::sampler::{Pattern, Sampler};
use scenes::{CASES, Case};
use std::error::Error;
use std::ops::ControlFlow;
use std::time::Duration;

/// The errors that are asked for, in levels.
const ERRORS: [f64; 4] = [8.0, 4.0, 2.0, 1.0];
/// The errors whose bias is measured.
const BIASED: [f64; 2] = [8.0, 2.0];
/// The patterns with a fixed number of samples, and their numbers.
const PATTERNS: [Pattern; 2] = [Pattern::Jittered, Pattern::Sobol];
const COUNTS: [u32; 6] = [1, 4, 16, 64, 256, 1024];

struct Settings {
    side: usize,
    seeds: u32,
    most: u32,
    /// The samples of each half of the reference.
    reference: u32,
    /// The seeds over which the errors of a fixed number of samples are averaged.
    fixed: u32,
    bias: u32,
    names: Vec<String>,
}

/// The cost and the error of a setting, over several seeds.
#[derive(Clone, Copy)]
struct Measured {
    rays: f64,
    /// The mean time, in seconds.
    time: f64,
    /// The root mean square error in levels: of all seeds, and of the worst one.
    error: f64,
    worst: f64,
    /// The error that adaptive samples estimate, in levels.
    estimated: f64,
}

fn settings() -> Result<Settings, Box<dyn Error>> {
    let mut settings =
        Settings { side: 60, seeds: 16, most: 1024, reference: 1024, fixed: 4, bias: 0, names: vec![] };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut number =
            || words.next().ok_or("a number is missing")?.parse::<u32>().map_err(Box::<dyn Error>::from);
        match word.as_str() {
            "-size" => settings.side = number()? as usize,
            "-seeds" => settings.seeds = number()?,
            "-most" => settings.most = number()?,
            "-reference" => settings.reference = number()?,
            "-fixed" => settings.fixed = number()?,
            "-bias" => settings.bias = number()?,
            _ => settings.names.push(word),
        }
    }
    Ok(settings)
}

fn main() -> Result<(), Box<dyn Error>> {
    let settings = settings()?;
    let fixed = PATTERNS.map(|pattern| format!("{pattern:?}: rays | s")).join(" | ");
    println!("| scene | asked | RMS / asked | worst / asked | rays | s | estimated / RMS | {fixed} |");
    println!("|---|{}", "---:|".repeat(6 + 2 * PATTERNS.len()));
    let is_wanted =
        |case: &&Case| settings.names.is_empty() || settings.names.iter().any(|name| name == case.name);
    CASES.iter().filter(is_wanted).try_for_each(|case| measure(case, &settings))
}

/// Prints the rows of a scene.
fn measure(case: &Case, settings: &Settings) -> Result<(), Box<dyn Error>> {
    let Settings { side, seeds, most, .. } = *settings;
    let words = format!("raytracer -input s -size {side} {side} {}", case.flags);
    let Command::Render(options) = parse(words.split_whitespace().map(Into::into))? else {
        return Err("no rendering".into());
    };
    let options: Options = *options;
    let renderer = Renderer::new(case.load()?, Meshes::Kept)?;
    let (many, one) = (ThreadPoolBuilder::new().build()?, ThreadPoolBuilder::new().num_threads(1).build()?);
    let base = Request { layers: vec![Layer::Color], ..options.request() };
    let fixed = |pattern, count, seed| Request {
        sampler: Sampler::new(pattern, count, Drand48::seeded(seed)),
        ..base.clone()
    };
    let adaptive = |error, seed| Request {
        sampler: Sampler::of_adaptive(Drand48::seeded(seed)),
        adaptive: Some(Adaptive { most, error }),
        ..base.clone()
    };
    let reference = |seed| fixed(Pattern::Sobol, settings.reference, seed);
    let prepared = renderer.prepare(&reference(0))?;
    let [a, b] = [1001, 2002].map(|seed| many.install(|| prepared.render(&reference(seed))));
    let halves = [a?.remove(0), b?.remove(0)];

    if settings.bias > 0 {
        for error in BIASED {
            let requests = (1..=settings.bias).map(|seed| adaptive(error, 100 + seed));
            let [bias, deviation] = bias(&prepared, &many, requests, &halves)?;
            let ratio = bias / deviation;
            println!("{} asked {error}: bias {bias:+.4} ± {deviation:.4} ({ratio:+.1})", case.name);
        }
    }
    let curve = |pattern| {
        let of_count = |&count: &u32| {
            let requests: Vec<Request> =
                (1..=settings.fixed).map(|seed| fixed(pattern, count, seed)).collect();
            measure_requests(&prepared, &one, &requests, &halves)
        };
        COUNTS.iter().map(of_count).collect::<Result<Vec<_>, _>>()
    };
    let curves = if settings.fixed > 0 {
        PATTERNS.map(curve).into_iter().collect::<Result<Vec<_>, _>>()?
    } else {
        vec![]
    };
    for error in ERRORS.into_iter().filter(|_| seeds > 0) {
        let requests: Vec<Request> = (1..=seeds).map(|seed| adaptive(error, seed)).collect();
        let found = measure_requests(&prepared, &one, &requests, &halves)?;
        let fixed = curves.iter().map(|curve| match cost_of(found.error, curve) {
            Some([rays, time]) => format!("{rays:.1} | {time:.4}"),
            None => "- | -".into(),
        });
        println!(
            "| {} | {error} | {:.2} | {:.2} | {:.1} | {:.4} | {:.2} | {} |",
            case.name,
            found.error / error,
            found.worst / error,
            found.rays,
            found.time,
            found.estimated / found.error,
            fixed.collect::<Vec<_>>().join(" | ")
        );
    }
    Ok(())
}

/// Renders the requests with one thread.
fn measure_requests(
    prepared: &Prepared,
    one: &ThreadPool,
    requests: &[Request],
    halves: &[FloatPicture; 2],
) -> Result<Measured, Box<dyn Error>> {
    let (mut all, mut squares, mut rays, mut estimated) = (Duration::ZERO, vec![], 0, 0.0);
    for request in requests {
        let mut colors = vec![];
        let mut take_row = |_: usize, row: &[Color]| {
            colors.extend_from_slice(row);
            Ok(())
        };
        let go_on = |_| ControlFlow::Continue(());
        let (rendered, time) = one.install(|| {
            let start = processor_time();
            let rendered = prepared.render_rows(request, &go_on, &mut take_row);
            (rendered, processor_time() - start)
        });
        let rendered = rendered?;
        rays += rendered.counts.rays();
        estimated += rendered.squared_error;
        all += time;
        squares.push(mean_square(&FloatPicture { size: request.size, colors }, halves));
    }
    let pixels = requests[0].size.iter().product::<usize>() as f64;
    let count = requests.len() as f64;
    let levels = |square: f64| 255.0 * square.max(0.0).sqrt();
    Ok(Measured {
        rays: rays as f64 / pixels / count,
        time: all.as_secs_f64() / count,
        error: levels(squares.iter().sum::<f64>() / count),
        estimated: levels(estimated / pixels / count),
        worst: levels(squares.iter().fold(0.0, |most, &square| f64::max(most, square))),
    })
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

/// The rays and the time with which a curve has this error, interpolated in logarithms, and continued from its first
/// two or last two points.
fn cost_of(error: f64, curve: &[Measured]) -> Option<[f64; 2]> {
    let next = curve.iter().position(|point| point.error <= error).unwrap_or(curve.len() - 1).max(1);
    let [one, other] = [curve[next - 1], curve[next]];
    let share = (one.error / error).ln() / (one.error / other.error).ln();
    let between = |one: f64, other: f64| (one.ln() + share * (other / one).ln()).exp();
    let cost = [between(one.rays, other.rays), between(one.time, other.time)];
    cost.iter().all(|cost| cost.is_finite()).then_some(cost)
}
