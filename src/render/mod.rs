//! Rows of pixels in parallel: samples -> film -> pictures.

mod sample_packet;
pub mod grid_view;
mod request;
mod row;

pub use request::{Request, View};

use crate::camera::Camera;
use crate::grid::Caster;
use crate::picture::{BadSize, Picture, quantize};
use crate::sampling::film::Film;
use crate::sampling::filter::Filter;
use crate::scene::Color;
use crate::stats::Probe;
use glam::DVec2;
use rayon::prelude::*;
use row::{Colors, Row};

/// The pictures that were asked for.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// What is seen.
    pub color: Option<Picture>,
    /// How far away it is.
    pub depth: Option<Picture>,
    /// Which way its surface faces.
    pub normals: Option<Picture>,
    /// Where the samples of each pixel lie, and their colours.
    pub samples: Option<Picture>,
    /// Pixels whose colour is not a number; they are black.
    pub nans: u64,
}

/// How much memory rows on their way to the film may take, in bytes.
const ROWS_IN_FLIGHT: usize = 32 << 20;

/// How many rows a thread traces before it asks for more.
const ROWS_AT_ONCE: usize = 4;

/// Renders what is asked for, and hands back what was counted.
///
/// Rows are traced in parallel and collected in order, so that the bytes depend on no thread.
pub fn render<P: Probe>(
    camera: &Camera,
    caster: &Caster,
    request: &Request,
) -> Result<(Pictures, P), BadSize> {
    let [_, height] = request.size;
    let mut pictures = Pictures::new(request)?;
    let mut film = Film::new(request.filter, request.size);
    let mut probe = P::default();
    // At least a row for each thread, and no more than there are.
    let batch =
        (ROWS_IN_FLIGHT / Row::<P>::bytes(request)).max(rayon::current_num_threads()).clamp(1, height.max(1));
    for first in (0..height).step_by(batch) {
        let rows = first..height.min(first + batch);
        let visibility = request.visibility::<P>(camera, caster, rows.clone());
        let rows: Vec<Row<P>> = rows
            .into_par_iter()
            // Left to itself the pool cuts the rows in a few large pieces, and waits for the last.
            .with_max_len(ROWS_AT_ONCE)
            .map(|j| Row::traced(camera, caster, request, visibility.as_ref(), j))
            .collect();
        for row in rows {
            pictures.take(&row);
            probe = probe.merge(row.probe);
            if let Colors::Spread(spread) = row.colors {
                film.add(spread, |j, colors| pictures.finish(j, colors));
            }
        }
    }
    Ok((pictures, probe))
}

impl Pictures {
    fn new(request: &Request) -> Result<Self, BadSize> {
        let [w, h] = request.size;
        let picture = |wanted: bool, zoom: usize| {
            let side = |n: usize| u32::try_from(n * zoom).unwrap_or(u32::MAX);
            wanted.then(|| Picture::new(side(w), side(h))).transpose()
        };
        Ok(Self {
            color: picture(request.color, 1)?,
            depth: picture(request.depth.is_some(), 1)?,
            normals: picture(request.normals, 1)?,
            samples: picture(request.samples.is_some(), request.samples.unwrap_or(1))?,
            nans: 0,
        })
    }

    /// Enters all of a row but the colours that it spreads.
    fn take<P>(&mut self, row: &Row<P>) {
        if let (Some(picture), Colors::Finished(bytes)) = (&mut self.color, &row.colors) {
            picture.row_mut(row.j).copy_from_slice(bytes);
        }
        for (picture, bytes) in [(&mut self.depth, &row.depths), (&mut self.normals, &row.normals)] {
            if let Some(picture) = picture {
                picture.row_mut(row.j).copy_from_slice(bytes);
            }
        }
        if let Some(plot) = &mut self.samples {
            for (k, colors) in row.samples.iter().enumerate() {
                let bytes = plot.row_mut(row.j * row.samples.len() + k);
                write(bytes, colors.iter().copied(), &mut self.nans);
            }
        }
        self.nans += row.nans;
    }

    /// Enters a row of finished colours.
    fn finish(&mut self, j: usize, colors: &mut dyn Iterator<Item = Color>) {
        if let Some(picture) = &mut self.color {
            write(picture.row_mut(j), colors, &mut self.nans);
        }
    }
}

fn write(bytes: &mut [u8], colors: impl Iterator<Item = Color>, nans: &mut u64) {
    for (pixel, color) in bytes.chunks_exact_mut(3).zip(colors) {
        pixel.copy_from_slice(&quantize(color, nans));
    }
}

/// The picture of a filter: the weights around the middle pixel, each pixel enlarged `zoom` times.
///
/// As the course draws it, half the width finds the middle along both axes, what lies beyond the
/// filter's support stays dark blue, and blue lines separate the pixels.
pub fn render_filter(filter: Filter, [width, height]: [usize; 2], zoom: usize) -> Result<Picture, BadSize> {
    let side = |n: usize| u32::try_from(n * zoom + 1).unwrap_or(u32::MAX);
    let mut picture = Picture::new(side(width), side(height))?;
    let middle = width / 2;
    let reached = middle.saturating_sub(filter.support())..=middle + filter.support();
    // Relative to the middle pixel's centre.
    let place = |k: usize| k as f64 / zoom as f64 - (middle as f64 + 0.5);
    for y in 0..=height * zoom {
        let colors = (0..=width * zoom).map(|x| {
            if x.is_multiple_of(zoom) || y.is_multiple_of(zoom) {
                Color::Z
            } else if reached.contains(&(x / zoom)) && reached.contains(&(y / zoom)) {
                Color::splat(filter.weight(DVec2::new(place(x), place(y))))
            } else {
                0.5 * Color::Z
            }
        });
        write(picture.row_mut(y), colors, &mut 0);
    }
    Ok(picture)
}
