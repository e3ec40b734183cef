//! Traces the samples of a picture, either counted or as fast as possible.

use super::Stopped;
use super::request::{Request, Tracing, View};
use super::tally::Tally;
use crate::camera::Camera;
use crate::caster::{Caster, LazyCaster, NotBuilt};
#[cfg(feature = "fast")]
use crate::fast::{Demand, Footprint, RasterHints};
use crate::picture::Color;
use crate::sampling::sample_packet::{SamplePacket, Stage};
use crate::scene::material::Material;
use crate::stats::Counts;
#[cfg(not(feature = "fast"))]
use crate::trace::NoHints;
use crate::trace::{Effects, RayCount, RayStack, Shadows, Tracer};
use fearless_simd::dispatch;
use std::ops::Range;

/// A scene from one camera, ready to be rendered.
#[derive(Debug)]
pub struct Shot<'a> {
    /// The camera.
    pub camera: Camera,
    /// Casts the rays.
    pub caster: &'a LazyCaster<'a>,
    /// The subject of the layers of colours.
    pub view: View<'a>,
}

impl<'a> Shot<'a> {
    /// Returns the caster with its structure, which is built unless the render is cancelled.
    pub(super) fn built(&'a self, tally: &'a Tally) -> Result<Caster<'a>, Stopped> {
        self.caster.built(tally).map_err(|error| match error {
            NotBuilt::Ended => tally.reason(),
            NotBuilt::TooLarge => Stopped::Structure,
        })
    }
}

/// Traces the samples of a picture.
#[derive(Clone)]
pub struct PictureTracer<'a> {
    pub shot: &'a Shot<'a>,
    /// The caster of the scene, or one of the planes alone as long as no ray needs more.
    pub caster: Caster<'a>,
    pub request: &'a Request,
    pub tally: &'a Tally<'a>,
    #[cfg(feature = "fast")]
    hints: RasterHints,
    #[cfg(not(feature = "fast"))]
    hints: NoHints,
}

impl<'a> PictureTracer<'a> {
    pub fn new(shot: &'a Shot<'a>, request: &'a Request, tally: &'a Tally<'a>) -> Self {
        let caster = shot.caster.so_far(tally);
        #[cfg(feature = "fast")]
        let hints = RasterHints::new(caster.world, demand(&shot.view, request), tally);
        #[cfg(not(feature = "fast"))]
        let hints = NoHints;
        Self { shot, caster, request, tally, hints }
    }

    /// Returns a tracer for these rows, counted from the bottom. It has their first hits, as far as rasterization finds
    /// them. It has a structure if other rays are cast, or if some first hits are unknown.
    pub fn for_rows(&self, rows: Range<usize>) -> Result<Self, Stopped> {
        let mut own = self.clone();
        if self.casts_further_rays() {
            own.caster = self.shot.built(self.tally)?;
        }
        #[cfg(feature = "fast")]
        if self.request.tracing == Tracing::Fast {
            own.hints = self.hints.in_rows(&self.shot.camera, &own.caster, rows);
            if own.hints.are_incomplete() {
                own.caster = self.shot.built(self.tally)?;
            }
        }
        #[cfg(not(feature = "fast"))]
        let _ = rows;
        Ok(own)
    }

    /// Returns true if other rays are cast than those that rasterization may replace.
    fn casts_further_rays(&self) -> bool {
        let Request { effects: Effects { shadows, bounces, .. }, tracing, .. } = *self.request;
        let world = self.caster.world;
        let casts_from_surfaces = shadows != Shadows::None && !world.lights.is_empty()
            || bounces > 0 && world.materials.iter().any(Material::has_secondary_rays);
        let has_colors = self.request.traces_colors(tracing) && matches!(self.shot.view, View::Scene);
        let has_hints = cfg!(feature = "fast") && tracing == Tracing::Fast;
        (has_colors && casts_from_surfaces)
            || !has_hints && (has_colors || self.request.measured() > Stage::Rays)
    }

    /// Traces the samples of a packet in row `j` up to a stage, and computes their colours if they are wanted. Does not
    /// count the camera rays. Does nothing once rays were left out.
    #[allow(clippy::too_many_arguments, reason = "an inner loop")]
    pub fn trace(
        &self,
        j: usize,
        measured: Stage,
        has_colors: bool,
        packet: &mut SamplePacket,
        stack: &mut RayStack,
        counts: &mut Counts,
    ) {
        let Self { shot: Shot { camera, view, .. }, caster, request, .. } = self;
        let Request { effects, tracing, size, .. } = request;
        if stack.is_cut() {
            return;
        }
        let stage = if has_colors && matches!(view, View::Scene) { Stage::Colors } else { measured };
        let level = caster.level;
        match tracing {
            Tracing::Counted => {
                let tracer = Tracer::new(caster, *effects);
                dispatch!(level, simd => tracer.trace(simd, camera, j, stage, packet, stack, counts));
            }
            Tracing::Fast => {
                let tracer = Tracer::with_hints(caster, *effects, &self.hints);
                let rays = &mut RayCount::default();
                dispatch!(level, simd => tracer.trace(simd, camera, j, stage, packet, stack, rays));
                // The total of all kinds.
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
        stack.spend(packet.samples().len() as u32);
    }
}

/// Returns the colour that shows a pixel's place: its column and its row from the bottom.
fn place_color([column, row]: [usize; 2], [width, height]: [usize; 2]) -> Color {
    Color::new(column as f64 / width as f64, (height - 1 - row) as f64 / height as f64, 1.0)
}

/// Returns the rays that a request needs if it does not count.
#[cfg(feature = "fast")]
fn demand(view: &View, request: &Request) -> Demand {
    let is_scene = matches!(view, View::Scene);
    let colors = request.tracing == Tracing::Fast && request.traces_colors(Tracing::Fast) && is_scene;
    let footprint = if colors && !request.sampler.is_center() { Footprint::Pixel } else { Footprint::Center };
    let samples = request.window_size().iter().product::<usize>() * request.samples();
    let is_blocked_or_not = colors && request.effects.shadows == Shadows::Opaque;
    Demand {
        size: request.size,
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
            let demand = demand(&view, &request);
            assert_eq!((demand.footprint, demand.shadow_rays), (footprint, colors), "{request:?}");
        }
    }
}
