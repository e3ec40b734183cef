//! A strip of rows: it is traced from the bottom, in the order in which the film adds up samples, and handed
//! out from the top, in the order of rows in files.
//!
//! If the filter's support extends beyond a pixel's row, the samples of the rows around the strip are traced
//! as well, so that the strip's pixels are those of the whole picture.

use super::layer::Layer;
use super::request::Request;
use super::row::adaptive::{BYTES_PER_PIXEL, FirstSamples, Refinement};
use super::row::{Colors, Row, Setting};
use super::spare::Spare;
use super::tally::{Tally, in_parallel};
use super::{Stopped, TakeRow};
use crate::memory::{self, NoMemory};
use crate::mode::Mode;
use crate::raster::VisibilityBuffer;
use crate::sampling::film::Film;
use crate::sampling::spread::Spread;
use crate::scene::Color;
use crate::trace::Observer;
use std::ops::Range;

/// Upper bound on the memory of a strip's finished rows, in bytes.
const MEMORY: usize = 48 << 20;

/// Upper bound on the memory of a strip's rows in progress, in bytes.
const MEMORY_IN_FLIGHT: usize = 32 << 20;

/// Upper bound on the rows in progress, per thread, where samples contribute to other rows: so few that the system does
/// not have to provide much memory, and so many that threads seldom wait for each other.
const ROWS_IN_FLIGHT_PER_THREAD: usize = 32;

/// Upper bound on the samples of a strip whose rows cannot be handed out before it is complete, so that not much is
/// lost when the render is cancelled: a few seconds' work.
const SAMPLES: usize = 1 << 24;

/// A strip is not made shorter than this many times the rows beside it that are traced for it, which cost a thirtieth
/// then.
const ROWS_PER_SUPPORT: usize = 64;

/// The number of rows, per thread, that are handed out together where no sample contributes to another row: so few that
/// their colours, whose memory is used again, stay in the cache, and so many that threads seldom wait for each other.
const ROWS_PER_THREAD: usize = 64;

/// Some rows of the window, counted from the bottom.
pub struct Strip<'a, M> {
    setting: &'a Setting<'a, M>,
    pub rows: Range<usize>,
}

/// The first samples of some rows, and their probes.
type FirstOfRows<P> = (Vec<FirstSamples>, Vec<P>);

/// Rows that are ready to be handed out.
struct Finished<P> {
    probe: P,
    /// The layers of each row of pixels, from the bottom.
    rows: Vec<Vec<Vec<Color>>>,
}

impl<'a, M: Mode> Strip<'a, M> {
    /// The rows from `end` down to at most `first`: as many as the memory allows, and at least one.
    pub fn below(setting: &'a Setting<'a, M>, end: usize, first: usize) -> Self {
        let Request { layers, sampler, adaptive, .. } = setting.request;
        let width = setting.request.columns().len();
        let colors: usize = layers.iter().map(|layer| layer.colors_per_row(width)).sum();
        let rows = MEMORY / (colors * size_of::<Color>()).max(1);
        // There are more if rows around the strip are traced and discarded, so that they are a small part of
        // the work.
        let support = setting.request.support();
        // The number of adaptive samples is not known; they seldom are the most.
        let samples = adaptive.map_or(sampler.count(), |adaptive| adaptive.most / 4) as usize;
        let few = (SAMPLES / (width * samples).max(1)).max(ROWS_PER_SUPPORT * support);
        let rows = if Self::hands_out_at_once(setting.request) { rows.min(few) } else { rows };
        let rows = rows.max(8 * support).max(rayon::current_num_threads());
        Self { setting, rows: end.saturating_sub(rows).max(first)..end }
    }

    /// Whether rows depend on each other, so that all of a strip are handed out at once.
    fn hands_out_at_once(request: &Request) -> bool {
        request.support() > 0 || request.adaptive.is_some()
    }

    /// Traces the strip and hands it out, and returns the probe.
    pub fn render<P: Observer, E>(&self, tally: &Tally, take_row: TakeRow<E>) -> Result<P, Stopped<E>> {
        let request = self.setting.request;
        if Self::hands_out_at_once(request) {
            let finished = self.finish::<P>(tally)?.ok_or(self.cancelled_above(self.rows.end))?;
            return finished.hand_out(request, self.setting.spare, take_row).map_err(Stopped::Output);
        }
        let visibility = self.visibility::<P>(self.rows.clone());
        let (mut probe, mut end) = (P::default(), self.rows.end);
        while end > self.rows.start {
            let first = end.saturating_sub(ROWS_PER_THREAD * rayon::current_num_threads());
            let rows = first.max(self.rows.start)..end;
            let part = Strip { setting: self.setting, rows: rows.clone() };
            let mut finished = Finished { probe, rows: memory::filled(vec![], rows.len())? };
            let mut film = Film::starting_at(request.filter, request.size, rows.start);
            let traced = part.trace(rows.clone(), visibility.as_ref(), tally)?;
            let complete = traced.iter().rev().take_while(|row| row.is_some()).count();
            for row in traced.into_iter().skip(rows.len() - complete).flatten() {
                finished.take(row, &part, &mut film)?;
            }
            probe = finished.hand_out(request, self.setting.spare, take_row).map_err(Stopped::Output)?;
            if complete < rows.len() {
                return Err(self.cancelled_above(end - complete));
            }
            end = rows.start;
        }
        Ok(probe)
    }

    /// The render is cancelled when the rows from `end` on have been handed out.
    fn cancelled_above<E>(&self, end: usize) -> Stopped<E> {
        Stopped::Cancelled { rows: self.setting.request.rows().end - end }
    }

    /// The first hits of the rays through the centres of these rows, as far as they are known.
    fn visibility<P: Observer>(&self, rows: Range<usize>) -> Option<VisibilityBuffer> {
        let Setting { camera, caster, view, request, .. } = *self.setting;
        request.visibility::<M, P>(camera, caster, view, rows)
    }

    /// Traces the strip; none if the watch cancels the render.
    fn finish<P: Observer>(&self, tally: &Tally) -> Result<Option<Finished<P>>, NoMemory> {
        let Request { filter, size, .. } = *self.setting.request;
        let [_, height] = size;
        let support = self.setting.request.support();
        let traced = self.rows.start.saturating_sub(support)..(self.rows.end + support).min(height);
        let mut film = Film::starting_at(filter, size, traced.start);
        let mut finished = Finished { probe: P::default(), rows: memory::filled(vec![], self.rows.len())? };
        // The first of adaptive samples are traced in the rows beside, too.
        let visibility = self.visibility::<P>(traced.start.saturating_sub(1)..(traced.end + 1).min(height));
        for first in traced.clone().step_by(self.rows_in_flight()) {
            let rows = first..traced.end.min(first + self.rows_in_flight());
            for row in self.trace(rows, visibility.as_ref(), tally)? {
                let Some(row) = row else { return Ok(None) };
                finished.take(row, self, &mut film)?;
            }
        }
        Ok(Some(finished))
    }

    /// The number of rows that are traced before they are added to the film: at least one for each thread. Adaptive
    /// samples are traced in as many rows at once as the memory allows, since those beside them are traced as well.
    fn rows_in_flight(&self) -> usize {
        let Request { filter, size, .. } = *self.setting.request;
        let threads = rayon::current_num_threads();
        let spread = if self.setting.request.support() == 0 { 0 } else { Spread::bytes(filter, size) };
        let (first, most) = match self.setting.request.adaptive {
            Some(_) => (BYTES_PER_PIXEL, usize::MAX),
            None => (0, ROWS_IN_FLIGHT_PER_THREAD * threads),
        };
        (MEMORY_IN_FLIGHT / (spread + (32 + first) * size[0])).min(most).max(threads).max(1)
    }

    /// Traces these rows; those are none that the watch cancels.
    fn trace<P: Observer>(
        &self,
        rows: Range<usize>,
        visibility: Option<&VisibilityBuffer>,
        tally: &Tally,
    ) -> Result<Vec<Option<Row<P>>>, NoMemory> {
        let Setting { request, .. } = *self.setting;
        let (first, probes) = match request.adaptive {
            Some(_) if request.traces_colors::<P>() => {
                match self.trace_first::<P>(&rows, visibility, tally)? {
                    Some(first) => first,
                    None => return memory::collected(rows.map(|_| None)),
                }
            }
            _ => (vec![], vec![]),
        };
        let first_row = rows.start.saturating_sub(1);
        let trace = |j: usize| {
            let is_shown = self.rows.contains(&j);
            let refinement = self.refinement(&first, first_row, j);
            let row = self.setting.row::<P>(visibility, j, is_shown, refinement)?;
            if is_shown {
                tally.row_is_done(row.probe.counts().rays());
            }
            Ok(row)
        };
        let mut traced = in_parallel(rows.clone(), tally, trace)?;
        for (row, probe) in traced.iter_mut().zip(probes.into_iter().skip(rows.start - first_row)) {
            if let Some(row) = row {
                row.probe = std::mem::take(&mut row.probe).merge(probe);
            }
        }
        Ok(traced)
    }

    /// Traces the first samples of these rows and of those beside them; none if the watch cancels the render.
    fn trace_first<P: Observer>(
        &self,
        rows: &Range<usize>,
        visibility: Option<&VisibilityBuffer>,
        tally: &Tally,
    ) -> Result<Option<FirstOfRows<P>>, NoMemory> {
        let all = rows.start.saturating_sub(1)..(rows.end + 1).min(self.setting.request.size[1]);
        let traced = in_parallel(all.clone(), tally, |j| self.setting.first_samples(visibility, j))?;
        let (mut first, mut probes) = (memory::with_room(all.len())?, memory::with_room(all.len())?);
        for row in traced {
            let Some((samples, probe)) = row else { return Ok(None) };
            first.push(samples);
            probes.push(probe);
        }
        Ok(Some((first, probes)))
    }

    /// What further samples of row `j` start from, given the first samples of the rows from `first_row` on; none if
    /// the first samples are all.
    fn refinement<'f>(
        &self,
        first: &'f [FirstSamples],
        first_row: usize,
        j: usize,
    ) -> Option<Refinement<'f>> {
        let row = |j: Option<usize>| first.get(j?.checked_sub(first_row)?);
        let rows = [row(j.checked_sub(1)), row(Some(j)), row(Some(j + 1))];
        rows[1]?;
        self.setting.request.adaptive.map(|settings| Refinement::new(settings, rows))
    }
}

impl<P: Observer> Finished<P> {
    fn take<M: Mode>(&mut self, row: Row<P>, strip: &Strip<M>, film: &mut Film) -> Result<(), NoMemory> {
        let Setting { request, .. } = *strip.setting;
        let index = |j: usize| strip.rows.contains(&j).then(|| j - strip.rows.start);
        if let Some(i) = index(row.j) {
            self.probe = std::mem::take(&mut self.probe).merge(row.probe);
            self.rows[i] = row.layers;
        }
        match row.colors {
            Colors::Unwanted => Ok(()),
            Colors::Finished(colors) => match index(row.j) {
                Some(i) => set_colors(&mut self.rows[i], request, colors),
                None => Ok(()),
            },
            Colors::Spread(spread) => film.add(spread, |j, colors| {
                let Some(i) = index(j) else { return Ok(()) };
                let columns = request.columns();
                let mut list = strip.setting.spare.list(columns.len())?;
                list.extend(colors.skip(columns.start).take(columns.len()));
                set_colors(&mut self.rows[i], request, list)
            }),
        }
    }

    /// Hands out the rows from the top, and returns the probe.
    fn hand_out<E>(self, request: &Request, spare: &Spare, take_row: TakeRow<E>) -> Result<P, E> {
        // Each row has taken one list: copies for further layers of colours would pile up.
        let first = request.layers.iter().position(|layer| matches!(layer, Layer::Color));
        for row in self.rows.into_iter().rev() {
            for (k, (layer, colors)) in request.layers.iter().zip(row).enumerate() {
                let [width, _] = layer.size(request.window_size());
                colors.chunks_exact(width.max(1)).rev().try_for_each(|colors| take_row(k, colors))?;
                if Some(k) == first {
                    spare.put(colors);
                }
            }
        }
        Ok(self.probe)
    }
}

/// Sets the colours of a row in all its layers of colours.
fn set_colors(layers: &mut [Vec<Color>], request: &Request, colors: Vec<Color>) -> Result<(), NoMemory> {
    let mut wanted = request.layers.iter().zip(layers).filter(|(layer, _)| matches!(layer, Layer::Color));
    if let Some((_, first)) = wanted.next() {
        for (_, other) in wanted {
            *other = memory::copied(&colors)?;
        }
        *first = colors;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
