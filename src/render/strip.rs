//! A strip of rows. It is traced from the bottom, in the order in which the film adds up samples, and handed out from
//! the top, in the order of rows in files.
//!
//! If the filter's support extends beyond a pixel's row, the samples of the rows around the strip are traced as well.
//! So the strip's pixels are the same as in the whole picture.

use super::layer::Layer;
use super::plan::Band;
use super::request::Request;
use super::row::{Colors, Row};
use super::tally::{Tally, in_parallel};
use super::tracing::PictureTracer;
use super::{Stopped, TakeRow};
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
const ROWS_PER_BATCH: usize = 32;

/// Upper bound on the rows in progress, per thread, if samples contribute to other rows. It is small enough to need
/// little memory, and large enough that threads seldom wait for each other.
const ROWS_IN_FLIGHT_PER_THREAD: usize = 32;

/// Upper bound on the samples of a strip whose rows cannot be handed out before it is complete. So a cancelled render
/// loses a few seconds' work at most.
const SAMPLES: usize = 1 << 24;

/// [`SAMPLES`] makes no strip shorter than this many times the filter's support. The rows that are traced beside the
/// strip then cost a thirtieth of the work.
const ROWS_PER_SUPPORT: usize = 64;

/// Some rows of the window, counted from the bottom.
pub struct Strip<'a> {
    request: &'a Request,
    pub rows: Range<usize>,
}

/// Rows that are ready to be handed out.
struct Finished {
    counts: Counts,
    /// The colours of each row of pixels, from the bottom, and its other layers.
    rows: Vec<(Vec<Color>, Vec<Vec<Color>>)>,
}

impl<'a> Strip<'a> {
    /// Returns the strip of rows from `end` down to at most `first`: as many as the memory allows, and at least one.
    pub fn below(request: &'a Request, end: usize, first: usize) -> Self {
        let Request { sampler, adaptive, .. } = request;
        let width = request.columns().len();
        let rows = MEMORY / (request.colors_per_row() * size_of::<Color>()).max(1);
        // If rows around the strip are traced and discarded, take more rows, so that the discarded ones are a small
        // part of the work.
        let support = request.support();
        // The number of adaptive samples is not known. It is seldom the maximum.
        let samples = adaptive.map_or(sampler.count(), |adaptive| adaptive.most / 4) as usize;
        let few = (SAMPLES / (width * samples).max(1)).max(ROWS_PER_SUPPORT * support);
        // Rows are handed out together if they depend on each other, and adaptive samples are planned together.
        let rows = if support > 0 || adaptive.is_some() { rows.min(few) } else { rows };
        let rows = rows.max(8 * support).max(rayon::current_num_threads());
        Self { request, rows: end.saturating_sub(rows).max(first)..end }
    }

    /// Traces the strip and hands it out. Returns the counts.
    pub fn render(
        &self,
        picture: &PictureTracer,
        bands: &[Band],
        tally: &Tally,
        take_row: TakeRow,
    ) -> Result<Counts, Stopped> {
        let request = self.request;
        let tracer = &picture.rows(self.traced());
        if request.support() > 0 {
            let finished = self.finish(tracer, bands, tally);
            return finished.ok_or(self.cancelled_above(self.rows.end))?.hand_out(request, take_row);
        }
        // Hand out a batch of rows while the next one is traced.
        let batch = ROWS_PER_BATCH * rayon::current_num_threads();
        let (mut counts, mut end, mut traced) = (Counts::default(), self.rows.end, vec![]);
        let mut hand_out_rows = |rows: &[Row]| {
            let taken = rows.iter().try_for_each(|row| {
                counts = counts.merge(row.counts);
                hand_out(row.colors.finished(), &row.layers, request, take_row)
            });
            taken.inspect_err(|_| tally.cancel())
        };
        while end > self.rows.start {
            let rows = end.saturating_sub(batch).max(self.rows.start)..end;
            let (taken, next) = rayon::join(
                || hand_out_rows(&traced),
                || in_parallel(rows.clone(), tally, |j| self.row(j, tracer, bands, tally)),
            );
            taken?;
            traced = next.into_iter().rev().map_while(|row| row).collect();
            if traced.len() < rows.len() {
                hand_out_rows(&traced)?;
                return Err(self.cancelled_above(end - traced.len()));
            }
            end = rows.start;
        }
        hand_out_rows(&traced)?;
        Ok(counts)
    }

    /// Returns the error of a render that is cancelled after the rows from `end` on have been handed out.
    fn cancelled_above(&self, end: usize) -> Stopped {
        Stopped::Cancelled { rows: self.request.rows().end - end }
    }

    /// Returns the rows to trace: the rows of the strip, and the rows around it whose samples contribute to it.
    pub fn traced(&self) -> Range<usize> {
        self.request.traced_rows(self.rows.clone())
    }

    /// Traces the strip. Returns `None` if the watch cancels the render.
    fn finish(&self, tracer: &PictureTracer, bands: &[Band], tally: &Tally) -> Option<Finished> {
        let Request { filter, size, .. } = *self.request;
        let traced = self.traced();
        let mut film = Film::starting_at(filter, size, traced.start);
        let mut finished =
            Finished { counts: Counts::default(), rows: vec![Default::default(); self.rows.len()] };
        for first in traced.clone().step_by(self.rows_in_flight()) {
            let rows = first..traced.end.min(first + self.rows_in_flight());
            for row in in_parallel(rows, tally, |j| self.row(j, tracer, bands, tally)) {
                finished.take(row?, self, &mut film);
            }
        }
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
    fn row(&self, j: usize, tracer: &PictureTracer, bands: &[Band], tally: &Tally) -> Option<Row> {
        let is_shown = self.rows.contains(&j);
        let plan = bands.iter().find_map(|band| band.plan(j));
        let mut row = tracer.row(j, is_shown, plan)?;
        row.counts = row.counts.merge(plan.map_or(Counts::default(), |plan| plan.counts));
        if is_shown {
            tally.row_is_done(row.counts.rays());
        }
        Some(row)
    }
}

impl Finished {
    fn take(&mut self, row: Row, strip: &Strip, film: &mut Film) {
        let request = strip.request;
        let index = |j: usize| strip.rows.contains(&j).then(|| j - strip.rows.start);
        if let Some(i) = index(row.j) {
            self.counts = self.counts.merge(row.counts);
            self.rows[i].1 = row.layers;
        }
        match row.colors {
            Colors::Unwanted => {}
            Colors::Finished(colors) => {
                if let Some(i) = index(row.j) {
                    self.rows[i].0 = colors;
                }
            }
            Colors::Spread(spread) => film.add(spread, |j, colors| {
                if let Some(i) = index(j) {
                    let columns = request.columns();
                    self.rows[i].0 = colors.skip(columns.start).take(columns.len()).collect();
                }
            }),
        }
    }

    /// Hands out the rows from the top, and returns the counts.
    fn hand_out(self, request: &Request, take_row: TakeRow) -> Result<Counts, Stopped> {
        let mut rows = self.rows.iter().rev();
        rows.try_for_each(|(colors, layers)| hand_out(colors, layers, request, take_row))?;
        Ok(self.counts)
    }
}

/// Hands out the layers of a row. Layers of colours get `colors`.
fn hand_out(
    colors: &[Color],
    layers: &[Vec<Color>],
    request: &Request,
    take_row: TakeRow,
) -> Result<(), Stopped> {
    for (k, (layer, measured)) in request.layers.iter().zip(layers).enumerate() {
        let row = if matches!(layer, Layer::Color) { colors } else { measured };
        let [width, _] = layer.size(request.window_size());
        if row.chunks_exact(width.max(1)).rev().try_for_each(|row| take_row(k, row)).is_break() {
            return Err(Stopped::Output);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests;
