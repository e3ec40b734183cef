//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::choose::Structure;
use raytracer::caster::{Caster, NotBuilt, RayOrigin};
use raytracer::math::instructions;
use raytracer::world::World;

impl Cast for Caster<'_> {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        Caster::closest(self, &ray.exact()).map_or(f64::INFINITY, |hit| hit.t)
    }

    fn count_closest(&self, rays: &[FlatRay]) -> usize {
        rays.iter().filter(|ray| self.nearest(&ray.exact(), RayOrigin::FREE).is_some()).count()
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        Caster::any(self, &ray.exact(), RayOrigin::FREE)
    }
}

/// The caster of a picture for which no structure is asked for.
pub fn caster(world: &World) -> Result<Caster<'_>, NotBuilt> {
    Caster::with(world, Structure::Any.layout(world, 0), instructions::available()[0])
}
