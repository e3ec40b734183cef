//! How much of a light reaches a surface.

use super::event::{Event, Observer};
use super::optics::transmittance;
use super::{Lit, Shadows, Tracer};
use crate::fast::Blocker;
use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::mode::Mode;
use crate::scene::limits::LARGEST;
use crate::scene::{Color, Light};
use crate::shading::light::Incident;
use crate::shading::phong::Mixture;
use crate::shading::texture::material_at;
use crate::world::SurfacePoint;

impl<M: Mode> Tracer<'_, M> {
    /// How much of the light with this index reaches the side of the surface that is seen, per channel.
    #[inline(always)]
    pub(super) fn light_passed<P: Observer>(
        &self,
        lit: &Lit,
        (light, index, is_inside): (&Incident, usize, bool),
        probe: &mut P,
    ) -> Color {
        if self.effects.shadows == Shadows::None {
            return Color::ONE;
        }
        probe.shadow_ray();
        // A ray to a light that lies on a triangle ends there, so that roundings would decide whether it is blocked.
        let is_at_rest = !self.world().triangles_at_light(index).is_empty();
        let is_cast = M::AS_COURSE || P::OBSERVES;
        if is_at_rest && !is_cast && self.effects.shadows == Shadows::Opaque {
            return Color::ZERO;
        }
        let blocker = self.blocker(&lit.surface, index, is_inside);
        // The ray leaves the only plane.
        if blocker == Blocker::Nothing && self.caster.has_no_plane_but(lit.surface.primitive) {
            return Color::ONE;
        }
        let mut ray = self.secondary(&lit.surface, light.direction);
        // The distance to a point light is measured from the origin of the shadow ray.
        ray.t_max = light.distance;
        if P::OBSERVES {
            probe.observe(Event::ShadowRay(ray));
        }
        if self.effects.shadows == Shadows::Transparent {
            // Only numbers of the hit are passed on, so that it can stay in registers.
            let starts_within = lit.surface.normal.dot(light.direction) < 0.0;
            return self.filtered(ray, index, starts_within, probe);
        }
        let leaves = lit.surface.primitive;
        let is_blocked = match blocker {
            Blocker::Any => self.caster.any_from(&ray, leaves, probe),
            Blocker::Only(triangle) => {
                self.caster.is_hit(&ray, triangle, leaves, probe)
                    || self.caster.meets_plane(&ray, leaves, probe)
            }
            Blocker::Nothing => self.caster.meets_plane(&ray, leaves, probe),
        };
        if is_blocked || is_cast && is_at_rest { Color::ZERO } else { Color::ONE }
    }

    /// The transparent colour of a triangle where the light with this index lies on it.
    fn tint_at_light(&self, triangle: u32, index: usize) -> Color {
        let Caster { world, instructions, .. } = *self.caster;
        let (Some(&Light::Point { position, .. }), material) =
            (world.lights.get(index), world.material_of(triangle))
        else {
            return Color::ZERO;
        };
        let mut mixture = Mixture::default();
        material_at(&world.materials, material, &position.into(), instructions, &mut mixture)
            .phong
            .transparent
    }

    /// What a ray from a surface to the light with this index may hit. A map knows nothing of a ray from a sphere, and
    /// one from an inner side hits the surface itself.
    #[inline(always)]
    fn blocker(&self, surface: &SurfacePoint, index: usize, is_inside: bool) -> Blocker {
        let is_round = surface.primitive.is_some_and(|primitive| self.caster.is_round(primitive));
        match self.shadow_maps {
            Some(maps) if !is_inside && !is_round => maps.blocker(index, surface.position),
            _ => Blocker::Any,
        }
    }

    /// The fraction of light that transparent objects transmit along a shadow ray. Where the ray leaves an
    /// object, this is the object's colour to the power of the distance since the last surface (Beer's law).
    ///
    /// The triangles that the light lies on are left behind at the light if the ray was within an object before. So it
    /// does not matter which of them the ray meets by its roundings. One that is opaque lets nothing through.
    fn filtered<P: Observer>(&self, mut ray: Ray, light: usize, starts_within: bool, probe: &mut P) -> Color {
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        let at_light = self.world().triangles_at_light(light);
        let mut is_within = starts_within;
        // The way since the last surface, up to where the ray starts now.
        let mut way = 0.0;
        while let Some(hit) = self.caster.closest(&ray, probe) {
            let surface = self.world().surface(&ray, &hit);
            if at_light.contains(&hit.primitive) {
                way += hit.t;
                ray = Ray { t_max: ray.t_max - hit.t, ..self.secondary(&surface, ray.direction) };
                continue;
            }
            let tint = self.material(&surface, &mut mixture).phong.transparent;
            let leaves = surface.normal.dot(ray.direction) >= 0.0;
            if P::OBSERVES {
                probe.observe(Event::Crossed { hit, tint, leaves });
            }
            if tint == Color::ZERO {
                return Color::ZERO;
            }
            is_within = !leaves;
            if leaves {
                passed = (passed * transmittance(tint, way + hit.t)).min(Color::splat(LARGEST));
            }
            way = 0.0;
            ray = Ray { t_max: ray.t_max - hit.t, ..self.secondary(&surface, ray.direction) };
        }
        let tints = at_light.iter().map(|&triangle| self.tint_at_light(triangle, light));
        match tints.reduce(|one, other| if other == Color::ZERO { other } else { one }) {
            Some(Color::ZERO) => Color::ZERO,
            Some(tint) if is_within => {
                let way = way + ray.t_max.max(0.0);
                (passed * transmittance(tint, way)).min(Color::splat(LARGEST))
            }
            _ => passed,
        }
    }
}
