//! The colour along a ray: local shading, shadows, reflection and refraction (Whitted, "An Improved
//! Illumination Model for Shaded Display", CACM 23(6), 1980).

use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::math::robust::offset_origin;
use crate::mode::{Fast, Mode};
use crate::scene::Color;
use crate::scene::limits::{BRIGHTEST, LARGEST};
use crate::shading::light::{Incident, incident};
use crate::shading::phong::PointMaterial;
use crate::shading::texture::material_at;
use crate::world::{SurfacePoint, World};
use glam::DVec3;
use serde::Serialize;

mod event;

pub use event::{End, Event, Observer, Secondary};

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

/// Traces rays through a world.
#[derive(Clone, Copy, Debug)]
pub struct Tracer<'a, M = Fast> {
    /// Finds the hits of rays.
    pub caster: &'a Caster<'a, M>,
    /// The effects that are modelled.
    pub effects: Effects,
}

/// The history of a ray since it left the camera.
#[derive(Clone, Copy, Debug)]
struct Path {
    /// The factor by which its colour contributes to the picture.
    filter: Color,
    /// The product of the lengths of the colours along the path, which is the weight in the course's program.
    weight: f64,
    bounces: u32,
    /// The index of refraction of the medium around the ray.
    index: f64,
}

impl Path {
    /// The path of a camera ray.
    const CAMERA: Self = Self { filter: Color::ONE, weight: 1.0, bounces: 0, index: 1.0 };
}

/// A secondary ray that has not been traced yet.
#[derive(Clone, Copy, Debug)]
struct Branch {
    ray: Ray,
    /// The triangle that the ray leaves.
    exclude: Option<u32>,
    path: Path,
}

/// The stack of secondary rays, kept from one camera ray to the next so that the loop allocates no memory.
#[derive(Debug, Default)]
pub struct Pending(Vec<Branch>);

/// A hit with everything that shading needs.
struct Lit<'r> {
    ray: &'r Ray,
    surface: &'r SurfacePoint,
    material: &'r PointMaterial<'r>,
}

impl<M: Mode> Tracer<'_, M> {
    fn world(&self) -> &World {
        self.caster.world
    }

    /// The material of a surface, with its textures evaluated at the point.
    #[inline(always)]
    fn material(&self, surface: &SurfacePoint) -> PointMaterial<'_> {
        let Caster { world, instructions, .. } = *self.caster;
        material_at(&world.materials, surface.material, surface.position, instructions)
    }

    /// The colour along a camera ray, given the surface that it hits.
    ///
    /// Secondary rays are kept on an explicit stack instead of being traced by recursion, so that the number
    /// of bounces is limited by nothing but memory.
    #[inline(always)]
    pub fn color<P: Observer>(
        &self,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        pending: &mut Pending,
        probe: &mut P,
    ) -> Color {
        let color = self.follow(ray, &Path::CAMERA, surface, pending, probe);
        if pending.0.is_empty() { color } else { self.with_pending(color, pending, probe) }
    }

    /// Adds the colours of the pending secondary rays, and of those that they cause in turn.
    #[cold]
    fn with_pending<P: Observer>(&self, mut color: Color, pending: &mut Pending, probe: &mut P) -> Color {
        while let Some(Branch { ray, exclude, path }) = pending.0.pop() {
            if P::OBSERVES {
                probe.observe(Event::Popped);
            }
            probe.non_shadow_ray();
            let visible = self.caster.nearest(&ray, exclude, probe);
            if P::OBSERVES {
                probe.observe(Event::Met(visible));
            }
            let surface = visible.map(|visible| self.world().visible_surface(&ray, visible));
            color += path.filter * self.follow(&ray, &path, surface.as_ref(), pending, probe);
        }
        color
    }

    /// The local colour of a hit. Its reflected and refracted rays are pushed to `pending`.
    ///
    /// This is inlined because a colour that is returned through memory would be written in two parts and
    /// read as a whole, so that store forwarding fails and the processor stalls.
    #[inline(always)]
    fn follow<P: Observer>(
        &self,
        ray: &Ray,
        path: &Path,
        surface: Option<&SurfacePoint>,
        pending: &mut Pending,
        probe: &mut P,
    ) -> Color {
        let Some(surface) = surface else {
            if P::OBSERVES {
                probe.observe(Event::Shaded(self.world().background));
            }
            return self.world().background;
        };
        let material = self.material(surface);
        if P::OBSERVES {
            probe.observe(Event::Surface { point: surface, material: &material.phong });
        }
        let lit = Lit { ray, surface, material: &material };
        if path.bounces < self.effects.bounces {
            self.reflect(path, &lit, pending, probe);
            self.refract(path, &lit, pending, probe);
        } else if P::OBSERVES {
            let phong = &material.phong;
            probe.observe(Secondary::Reflected.ends(End::of(phong.reflective, End::Bounces)));
            probe.observe(Secondary::Refracted.ends(End::of(phong.transparent, End::Bounces)));
        }
        let color = self.shade(&lit, probe);
        if P::OBSERVES {
            probe.observe(Event::Shaded(color));
        }
        color
    }

    /// The local colour: ambient light, and the lights that are visible from the point.
    fn shade<P: Observer>(&self, lit: &Lit, probe: &mut P) -> Color {
        let Lit { ray, surface, material } = *lit;
        let is_inside = surface.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if is_inside { -surface.normal } else { surface.normal };
        let to_viewer = -ray.direction;
        let mut color = self.world().ambient * material.phong.diffuse;
        if P::OBSERVES {
            probe.observe(Event::Ambient(color));
        }
        let is_black = material.is_black();
        for light in &self.world().lights {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            // The course's program casts the shadow ray first. Its result matters only where the light has an
            // effect.
            let has_effect = cosine > 0.0 && !is_black && light.color != Color::ZERO;
            let passed =
                if has_effect || M::AS_COURSE { self.light_passed(lit, &light, probe) } else { Color::ZERO };
            if has_effect && passed != Color::ZERO {
                color += passed * material.reflect(&light, cosine, normal, to_viewer);
            }
            if P::OBSERVES {
                let parts = material.parts(&light, cosine, normal, to_viewer);
                probe.observe(Event::Light { incident: light, cosine, passed, parts });
            }
        }
        color
    }

    /// How much of a light reaches the surface, per channel.
    fn light_passed<P: Observer>(&self, lit: &Lit, light: &Incident, probe: &mut P) -> Color {
        if self.effects.shadows == Shadows::None {
            return Color::ONE;
        }
        probe.shadow_ray();
        let mut ray = self.secondary(lit.surface, light.direction);
        // The distance to a point light is measured from the origin of the shadow ray.
        ray.t_max = light.distance;
        if P::OBSERVES {
            probe.observe(Event::ShadowRay(ray));
        }
        match self.effects.shadows {
            Shadows::Transparent => self.filtered(ray, probe),
            _ if self.caster.any_from(&ray, lit.surface.triangle, probe) => Color::ZERO,
            _ => Color::ONE,
        }
    }

    /// The fraction of light that transparent objects transmit along a shadow ray. Where the ray leaves an
    /// object, this is the object's colour to the power of the distance since the last surface (Beer's law).
    fn filtered<P: Observer>(&self, mut ray: Ray, probe: &mut P) -> Color {
        let mut passed = Color::ONE;
        while let Some(hit) = self.caster.closest(&ray, probe) {
            let surface = self.world().surface(&ray, &hit);
            let material = self.material(&surface);
            let tint = material.phong.transparent;
            let leaves = surface.normal.dot(ray.direction) >= 0.0;
            if P::OBSERVES {
                probe.observe(Event::Crossed { hit, tint, leaves });
            }
            if tint == Color::ZERO {
                return Color::ZERO;
            }
            if leaves {
                passed = (passed * transmittance(tint, hit.t)).min(Color::splat(LARGEST));
            }
            ray = Ray { t_max: ray.t_max - hit.t, ..self.secondary(&surface, ray.direction) };
        }
        passed
    }

    fn secondary(&self, surface: &SurfacePoint, direction: DVec3) -> Ray {
        Ray::new(
            offset_origin(surface.position, surface.normal, direction, self.world().max_abs_coord),
            direction,
        )
    }

    fn reflect<P: Observer>(&self, path: &Path, lit: &Lit, pending: &mut Pending, probe: &mut P) {
        let color = lit.material.phong.reflective;
        let Some((filter, weight)) = self.filter_and_weight(path, color) else {
            if P::OBSERVES {
                probe.observe(Secondary::Reflected.ends(too_light(path, color)));
            }
            return;
        };
        let ray = self.secondary(lit.surface, reflected(lit.ray.direction, lit.surface.normal));
        let path = Path { filter, weight, bounces: path.bounces + 1, index: path.index };
        let exclude = lit.surface.triangle;
        if P::OBSERVES {
            probe.observe(Event::Pushed { kind: Secondary::Reflected, ray, exclude, filter, weight });
        }
        pending.0.push(Branch { ray, exclude, path });
    }

    fn refract<P: Observer>(&self, path: &Path, lit: &Lit, pending: &mut Pending, probe: &mut P) {
        let material = &lit.material.phong;
        let Some((filter, weight)) = self.filter_and_weight(path, material.transparent) else {
            if P::OBSERVES {
                probe.observe(Secondary::Refracted.ends(too_light(path, material.transparent)));
            }
            return;
        };
        let (d, n) = (lit.ray.direction, lit.surface.normal);
        let entering = d.dot(n) < 0.0;
        let (normal, index) = if entering { (n, material.index_of_refraction) } else { (-n, 1.0) };
        let Some(direction) = refracted(d, normal, path.index / index) else {
            if P::OBSERVES {
                probe.observe(Secondary::Refracted.ends(End::TotalReflection));
            }
            return;
        };
        let ray = self.secondary(lit.surface, direction);
        let path = Path { filter, weight, bounces: path.bounces + 1, index };
        let exclude = lit.surface.triangle;
        if P::OBSERVES {
            probe.observe(Event::Pushed { kind: Secondary::Refracted, ray, exclude, filter, weight });
        }
        pending.0.push(Branch { ray, exclude, path });
    }

    /// The filter and the weight of a secondary ray, if its weight is large enough for it to be traced.
    fn filter_and_weight(&self, path: &Path, color: Color) -> Option<(Color, f64)> {
        let weight = path.weight * color.length();
        let bound = Color::splat(BRIGHTEST);
        (weight > self.effects.min_weight).then(|| ((path.filter * color).clamp(-bound, bound), weight))
    }
}

/// Why a secondary ray ends that weighs too little, or nothing at all.
fn too_light(path: &Path, color: Color) -> End {
    End::of(color, End::Weight { weight: path.weight * color.length() })
}

/// The fraction of light that is transmitted over a distance inside a transparent object: the object's colour
/// to the power of the distance. A negative channel, which has no such power, transmits nothing.
pub fn transmittance(color: Color, distance: f64) -> Color {
    Color::from_array(color.to_array().map(|channel| libm::pow(channel.max(0.0), distance)))
}

/// The direction of a reflected ray, as a unit vector. The normal may point to either side.
pub fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// The direction of a refracted ray, as a unit vector; none at total internal reflection. `ratio` is the
/// index of refraction in front of the surface over the one behind it, and `normal` points against
/// `direction`.
///
/// The direction is computed as the sum of its tangential and its normal component, because both are then
/// accurate at grazing incidence, where a formula that subtracts cosines suffers from cancellation. The
/// square of the normal component is 1 - |tangential|^2, or equivalently (1 - ratio^2) + (ratio * cosine)^2.
/// Of these two the one that subtracts the smaller number has less cancellation.
pub fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = direction.dot(normal);
    let tangential = ratio * (direction - cosine * normal);
    let normal_squared = if ratio * ratio < 1.5 {
        (1.0 - ratio) * (1.0 + ratio) + (ratio * cosine) * (ratio * cosine)
    } else {
        1.0 - tangential.length_squared()
    };
    (normal_squared >= 0.0).then(|| (tangential - normal_squared.sqrt() * normal).normalize())
}

#[cfg(test)]
mod tests;
