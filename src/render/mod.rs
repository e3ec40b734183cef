//! Rows of pixels in parallel: samples -> film -> the layers' rows, handed out from the top as they are
//! finished.

mod delivery;
pub mod grid_view;
pub mod layer;
mod request;
mod row;
mod sample_packet;
mod strip;
mod tally;

pub use layer::{Cost, Layer};
pub use request::{Request, View, Window};

use crate::camera::Camera;
use crate::grid::Caster;
use crate::memory::{self, NoMemory};
use crate::mode::{Course, Fast, Mode};
use crate::picture::{BadSize, FloatPicture};
use crate::sampling::adaptive::{Adaptive, Stratum};
use crate::sampling::filter::Filter;
use crate::scene::Color;
use crate::stats::{Counts, Probe, RayCount};
use crate::trace::Observer;
use glam::DVec2;
use row::RenderSetting;
use std::fmt;
use std::ops::ControlFlow;
use strip::Strip;
use tally::Tally;

/// A mode in which pictures are rendered, with what is counted in it.
///
/// Each mode has functions of its own, so that the loops over pixels are compiled once for each, and only in this
/// library.
pub trait RenderMode: Mode {
    /// Counts the rays of a picture, and in the course's mode whatever else the course's program counts.
    type Counter: Observer;

    /// Renders the layers of a request row by row, and returns what was counted.
    fn render(
        camera: &Camera,
        caster: &Caster<Self>,
        view: View,
        request: &Request,
        watch: Watch,
        take_row: TakeRow,
    ) -> Result<Self::Counter, Stopped>;
}

impl RenderMode for Fast {
    type Counter = RayCount;

    fn render(
        camera: &Camera,
        caster: &Caster<Self>,
        view: View,
        request: &Request,
        watch: Watch,
        take_row: TakeRow,
    ) -> Result<RayCount, Stopped> {
        render(camera, caster, view, request, watch, take_row)
    }
}

impl RenderMode for Course {
    type Counter = Counts;

    fn render(
        camera: &Camera,
        caster: &Caster<Self>,
        view: View,
        request: &Request,
        watch: Watch,
        take_row: TakeRow,
    ) -> Result<Counts, Stopped> {
        render(camera, caster, view, request, watch, take_row)
    }
}

/// The progress of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// The number of rows of pixels that have been traced.
    pub done: usize,
    /// The number of rows of pixels in the window.
    pub rows: usize,
    /// The rays that have been cast for them. Those of the first samples of adaptive sampling are not among them.
    pub rays: u64,
}

/// A callback that is told the progress of a render, and may cancel it. It is called from any of the render's
/// threads, at least once for each row.
pub type Watch<'a> = &'a (dyn Fn(Progress) -> ControlFlow<()> + Sync);

/// A callback that takes the rows of the layers: the arguments are the index of a layer in the request, and
/// the colours of that layer's next row, from the top. It may end the render.
pub type TakeRow<'a> = &'a mut (dyn FnMut(usize, &[Color]) -> ControlFlow<()> + Send + 'a);

/// Why a render ended before its last row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stopped {
    /// The watch cancelled it, after this number of rows of pixels had been handed out.
    Cancelled {
        /// Rows from the top of the window.
        rows: usize,
    },
    /// The callback that takes the rows ended it.
    Output,
    /// The system has too little memory for the rows in progress.
    Memory(NoMemory),
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled { rows } => write!(f, "stopped after {rows} rows"),
            Self::Output => write!(f, "the rows are not taken any more"),
            Self::Memory(refused) => refused.fmt(f),
        }
    }
}

impl std::error::Error for Stopped {}

impl From<NoMemory> for Stopped {
    fn from(refused: NoMemory) -> Self {
        Self::Memory(refused)
    }
}

/// Renders the layers of a request, and returns what was counted.
///
/// Rows are traced in parallel on the current thread pool of rayon and handed out in order, so that neither
/// the colours nor the counts depend on the number of threads. Only some rows are in memory at a time, never
/// the whole picture.
fn render<M: RenderMode>(
    camera: &Camera,
    caster: &Caster<M>,
    view: View,
    request: &Request,
    watch: Watch,
    take_row: TakeRow,
) -> Result<M::Counter, Stopped> {
    for (k, layer) in request.layers.iter().enumerate() {
        if let Layer::Filter { zoom } = *layer {
            render_filter(request.filter, request.window_size(), zoom, &mut |row| take_row(k, row))?;
        }
    }
    let shadow_maps = request.shadow_maps(caster, view);
    let shadow_maps = shadow_maps.as_ref();
    let setting = RenderSetting { camera, caster, view, request, shadow_maps };
    let rows = request.rows();
    let tally = Tally::new(rows.len(), watch);
    let mut counter = M::Counter::default();
    let mut end = rows.end;
    while end > rows.start {
        let strip = Strip::below(&setting, end, rows.start);
        counter = counter.merge(strip.render(&tally, take_row)?);
        end = strip.rows.start;
    }
    Ok(counter)
}

/// The adaptive samples of the pixel in this column and row from the bottom left.
pub fn strata<M: RenderMode>(
    camera: &Camera,
    caster: &Caster<M>,
    view: View,
    request: &Request,
    settings: Adaptive,
    pixel: [usize; 2],
) -> Vec<Stratum> {
    RenderSetting { camera, caster, view, request, shadow_maps: None }
        .strata(settings, pixel)
        .unwrap_or_default()
}

/// Renders a request into memory, and returns a picture for each of its layers and what was counted. A layer without
/// pixels, or with more than there is memory for, is an error.
pub fn render_in_memory<M: RenderMode>(
    camera: &Camera,
    caster: &Caster<M>,
    view: View,
    request: &Request,
) -> Result<(Vec<FloatPicture>, M::Counter), BadSize> {
    let empty = |layer: &Layer| FloatPicture::with_room(layer.size(request.window_size()));
    let mut pictures: Vec<FloatPicture> = request.layers.iter().map(empty).collect::<Result<_, _>>()?;
    let mut take_row = |layer: usize, row: &[Color]| {
        pictures[layer].colors.extend_from_slice(row);
        ControlFlow::Continue(())
    };
    let never_cancels = |_| ControlFlow::Continue(());
    let counter = match M::render(camera, caster, view, request, &never_cancels, &mut take_row) {
        Ok(counter) => counter,
        // Neither callback ends it.
        Err(Stopped::Cancelled { .. } | Stopped::Output) => M::Counter::default(),
        Err(Stopped::Memory(_)) => {
            let [width, height] = request.window_size();
            return Err(BadSize { width, height });
        }
    };
    Ok((pictures, counter))
}

/// Draws the weights of a filter around the middle pixel. Each pixel is enlarged `zoom` times.
///
/// As in the course's program, the middle is half the width along both axes, pixels beyond the filter's
/// support are dark blue, and blue lines separate the pixels.
fn render_filter(
    filter: Filter,
    [width, height]: [usize; 2],
    zoom: usize,
    take_row: &mut dyn FnMut(&[Color]) -> ControlFlow<()>,
) -> Result<(), Stopped> {
    let middle = width / 2;
    let supported = middle.saturating_sub(filter.support())..=middle + filter.support();
    // The offset from the middle pixel's centre, in pixels.
    let offset = |k: usize| k as f64 / zoom as f64 - (middle as f64 + 0.5);
    for y in (0..=height * zoom).rev() {
        let color = |x: usize| {
            if x.is_multiple_of(zoom) || y.is_multiple_of(zoom) {
                Color::Z
            } else if supported.contains(&(x / zoom)) && supported.contains(&(y / zoom)) {
                Color::splat(filter.weight(DVec2::new(offset(x), offset(y))))
            } else {
                0.5 * Color::Z
            }
        };
        if take_row(&memory::collected((0..width * zoom + 1).map(color))?).is_break() {
            return Err(Stopped::Output);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
