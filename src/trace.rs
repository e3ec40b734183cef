//! The tracer, after Whitted ("An Improved Illumination Model for Shaded Display", CACM 23(6), 1980).
//!
//! [`Tracer`] finds the surface that a camera ray hits first. The colour there is the ambient light, the light
//! of each source that nothing blocks, and the colours along the reflected and the refracted ray. These secondary rays
//! wait on a stack. An [`Observer`] counts or records the steps. [`Hints`] spare rays and never change a colour.

use crate::base::patience::Patience;
use crate::caster::{Caster, RayOrigin};
use crate::math::ray::{Ray, Visible};
use crate::math::robust::offset_origin;
use crate::picture::Color;
use crate::scene::model::Highlight;
use crate::shading::light::incident;
use crate::shading::phong::{Geometry, PointMaterial};
use crate::shading::texture::material_of_surface;
use crate::world::{SurfacePoint, World};
use fearless_simd::{Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;
use serde::Serialize;

mod hints;
mod observer;
mod optics;
mod packet;
mod secondary;
mod shadow;

pub use hints::{Blocker, FirstHit, Hints, NoHints};
pub use observer::{Event, Observer, PathEnd, Quiet, RayCount, Secondary};
pub use optics::{is_critical, reflected, refracted, transmittance};
pub(crate) use optics::{mirrored_part, refracted_between};
pub(crate) use secondary::MOST_WAITING;
pub use secondary::{IsOver, RayStack};
use secondary::{Path, SecondaryRay};
pub(crate) use shadow::ending_at_light;

/// The objects that cast shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shadows {
    /// No object.
    #[default]
    None,
    /// Every object, whether transparent or not.
    Opaque,
    /// Every object, but transparent ones only filter the light, by the length of its path inside them.
    Transparent,
}

impl Shadows {
    /// Returns the flag that asks for them.
    pub fn flag(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Opaque => Some("-shadows"),
            Self::Transparent => Some("-transparent_shadows"),
        }
    }
}

/// The effects that are modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Effects {
    /// The objects that cast shadows.
    pub shadows: Shadows,
    /// True if surfaces are also lit on their inside. Otherwise the inside is black.
    pub shade_back: bool,
    /// The maximum number of times that a ray is reflected or refracted.
    pub bounces: u32,
    /// The minimum weight. Only secondary rays above it are traced.
    pub min_weight: f64,
}

/// The number of lights between two questions whether the work should end.
const LIGHTS_AT_ONCE: usize = 16;

/// Finds the colours of rays: of a packet of camera rays in `trace`, of a single one in [`color`](Self::color).
#[derive(Clone, Copy, Debug)]
pub struct Tracer<'a, H = NoHints> {
    caster: &'a Caster<'a>,
    effects: Effects,
    hints: &'a H,
}

/// A ray, and the surface that it hits.
struct Arrival<'m> {
    ray: &'m Ray,
    path: &'m Path,
    surface: &'m SurfacePoint,
    material: PointMaterial<'m>,
}

impl<'a> Tracer<'a> {
    /// Returns a tracer that casts every ray.
    pub fn new(caster: &'a Caster<'a>, effects: Effects) -> Self {
        Self { caster, effects, hints: &NoHints }
    }
}

impl<'a, H: Hints> Tracer<'a, H> {
    /// Returns a tracer that casts only the rays whose result the hints do not know.
    pub fn with_hints(caster: &'a Caster<'a>, effects: Effects, hints: &'a H) -> Self {
        Self { caster, effects, hints }
    }

    #[inline(always)]
    fn world(&self) -> &'a World {
        self.caster.world
    }

    /// Returns the colour along a camera ray.
    pub fn color<O: Observer>(&self, ray: &Ray, stack: &mut RayStack, observer: &mut O) -> Color {
        let visible = self.nearest(ray, RayOrigin::FREE, observer);
        let surface = visible.map(|visible| self.surface(ray, visible));
        let (surface, mut color) = (surface.as_ref(), Color::ZERO);
        dispatch!(self.caster.level, simd => self.set_color(simd, &mut color, ray, surface, stack, observer));
        color
    }

    /// Sets the colour along a camera ray. `surface` is the one that it hits first, or `None`.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "an inner loop")]
    fn set_color<S: Simd, O: Observer>(
        &self,
        simd: S,
        color: &mut Color,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        stack: &mut RayStack,
        observer: &mut O,
    ) {
        *color = self.local_color(ray, &Path::CAMERA, surface, stack, observer);
        if !stack.pending.is_empty() {
            self.add_secondary(simd, color, stack, observer);
        }
    }

    /// Adds the colours along the secondary rays that wait, and along the rays that these cause in turn.
    #[simd]
    #[inline(never)]
    fn add_secondary<S: Simd, O: Observer>(
        &self,
        _: S,
        sum: &mut Color,
        stack: &mut RayStack,
        observer: &mut O,
    ) {
        let mut color = *sum;
        while let Some(SecondaryRay { ray, origin, path }) = stack.pending.pop() {
            if stack.spend(1) {
                stack.pending.clear();
                break;
            }
            observer.observe(|| Event::Popped);
            observer.non_shadow_ray();
            let visible = self.nearest(&ray, origin, observer);
            let surface = visible.map(|visible| self.surface(&ray, visible));
            color += path.filter * self.local_color(&ray, &path, surface.as_ref(), stack, observer);
        }
        *sum = color;
    }

    /// Returns the nearest hit, or `None`, and tells the observer the course's steps.
    #[inline(always)]
    fn cast<O: Observer>(&self, ray: &Ray, origin: RayOrigin, observer: &mut O) -> Option<Visible> {
        let visible = self.caster.nearest(ray, origin);
        if O::COUNTS {
            observer.steps(self.caster.course_steps(ray, visible));
        }
        visible
    }

    /// Returns the first hit of a camera ray or a secondary ray.
    #[inline(always)]
    fn nearest<O: Observer>(&self, ray: &Ray, origin: RayOrigin, observer: &mut O) -> Option<Visible> {
        let visible = self.cast(ray, origin, observer);
        observer.observe(|| Event::Met(visible.map(|visible| self.world().hit(ray, visible))));
        visible
    }

    /// Returns the surface that a ray hits first.
    #[inline(always)]
    fn surface(&self, ray: &Ray, visible: Visible) -> SurfacePoint {
        self.smooth(self.world().visible_surface(ray, visible))
    }

    /// Returns a surface with the smooth normal of its mesh, if that has one.
    #[inline(always)]
    fn smooth(&self, mut surface: SurfacePoint) -> SurfacePoint {
        if self.world().has_smooth_normals() {
            surface.normal = self.world().smooth_normal(&surface).unwrap_or(surface.normal);
        }
        surface
    }

    /// Returns the colour along a ray without its secondary rays, which are pushed to the stack.
    ///
    /// The function is inlined: a colour returned through memory would be written in two parts and read as a whole,
    /// which is slow.
    #[inline(always)]
    fn local_color<O: Observer>(
        &self,
        ray: &Ray,
        path: &Path,
        surface: Option<&SurfacePoint>,
        stack: &mut RayStack,
        observer: &mut O,
    ) -> Color {
        let color = match surface {
            Some(surface) => {
                let RayStack { pending, mixture, .. } = stack;
                let material = material_of_surface(self.world(), surface, self.caster.level, mixture);
                observer.observe(|| Event::Surface { point: surface, material: material.phong });
                let arrival = Arrival { ray, path, surface, material };
                // An observer that counts also learns of the rays that are not followed.
                if O::COUNTS || path.bounces < self.effects.bounces {
                    self.push_secondary(&arrival, pending, observer);
                }
                self.shade(&arrival, observer)
            }
            None => self.world().background_along(ray.direction),
        };
        observer.observe(|| Event::Shaded(color));
        color
    }

    /// Returns the light that a surface itself reflects: ambient light, and light from the sources that are visible
    /// from it.
    #[inline(always)]
    fn shade<O: Observer>(&self, arrival: &Arrival, observer: &mut O) -> Color {
        let Arrival { ray, surface, material, .. } = arrival;
        let world = self.world();
        let highlight = world.lighting.highlight;
        // Only programs with Blinn's model tell the inside from the outside.
        let is_inside = highlight == Highlight::Blinn && surface.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if is_inside { -surface.normal } else { surface.normal };
        let to_viewer = -ray.direction;
        let mut color = world.ambient * world.ambient_color(surface, material.phong.diffuse);
        observer.observe(|| Event::Ambient(color));
        let has_many_lights = world.lights.len() >= LIGHTS_AT_ONCE;
        for (index, light) in world.lights.iter().enumerate() {
            if has_many_lights && index.is_multiple_of(LIGHTS_AT_ONCE) && self.caster.is_over() {
                break;
            }
            let light = incident(light, surface.position);
            let geometry = Geometry { cosine: normal.dot(light.direction), normal, to_viewer };
            let shows = material.shows(highlight, &light, geometry.cosine);
            // The course's program casts the shadow ray even if the light has no effect.
            if !O::COUNTS && !shows {
                continue;
            }
            let passed = self.light_passed(surface, &light, index, observer);
            if shows && passed != Color::ZERO {
                color += passed * material.reflect(highlight, &light, &geometry);
            }
            observer.observe(|| {
                let parts = material.parts(highlight, &light, &geometry);
                Event::Light { incident: light, cosine: geometry.cosine, passed, parts }
            });
        }
        color
    }

    /// Returns a ray that starts on a surface. Its origin is moved off the surface by a few roundings, to the side of
    /// its direction. If the scene has an epsilon, this is the ray's `t_min` instead.
    #[inline(always)]
    fn departing(&self, surface: &SurfacePoint, direction: DVec3) -> Ray {
        let SurfacePoint { position, normal, extent, .. } = *surface;
        let (origin, t_min) = match self.world().lighting.epsilon {
            Some(t_min) => (position, t_min),
            None => (offset_origin(position, normal, direction, extent), 0.0),
        };
        Ray { t_min, ..Ray::new(origin, direction) }
    }

    /// Returns the origin of rays from a surface. If the scene has an epsilon, they are tested against every primitive.
    #[inline(always)]
    fn origin(&self, surface: &SurfacePoint) -> RayOrigin {
        let has_epsilon = self.world().lighting.epsilon.is_some();
        if has_epsilon { RayOrigin::FREE } else { RayOrigin::on(self.world(), surface.primitive) }
    }
}

#[cfg(test)]
mod tests;
