//! The hits of rays, found by a caster, by brute force, or in wrong ways.

use crate::caster::{Caster, RayOrigin};
use crate::math::ray::{Ray, Visible};
use crate::world::{SurfacePoint, World};

/// Finds the hits of rays.
pub trait Hits: Sync {
    /// The world that is hit.
    fn world(&self) -> &World;

    /// Returns the nearest hit of a ray that leaves `origin_primitive`. The ray cannot hit it again unless it is
    /// round.
    fn nearest(&self, ray: &Ray, origin_primitive: Option<u32>) -> Option<Visible>;

    /// Returns the t of a ray's nearest hit.
    fn distance(&self, ray: &Ray, visible: Visible) -> f64 {
        self.world().hit(ray, visible).t
    }

    /// Returns the surface at a ray's nearest hit, with its shading normal.
    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.world().visible_surface(ray, visible);
        let normal = self.world().smooth_normal(&surface).unwrap_or(surface.normal);
        SurfacePoint { normal, ..surface }
    }
}

impl Hits for Caster<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn nearest(&self, ray: &Ray, origin_primitive: Option<u32>) -> Option<Visible> {
        Caster::nearest(self, ray, RayOrigin::on(self.world, origin_primitive))
    }
}
