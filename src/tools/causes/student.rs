//! The student's tracer: Whitted's recursion as in a textbook, one ray at a time, with a switch for each rule.
//!
//! It uses the tracer's own functions for the laws of light. A broken rule is a switch around a call. Without one the
//! colours equal the tracer's. Rays are intersected through a trait, so it runs with a caster or by brute force, in
//! single or double precision.

use super::rules::{Rule, Rules};
use super::wrong_textures::first_weight;
use crate::base::patience::{Endless, Patience};
use crate::caster::{Caster, RayOrigin};
use crate::math::instructions::Level;
use crate::math::ray::{Ray, Visible};
use crate::math::robust::{offset_origin, unit};
use crate::picture::Color;
use crate::render::renderer::Renderer;
use crate::scene::limits::{BRIGHTEST, LARGEST};
use crate::scene::material::{Material, Phong, Texture};
use crate::scene::model::{Highlight, Split};
use crate::scene::{Light, MaterialId, Object};
use crate::shading::light::{Incident, incident};
use crate::shading::phong::{Geometry, Mixture, PointMaterial, alignment};
use crate::shading::texture::{each_part, material_at, material_of_surface};
use crate::trace::{
    Effects, Shadows, ending_at_light, mirrored_part, reflected, refracted_between, transmittance,
};
use crate::world::{Objects, Primitive, SurfacePoint, World};
use glam::{DMat3, DVec3};
use serde::Serialize;
use std::f64::consts::{FRAC_1_PI, PI};

/// How a ray leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    Reflected,
    Refracted,
    Shadow,
    /// Towards a light, after crossing a transparent surface.
    Onwards,
}

/// The rays that hit the surface that they leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SelfHitting {
    /// Rays to lights.
    Shadow,
    /// Reflected and refracted rays.
    Secondary,
    /// All rays.
    All,
}

impl SelfHitting {
    /// Returns true if rays that leave a surface that way are among these.
    pub(super) fn has(self, departure: Departure) -> bool {
        match departure {
            Departure::Shadow => self != Self::Secondary,
            Departure::Reflected | Departure::Refracted => self != Self::Shadow,
            Departure::Onwards => false,
        }
    }
}

/// Deeper recursion is not tried, because it could overflow the stack.
pub(crate) const MAX_BOUNCES: u32 = 100;

/// A ray from a surface, and the primitive that it cannot hit again.
type Start = (Ray, Option<u32>);

/// Finds the hits of rays.
pub trait Hits: Sync {
    /// The world that is hit.
    fn world(&self) -> &World;

    /// Returns the nearest hit of a ray that leaves the primitive `leaves`. The ray cannot hit it again unless it is
    /// round.
    fn nearest(&self, ray: &Ray, leaves: Option<u32>) -> Option<Visible>;

    /// Returns the t of a ray's nearest hit.
    fn distance(&self, ray: &Ray, visible: Visible) -> f64 {
        self.world().hit(ray, visible).t
    }

    /// Returns the surface at a ray's nearest hit, with its shading normal.
    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.world().visible_surface(ray, visible);
        let normal = self.world().smooth_normal(&surface).unwrap_or(surface.normal);
        SurfacePoint { normal, ..surface }
    }
}

impl Hits for Caster<'_> {
    fn world(&self) -> &World {
        self.world
    }

    fn nearest(&self, ray: &Ray, leaves: Option<u32>) -> Option<Visible> {
        Caster::nearest(self, ray, RayOrigin::on(self.world, leaves))
    }
}

/// Returns true if a ray that leaves a surface in a direction hits it again.
pub type HitsItself<'a> = &'a (dyn Fn(Departure, &SurfacePoint, DVec3) -> bool + Sync);

/// A tracer that breaks some rules.
#[derive(Clone, Copy)]
pub struct Student<'a> {
    pub renderer: &'a Renderer,
    pub hits: &'a dyn Hits,
    pub effects: Effects,
    pub rules: Rules,
    /// The objects of the world. Rules about normals need them.
    pub objects: Option<&'a Objects>,
    /// The rays that hit the surface that they leave, if not the rule's.
    pub hits_itself: Option<HitsItself<'a>>,
    /// An epsilon in place of the scene's.
    pub epsilon: Option<f64>,
    /// Ends the work early. Colours are unspecified then.
    pub patience: &'a dyn Patience,
}

/// A ray and its history since the camera.
struct PathRay {
    ray: Ray,
    /// The primitive that the ray leaves.
    leaves: Option<u32>,
    /// The product of the lengths of the colours along the path.
    weight: f64,
    bounces: u32,
    /// The index of refraction of the surrounding medium.
    index: f64,
}

/// A surface where a ray arrives.
struct Arrival<'m> {
    path_ray: &'m PathRay,
    surface: &'m SurfacePoint,
    material: PointMaterial<'m>,
}

impl<'a> Student<'a> {
    /// Returns a tracer that breaks no rule.
    pub fn new(renderer: &'a Renderer, hits: &'a dyn Hits, effects: Effects) -> Self {
        let rules = Rules::default();
        let (objects, hits_itself, epsilon, patience) = (None, None, None, &Endless);
        Self { renderer, hits, effects, rules, objects, hits_itself, epsilon, patience }
    }

    fn breaks(&self, rule: Rule) -> bool {
        self.rules.has(rule)
    }

    fn world(&self) -> &World {
        self.hits.world()
    }

    /// Returns the colour along a ray from the camera.
    pub fn color(&self, ray: &Ray) -> Color {
        let path_ray = PathRay { ray: *ray, leaves: None, weight: 1.0, bounces: 0, index: 1.0 };
        self.clamped_by(Rule::SamplesClamped, self.trace(&path_ray))
    }

    /// Returns the distance and the surface of a camera ray's nearest hit.
    pub fn seen(&self, ray: &Ray) -> Option<(f64, SurfacePoint)> {
        let visible = self.hits.nearest(ray, None)?;
        Some((self.hits.distance(ray, visible), self.surface(ray, visible)))
    }

    /// Returns the colour along a ray: the surface's own colour, plus the colours of the refracted and mirrored rays.
    fn trace(&self, path_ray: &PathRay) -> Color {
        // One camera ray may cause more rays than can ever be traced.
        if self.patience.is_over() {
            return Color::ZERO;
        }
        let color = match self.hits.nearest(&path_ray.ray, path_ray.leaves) {
            Some(visible) => {
                let surface = &self.surface(&path_ray.ray, visible);
                let mut mixture = Mixture::default();
                let material = self.material(surface, &mut mixture);
                let arrival = Arrival { path_ray, surface, material };
                let own = self.shade(&arrival);
                let [refracted, mirrored] = self.branches(&arrival);
                if self.rules.has_any(&[Rule::ReflectionBlended, Rule::RefractionBlended]) {
                    let own = self.blended(Rule::ReflectionBlended, own, mirrored);
                    self.blended(Rule::RefractionBlended, own, refracted)
                } else {
                    let both = [refracted, mirrored].into_iter().flatten();
                    both.fold(own, |sum, (tint, path_ray)| sum + tint * self.trace(&path_ray))
                }
            }
            None if path_ray.bounces > 0 && self.breaks(Rule::BackgroundForCameraOnly) => Color::ZERO,
            None => self.world().background_along(path_ray.ray.direction),
        };
        self.clamped_by(Rule::RaysClamped, color)
    }

    /// Adds the colour of a secondary ray. If the rule is broken, the colour so far is multiplied by 1 minus its factor.
    fn blended(&self, rule: Rule, color: Color, branch: Option<(Color, PathRay)>) -> Color {
        let Some((tint, path_ray)) = branch else { return color };
        let part = if self.breaks(rule) { 1.0 - tint } else { Color::ONE };
        part * color + tint * self.trace(&path_ray)
    }

    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.hits.surface(ray, visible);
        let Some(objects) = self.objects.filter(|_| !self.rules.is_empty()) else { return surface };
        let matrix = objects.of(visible.primitive).matrix.matrix3;
        let normal = self.wrong_normal(surface.normal, visible.primitive, matrix);
        if normal.is_finite() { SurfacePoint { normal, ..surface } } else { surface }
    }

    /// Returns the normal that broken rules give a primitive with this unit normal and this transform.
    fn wrong_normal(&self, normal: DVec3, primitive: u32, matrix: DMat3) -> DVec3 {
        // The inverse transpose transforms normals to world space.
        let of_object = matrix.transpose() * normal;
        let is_placed_as_written = matrix == DMat3::IDENTITY;
        if self.breaks(Rule::NormalsNeverNormalised) {
            let object = self.objects.map(|objects| &self.renderer.scene.objects[objects.of(primitive).id]);
            // In the sphere's own space.
            let radius = if let Some(&Object::Sphere { radius, .. }) = object { radius } else { 1.0 };
            return radius * normal / of_object.length();
        }
        let (is_sphere, is_triangle) =
            (self.world().is_shape(primitive), self.world().is_triangle(primitive));
        let is_reversed = self.breaks(Rule::SphereNormalsInward) && is_sphere
            || self.breaks(Rule::WindingReversed) && is_triangle;
        if self.breaks(Rule::NormalsByMatrix) {
            unit(matrix * of_object)
        } else if self.breaks(Rule::NormalsByInverse) {
            unit(matrix.inverse() * of_object)
        } else if self.breaks(Rule::NormalsOfObjectSpace) {
            unit(of_object)
        } else if self.breaks(Rule::NormalsNotNormalised) {
            normal / of_object.length()
        } else if self.breaks(Rule::SphereNormalsNotNormalised) && is_sphere && is_placed_as_written {
            0.5 * self.world().box_of(primitive).extent().x * normal
        } else if is_reversed {
            -normal
        } else if self.breaks(Rule::TriangleNormalsNotNormalised)
            && is_placed_as_written
            && let Primitive::Triangle(triangle) = self.world().primitive(primitive)
        {
            let [a, b, c] = self.world().corners(triangle);
            (b - a).cross(c - a).length() * normal
        } else {
            normal
        }
    }

    /// Returns the material of a surface, with its textures evaluated at the point.
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let is_texture = matches!(self.world().materials[surface.material], Material::Texture(_));
        if is_texture && self.rules.has_any(&super::wrong_textures::RULES) {
            self.mix(surface.material, surface.position, mixture);
            return mixture.material();
        }
        material_of_surface(self.world(), surface, LEVEL, mixture)
    }

    /// Mixes a material's parts at a point.
    fn mix(&self, id: MaterialId, point: DVec3, mixture: &mut Mixture) {
        let mut weights = vec![0.0; id + 1];
        weights[id] = 1.0;
        mixture.start(&Phong::default(), 0.0);
        let first = |_, texture: &Texture| first_weight(self.rules, texture, point);
        each_part(&self.world().materials[..=id], &mut weights, first, |_, phong, weight| {
            mixture.add(phong, weight);
        });
    }

    /// Returns the surface's own colour: ambient light, and the lights visible from the point.
    fn shade(&self, arrival: &Arrival) -> Color {
        let Arrival { path_ray, surface, material } = arrival;
        let highlight = self.world().lighting.highlight;
        let is_back = surface.normal.dot(path_ray.ray.direction) > 0.0;
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
        let is_overwritten =
            self.rules.has_any(&[Rule::LightsOverwritten, Rule::LightsAndAmbientOverwritten]);
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
            let view = Geometry { cosine, normal, to_viewer: -path_ray.ray.direction };
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
    fn incident(&self, index: usize, point: DVec3) -> Incident {
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
        shows || self.rules.has_any(&BEHIND) && !material.is_black() && light.color != Color::ZERO
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
        if self.breaks(Rule::HighlightsNormalisedPhong) {
            strength *= (exponent + 2.0) / (2.0 * PI);
        }
        if self.breaks(Rule::HighlightsNormalisedBlinn) {
            strength *= (exponent + 8.0) / (8.0 * PI);
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

    /// Returns the smallest fraction of any light that reaches a surface.
    fn passed_of_all(&self, arrival: &Arrival) -> Color {
        let lights = 0..self.world().lights.len();
        let passed = |index| self.passed(arrival, &self.incident(index, arrival.surface.position), index);
        lights.take_while(|_| !self.patience.is_over()).map(passed).fold(Color::ONE, Color::min)
    }

    /// Returns the fraction of a light that reaches a surface, per channel.
    fn passed(&self, arrival: &Arrival, light: &Incident, index: usize) -> Color {
        if self.effects.shadows == Shadows::None || index > 0 && self.breaks(Rule::ShadowsOfFirstLight) {
            return Color::ONE;
        }
        let surface = arrival.surface;
        let start = match self.shadow_bias() {
            Some(bias) => {
                let side = -surface.normal.dot(arrival.path_ray.ray.direction).signum();
                (Ray::new(surface.position + side * bias * surface.normal, light.direction), None)
            }
            None => self.departing(Departure::Shadow, surface, light.direction),
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
        (mut ray, mut leaves): Start,
        surface: &SurfacePoint,
        light: &Incident,
        index: usize,
    ) -> Color {
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
            let is_blocked = !at_light.is_empty() || self.hits.nearest(&ray, leaves).is_some();
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
            let visible = if self.patience.is_over() { None } else { self.hits.nearest(&ray, leaves) };
            let Some(visible) = visible else { break };
            let (t, crossed) = (self.hits.distance(&ray, visible), self.surface(&ray, visible));
            let is_left = crossed.normal.dot(ray.direction) >= 0.0;
            if at_light.iter().any(|place| place.is_crossed(visible.primitive, ray.direction, is_left)) {
                inside += t;
            } else {
                let tint = self.material(&crossed, &mut mixture).phong.transparent;
                if tint == Color::ZERO {
                    return Color::ZERO;
                }
                if is_left {
                    passed = absorbed(passed, tint, inside + t);
                }
                (is_within, inside) = (!is_left, 0.0);
            }
            let t_max = ray.t_max - t;
            (ray, leaves) = self.departing(Departure::Onwards, &crossed, ray.direction);
            ray = ended(ray, &crossed, t_max);
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

    /// Returns the refracted and the mirrored ray, each with the factor of its colour, if they are followed.
    fn branches(&self, arrival: &Arrival) -> [Option<(Color, PathRay)>; 2] {
        let Arrival { path_ray, surface, material } = arrival;
        let (direction, normal) = (path_ray.ray.direction, surface.normal);
        let cosine = direction.dot(normal);
        let is_entering = cosine < 0.0;
        // In front of the surface and behind it.
        let indices = match is_entering {
            true => [path_ray.index, material.phong.index_of_refraction],
            false if self.breaks(Rule::IndexNotInverted) => [1.0, material.phong.index_of_refraction],
            false => [path_ray.index, 1.0],
        };
        let Phong { mut reflective, mut transparent, .. } = *material.phong;
        // An opaque surface mirrors all light.
        if self.world().lighting.split == Split::Schlick && transparent != Color::ZERO {
            let part = mirrored_part(cosine.abs(), indices);
            // At total internal reflection nothing is refracted.
            let part = if self.breaks(Rule::SchlickSwapped) && part < 1.0 { 1.0 - part } else { part };
            reflective *= part;
            transparent *= 1.0 - part;
        }
        let next = |why, direction, weight, index| {
            let (ray, leaves) = self.departing(why, surface, direction);
            PathRay { ray, leaves, weight, bounces: path_ray.bounces + 1, index }
        };
        let is_turned = !is_entering && !self.breaks(Rule::NormalNotFlippedInRefraction);
        let against = if is_turned { -normal } else { normal };
        let sine = || {
            // An interpolated normal differs from the triangle's.
            let is_smooth = self.world().has_smooth_normals() && surface.triangle.is_some();
            let primitive = surface.primitive.filter(|_| !is_smooth);
            self.world().precise_sine((path_ray.ray.origin, direction), primitive, normal)
        };
        let bent = refracted_between(direction, against, indices, sine);
        let is_total = bent.is_none() && transparent != Color::ZERO;
        let refracted = self.weight(path_ray, transparent).and_then(|weight| {
            let (direction, index) = match bent {
                Some(refracted) => (refracted, if is_entering { indices[1] } else { 1.0 }),
                None if self.breaks(Rule::TotalReflectionAdded) => {
                    (reflected(direction, normal), path_ray.index)
                }
                None if self.breaks(Rule::TotalReflectionStraight) => (direction, 1.0),
                None => return None,
            };
            let tint = self.tint(transparent, Rule::RefractionWithoutColor);
            Some((tint, next(Departure::Refracted, direction, weight, index)))
        });
        let is_dropped = is_total && self.breaks(Rule::TotalReflectionDropped);
        let mirrored = self.weight(path_ray, reflective).filter(|_| !is_dropped).map(|weight| {
            let direction = if self.breaks(Rule::NormalFlippedInReflection) {
                reflected_by_sum(direction, normal)
            } else if self.breaks(Rule::ReflectionReversed) {
                -reflected(direction, normal)
            } else {
                reflected(direction, normal)
            };
            let tint = self.tint(reflective, Rule::ReflectionWithoutColor);
            (tint, next(Departure::Reflected, direction, weight, path_ray.index))
        });
        [refracted, mirrored]
    }

    /// Returns the weight of a secondary ray of this colour, if it is followed.
    fn weight(&self, path_ray: &PathRay, color: Color) -> Option<f64> {
        let weight = path_ray.weight * color.length();
        (path_ray.bounces < self.effects.bounces && weight > self.effects.min_weight).then_some(weight)
    }

    /// Returns the factor of a secondary ray's colour.
    fn tint(&self, color: Color, untinted: Rule) -> Color {
        let bound = Color::splat(BRIGHTEST);
        if self.breaks(untinted) { Color::ONE } else { color.clamp(-bound, bound) }
    }

    /// Returns a ray that leaves a surface: it starts a few roundings off, on the side to which it goes.
    fn departing(&self, why: Departure, surface: &SurfacePoint, direction: DVec3) -> Start {
        let off = |side| offset_origin(surface.position, surface.normal, side * direction, surface.extent);
        let is_from_below = self.breaks(Rule::ReflectionFromBelow) && why == Departure::Reflected;
        let hits_itself = match self.hits_itself {
            Some(hits_itself) => hits_itself(why, surface, direction),
            None => self_hitting(self.rules).is_some_and(|rays| rays.has(why)),
        };
        match self.epsilon.or(self.world().lighting.epsilon) {
            // On the other side of the surface, the ray hits it at once.
            _ if is_from_below || hits_itself => (Ray::new(off(-1.0), direction), None),
            Some(epsilon) => (Ray { t_min: epsilon, ..Ray::new(surface.position, direction) }, None),
            None => (Ray::new(off(1.0), direction), surface.primitive),
        }
    }

    /// Returns the distance from the visible side at which shadow rays start, if a rule says so.
    fn shadow_bias(&self) -> Option<f64> {
        const BIASES: [(Rule, f64); 3] = [
            (Rule::ShadowBiasThousandth, 0.001),
            (Rule::ShadowBiasHundredth, 0.01),
            (Rule::ShadowBiasTenth, 0.1),
        ];
        BIASES.into_iter().find(|&(rule, _)| self.breaks(rule)).map(|(_, bias)| bias)
    }

    fn clamped_by(&self, rule: Rule, color: Color) -> Color {
        if self.breaks(rule) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }
}

/// Returns the rays that hit the surface that they leave by a rule.
fn self_hitting(rules: Rules) -> Option<SelfHitting> {
    let all = [
        (Rule::NoEpsilonOfShadows, SelfHitting::Shadow),
        (Rule::NoEpsilonOfSecondary, SelfHitting::Secondary),
        (Rule::NoEpsilon, SelfHitting::All),
    ];
    all.into_iter().find(|&(rule, _)| rules.has(rule)).map(|(_, rays)| rays)
}

/// Textures give the same bytes with all instruction sets.
pub const LEVEL: Level = Level::baseline();

/// Returns d + 2 (d.n) n instead of the mirrored direction d - 2 (d.n) n.
fn reflected_by_sum(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction + 2.0 * direction.dot(normal) * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::tests::Counted;
    use crate::render::Request;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::render::test_renderer::renderer_of;
    use crate::scene::load::load;
    use crate::trace::{Quiet, RayStack, Tracer};
    use glam::DVec2;
    use std::fs;
    use std::path::{Path, PathBuf};

    /// Returns the project's scenes, including other editions.
    fn scenes() -> Vec<PathBuf> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let files = |folder: PathBuf| fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        let all = files(folder.clone()).chain(files(folder.join("editions")));
        let is_scene = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "txt");
        all.filter(is_scene).collect()
    }

    #[test]
    fn rays_that_split_without_end_end_with_the_patience() {
        let text = "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 40 }
            Lights { numLights 1 DirectionalLight { direction -1 -1 -1 color 1 1 1 } }
            Group { numObjects 2 Material { reflectiveColor 1 1 1 transparentColor 1 1 1 indexOfRefraction 1.5 }
            Sphere { center 0 0 0 radius 10 } Sphere { center 0 0 0 radius 5.5 } }";
        let renderer = renderer_of(text);
        let request = Request::new([4, 4]);
        let prepared = renderer.prepare(&request).unwrap();
        let caster = prepared.caster(&Endless).unwrap();
        let effects =
            Effects { shadows: Shadows::Transparent, bounces: 90, min_weight: 0.0, shade_back: true };
        let patience = &Counted::up_to(10_000);
        let student = Student { patience, ..Student::new(&renderer, &caster, effects) };
        let _ = student.color(&renderer.camera(&request).ray(DVec2::ONE, DVec2::ZERO));
        assert!((10_000..40_000).contains(&patience.asked()), "{}", patience.asked());
    }

    #[test]
    fn without_a_mistake_colours_are_those_of_the_tracer() {
        let opaque = Effects { shadows: Shadows::Opaque, bounces: 4, min_weight: 0.1, shade_back: false };
        let tinted = Effects { shadows: Shadows::Transparent, bounces: 3, min_weight: 0.0, shade_back: true };
        let scenes = scenes();
        assert!(scenes.len() > 60);
        for path in scenes {
            let renderer = Renderer::new(load(&path).unwrap(), Meshes::Kept).unwrap();
            let request = Request::new([24, 18]);
            let prepared = renderer.prepare(&request).unwrap();
            let caster = prepared.caster(&Endless).unwrap();
            let camera = renderer.camera(&request);
            for effects in [Effects::default(), opaque, tinted] {
                let hits = &caster;
                let student = Student::new(&renderer, hits, effects);
                let tracer = Tracer::new(hits, effects);
                for (x, y) in (0..24).flat_map(|x| (0..18).map(move |y| (x, y))) {
                    let ray = camera.ray(DVec2::new(x.into(), y.into()), DVec2::ZERO);
                    let (own, expected) =
                        (student.color(&ray), tracer.color(&ray, &mut RayStack::default(), &mut Quiet));
                    let far = (own - expected).abs().max_element() / expected.abs().max_element().max(1.0);
                    assert!(far < 1e-9, "{} {effects:?} {x} {y}: {own} {expected}", path.display());
                }
            }
        }
    }
}
