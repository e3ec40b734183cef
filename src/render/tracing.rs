//! Who traces the rays of a picture: the tracer itself, which is counted, or its fast twin.

use super::request::{Request, View};
use crate::camera::Camera;
use crate::caster::Caster;
#[cfg(feature = "fast")]
use crate::fast::{Demand, FastRow, FastRows, FastTracer, Footprint};
use crate::sampling::sample_packet::{PacketColors, SamplePacket, Wanted};
use crate::stats::Counts;
use crate::trace::{ByModel, Effects, Observer, Patience, Rules, Tracer};
use glam::DVec2;
use serde::Serialize;
use std::ops::Range;

/// How a picture is traced. It is the same picture either way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tracing {
    /// As soon as possible: only what the picture needs is traced, and only rays are counted. They are not told apart.
    #[default]
    Fast,
    /// As by the course's program, whose steps are counted.
    Counted,
}

/// Traces the rays of a picture.
pub enum PictureTracer<'a> {
    Plain(PlainTracer<'a>),
    #[cfg(feature = "fast")]
    Fast(FastTracer<'a>),
}

/// Traces the rays of some rows.
pub enum RowsTracer<'a> {
    Plain(PlainTracer<'a>),
    #[cfg(feature = "fast")]
    Fast(FastRows<'a>),
}

/// Traces the rays of one row.
pub enum RowTracer<'a> {
    Plain(PlainTracer<'a>),
    #[cfg(feature = "fast")]
    Fast(FastRow<'a>),
}

/// Traces rays one by one.
#[derive(Clone, Copy)]
pub struct PlainTracer<'a> {
    camera: &'a Camera,
    caster: &'a Caster<'a>,
    effects: Effects,
    patience: Patience<'a>,
}

impl<'a> PictureTracer<'a> {
    pub fn new(
        camera: &'a Camera,
        caster: &'a Caster<'a>,
        view: View,
        request: &Request,
        tracing: Tracing,
        patience: Patience<'a>,
    ) -> Self {
        match tracing {
            #[cfg(feature = "fast")]
            Tracing::Fast => Self::Fast(FastTracer::new(camera, caster, demand(view, request), patience)),
            _ => {
                let _ = view;
                Self::Plain(PlainTracer { camera, caster, effects: request.effects, patience })
            }
        }
    }

    /// For these rows, counted from the bottom.
    pub fn rows(&self, rows: Range<usize>) -> RowsTracer<'_> {
        match self {
            Self::Plain(plain) => {
                let _ = rows;
                RowsTracer::Plain(*plain)
            }
            #[cfg(feature = "fast")]
            Self::Fast(fast) => RowsTracer::Fast(fast.rows(rows)),
        }
    }
}

impl RowsTracer<'_> {
    pub fn row(&self) -> RowTracer<'_> {
        match self {
            Self::Plain(plain) => RowTracer::Plain(*plain),
            #[cfg(feature = "fast")]
            Self::Fast(fast) => RowTracer::Fast(fast.row()),
        }
    }
}

impl<'a> RowTracer<'a> {
    /// Whether rays of the row were left out, since the render was cancelled.
    pub fn is_cut(&mut self) -> bool {
        self.patience().has_ended
    }

    fn patience(&mut self) -> &mut Patience<'a> {
        match self {
            Self::Plain(plain) => &mut plain.patience,
            #[cfg(feature = "fast")]
            Self::Fast(fast) => fast.patience(),
        }
    }

    /// Traces the samples of a packet, which lie in row `j`, and enters their colours, if they are wanted. The rays from
    /// the camera are not counted. Does nothing once the row is cut.
    pub fn trace(
        &mut self,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
        counts: &mut Counts,
    ) {
        if self.is_cut() {
            return;
        }
        match self {
            Self::Plain(plain) => plain.trace(j, wanted, packet, colors, counts),
            #[cfg(feature = "fast")]
            Self::Fast(fast) => counts.non_shadow_rays += fast.trace(j, wanted, packet, colors),
        }
        self.patience().spend(packet.samples().len());
    }
}

impl PlainTracer<'_> {
    fn trace<O: Observer>(
        &mut self,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
        observer: &mut O,
    ) {
        let Self { caster, effects, .. } = *self;
        if caster.world.is_of_course() {
            return self.trace_with(Tracer { rules: caster, effects }, j, wanted, packet, colors, observer);
        }
        let rules = &ByModel(caster);
        self.trace_with(Tracer { rules, effects }, j, wanted, packet, colors, observer);
    }

    fn trace_with<R: Rules, O: Observer>(
        &mut self,
        tracer: Tracer<R>,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
        observer: &mut O,
    ) {
        let camera = self.camera;
        let samples = packet.samples_mut();
        // Step by step, since the processor works on the same step of several samples at once.
        for sample in &mut *samples {
            sample.ray = camera.ray(DVec2::new(sample.source.column as f64, j as f64), sample.source.offset);
        }
        for sample in &mut *samples {
            sample.visible = wanted.hits.then(|| tracer.nearest(&sample.ray, None, observer)).flatten();
        }
        if wanted.surfaces {
            for sample in &mut *samples {
                sample.surface = sample.visible.map(|visible| tracer.rules.surface(&sample.ray, visible));
            }
        }
        if wanted.colors {
            let mut pending = vec![];
            for (sample, color) in samples.iter().zip(colors) {
                *color = tracer.color_with(
                    &mut pending,
                    &mut self.patience,
                    &sample.ray,
                    sample.surface,
                    observer,
                );
            }
        }
    }
}

/// The rays that a request asks for.
#[cfg(feature = "fast")]
fn demand(view: View, request: &Request) -> Demand {
    let colors = request.traces_colors(Tracing::Fast) && matches!(view, View::Scene);
    let footprint = if colors && !request.sampler.is_center() { Footprint::Pixel } else { Footprint::Center };
    let samples = request.window_size().iter().product::<usize>() * request.samples();
    Demand {
        size: request.size,
        columns: request.columns(),
        footprint: (request.measures() || colors).then_some(footprint),
        colors: if colors { samples } else { 0 },
        effects: request.effects,
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
            assert_eq!((demand.footprint, demand.colors), (footprint, colors), "{request:?}");
        }
    }
}
