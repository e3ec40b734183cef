//! The rules by which rays are traced. Those that are provided are the right ones, and the only ones of a caster. Whoever
//! wants to know what a mistake looks like breaks one.

use super::{Secondary, reflected};
use crate::caster::Caster;
use crate::math::instructions::Instructions;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust::offset_origin;
use crate::scene::Color;
use crate::scene::material::Material;
use crate::shading::phong::{Mixture, PointMaterial};
use crate::shading::texture::material_at;
use crate::stats::Probe;
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// Why a ray leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    /// It is reflected or refracted.
    Secondary(Secondary),
    /// It goes to a light.
    Shadow,
}

/// How rays are traced.
pub trait Rules: Sync {
    /// What rays hit.
    fn world(&self) -> &World;

    /// What a ray hits first that leaves the primitive `leaves`. That is not hit again, unless it is round.
    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible>;

    /// The hit of a ray on what it hits first, with its t.
    #[inline(always)]
    fn hit(&self, ray: &Ray, visible: Visible) -> Hit {
        self.world().hit(ray, visible)
    }

    /// The surface that a ray hits first.
    #[inline(always)]
    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        self.world().visible_surface(ray, visible)
    }

    /// The instructions that textures are evaluated with. The bytes are the same with all of them.
    #[inline(always)]
    fn instructions(&self) -> Instructions {
        Instructions::Portable
    }

    /// The material of a surface, with its textures evaluated at the point.
    #[inline(always)]
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let (world, instructions) = (self.world(), self.instructions());
        if let Material::Phong(phong) = &world.materials[surface.material] {
            return phong.into();
        }
        world.with_rounded_point(surface, |point| {
            material_at(&world.materials, surface.material, point, instructions, mixture)
        })
    }

    /// The colour of a ray that hits nothing after so many bounces.
    #[inline(always)]
    fn background(&self, _bounces: u32) -> Color {
        self.world().background
    }

    /// A ray from a surface, and the primitive that it leaves. It starts a few roundings off the surface, on the side to
    /// which it goes.
    #[inline(always)]
    fn departing(&self, _why: Departure, surface: &SurfacePoint, direction: DVec3) -> (Ray, Option<u32>) {
        let largest = self.world().max_abs_coord;
        let origin = offset_origin(surface.position, surface.normal, direction, largest);
        (Ray::new(origin, direction), surface.primitive)
    }

    /// Where a shadow ray to a light at this distance ends.
    #[inline(always)]
    fn shadow_end(&self, distance: f64) -> f64 {
        distance
    }

    /// The direction of a mirrored ray.
    #[inline(always)]
    fn reflected(&self, direction: DVec3, normal: DVec3) -> DVec3 {
        reflected(direction, normal)
    }

    /// What the light of one source adds to the colour of a surface.
    #[inline(always)]
    fn light(&self, color: Color) -> Color {
        color
    }

    /// The sum of two colours, in the precision of the computation.
    #[inline(always)]
    fn sum(&self, one: Color, other: Color) -> Color {
        one + other
    }
}

impl Rules for Caster<'_> {
    #[inline(always)]
    fn world(&self) -> &World {
        self.world
    }

    #[inline(always)]
    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        Caster::nearest(self, ray, leaves, probe)
    }

    #[inline(always)]
    fn instructions(&self) -> Instructions {
        self.instructions
    }
}
