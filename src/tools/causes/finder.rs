//! How the textbook's tracer finds what rays hit.

use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::stats::RayCount;
use crate::world::{SurfacePoint, World};

/// Finds what rays hit.
pub trait Finder: Sync {
    /// What there is to hit.
    fn world(&self) -> &World;
    /// The first thing along a ray that is not the triangle it starts at.
    fn nearest(&self, ray: &Ray, exclude: Option<u32>) -> Option<Found>;
    /// Whether there is anything along a ray but the triangle it starts at.
    fn is_blocked(&self, ray: &Ray, exclude: Option<u32>) -> bool;
}

/// What a ray hits.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Its id.
    pub primitive: u32,
    /// Where on the ray it is.
    pub t: f64,
    /// Its surface there.
    pub surface: SurfacePoint,
}

impl Finder for Caster<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn nearest(&self, ray: &Ray, exclude: Option<u32>) -> Option<Found> {
        let hit = self.world.hit(ray, Caster::nearest(self, ray, exclude, &mut RayCount::default())?);
        Some(Found { primitive: hit.primitive, t: hit.t, surface: self.world.surface(ray, &hit) })
    }

    fn is_blocked(&self, ray: &Ray, exclude: Option<u32>) -> bool {
        self.any_from(ray, exclude, &mut RayCount::default())
    }
}
