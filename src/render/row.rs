//! Traces the samples of a row of pixels, and adds their colours to the layers.

use super::layer::Layer;
use super::plan::Plan;
use super::request::{Request, Tracing, View};
use super::tracing::PictureTracer;
use crate::caster::Caster;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::render::grid_view::Face;
use crate::sampling::c_rand::CRand;
use crate::sampling::sample_packet::{PacketColors, Sample, SamplePacket, SamplePlace, Wanted};
use crate::sampling::spread::Spread;
use crate::sampling::sum::Sum;
use crate::shading::light::incident;
use crate::stats::Counts;
use crate::trace::{Memory, Observer};
use crate::world::World;
use glam::DVec2;
use plot::plots;
use std::ops::Range;

mod measure;
mod planned;
mod plot;
mod traced;

pub use planned::Looked;
pub use traced::{Colors, Row};

/// The data that every row of a picture needs to be traced.
#[derive(Clone, Copy)]
pub struct RenderSetting<'a> {
    pub caster: &'a Caster<'a>,
    pub view: View<'a>,
    pub request: &'a Request,
    pub tracing: Tracing,
}

impl RenderSetting<'_> {
    /// Traces an empty row. Returns `None` if the render is cancelled meanwhile, possibly within a pixel that takes
    /// long. If `is_shown` is false, only the samples are traced, because they contribute to the rows around it.
    pub fn row(&self, empty: Row, tracer: &PictureTracer, is_shown: bool, plan: Option<Plan>) -> Option<Row> {
        let mut painter = Painter { plan, ..self.painter(empty, tracer, is_shown) };
        let (columns, mut packet) = (self.columns(), SamplePacket::default());
        if self.request.has_costs() {
            for column in columns {
                painter.paint_and_count(column, &mut packet);
                if painter.memory.is_cut() {
                    return None;
                }
            }
            return Some(painter.row);
        }
        for first in columns.clone().step_by(SamplePacket::SIZE) {
            painter.paint(first..columns.end.min(first + SamplePacket::SIZE), &mut packet);
            if painter.memory.is_cut() {
                return None;
            }
        }
        Some(painter.row)
    }

    /// Returns the number of colours in a row of pixels, over all layers.
    pub fn colors_per_row(&self) -> usize {
        let width = self.request.columns().len();
        self.request.layers.iter().map(|layer| layer.colors_per_row(width)).sum()
    }

    /// Returns the columns whose samples contribute to the row.
    pub fn columns(&self) -> Range<usize> {
        let RenderSetting { request, .. } = *self;
        let (shown, support) = (request.columns(), request.support());
        shown.start.saturating_sub(support)..(shown.end + support).min(request.size[0])
    }

    /// Returns a painter of an empty row.
    fn painter<'a>(&'a self, row: Row, tracer: &'a PictureTracer<'a>, is_shown: bool) -> Painter<'a> {
        let RenderSetting { request, .. } = *self;
        Painter {
            setting: *self,
            tracer,
            memory: tracer.memory(),
            is_shown,
            shown: request.columns(),
            center_weight: request.filter.weight(DVec2::ZERO),
            sum: Sum::default(),
            plots: plots(request, is_shown),
            c_rand: request.sampler.c_rand([self.columns().start, row.j], request.size[0]),
            plan: None,
            row,
        }
    }

    /// Returns an empty row `j`. Reuses the memory of `used` if possible.
    pub fn empty_row(&self, j: usize, used: Option<Row>) -> Row {
        let RenderSetting { request, .. } = *self;
        if let Some(row) = used.and_then(|used| used.emptied(j)) {
            return row;
        }
        let colors = match (request.has_colors(), request.filter.support()) {
            (false, _) => Colors::Unwanted,
            (true, 0) => Colors::Finished(Vec::with_capacity(request.columns().len())),
            (true, _) => Colors::Spread(Spread::new(request.filter, self.caster.level, j, request.size)),
        };
        let layers = request.layers.iter().map(|layer| match layer {
            Layer::Color | Layer::Filter { .. } => vec![],
            _ => Vec::with_capacity(layer.colors_per_row(request.columns().len())),
        });
        Row { j, counts: Counts::default(), colors, layers: layers.collect() }
    }
}

/// Traces the pixels of one row.
struct Painter<'a> {
    setting: RenderSetting<'a>,
    tracer: &'a PictureTracer<'a>,
    memory: Memory<'a>,
    is_shown: bool,
    /// The columns of the window.
    shown: Range<usize>,
    /// The filter's weight of a sample at the pixel's centre.
    center_weight: f64,
    /// The sum over the current pixel's samples so far.
    sum: Sum,
    /// The indices of the layers of samples, each with its zoom.
    plots: Vec<(usize, usize)>,
    /// The random numbers of the next sample, if they are drawn row by row.
    c_rand: Option<CRand>,
    /// The number of samples of each pixel, if the samples are adaptive.
    plan: Option<Plan<'a>>,
    row: Row,
}

impl Painter<'_> {
    /// Traces the pixels in these columns. There must not be more columns than a packet holds.
    fn paint(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Request { sampler, .. } = *self.setting.request;
        for (k, zoom) in self.plots.clone() {
            self.plot_background(k, zoom, columns.clone());
        }
        let colors = self.setting.request.traces_colors(self.setting.tracing);
        if self.is_shown && self.setting.request.measures() || colors && sampler.is_center() {
            self.paint_centers(columns.clone(), packet);
        }
        if colors && self.plan.is_some() {
            self.take_planned(columns, packet);
        } else if colors && !sampler.is_center() {
            self.take_samples(columns, packet);
        }
    }

    /// Paints one pixel by itself, and adds its cost to the layers of costs.
    #[cold]
    fn paint_and_count(&mut self, column: usize, packet: &mut SamplePacket) {
        let before = self.row.counts;
        self.paint(column..column + 1, packet);
        if !self.is_shown || !self.shown.contains(&column) {
            return;
        }
        let mut cost = self.row.counts.since(before);
        if let Some(plan) = &self.plan {
            cost = cost.merge(plan.cost(column));
        }
        for (layer, colors) in self.setting.request.layers.iter().zip(&mut self.row.layers) {
            if let Layer::Cost(kind) = layer {
                colors.push(Color::splat(kind.of(&cost) as f64));
            }
        }
    }

    /// Measures the centres of pixels, and colours them if the samples are at the centres.
    fn paint_centers(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let RenderSetting { view, request, .. } = self.setting;
        let (measures, casts) =
            (self.is_shown && request.measures(), request.casts_centers(view, self.setting.tracing));
        let wanted = Wanted {
            hits: measures || casts,
            surfaces: request.has_normals() || casts,
            colors: request.traces_colors(self.setting.tracing) && request.sampler.is_center(),
        };
        packet.push_centers(columns);
        let mut colors = [Color::ZERO; SamplePacket::SIZE];
        self.trace(wanted, packet, &mut colors);
        if measures {
            self.measure(packet.samples());
        }
        if wanted.colors {
            self.add_samples::<true>(packet, &colors);
        }
        packet.clear();
    }

    /// Returns the index of a pixel in the order in which random numbers are drawn.
    fn index(&self, column: usize) -> u64 {
        let [_, height] = self.setting.request.size;
        (column * height + self.row.j) as u64
    }

    /// Traces the samples of the pixels in these columns, packet by packet.
    fn take_samples(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Request { sampler, size: [_, height], .. } = *self.setting.request;
        if let Some(c_rand) = &mut self.c_rand {
            columns.for_each(|column| packet.push(column, c_rand.next_offset(), true));
            return self.color_samples(packet);
        }
        let mut pixels = sampler.pixels(self.index(columns.start), height as u64);
        for column in columns {
            let mut offsets = pixels.next_offsets();
            while let Some(offset) = offsets.next() {
                packet.push(column, offset, offsets.len() == 0);
                if packet.is_full() {
                    self.color_samples(packet);
                }
            }
        }
        self.color_samples(packet);
    }

    /// Traces and adds the samples of a packet, and empties it.
    fn color_samples(&mut self, packet: &mut SamplePacket) {
        let mut colors = [Color::ZERO; SamplePacket::SIZE];
        self.trace(self.wanted_of_samples(), packet, &mut colors);
        self.add_samples::<false>(packet, &colors);
        packet.clear();
    }

    /// Counts and traces a packet's samples, and returns their colours.
    fn colors_of(&mut self, packet: &mut SamplePacket) -> PacketColors {
        packet.samples().iter().for_each(|_| self.row.counts.non_shadow_ray());
        let mut colors = [Color::ZERO; SamplePacket::SIZE];
        self.trace(self.wanted_of_samples(), packet, &mut colors);
        colors
    }

    /// Returns the results that coloured samples need. A view of cells casts no ray into the scene for them.
    fn wanted_of_samples(&self) -> Wanted {
        let is_scene = matches!(self.setting.view, View::Scene);
        Wanted { hits: is_scene, surfaces: is_scene, colors: true }
    }

    /// Traces the samples of a packet, and stores their colours if they are wanted.
    fn trace(&mut self, wanted: Wanted, packet: &mut SamplePacket, colors: &mut PacketColors) {
        let of_tracer =
            Wanted { colors: wanted.colors && matches!(self.setting.view, View::Scene), ..wanted };
        let (memory, counts) = (&mut self.memory, &mut self.row.counts);
        self.tracer.trace(self.row.j, of_tracer, packet, colors, memory, counts);
        let RenderSetting { view, request, .. } = self.setting;
        match view {
            View::Scene => {}
            View::Cells(occupancy) => {
                let world = self.setting.caster.world;
                for (color, Sample { ray, .. }) in colors.iter_mut().zip(packet.samples()) {
                    let face = occupancy.first_face(ray);
                    *color = face.map_or(world.background, |face| cell_color(&face, ray, world));
                }
            }
            View::Places => {
                for (color, sample) in colors.iter_mut().zip(packet.samples()) {
                    *color = place_color([sample.source.column, self.row.j], request.size);
                }
            }
        }
    }

    /// Adds the samples of a packet, with these colours, to the row.
    #[inline(always)]
    fn add_samples<const CENTERS: bool>(&mut self, packet: &SamplePacket, colors: &[Color]) {
        let mut sum = self.sum;
        for (Sample { source: SamplePlace { column, offset, is_last }, .. }, color) in
            packet.samples().iter().zip(colors)
        {
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
        self.row.counts.non_shadow_ray();
        match &mut self.row.colors {
            Colors::Unwanted => {}
            Colors::Finished(_) if CENTERS => sum.add(self.center_weight, color),
            Colors::Finished(_) => sum.add(self.setting.request.filter.weight(offset), color),
            Colors::Spread(spread) => {
                let part = self.plan.as_ref().map_or(1.0, |plan| plan.part(column));
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
        if let Colors::Finished(colors) = &mut self.row.colors {
            colors.push(sum.color());
        }
    }
}

/// Returns the colour that shows a pixel's place: its column and its row from the bottom.
fn place_color([column, row]: [usize; 2], [width, height]: [usize; 2]) -> Color {
    Color::new(column as f64 / width as f64, (height - 1 - row) as f64 / height as f64, 1.0)
}

/// Returns the colour of a cell's face under the scene's lights: ambient and diffuse, without shadows.
fn cell_color(face: &Face, ray: &Ray, world: &World) -> Color {
    let point = ray.at(face.t);
    let lights = world.lights.iter().map(|light| {
        let light = incident(light, point);
        light.color * face.normal.dot(light.direction).max(0.0)
    });
    face.color * (world.ambient + lights.sum::<Color>())
}

#[cfg(test)]
mod tests;
