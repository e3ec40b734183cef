//! A row of pixels: its samples traced, and what they leave for the pictures.

use super::request::{Request, View};
use super::sample_packet::{Sample, SamplePacket};
use crate::camera::Camera;
use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::picture::quantize;
use crate::raster::VisibilityBuffer;
use crate::render::grid_view::Face;
use crate::sampling::film::{Spread, Sum};
use crate::scene::Color;
use crate::shading::light::incident;
use crate::stats::Probe;
use crate::trace::{Pending, Tracer};
use crate::world::{SurfacePoint, World};
use glam::{DVec2, DVec3};
use std::ops::Range;

/// What a row of pixels leaves; a list is empty where its picture is not wanted.
pub struct Row<P> {
    /// Counted from the bottom.
    pub j: usize,
    pub probe: P,
    pub colors: Colors,
    /// Bytes of the pictures of depths and of normals.
    pub depths: Vec<u8>,
    pub normals: Vec<u8>,
    /// Rows of the picture of samples, from the bottom.
    pub samples: Vec<Vec<Color>>,
    /// Colours in the bytes that were not numbers.
    pub nans: u64,
}

/// What a row's samples add to the colour picture.
pub enum Colors {
    Unwanted,
    /// Bytes of the row itself, where no sample counts for another pixel.
    Finished(Vec<u8>),
    /// Sums for the rows around.
    Spread(Spread),
}

impl Colors {
    fn new(request: &Request, j: usize) -> Self {
        match (request.color, request.filter.support()) {
            (false, _) => Self::Unwanted,
            (true, 0) => Self::Finished(Vec::with_capacity(3 * request.size[0])),
            (true, _) => Self::Spread(Spread::new(request.filter, j, request.size)),
        }
    }
}

impl<P: Probe> Row<P> {
    /// Bytes that a row takes, about.
    pub fn bytes(request: &Request) -> usize {
        let spread = match request.filter.support() {
            0 => 0,
            _ => Spread::bytes(request.filter, request.size),
        };
        spread + request.size[0] * 32
    }

    /// Traces row `j`. `visibility` says what its centres see, as far as it is known.
    pub fn traced(
        camera: &Camera,
        caster: &Caster,
        request: &Request,
        visibility: Option<&VisibilityBuffer>,
        j: usize,
    ) -> Self {
        let [width, _] = request.size;
        let zoom = request.samples.unwrap_or(0);
        let row = Self {
            j,
            probe: P::default(),
            colors: Colors::new(request, j),
            depths: vec![],
            normals: vec![],
            samples: vec![Vec::with_capacity(width * zoom); zoom],
            nans: 0,
        };
        let mut painter = Painter {
            camera,
            caster,
            request,
            visibility,
            pending: Pending::default(),
            center_weight: request.filter.weight(DVec2::ZERO),
            sum: Sum::default(),
            row,
        };
        let mut batch = SamplePacket::default();
        for first in (0..width).step_by(SamplePacket::SIZE) {
            painter.paint(first..width.min(first + SamplePacket::SIZE), &mut batch);
        }
        painter.row
    }
}

/// Paints the pixels of one row.
struct Painter<'a, P> {
    camera: &'a Camera,
    caster: &'a Caster<'a>,
    request: &'a Request<'a>,
    visibility: Option<&'a VisibilityBuffer>,
    pending: Pending,
    /// The filter's weight of a sample at the pixel's centre.
    center_weight: f64,
    /// Of the current pixel's samples so far.
    sum: Sum,
    row: Row<P>,
}

impl<P: Probe> Painter<'_, P> {
    /// Paints the pixels in these columns, of which there are not more than a batch holds.
    fn paint(&mut self, columns: Range<usize>, batch: &mut SamplePacket) {
        let Request { sampler, samples, .. } = *self.request;
        if let Some(zoom) = samples {
            columns.clone().for_each(|i| self.plot_background(i, zoom));
        }
        let colors = self.request.traces_colors::<P>();
        if self.request.measures() || colors && sampler.is_center() {
            self.paint_centers(columns.clone(), batch);
        }
        if colors && !sampler.is_center() {
            columns.for_each(|column| self.take_samples(column, batch));
            self.color_samples(batch);
        }
    }

    /// Measures the centres of pixels, and colours them if they are what is sampled.
    fn paint_centers(&mut self, columns: Range<usize>, batch: &mut SamplePacket) {
        let (measures, casts) = (self.request.measures(), self.request.casts_centers::<P>());
        let j = self.row.j;
        batch.take(self.camera, columns, j);
        if measures || casts {
            batch.find_hits(self.caster, self.visibility, j, &mut self.row.probe);
        }
        if self.request.normals || casts {
            batch.find_surfaces(self.caster);
        }
        if measures {
            batch.samples().iter().for_each(|center| self.measure(center));
        }
        if self.request.traces_colors::<P>() && self.request.sampler.is_center() {
            self.color::<true>(batch);
        }
        batch.clear();
    }

    /// Adds the samples of a pixel to a batch, and colours it whenever it is full.
    fn take_samples(&mut self, column: usize, batch: &mut SamplePacket) {
        let Request { sampler, size: [_, height], .. } = *self.request;
        let j = self.row.j;
        let offsets = sampler.offsets((column * height + j) as u64);
        for (offset, number) in offsets.zip(1..) {
            batch.push(self.camera, [column, j], offset, number == sampler.count());
            if batch.samples().len() == SamplePacket::SIZE {
                self.color_samples(batch);
            }
        }
    }

    /// Traces a batch of samples that have not been cast, and empties it.
    fn color_samples(&mut self, batch: &mut SamplePacket) {
        if matches!(self.request.view, View::Scene(_)) {
            batch.find_hits(self.caster, None, self.row.j, &mut self.row.probe);
            batch.find_surfaces(self.caster);
        }
        self.color::<false>(batch);
        batch.clear();
    }

    /// Traces on from what is seen at some samples.
    #[inline(always)]
    fn color<const CENTERS: bool>(&mut self, batch: &SamplePacket) {
        let mut sum = self.sum;
        for Sample { column, offset, is_last, ray, surface, .. } in batch.samples() {
            let color = self.color_along(ray, surface.as_ref());
            self.enter::<CENTERS>(*column, *offset, color, &mut sum);
            if CENTERS || *is_last {
                self.finish(&sum);
                sum = Sum::default();
            }
        }
        self.sum = sum;
    }

    /// Enters a sample of a pixel, whose sum this is.
    #[inline(always)]
    fn enter<const CENTERS: bool>(&mut self, column: usize, offset: DVec2, color: Color, sum: &mut Sum) {
        self.row.probe.non_shadow_ray();
        match &mut self.row.colors {
            Colors::Unwanted => {}
            Colors::Finished(_) if CENTERS => sum.add(self.center_weight, color),
            Colors::Finished(_) => sum.add(self.request.filter.weight(offset), color),
            Colors::Spread(spread) => spread.add(column, offset, color),
        }
        if let Some(zoom) = self.request.samples {
            self.plot(column, offset, color, zoom);
        }
    }

    /// Finishes a pixel for which no other row's samples count.
    fn finish(&mut self, sum: &Sum) {
        if let Colors::Finished(bytes) = &mut self.row.colors {
            bytes.extend_from_slice(&quantize(sum.color(), &mut self.row.nans));
        }
    }

    /// Enters the depth and the normal of a pixel's centre.
    fn measure(&mut self, center: &Sample) {
        if let Some([near, far]) = self.request.depth {
            let t = center.hit.map(|hit| self.caster.world.exact(&center.ray, hit).t);
            let grey = t.map_or(0.0, |t| (far - t.clamp(near, far)) / (far - near));
            let bytes = quantize(Color::splat(grey), &mut self.row.nans);
            self.row.depths.extend_from_slice(&bytes);
        }
        if self.request.normals {
            let normal = center.surface.map_or(DVec3::ZERO, |surface| surface.normal);
            let bytes = quantize(normal.abs(), &mut self.row.nans);
            self.row.normals.extend_from_slice(&bytes);
        }
    }

    /// The colour along a ray that hits this surface.
    #[inline(always)]
    fn color_along(&mut self, ray: &Ray, surface: Option<&SurfacePoint>) -> Color {
        let caster = self.caster;
        match self.request.view {
            View::Scene(effects) => {
                Tracer { caster, effects }.color(ray, surface, &mut self.pending, &mut self.row.probe)
            }
            View::Cells(occupancy) => {
                let face = occupancy.first_face(ray);
                face.map_or(caster.world.background, |face| cell_color(&face, ray, caster.world))
            }
        }
    }

    /// The chequered ground on which a pixel's samples are plotted.
    fn plot_background(&mut self, i: usize, zoom: usize) {
        let grey = if (i + self.row.j).is_multiple_of(2) { 0.2 } else { 0.0 };
        for row in &mut self.row.samples {
            row.extend(std::iter::repeat_n(Color::splat(grey), zoom));
        }
    }

    /// Plots a sample where it falls in its enlarged pixel.
    fn plot(&mut self, i: usize, offset: DVec2, color: Color, zoom: usize) {
        let place = |base: usize, offset: f64| {
            let at = ((base as f64 + 0.5 + offset) * zoom as f64) as usize;
            at.clamp(base * zoom, base * zoom + zoom - 1)
        };
        let (x, y) = (place(i, offset.x), place(self.row.j, offset.y) - self.row.j * zoom);
        self.row.samples[y][x] = color;
    }
}

/// A cell's face under the scene's lights: ambient and diffuse, no shadows.
fn cell_color(face: &Face, ray: &Ray, world: &World) -> Color {
    let point = ray.at(face.t);
    let lights = world.lights.iter().map(|light| {
        let light = incident(light, point);
        light.color * face.normal.dot(light.direction).max(0.0)
    });
    face.color * (world.ambient + lights.sum::<Color>())
}
