//! Traces the samples of a picture, either counted or as fast as possible.

use super::request::{Request, Tracing, View};
use crate::camera::Camera;
use crate::caster::Caster;
#[cfg(feature = "fast")]
use crate::caster::choose::Rays;
#[cfg(feature = "fast")]
use crate::fast::{Demand, Footprint, RasterHints};
use crate::sampling::sample_packet::{PacketColors, SamplePacket, Wanted};
use crate::stats::Counts;
#[cfg(not(feature = "fast"))]
use crate::trace::NoHints;
#[cfg(feature = "fast")]
use crate::trace::Shadows;
use crate::trace::{IsOver, Memory, RayCount, Tracer};
use fearless_simd::dispatch;
use std::ops::Range;

/// Traces the samples of a picture.
#[derive(Clone)]
pub struct PictureTracer<'a> {
    pub camera: &'a Camera,
    pub caster: Caster<'a>,
    pub view: View<'a>,
    pub request: &'a Request,
    is_over: IsOver<'a>,
    #[cfg(feature = "fast")]
    hints: RasterHints,
    #[cfg(not(feature = "fast"))]
    hints: NoHints,
}

impl<'a> PictureTracer<'a> {
    pub fn new(
        camera: &'a Camera,
        caster: &'a Caster<'a>,
        view: View<'a>,
        request: &'a Request,
        is_over: IsOver<'a>,
    ) -> Self {
        #[cfg(feature = "fast")]
        let hints = RasterHints::new(caster.world, demand(view, request));
        #[cfg(not(feature = "fast"))]
        let hints = NoHints;
        Self { camera, caster: caster.clone(), view, request, is_over, hints }
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

    /// Returns the memory for a row.
    pub fn memory(&self) -> Memory<'a> {
        Memory::until(self.is_over, self.caster.world.lights.len())
    }

    /// Traces the samples of a packet in row `j`, and stores their colours if they are wanted. Does not count the
    /// camera rays. Does nothing once `is_over` has returned true.
    pub fn trace(
        &self,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
        memory: &mut Memory,
        counts: &mut Counts,
    ) {
        let Self { camera, caster, request: Request { effects, tracing, .. }, .. } = self;
        if memory.is_cut() {
            return;
        }
        let level = caster.level;
        match tracing {
            Tracing::Counted => {
                let tracer = Tracer::new(caster, *effects);
                dispatch!(level, simd => tracer.trace(simd, camera, j, wanted, packet, colors, memory, counts));
            }
            Tracing::Fast => {
                let tracer = Tracer::with_hints(caster, *effects, &self.hints);
                let rays = &mut RayCount::default();
                dispatch!(level, simd => tracer.trace(simd, camera, j, wanted, packet, colors, memory, rays));
                counts.non_shadow_rays += rays.0;
            }
        }
        memory.spend(packet.samples().len());
    }
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
        footprint: (request.measures() || colors).then_some(footprint),
        enters_objects: request.effects.bounces > 0,
        shadow_rays: if is_blocked_or_not { samples } else { 0 },
    }
}

#[cfg(all(test, feature = "fast"))]
mod tests {
    use super::*;
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
        let occupancy = Occupancy::new(&scene, &[], world.bounds, [1; 3]).unwrap();
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
                let is_over: IsOver = &|_| false;
                let tracer = PictureTracer::new(&camera, &caster, View::Scene, &request, is_over);
                tracer.rows(0..40).caster.is_selective()
            };
            assert_eq!(has_grid(Caster::new(&world, None).unwrap().replaceable()), is_selective, "{far}");
            assert!(!has_grid(Caster::new(&world, None).unwrap()));
        }
    }
}
