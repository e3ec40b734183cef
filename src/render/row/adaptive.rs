//! The adaptive samples of a row of pixels: rays through the corners of all pixels, and then as many samples as each pixel
//! needs by what they see.

use super::{Colors, Painter, RenderSetting};
use crate::memory::{self, NoMemory};
use crate::render::tracing::{RowTracer, RowsTracer};
use crate::render::unseen::{Unseen, UnseenRows};
use crate::sampling::adaptive::{Adaptive, Contents, Corner, Line};
use crate::sampling::drand48::Jump;
use crate::sampling::multi_jittered::MultiJittered;
use crate::sampling::sample_packet::{Sample, SamplePacket};
use crate::stats::Counts;
use glam::DVec2;
use std::ops::{Range, RangeInclusive};

/// What the rays through a row of corners of pixels see.
pub struct Corners {
    /// The column of the first corner: that of the pixel to the right.
    start: usize,
    corners: Vec<Corner>,
    /// For each corner that has a next one, the line around the side between them.
    sides: Vec<Line>,
    /// What each has cost, if that is asked for.
    counts: Vec<Counts>,
}

/// The rows of corners below and above a row of pixels, and those before and after them; none outside the picture.
pub type CornerRows<'a> = [Option<&'a Corners>; 4];

/// How many samples each pixel of a row gets.
pub struct Plan {
    settings: Adaptive,
    /// The column of the first pixel.
    start: usize,
    samples: Vec<u16>,
    /// What the corner at the lower left of each pixel has cost, if that is asked for.
    counts: Vec<Counts>,
}

/// The bytes that the corners of a row take for each pixel.
pub const BYTES_PER_PIXEL: usize = size_of::<Corner>() + size_of::<Line>();

/// The rows of corners that decide on some rows of pixels, in a picture of this height.
pub fn rows_of_corners(rows: &Range<usize>, height: usize) -> RangeInclusive<usize> {
    rows.start.saturating_sub(1)..=(rows.end + 1).min(height)
}

impl Corners {
    fn at(&self, column: Option<usize>) -> Option<Corner> {
        self.corners.get(column?.checked_sub(self.start)?).copied()
    }
}

impl Plan {
    /// The part of its pixel that a sample in this column stands for.
    pub fn part(&self, column: usize) -> f64 {
        let [columns, rows] = self.strata(column);
        1.0 / f64::from(columns * rows)
    }

    /// The columns and rows of a pixel's strata.
    fn strata(&self, column: usize) -> [u32; 2] {
        let samples = column.checked_sub(self.start).and_then(|k| self.samples.get(k)).copied().unwrap_or(1);
        MultiJittered::strata(u32::from(samples), self.settings.most)
    }

    /// What the ray through the lower left corner of a pixel has cost.
    pub fn corner_counts(&self, column: usize) -> Counts {
        column.checked_sub(self.start).and_then(|k| self.counts.get(k)).copied().unwrap_or_default()
    }
}

impl RenderSetting<'_> {
    /// Casts the rays through row `j` of corners that decide on the pixels in the row's columns.
    pub fn corners(&self, tracer: RowTracer, unseen: &Unseen, j: usize) -> Result<(Corners, Counts), NoMemory> {
        self.corners_around(tracer, unseen, self.columns(), j)
    }

    fn corners_around(
        &self,
        tracer: RowTracer,
        unseen: &Unseen,
        columns: Range<usize>,
        j: usize,
    ) -> Result<(Corners, Counts), NoMemory> {
        let [width, height] = self.request.size;
        let columns = columns.start.saturating_sub(1)..(columns.end + 1).min(width) + 1;
        // Those at the upper and the right border of the picture are in the last pixel.
        let row = j.min(height - 1);
        let mut painter = self.painter(self.empty_row(row, None)?, tracer, false);
        painter.row.colors = Colors::Unwanted;
        let mut packet = SamplePacket::default();
        let counted = if self.request.has_costs() { columns.len() } else { 0 };
        let mut found = Corners {
            start: columns.start,
            corners: memory::with_room(columns.len())?,
            sides: memory::with_room(columns.len())?,
            counts: memory::with_room(counted)?,
        };
        let at_once = if self.request.has_costs() { 1 } else { SamplePacket::SIZE };
        for first in columns.clone().step_by(at_once) {
            let before = painter.row.counts;
            for column in first..columns.end.min(first + at_once) {
                let pixel = column.min(width - 1);
                packet.push(pixel, DVec2::new((column - pixel) as f64, (j - row) as f64) - 0.5, false);
            }
            let colors = painter.colors_of(&mut packet);
            let hidden = |sample: &Sample| sample.surface.map_or(0.0, |surface| unseen.hidden_by(&surface));
            let seen = packet.samples().iter().zip(colors).map(|(sample, color)| Corner::new(color, hidden(sample)));
            found.corners.extend(seen);
            packet.clear();
            if self.request.has_costs() {
                found.counts.push(painter.row.counts.since(before));
            }
        }
        let corner = |k: Option<usize>| found.corners.get(k?).copied();
        found.sides.extend(found.corners.windows(2).enumerate().map(|(k, pair)| {
            Line::new(corner(k.checked_sub(1)), pair[0], pair[1], corner(Some(k + 2)))
        }));
        Ok((found, painter.row.counts))
    }

    /// How many samples the pixels of row `j` need; none where corners are missing.
    pub fn plan(
        &self,
        settings: Adaptive,
        corners: CornerRows,
        unseen: &UnseenRows,
        j: usize,
    ) -> Result<Option<Plan>, NoMemory> {
        self.plan_of(settings, corners, unseen, self.columns(), j)
    }

    fn plan_of(
        &self,
        settings: Adaptive,
        corners: CornerRows,
        unseen: &UnseenRows,
        columns: Range<usize>,
        j: usize,
    ) -> Result<Option<Plan>, NoMemory> {
        let [before, Some(below), Some(above), after] = corners else { return Ok(None) };
        let along = [before.unwrap_or(below), below, above, after.unwrap_or(above)];
        let upright = |column: Option<usize>| {
            let at = |row: Option<&Corners>| row?.at(column);
            Some(Line::new(at(before), below.at(column)?, above.at(column)?, at(after)))
        };
        let count = settings.counts();
        let mut plan = Plan {
            settings,
            start: columns.start,
            samples: memory::with_room(columns.len())?,
            counts: memory::with_room(below.counts.len())?,
        };
        let first = columns.start;
        let mut lines = [first.checked_sub(1), Some(first), Some(first + 1), None].map(upright);
        for column in columns {
            lines[3] = upright(Some(column + 2));
            let [left, Some(here), Some(next), right] = lines else { return Ok(None) };
            let across = [left.unwrap_or(here), here, next, right.unwrap_or(next)];
            let index = column - below.start;
            let rows = along.map(|row| row.sides[index]);
            let corners = [below.corners[index], below.corners[index + 1], above.corners[index], above.corners[index + 1]];
            let contents = Contents::new(rows, across, corners, unseen.variance([column, j]));
            plan.samples.push(count(contents) as u16);
            lines = [lines[1], lines[2], lines[3], None];
        }
        if !below.counts.is_empty() {
            plan.counts.extend_from_slice(&below.counts[first - below.start..]);
        }
        Ok(Some(plan))
    }

    /// The offsets of the samples of one pixel; none where there is no memory for what decides on them.
    pub fn adaptive_offsets(
        &self,
        settings: Adaptive,
        tracer: &RowsTracer,
        unseen: &Unseen,
        [column, j]: [usize; 2],
    ) -> Option<Vec<DVec2>> {
        let height = self.request.size[1];
        let columns = column..column + 1;
        let corners = |j: Option<usize>| {
            Some(self.corners_around(tracer.row(), unseen, columns.clone(), j.filter(|&j| j <= height)?).ok()?.0)
        };
        let rows = [corners(j.checked_sub(1)), corners(Some(j)), corners(Some(j + 1)), corners(Some(j + 2))];
        let known = unseen.rows(j..j + 1).ok()?;
        let plan = self.plan_of(settings, rows.each_ref().map(Option::as_ref), &known, columns, j).ok()??;
        let index = (column * height + j) as u64;
        let rng = self.request.sampler.rng().jumped(index * MultiJittered::draws(settings.most));
        Some(MultiJittered::new(plan.strata(column), rng).collect())
    }
}

impl Painter<'_> {
    /// Takes the samples of the pixels in these columns as planned, packet by packet.
    pub fn take_planned(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Some(plan) = &self.plan else { return };
        let [_, height] = self.setting.request.size;
        let draws = MultiJittered::draws(plan.settings.most);
        let mut rng = self.setting.request.sampler.rng().jumped(self.index(columns.start) * draws);
        let jump = Jump::of(draws * height as u64);
        for column in columns {
            let Some(plan) = &self.plan else { return };
            let mut offsets = MultiJittered::new(plan.strata(column), rng);
            rng = rng.after(jump);
            while let Some(offset) = offsets.next() {
                packet.push(column, offset, offsets.len() == 0);
                if packet.is_full() {
                    self.color_samples(packet);
                }
            }
        }
        self.color_samples(packet);
    }
}
