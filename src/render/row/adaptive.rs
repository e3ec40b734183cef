//! The adaptive samples of a row of pixels: the first samples of each pixel, and then, where these and those around
//! them disagree, more.

use super::{Colors, Painter, RenderSetting};
use crate::render::tracing::{RowTracer, RowsTracer};
use crate::sampling::adaptive::{Adaptive, Neighborhood, Quarters, Strata, Stratum};
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
    strata: Strata,
}

impl<'a> Refinement<'a> {
    pub fn new(settings: Adaptive, rows: FirstRows<'a>) -> Self {
        Self { settings, rows, strata: Strata::default() }
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
    pub fn first_samples(&self, tracer: RowTracer, j: usize) -> (FirstSamples, Counts) {
        let columns = self.columns();
        let columns = columns.start.saturating_sub(1)..(columns.end + 1).min(self.request.size[0]);
        self.first_samples_in(tracer, columns, j)
    }

    /// Traces the first samples of the pixels in these columns.
    fn first_samples_in(&self, tracer: RowTracer, columns: Range<usize>, j: usize) -> (FirstSamples, Counts) {
        let mut painter = self.painter(self.empty_row(j, None), tracer, false);
        painter.row.colors = Colors::Unwanted;
        let (mut packet, start) = (SamplePacket::default(), columns.start);
        let counted = if self.request.has_costs() { columns.len() } else { 0 };
        let (quarters, counts) = (Vec::with_capacity(columns.len()), Vec::with_capacity(counted));
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
                Quarters::new(pixel.each_ref().map(|sample| sample.source.offset), *colors)
            };
            first.quarters.extend(pixels.iter().zip(colors).map(quarters));
            packet.clear();
            if self.request.has_costs() {
                first.counts.push(painter.row.counts.since(before));
            }
        }
        (first, painter.row.counts)
    }

    /// The samples of one pixel with their strata.
    pub fn strata(&self, settings: Adaptive, tracer: &RowsTracer, [column, j]: [usize; 2]) -> Vec<Stratum> {
        let [width, height] = self.request.size;
        let columns = column.saturating_sub(1)..(column + 2).min(width);
        let row = |j: Option<usize>| {
            Some(self.first_samples_in(tracer.row(), columns.clone(), j.filter(|&j| j < height)?).0)
        };
        let rows = [row(j.checked_sub(1)), row(Some(j)), row(Some(j + 1))];
        let mut painter = self.painter(self.empty_row(j, None), tracer.row(), false);
        painter.row.colors = Colors::Unwanted;
        painter.refinement = Some(Refinement::new(settings, rows.each_ref().map(Option::as_ref)));
        painter.refine(column, &mut SamplePacket::default());
        painter.refinement.map(|refinement| refinement.strata.all().to_vec()).unwrap_or_default()
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

    /// Takes the samples of a pixel, the first of which have been traced, and adds them to the row.
    pub fn refine(&mut self, column: usize, packet: &mut SamplePacket) {
        let Some(mut refinement) = self.refinement.take() else { return };
        let Refinement { settings, rows, strata } = &mut refinement;
        let around: Neighborhood =
            rows.map(|row| [column.checked_sub(1), Some(column), Some(column + 1)].map(|x| row?.at(x)));
        if let Some(first) = around[1][1] {
            strata.start(first);
            self.divide(column, *settings, &around, strata, packet);
            strata.all().iter().for_each(|stratum| self.add_stratum(column, stratum));
            let sum = std::mem::take(&mut self.sum);
            self.finish(&sum);
        }
        self.refinement = Some(refinement);
    }

    /// Divides strata and samples the new ones until the pixel is finished.
    fn divide(
        &mut self,
        column: usize,
        settings: Adaptive,
        around: &Neighborhood,
        strata: &mut Strata,
        packet: &mut SamplePacket,
    ) {
        let request = self.setting.request;
        let pixels = (request.size[0] * request.size[1]) as u64;
        let mut rng = request.sampler.further(self.index(column), pixels, settings.most);
        loop {
            let new = strata.divide(settings, around, &mut rng);
            if new.is_empty() {
                return;
            }
            for some in new.chunks_mut(SamplePacket::SIZE) {
                for stratum in &*some {
                    packet.push(column, stratum.offset, false);
                }
                let colors = self.colors_of(packet);
                some.iter_mut().zip(colors).for_each(|(stratum, color)| stratum.color = color);
                packet.clear();
            }
        }
    }

    fn add_stratum(&mut self, column: usize, stratum: &Stratum) {
        let Stratum { offset, color, .. } = *stratum;
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
