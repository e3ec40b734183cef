//! Traces the samples of a row of pixels, and adds their colours to the layers.

use super::adaptive::AdaptiveRow;
use super::layer::Layer;
use super::request::Request;
use super::tracing::PictureTracer;
use crate::picture::Color;
use crate::sampling::c_rand::CRand;
use crate::sampling::sample_packet::{Sample, SamplePacket, Stage};
use crate::sampling::spread::Spread;
use crate::sampling::sum::Sum;
use crate::stats::Counts;
use crate::trace::RayStack;
use glam::DVec2;
use layers::plots;
use std::ops::Range;

mod layers;

/// The result of tracing a row of pixels.
pub struct Row {
    /// The index of the row, counted from the bottom.
    pub j: usize,
    /// The counts of the row's rays.
    pub counts: Counts,
    /// The cost of each pixel, if costs are a layer.
    pub costs: Vec<u64>,
    /// The sum of the pixels' estimated squared errors, with adaptive samples.
    pub squared_error: f64,
    /// The colour of each pixel, if its own samples determine it.
    pub colors: Vec<Color>,
    /// The contributions of the samples to this row and the rows around it, if the filter reaches that far.
    pub spread: Option<Spread>,
    /// The colours of each layer of the request: one for each pixel, or for a layer of samples the rows of the
    /// enlarged picture from the bottom. The list of a colour layer is empty, because its colours are in `colors`.
    pub layers: Vec<Vec<Color>>,
}

/// The results of some rays of a row.
pub struct RaySamples {
    pub colors: Vec<Color>,
    /// The cost of all rays together.
    pub counts: Counts,
    /// The cost of each ray, if costs are a layer.
    pub costs: Vec<u64>,
}

/// Places the samples of a row of pixels, from left to right.
pub struct RowSampler<'a> {
    request: &'a Request,
    j: usize,
    /// The number of samples of each pixel, if they are adaptive.
    adaptive: Option<AdaptiveRow<'a>>,
    /// The random numbers of the next sample, if they are drawn row by row.
    c_rand: Option<CRand>,
}

impl<'a> RowSampler<'a> {
    /// Returns a sampler of row `j` from the column `first` on.
    pub fn new(request: &'a Request, first: usize, j: usize, adaptive: Option<AdaptiveRow<'a>>) -> Self {
        Self { request, j, adaptive, c_rand: request.sampler.c_rand([first, j], request.size[0]) }
    }

    /// Calls `take` for each sample of the pixels in these columns, with its column, its offset from the pixel's
    /// centre, and true if it is the pixel's last.
    #[inline(always)]
    pub fn place(&mut self, columns: Range<usize>, take: impl FnMut(usize, DVec2, bool)) {
        let Request { sampler, size: [_, height], .. } = *self.request;
        // The index of the first pixel in the order in which random numbers are drawn.
        let first = (columns.start * height + self.j) as u64;
        if let Some(adaptive) = self.adaptive {
            each(columns, take, |column| {
                let sequence = sampler.sequence((column * height + self.j) as u64);
                (0..adaptive.samples(column)).map(move |index| sequence.offset(index))
            });
        } else if let Some(c_rand) = &mut self.c_rand {
            each(columns, take, |_| std::iter::once(c_rand.next_offset()));
        } else {
            let mut pixels = sampler.pixels(first, height as u64);
            each(columns, take, |_| pixels.next_offsets());
        }
    }
}

/// Calls `take` for each of the offsets of the pixels in these columns.
#[inline(always)]
fn each<Offsets: ExactSizeIterator<Item = DVec2>>(
    columns: Range<usize>,
    mut take: impl FnMut(usize, DVec2, bool),
    mut offsets_of: impl FnMut(usize) -> Offsets,
) {
    for column in columns {
        let mut offsets = offsets_of(column);
        while let Some(offset) = offsets.next() {
            take(column, offset, offsets.len() == 0);
        }
    }
}

impl PictureTracer<'_> {
    /// Traces row `j`. Returns `None` if the render is cancelled meanwhile, possibly within a pixel that takes
    /// long. If `is_shown` is false, only the samples are traced, because they contribute to the rows around it.
    pub fn row(&self, j: usize, is_shown: bool, adaptive: Option<AdaptiveRow>) -> Option<Row> {
        let request = self.request;
        let columns = request.traced_columns();
        let is_over = |waiting| self.tally.asks(waiting);
        let layers = request.layers.iter().map(|layer| match layer {
            Layer::Color => vec![],
            _ => Vec::with_capacity(layer.colors_per_row(request.columns().len())),
        });
        let row = Row {
            j,
            counts: Counts::default(),
            costs: vec![],
            squared_error: adaptive.map_or(0.0, AdaptiveRow::squared_error),
            colors: Vec::with_capacity(if request.has_colors() { request.columns().len() } else { 0 }),
            spread: (request.support() > 0)
                .then(|| Spread::new(request.filter, self.caster.level, j, request.size)),
            layers: layers.collect(),
        };
        let mut painter = Painter {
            tracer: self,
            stack: RayStack::until(&is_over, self.caster.world),
            is_shown,
            shown: request.columns(),
            center_weight: request.filter.weight(DVec2::ZERO),
            sum: Sum::default(),
            plots: plots(request, is_shown),
            adaptive,
            row,
        };
        let mut sampler = RowSampler::new(request, columns.start, j, adaptive);
        let mut packet = SamplePacket::default();
        let cost = request.cost();
        let at_once = if cost.is_some() { 1 } else { SamplePacket::SIZE };
        for first in columns.clone().step_by(at_once) {
            let before = std::mem::take(&mut painter.row.counts);
            painter.paint(first..columns.end.min(first + at_once), &mut sampler, &mut packet);
            if painter.stack.is_cut() {
                return None;
            }
            let counts = painter.row.counts;
            if let Some(cost) = cost.filter(|_| is_shown && painter.shown.contains(&first)) {
                painter
                    .row
                    .costs
                    .push(cost.of(&counts) + adaptive.and_then(|adaptive| adaptive.cost(first)).unwrap_or(0));
            }
            painter.row.counts = before.merge(counts);
        }
        // The last search may have ended early.
        Some(painter.row).filter(|_| !self.tally.is_cancelled())
    }

    /// Casts rays through these columns of row `j`, at these offsets from their pixels' centres. Returns `None` if the
    /// render is cancelled meanwhile.
    pub fn trace_rays(
        &self,
        j: usize,
        mut places: impl Iterator<Item = (usize, DVec2)>,
    ) -> Option<RaySamples> {
        let is_over = |waiting| self.tally.asks(waiting);
        let mut stack = RayStack::until(&is_over, self.caster.world);
        let mut traced = RaySamples { colors: vec![], counts: Counts::default(), costs: vec![] };
        let mut packet = SamplePacket::default();
        let cost = self.request.cost();
        let at_once = if cost.is_some() { 1 } else { SamplePacket::SIZE };
        loop {
            places.by_ref().take(at_once).for_each(|(column, offset)| packet.push(column, offset, false));
            let count = packet.samples().len();
            if count == 0 {
                return Some(traced).filter(|_| !self.tally.is_cancelled());
            }
            let mut counts = Counts { non_shadow_rays: count as u64, ..Counts::default() };
            self.trace(j, Stage::Rays, true, &mut packet, &mut stack, &mut counts);
            if stack.is_cut() {
                return None;
            }
            traced.colors.extend_from_slice(packet.colors());
            traced.costs.extend(cost.map(|cost| cost.of(&counts)));
            traced.counts = traced.counts.merge(counts);
            packet.clear();
        }
    }
}

/// Traces the pixels of one row.
struct Painter<'a> {
    tracer: &'a PictureTracer<'a>,
    stack: RayStack<'a>,
    is_shown: bool,
    /// The columns of the window.
    shown: Range<usize>,
    /// The filter's weight of a sample at the pixel's centre.
    center_weight: f64,
    /// The sum over the current pixel's samples so far.
    sum: Sum,
    /// The indices of the layers of samples, each with its zoom.
    plots: Vec<(usize, usize)>,
    /// The number of samples of each pixel, if they are adaptive.
    adaptive: Option<AdaptiveRow<'a>>,
    row: Row,
}

impl Painter<'_> {
    /// Traces the pixels in these columns. There must not be more columns than a packet holds.
    fn paint(&mut self, columns: Range<usize>, sampler: &mut RowSampler, packet: &mut SamplePacket) {
        let request = self.tracer.request;
        for (k, zoom) in self.plots.clone() {
            self.plot_background(k, zoom, columns.clone());
        }
        let measured = if self.is_shown { request.measured() } else { Stage::Rays };
        let (colors, are_centers) = (request.traces_colors(request.tracing), request.sampler.is_center());
        if measured > Stage::Rays || colors && are_centers {
            // Measure the centres, and colour them if the samples are there.
            columns.clone().for_each(|column| packet.push(column, DVec2::ZERO, true));
            self.trace(measured, colors && are_centers, packet);
            if measured > Stage::Rays {
                self.measure(packet.samples());
            }
            if colors && are_centers {
                self.add_samples::<true>(packet);
            }
            packet.clear();
        }
        if !colors || are_centers {
            return;
        }
        if let Some(adaptive) = self.adaptive {
            if adaptive.color(columns.start).is_some() {
                self.row.colors.extend(columns.filter_map(|column| adaptive.color(column)));
                return;
            }
            if let Some(kept) = adaptive.kept_samples(columns.clone()) {
                self.add_kept(columns, kept, sampler);
                return;
            }
        }
        sampler.place(columns, |column, offset, is_last| {
            packet.push(column, offset, is_last);
            if packet.is_full() {
                self.color_samples(packet);
            }
        });
        self.color_samples(packet);
    }

    /// Adds the samples of these columns, of which the colours are known.
    fn add_kept(&mut self, columns: Range<usize>, colors: &[Color], sampler: &mut RowSampler) {
        let (mut colors, mut sum) = (colors.iter(), Sum::default());
        sampler.place(columns, |column, offset, is_last| {
            let Some(color) = colors.next() else { return };
            self.add_sample::<false>(column, offset, *color, &mut sum);
            if is_last {
                self.finish(&std::mem::take(&mut sum));
            }
        });
    }

    /// Traces and adds the samples of a packet, and empties it.
    fn color_samples(&mut self, packet: &mut SamplePacket) {
        self.trace(Stage::Rays, true, packet);
        self.add_samples::<false>(packet);
        packet.clear();
    }

    fn trace(&mut self, measured: Stage, has_colors: bool, packet: &mut SamplePacket) {
        let (stack, counts) = (&mut self.stack, &mut self.row.counts);
        self.tracer.trace(self.row.j, measured, has_colors, packet, stack, counts);
    }

    /// Adds the samples of a packet to the row.
    #[inline(always)]
    fn add_samples<const CENTERS: bool>(&mut self, packet: &SamplePacket) {
        let mut sum = self.sum;
        self.row.counts.non_shadow_rays += packet.samples().len() as u64;
        for (Sample { column, offset, is_last, .. }, color) in packet.samples().iter().zip(packet.colors()) {
            self.add_sample::<CENTERS>(*column, *offset, *color, &mut sum);
            if CENTERS || *is_last {
                self.finish(&sum);
                sum = Sum::default();
            }
        }
        self.sum = sum;
    }

    /// Adds a sample to the row. `sum` is the sum of its pixel.
    #[inline(always)]
    fn add_sample<const CENTERS: bool>(&mut self, column: usize, offset: DVec2, color: Color, sum: &mut Sum) {
        match &mut self.row.spread {
            None if CENTERS => sum.add(self.center_weight, color, 1.0),
            None => sum.add(self.tracer.request.filter.weight(offset), color, 1.0),
            Some(spread) => {
                let part =
                    self.adaptive.as_ref().map_or(1.0, |adaptive| 1.0 / f64::from(adaptive.samples(column)));
                spread.add(column, offset, color, part);
            }
        }
        if !self.plots.is_empty() {
            self.plot(column, offset, color);
        }
    }

    /// Finishes a pixel, if only its own samples contribute to it.
    #[inline(always)]
    fn finish(&mut self, sum: &Sum) {
        if self.row.spread.is_none() {
            self.row.colors.push(sum.color());
        }
    }
}
