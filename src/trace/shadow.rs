//! How much of a light reaches a surface.

use super::event::{Event, Observer};
use super::occluders::{Occluders, Side};
use super::optics::transmittance;
use super::{Lit, Shadows, Tracer};
use crate::math::ray::Ray;
use crate::mode::Mode;
use crate::raster::Blocker;
use crate::scene::Color;
use crate::scene::limits::LARGEST;
use crate::shading::light::Incident;
use crate::shading::phong::Mixture;
use crate::world::SurfacePoint;

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
        let blocker = self.blocker(&lit.surface, index, side);
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
            return self.filtered(ray, probe);
        }
        let leaves = lit.surface.primitive;
        let is_blocked = match blocker {
            Blocker::Any => {
                let occluder = occluders.place(side, index);
                *occluder = self.caster.occluder(&ray, leaves, *occluder, probe);
                occluder.is_some()
            }
            Blocker::Only(triangle) => {
                self.caster.is_hit(&ray, triangle, leaves, probe)
                    || self.caster.meets_plane(&ray, leaves, probe)
            }
            Blocker::Nothing => self.caster.meets_plane(&ray, leaves, probe),
        };
        if is_blocked { Color::ZERO } else { Color::ONE }
    }

    /// What a ray from a surface to the light with this index may hit. A map knows nothing of a ray from a sphere.
    /// One from an inner side most often hits what the last one hit, which is tested sooner.
    #[inline(always)]
    fn blocker(&self, surface: &SurfacePoint, index: usize, side: Side) -> Blocker {
        let is_round = surface.primitive.is_some_and(|primitive| self.caster.is_round(primitive));
        match self.shadow_maps {
            Some(maps) if !side.is_inner() && !is_round => maps.blocker(index, surface.position),
            _ => Blocker::Any,
        }
    }

    /// The fraction of light that transparent objects transmit along a shadow ray. Where the ray leaves an
    /// object, this is the object's colour to the power of the distance since the last surface (Beer's law).
    fn filtered<P: Observer>(&self, mut ray: Ray, probe: &mut P) -> Color {
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        while let Some(hit) = self.caster.closest(&ray, probe) {
            let surface = self.world().surface(&ray, &hit);
            let tint = self.material(&surface, &mut mixture).phong.transparent;
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
