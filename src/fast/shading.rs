//! The colours of rays whose surfaces are known: those of the tracer, with fewer shadow rays, and with the secondary rays
//! of several camera rays side by side.

use super::raster::{Blocker, ShadowMaps};
use super::side_by_side::Cast;
use crate::caster::Caster;
#[cfg(target_arch = "x86_64")]
use crate::math::avx::Avx;
use crate::math::f64x4::{F64x4, Scalar};
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::math::ray::Ray;
use crate::sampling::sample_packet::SamplePacket;
use crate::scene::Color;
use crate::shading::light::{Incident, incident};
use crate::shading::phong::Mixture;
use crate::stats::Quiet;
use crate::trace::{Arrival, Path, Rules, SecondaryRay, Shadows, Tracer};
use crate::world::{SurfacePoint, World};

/// Colours rays.
#[derive(Clone, Copy, Debug)]
pub struct Shading<'a> {
    /// Says which rays leave a surface, and what they bring.
    pub tracer: Tracer<'a, Caster<'a>>,
    /// What is known of shadows before any ray is cast, if anything is.
    pub shadow_maps: Option<&'a ShadowMaps>,
}

/// What is kept from one packet of camera rays to the next, and how many rays were cast for them all.
#[derive(Debug, Default)]
pub struct Memory {
    /// A stack of secondary rays for each camera ray, kept so that the loop allocates no memory.
    pub pending: [Vec<SecondaryRay>; SamplePacket::SIZE],
    /// The rays that are cast together.
    pub cast: Vec<Cast>,
    mixture: Mixture,
    /// The number of secondary and shadow rays.
    pub rays: u64,
}

impl Shading<'_> {
    fn caster(&self) -> &Caster<'_> {
        self.tracer.rules
    }

    fn world(&self) -> &World {
        self.tracer.world()
    }

    /// The colour along a camera ray without secondary rays, which wait in the memory for
    /// [`add_secondary`](Self::add_secondary).
    #[inline(always)]
    pub fn local_color(
        &self,
        ray: &Ray,
        surface: Option<&SurfacePoint>,
        camera_ray: usize,
        memory: &mut Memory,
    ) -> Color {
        match surface {
            Some(surface) => self.follow(ray, &Path::CAMERA, surface, camera_ray, memory),
            None => self.world().background,
        }
    }

    /// Adds the colours of the secondary rays that wait, and of those that they cause in turn, to the colours of their
    /// camera rays.
    #[inline(always)]
    pub fn add_secondary(&self, colors: &mut [Color], memory: &mut Memory) {
        if self.tracer.effects.bounces == 0 || memory.pending[..colors.len()].iter().all(Vec::is_empty) {
            return;
        }
        match self.caster().instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) => unsafe { add_secondary_avx2(avx2, self, colors, memory) },
            Instructions::Portable => self.add_secondary_with::<Scalar>(Portable, colors, memory),
        }
    }

    /// The same, compiled for the instructions of the caller.
    #[inline(always)]
    fn add_secondary_with<F: F64x4>(&self, proof: F::Proof, colors: &mut [Color], memory: &mut Memory) {
        if self.goes_side_by_side() {
            self.follow_side_by_side::<F>(proof, colors, memory);
        }
        for (camera_ray, color) in colors.iter_mut().enumerate() {
            if !memory.pending[camera_ray].is_empty() {
                *color = self.follow_pending(*color, camera_ray, memory);
            }
        }
    }

    /// Adds the secondary rays of one camera ray.
    #[inline(always)]
    fn follow_pending(&self, mut color: Color, camera_ray: usize, memory: &mut Memory) -> Color {
        // Only the parts of a branch are copied. It was written in parts just before, so that reading it as whole
        // vectors would fail to forward the stores, and the processor would stall.
        while let Some(SecondaryRay { ray, leaves, path }) = memory.pending[camera_ray].pop() {
            memory.rays += 1;
            let seen = match self.caster().nearest(&ray, leaves, &mut Quiet) {
                Some(visible) => {
                    let surface = self.world().visible_surface(&ray, visible);
                    self.follow(&ray, &path, &surface, camera_ray, memory)
                }
                None => self.world().background,
            };
            color += path.filter * seen;
        }
        color
    }

    /// The local colour of a hit. Its reflected and refracted rays are pushed to the memory's `pending` of this camera
    /// ray.
    ///
    /// This is inlined because a colour that is returned through memory would be written in two parts and
    /// read as a whole, so that store forwarding fails and the processor stalls.
    #[inline(always)]
    pub fn follow(
        &self,
        ray: &Ray,
        path: &Path,
        surface: &SurfacePoint,
        camera_ray: usize,
        memory: &mut Memory,
    ) -> Color {
        let Memory { pending, mixture, rays, .. } = memory;
        let pending = &mut pending[camera_ray];
        let material = self.caster().material(surface, mixture);
        let arrival = Arrival { direction: ray.direction, surface: *surface, material };
        if path.bounces < self.tracer.effects.bounces {
            self.tracer.reflect(path, &arrival, pending, &mut Quiet);
            self.tracer.refract(path, &arrival, pending, &mut Quiet);
        }
        self.shade(&arrival, rays)
    }

    /// The local colour: ambient light, and the lights that are visible from the point. No shadow ray is cast to a light
    /// without effect.
    #[inline(always)]
    fn shade(&self, arrival: &Arrival, rays: &mut u64) -> Color {
        let Arrival { direction, surface, material } = arrival;
        let is_inside = surface.normal.dot(*direction) > 0.0;
        if is_inside && !self.tracer.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if is_inside { -surface.normal } else { surface.normal };
        let to_viewer = -*direction;
        let mut color = self.world().ambient * material.phong.diffuse;
        let is_black = material.is_black();
        for (light_index, light) in self.world().lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            if cosine > 0.0 && !is_black && light.color != Color::ZERO {
                let passed = self.light_passed(arrival, (&light, light_index, is_inside), rays);
                if passed != Color::ZERO {
                    color += passed * material.reflect(&light, cosine, normal, to_viewer);
                }
            }
        }
        color
    }

    /// How much of the light with this index reaches the side of the surface that is seen, per channel.
    #[inline(always)]
    fn light_passed(
        &self,
        arrival: &Arrival,
        (light, index, is_inside): (&Incident, usize, bool),
        rays: &mut u64,
    ) -> Color {
        let Arrival { surface, .. } = arrival;
        let shadows = self.tracer.effects.shadows;
        if shadows == Shadows::None {
            return Color::ONE;
        }
        *rays += 1;
        if shadows == Shadows::Transparent {
            let (ray, _) = self.tracer.shadow_ray(surface, light);
            let starts_within = surface.normal.dot(light.direction) < 0.0;
            return self.tracer.filtered(ray, index, starts_within, &mut Quiet);
        }
        if !self.world().triangles_at_light(index).is_empty() {
            return Color::ZERO;
        }
        let blocker = self.blocker(surface, index, is_inside);
        // The ray leaves the only plane.
        if blocker == Blocker::Nothing && self.caster().has_no_plane_but(surface.primitive) {
            return Color::ONE;
        }
        let (ray, leaves) = self.tracer.shadow_ray(surface, light);
        let is_blocked = match blocker {
            Blocker::Any => self.caster().any_from(&ray, leaves, &mut Quiet),
            Blocker::Only(triangle) => {
                self.caster().is_hit(&ray, triangle, leaves) || self.caster().meets_plane(&ray, leaves)
            }
            Blocker::Nothing => self.caster().meets_plane(&ray, leaves),
        };
        if is_blocked { Color::ZERO } else { Color::ONE }
    }

    /// What a ray from a surface to the light with this index may hit. A map knows nothing of a ray from a sphere, and
    /// one from an inner side hits the surface itself.
    #[inline(always)]
    fn blocker(&self, surface: &SurfacePoint, index: usize, is_inside: bool) -> Blocker {
        let is_round = surface.primitive.is_some_and(|primitive| self.caster().is_round(primitive));
        match self.shadow_maps {
            Some(maps) if !is_inside && !is_round => maps.blocker(index, surface.position),
            _ => Blocker::Any,
        }
    }
}

/// Adds the colours of the secondary rays that wait, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn add_secondary_avx2(avx2: Avx2, shading: &Shading, colors: &mut [Color], memory: &mut Memory) {
    shading.add_secondary_with::<Avx>(avx2, colors, memory);
}
