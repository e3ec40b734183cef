//! Optional hints for the tracer. They never change a picture: a build without the feature `fast` makes the same bytes.
//!
//! Rasterization finds the first hits of camera rays and what stands between a surface and a light, where that is certain.
//! [`RasterHints`] answers the questions of [`Hints`]; the tracer casts the other rays.

mod raster;
#[cfg(test)]
mod tests;

use crate::camera::Camera;
use crate::caster::Caster;
use crate::math::ray::Ray;
use crate::trace::{Blocker, FirstHit, Hints};
use crate::world::World;
use glam::DVec3;
use raster::ShadowMaps;
use std::ops::Range;
use std::sync::Arc;

pub use raster::{Footprint, VisibilityBuffer};

/// The rays that are wanted for a picture.
#[derive(Clone, Debug)]
pub struct Demand {
    /// Width and height of the whole picture in pixels.
    pub size: [usize; 2],
    /// The columns that are rendered.
    pub columns: Range<usize>,
    /// Which rays are cast from the camera into the scene, if any are.
    pub footprint: Option<Footprint>,
    /// The number of rays to each light, if they only have to tell whether they are blocked.
    pub shadow_rays: usize,
}

/// What rasterization tells of the rays of a picture.
#[derive(Clone, Debug)]
pub struct RasterHints {
    demand: Demand,
    shadow_maps: Arc<ShadowMaps>,
    /// The first hits of the rays through some rows.
    visibility: Option<Arc<VisibilityBuffer>>,
}

impl Hints for RasterHints {
    #[inline(always)]
    fn first_hit(&self, world: &World, ray: &Ray, pixel: [usize; 2]) -> FirstHit {
        // A closure would not be compiled for the instructions of the caller.
        match &self.visibility {
            Some(buffer) => buffer.first_hit(world, ray, pixel),
            None => FirstHit::Unknown,
        }
    }

    #[inline(always)]
    fn blocker(&self, light: usize, point: DVec3) -> Blocker {
        self.shadow_maps.blocker(light, point)
    }
}

/// Whether the first hits of camera rays are found without casting most of them.
pub fn finds_first_hits(camera: &Camera, world: &World, size: [usize; 2]) -> bool {
    VisibilityBuffer::suits(camera, world, size)
}

impl RasterHints {
    /// Hints about shadows.
    pub fn new(world: &World, demand: Demand) -> Self {
        let shadow_maps = Arc::new(ShadowMaps::new(world, demand.shadow_rays));
        Self { demand, shadow_maps, visibility: None }
    }

    /// Adds hints about the first hits in these rows, counted from the bottom.
    pub fn in_rows(&self, camera: &Camera, caster: &Caster, rows: Range<usize>) -> Self {
        let Demand { size, footprint, .. } = self.demand;
        let buffer = footprint.and_then(|of| VisibilityBuffer::new(camera, caster, size, rows, of));
        Self { visibility: buffer.map(Arc::new), ..self.clone() }
    }
}
