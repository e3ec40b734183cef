//! The light of a surface towards the viewer: ambient light, and the lights that reach it.

use super::{Arrival, Student};
use crate::picture::Color;
use crate::scene::Light;
use crate::scene::model::Highlight;
use crate::shading::light::{Incident, incident};
use crate::shading::phong::{Geometry, PointMaterial, alignment};
use crate::tools::causes::rules::Rule;
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, PI};

impl Student<'_> {
    /// Returns the surface's own colour: ambient light, and the lights visible from the point.
    pub(super) fn shade(&self, arrival: &Arrival) -> Color {
        let Arrival { path_ray, surface, material } = arrival;
        let highlight = self.world().lighting.highlight;
        let is_back = surface.normal.dot(path_ray.leaving.ray.direction) > 0.0;
        let is_inside = is_back && highlight == Highlight::Blinn;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let is_flipped = if self.breaks(Rule::NormalsNotFlipped) {
            false
        } else if self.breaks(Rule::NormalsFlipped) {
            is_back
        } else {
            is_inside
        };
        let normal = if is_flipped { -surface.normal } else { surface.normal };
        let ambient = self.world().ambient * self.ambient_factor(arrival);
        let (mut color, mut is_lit, mut is_shadowed) = (ambient, false, false);
        let others = self.breaks(Rule::ShadowsOfAnyLight).then(|| self.passed_of_all(arrival));
        let is_overwritten = self.breaks_any(&[Rule::LightsOverwritten, Rule::LightsAndAmbientOverwritten]);
        for index in 0..self.world().lights.len() {
            if self.patience.is_over() {
                break;
            }
            let light = self.incident(index, surface.position);
            let cosine = normal.dot(light.direction);
            let shows = self.shows(material, &light, cosine);
            if !shows && !is_overwritten {
                continue;
            }
            let passed = others.unwrap_or_else(|| self.passed(arrival, &light, index));
            let view = Geometry { cosine, normal, to_viewer: -path_ray.leaving.ray.direction };
            let reflected = if shows { self.reflect(material, &light, index, &view) } else { Color::ZERO };
            let lit = passed * reflected;
            is_lit |= passed != Color::ZERO;
            is_shadowed |= passed == Color::ZERO;
            if passed == Color::ZERO {
                continue;
            }
            color = if self.breaks(Rule::LightsOverwritten) {
                ambient + lit
            } else if self.breaks(Rule::LightsAndAmbientOverwritten) {
                lit
            } else {
                color + self.clamped_by(Rule::LightsClamped, lit)
            };
        }
        if self.breaks(Rule::ShadowsBlack) && is_shadowed && !is_lit { Color::ZERO } else { color }
    }

    /// Returns the light that arrives at a point.
    pub(super) fn incident(&self, index: usize, point: DVec3) -> Incident {
        let light = &self.world().lights[index];
        let found = incident(light, point);
        match light {
            Light::Point { color: full, .. } if self.breaks(Rule::AttenuationTwice) => {
                let factor = found.color / *full;
                Incident {
                    color: found.color * if factor.is_finite() { factor } else { Color::ONE },
                    ..found
                }
            }
            _ => found,
        }
    }

    /// Returns true if a surface may reflect a light to the viewer.
    fn shows(&self, material: &PointMaterial, light: &Incident, cosine: f64) -> bool {
        const BEHIND: [Rule; 4] =
            [Rule::CosineAbsolute, Rule::DiffuseAbsolute, Rule::DiffuseNotClamped, Rule::HighlightsUngated];
        let shows = material.shows(self.world().lighting.highlight, light, cosine);
        shows || self.breaks_any(&BEHIND) && !material.is_black() && light.color != Color::ZERO
    }

    fn ambient_factor(&self, arrival: &Arrival) -> Color {
        let color = self.world().ambient_color(arrival.surface, arrival.material.phong.diffuse);
        if self.breaks(Rule::AmbientWithoutDiffuse) {
            Color::ONE
        } else if self.breaks(Rule::AmbientFromAbove) {
            (0.5 + 0.5 * arrival.surface.normal.y) * color
        } else {
            color
        }
    }

    /// Returns the part of a light that a surface reflects to the viewer.
    fn reflect(&self, material: &PointMaterial, light: &Incident, index: usize, view: &Geometry) -> Color {
        let length = self.length_to(light, index);
        let cosine = view.cosine * length;
        let cosine = if self.breaks(Rule::CosineAbsolute) { cosine.abs() } else { cosine };
        let lit = cosine.max(0.0);
        let diffuse = if self.breaks(Rule::DiffuseNotClamped) {
            cosine
        } else if self.breaks(Rule::DiffuseAbsolute) {
            cosine.abs()
        } else if self.breaks(Rule::DiffuseOverPi) {
            lit * FRAC_1_PI
        } else {
            lit
        };
        let alignment = self.alignment(light.direction * length, view);
        let highlights = self.highlight_strength(material, lit) * material.highlights(alignment.max(0.0));
        light.color * (material.phong.diffuse * diffuse + highlights)
    }

    /// Returns the cosine that is raised to the exponent of highlights.
    fn alignment(&self, to_light: DVec3, view: &Geometry) -> f64 {
        let highlight = self.world().lighting.highlight;
        if self.breaks(Rule::HighlightsByReflection) {
            alignment(Highlight::Phong, to_light, view)
        } else if self.breaks(Rule::HighlightsByWrongReflection) {
            (2.0 * view.cosine * (view.normal - to_light)).dot(view.to_viewer)
        } else if self.breaks(Rule::HalfWayNotNormalised) && highlight == Highlight::Blinn {
            view.normal.dot(to_light + view.to_viewer)
        } else {
            alignment(highlight, to_light, view)
        }
    }

    /// Returns the factor of a material's highlights where a light falls with this cosine, at least 0.
    fn highlight_strength(&self, material: &PointMaterial, lit: f64) -> Color {
        let exponent = material.phong.exponent;
        let is_gated = self.world().lighting.highlight == Highlight::Blinn;
        let mut strength = Color::ONE;
        if self.breaks(Rule::HighlightsTimesCosine) {
            strength *= lit;
        } else if (is_gated && !self.breaks(Rule::HighlightsUngated))
            || self.breaks(Rule::HighlightsOnlyWhereLit)
        {
            strength *= f64::from(lit > 0.0);
        }
        if self.breaks(Rule::HighlightsTimesDiffuse) {
            strength *= material.phong.diffuse;
        }
        for rule in self.rules {
            if let Rule::HighlightsNormalised(k) = rule {
                strength *= (exponent + k) / (k * PI);
            }
        }
        strength
    }

    /// Returns the length of the vector to a light. It is 1 unless a normalisation is missing.
    fn length_to(&self, light: &Incident, index: usize) -> f64 {
        match self.renderer.scene.lights.get(index) {
            Some(Light::Directional { direction, .. }) if self.breaks(Rule::DirectionsNotNormalised) => {
                direction.length()
            }
            Some(Light::Point { .. }) if self.breaks(Rule::PointDirectionsNotNormalised) => light.distance,
            _ => 1.0,
        }
    }
}
