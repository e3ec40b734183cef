//! The fast twin of the tracer: it finds sooner what [`trace`](crate::trace) finds, and never anything else. A build
//! without it, by `--no-default-features`, makes the same bytes.
//!
//! The first hits of camera rays are found by rasterization where that is certain; so is what stands between a surface
//! and a light. Surfaces are computed four at a time. It serves one tracer only, and counts nothing but rays.
//!
//! Its one door is [`FastTracer`].

mod raster;
mod row;
mod shading;
mod surfaces;
mod triangle4;
#[cfg(test)]
mod tests;

use crate::camera::Camera;
use crate::caster::Caster;
use crate::sampling::sample_packet::{PacketColors, SamplePacket, Wanted};
use crate::trace::{ByModel, Effects, Patience, Shadows};
use crate::world::World;
use raster::ShadowMaps;
use shading::Memory;
use std::ops::Range;

pub use raster::Footprint;
#[doc(hidden)]
pub use raster::{Seen, VisibilityBuffer};

/// The rays that are wanted for a picture.
#[derive(Clone, Debug)]
pub struct Demand {
    /// Width and height of the whole picture in pixels.
    pub size: [usize; 2],
    /// The columns that are rendered.
    pub columns: Range<usize>,
    /// Which rays are cast from the camera into the scene, if any are.
    pub footprint: Option<Footprint>,
    /// The number of camera rays whose colours are wanted.
    pub colors: usize,
    /// The effects that are modelled.
    pub effects: Effects,
}

/// Traces the rays of a picture.
#[derive(Debug)]
pub struct FastTracer<'a> {
    camera: &'a Camera,
    caster: &'a Caster<'a>,
    demand: Demand,
    shadow_maps: Option<ShadowMaps>,
    patience: Patience<'a>,
    /// Whether the scene means what those of 2004 do.
    is_of_course: bool,
}

/// Traces some rows of pixels.
#[derive(Debug)]
pub struct FastRows<'a> {
    picture: &'a FastTracer<'a>,
    caster: &'a Caster<'a>,
    /// The first hits of the rays through these rows, as far as they are known.
    visibility: Option<VisibilityBuffer>,
}

/// Traces one row of pixels.
#[derive(Debug)]
pub struct FastRow<'a> {
    rows: &'a FastRows<'a>,
    memory: Box<Memory<'a>>,
}

/// Whether the first hits of camera rays are found without casting most of them.
pub fn finds_first_hits(camera: &Camera, world: &World, size: [usize; 2]) -> bool {
    VisibilityBuffer::suits(camera, world, size)
}

impl<'a> FastTracer<'a> {
    /// A tracer for a picture that follows secondary rays as long as the patience of a row lasts.
    pub(crate) fn new(
        camera: &'a Camera,
        caster: &'a Caster<'a>,
        demand: Demand,
        patience: Patience<'a>,
    ) -> Self {
        let is_needed = demand.colors > 0 && demand.effects.shadows == Shadows::Opaque;
        let shadow_maps = is_needed.then(|| ShadowMaps::new(caster.world, demand.colors));
        Self { camera, caster, demand, shadow_maps, patience, is_of_course: caster.world.is_of_course() }
    }

    /// A tracer for these rows of the picture, counted from the bottom.
    pub fn rows(&self, rows: Range<usize>) -> FastRows<'_> {
        let Self { camera, caster, demand, .. } = self;
        let buffer = |footprint| VisibilityBuffer::new(camera, caster, demand.size, rows.clone(), footprint);
        let visibility = demand.footprint.and_then(buffer);
        FastRows { picture: self, caster, visibility }
    }
}

impl FastRows<'_> {
    /// A tracer for one of the rows.
    pub fn row(&self) -> FastRow<'_> {
        FastRow { rows: self, memory: Box::new(Memory::new(self.picture.patience)) }
    }
}

impl<'a> FastRow<'a> {
    /// How long the row is traced.
    pub(crate) fn patience(&mut self) -> &mut Patience<'a> {
        &mut self.memory.patience
    }

    /// Traces the samples of a packet, which lie in row `j`, and enters their colours, if they are wanted. Returns how
    /// many secondary and shadow rays were cast for them.
    pub fn trace(
        &mut self,
        j: usize,
        wanted: Wanted,
        packet: &mut SamplePacket,
        colors: &mut PacketColors,
    ) -> u64 {
        let caster = &self.rows.caster;
        if self.rows.picture.is_of_course {
            row::trace(self, *caster, j, wanted, packet, colors);
        } else {
            row::trace(self, &ByModel(caster), j, wanted, packet, colors);
        }
        std::mem::take(&mut self.memory.rays)
    }
}
