//! One ray to one colour: local shading, shadows, reflection, refraction.

use crate::grid::Caster;
use crate::math::ray::Ray;
use crate::math::robust::offset_origin;
use crate::mode::{Fast, Mode};
use crate::scene::Color;
use crate::scene::limits::{BRIGHTEST, LARGEST};
use crate::shading::light::{Incident, incident};
use crate::shading::phong::PointMaterial;
use crate::shading::texture::material_at;
use crate::stats::Probe;
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// What casts shadows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Shadows {
    /// Nothing.
    #[default]
    None,
    /// Everything, transparent or not.
    Opaque,
    /// Transparent things filter the light by the way it goes inside them.
    Transparent,
}

/// What is modelled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effects {
    /// What casts shadows.
    pub shadows: Shadows,
    /// Light surfaces also from within; without it their inside is black.
    pub shade_back: bool,
    /// How many times a ray may be reflected or refracted.
    pub bounces: u32,
    /// A secondary ray is followed when it weighs more than this.
    pub min_weight: f64,
}

/// Traces rays through a world.
#[derive(Clone, Copy, Debug)]
pub struct Tracer<'a, M = Fast> {
    /// Finds what rays hit.
    pub caster: &'a Caster<'a, M>,
    /// What is modelled.
    pub effects: Effects,
}

/// How a ray came to be where it runs.
#[derive(Clone, Copy, Debug)]
struct Path {
    /// What its colour is multiplied by on the way to the picture.
    filter: Color,
    /// The product of the filters' lengths, as the course weighs rays.
    weight: f64,
    bounces: u32,
    /// Index of refraction of what the ray runs through.
    index: f64,
}

impl Path {
    /// Of a ray that starts at the camera.
    const CAMERA: Self = Self { filter: Color::ONE, weight: 1.0, bounces: 0, index: 1.0 };
}

/// A secondary ray that waits for its turn.
#[derive(Clone, Copy, Debug)]
struct Branch {
    ray: Ray,
    /// The triangle that it starts at.
    exclude: Option<u32>,
    path: Path,
}

/// Secondary rays that wait, kept between rays so that no memory is asked for in the loop.
#[derive(Debug, Default)]
pub struct Pending(Vec<Branch>);

/// A hit with all that shading needs.
struct Lit<'r> {
    ray: &'r Ray,
    surface: &'r SurfacePoint,
    material: &'r PointMaterial<'r>,
}

impl<M: Mode> Tracer<'_, M> {
    fn world(&self) -> &World {
        self.caster.world
    }

    /// The colour seen along a camera ray, given the surface that it hits.
    ///
    /// A stack instead of recursion: any number of bounces fits, and a mirror hall costs no stack.
    #[inline(always)]
    pub fn color<P: Probe>(
        &self,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        pending: &mut Pending,
        probe: &mut P,
    ) -> Color {
        let color = self.follow(ray, &Path::CAMERA, surface, pending, probe);
        if pending.0.is_empty() { color } else { self.with_pending(color, pending, probe) }
    }

    /// Adds the colours of the secondary rays that wait, and of those that they leave in turn.
    #[cold]
    fn with_pending<P: Probe>(&self, mut color: Color, pending: &mut Pending, probe: &mut P) -> Color {
        while let Some(Branch { ray, exclude, path }) = pending.0.pop() {
            probe.non_shadow_ray();
            let visible = self.caster.nearest(&ray, exclude, probe);
            let surface = visible.map(|visible| self.world().visible_surface(&ray, visible));
            color += path.filter * self.follow(&ray, &path, surface.as_ref(), pending, probe);
        }
        color
    }

    /// The colour of one hit by itself; what it reflects and lets through goes to `pending`.
    ///
    /// Inlined, since a colour returned through memory is written in halves and read as one, for
    /// which the processor waits.
    #[inline(always)]
    fn follow<P: Probe>(
        &self,
        ray: &Ray,
        path: &Path,
        surface: Option<&SurfacePoint>,
        pending: &mut Pending,
        probe: &mut P,
    ) -> Color {
        let Some(surface) = surface else { return self.world().background };
        let material = material_at(&self.world().materials, surface.material, surface.position);
        let lit = Lit { ray, surface, material: &material };
        if path.bounces < self.effects.bounces {
            self.reflect(path, &lit, pending);
            self.refract(path, &lit, pending);
        }
        self.shade(&lit, probe)
    }

    /// Ambient light and the lights that are seen from the point.
    fn shade<P: Probe>(&self, lit: &Lit, probe: &mut P) -> Color {
        let Lit { ray, surface, material } = *lit;
        let from_within = surface.normal.dot(ray.direction) > 0.0;
        if from_within && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if from_within { -surface.normal } else { surface.normal };
        let to_viewer = -ray.direction;
        let mut color = self.world().ambient * material.phong.diffuse;
        let is_black = material.is_black();
        for light in &self.world().lights {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            // The course's program casts the shadow ray first. It matters only where the light would show.
            let shows = cosine > 0.0 && !is_black && light.color != Color::ZERO;
            let passed =
                if shows || M::AS_COURSE { self.light_passed(lit, &light, probe) } else { Color::ZERO };
            if shows && passed != Color::ZERO {
                color += passed * material.reflect(&light, cosine, normal, to_viewer);
            }
        }
        color
    }

    /// How much of a light reaches the surface, per channel.
    fn light_passed<P: Probe>(&self, lit: &Lit, light: &Incident, probe: &mut P) -> Color {
        if self.effects.shadows == Shadows::None {
            return Color::ONE;
        }
        probe.shadow_ray();
        let mut ray = self.secondary(lit.surface, light.direction);
        // A point light's distance is counted from where the shadow ray starts.
        ray.t_max = light.distance;
        match self.effects.shadows {
            Shadows::Transparent => self.filtered(ray, probe),
            _ if self.caster.any_from(&ray, lit.surface.triangle, probe) => Color::ZERO,
            _ => Color::ONE,
        }
    }

    /// What transparent things leave of light along a shadow ray: where it comes out of one, its
    /// colour to the power of the distance since the last surface.
    fn filtered<P: Probe>(&self, mut ray: Ray, probe: &mut P) -> Color {
        let mut passed = Color::ONE;
        while let Some(hit) = self.caster.closest(&ray, probe) {
            let surface = self.world().surface(&ray, &hit);
            let material = material_at(&self.world().materials, surface.material, surface.position);
            let tint = material.phong.transparent;
            if tint == Color::ZERO {
                return Color::ZERO;
            }
            if surface.normal.dot(ray.direction) >= 0.0 {
                passed = (passed * tint_over(tint, hit.t)).min(Color::splat(LARGEST));
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

    fn reflect(&self, path: &Path, lit: &Lit, pending: &mut Pending) {
        let Some((filter, weight)) = self.passes(path, lit.material.phong.reflective) else { return };
        let ray = self.secondary(lit.surface, reflected(lit.ray.direction, lit.surface.normal));
        let path = Path { filter, weight, bounces: path.bounces + 1, index: path.index };
        pending.0.push(Branch { ray, exclude: lit.surface.triangle, path });
    }

    fn refract(&self, path: &Path, lit: &Lit, pending: &mut Pending) {
        let material = &lit.material.phong;
        let Some((filter, weight)) = self.passes(path, material.transparent) else { return };
        let (d, n) = (lit.ray.direction, lit.surface.normal);
        let entering = d.dot(n) < 0.0;
        let (normal, index) = if entering { (n, material.index_of_refraction) } else { (-n, 1.0) };
        let Some(direction) = refracted(d, normal, path.index / index) else { return };
        let ray = self.secondary(lit.surface, direction);
        let path = Path { filter, weight, bounces: path.bounces + 1, index };
        pending.0.push(Branch { ray, exclude: lit.surface.triangle, path });
    }

    /// The filter and weight of a secondary ray, if it weighs enough to be followed.
    fn passes(&self, path: &Path, color: Color) -> Option<(Color, f64)> {
        let weight = path.weight * color.length();
        let bound = Color::splat(BRIGHTEST);
        (weight > self.effects.min_weight).then(|| ((path.filter * color).clamp(-bound, bound), weight))
    }
}

/// What is left of light after so long a way through a transparent thing: its colour to the power of the
/// way. A negative colour lets nothing through, as it has no such power.
fn tint_over(tint: Color, way: f64) -> Color {
    Color::from_array(tint.to_array().map(|channel| libm::pow(channel.max(0.0), way)))
}

/// The direction of a mirrored ray, a unit vector; the normal may point to either side.
pub fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// The direction of a refracted ray; none at total internal reflection. `ratio` is the index of
/// refraction before the surface over the one behind it, `normal` points against `direction`.
///
/// Split into its parts along the surface and into it, so that both keep their digits at grazing
/// incidence, where a formula that subtracts cosines loses them. The square of the part inward is
/// one less that of the part along, and also 1 - ratio^2 more than that of `ratio` times the cosine.
/// The form that subtracts the smaller number loses the less.
pub fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = direction.dot(normal);
    let along = ratio * (direction - cosine * normal);
    let inward = if ratio * ratio < 1.5 {
        (1.0 - ratio) * (1.0 + ratio) + (ratio * cosine) * (ratio * cosine)
    } else {
        1.0 - along.length_squared()
    };
    (inward >= 0.0).then(|| (along - inward.sqrt() * normal).normalize())
}

#[cfg(test)]
mod tests;
