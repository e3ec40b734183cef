//! The tracer's rules with at most one of them broken.

use super::object_space::ObjectSpaces;
use super::rules::Rule;
use crate::math::instructions::Instructions;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust::unit;
use crate::scene::material::{Material, Pattern, Texture};
use crate::scene::model::Model;
use crate::scene::{Color, MaterialId};
use crate::shading::phong::{Mixture, PointMaterial};
use crate::shading::texture::material_at;
use crate::stats::{Probe, Quiet};
use crate::trace::{Departure, Path, Rules, Secondary, SecondaryRay, Tracer, reflected};
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// The rules `right`, of which at most one is broken.
pub struct Mistaken<'a, R> {
    pub right: &'a R,
    pub rule: Option<Rule>,
    pub spaces: &'a ObjectSpaces<'a>,
}

impl<R: Rules> Mistaken<'_, R> {
    fn breaks(&self, rule: Rule) -> bool {
        self.rule == Some(rule)
    }

    fn clamped_by(&self, rule: Rule, color: Color) -> Color {
        if self.breaks(rule) { color.clamp(Color::ZERO, Color::ONE) } else { color }
    }
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
        let world = self.world();
        match &world.materials[surface.material] {
            Material::Texture(texture)
                if texture.pattern == Pattern::Checkerboard && self.breaks(Rule::CheckerboardCut) =>
            {
                let child = child_by_cutting(texture, surface.position);
                world.with_rounded_point(surface, |point| {
                    material_at(&world.materials, child, point, Instructions::Portable, mixture)
                })
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
            (Some(Rule::Epsilon { distance: t_min }), _) => {
                (Ray { t_min, ..Ray::new(surface.position, direction) }, surface.triangle)
            }
            (Some(Rule::ReflectionFromBelow), Departure::Secondary(Secondary::Reflected)) => {
                let (from_below, _) = self.right.departing(why, surface, -direction);
                (Ray::new(from_below.origin, direction), None)
            }
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

/// The child of a checkerboard where coordinates are cut to whole numbers, towards zero.
fn child_by_cutting(texture: &Texture, point: DVec3) -> MaterialId {
    let cells = texture.world_to_texture.map.transform_point3(point).to_array().map(|q| q as i64);
    let is_odd = cells.iter().fold(false, |is_odd, cell| is_odd ^ (cell % 2 != 0));
    texture.children[usize::from(is_odd)]
}
