//! Traces the samples of a row of pixels, and adds their colours to the layers.

use super::layer::Layer;
use super::plan::Plan;
use super::request::{Request, View};
use super::tracing::PictureTracer;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::render::grid_view::Face;
use crate::sampling::c_rand::CRand;
use crate::sampling::drand48::Jump;
use crate::sampling::multi_jittered::MultiJittered;
use crate::sampling::sample_packet::{PacketColors, Sample, SamplePacket, SamplePlace, Wanted};
use crate::sampling::spread::Spread;
use crate::sampling::sum::Sum;
use crate::shading::light::incident;
use crate::stats::Counts;
use crate::trace::{Memory, Observer};
use crate::world::World;
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
    pub colors: Colors,
    /// The colours of each layer of the request: one for each pixel, or for a layer of samples the rows of the
    /// enlarged picture from the bottom. The list of a colour layer is empty, because its colours are in `colors`.
    pub layers: Vec<Vec<Color>>,
}

/// The contribution of a row's samples to the layer of colours.
pub enum Colors {
    /// Nothing, because the request has no such layer.
    Unwanted,
    /// The colours of the row itself, if every sample contributes to its own pixel only.
    Finished(Vec<Color>),
    /// Sums for this row and the rows around it.
    Spread(Spread),
}

impl Colors {
    /// Returns the colours of the row itself, or an empty list if they are not known.
    pub fn finished(&self) -> &[Color] {
        match self {
            Self::Finished(colors) => colors,
            Self::Unwanted | Self::Spread(_) => &[],
        }
    }
}

/// The results of rays that do not contribute to the picture.
pub struct Looked {
    pub colors: Vec<Color>,
    /// The cost of all rays together.
    pub counts: Counts,
    /// The cost of each ray, if costs are a layer.
    pub costs: Vec<Counts>,
}

impl PictureTracer<'_> {
    /// Traces row `j`. Returns `None` if the render is cancelled meanwhile, possibly within a pixel that takes
    /// long. If `is_shown` is false, only the samples are traced, because they contribute to the rows around it.
    pub fn row(&self, j: usize, is_shown: bool, plan: Option<Plan>) -> Option<Row> {
        let mut painter = Painter { plan, ..self.painter(j, is_shown) };
        let (columns, mut packet) = (self.request.traced_columns(), SamplePacket::default());
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

    /// Casts rays through these columns of row `j`, at these offsets from their pixels' centres. Returns `None` if the
    /// render is cancelled meanwhile.
    pub fn look(&self, j: usize, mut places: impl Iterator<Item = (usize, DVec2)>) -> Option<Looked> {
        let mut painter = self.painter(j, false);
        let (mut packet, mut colors, mut costs) = (SamplePacket::default(), vec![], vec![]);
        let has_costs = self.request.has_costs();
        let at_once = if has_costs { 1 } else { SamplePacket::SIZE };
        loop {
            places.by_ref().take(at_once).for_each(|(column, offset)| packet.push(column, offset, false));
            let count = packet.samples().len();
            if count == 0 {
                return Some(Looked { colors, counts: painter.row.counts, costs });
            }
            let before = painter.row.counts;
            colors.extend_from_slice(&painter.colors_of(&mut packet)[..count]);
            packet.clear();
            if has_costs {
                costs.push(painter.row.counts.since(before));
            }
            if painter.memory.is_cut() {
                return None;
            }
        }
    }

    /// Returns a painter of row `j`.
    fn painter(&self, j: usize, is_shown: bool) -> Painter<'_> {
        let request = self.request;
        Painter {
            tracer: self,
            request,
            memory: self.memory(),
            is_shown,
            shown: request.columns(),
            center_weight: request.filter.weight(DVec2::ZERO),
            sum: Sum::default(),
            plots: plots(request, is_shown),
            c_rand: request.sampler.c_rand([request.traced_columns().start, j], request.size[0]),
            plan: None,
            row: self.empty_row(j),
        }
    }

    /// Returns an empty row `j`.
    fn empty_row(&self, j: usize) -> Row {
        let request = self.request;
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
    tracer: &'a PictureTracer<'a>,
    request: &'a Request,
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
        let Request { sampler, .. } = *self.request;
        for (k, zoom) in self.plots.clone() {
            self.plot_background(k, zoom, columns.clone());
        }
        let colors = self.request.traces_colors(self.request.tracing);
        if self.is_shown && self.request.measures() || colors && sampler.is_center() {
            self.paint_centers(columns.clone(), packet);
        }
        if colors && !sampler.is_center() {
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
        for (layer, colors) in self.request.layers.iter().zip(&mut self.row.layers) {
            if let Layer::Cost(kind) = layer {
                colors.push(Color::splat(kind.of(&cost) as f64));
            }
        }
    }

    /// Measures the centres of pixels, and colours them if the samples are at the centres.
    fn paint_centers(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let measures = self.is_shown && self.request.measures();
        let colors = self.request.sampler.is_center() && self.request.traces_colors(self.request.tracing);
        let casts = colors && matches!(self.tracer.view, View::Scene);
        let wanted =
            Wanted { hits: measures || casts, surfaces: self.request.has_normals() || casts, colors };
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
        let [_, height] = self.request.size;
        (column * height + self.row.j) as u64
    }

    /// Traces the samples of the pixels in these columns.
    fn take_samples(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Request { sampler, size: [_, height], .. } = *self.request;
        let first = self.index(columns.start);
        if let Some(plan) = self.plan {
            let draws = MultiJittered::draws(plan.most);
            let (mut rng, jump) = (sampler.rng().jumped(first * draws), Jump::of(height as u64 * draws));
            self.take(columns, packet, |column| {
                let offsets = MultiJittered::new(plan.strata(column), rng);
                rng = rng.after(jump);
                offsets
            });
        } else if let Some(mut c_rand) = self.c_rand.take() {
            self.take(columns, packet, |_| std::iter::once(c_rand.next_offset()));
            self.c_rand = Some(c_rand);
        } else {
            let mut pixels = sampler.pixels(first, height as u64);
            self.take(columns, packet, |_| pixels.next_offsets());
        }
    }

    /// Traces the samples at these offsets from the centres of the pixels in these columns, packet by packet.
    #[inline(always)]
    fn take<Offsets: ExactSizeIterator<Item = DVec2>>(
        &mut self,
        columns: Range<usize>,
        packet: &mut SamplePacket,
        mut offsets_of: impl FnMut(usize) -> Offsets,
    ) {
        for column in columns {
            let mut offsets = offsets_of(column);
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
        let is_scene = matches!(self.tracer.view, View::Scene);
        Wanted { hits: is_scene, surfaces: is_scene, colors: true }
    }

    /// Traces the samples of a packet, and stores their colours if they are wanted.
    fn trace(&mut self, wanted: Wanted, packet: &mut SamplePacket, colors: &mut PacketColors) {
        let of_tracer = Wanted { colors: wanted.colors && matches!(self.tracer.view, View::Scene), ..wanted };
        let (memory, counts) = (&mut self.memory, &mut self.row.counts);
        self.tracer.trace(self.row.j, of_tracer, packet, colors, memory, counts);
        let PictureTracer { view, request, .. } = *self.tracer;
        match view {
            View::Scene => {}
            View::Cells(occupancy) => {
                let world = self.tracer.caster.world;
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
            Colors::Finished(_) => sum.add(self.request.filter.weight(offset), color),
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
