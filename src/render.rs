//! Pixels in parallel, row by row.

use crate::camera::Camera;
use crate::grid::visualize::{Face, Occupancy};
use crate::math::ray::{Hit, Ray};
use crate::scene::Color;
use crate::shading::light::incident;
use crate::stats::Probe;
use crate::trace::{Pending, Tracer};
use crate::world::World;
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// What the colour picture shows.
#[derive(Debug)]
pub enum View<'a> {
    Scene(Tracer<'a>),
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy, &'a World),
}

/// Which pictures are wanted besides the counters.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted {
    pub color: bool,
    pub depth: bool,
    pub normals: bool,
}

/// One row of pixels from the left; a list is empty where its picture is not wanted.
#[derive(Clone, Debug, Default)]
pub struct Row {
    pub colors: Vec<Color>,
    /// Distances in units of the ray's direction, infinite where nothing is hit.
    pub depths: Vec<f64>,
    /// Outward unit normals, zero where nothing is hit.
    pub normals: Vec<DVec3>,
}

/// Renders all rows, from the top of the picture down, and hands back what was counted.
pub fn render<P: Probe>(
    camera: &Camera,
    tracer: &Tracer,
    view: &View,
    wanted: Wanted,
    [width, height]: [usize; 2],
) -> (Vec<Row>, P) {
    let (rows, probes): (Vec<Row>, Vec<P>) = (0..height)
        .into_par_iter()
        .map(|y| {
            let mut painter =
                Painter { tracer, view, wanted, pending: Pending::default(), probe: P::default() };
            let mut row = Row::default();
            for x in 0..width {
                let center = DVec2::new(x as f64 + 0.5, (height - 1 - y) as f64 + 0.5);
                painter.paint(&camera.ray(center), &mut row);
            }
            (row, painter.probe)
        })
        .unzip();
    (rows, probes.into_iter().fold(P::default(), P::merge))
}

/// Paints the pixels of one thread.
struct Painter<'a, P> {
    tracer: &'a Tracer<'a>,
    view: &'a View<'a>,
    wanted: Wanted,
    pending: Pending,
    probe: P,
}

impl<P: Probe> Painter<'_, P> {
    fn paint(&mut self, ray: &Ray, row: &mut Row) {
        let shows_scene = matches!(self.view, View::Scene(_));
        let needs_hit = self.wanted.depth || self.wanted.normals || shows_scene;
        let hit = if needs_hit { self.tracer.caster.closest(ray, &mut self.probe) } else { None };
        self.probe.non_shadow_ray();
        if self.wanted.color {
            row.colors.push(self.color(ray, hit));
        }
        if self.wanted.depth {
            row.depths.push(hit.map_or(f64::INFINITY, |h| h.t));
        }
        if self.wanted.normals {
            row.normals.push(hit.map_or(DVec3::ZERO, |h| self.tracer.caster.world.surface(ray, h).normal));
        }
    }

    fn color(&mut self, ray: &Ray, hit: Option<Hit>) -> Color {
        match self.view {
            View::Scene(tracer) => tracer.color(ray, hit, &mut self.pending, &mut self.probe),
            View::Cells(occupancy, world) => {
                occupancy.first_face(ray).map_or(world.background, |face| cell_color(&face, ray, world))
            }
        }
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
