//! The part of a light that reaches a surface, past whatever is in the way.

use super::{Arrival, LEVEL, Leaving, Student};
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::Light;
use crate::scene::limits::LARGEST;
use crate::shading::light::Incident;
use crate::shading::phong::Mixture;
use crate::shading::texture::material_at;
use crate::tools::causes::rules::{RayKind, Rule};
use crate::trace::{Shadows, ending_at_light, transmittance};
use crate::world::SurfacePoint;

impl Student<'_> {
    /// Returns the smallest fraction of any light that reaches a surface.
    pub(super) fn passed_of_all(&self, arrival: &Arrival) -> Color {
        let lights = 0..self.world().lights.len();
        let passed = |index| self.passed(arrival, &self.incident(index, arrival.surface.position), index);
        lights.take_while(|_| !self.patience.is_over()).map(passed).fold(Color::ONE, Color::min)
    }

    /// Returns the fraction of a light that reaches a surface, per channel.
    pub(super) fn passed(&self, arrival: &Arrival, light: &Incident, index: usize) -> Color {
        if self.effects.shadows == Shadows::None || index > 0 && self.breaks(Rule::ShadowsOfFirstLight) {
            return Color::ONE;
        }
        let surface = arrival.surface;
        let start = match self.shadow_bias() {
            Some(bias) => {
                let side = -surface.normal.dot(arrival.path_ray.leaving.ray.direction).signum();
                let origin = surface.position + side * bias * surface.normal;
                Leaving { ray: Ray::new(origin, light.direction), origin_primitive: None }
            }
            None => self.departing(RayKind::Shadow, surface, light.direction),
        };
        let passed = self.passed_along(start, surface, light, index);
        if self.breaks(Rule::ShadowsHalve) { 0.5 + 0.5 * passed } else { passed }
    }

    /// Returns the fraction of a light that a shadow ray lets pass. Where it leaves a transparent object, this is the
    /// object's colour to the power of the distance inside (Beer's law).
    ///
    /// Surfaces that contain the light's position are crossed at the light if the ray was inside an object before. So
    /// it does not matter which of them the ray hits by rounding. An opaque one blocks the light.
    fn passed_along(
        &self,
        leaving: Leaving,
        surface: &SurfacePoint,
        light: &Incident,
        index: usize,
    ) -> Color {
        let Leaving { mut ray, mut origin_primitive } = leaving;
        let is_unshadowed = self.breaks(Rule::GlassWithoutShadows);
        let at_light = self.world().primitives_at_light(index);
        let length = if self.breaks(Rule::ShadowsFromBehindLight) {
            f64::INFINITY
        } else if self.breaks(Rule::ShadowRaysHalved) {
            0.5 * light.distance
        } else {
            light.distance
        };
        // Students with an epsilon or a bias do not measure the length again.
        let ends_at_light =
            length == light.distance && self.epsilon.is_none() && self.shadow_bias().is_none();
        let ended = |ray: Ray, surface: &SurfacePoint, t_max: f64| {
            let ray = Ray { t_max, ..ray };
            if ends_at_light { ending_at_light(self.world(), index, surface, ray) } else { ray }
        };
        ray = ended(ray, surface, length);
        if self.effects.shadows == Shadows::Opaque && !is_unshadowed {
            let is_blocked = !at_light.is_empty() || self.hits.nearest(&ray, origin_primitive).is_some();
            return if is_blocked { Color::ZERO } else { Color::ONE };
        }
        let absorbed = |passed: Color, tint: Color, inside: f64| match is_unshadowed {
            true => passed,
            false => (passed * transmittance(tint, inside)).min(Color::splat(LARGEST)),
        };
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        let mut is_within = surface.normal.dot(light.direction) < 0.0;
        // The distance from the last surface to the current start of the ray.
        let mut inside = 0.0;
        for _ in 0..self.world().most_crossings() {
            let visible =
                if self.patience.is_over() { None } else { self.hits.nearest(&ray, origin_primitive) };
            let Some(visible) = visible else { break };
            let (t, crossed) = (self.hits.distance(&ray, visible), self.surface(&ray, visible));
            let is_leaving = crossed.normal.dot(ray.direction) >= 0.0;
            if at_light.iter().any(|place| place.is_crossed(visible.primitive, ray.direction, is_leaving)) {
                inside += t;
            } else {
                let tint = self.material(&crossed, &mut mixture).phong.transparent;
                if tint == Color::ZERO {
                    return Color::ZERO;
                }
                if is_leaving {
                    passed = absorbed(passed, tint, inside + t);
                }
                (is_within, inside) = (!is_leaving, 0.0);
            }
            let t_max = ray.t_max - t;
            let onwards = self.departing(RayKind::Onwards, &crossed, ray.direction);
            (ray, origin_primitive) = (ended(onwards.ray, &crossed, t_max), onwards.origin_primitive);
        }
        let tints = at_light.iter().map(|place| self.tint_at_light(place.primitive, index));
        match tints.reduce(|one, other| if other == Color::ZERO { other } else { one }) {
            Some(Color::ZERO) => Color::ZERO,
            Some(tint) if is_within => absorbed(passed, tint, inside + ray.t_max.max(0.0)),
            _ => passed,
        }
    }

    /// Returns the transparent colour of a primitive at the position of a light on it.
    fn tint_at_light(&self, primitive: u32, index: usize) -> Color {
        let world = self.world();
        let Some(&Light::Point { position, .. }) = world.lights.get(index) else { return Color::ZERO };
        let (material, mut mixture) = (world.material_of(primitive), Mixture::default());
        material_at(&world.materials, material, &position.into(), LEVEL, &mut mixture).phong.transparent
    }

    /// Returns the distance from the visible side at which shadow rays start, if a rule says so.
    fn shadow_bias(&self) -> Option<f64> {
        self.rules.iter().find_map(|rule| if let Rule::ShadowBias(bias) = rule { Some(*bias) } else { None })
    }
}
