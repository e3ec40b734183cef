//! Renders rows of pixels in parallel: samples -> film -> the layers' rows. Rows are handed out from the top as soon
//! as they are finished.

pub mod adaptive;
mod filter_picture;
pub mod grid_view;
pub mod layer;
pub mod renderer;
mod request;
mod row;
mod small_things;
mod stop;
mod strip;
mod tally;
mod tracing;

pub use layer::{Cost, Layer};
pub use request::{Request, Tracing, View};
pub use stop::Stop;
pub use tracing::Shot;

pub use crate::picture::Window;

use crate::base::memory::{self, NoMemory};
use crate::diagnostic::Diagnostic;
use crate::picture::{BadSize, Color, FloatPicture};
use crate::sampling::blur::Blur;
use crate::sampling::sampler::Sampler;
use crate::stats::Counts;
use crate::trace::MOST_WAITING;
use adaptive::{AdaptiveRow, AdaptiveSampler};
use filter_picture::render_filter;
use glam::DVec2;
use rayon::prelude::*;
use row::RowSampler;
use std::error::Error;
use std::fmt;
use std::ops::ControlFlow;
use strip::Strip;
use tally::Tally;
use tracing::PictureTracer;

/// The progress of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of rows of pixels that have been traced.
    pub done: usize,
    /// The number of rows of pixels in the window.
    pub rows: usize,
    /// The number of rays of these rows.
    pub rays: u64,
}

/// A callback that gets the progress of a render and may cancel it. Any of the render's threads may call it. It is
/// called at least once for each row, and also within a row that takes long.
pub type Watch<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync);

/// A callback that takes the rows of the layers. The arguments are the index of a layer in the request and the colours
/// of the layer's next row, from the top. An error ends the render.
pub type TakeRow<'a> = &'a mut (dyn FnMut(usize, &[Color]) -> Result<(), Diagnostic> + Send + 'a);

/// The reason why a render ended before its last row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The watch cancelled the render after this number of rows of pixels had been handed out.
    Cancelled {
        /// Rows from the top of the window.
        rows: usize,
    },
    /// The error of the callback that takes the rows.
    Output(Diagnostic),
    /// The system has too little memory for the rows that must be in memory at the same time.
    Memory(NoMemory),
    /// A picture has no pixels, or does not fit into memory.
    Size(BadSize),
    /// The structure into which rays are cast does not fit into memory.
    Structure,
    /// Too many secondary rays of one camera ray wait to be traced.
    Rays,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled { rows } => write!(f, "stopped after {rows} rows"),
            Self::Output(error) => error.fmt(f),
            Self::Memory(refused) => refused.fmt(f),
            Self::Size(size) => size.fmt(f),
            Self::Structure => f.write_str("the scene's structure for casting rays does not fit into memory"),
            Self::Rays => write!(
                f,
                "the rays of one pixel split without end: more than {MOST_WAITING} wait to be traced; \
                 use fewer `-bounces` or a larger `-weight`"
            ),
        }
    }
}

impl From<Stopped> for Diagnostic {
    fn from(stopped: Stopped) -> Self {
        match stopped {
            Stopped::Output(error) => error,
            stopped => Self::error(stopped.to_string()),
        }
    }
}

impl From<Stopped> for Box<dyn Error> {
    fn from(stopped: Stopped) -> Self {
        Diagnostic::from(stopped).into()
    }
}

impl From<BadSize> for Stopped {
    fn from(size: BadSize) -> Self {
        Self::Size(size)
    }
}

impl From<NoMemory> for Stopped {
    fn from(refused: NoMemory) -> Self {
        Self::Memory(refused)
    }
}

/// The results of a render besides its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rendered {
    /// The events that were counted.
    pub counts: Counts,
    /// The cost of each pixel, row by row from the top, if costs are a layer.
    pub costs: Vec<u64>,
    /// The sum of the estimated squared errors of the colours, where white is 1, with adaptive samples. The error of a
    /// pixel is that of the mean of its own samples.
    pub squared_error: f64,
}

/// Renders the layers of a request, and returns the counts and the costs of the pixels.
///
/// Rows are traced in parallel on rayon's current thread pool and handed out in order. Neither the colours nor the
/// counts depend on the number of threads. Only some rows are in memory at a time, never the whole picture.
pub fn render(shot: &Shot, request: &Request, watch: Watch, take_row: TakeRow) -> Result<Rendered, Stopped> {
    for (k, layer) in request.layers.iter().enumerate() {
        if let Layer::Filter { zoom } = *layer {
            let size = request.window_size();
            render_filter(request.filter, size, zoom, watch, &mut |row| take_row(k, row))?;
        }
    }
    // Reduce the colours of layers that are reduced.
    let blur = |layer: &Layer| request.reduces(layer).then(|| Blur::new(request.rows().len()));
    let mut blurs: Vec<Option<Blur>> = request.layers.iter().map(blur).collect();
    let mut reduce = |layer: usize, row: &[Color]| match &mut blurs[layer] {
        Some(blur) => blur.add(row).map_or(Ok(()), |row| take_row(layer, &row)),
        None => take_row(layer, row),
    };
    let rendered = render_strips(shot, request, watch, &mut reduce)?;
    for (layer, blur) in blurs.iter_mut().enumerate() {
        if let Some(row) = blur.as_mut().and_then(Blur::end) {
            take_row(layer, &row).map_err(Stopped::Output)?;
        }
    }
    Ok(rendered)
}

/// Renders the layers of a request strip by strip. Does not reduce their colours.
fn render_strips(
    shot: &Shot,
    request: &Request,
    watch: Watch,
    take_row: TakeRow,
) -> Result<Rendered, Stopped> {
    let rows = request.rows();
    // No strip takes more memory than the first one.
    memory::ask(Strip::below(request, rows.end, rows.start).bytes())?;
    let tally = Tally::new(rows.len(), watch);
    let tracer = PictureTracer::new(shot, request, &tally);
    let mut adaptive = AdaptiveSampler::new(&tracer);
    let pixels = request.cost().map_or(0, |_| request.window_size().iter().product());
    let mut rendered = Rendered { costs: memory::with_room(pixels)?, ..Rendered::default() };
    let mut end = rows.end;
    while end > rows.start {
        let strip = Strip::below(request, end, rows.start);
        adaptive.as_mut().map_or(Ok(()), |adaptive| adaptive.sample(&strip.traced()))?;
        strip.render(&tracer, adaptive.as_ref(), &mut rendered, take_row)?;
        end = strip.rows.start;
    }
    Ok(rendered)
}

/// Renders the colours of these rows of the window, counted from its top, with each of these samplers. The samples are
/// not adaptive. The colours are not reduced. Each row is rendered by itself.
pub fn render_some_rows(
    shot: &Shot,
    request: &Request,
    samplers: &[Sampler],
    rows: &[usize],
) -> Result<Vec<Vec<Color>>, Stopped> {
    let tally = Tally::new(rows.len(), &|_| ControlFlow::Continue(()));
    // Otherwise each of the rows would build the structure.
    shot.built(&tally)?;
    let render = |&sampler: &Sampler| {
        let request = &Request { sampler, ..request.clone() };
        let tracer = PictureTracer::new(shot, request, &tally);
        let colors = |row: &usize| {
            let end = request.rows().end - row;
            let strip = Strip::below(request, end, end - 1);
            let traced = strip.trace(end - 1..end, &tracer.for_rows(strip.traced())?, None).pop();
            traced.map(|row| row.colors).ok_or_else(|| tally.reason())
        };
        let colors: Vec<Vec<Color>> = rows.par_iter().map(colors).collect::<Result<_, Stopped>>()?;
        Ok(colors.concat())
    };
    samplers.iter().map(render).collect()
}

/// Returns the offsets of the samples of the pixel in this column and row from the bottom left. Returns an empty list if
/// the watch cancels.
pub fn offsets(shot: &Shot, request: &Request, [column, row]: [usize; 2], watch: Watch) -> Vec<DVec2> {
    let offsets = |row_samples: Option<AdaptiveRow>| {
        let mut offsets = vec![];
        RowSampler::new(request, column, row, row_samples)
            .place(column..column + 1, |_, at, _| offsets.push(at));
        offsets
    };
    if request.adaptive.is_none() {
        return offsets(None);
    }
    let window = Some(Window { x: column, y: request.size[1] - 1 - row, width: 1, height: 1 });
    let pixel = &Request { window, layers: vec![Layer::Color], ..request.clone() };
    let tally = Tally::new(1, watch);
    let tracer = PictureTracer::new(shot, pixel, &tally);
    let mut adaptive = AdaptiveSampler::new(&tracer);
    adaptive.as_mut().and_then(|adaptive| adaptive.sample(&(row..row + 1)).ok());
    let row_samples = adaptive.as_ref().and_then(|adaptive| adaptive.row(row));
    row_samples.map_or(vec![], |row_samples| offsets(Some(row_samples)))
}

/// Renders a request into memory. Returns a picture for each of its layers, and the counts.
pub fn render_in_memory(
    shot: &Shot,
    request: &Request,
    watch: Watch,
) -> Result<(Vec<FloatPicture>, Counts), Stopped> {
    let empty = |layer: &Layer| FloatPicture::with_room(request.layer_size(layer));
    let mut pictures: Vec<FloatPicture> = request.layers.iter().map(empty).collect::<Result<_, _>>()?;
    let mut take_row = |layer: usize, row: &[Color]| {
        pictures[layer].colors.extend_from_slice(row);
        Ok(())
    };
    let Rendered { counts, costs, .. } = render(shot, request, watch, &mut take_row)?;
    for (layer, picture) in request.layers.iter().zip(&mut pictures) {
        if matches!(layer, Layer::Cost(_)) {
            picture.colors = costs.iter().map(|&cost| Color::splat(cost as f64)).collect();
        }
    }
    Ok((pictures, counts))
}

#[cfg(test)]
pub(crate) mod test_renderer;
#[cfg(test)]
mod tests;
