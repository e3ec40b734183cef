//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::choose::{Layout, Rays};
use raytracer::caster::{Caster, NotBuilt, RayOrigin};
use raytracer::math::instructions;
use raytracer::trace::Quiet;
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
        Caster::any(self, &ray.exact(), RayOrigin::FREE, &mut Quiet)
    }
}

/// A number of rays for which the time of building is negligible.
const RAYS: usize = 1 << 30;

/// The caster that `-grid auto` chooses.
pub fn caster(world: &World) -> Result<Caster<'_>, NotBuilt> {
    Caster::with(world, Layout::chosen(world, Rays::cast(RAYS)), instructions::available()[0])
}
