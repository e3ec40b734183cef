//! The tracer: the recursion of Whitted ("An Improved Illumination Model for Shaded Display", CACM 23(6), 1980), one
//! ray at a time. It defines the picture, and does what the course's program does, so that an observer can count it.
//!
//! A ray's colour is that of the surface that it hits, by ambient light and by the lights that are visible from there,
//! and of the rays that are reflected and refracted there.

use crate::math::ray::{Ray, Visible};
use crate::picture::Color;
use crate::scene::model::Highlight;
use crate::shading::light::incident;
use crate::shading::phong::{Mixture, PointMaterial, View};
use crate::world::{SurfacePoint, World};
use serde::Serialize;

mod observer;
mod optics;
mod patience;
mod rules;
mod secondary;
mod shadow;

pub use observer::{Event, Observer, PathEnd, Secondary};
pub(crate) use optics::refracted_between;
pub use optics::{is_critical, reflected, refracted, transmittance};
pub(crate) use patience::{MOST_WAITING, Patience};
pub(crate) use rules::painted;
pub use rules::{ByModel, Departure, Rules};
pub(crate) use secondary::{Path, SecondaryRay, mirrored_part};

/// Which objects cast shadows.
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

/// The effects that are modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Effects {
    /// Which objects cast shadows.
    pub shadows: Shadows,
    /// Whether surfaces are also lit on their inside. Otherwise it is black.
    pub shade_back: bool,
    /// The maximum number of times that a ray is reflected or refracted.
    pub bounces: u32,
    /// A secondary ray is traced if its weight is above this.
    pub min_weight: f64,
}

/// Traces rays by the rules of a caster, or by others that have mistakes.
#[derive(Debug)]
pub struct Tracer<'a, R> {
    /// The rules, which also find what rays hit.
    pub rules: &'a R,
    /// The effects that are modelled.
    pub effects: Effects,
}

// Implemented by hand, because a derived `Clone` would require that `R` is `Clone`.
impl<R> Clone for Tracer<'_, R> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<R> Copy for Tracer<'_, R> {}

/// A surface as a ray arrives at it, with everything that shading needs.
pub(crate) struct Arrival<'m> {
    pub ray: &'m Ray,
    pub surface: &'m SurfacePoint,
    pub material: PointMaterial<'m>,
}

impl<R: Rules> Tracer<'_, R> {
    #[inline(always)]
    pub(crate) fn world(&self) -> &World {
        self.rules.world()
    }

    /// The colour along a ray from the camera.
    pub fn color<O: Observer>(&self, ray: &Ray, observer: &mut O) -> Color {
        let surface = self.nearest(ray, None, observer).map(|visible| self.rules.surface(ray, visible));
        self.color_of(ray, surface, observer)
    }

    /// The same, given the surface that the ray hits first.
    pub fn color_of<O: Observer>(&self, ray: &Ray, surface: Option<SurfacePoint>, observer: &mut O) -> Color {
        self.color_with(&mut vec![], &mut Patience::endless(), ray, surface, observer)
    }

    /// Returns the colour, but stops following secondary rays when the patience ends.
    ///
    /// Secondary rays wait on a stack, `pending`, instead of being traced by a function that calls itself, so that the
    /// number of bounces is limited by nothing but the rays that wait. It is empty before and afterwards, and has its memory for the
    /// next ray.
    pub(crate) fn color_with<O: Observer>(
        &self,
        pending: &mut Vec<SecondaryRay>,
        patience: &mut Patience,
        ray: &Ray,
        surface: Option<SurfacePoint>,
        observer: &mut O,
    ) -> Color {
        let (mut ray, mut path, mut surface) = (*ray, Path::CAMERA, surface);
        // Negative zero, since x + 0 is not x if x is negative zero.
        let mut color = Color::splat(-0.0);
        loop {
            color += path.filter * self.local_color(&ray, &path, surface, pending, observer);
            let Some(next) = pending.pop() else { return color };
            if patience.ends(pending.len()) {
                pending.clear();
                return color;
            }
            observer.observe(|| Event::Popped);
            observer.non_shadow_ray();
            (ray, path) = (next.ray, next.path);
            let visible = self.nearest(&ray, next.leaves, observer);
            surface = visible.map(|visible| self.rules.surface(&ray, visible));
        }
    }

    /// What a ray hits first, if it leaves the primitive `leaves`.
    #[inline(always)]
    pub fn nearest<O: Observer>(&self, ray: &Ray, leaves: Option<u32>, observer: &mut O) -> Option<Visible> {
        let visible = self.rules.nearest(ray, leaves, observer);
        observer.observe(|| Event::Met(visible.map(|visible| self.rules.hit(ray, visible))));
        visible
    }

    /// The colour along a ray without its secondary rays, which are pushed to `pending`.
    #[inline(always)]
    pub(crate) fn local_color<O: Observer>(
        &self,
        ray: &Ray,
        path: &Path,
        surface: Option<SurfacePoint>,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) -> Color {
        let color = match surface {
            Some(surface) => {
                let mut mixture = Mixture::default();
                let material = self.rules.material(&surface, &mut mixture);
                observer.observe(|| Event::Surface { point: &surface, material: material.phong });
                let arrival = Arrival { ray, surface: &surface, material };
                self.reflect(path, &arrival, pending, observer);
                self.refract(path, &arrival, pending, observer);
                self.shade(&arrival, observer)
            }
            None => self.rules.background(ray.direction, path.bounces),
        };
        observer.observe(|| Event::Shaded(color));
        color
    }

    /// The colour of a surface by itself: ambient light, and the lights that are visible from the point.
    fn shade<O: Observer>(&self, arrival: &Arrival, observer: &mut O) -> Color {
        let Arrival { ray, surface, material } = arrival;
        let highlight = self.rules.model().highlight;
        let is_inside = highlight == Highlight::Blinn && surface.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = self.rules.shading_normal(surface.normal, ray.direction, is_inside);
        let to_viewer = -ray.direction;
        let mut color = self.rules.sum(Color::ZERO, self.rules.ambient(surface, material.phong));
        observer.observe(|| Event::Ambient(color));
        for (index, light) in self.world().lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            let view = View { cosine, normal, to_viewer };
            // The course's program casts the shadow ray even where the light has no effect.
            let passed = self.light_passed(arrival, &light, index, observer);
            if material.shows(highlight, &light, cosine) && passed != Color::ZERO {
                let lit = passed * self.rules.reflect(material, (&light, index), &view);
                color = self.rules.sum(color, self.rules.light(lit));
            }
            observer.observe(|| {
                let parts = material.parts(highlight, &light, &view);
                Event::Light { incident: light, cosine, passed, parts }
            });
        }
        color
    }
}

#[cfg(test)]
mod tests;
