//! Estimates the difference of a picture from the converged one, without rendering the latter.
//!
//! One sample per stratum does not show how much the colours in the stratum vary, so an estimate from the strata of one
//! picture is always biased. Further pictures with other random numbers give an unbiased estimate: their variance is
//! the picture's variance. Uniform samples have no random numbers. Their error is measured with jittered pictures,
//! whose own errors are independent and cancel on average. Adaptive samples have an estimate of their own if the filter
//! covers a pixel. With other filters whole pictures are rendered.
//!
//! For a large picture, some random rows represent all. Two pictures with one sample per pixel show which rows differ
//! much. These rows are chosen with a higher probability, and weighted less.

use crate::base::memory::NoMemory;
use crate::picture::Color;
use crate::render::renderer::Prepared;
use crate::render::{Layer, Request, Stopped, Tracing, Window};
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use rand::RngExt;

/// The approximate number of rows of a picture that are compared.
const ROWS: usize = 64;

/// The approximate number of rows in all pictures together. Details seen by few samples add much noise to a small
/// picture's error.
const ROWS_OF_ALL: usize = 4 * ROWS;

/// The approximate number of pixels examined together to choose rows.
const LOOKED_AT: usize = 1 << 20;

/// The reference for uniform samples has this many times as many samples, so its own error matters little.
const REFERENCE: u32 = 4;

/// The number of levels of a byte above zero.
const LEVELS: f64 = 255.0;

/// Returns the root mean square error of the colours due to sampling, in levels, over all channels of all pixels.
/// `None` if the colours are those of pixel centres, or if the rays of a pixel split too often.
pub fn standard_error(prepared: &Prepared, request: &Request) -> Result<Option<f64>, NoMemory> {
    let are_means = request.adaptive.is_some() || !request.sampler.is_center();
    if !are_means || !request.layers.contains(&Layer::Color) {
        return Ok(None);
    }
    let request = Request { layers: vec![Layer::Color], tracing: Tracing::Fast, ..request.clone() };
    match of_colors(prepared, &request) {
        Err(Stopped::Memory(refused)) => Err(refused),
        found => Ok(found.ok()),
    }
}

fn of_colors(prepared: &Prepared, request: &Request) -> Result<f64, Stopped> {
    let Request { sampler, .. } = *request;
    let [width, height] = request.layer_size(&Layer::Color);
    let mut rng = sampler.rng();
    let mut rows: Vec<(usize, f64)> = (0..height).map(|row| (row, 1.0)).collect();
    // Rows of a reduced picture are not independent.
    // Nor are adaptive samples.
    let are_some = height > ROWS && !request.is_reduced && request.adaptive.is_none();
    if are_some {
        let differences = differences(prepared, request, &mut rng)?;
        let sum = differences.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        for ((_, likely), difference) in rows.iter_mut().zip(differences) {
            *likely = (ROWS as f64 * 0.5 * (1.0 / height as f64 + difference / sum)).min(1.0);
        }
        rows.retain(|&(_, likely)| rng.random::<f64>() < likely);
    }

    let taken: Vec<usize> = rows.iter().map(|&(row, _)| row).collect();
    let taken = are_some.then_some(&*taken);
    let is_uniform = sampler.pattern() == Pattern::Uniform;
    let others = match sampler.pattern() {
        Pattern::Uniform => Sampler::new(Pattern::Jittered, REFERENCE * sampler.count(), sampler.rng()),
        // The random numbers of `Displaced` have no seed.
        Pattern::Displaced => Sampler::new(Pattern::Jittered, 1, sampler.rng()),
        Pattern::Random | Pattern::Jittered | Pattern::Sobol => sampler,
    };
    let pictures = ROWS_OF_ALL.div_ceil(rows.len().max(1)).clamp(2, 16);
    let mut samplers = if is_uniform { vec![sampler] } else { vec![] };
    samplers.extend((0..pictures).map(|_| others.with_rng(Drand48::seeded(rng.random()))));
    let colors = colors(prepared, request, &samplers, taken)?;
    // For each pixel, the sum over all pictures of the difference from the first one, and the sum of its square.
    let base = &colors[0];
    let mut sums = vec![(Color::ZERO, 0.0); base.len()];
    for colors in &colors[1..] {
        for ((sum, squares), (own, base)) in sums.iter_mut().zip(colors.iter().zip(base)) {
            *sum += own - base;
            *squares += (own - base).length_squared();
        }
    }
    let n = pictures as f64;
    let variance = |(sum, squares): (Color, f64)| match is_uniform {
        true => (sum.length_squared() - squares) / (n * (n - 1.0)),
        false => (squares - sum.length_squared() / n) / (n - 1.0),
    };
    let rows = sums.chunks(width.max(1)).zip(&rows);
    let sum: f64 =
        rows.map(|(row, (_, likely))| row.iter().map(|&sums| variance(sums)).sum::<f64>() / likely).sum();
    let channels = (3 * width * height).max(1) as f64;
    Ok(LEVELS * (sum / channels).max(0.0).sqrt())
}

/// Returns how much two pictures with one sample per pixel differ in each row.
fn differences(prepared: &Prepared, request: &Request, rng: &mut Drand48) -> Result<Vec<f64>, Stopped> {
    let columns = request.columns();
    let [width, height] = request.window_size();
    let top = request.size[1] - request.rows().end;
    let samplers = [(); 2].map(|()| Sampler::new(Pattern::Jittered, 1, Drand48::seeded(rng.random())));
    let mut differences = Vec::with_capacity(height);
    let step = (LOOKED_AT / width.max(1)).max(1);
    for from in (0..height).step_by(step) {
        let window = Window { x: columns.start, y: top + from, width, height: step.min(height - from) };
        let request = Request { window: Some(window), adaptive: None, ..request.clone() };
        let looks = colors(prepared, &request, &samplers, None)?;
        let [one, other] = [0, 1].map(|look: usize| looks[look].chunks(width.max(1)));
        let squares = |(a, b): (&Color, &Color)| (a - b).length_squared();
        differences.extend(one.zip(other).map(|(a, b)| a.iter().zip(b).map(squares).sum::<f64>()));
    }
    Ok(differences)
}

/// Returns the window's colours with each of these samplers. `rows` selects rows of the window, counted from the top.
fn colors(
    prepared: &Prepared,
    request: &Request,
    samplers: &[Sampler],
    rows: Option<&[usize]>,
) -> Result<Vec<Vec<Color>>, Stopped> {
    let whole = |&sampler: &Sampler| {
        let request = Request { sampler, ..request.clone() };
        prepared.render(&request).map(|mut pictures| pictures.remove(0).colors)
    };
    let mut colors = match rows {
        Some(rows) => prepared.render_some_rows(request, samplers, rows)?,
        None => samplers.iter().map(whole).collect::<Result<_, _>>()?,
    };
    if !request.has_floats {
        colors.iter_mut().flatten().for_each(|color| *color = color.clamp(Color::ZERO, Color::ONE));
    }
    Ok(colors)
}
