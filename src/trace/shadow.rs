//! How much of a light reaches a surface.

use super::event::{Event, Observer};
use super::occluders::{Occluders, Side};
use super::optics::transmittance;
use super::{Lit, Shadows, Tracer};
use crate::math::ray::Ray;
use crate::mode::Mode;
use crate::scene::Color;
use crate::scene::limits::LARGEST;
use crate::shading::light::Incident;

impl<M: Mode> Tracer<'_, M> {
    /// How much of the light with this index reaches this side of the surface, per channel.
    #[inline(always)]
    pub(super) fn light_passed<P: Observer>(
        &self,
        lit: &Lit,
        (light, index, side): (&Incident, usize, Side),
        occluders: &mut Occluders,
        probe: &mut P,
    ) -> Color {
        if self.effects.shadows == Shadows::None {
            return Color::ONE;
        }
        probe.shadow_ray();
        let mut ray = self.secondary(lit.surface, light.direction);
        // The distance to a point light is measured from the origin of the shadow ray.
        ray.t_max = light.distance;
        if P::OBSERVES {
            probe.observe(Event::ShadowRay(ray));
        }
        match self.effects.shadows {
            Shadows::Transparent => self.filtered(ray, probe),
            _ => {
                let occluder = occluders.place(side, index);
                *occluder = self.caster.occluder(&ray, lit.surface.primitive, *occluder, probe);
                if occluder.is_some() { Color::ZERO } else { Color::ONE }
            }
        }
    }

    /// The fraction of light that transparent objects transmit along a shadow ray. Where the ray leaves an
    /// object, this is the object's colour to the power of the distance since the last surface (Beer's law).
    fn filtered<P: Observer>(&self, mut ray: Ray, probe: &mut P) -> Color {
        let mut passed = Color::ONE;
        while let Some(hit) = self.caster.closest(&ray, probe) {
            let surface = self.world().surface(&ray, &hit);
            let material = self.material(&surface);
            let tint = material.phong.transparent;
            let leaves = surface.normal.dot(ray.direction) >= 0.0;
            if P::OBSERVES {
                probe.observe(Event::Crossed { hit, tint, leaves });
            }
            if tint == Color::ZERO {
                return Color::ZERO;
            }
            if leaves {
                passed = (passed * transmittance(tint, hit.t)).min(Color::splat(LARGEST));
            }
            ray = Ray { t_max: ray.t_max - hit.t, ..self.secondary(&surface, ray.direction) };
        }
        passed
    }
}
