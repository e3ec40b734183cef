//! The tracer's rules with at most one of them broken.

use super::object_space::ObjectSpaces;
use super::rules::Rule;
use crate::math::instructions::Level;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust::{offset_origin, unit};
use crate::math::rounded::RoundedPoint;
use crate::picture::Color;
use crate::scene::material::{Material, Pattern, Phong, Texture};
use crate::scene::model::{Highlight, Model};
use crate::scene::{Light, MaterialId};
use crate::shading::light::Incident;
use crate::shading::perlin::turbulence;
use crate::shading::phong::{Mixture, PointMaterial, View, alignment};
use crate::shading::texture::first_weight;
use crate::stats::{Probe, Quiet};
use crate::trace::{Departure, Path, Rules, Secondary, SecondaryRay, Tracer, reflected};
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// The rules `right`, of which at most one is broken.
pub struct Mistaken<'a, R> {
    pub right: &'a R,
    pub rule: Option<Rule>,
    pub spaces: &'a ObjectSpaces<'a>,
    /// The lights as the scene has them.
    pub lights: &'a [Light],
}

impl<R: Rules> Mistaken<'_, R> {
    fn breaks(&self, rule: Rule) -> bool {
        self.rule == Some(rule)
    }

    fn clamped_by(&self, rule: Rule, color: Color) -> Color {
        if self.breaks(rule) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }

    /// The weight of a texture's first child at a point.
    fn first_weight(&self, texture: &Texture, point: &RoundedPoint) -> f64 {
        let in_texture = || texture.world_to_texture.map.transform_point3(point.position);
        match (self.rule, texture.pattern) {
            (Some(Rule::CheckerboardCut), Pattern::Checkerboard) => {
                // The coordinates are cut to whole numbers, towards zero.
                let cells = in_texture().to_array().map(|q| q as i64);
                f64::from(cells.iter().filter(|&cell| cell % 2 != 0).count() % 2 == 0)
            }
            (Some(Rule::NoiseHalved), Pattern::Noise { octaves }) => {
                (0.5 * turbulence(in_texture(), octaves, Level::baseline()) + 0.5).clamp(0.0, 1.0)
            }
            _ => first_weight(texture, point, Level::baseline()),
        }
    }

    /// The mixture of a material's parts at a point. A texture passes its weight on to its children, which come before
    /// it.
    fn mix(&self, id: MaterialId, point: &RoundedPoint, mixture: &mut Mixture) {
        let mut weights = vec![0.0; id + 1];
        weights[id] = 1.0;
        let mut is_empty = true;
        for (id, material) in self.world().materials[..=id].iter().enumerate().rev() {
            match (material, weights[id]) {
                (_, 0.0) => {}
                (Material::Phong(phong) | Material::Painted(phong, _), weight) if is_empty => {
                    mixture.start(phong, weight);
                    is_empty = false;
                }
                (Material::Phong(phong) | Material::Painted(phong, _), weight) => mixture.add(phong, weight),
                (Material::Texture(texture), weight) => {
                    let first = self.first_weight(texture, point);
                    weights[texture.children[0]] += weight * first;
                    weights[texture.children[1]] += weight * (1.0 - first);
                }
            }
        }
    }

    /// How long the vector to a light is that has not been divided by its length.
    fn length_to(&self, light: &Incident, index: usize) -> f64 {
        match (self.rule, self.lights.get(index)) {
            (Some(Rule::DirectionsNotNormalised), Some(Light::Directional { direction, .. })) => {
                direction.length()
            }
            (Some(Rule::PointDirectionsNotNormalised), Some(Light::Point { .. })) => light.distance,
            _ => 1.0,
        }
    }
}

/// A ray that starts on the other side of the surface, and so meets it at once.
pub fn from_other_side(surface: &SurfacePoint, direction: DVec3) -> (Ray, Option<u32>) {
    let origin = offset_origin(surface.position, surface.normal, -direction, surface.extent);
    (Ray::new(origin, direction), None)
}

/// The colour along a camera ray.
pub fn color<R: Rules>(tracer: &Tracer<Mistaken<R>>, ray: &Ray) -> Color {
    let camera_ray = SecondaryRay { ray: *ray, leaves: None, path: Path::CAMERA };
    tracer.rules.clamped_by(Rule::SamplesClamped, seen(tracer, &camera_ray))
}

/// The colour along a ray. The colours of secondary rays are added up ray by ray, not all at once, since some mistakes
/// happen there.
fn seen<R: Rules>(tracer: &Tracer<Mistaken<R>>, SecondaryRay { ray, leaves, path }: &SecondaryRay) -> Color {
    let visible = tracer.nearest(ray, *leaves, &mut Quiet);
    let surface = visible.map(|visible| tracer.rules.surface(ray, visible));
    let mut branches = vec![];
    let mut color = tracer.local_color(ray, path, surface, &mut branches, &mut Quiet);
    while let Some(mut branch) = branches.pop() {
        let tint = std::mem::replace(&mut branch.path.filter, Color::ONE);
        color = tracer.rules.sum(color, tint * seen(tracer, &branch));
    }
    tracer.rules.clamped_by(Rule::RaysClamped, color)
}

impl<R: Rules> Rules for Mistaken<'_, R> {
    fn world(&self) -> &World {
        self.right.world()
    }

    fn nearest<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> Option<Visible> {
        self.right.nearest(ray, leaves, probe)
    }

    fn hit(&self, ray: &Ray, visible: Visible) -> Hit {
        self.right.hit(ray, visible)
    }

    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.right.surface(ray, visible);
        let object_normal = || self.spaces.normal(visible.primitive, surface.normal);
        let normal = match self.rule {
            Some(Rule::NormalsByMatrix) => unit(self.spaces.matrix(visible.primitive) * object_normal()),
            Some(Rule::NormalsOfObjectSpace) => unit(object_normal()),
            _ => return surface,
        };
        if normal.is_finite() { SurfacePoint { normal, ..surface } } else { surface }
    }

    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let is_textured = matches!(self.world().materials[surface.material], Material::Texture(_));
        match self.rule {
            Some(Rule::CheckerboardCut | Rule::NoiseHalved) if is_textured => {
                self.world().with_rounded_point(surface, |point| self.mix(surface.material, point, mixture));
                mixture.material()
            }
            _ => self.right.material(surface, mixture),
        }
    }

    fn model(&self) -> Model {
        self.right.model()
    }

    fn background(&self, direction: DVec3, bounces: u32) -> Color {
        let is_missing = bounces > 0 && self.breaks(Rule::BackgroundForCameraOnly);
        if is_missing {
            Color::ZERO
        } else {
            self.sum(Color::ZERO, self.right.background(direction, bounces))
        }
    }

    fn departing(&self, why: Departure, surface: &SurfacePoint, direction: DVec3) -> (Ray, Option<u32>) {
        match (self.rule, why) {
            (Some(Rule::Epsilon { distance: t_min } | Rule::SmallerEpsilon { distance: t_min }), _) => {
                (Ray { t_min, ..Ray::new(surface.position, direction) }, surface.triangle)
            }
            (Some(Rule::ReflectionFromBelow), Departure::Secondary(Secondary::Reflected)) => {
                from_other_side(surface, direction)
            }
            (Some(Rule::NoEpsilon { rays }), _) if rays.includes(why) => from_other_side(surface, direction),
            _ => self.right.departing(why, surface, direction),
        }
    }

    fn shadow_end(&self, distance: f64) -> f64 {
        if self.breaks(Rule::ShadowsFromBehindLight) { f64::INFINITY } else { distance }
    }

    fn reflected(&self, direction: DVec3, normal: DVec3) -> DVec3 {
        match self.rule {
            Some(Rule::NormalFlippedInReflection) => {
                (direction + 2.0 * direction.dot(normal) * normal).normalize()
            }
            Some(Rule::ReflectionReversed) => -reflected(direction, normal),
            _ => reflected(direction, normal),
        }
    }

    fn mirrored(&self, part: f64) -> f64 {
        // All is mirrored at what is opaque, and where nothing is refracted.
        if self.breaks(Rule::SchlickSwapped) && part < 1.0 { 1.0 - part } else { part }
    }

    fn filter(&self, kind: Secondary, color: Color) -> Color {
        match (self.rule, kind) {
            (Some(Rule::ReflectionWithoutColor), Secondary::Reflected)
            | (Some(Rule::RefractionWithoutColor), Secondary::Refracted) => Color::ONE,
            _ => color,
        }
    }

    fn indices(&self, around: f64, material: &Phong, is_entering: bool) -> [f64; 2] {
        if !is_entering && self.breaks(Rule::IndexNotInverted) {
            return [1.0, material.index_of_refraction];
        }
        self.right.indices(around, material, is_entering)
    }

    fn totally_reflected(&self, direction: DVec3, normal: DVec3) -> Option<DVec3> {
        self.breaks(Rule::TotalReflectionAdded).then(|| reflected(direction, normal))
    }

    fn is_blocked<P: Probe>(&self, ray: &Ray, leaves: Option<u32>, probe: &mut P) -> bool {
        let (mut ray, mut leaves) = (*ray, leaves);
        let mut mixture = Mixture::default();
        for _ in 0..self.world().most_crossings() {
            let Some(visible) = self.nearest(&ray, leaves, probe) else { return false };
            if !self.breaks(Rule::GlassWithoutShadows) {
                return true;
            }
            let (hit, surface) = (self.hit(&ray, visible), self.surface(&ray, visible));
            if self.material(&surface, &mut mixture).phong.transparent == Color::ZERO {
                return true;
            }
            let t_max = ray.t_max - hit.t;
            (ray, leaves) = self.departing(Departure::Onwards, &surface, ray.direction);
            ray.t_max = t_max;
        }
        false
    }

    fn transmittance(&self, tint: Color, way: f64) -> Color {
        if self.breaks(Rule::GlassWithoutShadows) { Color::ONE } else { self.right.transmittance(tint, way) }
    }

    fn shading_normal(&self, normal: DVec3, direction: DVec3, is_inside: bool) -> DVec3 {
        match self.rule {
            Some(Rule::NormalsNotFlipped) => normal,
            Some(Rule::NormalsFlipped) if normal.dot(direction) > 0.0 => -normal,
            _ => self.right.shading_normal(normal, direction, is_inside),
        }
    }

    fn ambient(&self, surface: &SurfacePoint, material: &Phong) -> Color {
        if self.breaks(Rule::AmbientWithoutDiffuse) {
            self.world().ambient
        } else {
            self.right.ambient(surface, material)
        }
    }

    fn reflect(&self, material: &PointMaterial, (light, index): (&Incident, usize), view: &View) -> Color {
        let View { cosine, normal, .. } = *view;
        let to_light = light.direction * self.length_to(light, index);
        let (highlight, strength) = match self.rule {
            Some(Rule::HighlightsByReflection) => (Highlight::Phong, 1.0),
            Some(Rule::HighlightsTimesCosine) => (self.model().highlight, cosine.max(0.0)),
            Some(Rule::HighlightsOnlyWhereLit) => (self.model().highlight, f64::from(cosine > 0.0)),
            Some(Rule::DirectionsNotNormalised | Rule::PointDirectionsNotNormalised) => {
                (self.model().highlight, 1.0)
            }
            _ => return self.right.reflect(material, (light, index), view),
        };
        let highlights = strength * material.highlights(alignment(highlight, to_light, view).max(0.0));
        light.color * (normal.dot(to_light).max(0.0) * material.phong.diffuse + highlights)
    }

    fn light(&self, color: Color) -> Color {
        self.clamped_by(Rule::LightsClamped, color)
    }

    fn sum(&self, one: Color, other: Color) -> Color {
        match self.rule {
            Some(Rule::SinglePrecision) => (one.as_vec3() + other.as_vec3()).as_dvec3(),
            _ => one + other,
        }
    }
}
