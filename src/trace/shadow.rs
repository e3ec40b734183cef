//! How much of a light reaches a surface.

use super::observer::{Event, Observer};
use super::rules::{Departure, Rules};
use super::{Arrival, Shadows, Tracer};
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::Light;
use crate::scene::limits::LARGEST;
use crate::shading::light::Incident;
use crate::shading::phong::Mixture;
use crate::shading::texture::material_at;
use crate::world::SurfacePoint;

impl<R: Rules> Tracer<'_, R> {
    /// How much of the light with this index passes what is between it and a surface, per channel.
    pub(super) fn light_passed<O: Observer>(
        &self,
        arrival: &Arrival,
        light: &Incident,
        index: usize,
        observer: &mut O,
    ) -> Color {
        if self.effects.shadows == Shadows::None {
            return Color::ONE;
        }
        observer.shadow_ray();
        let (ray, leaves) = self.shadow_ray(arrival.surface, light);
        observer.observe(|| Event::ShadowRay(ray));
        if self.effects.shadows == Shadows::Transparent {
            let starts_within = arrival.surface.normal.dot(light.direction) < 0.0;
            return self.filtered((ray, leaves), index, starts_within, observer);
        }
        let is_blocked = self.rules.is_blocked(&ray, leaves, observer);
        // A ray to a light that lies on a surface ends there, so that roundings would decide whether it is blocked.
        let is_at_rest = !self.world().primitives_at_light(index).is_empty();
        if is_blocked || is_at_rest { Color::ZERO } else { Color::ONE }
    }

    /// The ray from a surface to a light, and the primitive that it leaves. The distance to a point light is measured from
    /// the surface.
    #[inline(always)]
    pub(crate) fn shadow_ray(&self, surface: &SurfacePoint, light: &Incident) -> (Ray, Option<u32>) {
        let (ray, leaves) = self.rules.departing(Departure::Shadow, surface, light.direction);
        (Ray { t_max: self.rules.shadow_end(light.distance), ..ray }, leaves)
    }

    /// The fraction of light that transparent objects transmit along a shadow ray, which leaves a primitive. Where the ray
    /// leaves an object, this is the object's colour to the power of the distance since the last surface (Beer's law).
    ///
    /// The surfaces that the light lies on are left behind at the light if the ray was within an object before. So it
    /// does not matter which of them the ray meets by its roundings. One that is opaque lets nothing through.
    pub(crate) fn filtered<O: Observer>(
        &self,
        (mut ray, mut left): (Ray, Option<u32>),
        light: usize,
        starts_within: bool,
        observer: &mut O,
    ) -> Color {
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        let at_light = self.world().primitives_at_light(light);
        let mut is_within = starts_within;
        // The way since the last surface, up to where the ray starts now.
        let mut way = 0.0;
        for _ in 0..self.world().most_crossings() {
            let Some(visible) = self.rules.nearest(&ray, left, observer) else { break };
            let (hit, surface) = (self.rules.hit(&ray, visible), self.rules.surface(&ray, visible));
            let leaves = surface.normal.dot(ray.direction) >= 0.0;
            let is_at_light =
                at_light.iter().any(|place| place.is_crossed(hit.primitive, ray.direction, leaves));
            if is_at_light {
                way += hit.t;
            } else {
                let tint = self.rules.material(&surface, &mut mixture).phong.transparent;
                observer.observe(|| Event::Crossed { hit, tint, leaves });
                if tint == Color::ZERO {
                    return Color::ZERO;
                }
                is_within = !leaves;
                if leaves {
                    passed =
                        (passed * self.rules.transmittance(tint, way + hit.t)).min(Color::splat(LARGEST));
                }
                way = 0.0;
            }
            let t_max = ray.t_max - hit.t;
            (ray, left) = self.rules.departing(Departure::Onwards, &surface, ray.direction);
            ray.t_max = t_max;
        }
        let tints = at_light.iter().map(|place| self.tint_at_light(place.primitive, light));
        match tints.reduce(|one, other| if other == Color::ZERO { other } else { one }) {
            Some(Color::ZERO) => Color::ZERO,
            Some(tint) if is_within => {
                let way = way + ray.t_max.max(0.0);
                (passed * self.rules.transmittance(tint, way)).min(Color::splat(LARGEST))
            }
            _ => passed,
        }
    }

    /// The transparent colour of a primitive where the light with this index lies on it.
    fn tint_at_light(&self, primitive: u32, index: usize) -> Color {
        let world = self.world();
        let Some(&Light::Point { position, .. }) = world.lights.get(index) else { return Color::ZERO };
        let (material, level) = (world.material_of(primitive), self.rules.level());
        let mut mixture = Mixture::default();
        material_at(&world.materials, material, &position.into(), level, &mut mixture).phong.transparent
    }
}
