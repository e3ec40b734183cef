//! The secondary rays of several camera rays, side by side.
//!
//! Of all camera rays the next secondary rays are cast together, and their surfaces are found four at a time. The stages
//! of one ray depend on each other, while those of different rays overlap. Each camera ray keeps the order of its own
//! rays, so that its colour is the same sum as by itself.

use super::shading::{Memory, Shading};
use crate::caster::packet::PacketRay;
use crate::math::f64x4::F64x4;
use crate::math::lanes::lanes;
use crate::math::ray::{Ray, Visible};
use crate::scene::Color;
use crate::shortcut::Shortcut;
use crate::trace::SecondaryRay;
use crate::world::surfaces::Traced;

/// Fewer rays are followed one after the other.
const LEAST_RAYS: usize = 4;

/// Where a secondary ray comes from.
#[derive(Clone, Copy, Debug)]
pub struct Origin {
    /// The index of the camera ray.
    camera_ray: usize,
    /// The primitive that the ray leaves.
    leaves: Option<u32>,
}

/// A secondary ray that is cast.
pub type Cast = Traced<Origin>;

impl PacketRay for Cast {
    const LEAVES_A_SURFACE: bool = true;

    #[inline(always)]
    fn ray(&self) -> &Ray {
        &self.ray
    }

    #[inline(always)]
    fn leaves(&self) -> Option<u32> {
        self.source.leaves
    }

    #[inline(always)]
    fn set_visible(&mut self, visible: Option<Visible>) {
        self.visible = visible;
    }
}

impl Shading<'_> {
    /// Whether secondary rays are followed side by side. It pays where they traverse a grid with triangles.
    pub(super) fn goes_side_by_side(&self) -> bool {
        let has_triangles = !self.tracer.world().triangles.is_empty();
        Shortcut::SideBySide.is_taken() && has_triangles && self.tracer.rules.is_selective()
    }

    /// Adds the colours of the secondary rays to those of their camera rays, until few camera rays have any left.
    #[inline(always)]
    pub(super) fn follow_side_by_side<F: F64x4>(
        &self,
        proof: F::Proof,
        colors: &mut [Color],
        memory: &mut Memory,
    ) {
        let mut cast = std::mem::take(&mut memory.cast);
        // The set of the camera rays with secondary rays.
        let mut active = ((1u64 << colors.len()) - 1) as u32;
        loop {
            cast.clear();
            let mut next_active = 0;
            for camera_ray in lanes(active) {
                let pending = &memory.pending[camera_ray];
                if let Some(&SecondaryRay { ray, leaves, .. }) = pending.last() {
                    cast.push(Cast::new(Origin { camera_ray, leaves }, ray));
                    next_active |= 1 << camera_ray;
                }
            }
            active = next_active;
            if cast.len() < LEAST_RAYS {
                break;
            }
            self.tracer.rules.nearest_of_packet(&mut cast);
            self.tracer.world().find_surfaces::<F, _>(proof, &mut cast);
            for Cast { source: Origin { camera_ray, .. }, ray, surface, .. } in &cast {
                let Some(SecondaryRay { path, .. }) = memory.pending[*camera_ray].pop() else { continue };
                memory.rays += 1;
                let seen = match surface {
                    Some(surface) => self.follow(ray, &path, surface, *camera_ray, memory),
                    None => self.tracer.world().background,
                };
                colors[*camera_ray] += path.filter * seen;
            }
        }
        memory.cast = cast;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::choose::Layout;
    use crate::caster::{Caster, Instructions};
    use crate::sampling::sample_packet::SamplePacket;
    use crate::scene::parser::parse;
    use crate::stats::{Counts, Quiet};
    use crate::trace::{Effects, Shadows, Tracer};
    use crate::world::World;
    use glam::DVec3;

    /// Glass with a mirror's coating, that of boxes and that of a ball, a mirror that is a floor, and something dull.
    const TEXT: &str = "PerspectiveCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 angle 30 }
         Background { color .25 .5 1 ambientLight .125 .125 .125 }
         Lights { numLights 2 DirectionalLight { direction -1 -2 -1 color .5 .5 .5 }
         PointLight { position 0 4 0 color 1 .5 .25 } }
         Materials { numMaterials 3
         Material { diffuseColor .2 .3 .4 reflectiveColor .4 .3 .2 transparentColor .9 .8 .7 indexOfRefraction 1.5 }
         Material { diffuseColor .5 .1 .2 reflectiveColor .5 .5 .5 }
         Material { diffuseColor 1 .5 .25 specularColor 1 1 1 exponent 9 } }
         Group { numObjects 5
         MaterialIndex 0 Transform { Translate -1 .5 0 XRotate 40 Box { min -.7 -.7 -.7 max .7 .7 .7 } }
         MaterialIndex 0 Transform { Translate 1 .5 0 ZRotate 25 Box { min -.7 -.7 -.7 max .7 .7 .7 } }
         MaterialIndex 0 Sphere { center 0 .4 1.5 radius .6 }
         MaterialIndex 2 Box { min -3 -1 -3 max -2 2 -2 }
         MaterialIndex 1 Plane { normal 0 1 0 offset -1 } }";

    /// Camera rays from around the objects, some of which miss them. Neighbours are often close to each other.
    fn camera_ray(k: usize) -> Ray {
        let [turn, height, aim] = [k / 8, k % 5, k].map(|k| k as f64);
        let origin = DVec3::new(4.0 * turn.cos(), 0.2 + 0.5 * height, 4.0 * turn.sin());
        let target = DVec3::new(1.3 * (0.37 * aim).sin(), 0.9 * (0.61 * aim).cos() + 0.4, (0.23 * aim).sin());
        Ray::new(origin, (target - origin).normalize())
    }

    #[test]
    fn camera_rays_have_the_colours_that_they_have_alone() {
        let world = World::new(&parse(TEXT).unwrap(), &[]).unwrap();
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 4, min_weight: 0.01 };
        for instructions in Instructions::available() {
            let caster = Caster::with(&world, Layout::Grid([6, 5, 7]), instructions).unwrap();
            let tracer = Tracer { rules: &caster, effects };
            let shading = Shading { tracer, shadow_maps: None };
            assert!(shading.goes_side_by_side());
            let (mut memory, mut alone) = (Memory::default(), Counts::default());
            let mut first = 0;
            for count in (1..=SamplePacket::SIZE).cycle().take(100) {
                let rays: Vec<Ray> = (first..first + count).map(camera_ray).collect();
                let surface = |ray| Some(world.visible_surface(ray, caster.nearest(ray, None, &mut Quiet)?));
                let surfaces: Vec<_> = rays.iter().map(surface).collect();
                let mut colors = vec![];
                for (i, (ray, surface)) in rays.iter().zip(&surfaces).enumerate() {
                    colors.push(shading.local_color(ray, surface.as_ref(), i, &mut memory));
                }
                shading.add_secondary(&mut colors, &mut memory);
                for (color, (ray, surface)) in colors.iter().zip(rays.iter().zip(&surfaces)) {
                    let expected = tracer.color_of(ray, *surface, &mut alone);
                    let bits = |color: &Color| color.to_array().map(f64::to_bits);
                    assert_eq!(bits(color), bits(&expected), "{ray:?}");
                }
                first += count;
            }
            // The tracer also casts shadow rays to lights without effect.
            assert!(memory.rays < alone.rays() && memory.rays > alone.non_shadow_rays);
            assert!(alone.non_shadow_rays as usize > 4 * first, "{}", alone.non_shadow_rays);
        }
    }
}
