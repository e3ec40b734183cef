//! A strip of rows. It is traced from the bottom, in the order in which the film adds up samples, and handed out from
//! the top, in the order of rows in files.
//!
//! If the filter's support extends beyond a pixel's row, the samples of the rows around the strip are traced as well.
//! So the strip's pixels are the same as in the whole picture.

use super::adaptive::{AdaptiveRow, AdaptiveSampler};
use super::layer::Layer;
use super::request::Request;
use super::row::Row;
use super::tracing::PictureTracer;
use super::{Rendered, Stopped, TakeRow};
use crate::picture::Color;
use crate::sampling::film::Film;
use crate::sampling::spread::Spread;
use crate::stats::Counts;
use std::ops::Range;

/// Upper bound on the memory of a strip's finished rows, in bytes.
const MEMORY: usize = 48 << 20;

/// Upper bound on the memory of a strip's rows in progress, in bytes.
const MEMORY_IN_FLIGHT: usize = 32 << 20;

/// The number of rows per thread that are traced while the rows before them are handed out: few enough to take little
/// memory, and enough that threads seldom wait for a slow row.
const ROWS_PER_BATCH: usize = 16;

/// Upper bound on the rows in progress, per thread, if samples contribute to other rows. It is small enough to need
/// little memory, and large enough that threads seldom wait for each other.
const ROWS_IN_FLIGHT_PER_THREAD: usize = 32;

/// Upper bound on the samples of a strip whose rows cannot be handed out before it is complete. So a cancelled render
/// loses a few seconds' work at most.
const SAMPLES: usize = 1 << 24;

/// [`SAMPLES`] makes no strip shorter than this many times the filter's support. The rows that are traced beside the
/// strip then cost a thirtieth of the work.
const ROWS_PER_SUPPORT: usize = 64;

/// No strip is shorter than this many times the filter's support, or most of the rows that are traced would be discarded.
const LEAST_ROWS_PER_SUPPORT: usize = 8;

/// Some rows of the window, counted from the bottom.
pub struct Strip<'a> {
    request: &'a Request,
    pub rows: Range<usize>,
}

impl<'a> Strip<'a> {
    /// Returns the strip of rows from `end` down to at most `first`: as many as the memory allows, and at least one.
    pub fn below(request: &'a Request, end: usize, first: usize) -> Self {
        let Request { sampler, adaptive, .. } = request;
        let width = request.columns().len();
        let by_memory = MEMORY / (request.colors_per_row() * size_of::<Color>()).max(1);
        // If rows around the strip are traced and discarded, take more rows, so that the discarded ones are a small
        // part of the work.
        let support = request.support();
        // The number of adaptive samples is not known. It is seldom the maximum.
        let samples = adaptive.map_or(sampler.count(), |adaptive| adaptive.most / 4) as usize;
        let by_samples = (SAMPLES / (width * samples).max(1)).max(ROWS_PER_SUPPORT * support);
        // Rows are handed out together if they depend on each other, and adaptive samples are taken together.
        let is_together = support > 0 || adaptive.is_some();
        let rows = if is_together { by_memory.min(by_samples) } else { by_memory };
        let rows = rows.max(LEAST_ROWS_PER_SUPPORT * support).max(rayon::current_num_threads());
        Self { request, rows: end.saturating_sub(rows).max(first)..end }
    }

    /// Traces the strip and hands it out. Adds its counts to `rendered`.
    pub fn render(
        &self,
        picture: &PictureTracer,
        adaptive: Option<&AdaptiveSampler>,
        rendered: &mut Rendered,
        take_row: TakeRow,
    ) -> Result<(), Stopped> {
        let tracer = &picture.for_rows(self.traced())?;
        let batch = match self.request.support() {
            0 => ROWS_PER_BATCH * rayon::current_num_threads(),
            _ => self.rows.len(),
        };
        // Hand out a batch of rows while the next one is traced.
        let (mut end, mut traced) = (self.rows.end, vec![]);
        let mut hand_out_rows = |rows: &[Row]| {
            let taken = rows.iter().try_for_each(|row| {
                rendered.counts = rendered.counts.merge(row.counts);
                rendered.costs.extend_from_slice(&row.costs);
                rendered.squared_error += row.squared_error;
                hand_out(row, self.request, take_row)?;
                tracer.tally.row_is_handed_out();
                Ok(())
            });
            taken.inspect_err(|_| tracer.tally.cancel())
        };
        while end > self.rows.start {
            let rows = end.saturating_sub(batch).max(self.rows.start)..end;
            let (taken, next) =
                rayon::join(|| hand_out_rows(&traced), || self.trace(rows.clone(), tracer, adaptive));
            taken?;
            traced = next;
            if traced.len() < rows.len() {
                hand_out_rows(&traced)?;
                return Err(tracer.tally.reason());
            }
            end = rows.start;
        }
        hand_out_rows(&traced)
    }

    /// Returns the rows to trace: the rows of the strip, and the rows around it whose samples contribute to it.
    pub fn traced(&self) -> Range<usize> {
        self.request.traced_rows(self.rows.clone())
    }

    /// Traces these rows of the strip, which must be all if samples contribute to other rows. Returns them from the top,
    /// and fewer if the render is cancelled.
    pub fn trace(
        &self,
        rows: Range<usize>,
        tracer: &PictureTracer,
        adaptive: Option<&AdaptiveSampler>,
    ) -> Vec<Row> {
        if self.request.support() > 0 {
            return self.filter(tracer, adaptive).unwrap_or_default();
        }
        let traced = tracer.tally.in_parallel(rows, |j| self.row(j, tracer, adaptive));
        traced.into_iter().rev().map_while(|row| row).collect()
    }

    /// Traces the strip and filters its samples. Returns its rows from the top, or `None` if the render is cancelled.
    fn filter(&self, tracer: &PictureTracer, adaptive: Option<&AdaptiveSampler>) -> Option<Vec<Row>> {
        let Request { filter, size, .. } = *self.request;
        let (traced, columns) = (self.traced(), self.request.columns());
        let mut film = Film::new(filter, size, traced.start);
        let mut finished: Vec<Row> = Vec::with_capacity(self.rows.len());
        for first in traced.clone().step_by(self.rows_in_flight()) {
            let rows = first..traced.end.min(first + self.rows_in_flight());
            for row in tracer.tally.in_parallel(rows, |j| self.row(j, tracer, adaptive)) {
                let mut row = row?;
                let Some(spread) = row.spread.take() else { continue };
                if self.rows.contains(&row.j) {
                    finished.push(row);
                }
                film.add(spread, |j, colors| {
                    if self.rows.contains(&j) {
                        let colors = colors.skip(columns.start).take(columns.len());
                        finished[j - self.rows.start].colors.extend(colors);
                    }
                });
            }
        }
        finished.reverse();
        Some(finished)
    }

    /// Returns the number of rows that are traced before they are added to the film: at least one for each thread.
    fn rows_in_flight(&self) -> usize {
        let threads = rayon::current_num_threads();
        let most = ROWS_IN_FLIGHT_PER_THREAD * threads;
        (MEMORY_IN_FLIGHT / self.bytes_in_flight()).min(most).max(threads).max(1)
    }

    /// Returns the memory of a row in progress, in bytes.
    fn bytes_in_flight(&self) -> usize {
        self.bytes_of_sums() + 32 * self.request.size[0]
    }

    /// Returns the memory of the sums of all rows to which the samples of one row contribute, in bytes.
    fn bytes_of_sums(&self) -> usize {
        let Request { filter, size, .. } = *self.request;
        if self.request.support() == 0 { 0 } else { Spread::bytes(filter, size) }
    }

    /// Returns the memory of the rows that are in memory at the same time, in bytes.
    pub fn bytes(&self) -> u64 {
        let finished = self.request.colors_per_row() * size_of::<Color>();
        let bytes = if self.request.support() > 0 {
            let in_flight = self.rows_in_flight().min(self.traced().len());
            // The film also has sums.
            self.rows.len() * finished + in_flight * self.bytes_in_flight() + self.bytes_of_sums()
        } else {
            self.rows.len().min(2 * ROWS_PER_BATCH * rayon::current_num_threads()) * finished
        };
        bytes as u64
    }

    /// Traces row `j`. Returns `None` if the render is cancelled meanwhile.
    fn row(&self, j: usize, tracer: &PictureTracer, adaptive: Option<&AdaptiveSampler>) -> Option<Row> {
        let is_shown = self.rows.contains(&j);
        let adaptive = adaptive.and_then(|adaptive| adaptive.row(j));
        let mut row = tracer.row(j, is_shown, adaptive)?;
        row.counts = row.counts.merge(adaptive.map_or(Counts::default(), AdaptiveRow::counts));
        if is_shown {
            tracer.tally.row_is_done(row.counts.rays());
        }
        Some(row)
    }
}

/// Hands out the layers of a row.
fn hand_out(row: &Row, request: &Request, take_row: TakeRow) -> Result<(), Stopped> {
    for (k, (layer, measured)) in request.layers.iter().zip(&row.layers).enumerate() {
        let colors = if matches!(layer, Layer::Color) { &row.colors } else { measured };
        let [width, _] = layer.size(request.window_size());
        let mut rows = colors.chunks_exact(width.max(1)).rev();
        rows.try_for_each(|row| take_row(k, row)).map_err(Stopped::Output)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
