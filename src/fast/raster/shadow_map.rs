//! Shadow maps (Williams, "Casting Curved Shadows on Curved Surfaces", SIGGRAPH 1978): finds the primitives between a
//! light and any point of the world, as far as rasterization determines them.
//!
//! The triangles are drawn as seen from the light, for whole pixels of a picture. A pixel is certain if nothing is in
//! it, or if one triangle covers all of it and is the nearest. In the first case a ray to the light from a point in
//! the pixel hits nothing. In the second case it hits this triangle or nothing. All other rays must be cast, including
//! rays near spheres. So shadows are as exact as without maps. [`light_view`](super::light_view) and
//! [`flat_triangle`](super::flat_triangle) state the error bounds of the pictures.

use super::light_view::{LightView, MapPlace};
use super::{NOTHING, UNSURE, bytes_to_draw, drawn, tile};
use crate::base::memory;
use crate::base::patience::Patience;
use crate::base::shortcut::Shortcut;
use crate::caster::bounds::widened;
use crate::math::aabb::Aabb;
use crate::scene::Light;
use crate::trace::Blocker;
use crate::world::World;
use glam::DVec3;
use rayon::prelude::*;

/// The shadow map of one light.
#[derive(Debug)]
struct ShadowMap {
    view: LightView,
    /// The id of the triangle nearest to the light in each pixel, or [`NOTHING`] or [`UNSURE`].
    nearest_ids: Vec<u32>,
}

/// The shadow maps of a world's lights.
#[derive(Debug, Default)]
pub struct ShadowMaps(Vec<Option<ShadowMap>>);

/// The number of pixels along a side. It is small enough that a map stays in the cache.
const SIZE: usize = 256;

/// Maps are built only for at least this number of rays to a light per triangle, and at least one per pixel. According
/// to measurements, they take more time than they save otherwise.
const RAYS_PER_TRIANGLE: usize = 48;

/// Upper bound on the pixel tests of all maps together: a fraction of a second, which cannot be interrupted.
const MAX_PIXELS: usize = 1 << 28;

impl ShadowMaps {
    /// Builds the maps for this number of rays to each light. A light has no map if it is too close to the primitives,
    /// if there is too little memory, or if casting the rays is less work.
    pub fn new(world: &World, rays: usize, patience: &dyn Patience) -> Self {
        // The pixels of spheres are unsure.
        let has_flat_surfaces = !world.triangles.is_empty() || !world.planes.is_empty();
        let pays = rays >= SIZE * SIZE && rays / RAYS_PER_TRIANGLE >= world.triangles.len();
        if !Shortcut::ShadowMaps.is_taken() || world.finite_count() == 0 || !has_flat_surfaces || !pays {
            return Self::default();
        }
        let at_once = world.lights.len().min(rayon::current_num_threads()) as u64;
        if memory::ask(at_once * bytes_to_draw(world, SIZE * (SIZE + tile::LANES))).is_err() {
            return Self::default();
        }
        let most_pixels = MAX_PIXELS / world.lights.len().max(1);
        let map = |light: &Light| {
            let may_go_on = !patience.is_over();
            if may_go_on { ShadowMap::new(world, light, most_pixels, patience) } else { None }
        };
        Self(world.lights.par_iter().map(map).collect())
    }

    /// Returns the primitives that a ray from a point to the light with this index may hit.
    #[inline(always)]
    pub fn blocker(&self, light: usize, point: DVec3) -> Blocker {
        match self.0.get(light) {
            Some(Some(map)) => map.blocker(point),
            _ => Blocker::Any,
        }
    }
}

impl ShadowMap {
    fn new(world: &World, light: &Light, most_pixels: usize, patience: &dyn Patience) -> Option<Self> {
        let of_boxes = world.boxes().flat_map(|bounds| widened(bounds).corners());
        let bounds = Aabb::around(of_boxes.chain(world.vertices.iter().copied()));
        let view = LightView::new(light, &bounds, SIZE)?;
        let nearest_ids = drawn(&view, &(0..SIZE), world, most_pixels, patience)?;
        Some(Self { view, nearest_ids })
    }

    #[inline(always)]
    fn blocker(&self, point: DVec3) -> Blocker {
        match self.view.pixel(point) {
            MapPlace::Outside => Blocker::Nothing,
            MapPlace::Unknown => Blocker::Any,
            MapPlace::Pixel([i, j]) => match self.nearest_ids[j * (SIZE + tile::LANES) + i] {
                NOTHING => Blocker::Nothing,
                UNSURE => Blocker::Any,
                id => Blocker::Only(id),
            },
        }
    }
}

#[cfg(test)]
mod tests;
