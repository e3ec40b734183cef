//! The adaptive samples of a row of pixels: rays through the corners of all pixels, and then as many samples as each pixel
//! needs by what they see.

use super::{Colors, Painter, RenderSetting};
use crate::render::tally::{Tally, in_parallel};
use crate::render::tracing::{RowTracer, RowsTracer};
use crate::render::unseen::{self, Unseen, UnseenRows};
use crate::sampling::adaptive::{Adaptive, Contents, Corner, Line, color_of_corner};
use crate::sampling::drand48::Jump;
use crate::sampling::multi_jittered::MultiJittered;
use crate::sampling::sample_packet::SamplePacket;
use crate::stats::Counts;
use glam::DVec2;
use std::ops::Range;

/// What the rays through a row of corners of pixels see.
struct Corners {
    /// The column of the first corner: that of the pixel to the right.
    start: usize,
    corners: Vec<Corner>,
    /// For each corner that has a next one, the line around the side between them.
    sides: Vec<Line>,
    /// What each has cost, if that is asked for.
    counts: Vec<Counts>,
}

/// What corners tell of a row of pixels.
struct RowContents {
    /// The column of the first pixel.
    start: usize,
    contents: Vec<Contents>,
}

/// How many samples each pixel of a row gets.
pub struct Plan {
    settings: Adaptive,
    /// The column of the first pixel.
    start: usize,
    samples: Vec<u16>,
    /// What the corners of each pixel have cost, each counted once, if that is asked for.
    counts: Vec<Counts>,
}

/// What is known of some rows of pixels before they are sampled.
pub struct Pilot<'a> {
    setting: RenderSetting<'a>,
    of_picture: &'a Unseen<'a>,
    settings: Adaptive,
    columns: Range<usize>,
    /// The rows of corners from that with the second index on, with what was counted.
    corners: (Vec<(Corners, Counts)>, usize),
    /// The contents of the rows from that with the second index on.
    contents: (Vec<RowContents>, usize),
    unseen: UnseenRows,
}

/// The bytes that what decides on a row of pixels takes for each of them.
pub const BYTES_PER_PIXEL: usize =
    size_of::<Corner>() + size_of::<Line>() + size_of::<Contents>() + unseen::BYTES_PER_PIXEL;

/// How far things that are no larger than pixels are looked for around a pixel, in pixels.
const AROUND: usize = 4;

/// The part of their variance that a pixel is assumed to have, too.
const OF_AROUND: f32 = 1.0 / 64.0;

/// How far edges are.
const BESIDE: usize = 2;

/// The rows beside some that have to be traced for the corners that decide on them.
pub const ROWS_BESIDE: usize = AROUND + 2;

/// These and so many around them, of `count`.
fn widened(range: &Range<usize>, by: usize, count: usize) -> Range<usize> {
    range.start.saturating_sub(by)..(range.end + by).min(count)
}

/// The rows or columns of corners that decide on the contents of these pixels, of `count`.
fn corners_of(pixels: &Range<usize>, count: usize) -> Range<usize> {
    widened(&(pixels.start..pixels.end + 1), 1, count + 1)
}

impl<'a> Pilot<'a> {
    /// Casts rays through the corners of these rows of pixels and of those around them; none if the watch cancels the
    /// render.
    pub fn new(
        setting: &RenderSetting<'a>,
        (tracer, of_picture): (&RowsTracer, &'a Unseen<'a>),
        settings: Adaptive,
        [columns, rows]: [Range<usize>; 2],
        tally: &Tally,
    ) -> Option<Self> {
        let [_, height] = setting.request.size;
        let around = widened(&rows, AROUND, height);
        let of_corners = corners_of(&around, height);
        let trace = |j| setting.corners(tracer.row(), of_picture, &columns, j);
        let corners: Option<Vec<_>> = in_parallel(of_corners.clone(), tally, trace).into_iter().collect();
        let corners = (corners?, of_corners.start);
        let look = |j| setting.contents((&corners.0, corners.1), &columns, j);
        let contents: Option<Vec<_>> = in_parallel(around.clone(), tally, look).into_iter().collect();
        let (contents, unseen) = ((contents?, around.start), of_picture.rows(rows));
        Some(Self { setting: *setting, of_picture, settings, columns, corners, contents, unseen })
    }

    /// What the corners of a row of pixels have cost: those below it, and the uppermost ones of the picture, too.
    pub fn counts(&self, j: usize) -> Counts {
        let (corners, first) = &self.corners;
        let last = if j + 1 == self.setting.request.size[1] { j + 1 } else { j };
        let own = (j..=last).filter_map(|j| Some(corners.get(j.checked_sub(*first)?)?.1));
        own.fold(Counts::default(), Counts::merge)
    }

    /// How many samples the pixels of row `j` need.
    pub fn plan(&self, j: usize) -> Plan {
        let ((corners, first_corner), (contents, first)) = (&self.corners, &self.contents);
        let [below, above] = [j, j + 1].map(|j| &corners[j - first_corner].0);
        let row = &contents[j - first];
        // The strongest edges, and the largest variance, of each column around.
        let mut most = vec![[0.0f32; 2]; row.contents.len()];
        let rows = widened(&(j - first..j - first + 1), AROUND, contents.len());
        for (away, row) in rows.clone().map(|k| k.abs_diff(j - first)).zip(&contents[rows]) {
            for (most, contents) in most.iter_mut().zip(&row.contents) {
                let [edge, variance] = contents.edge_and_variance();
                let edge = if away > BESIDE { 0.0 } else { edge };
                *most = [most[0].max(edge), most[1].max(variance)];
            }
        }
        let count = self.settings.counts();
        let mut plan = Plan {
            settings: self.settings,
            start: self.columns.start,
            samples: Vec::with_capacity(self.columns.len()),
            counts: vec![],
        };
        for column in self.columns.clone() {
            let [k, index] = [column - row.start, column - below.start];
            let largest = |which: usize, by: usize| {
                let around = &most[widened(&(k..k + 1), by, most.len())];
                around.iter().fold(0.0, |a: f32, b| a.max(b[which]))
            };
            let (edges, around) = (largest(0, BESIDE), OF_AROUND * largest(1, AROUND));
            let corners =
                [(below, 0), (below, 1), (above, 0), (above, 1)].map(|(row, k)| row.corners[index + k]);
            let hidden = corners.iter().fold(0.0, |a: f32, corner| a.max(corner.hidden));
            let known = self.unseen.variance(self.of_picture, [column, j], &corners).max(hidden).max(around);
            plan.samples.push(count(row.contents[k].among(known, edges)) as u16);
            if !below.counts.is_empty() {
                // The corners at the upper and the right border of the picture are the last pixels', too.
                let [width, height] = self.setting.request.size;
                let rows = [below, above].into_iter().take(if j + 1 == height { 2 } else { 1 });
                let own = index..index + if column + 1 == width { 2 } else { 1 };
                let counts = rows.flat_map(|row| &row.counts[own.clone()]);
                plan.counts.push(counts.fold(Counts::default(), |sum, counts| sum.merge(*counts)));
            }
        }
        plan
    }
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

    /// What the corners of a pixel have cost.
    pub fn corner_counts(&self, column: usize) -> Counts {
        column.checked_sub(self.start).and_then(|k| self.counts.get(k)).copied().unwrap_or_default()
    }
}

impl RenderSetting<'_> {
    /// Casts the rays through row `j` of corners that decide on the pixels in these columns.
    fn corners(
        &self,
        tracer: RowTracer,
        unseen: &Unseen,
        columns: &Range<usize>,
        j: usize,
    ) -> (Corners, Counts) {
        let [width, height] = self.request.size;
        let columns = corners_of(&widened(columns, AROUND, width), width);
        // Those at the upper and the right border of the picture are in the last pixel.
        let row = j.min(height - 1);
        let mut painter = self.painter(self.empty_row(row, None), tracer, false);
        painter.row.colors = Colors::Unwanted;
        let mut packet = SamplePacket::default();
        let mut found = Corners {
            start: columns.start,
            corners: Vec::with_capacity(columns.len()),
            sides: Vec::with_capacity(columns.len()),
            counts: vec![],
        };
        let at_once = if self.request.has_costs() { 1 } else { SamplePacket::SIZE };
        for first in columns.clone().step_by(at_once) {
            let before = painter.row.counts;
            for column in first..columns.end.min(first + at_once) {
                let pixel = column.min(width - 1);
                packet.push(pixel, DVec2::new((column - pixel) as f64, (j - row) as f64) - 0.5, false);
            }
            let colors = painter.colors_of(&mut packet);
            found.corners.extend(packet.samples().iter().zip(colors).map(|(sample, color)| Corner {
                color: color_of_corner(color),
                hidden: sample.surface.map_or(0.0, |surface| unseen.hidden_by(&surface)),
                material: sample.surface.map(|surface| surface.material as u32),
                depth: sample.surface.map_or(f32::INFINITY, |surface| unseen.depth(surface.position)),
            }));
            packet.clear();
            if self.request.has_costs() {
                found.counts.push(painter.row.counts.since(before));
            }
        }
        let corner = |k: Option<usize>| found.corners.get(k?).copied();
        found.sides.extend(
            found
                .corners
                .windows(2)
                .enumerate()
                .map(|(k, pair)| Line::new(corner(k.checked_sub(1)), pair[0], pair[1], corner(Some(k + 2)))),
        );
        (found, painter.row.counts)
    }

    /// What corners tell of the pixels of row `j` in these columns and around them. The first of their rows has this index.
    fn contents(
        &self,
        (corners, first): (&[(Corners, Counts)], usize),
        columns: &Range<usize>,
        j: usize,
    ) -> RowContents {
        let columns = widened(columns, AROUND, self.request.size[0]);
        let row = |j: Option<usize>| Some(&corners.get(j?.checked_sub(first)?)?.0);
        let start = columns.start;
        let mut contents = Vec::with_capacity(columns.len());
        let (before, after) = (row(j.checked_sub(1)), row(Some(j + 2)));
        if let (Some(below), Some(above)) = (row(Some(j)), row(Some(j + 1))) {
            let along = [before.unwrap_or(below), below, above, after.unwrap_or(above)];
            let upright = |column: Option<usize>| {
                let at = |row: Option<&Corners>| row?.at(column);
                Some(Line::new(at(before), below.at(column)?, above.at(column)?, at(after)))
            };
            let mut lines = [start.checked_sub(1), Some(start), Some(start + 1), None].map(upright);
            for column in columns {
                lines[3] = upright(Some(column + 2));
                let [left, here, next, right] = lines;
                let (here, next) = (here.unwrap_or_default(), next.unwrap_or_default());
                let across = [left.unwrap_or(here), here, next, right.unwrap_or(next)];
                contents.push(Contents::new(along.map(|row| row.sides[column - row.start]), across));
                lines = [lines[1], lines[2], lines[3], None];
            }
        }
        RowContents { start, contents }
    }

    /// The offsets of the samples of one pixel.
    pub fn adaptive_offsets(
        &self,
        settings: Adaptive,
        tracer: &RowsTracer,
        unseen: &Unseen,
        [column, j]: [usize; 2],
        tally: &Tally,
    ) -> Vec<DVec2> {
        let window = [column..column + 1, j..j + 1];
        let Some(pilot) = Pilot::new(self, (tracer, unseen), settings, window, tally) else { return vec![] };
        let index = (column * self.request.size[1] + j) as u64;
        let rng = self.request.sampler.rng().jumped(index * MultiJittered::draws(settings.most));
        MultiJittered::new(pilot.plan(j).strata(column), rng).collect()
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
