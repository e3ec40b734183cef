//! This project's caster.

use crate::contestant::{Cast, FlatRay};
use raytracer::caster::Caster;
use raytracer::math::aabb::Aabb;
use raytracer::stats::Quiet;
use raytracer::world::World;

impl Cast for Caster<'_> {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        Caster::closest(self, &ray.exact(), &mut Quiet).map_or(f64::INFINITY, |hit| hit.t)
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        Caster::any(self, &ray.exact(), &mut Quiet)
    }
}

/// Cubic cells, about one for each triangle.
pub fn cells(world: &World) -> [usize; 3] {
    let Aabb { min, max } = world.bounds;
    let extent = max - min;
    let edge = (extent.element_product() / world.triangles.len() as f64).cbrt();
    (extent / edge).to_array().map(|count| count.round().max(1.0) as usize)
}
