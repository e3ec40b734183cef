//! The student's tracer: Whitted's recursion as in a textbook, one ray at a time, with a switch for each rule.
//!
//! It uses the tracer's own functions for the laws of light. A broken rule is a switch around a call. Without one the
//! colours equal the tracer's. Rays are intersected through a trait, so it runs with a caster or by brute force, in
//! single or double precision.

mod light;
mod normal;
mod shadow;

use super::hits::Hits;
use super::rules::{RayKind, Rule};
use super::wrong_textures::first_weight;
use crate::base::patience::{Endless, Patience};
use crate::math::instructions::Level;
use crate::math::ray::Ray;
use crate::math::robust::offset_origin;
use crate::picture::Color;
use crate::render::renderer::Renderer;
use crate::scene::MaterialId;
use crate::scene::limits::BRIGHTEST;
use crate::scene::material::{Material, Phong, Texture};
use crate::scene::model::Split;
use crate::shading::phong::{Mixture, PointMaterial};
use crate::shading::texture::{each_part, material_of_surface};
use crate::trace::{Effects, mirrored_part, reflected, refracted_between};
use crate::world::{Objects, SurfacePoint, World};
use glam::DVec3;

/// Deeper recursion is not tried, because it could overflow the stack.
pub(crate) const MAX_BOUNCES: u32 = 100;

/// A ray that leaves a surface or the camera.
struct Leaving {
    ray: Ray,
    /// The primitive that the ray leaves, if it cannot hit it again.
    origin_primitive: Option<u32>,
}

/// Returns true if a ray that leaves a surface in a direction hits it again.
pub type HitsItself<'a> = &'a (dyn Fn(RayKind, &SurfacePoint, DVec3) -> bool + Sync);

/// A tracer that breaks some rules.
#[derive(Clone, Copy)]
pub struct Student<'a> {
    pub renderer: &'a Renderer,
    pub hits: &'a dyn Hits,
    pub effects: Effects,
    pub rules: &'a [Rule],
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
    leaving: Leaving,
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
        let (objects, hits_itself, epsilon, patience) = (None, None, None, &Endless);
        Self { renderer, hits, effects, rules: &[], objects, hits_itself, epsilon, patience }
    }

    fn breaks(&self, rule: Rule) -> bool {
        self.rules.contains(&rule)
    }

    fn breaks_any(&self, rules: &[Rule]) -> bool {
        self.rules.iter().any(|rule| rules.contains(rule))
    }

    fn world(&self) -> &World {
        self.hits.world()
    }

    /// Returns the colour along a ray from the camera.
    pub fn color(&self, ray: &Ray) -> Color {
        let leaving = Leaving { ray: *ray, origin_primitive: None };
        let path_ray = PathRay { leaving, weight: 1.0, bounces: 0, index: 1.0 };
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
        let Leaving { ray, origin_primitive } = &path_ray.leaving;
        let color = match self.hits.nearest(ray, *origin_primitive) {
            Some(visible) => {
                let surface = &self.surface(ray, visible);
                let mut mixture = Mixture::default();
                let material = self.material(surface, &mut mixture);
                let arrival = Arrival { path_ray, surface, material };
                let own = self.shade(&arrival);
                let [refracted, mirrored] = self.branches(&arrival);
                if self.breaks_any(&[Rule::ReflectionBlended, Rule::RefractionBlended]) {
                    let own = self.blended(Rule::ReflectionBlended, own, mirrored);
                    self.blended(Rule::RefractionBlended, own, refracted)
                } else {
                    let both = [refracted, mirrored].into_iter().flatten();
                    both.fold(own, |sum, (tint, path_ray)| sum + tint * self.trace(&path_ray))
                }
            }
            None if path_ray.bounces > 0 && self.breaks(Rule::BackgroundForCameraOnly) => Color::ZERO,
            None => self.world().background_along(ray.direction),
        };
        self.clamped_by(Rule::RaysClamped, color)
    }

    /// Adds the colour of a secondary ray. If the rule is broken, the colour so far is multiplied by 1 minus its factor.
    fn blended(&self, rule: Rule, color: Color, branch: Option<(Color, PathRay)>) -> Color {
        let Some((tint, path_ray)) = branch else { return color };
        let part = if self.breaks(rule) { 1.0 - tint } else { Color::ONE };
        part * color + tint * self.trace(&path_ray)
    }

    /// Returns the material of a surface, with its textures evaluated at the point.
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let is_texture = matches!(self.world().materials[surface.material], Material::Texture(_));
        if is_texture && self.breaks_any(&super::wrong_textures::RULES) {
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

    /// Returns the refracted and the mirrored ray, each with the factor of its colour, if they are followed.
    fn branches(&self, arrival: &Arrival) -> [Option<(Color, PathRay)>; 2] {
        let Arrival { path_ray, surface, material } = arrival;
        let arriving = &path_ray.leaving.ray;
        let (direction, normal) = (arriving.direction, surface.normal);
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
        let next = |kind, direction, weight, index| {
            let leaving = self.departing(kind, surface, direction);
            PathRay { leaving, weight, bounces: path_ray.bounces + 1, index }
        };
        let is_turned = !is_entering && !self.breaks(Rule::NormalNotFlippedInRefraction);
        let against = if is_turned { -normal } else { normal };
        let sine = || {
            // An interpolated normal differs from the triangle's.
            let is_smooth = self.world().has_smooth_normals() && surface.triangle.is_some();
            let primitive = surface.primitive.filter(|_| !is_smooth);
            self.world().precise_sine((arriving.origin, direction), primitive, normal)
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
            Some((tint, next(RayKind::Refracted, direction, weight, index)))
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
            (tint, next(RayKind::Reflected, direction, weight, path_ray.index))
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
    fn departing(&self, kind: RayKind, surface: &SurfacePoint, direction: DVec3) -> Leaving {
        let off = |side| offset_origin(surface.position, surface.normal, side * direction, surface.extent);
        let is_from_below = self.breaks(Rule::ReflectionFromBelow) && kind == RayKind::Reflected;
        let hits_itself = match self.hits_itself {
            Some(hits_itself) => hits_itself(kind, surface, direction),
            None => self.rules.iter().any(|rule| matches!(rule, Rule::NoEpsilon(rays) if rays.has(kind))),
        };
        let (ray, origin_primitive) = match self.epsilon.or(self.world().lighting.epsilon) {
            // On the other side of the surface, the ray hits it at once.
            _ if is_from_below || hits_itself => (Ray::new(off(-1.0), direction), None),
            Some(epsilon) => (Ray { t_min: epsilon, ..Ray::new(surface.position, direction) }, None),
            None => (Ray::new(off(1.0), direction), surface.primitive),
        };
        Leaving { ray, origin_primitive }
    }

    fn clamped_by(&self, rule: Rule, color: Color) -> Color {
        if self.breaks(rule) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }
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
    use crate::trace::{Quiet, RayStack, Shadows, Tracer};
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
