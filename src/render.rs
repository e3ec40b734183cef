//! Rows of pixels in parallel: samples -> film -> pictures.

use crate::camera::Camera;
use crate::caster::Caster;
use crate::grid::visualize::{Face, Occupancy};
use crate::math::ray::{Hit, Ray};
use crate::picture::{BadSize, Picture, quantize};
use crate::sampling::film::{Film, Spread};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::scene::Color;
use crate::shading::light::incident;
use crate::stats::Probe;
use crate::trace::{Effects, Pending, Tracer};
use crate::world::World;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// What the colour picture shows.
#[derive(Clone, Copy, Debug)]
pub enum View<'a> {
    Scene(Effects),
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy),
}

/// Which pictures are wanted, and how the colours are sampled.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Width and height in pixels.
    pub size: [usize; 2],
    pub view: View<'a>,
    pub sampler: Sampler,
    pub filter: Filter,
    /// The colour picture.
    pub color: bool,
    /// The depth picture, white and black at these distances.
    pub depth: Option<[f64; 2]>,
    pub normals: bool,
    /// The picture of the samples, each pixel enlarged so many times.
    pub samples: Option<usize>,
}

/// The pictures that were asked for.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    pub color: Option<Picture>,
    pub depth: Option<Picture>,
    pub normals: Option<Picture>,
    pub samples: Option<Picture>,
    /// Pixels whose colour is not a number; they are black.
    pub nans: u64,
}

/// How much memory rows on their way to the film may take, in bytes.
const ROWS_IN_FLIGHT: usize = 32 << 20;

/// Renders what is asked for, and hands back what was counted.
///
/// Rows are traced in parallel and collected in order, so that the bytes depend on no thread.
pub fn render<P: Probe>(
    camera: &Camera,
    caster: &Caster,
    request: &Request,
) -> Result<(Pictures, P), BadSize> {
    let [_, height] = request.size;
    let mut pictures = Pictures::new(request)?;
    let mut film = Film::new(request.filter, request.size);
    let mut probe = P::default();
    let bytes = Spread::bytes(request.filter, request.size) + request.size[0] * 32;
    // At least a row for each thread, and no more than there are.
    let batch = (ROWS_IN_FLIGHT / bytes).max(rayon::current_num_threads()).clamp(1, height.max(1));
    for first in (0..height).step_by(batch) {
        let rows: Vec<Row<P>> = (first..height.min(first + batch))
            .into_par_iter()
            .map(|j| Row::traced(camera, caster, request, j))
            .collect();
        for row in rows {
            probe = probe.merge(row.probe);
            pictures.take(row.j, &row.depths, &row.normals, &row.samples);
            if let Some(spread) = row.spread {
                film.add(spread, |j, colors| pictures.finish(j, colors));
            }
        }
    }
    Ok((pictures, probe))
}

impl Pictures {
    fn new(request: &Request) -> Result<Self, BadSize> {
        let [w, h] = request.size;
        let picture = |wanted: bool, zoom: usize| {
            let side = |n: usize| u32::try_from(n * zoom).unwrap_or(u32::MAX);
            wanted.then(|| Picture::new(side(w), side(h))).transpose()
        };
        Ok(Self {
            color: picture(request.color, 1)?,
            depth: picture(request.depth.is_some(), 1)?,
            normals: picture(request.normals, 1)?,
            samples: picture(request.samples.is_some(), request.samples.unwrap_or(1))?,
            nans: 0,
        })
    }

    /// Enters what row `j` shows beside its colours.
    fn take(&mut self, j: usize, depths: &[Color], normals: &[Color], samples: &[Vec<Color>]) {
        let Self { depth, normals: normal, samples: plot, nans, .. } = self;
        for (picture, row) in [(depth, depths), (normal, normals)] {
            if let Some(picture) = picture {
                write(picture.row_mut(j), row.iter().copied(), nans);
            }
        }
        if let Some(plot) = plot {
            for (k, row) in samples.iter().enumerate() {
                write(plot.row_mut(j * samples.len() + k), row.iter().copied(), nans);
            }
        }
    }

    /// Enters a row of finished colours.
    fn finish(&mut self, j: usize, colors: &mut dyn Iterator<Item = Color>) {
        if let Some(picture) = &mut self.color {
            write(picture.row_mut(j), colors, &mut self.nans);
        }
    }
}

fn write(bytes: &mut [u8], colors: impl Iterator<Item = Color>, nans: &mut u64) {
    for (pixel, color) in bytes.chunks_exact_mut(3).zip(colors) {
        pixel.copy_from_slice(&quantize(color, nans));
    }
}

/// What a row of pixels leaves; a list is empty where its picture is not wanted.
struct Row<P> {
    /// Counted from the bottom.
    j: usize,
    probe: P,
    spread: Option<Spread>,
    depths: Vec<Color>,
    normals: Vec<Color>,
    /// Rows of the picture of samples, from the bottom.
    samples: Vec<Vec<Color>>,
}

impl<P: Probe> Row<P> {
    fn traced(camera: &Camera, caster: &Caster, request: &Request, j: usize) -> Self {
        let [width, height] = request.size;
        let zoom = request.samples.unwrap_or(0);
        let row = Self {
            j,
            probe: P::default(),
            spread: request.color.then(|| Spread::new(request.filter, j, request.size)),
            depths: vec![],
            normals: vec![],
            samples: vec![Vec::with_capacity(width * zoom); zoom],
        };
        let mut painter = Painter { camera, caster, request, pending: Pending::default(), row };
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
            center = Some(self.caster.closest(&ray, &mut self.row.probe));
            self.measure(&ray, center.flatten());
        }
        if let Some(zoom) = samples {
            self.plot_background(i, zoom);
        }
        if !wants_color {
            return;
        }
        if sampler.is_center() {
            // The centre's hit may be known already.
            return self.sample(pixel, DVec2::ZERO, center);
        }
        for offset in sampler.offsets(number) {
            self.sample(pixel, offset, None);
        }
    }

    /// Traces one sample of a pixel; `hit` is what it hits, if that is known.
    fn sample(&mut self, pixel: DVec2, offset: DVec2, hit: Option<Option<Hit>>) {
        let ray = self.camera.ray(pixel, offset);
        self.row.probe.non_shadow_ray();
        let color = self.color(&ray, hit);
        if let Some(spread) = &mut self.row.spread {
            spread.add(pixel.x as usize, offset, color);
        }
        if let Some(zoom) = self.request.samples {
            self.plot(pixel.x as usize, offset, color, zoom);
        }
    }

    /// Enters the depth and the normal of a pixel's centre.
    fn measure(&mut self, ray: &Ray, hit: Option<Hit>) {
        if let Some([near, far]) = self.request.depth {
            let grey = hit.map_or(0.0, |h| (far - h.t.clamp(near, far)) / (far - near));
            self.row.depths.push(Color::splat(grey));
        }
        if self.request.normals {
            let normal = hit.map_or(DVec3::ZERO, |h| self.caster.world.surface(ray, h).normal);
            self.row.normals.push(normal.abs());
        }
    }

    /// The colour along a ray; `hit` is what it hits, if that is known.
    fn color(&mut self, ray: &Ray, hit: Option<Option<Hit>>) -> Color {
        let (caster, probe) = (self.caster, &mut self.row.probe);
        match self.request.view {
            View::Scene(effects) => {
                let hit = hit.unwrap_or_else(|| caster.closest(ray, probe));
                Tracer { caster, effects }.color(ray, hit, &mut self.pending, probe)
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

/// The picture of a filter: the weights around the middle pixel, each pixel enlarged `zoom` times.
///
/// As the course draws it, half the width finds the middle along both axes, what lies beyond the
/// filter's support stays dark blue, and blue lines separate the pixels.
pub fn render_filter(filter: Filter, [width, height]: [usize; 2], zoom: usize) -> Result<Picture, BadSize> {
    let side = |n: usize| u32::try_from(n * zoom + 1).unwrap_or(u32::MAX);
    let mut picture = Picture::new(side(width), side(height))?;
    let middle = width / 2;
    let reached = middle.saturating_sub(filter.support())..=middle + filter.support();
    // Relative to the middle pixel's centre.
    let place = |k: usize| k as f64 / zoom as f64 - (middle as f64 + 0.5);
    for y in 0..=height * zoom {
        let colors = (0..=width * zoom).map(|x| {
            if x.is_multiple_of(zoom) || y.is_multiple_of(zoom) {
                Color::Z
            } else if reached.contains(&(x / zoom)) && reached.contains(&(y / zoom)) {
                Color::splat(filter.weight(DVec2::new(place(x), place(y))))
            } else {
                0.5 * Color::Z
            }
        });
        write(picture.row_mut(y), colors, &mut 0);
    }
    Ok(picture)
}
