//! The adaptive samples of a row of pixels: the first samples of each pixel, and then, where these and those around
//! them disagree, more.

use super::{Colors, Painter, RenderSetting};
use crate::memory::{self, NoMemory};
use crate::render::tracing::{RowTracer, RowsTracer};
use crate::render::request::Request;
use crate::render::unseen::{Unseen, UnseenRows};
use crate::sampling::adaptive::{Adaptive, Quarters, Strata, Stratum, StratumIndex, Undivided};
use crate::sampling::sample_packet::{Sample, SamplePacket};
use crate::scene::Color;
use crate::stats::Counts;
use std::ops::Range;

/// The first samples of a row of pixels.
pub struct FirstSamples {
    /// The column of the first pixel.
    start: usize,
    quarters: Vec<Quarters>,
    /// What they have cost, if that is asked for.
    counts: Vec<Counts>,
}

/// The first samples of a row of pixels, with those of the row below and above; none outside the picture.
pub type FirstRows<'a> = [Option<&'a FirstSamples>; 3];

/// What the adaptive samples of a row start from.
pub struct Refinement<'a> {
    settings: Adaptive,
    rows: FirstRows<'a>,
    unseen: &'a UnseenRows,
    strata: Strata<'a>,
    /// Those that need a sample.
    new: Vec<StratumIndex>,
}

impl<'a> Refinement<'a> {
    /// From the first samples of a row and those beside it, and what is known without them.
    pub fn new(settings: Adaptive, rows: FirstRows<'a>, unseen: &'a UnseenRows) -> Self {
        Self { settings, rows, unseen, strata: Strata::new(settings), new: vec![] }
    }

    /// What the first samples of a pixel have cost.
    pub fn first_counts(&self, column: usize) -> Counts {
        let [_, row, _] = self.rows;
        row.and_then(|row| row.counts.get(column.checked_sub(row.start)?)).copied().unwrap_or_default()
    }
}

impl FirstSamples {
    fn at(&self, column: Option<usize>) -> Option<&Quarters> {
        self.quarters.get(column?.checked_sub(self.start)?)
    }
}

/// The bytes that the first samples of a pixel take.
pub const BYTES_PER_PIXEL: usize = size_of::<Quarters>();

impl RenderSetting<'_> {
    /// Traces the first samples of row `j`, in the columns of the row's pixels and of those around them.
    pub fn first_samples(&self, tracer: RowTracer, unseen: &Unseen, j: usize) -> Result<(FirstSamples, Counts), NoMemory> {
        let columns = self.columns();
        let columns = columns.start.saturating_sub(1)..(columns.end + 1).min(self.request.size[0]);
        self.first_samples_in(tracer, unseen, columns, j)
    }

    /// Traces the first samples of the pixels in these columns.
    fn first_samples_in(
        &self,
        tracer: RowTracer,
        unseen: &Unseen,
        columns: Range<usize>,
        j: usize,
    ) -> Result<(FirstSamples, Counts), NoMemory> {
        let mut painter = self.painter(self.empty_row(j, None)?, tracer, false);
        painter.row.colors = Colors::Unwanted;
        let (mut packet, start) = (SamplePacket::default(), columns.start);
        let counted = if self.request.has_costs() { columns.len() } else { 0 };
        let (quarters, counts) = (memory::with_room(columns.len())?, memory::with_room(counted)?);
        let mut first = FirstSamples { start, quarters, counts };
        let pixels_at_once = if self.request.has_costs() { 1 } else { SamplePacket::SIZE / 4 };
        for some in columns.clone().step_by(pixels_at_once) {
            let before = painter.row.counts;
            for column in some..columns.end.min(some + pixels_at_once) {
                painter.push_first(column, &mut packet);
            }
            let colors = painter.colors_of(&mut packet);
            let (pixels, _) = packet.samples().as_chunks::<4>();
            let (colors, _) = colors.as_chunks::<4>();
            let quarters = |(pixel, colors): (&[Sample; 4], &[Color; 4])| {
                let hidden = |sample: &Sample| sample.surface.map_or(0.0, |surface| unseen.hidden_by(&surface));
                let offsets = pixel.each_ref().map(|sample| sample.source.offset);
                Quarters::new(offsets, *colors, pixel.each_ref().map(hidden))
            };
            first.quarters.extend(pixels.iter().zip(colors).map(quarters));
            packet.clear();
            if self.request.has_costs() {
                first.counts.push(painter.row.counts.since(before));
            }
        }
        Ok((first, painter.row.counts))
    }

    /// The samples of one pixel with their strata; none where there is no memory for them.
    pub fn strata(
        &self,
        settings: Adaptive,
        tracer: &RowsTracer,
        unseen: &Unseen,
        [column, j]: [usize; 2],
    ) -> Option<Vec<Stratum>> {
        let [width, height] = self.request.size;
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        let row = |j: Option<usize>| {
            let j = j.filter(|&j| j < height)?;
            Some(self.first_samples_in(tracer.row(), unseen, columns.clone(), j).ok()?.0)
        };
        let rows = [row(j.checked_sub(1)), row(Some(j)), row(Some(j + 1))];
        let unseen = unseen.rows(j..j + 1).ok()?;
        let mut painter = self.painter(self.empty_row(j, None).ok()?, tracer.row(), false);
        painter.row.colors = Colors::Unwanted;
        painter.refinement = Some(Refinement::new(settings, rows.each_ref().map(Option::as_ref), &unseen));
        painter.refine(column..column + 1, &mut SamplePacket::default());
        painter.refinement.map(|mut refinement| refinement.strata.finish().flatten().copied().collect())
    }
}

impl Painter<'_> {
    /// Adds the first samples of a pixel to a packet.
    fn push_first(&self, column: usize, packet: &mut SamplePacket) {
        let index = self.index(column);
        for offset in self.setting.request.sampler.offsets(index) {
            packet.push(column, offset, false);
        }
    }

    /// Takes the samples of the pixels in these columns, the first of which have been traced, and adds them to the row.
    pub fn refine(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Some(mut refinement) = self.refinement.take() else { return };
        let Refinement { settings, rows, unseen, strata, new } = &mut refinement;
        let Request { sampler, size: [width, height], .. } = *self.setting.request;
        let all = (width * height) as u64;
        strata.start(columns.map(|column| Undivided {
            column,
            around: rows.map(|row| [column.checked_sub(1), Some(column), Some(column + 1)].map(|x| row?.at(x))),
            known: unseen.variance([column, self.row.j]),
            rng: sampler.further(self.index(column), all, settings.most),
        }));
        loop {
            strata.divide(new);
            if new.is_empty() {
                break;
            }
            self.sample(strata, new, packet);
        }
        for pixel in strata.finish() {
            pixel.iter().for_each(|stratum| self.add_stratum(stratum));
            let sum = std::mem::take(&mut self.sum);
            self.finish(&sum);
        }
        self.refinement = Some(refinement);
    }

    /// Samples the strata that have no colours yet.
    fn sample(&mut self, strata: &mut Strata, new: &[StratumIndex], packet: &mut SamplePacket) {
        for some in new.chunks(SamplePacket::SIZE) {
            for &index in some {
                let Stratum { column, offset, .. } = *strata.stratum(index);
                packet.push(column, offset, false);
            }
            let colors = self.colors_of(packet);
            some.iter().zip(colors).for_each(|(&index, color)| strata.stratum(index).color = color);
            packet.clear();
        }
    }

    fn add_stratum(&mut self, stratum: &Stratum) {
        let Stratum { column, offset, color, .. } = *stratum;
        match &mut self.row.colors {
            Colors::Unwanted => {}
            Colors::Finished(_) => {
                self.sum.add(self.setting.request.filter.weight(offset) * stratum.area(), color);
            }
            Colors::Spread(spread) => spread.add(column, offset, color, stratum.area()),
        }
        if !self.plots.is_empty() {
            self.plot(column, offset, color);
        }
    }
}
