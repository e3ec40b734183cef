//! A recursive ray tracer as in a textbook, which can break a rule. It is not fast.

use super::finder::{Finder, Found};
use super::object_space::ObjectSpaces;
use super::rules::Rule;
use crate::math::instructions::Instructions;
use crate::math::ray::Ray;
use crate::math::robust::{offset_origin, unit};
use crate::scene::material::{Material, Pattern, Texture};
use crate::scene::{Color, MaterialId};
use crate::shading::light::{Incident, incident};
use crate::shading::phong::{Mixture, PointMaterial};
use crate::shading::texture::material_at;
use crate::trace::{Effects, Shadows, reflected, refracted_between, transmittance};
use crate::world::SurfacePoint;
use glam::DVec3;

/// Traces rays, and breaks at most one rule.
pub struct Textbook<'a, F> {
    pub finder: &'a F,
    pub effects: Effects,
    pub rule: Option<Rule>,
    pub spaces: &'a ObjectSpaces<'a>,
}

/// A ray on its way from the camera.
struct Path {
    ray: Ray,
    /// The triangle that it starts at.
    exclude: Option<u32>,
    weight: f64,
    bounces: u32,
    /// Index of refraction of what the ray runs through.
    index: f64,
}

impl<F: Finder> Textbook<'_, F> {
    /// The colour along a camera ray.
    pub fn color(&self, ray: &Ray) -> Color {
        let path = Path { ray: *ray, exclude: None, weight: 1.0, bounces: 0, index: 1.0 };
        self.clamped_by(Rule::SamplesClamped, self.seen(&path))
    }

    fn breaks(&self, rule: Rule) -> bool {
        self.rule == Some(rule)
    }

    fn clamped_by(&self, rule: Rule, color: Color) -> Color {
        if self.breaks(rule) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }

    /// A result in the precision of the computation.
    fn number(&self, color: Color) -> Color {
        if self.breaks(Rule::SinglePrecision) { color.as_vec3().as_dvec3() } else { color }
    }

    /// The colour along a ray.
    fn seen(&self, path: &Path) -> Color {
        let Some(surface) = self.nearest(path) else {
            return self.clamped_by(Rule::RaysClamped, self.background(path));
        };
        let mut mixture = Mixture::default();
        let material = self.material(&surface, &mut mixture);
        let mut color = self.shade(path, &surface, &material);
        if path.bounces < self.effects.bounces {
            let branches = [self.refract(path, &surface, &material), self.reflect(path, &surface, &material)];
            for (tint, branch) in branches.into_iter().flatten() {
                color = self.number(color + self.number(self.number(tint) * self.seen(&branch)));
            }
        }
        self.clamped_by(Rule::RaysClamped, color)
    }

    fn background(&self, path: &Path) -> Color {
        let is_missing = path.bounces > 0 && self.breaks(Rule::BackgroundForCameraOnly);
        if is_missing { Color::ZERO } else { self.number(self.finder.world().background) }
    }

    fn nearest(&self, path: &Path) -> Option<SurfacePoint> {
        let Found { primitive, surface, .. } = self.finder.nearest(&path.ray, path.exclude)?;
        let object_normal = || self.spaces.normal(primitive, surface.normal);
        let normal = match self.rule {
            Some(Rule::NormalsByMatrix) => unit(self.spaces.matrix(primitive) * object_normal()),
            Some(Rule::NormalsOfObjectSpace) => unit(object_normal()),
            _ => return Some(surface),
        };
        Some(if normal.is_finite() { SurfacePoint { normal, ..surface } } else { surface })
    }

    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let world = self.finder.world();
        let materials = &world.materials;
        // The bytes are the same with all of them.
        let instructions = Instructions::Portable;
        world.with_rounded_point(surface, |point| {
            let material = match &materials[surface.material] {
                Material::Texture(texture)
                    if texture.pattern == Pattern::Checkerboard && self.breaks(Rule::CheckerboardCut) =>
                {
                    child_by_cutting(texture, point.position)
                }
                _ => surface.material,
            };
            material_at(materials, material, point, instructions, mixture)
        })
    }

    fn shade(&self, path: &Path, surface: &SurfacePoint, material: &PointMaterial) -> Color {
        let from_within = surface.normal.dot(path.ray.direction) > 0.0;
        if from_within && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if from_within { -surface.normal } else { surface.normal };
        let world = self.finder.world();
        let mut color = self.number(self.number(world.ambient) * self.number(material.phong.diffuse));
        for (index, light) in world.lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            if cosine > 0.0 {
                let passed = self.light_passed(surface, &light, index);
                let light = Incident { color: self.number(light.color), ..light };
                let lit = self.number(passed * material.reflect(&light, cosine, normal, -path.ray.direction));
                color = self.number(color + self.clamped_by(Rule::LightsClamped, lit));
            }
        }
        color
    }

    fn light_passed(&self, surface: &SurfacePoint, light: &Incident, index: usize) -> Color {
        let ends = !self.breaks(Rule::ShadowsFromBehindLight);
        let t_max = if ends { light.distance } else { f64::INFINITY };
        let ray = Ray { t_max, ..self.leaving(surface, light.direction) };
        match self.effects.shadows {
            Shadows::None => Color::ONE,
            Shadows::Transparent => self.filtered(ray),
            Shadows::Opaque => {
                let is_at_triangle = !self.finder.world().triangles_at_light(index).is_empty();
                let is_blocked = is_at_triangle || self.finder.is_blocked(&ray, surface.triangle);
                if is_blocked { Color::ZERO } else { Color::ONE }
            }
        }
    }

    /// What transparent things leave of the light along a shadow ray.
    fn filtered(&self, mut ray: Ray) -> Color {
        let mut passed = Color::ONE;
        while let Some(Found { t, surface, .. }) = self.finder.nearest(&ray, None) {
            let tint = self.material(&surface, &mut Mixture::default()).phong.transparent;
            if tint == Color::ZERO {
                return Color::ZERO;
            }
            if surface.normal.dot(ray.direction) >= 0.0 {
                passed *= transmittance(tint, t);
            }
            ray = Ray { t_max: ray.t_max - t, ..self.leaving(&surface, ray.direction) };
        }
        passed
    }

    /// A ray that leaves a surface.
    fn leaving(&self, surface: &SurfacePoint, direction: DVec3) -> Ray {
        if let Some(Rule::Epsilon { distance: t_min }) = self.rule {
            return Ray { t_min, ..Ray::new(surface.position, direction) };
        }
        let largest = self.finder.world().max_abs_coord;
        Ray::new(offset_origin(surface.position, surface.normal, direction, largest), direction)
    }

    fn reflect(
        &self,
        path: &Path,
        surface: &SurfacePoint,
        material: &PointMaterial,
    ) -> Option<(Color, Path)> {
        let tint = material.phong.reflective;
        let weight = self.weight(path, tint)?;
        let (d, n) = (path.ray.direction, surface.normal);
        let direction = match self.rule {
            Some(Rule::NormalFlippedInReflection) => (d + 2.0 * d.dot(n) * n).normalize(),
            Some(Rule::ReflectionReversed) => -reflected(d, n),
            _ => reflected(d, n),
        };
        let ray = match self.rule {
            Some(Rule::ReflectionFromBelow) => {
                let origin = self.leaving(surface, -direction).origin;
                Ray::new(origin, direction)
            }
            _ => self.leaving(surface, direction),
        };
        let exclude = if self.breaks(Rule::ReflectionFromBelow) { None } else { surface.triangle };
        Some((tint, Path { ray, exclude, weight, bounces: path.bounces + 1, index: path.index }))
    }

    fn refract(
        &self,
        path: &Path,
        surface: &SurfacePoint,
        material: &PointMaterial,
    ) -> Option<(Color, Path)> {
        let tint = material.phong.transparent;
        let weight = self.weight(path, tint)?;
        let (d, n) = (path.ray.direction, surface.normal);
        let entering = d.dot(n) < 0.0;
        let (normal, index) = if entering { (n, material.phong.index_of_refraction) } else { (-n, 1.0) };
        let precise_normal = || self.finder.world().precise_normal(surface.primitive, n);
        let ray = self.leaving(surface, refracted_between(d, normal, [path.index, index], precise_normal)?);
        Some((tint, Path { ray, exclude: surface.triangle, weight, bounces: path.bounces + 1, index }))
    }

    /// The weight of a secondary ray, if it weighs enough to be followed.
    fn weight(&self, path: &Path, tint: Color) -> Option<f64> {
        let weight = path.weight * tint.length();
        (weight > self.effects.min_weight).then_some(weight)
    }
}

/// The child of a checkerboard where coordinates are cut to whole numbers, towards zero.
fn child_by_cutting(texture: &Texture, point: DVec3) -> MaterialId {
    let cells = texture.world_to_texture.map.transform_point3(point).to_array().map(|q| q as i64);
    let is_odd = cells.iter().fold(false, |is_odd, cell| is_odd ^ (cell % 2 != 0));
    texture.children[usize::from(is_odd)]
}
