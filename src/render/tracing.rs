//! Traces the samples of a picture, either counted or as fast as possible.

use super::request::{Request, Tracing, View};
use super::tally::Tally;
use crate::camera::Camera;
use crate::caster::Caster;
#[cfg(feature = "fast")]
use crate::caster::choose::Rays;
#[cfg(feature = "fast")]
use crate::fast::{Demand, Footprint, RasterHints};
use crate::picture::Color;
use crate::sampling::sample_packet::{SamplePacket, Stage};
use crate::stats::Counts;
#[cfg(not(feature = "fast"))]
use crate::trace::NoHints;
#[cfg(feature = "fast")]
use crate::trace::Shadows;
use crate::trace::{Memory, RayCount, Tracer};
use fearless_simd::dispatch;
use std::ops::Range;

/// Traces the samples of a picture.
#[derive(Clone)]
pub struct PictureTracer<'a> {
    pub camera: &'a Camera,
    pub caster: Caster<'a>,
    pub view: View<'a>,
    pub request: &'a Request,
    pub tally: &'a Tally<'a>,
    #[cfg(feature = "fast")]
    hints: RasterHints,
    #[cfg(not(feature = "fast"))]
    hints: NoHints,
}

impl<'a> PictureTracer<'a> {
    pub fn new(
        (camera, caster): (&'a Camera, &'a Caster<'a>),
        view: View<'a>,
        request: &'a Request,
        tally: &'a Tally<'a>,
    ) -> Self {
        #[cfg(feature = "fast")]
        let hints = RasterHints::new(caster.world, demand(view, request), tally);
        #[cfg(not(feature = "fast"))]
        let hints = NoHints;
        Self { camera, caster: caster.patient(tally), view, request, tally, hints }
    }

    /// Returns a tracer that is prepared for these rows, counted from the bottom.
    #[cfg(feature = "fast")]
    pub fn rows(&self, rows: Range<usize>) -> Self {
        if self.request.tracing == Tracing::Counted {
            return self.clone();
        }
        let hints = self.hints.in_rows(self.camera, &self.caster, rows.clone());
        // The other rows have about as many unsure pixels.
        let (camera, all_rows) = (self.request.camera_rays(), self.request.rows().len());
        let cast = hints.unsure(rows.clone()) * all_rows / rows.len().max(1);
        Self { caster: self.caster.for_rays(Rays { camera, cast }), hints, ..self.clone() }
    }

    #[cfg(not(feature = "fast"))]
    pub fn rows(&self, _: Range<usize>) -> Self {
        self.clone()
    }

    /// Traces the samples of a packet in row `j` up to a stage, and computes their colours if they are wanted. Does not
    /// count the camera rays. Does nothing once the memory is cut.
    pub fn trace(
        &self,
        j: usize,
        measured: Stage,
        has_colors: bool,
        packet: &mut SamplePacket,
        memory: &mut Memory,
        counts: &mut Counts,
    ) {
        let Self { camera, caster, view, request: Request { effects, tracing, size, .. }, .. } = self;
        if memory.is_cut() {
            return;
        }
        let stage = if has_colors && matches!(view, View::Scene) { Stage::Colors } else { measured };
        let level = caster.level;
        match tracing {
            Tracing::Counted => {
                let tracer = Tracer::new(caster, *effects);
                dispatch!(level, simd => tracer.trace(simd, camera, j, stage, packet, memory, counts));
            }
            Tracing::Fast => {
                let tracer = Tracer::with_hints(caster, *effects, &self.hints);
                let rays = &mut RayCount::default();
                dispatch!(level, simd => tracer.trace(simd, camera, j, stage, packet, memory, rays));
                counts.non_shadow_rays += rays.0;
            }
        }
        match view {
            View::Scene => {}
            View::Cells(cells) => {
                for (sample, color) in packet.colors_mut() {
                    *color = cells.color(&sample.ray, caster.world);
                }
            }
            View::Places => {
                for (sample, color) in packet.colors_mut() {
                    *color = place_color([sample.column, j], *size);
                }
            }
        }
        memory.spend(packet.samples().len() as u32);
    }
}

/// Returns the colour that shows a pixel's place: its column and its row from the bottom.
fn place_color([column, row]: [usize; 2], [width, height]: [usize; 2]) -> Color {
    Color::new(column as f64 / width as f64, (height - 1 - row) as f64 / height as f64, 1.0)
}

/// Returns the rays that a request needs if it does not count.
#[cfg(feature = "fast")]
fn demand(view: View, request: &Request) -> Demand {
    let is_scene = matches!(view, View::Scene);
    let colors = request.tracing == Tracing::Fast && request.traces_colors(Tracing::Fast) && is_scene;
    let footprint = if colors && !request.sampler.is_center() { Footprint::Pixel } else { Footprint::Center };
    let samples = request.window_size().iter().product::<usize>() * request.samples();
    let is_blocked_or_not = colors && request.effects.shadows == Shadows::Opaque;
    Demand {
        size: request.size,
        columns: request.columns(),
        footprint: (request.measured() > Stage::Rays || colors).then_some(footprint),
        enters_objects: request.effects.bounces > 0,
        shadow_rays: if is_blocked_or_not { samples } else { 0 },
    }
}

#[cfg(feature = "fast")]
#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::render::grid_view::Occupancy;
    use crate::render::{Layer, Request};
    use crate::sampling::drand48::Drand48;
    use crate::sampling::sampler::{Pattern, Sampler};
    use crate::scene::parser::parse;
    use crate::trace::{Effects, Shadows};
    use crate::world::World;

    #[test]
    fn camera_rays_are_asked_for_where_a_layer_needs_them() {
        let text =
            "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 40 } Group { numObjects 1
             Material { } Sphere { center 0 0 0 radius 1 } }";
        let scene = parse(text).unwrap();
        let world = World::new(&scene, &[]).unwrap();
        let occupancy = Occupancy::new(&scene, &[], world.bounds, [1; 3], &Endless).unwrap();
        let (center, aside) = (Sampler::CENTER, Sampler::new(Pattern::Uniform, 4, Drand48::UNSEEDED));
        let cells = View::Cells(&occupancy);
        let depth = Layer::Depth { near: 1.0, far: 2.0 };
        for (layers, sampler, view, footprint, colors) in [
            (vec![Layer::Color], center, View::Scene, Some(Footprint::Center), 30),
            (vec![Layer::Color], aside, View::Scene, Some(Footprint::Pixel), 120),
            (vec![Layer::Color], center, cells, None, 0),
            (vec![Layer::Color, depth], aside, View::Scene, Some(Footprint::Pixel), 120),
            (vec![Layer::Color, depth], center, cells, Some(Footprint::Center), 0),
            (vec![depth], center, View::Scene, Some(Footprint::Center), 0),
            (vec![Layer::Filter { zoom: 1 }], center, View::Scene, None, 0),
        ] {
            let effects = Effects { shadows: Shadows::Opaque, ..Effects::default() };
            let request = Request { sampler, effects, layers, ..Request::new([6, 5]) };
            let demand = demand(view, &request);
            assert_eq!((demand.footprint, demand.shadow_rays), (footprint, colors), "{request:?}");
        }
    }

    #[test]
    fn rays_that_rasterization_leaves_get_a_grid_if_they_are_many() {
        let triangle = |k: usize| {
            let [x, y] = [k % 8, k / 8].map(|n| 0.25 * n as f64 - 1.0);
            format!("Triangle {{ vertex0 {x} {y} 0 vertex1 {} {y} 0 vertex2 {x} {} 0 }} ", x + 0.25, y + 0.25)
        };
        let triangles: String = (0..64).map(triangle).collect();
        // A far vertex makes the error bounds of all depths large.
        for (far, is_selective) in [(1.0, false), (1e9, true)] {
            let text = format!(
                "PerspectiveCamera {{ center 0.013 0.029 5 direction 0 0 -1 up 0 1 0 angle 25 }}
                 Group {{ numObjects 65 Material {{ }} {triangles}
                 Triangle {{ vertex0 0 0 -1 vertex1 {far} 0 -1 vertex2 0 {far} -1 }} }}"
            );
            let scene = parse(&text).unwrap();
            let world = World::new(&scene, &[]).unwrap();
            let camera = Camera::new(&scene.camera, [40, 40]);
            let request = Request::new([40, 40]);
            let has_grid = |caster: Caster| {
                let tally = Tally::new(40, &|_| std::ops::ControlFlow::Continue(()));
                let tracer = PictureTracer::new((&camera, &caster), View::Scene, &request, &tally);
                tracer.rows(0..40).caster.is_selective()
            };
            assert_eq!(has_grid(Caster::new(&world, None).unwrap().replaceable()), is_selective, "{far}");
            assert!(!has_grid(Caster::new(&world, None).unwrap()));
        }
    }
}
