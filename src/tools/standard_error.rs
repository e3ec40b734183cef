//! How far a picture is likely to be from the one with endlessly many samples, without rendering that.
//!
//! One sample in each stratum does not say how much the colours in the stratum vary, so that an estimate from the strata of
//! one picture is never without bias. Two further pictures with other random numbers are: half the mean square of their
//! difference is the variance of each. Uniform samples have no random numbers. Their error is measured by two jittered
//! pictures, whose own errors are independent and cancel on average. Of a large picture some rows stand for all.

use crate::memory::NoMemory;
use crate::render::{Layer, Request, Stopped, Watch, Window};
use crate::renderer::Prepared;
use crate::sampling::drand48::Drand48;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::Color;
use std::ops::{ControlFlow, Range};

/// The rows that are looked at are as many bands of this height, at equal distances.
const BANDS: usize = 16;
const BAND_HEIGHT: usize = 4;

/// What uniform samples are compared with has so many times as many samples, so that its own error matters little.
const REFERENCE: u32 = 4;

/// The number of levels of a byte above zero.
const LEVELS: f64 = 255.0;

/// Whether the colours of a request are means of samples, and not those of pixels' centres.
pub fn has_standard_error(request: &Request) -> bool {
    request.layers.contains(&Layer::Color) && (request.adaptive.is_some() || !request.sampler.is_center())
}

/// The root mean square error of the colours that is due to where samples lie, in levels, over all channels of all pixels.
/// None if the watch has ended it.
pub fn standard_error(prepared: &Prepared, request: &Request, watch: Watch) -> Result<Option<f64>, NoMemory> {
    let Request { sampler, .. } = *request;
    let is_uniform = sampler.pattern() == Pattern::Uniform;
    let mut seeds = (0x5EED..).map(Drand48::seeded).filter(|&seed| seed != sampler.rng());
    let [one, other] = [(); 2].map(|()| {
        let rng = seeds.next().unwrap_or(sampler.rng());
        if is_uniform {
            Sampler::new(Pattern::Jittered, REFERENCE * sampler.count(), rng)
        } else {
            sampler.with_rng(rng)
        }
    });
    let (mut sum, mut channels) = (0.0, 0.0);
    for rows in bands(request.window_size()[1]) {
        let colors = |sampler| colors(prepared, request, sampler, rows.clone(), watch);
        let (Some(a), Some(b)) = (colors(one)?, colors(other)?) else { return Ok(None) };
        let own = if is_uniform { colors(sampler)? } else { None };
        if is_uniform && own.is_none() {
            return Ok(None);
        }
        for (k, (a, b)) in a.iter().zip(&b).enumerate() {
            sum += match own.as_ref().and_then(|own| own.get(k)) {
                Some(own) => (own - a).dot(own - b),
                None => 0.5 * (a - b).length_squared(),
            };
            channels += 3.0;
        }
    }
    Ok((channels > 0.0).then(|| LEVELS * (sum / channels).max(0.0).sqrt()))
}

/// The rows that are looked at, of so many.
fn bands(rows: usize) -> Vec<Range<usize>> {
    let (count, height) = if rows <= BANDS * BAND_HEIGHT { (1, rows) } else { (BANDS, BAND_HEIGHT) };
    let starts = (0..count).map(|band| (2 * band + 1) * rows / (2 * count) - height / 2);
    starts.map(|start| start..start + height).collect()
}

/// The colours in these rows of the window, counted from the top, as a picture shows them; none if the watch has ended it.
fn colors(
    prepared: &Prepared,
    request: &Request,
    sampler: Sampler,
    rows: Range<usize>,
    watch: Watch,
) -> Result<Option<Vec<Color>>, NoMemory> {
    let [width, height] = request.size;
    let whole = Window { x: 0, y: 0, width, height };
    let window = request.window.unwrap_or(whole);
    let window = Window { y: window.y + rows.start, height: rows.len(), ..window };
    let request = Request { window: Some(window), sampler, layers: vec![Layer::Color], ..request.clone() };
    let mut colors = crate::memory::with_room(request.window_size().iter().product())?;
    let mut take_row = |_: usize, row: &[Color]| {
        colors.extend(row.iter().map(|color| color.clamp(Color::ZERO, Color::ONE)));
        ControlFlow::Continue(())
    };
    match prepared.render_rows_fast(&request, watch, &mut take_row) {
        Ok(()) => Ok(Some(colors)),
        Err(Stopped::Memory(refused)) => Err(refused),
        Err(Stopped::Cancelled { .. } | Stopped::Output) => Ok(None),
    }
}
