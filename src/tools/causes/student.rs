//! The student's tracer: Whitted's recursion as in a textbook, one ray at a time, with a switch for each mistake.
//!
//! It uses the tracer's own functions for the laws of light. A mistake is a switch around a call. Without a mistake the
//! colours equal the tracer's. Rays are intersected through a trait, so it runs with a caster or by brute force, in
//! single or double precision.

use super::mistakes::Mistake;
pub use super::object_space::ObjectSpaces;
use crate::caster::{Caster, RayOrigin};
use crate::math::instructions::Level;
use crate::math::ray::{Ray, Visible};
use crate::math::robust::{offset_origin, unit};
use crate::picture::Color;
use crate::render::renderer::Renderer;
use crate::scene::limits::{BRIGHTEST, LARGEST};
use crate::scene::material::{Material, Pattern, Phong, Texture};
use crate::scene::model::{Highlight, Split};
use crate::scene::{Light, MaterialId};
use crate::shading::light::{Incident, incident};
use crate::shading::perlin::turbulence;
use crate::shading::phong::{Mixture, PointMaterial, View, alignment};
use crate::shading::texture::{first_weight, material_at, material_of_surface};
use crate::stats::Quiet;
use crate::trace::{
    Effects, Shadows, ending_at_light, mirrored_part, reflected, refracted_between, transmittance,
};
use crate::world::{SurfacePoint, World};
use glam::DVec3;
use serde::Serialize;
use std::f64::consts::FRAC_1_PI;

/// How a ray leaves a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Departure {
    /// Mirrored.
    Reflected,
    /// Through the surface.
    Refracted,
    /// Towards a light.
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
        Caster::nearest(self, ray, RayOrigin::on(self.world, leaves), &mut Quiet)
    }
}

/// Returns true if a ray that leaves a surface in a direction hits it again.
pub type HitsItself<'a> = &'a (dyn Fn(Departure, &SurfacePoint, DVec3) -> bool + Sync);

/// A tracer with at most one mistake.
#[derive(Clone, Copy)]
pub struct Student<'a> {
    pub renderer: &'a Renderer,
    pub hits: &'a dyn Hits,
    pub effects: Effects,
    pub mistake: Option<Mistake>,
    /// The transforms applied to the primitives. Mistakes with normals need them.
    pub spaces: Option<&'a ObjectSpaces<'a>>,
    /// The rays that hit the surface that they leave, if not the mistake's.
    pub hits_itself: Option<HitsItself<'a>>,
    /// True if points, directions and colours are rounded to single precision.
    pub is_single: bool,
}

/// A ray and its history since the camera.
struct Way {
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
    way: &'m Way,
    surface: &'m SurfacePoint,
    material: PointMaterial<'m>,
}

impl<'a> Student<'a> {
    /// Returns a tracer in double precision without mistakes.
    pub fn new(renderer: &'a Renderer, hits: &'a dyn Hits, effects: Effects) -> Self {
        Self { renderer, hits, effects, mistake: None, spaces: None, hits_itself: None, is_single: false }
    }

    fn makes(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    fn world(&self) -> &World {
        self.hits.world()
    }

    /// Returns the colour along a ray from the camera.
    pub fn color(&self, ray: &Ray) -> Color {
        let ray = Ray { origin: self.rounded(ray.origin), direction: self.rounded(ray.direction), ..*ray };
        let way = Way { ray, leaves: None, weight: 1.0, bounces: 0, index: 1.0 };
        self.clamped_by(Mistake::SamplesClamped, self.trace(&way))
    }

    /// Returns the distance and the surface of a camera ray's nearest hit.
    pub fn seen(&self, ray: &Ray) -> Option<(f64, SurfacePoint)> {
        let visible = self.hits.nearest(ray, None)?;
        Some((self.hits.distance(ray, visible), self.surface(ray, visible)))
    }

    /// Returns the colour along a ray: the surface's own colour, plus the colours of the refracted and mirrored rays.
    fn trace(&self, way: &Way) -> Color {
        let color = match self.hits.nearest(&way.ray, way.leaves) {
            Some(visible) => {
                let surface = &self.surface(&way.ray, visible);
                let mut mixture = Mixture::default();
                let material = self.material(surface, &mut mixture);
                let arrival = Arrival { way, surface, material };
                let add = |sum, (tint, way)| self.rounded(sum + tint * self.trace(&way));
                self.branches(&arrival).into_iter().flatten().fold(self.shade(&arrival), add)
            }
            None if way.bounces > 0 && self.makes(Mistake::BackgroundForCameraOnly) => Color::ZERO,
            None => self.rounded(self.world().background_along(way.ray.direction)),
        };
        self.clamped_by(Mistake::RaysClamped, color)
    }

    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        let surface = self.hits.surface(ray, visible);
        let Some(spaces) = self.spaces else { return surface };
        let object_normal = || spaces.normal(visible.primitive, surface.normal);
        let normal = match self.mistake {
            Some(Mistake::NormalsByMatrix) => unit(spaces.matrix(visible.primitive) * object_normal()),
            Some(Mistake::NormalsOfObjectSpace) => unit(object_normal()),
            _ => return surface,
        };
        if normal.is_finite() { SurfacePoint { normal, ..surface } } else { surface }
    }

    /// Returns the material of a surface, with its textures evaluated at the point.
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let materials = &self.world().materials;
        match (&materials[surface.material], self.mistake) {
            (Material::Texture(_), Some(Mistake::CheckerboardCut | Mistake::NoiseHalved)) => {
                self.mix(surface.material, surface.position, mixture);
                mixture.material()
            }
            _ => material_of_surface(self.world(), surface, LEVEL, mixture),
        }
    }

    /// Mixes a material's parts at a point. A texture passes its weight on to its children, which precede it.
    fn mix(&self, id: MaterialId, point: DVec3, mixture: &mut Mixture) {
        let mut weights = vec![0.0; id + 1];
        weights[id] = 1.0;
        mixture.start(&Phong::default(), 0.0);
        for (id, material) in self.world().materials[..=id].iter().enumerate().rev() {
            match (material, weights[id]) {
                (_, 0.0) => {}
                (Material::Phong(phong) | Material::Painted(phong, _), weight) => mixture.add(phong, weight),
                (Material::Texture(texture), weight) => {
                    let first = self.first_weight(texture, point);
                    weights[texture.children[0]] += weight * first;
                    weights[texture.children[1]] += weight * (1.0 - first);
                }
            }
        }
    }

    /// Returns the weight of a texture's first child at a point.
    fn first_weight(&self, texture: &Texture, point: DVec3) -> f64 {
        let in_texture = || texture.world_to_texture.map.transform_point3(point);
        match (self.mistake, texture.pattern) {
            (Some(Mistake::CheckerboardCut), Pattern::Checkerboard) => {
                // The coordinates are truncated towards zero.
                let cells = in_texture().to_array().map(|q| q as i64);
                f64::from(cells.iter().filter(|&cell| cell % 2 != 0).count() % 2 == 0)
            }
            (Some(Mistake::NoiseHalved), Pattern::Noise { octaves }) => {
                (0.5 * turbulence(in_texture(), octaves, LEVEL) + 0.5).clamp(0.0, 1.0)
            }
            _ => first_weight(texture, &point.into(), LEVEL),
        }
    }

    /// Returns the surface's own colour: ambient light, and the lights visible from the point.
    fn shade(&self, arrival: &Arrival) -> Color {
        let Arrival { way, surface, material } = arrival;
        let highlight = self.world().lighting.highlight;
        let is_back = surface.normal.dot(way.ray.direction) > 0.0;
        let is_inside = is_back && highlight == Highlight::Blinn;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let is_flipped = match self.mistake {
            Some(Mistake::NormalsNotFlipped) => false,
            Some(Mistake::NormalsFlipped) => is_back,
            _ => is_inside,
        };
        let normal = if is_flipped { -surface.normal } else { surface.normal };
        let mut color = self.rounded(self.world().ambient * self.ambient_factor(arrival));
        for (index, light) in self.world().lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let light = Incident { direction: self.rounded(light.direction), ..light };
            let cosine = self.rounded_number(normal.dot(light.direction));
            // As in the course's program, a shadow ray starts even where the light has no effect.
            let has_ray = self.effects.shadows != Shadows::None;
            let start = has_ray.then(|| self.departing(Departure::Shadow, surface, light.direction));
            if material.shows(highlight, &light, cosine) {
                let view = View { cosine, normal, to_viewer: -way.ray.direction };
                let passed = start.map_or(Color::ONE, |start| self.passed(start, surface, &light, index));
                let lit = self.rounded(passed * self.reflect(material, &light, index, &view));
                color = self.rounded(color + self.clamped_by(Mistake::LightsClamped, lit));
            }
        }
        color
    }

    fn ambient_factor(&self, arrival: &Arrival) -> Color {
        let color = self.world().ambient_color(arrival.surface, arrival.material.phong.diffuse);
        match self.mistake {
            Some(Mistake::AmbientWithoutDiffuse) => Color::ONE,
            Some(Mistake::AmbientFromAbove) => (0.5 + 0.5 * arrival.surface.normal.y) * color,
            _ => color,
        }
    }

    /// Returns the part of a light that a surface reflects to the viewer.
    fn reflect(&self, material: &PointMaterial, light: &Incident, index: usize, view: &View) -> Color {
        let length = self.length_to(light, index);
        let to_light = light.direction * length;
        let lit = view.cosine.max(0.0) * length;
        let (mut highlight, mut strength, mut diffuse) = (self.world().lighting.highlight, 1.0, lit);
        let is_blinn = highlight == Highlight::Blinn;
        match self.mistake {
            Some(Mistake::HighlightsByReflection) => highlight = Highlight::Phong,
            Some(Mistake::HighlightsTimesCosine) => strength = lit,
            Some(Mistake::HighlightsOnlyWhereLit) => strength = f64::from(lit > 0.0),
            Some(Mistake::DiffuseOverPi) => diffuse *= FRAC_1_PI,
            _ => {}
        }
        let alignment = match self.mistake {
            Some(Mistake::HalfWayNotNormalised) if is_blinn => view.normal.dot(to_light + view.to_viewer),
            _ => alignment(highlight, to_light, view),
        };
        let highlights = strength * material.highlights(self.rounded_number(alignment).max(0.0));
        light.color * (material.phong.diffuse * diffuse + highlights)
    }

    /// Returns the length of the vector to a light. It is not 1 if the mistake is a missing normalisation.
    fn length_to(&self, light: &Incident, index: usize) -> f64 {
        match (self.mistake, self.renderer.scene.lights.get(index)) {
            (Some(Mistake::DirectionsNotNormalised), Some(Light::Directional { direction, .. })) => {
                direction.length()
            }
            (Some(Mistake::PointDirectionsNotNormalised), Some(Light::Point { .. })) => light.distance,
            _ => 1.0,
        }
    }

    /// Returns the fraction of a light that reaches a surface, per channel. Where the shadow ray leaves a transparent
    /// object, this is the object's colour to the power of the distance inside (Beer's law).
    ///
    /// Surfaces that contain the light's position are crossed at the light if the ray was inside an object before. So
    /// it does not matter which of them the ray hits by rounding. An opaque one blocks the light.
    fn passed(
        &self,
        (mut ray, mut leaves): Start,
        surface: &SurfacePoint,
        light: &Incident,
        index: usize,
    ) -> Color {
        let is_unshadowed = self.makes(Mistake::GlassWithoutShadows);
        let at_light = self.world().primitives_at_light(index);
        let length = match self.mistake {
            Some(Mistake::ShadowsFromBehindLight) => f64::INFINITY,
            Some(Mistake::ShadowRaysHalved) => 0.5 * light.distance,
            _ => light.distance,
        };
        let ends_at_light = length == light.distance && !self.is_single;
        let ended = |ray: Ray, surface: &SurfacePoint, t_max: f64| {
            let ray = Ray { t_max, ..ray };
            if ends_at_light { ending_at_light(self.world(), index, surface, ray) } else { ray }
        };
        ray = ended(ray, surface, length);
        if self.effects.shadows == Shadows::Opaque && !is_unshadowed {
            let is_blocked = !at_light.is_empty() || self.hits.nearest(&ray, leaves).is_some();
            return if is_blocked { Color::ZERO } else { Color::ONE };
        }
        let absorbed = |passed: Color, tint: Color, way: f64| match is_unshadowed {
            true => passed,
            false => (passed * transmittance(tint, way)).min(Color::splat(LARGEST)),
        };
        let (mut passed, mut mixture) = (Color::ONE, Mixture::default());
        let mut is_within = surface.normal.dot(light.direction) < 0.0;
        // The distance from the last surface to the current start of the ray.
        let mut way = 0.0;
        for _ in 0..self.world().most_crossings() {
            let Some(visible) = self.hits.nearest(&ray, leaves) else { break };
            let (t, crossed) = (self.hits.distance(&ray, visible), self.surface(&ray, visible));
            let is_left = crossed.normal.dot(ray.direction) >= 0.0;
            if at_light.iter().any(|place| place.is_crossed(visible.primitive, ray.direction, is_left)) {
                way += t;
            } else {
                let tint = self.material(&crossed, &mut mixture).phong.transparent;
                if tint == Color::ZERO {
                    return Color::ZERO;
                }
                if is_left {
                    passed = absorbed(passed, tint, way + t);
                }
                (is_within, way) = (!is_left, 0.0);
            }
            let t_max = ray.t_max - t;
            (ray, leaves) = self.departing(Departure::Onwards, &crossed, ray.direction);
            ray = ended(ray, &crossed, t_max);
        }
        let tints = at_light.iter().map(|place| self.tint_at_light(place.primitive, index));
        match tints.reduce(|one, other| if other == Color::ZERO { other } else { one }) {
            Some(Color::ZERO) => Color::ZERO,
            Some(tint) if is_within => absorbed(passed, tint, way + ray.t_max.max(0.0)),
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
    fn branches(&self, arrival: &Arrival) -> [Option<(Color, Way)>; 2] {
        let Arrival { way, surface, material } = arrival;
        let (direction, normal) = (way.ray.direction, surface.normal);
        let cosine = direction.dot(normal);
        let is_entering = cosine < 0.0;
        // In front of the surface and behind it.
        let indices = match is_entering {
            true => [way.index, material.phong.index_of_refraction],
            false if self.makes(Mistake::IndexNotInverted) => [1.0, material.phong.index_of_refraction],
            false => [way.index, 1.0],
        };
        let Phong { mut reflective, mut transparent, .. } = *material.phong;
        // An opaque surface mirrors all light.
        if self.world().lighting.split == Split::Schlick && transparent != Color::ZERO {
            let part = mirrored_part(cosine.abs(), indices);
            // At total internal reflection nothing is refracted.
            let part = if self.makes(Mistake::SchlickSwapped) && part < 1.0 { 1.0 - part } else { part };
            reflective *= part;
            transparent *= 1.0 - part;
        }
        let next = |why, direction, weight, index| {
            let (ray, leaves) = self.departing(why, surface, direction);
            Way { ray, leaves, weight, bounces: way.bounces + 1, index }
        };
        let mirrored = self.weight(way, reflective).map(|weight| {
            let direction = match self.mistake {
                Some(Mistake::NormalFlippedInReflection) => reflected_by_sum(direction, normal),
                Some(Mistake::ReflectionReversed) => -reflected(direction, normal),
                _ => reflected(direction, normal),
            };
            let tint = self.tint(reflective, Mistake::ReflectionWithoutColor);
            (tint, next(Departure::Reflected, direction, weight, way.index))
        });
        let refracted = self.weight(way, transparent).and_then(|weight| {
            let is_turned = !is_entering && !self.makes(Mistake::NormalNotFlippedInRefraction);
            let against = if is_turned { -normal } else { normal };
            let sine = || {
                // An interpolated normal differs from the triangle's.
                let is_smooth = self.world().has_smooth_normals() && surface.triangle.is_some();
                let primitive = surface.primitive.filter(|_| !is_smooth);
                self.world().precise_sine((way.ray.origin, direction), primitive, normal)
            };
            let (direction, index) = match refracted_between(direction, against, indices, sine) {
                Some(refracted) => (refracted, if is_entering { indices[1] } else { 1.0 }),
                None if self.makes(Mistake::TotalReflectionAdded) => {
                    (reflected(direction, normal), way.index)
                }
                None => return None,
            };
            let tint = self.tint(transparent, Mistake::RefractionWithoutColor);
            Some((tint, next(Departure::Refracted, direction, weight, index)))
        });
        [refracted, mirrored]
    }

    /// Returns the weight of a secondary ray of this colour, if it is followed.
    fn weight(&self, way: &Way, color: Color) -> Option<f64> {
        let weight = way.weight * color.length();
        (way.bounces < self.effects.bounces && weight > self.effects.min_weight).then_some(weight)
    }

    /// Returns the factor of a secondary ray's colour.
    fn tint(&self, color: Color, untinted: Mistake) -> Color {
        let bound = Color::splat(BRIGHTEST);
        if self.makes(untinted) { Color::ONE } else { color.clamp(-bound, bound) }
    }

    /// Returns a ray that leaves a surface.
    fn departing(&self, why: Departure, surface: &SurfacePoint, direction: DVec3) -> Start {
        let direction = self.rounded(direction);
        let hits_itself = match self.hits_itself {
            Some(hits_itself) => hits_itself(why, surface, direction),
            None => matches!(self.mistake, Some(Mistake::NoEpsilon { rays }) if rays.has(why)),
        };
        let (ray, leaves) = self.start(why, surface, direction, hits_itself);
        (Ray { origin: self.rounded(ray.origin), ..ray }, leaves)
    }

    /// Returns the start of a ray that leaves a surface: a few roundings off it, on the side to which it goes.
    fn start(&self, why: Departure, surface: &SurfacePoint, direction: DVec3, hits_itself: bool) -> Start {
        let beyond = |t_min, origin| (Ray { t_min, ..Ray::new(origin, direction) }, None);
        let off = |side| offset_origin(surface.position, surface.normal, side * direction, surface.extent);
        let is_from_below = self.makes(Mistake::ReflectionFromBelow) && why == Departure::Reflected;
        match self.world().lighting.epsilon {
            _ if is_from_below && self.is_single => {
                let depth = BELOW * surface.normal.dot(direction).signum() * surface.normal;
                beyond(NO_EPSILON, off(-1.0) - depth)
            }
            _ if hits_itself && self.is_single => beyond(NO_EPSILON, surface.position),
            // On the other side of the surface, the ray hits it at once.
            _ if is_from_below || hits_itself => (Ray::new(off(-1.0), direction), None),
            Some(epsilon) => beyond(epsilon, surface.position),
            None => (Ray::new(off(1.0), direction), surface.primitive),
        }
    }

    /// Returns a vector in the precision of the tracer.
    fn rounded(&self, vector: DVec3) -> DVec3 {
        if self.is_single { vector.as_vec3().as_dvec3() } else { vector }
    }

    /// Returns a number in the precision of the tracer.
    fn rounded_number(&self, number: f64) -> f64 {
        if self.is_single { f64::from(number as f32) } else { number }
    }

    fn clamped_by(&self, mistake: Mistake, color: Color) -> Color {
        if self.makes(mistake) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }
}

/// How far below a surface reflected rays start in single precision by mistake.
const BELOW: f64 = 1e-4;

/// The smallest t of a ray without an epsilon. In single precision, 0 stands for the usual epsilon.
const NO_EPSILON: f64 = f64::MIN_POSITIVE;

/// Textures give the same bytes with all instruction sets.
const LEVEL: Level = Level::baseline();

/// Returns d + 2 (d.n) n instead of the mirrored direction d - 2 (d.n) n.
fn reflected_by_sum(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction + 2.0 * direction.dot(normal) * normal).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Request;
    use crate::render::renderer::{Meshes, Renderer};
    use crate::scene::load::load;
    use crate::trace::{Memory, Tracer};
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
    fn without_a_mistake_colours_are_those_of_the_tracer() {
        let opaque = Effects { shadows: Shadows::Opaque, bounces: 4, min_weight: 0.1, shade_back: false };
        let tinted = Effects { shadows: Shadows::Transparent, bounces: 3, min_weight: 0.0, shade_back: true };
        let scenes = scenes();
        assert!(scenes.len() > 60);
        for path in scenes {
            let renderer = Renderer::new(load(&path).unwrap(), Meshes::Kept).unwrap();
            let request = Request::new([24, 18]);
            let prepared = renderer.prepare(&request).unwrap();
            let camera = renderer.camera(&request);
            for effects in [Effects::default(), opaque, tinted] {
                let hits = prepared.caster();
                let student = Student::new(&renderer, hits, effects);
                let tracer = Tracer::new(hits, effects);
                for (x, y) in (0..24).flat_map(|x| (0..18).map(move |y| (x, y))) {
                    let ray = camera.ray(DVec2::new(x.into(), y.into()), DVec2::ZERO);
                    let (own, expected) =
                        (student.color(&ray), tracer.color(&ray, &mut Memory::default(), &mut Quiet));
                    let far = (own - expected).abs().max_element() / expected.abs().max_element().max(1.0);
                    assert!(far < 1e-9, "{} {effects:?} {x} {y}: {own} {expected}", path.display());
                }
            }
        }
    }
}
