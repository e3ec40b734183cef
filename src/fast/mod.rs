//! Optional hints for the tracer. They never change a picture: a build without the feature `fast` makes the same bytes.
//!
//! Rasterization finds the first hits of camera rays, and the primitives between a surface and a light, if they are
//! certain. [`RasterHints`] implements [`Hints`] with these results. The tracer casts the other rays.

mod enclosed;
mod raster;
#[cfg(test)]
mod tests;

use crate::base::patience::Patience;
use crate::camera::Camera;
use crate::caster::Caster;
use crate::math::ray::Ray;
use crate::trace::{Blocker, FirstHit, Hints};
use crate::world::{SurfacePoint, World};
use enclosed::ClosedMeshes;
use glam::DVec3;
use raster::ShadowMaps;
use std::ops::Range;
use std::sync::Arc;

pub use raster::{Footprint, VisibilityBuffer};

/// The rays that a picture needs.
#[derive(Clone, Debug)]
pub struct Demand {
    /// Width and height of the whole picture in pixels.
    pub size: [usize; 2],
    /// The camera rays that go into the scene. `None` if there are none.
    pub footprint: Option<Footprint>,
    /// True if rays may be inside transparent objects.
    pub enters_objects: bool,
    /// The number of rays to each light, if it only matters that they are blocked or not. Otherwise 0.
    pub shadow_rays: usize,
}

/// The results of rasterization for the rays of a picture.
#[derive(Clone, Debug)]
pub struct RasterHints {
    demand: Demand,
    shadow_maps: Arc<ShadowMaps>,
    closed_meshes: Arc<ClosedMeshes>,
    /// The first hits of the rays through some rows.
    visibility: Option<Arc<VisibilityBuffer>>,
}

impl Hints for RasterHints {
    #[inline(always)]
    fn first_hit(&self, world: &World, ray: &Ray, pixel: [usize; 2]) -> FirstHit {
        // No closure here: it would not be compiled for the instructions of the caller.
        match &self.visibility {
            Some(buffer) => buffer.first_hit(world, ray, pixel),
            None => FirstHit::Unknown,
        }
    }

    #[inline(always)]
    fn blocker(&self, world: &World, light: usize, surface: &SurfacePoint, direction: DVec3) -> Blocker {
        if self.closed_meshes.block(light, surface, direction) {
            return Blocker::Certain;
        }
        // A shape may block the rays that start on it, of which shadow maps know nothing.
        if let Some(id) = surface.primitive.filter(|&id| world.is_shape(id))
            && world.lighting.epsilon.is_none()
        {
            let is_blocked = enclosed::sphere_blocks(world, id, light, surface, direction);
            return if is_blocked { Blocker::Certain } else { Blocker::Any };
        }
        self.shadow_maps.blocker(light, surface.position)
    }
}

impl RasterHints {
    /// Returns hints about shadows. There are fewer of them if the patience is over.
    pub fn new(world: &World, demand: Demand, patience: &dyn Patience) -> Self {
        let shadow_maps = Arc::new(ShadowMaps::new(world, demand.shadow_rays, patience));
        let is_worth = demand.shadow_rays > 0 && demand.enters_objects;
        // The bounds hold for rays that start off the triangle along its own normal.
        let is_certain = world.lighting.epsilon.is_none() && !world.has_smooth_normals();
        let closed_meshes =
            if is_worth && is_certain { ClosedMeshes::new(world, patience) } else { ClosedMeshes::default() };
        Self { demand, shadow_maps, closed_meshes: Arc::new(closed_meshes), visibility: None }
    }

    /// Returns these hints with hints about the first hits in these rows, counted from the bottom.
    pub fn in_rows(&self, camera: &Camera, caster: &Caster, rows: Range<usize>) -> Self {
        let Demand { size, footprint, .. } = self.demand;
        let buffer = footprint.and_then(|of| VisibilityBuffer::new(camera, caster, size, rows, of));
        Self { visibility: buffer.map(Arc::new), ..self.clone() }
    }

    /// Returns true if camera rays must be cast, since the first hits of some are not known.
    pub fn are_incomplete(&self) -> bool {
        match &self.visibility {
            Some(buffer) => buffer.is_incomplete(),
            None => self.demand.footprint.is_some(),
        }
    }
}
