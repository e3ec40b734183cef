//! A row of pixels: its samples traced, and what they leave for the pictures.

use super::request::{Request, View};
use crate::camera::Camera;
use crate::caster::Caster;
use crate::grid::visualize::Face;
use crate::math::ray::{Hit, Ray};
use crate::picture::quantize;
use crate::projection::Projection;
use crate::sampling::film::{Spread, Sum};
use crate::scene::Color;
use crate::shading::light::incident;
use crate::stats::Probe;
use crate::trace::{Pending, Tracer};
use crate::world::World;
use glam::{DVec2, DVec3};

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

    /// Traces row `j`. `projection` says what its centres see, as far as it is known.
    pub fn traced(
        camera: &Camera,
        caster: &Caster,
        request: &Request,
        projection: Option<&Projection>,
        j: usize,
    ) -> Self {
        let [width, height] = request.size;
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
        let mut painter = Painter { camera, caster, request, projection, pending: Pending::default(), row };
        for i in 0..width {
            painter.paint(i, (i * height + j) as u64);
        }
        painter.row
    }
}

/// Paints the pixels of one row.
struct Painter<'a, P> {
    camera: &'a Camera,
    caster: &'a Caster<'a>,
    request: &'a Request<'a>,
    projection: Option<&'a Projection>,
    pending: Pending,
    row: Row<P>,
}

impl<P: Probe> Painter<'_, P> {
    /// Paints the pixel in column `i`, the one of this number in the sampler's order.
    fn paint(&mut self, i: usize, number: u64) {
        let Request { sampler, color, depth, normals, samples, .. } = *self.request;
        let wants_hit = depth.is_some() || normals;
        // Counters alone also want the colours traced.
        let wants_color = color || samples.is_some() || P::COUNTS;
        let pixel = DVec2::new(i as f64, self.row.j as f64);
        let mut center = None;
        if wants_hit {
            let ray = self.camera.ray(pixel, DVec2::ZERO);
            let hit = self.projected(&ray, i).unwrap_or_else(|| self.nearest(&ray));
            self.measure(&ray, hit);
            center = Some(hit);
        }
        if let Some(zoom) = samples {
            self.plot_background(i, zoom);
        }
        if !wants_color {
            return;
        }
        let mut sum = Sum::default();
        if sampler.is_center() {
            let ray = self.camera.ray(pixel, DVec2::ZERO);
            let hit = center.or_else(|| self.projected(&ray, i));
            self.sample(pixel, DVec2::ZERO, &ray, hit, &mut sum);
        } else {
            for offset in sampler.offsets(number) {
                self.sample(pixel, offset, &self.camera.ray(pixel, offset), None, &mut sum);
            }
        }
        if let Colors::Finished(bytes) = &mut self.row.colors {
            bytes.extend_from_slice(&quantize(sum.color(), &mut self.row.nans));
        }
    }

    /// What the ray through the centre of the pixel in column `i` hits, if that is known without casting it.
    fn projected(&self, ray: &Ray, i: usize) -> Option<Option<Hit>> {
        self.projection?.hit(self.caster.world, ray, i, self.row.j)
    }

    fn nearest(&mut self, ray: &Ray) -> Option<Hit> {
        self.caster.nearest(ray, None, &mut self.row.probe)
    }

    /// Traces one sample of a pixel along a ray; `hit` is what that hits, if it is known. `sum` is the pixel's
    /// own.
    #[inline(always)]
    fn sample(&mut self, pixel: DVec2, offset: DVec2, ray: &Ray, hit: Option<Option<Hit>>, sum: &mut Sum) {
        self.row.probe.non_shadow_ray();
        let color = self.color(ray, hit);
        match &mut self.row.colors {
            Colors::Unwanted => {}
            Colors::Finished(_) => sum.add(self.request.filter.weight(offset), color),
            Colors::Spread(spread) => spread.add(pixel.x as usize, offset, color),
        }
        if let Some(zoom) = self.request.samples {
            self.plot(pixel.x as usize, offset, color, zoom);
        }
    }

    /// Enters the depth and the normal of a pixel's centre.
    fn measure(&mut self, ray: &Ray, hit: Option<Hit>) {
        if let Some([near, far]) = self.request.depth {
            let t = hit.map(|h| self.caster.world.exact(ray, h).t);
            let grey = t.map_or(0.0, |t| (far - t.clamp(near, far)) / (far - near));
            let bytes = quantize(Color::splat(grey), &mut self.row.nans);
            self.row.depths.extend_from_slice(&bytes);
        }
        if self.request.normals {
            let normal = hit.map_or(DVec3::ZERO, |h| self.caster.world.surface(ray, h).normal);
            let bytes = quantize(normal.abs(), &mut self.row.nans);
            self.row.normals.extend_from_slice(&bytes);
        }
    }

    /// The colour along a ray; `hit` is what it hits, if that is known.
    fn color(&mut self, ray: &Ray, hit: Option<Option<Hit>>) -> Color {
        let caster = self.caster;
        match self.request.view {
            View::Scene(effects) => {
                let hit = hit.unwrap_or_else(|| self.nearest(ray));
                Tracer { caster, effects }.color(ray, hit, &mut self.pending, &mut self.row.probe)
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
