//! Secondary rays as the renderer casts them.

use glam::DVec3;
use raytracer::caster::{Caster, RayOrigin};
use raytracer::math::ray::Ray;
use raytracer::math::robust::offset_origin;
use raytracer::world::SurfacePoint;

/// The ray along `direction` that leaves a surface.
pub fn secondary(surface: &SurfacePoint, direction: DVec3) -> Ray {
    Ray::new(offset_origin(surface.position, surface.normal, direction, surface.extent), direction)
}

/// Whether anything blocks this ray.
pub fn blocked(caster: &Caster, surface: &SurfacePoint, direction: DVec3) -> bool {
    let origin = RayOrigin::on(caster.world, surface.primitive);
    caster.any(&secondary(surface, direction), origin)
}
