//! Shadows: the fraction of a light that reaches a surface.

use super::hints::{Blocker, Hints};
use super::observer::{Event, Observer};
use super::optics::transmittance;
use super::{Shadows, Tracer};
use crate::base::patience::Patience;
use crate::caster::RayOrigin;
use crate::math::ray::Ray;
use crate::math::robust::end_at;
use crate::picture::Color;
use crate::scene::Light;
use crate::scene::limits::LARGEST;
use crate::shading::light::Incident;
use crate::shading::phong::Mixture;
use crate::shading::texture::{material_at, material_of_surface};
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// The number of crossings of one ray between two questions whether the work should end.
const CROSSINGS_AT_ONCE: usize = 16;

/// Returns the ray from a surface, off which its origin was moved, up to a point light. Its length is measured from the
/// origin. If the scene has an epsilon, the origin was not moved, and the ray stays as it is.
#[inline(always)]
pub(crate) fn ending_at_light(world: &World, index: usize, surface: &SurfacePoint, ray: Ray) -> Ray {
    match world.lights.get(index) {
        Some(&Light::Point { position, .. }) if world.lighting.epsilon.is_none() => {
            let (t_max, direction) = end_at(position, ray.origin, surface.normal, ray.direction);
            Ray { t_max, direction, ..ray }
        }
        _ => ray,
    }
}

impl<H: Hints> Tracer<'_, H> {
    /// Returns the fraction of the light with this index, per channel, that reaches a surface.
    #[inline(always)]
    pub(super) fn light_passed<O: Observer>(
        &self,
        surface: &SurfacePoint,
        light: &Incident,
        index: usize,
        observer: &mut O,
    ) -> Color {
        match self.effects.shadows {
            Shadows::None => Color::ONE,
            Shadows::Opaque if self.is_blocked(surface, light, index, observer) => Color::ZERO,
            Shadows::Opaque => Color::ONE,
            Shadows::Transparent => {
                observer.shadow_ray();
                // The function gets copies: a light that is referred to lies in memory, written part by part and read as
                // vectors, for which the processor stalls.
                let ray = self.shadow_ray(surface, light.direction, light.distance, index);
                observer.observe(|| Event::ShadowRay(ray));
                let origin = self.origin(surface);
                let starts_within = surface.normal.dot(light.direction) < 0.0;
                self.filtered(ray, origin, starts_within, index, observer)
            }
        }
    }

    /// Returns the ray from a surface in the direction of the light with this index. It has this length if the light is
    /// directional, or if the scene has an epsilon.
    #[inline(always)]
    fn shadow_ray(&self, surface: &SurfacePoint, direction: DVec3, length: f64, index: usize) -> Ray {
        let ray = Ray { t_max: length, ..self.departing(surface, direction) };
        ending_at_light(self.world(), index, surface, ray)
    }

    /// Returns true if anything blocks the light with this index from a surface.
    #[inline(always)]
    fn is_blocked<O: Observer>(
        &self,
        surface: &SurfacePoint,
        light: &Incident,
        index: usize,
        observer: &mut O,
    ) -> bool {
        observer.shadow_ray();
        // A ray to a light that lies on a surface ends there. Roundings would decide whether it is blocked, so it
        // always is.
        let is_at_rest = !self.world().primitives_at_light(index).is_empty();
        let origin = self.origin(surface);
        let blocker = self.hints.blocker(self.world(), index, surface, light.direction);
        if !O::COUNTS && blocker == Blocker::Certain {
            return true;
        }
        if !O::COUNTS && blocker == Blocker::Nothing && self.caster.has_no_plane_but(origin) {
            return is_at_rest;
        }
        let ray = self.shadow_ray(surface, light.direction, light.distance, index);
        observer.observe(|| Event::ShadowRay(ray));
        let is_hit = match blocker {
            // The course's program searches the nearest hit, even if any hit would do.
            _ if O::COUNTS => self.cast(&ray, origin, observer).is_some(),
            Blocker::Any | Blocker::Certain => self.caster.any(&ray, origin),
            Blocker::Only(triangle) => {
                self.caster.hits_triangle(&ray, triangle, origin) || self.caster.hits_plane(&ray, origin)
            }
            Blocker::Nothing => self.caster.hits_plane(&ray, origin),
        };
        is_hit || is_at_rest
    }

    /// Returns the fraction of light that transparent objects transmit along a shadow ray. At each exit from an
    /// object, this is the object's colour to the power of the distance since the last surface (Beer's law). `is_within`
    /// is true if the ray starts inside an object.
    ///
    /// If the light lies on surfaces, they are crossed at the light itself, and only if the ray was inside an object
    /// before. So it does not matter which of them the ray hits by rounding. An opaque one blocks the light.
    fn filtered<O: Observer>(
        &self,
        mut ray: Ray,
        mut origin: RayOrigin,
        mut is_within: bool,
        index: usize,
        observer: &mut O,
    ) -> Color {
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        let at_light = self.world().primitives_at_light(index);
        // The distance from the last surface to the current origin of the ray.
        let mut way = 0.0;
        let through = |passed: Color, tint: Color, way: f64| {
            (passed * transmittance(tint, way)).min(Color::splat(LARGEST))
        };
        for crossing in 0..self.world().most_crossings() {
            if crossing % CROSSINGS_AT_ONCE == CROSSINGS_AT_ONCE - 1 && self.caster.is_over() {
                break;
            }
            let Some(visible) = self.cast(&ray, origin, observer) else { break };
            let (hit, surface) = (self.world().hit(&ray, visible), self.surface(&ray, visible));
            let is_exit = surface.normal.dot(ray.direction) >= 0.0;
            if at_light.iter().any(|place| place.is_crossed(hit.primitive, ray.direction, is_exit)) {
                way += hit.t;
            } else {
                let material = material_of_surface(self.world(), &surface, self.caster.level, &mut mixture);
                let tint = material.phong.transparent;
                observer.observe(|| Event::Crossed { hit, tint, is_leaving: is_exit });
                if tint == Color::ZERO {
                    return Color::ZERO;
                }
                if is_exit {
                    passed = through(passed, tint, way + hit.t);
                }
                (is_within, way) = (!is_exit, 0.0);
            }
            ray = self.shadow_ray(&surface, ray.direction, ray.t_max - hit.t, index);
            origin = self.origin(&surface);
        }
        let goes_on = |&(place, _): &(usize, _)| place == 0 || !self.caster.is_over();
        let tints = at_light.iter().enumerate().take_while(goes_on);
        let tints = tints.map(|(_, place)| self.tint_at_light(place.primitive, index));
        match tints.reduce(|one, other| if other == Color::ZERO { other } else { one }) {
            Some(Color::ZERO) => Color::ZERO,
            Some(tint) if is_within => through(passed, tint, way + ray.t_max.max(0.0)),
            _ => passed,
        }
    }

    /// Returns the transparent colour of a primitive at the position of the light with this index.
    fn tint_at_light(&self, primitive: u32, index: usize) -> Color {
        let world = self.world();
        let Some(&Light::Point { position, .. }) = world.lights.get(index) else { return Color::ZERO };
        let (material, level) = (world.material_of(primitive), self.caster.level);
        let mut mixture = Mixture::default();
        material_at(&world.materials, material, &position.into(), level, &mut mixture).phong.transparent
    }
}
