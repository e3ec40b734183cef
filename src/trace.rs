//! The colour along a ray: local shading, shadows, reflection and refraction (Whitted, "An Improved
//! Illumination Model for Shaded Display", CACM 23(6), 1980).

use crate::fast::ShadowMaps;
use crate::grid::Caster;
#[cfg(target_arch = "x86_64")]
use crate::math::avx::Avx;
use crate::math::f64x4::{F64x4, Scalar};
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::math::ray::Ray;
use crate::mode::{Fast, Mode};
use crate::scene::Color;
use crate::scene::material::Material;
use crate::shading::light::incident;
use crate::shading::phong::{Mixture, PointMaterial};
use crate::shading::texture::material_at;
use crate::world::{SurfacePoint, World};
use glam::DVec3;
use serde::Serialize;

mod event;
mod optics;
mod secondary;
mod shadow;
mod side_by_side;

pub use event::{Event, Observer, PathEnd, Secondary};
pub(crate) use optics::refracted_between;
pub use optics::{reflected, refracted, transmittance};
use secondary::{Path, SecondaryRay};
use side_by_side::Cast;

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
    /// What is known of shadows before any ray is cast, if anything is.
    pub shadow_maps: Option<&'a ShadowMaps>,
}

/// The largest number of camera rays whose colours are computed together: so many that most of their secondary rays
/// have enough company, and so few that they stay in the cache.
pub const MOST_CAMERA_RAYS: usize = 32;

/// What is kept from one camera ray to the next.
#[derive(Debug, Default)]
pub struct Memory {
    /// A stack of secondary rays for each camera ray, kept so that the loop allocates no memory.
    pending: [Vec<SecondaryRay>; MOST_CAMERA_RAYS],
    /// The rays that are cast together.
    cast: Vec<Cast>,
    mixture: Mixture,
}

/// A hit with everything that shading needs. It has copies, which can stay in registers.
struct Lit<'r> {
    /// The direction of the ray.
    direction: DVec3,
    surface: SurfacePoint,
    material: PointMaterial<'r>,
}

impl<M: Mode> Tracer<'_, M> {
    fn world(&self) -> &World {
        self.caster.world
    }

    /// The material of a surface, with its textures evaluated at the point.
    #[inline(always)]
    fn material<'m>(&'m self, surface: &SurfacePoint, mixture: &'m mut Mixture) -> PointMaterial<'m> {
        let Caster { world, instructions, .. } = *self.caster;
        if let Material::Phong(phong) = &world.materials[surface.material] {
            return phong.into();
        }
        world.with_rounded_point(surface, |point| {
            material_at(&world.materials, surface.material, point, instructions, mixture)
        })
    }

    /// The colour along a camera ray, given the surface that it hits.
    pub fn color<P: Observer>(
        &self,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        memory: &mut Memory,
        probe: &mut P,
    ) -> Color {
        let mut colors = [self.local_color(ray, surface, 0, memory, probe)];
        self.add_secondary(&mut colors, memory, probe);
        let [color] = colors;
        color
    }

    /// The same without secondary rays, for the camera ray with this index among up to [`MOST_CAMERA_RAYS`]. Its
    /// secondary rays wait for [`add_secondary`](Self::add_secondary).
    #[inline(always)]
    pub fn local_color<P: Observer>(
        &self,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        camera_ray: usize,
        memory: &mut Memory,
        probe: &mut P,
    ) -> Color {
        match surface {
            Some(surface) => self.follow(ray, &Path::CAMERA, surface, camera_ray, memory, probe),
            None => self.background(probe),
        }
    }

    /// Adds the colours of the secondary rays that wait, and of those that they cause in turn, to the colours of their
    /// camera rays.
    ///
    /// Secondary rays are kept on explicit stacks instead of being traced by recursion, so that the number of bounces is
    /// limited by nothing but memory.
    #[inline(always)]
    pub fn add_secondary<P: Observer>(&self, colors: &mut [Color], memory: &mut Memory, probe: &mut P) {
        if self.effects.bounces == 0 || memory.pending[..colors.len()].iter().all(Vec::is_empty) {
            return;
        }
        match self.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE && !P::OBSERVES => unsafe {
                add_secondary_avx2(avx2, self, colors, memory, probe)
            },
            _ => self.add_secondary_with::<Scalar, _>(Portable, colors, memory, probe),
        }
    }

    /// The same, compiled for the instructions of the caller.
    #[inline(always)]
    fn add_secondary_with<F: F64x4, P: Observer>(
        &self,
        proof: F::Proof,
        colors: &mut [Color],
        memory: &mut Memory,
        probe: &mut P,
    ) {
        if self.goes_side_by_side::<P>() {
            self.follow_side_by_side::<F, _>(proof, colors, memory, probe);
        }
        for (camera_ray, color) in colors.iter_mut().enumerate() {
            if !memory.pending[camera_ray].is_empty() {
                *color = self.follow_pending(*color, camera_ray, memory, probe);
            }
        }
    }

    /// Adds the secondary rays of one camera ray.
    #[inline(always)]
    fn follow_pending<P: Observer>(
        &self,
        mut color: Color,
        camera_ray: usize,
        memory: &mut Memory,
        probe: &mut P,
    ) -> Color {
        // Only the parts of a branch are copied. It was written in parts just before, so that reading it as whole
        // vectors would fail to forward the stores, and the processor would stall.
        while let Some(SecondaryRay { ray, leaves, path }) = memory.pending[camera_ray].pop() {
            if P::OBSERVES {
                probe.observe(Event::Popped);
            }
            probe.non_shadow_ray();
            let visible = self.caster.nearest(&ray, leaves, probe);
            if P::OBSERVES {
                probe.observe(Event::Met(visible));
            }
            let seen = match visible {
                Some(visible) => {
                    let surface = self.world().visible_surface(&ray, visible);
                    self.follow(&ray, &path, &surface, camera_ray, memory, probe)
                }
                None => self.background(probe),
            };
            color += path.filter * seen;
        }
        color
    }

    /// The colour of a ray that hits nothing.
    #[inline(always)]
    fn background<P: Observer>(&self, probe: &mut P) -> Color {
        if P::OBSERVES {
            probe.observe(Event::Shaded(self.world().background));
        }
        self.world().background
    }

    /// The local colour of a hit. Its reflected and refracted rays are pushed to the memory's `pending` of this camera
    /// ray.
    ///
    /// This is inlined because a colour that is returned through memory would be written in two parts and
    /// read as a whole, so that store forwarding fails and the processor stalls.
    #[inline(always)]
    fn follow<P: Observer>(
        &self,
        ray: &Ray,
        path: &Path,
        surface: &SurfacePoint,
        camera_ray: usize,
        memory: &mut Memory,
        probe: &mut P,
    ) -> Color {
        let Memory { pending, mixture, .. } = memory;
        let pending = &mut pending[camera_ray];
        let material = self.material(surface, mixture);
        if P::OBSERVES {
            probe.observe(Event::Surface { point: surface, material: material.phong });
        }
        let lit = Lit { direction: ray.direction, surface: *surface, material };
        if path.bounces < self.effects.bounces {
            self.reflect(path, &lit, pending, probe);
            self.refract(path, &lit, pending, probe);
        } else if P::OBSERVES {
            let phong = material.phong;
            probe.observe(Secondary::Reflected.ends(PathEnd::of(phong.reflective, PathEnd::Bounces)));
            probe.observe(Secondary::Refracted.ends(PathEnd::of(phong.transparent, PathEnd::Bounces)));
        }
        let color = self.shade(&lit, probe);
        if P::OBSERVES {
            probe.observe(Event::Shaded(color));
        }
        color
    }

    /// The local colour: ambient light, and the lights that are visible from the point.
    #[inline(always)]
    fn shade<P: Observer>(&self, lit: &Lit, probe: &mut P) -> Color {
        let Lit { direction, surface, material } = lit;
        let is_inside = surface.normal.dot(*direction) > 0.0;
        if is_inside && !self.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if is_inside { -surface.normal } else { surface.normal };
        let to_viewer = -*direction;
        let mut color = self.world().ambient * material.phong.diffuse;
        if P::OBSERVES {
            probe.observe(Event::Ambient(color));
        }
        let is_black = material.is_black();
        for (light_index, light) in self.world().lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            // The course's program casts the shadow ray first. Its result matters only where the light has an
            // effect.
            let has_effect = cosine > 0.0 && !is_black && light.color != Color::ZERO;
            let passed = if has_effect || M::AS_COURSE {
                self.light_passed(lit, (&light, light_index, is_inside), probe)
            } else {
                Color::ZERO
            };
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
}

/// Adds the colours of the secondary rays that wait, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn add_secondary_avx2<M: Mode, P: Observer>(
    avx2: Avx2,
    tracer: &Tracer<M>,
    colors: &mut [Color],
    memory: &mut Memory,
    probe: &mut P,
) {
    tracer.add_secondary_with::<Avx, _>(avx2, colors, memory, probe);
}

#[cfg(test)]
mod tests;
