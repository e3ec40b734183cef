//! The colours of rays whose surfaces are known: those of the tracer, with fewer shadow rays.

use super::raster::{Blocker, ShadowMaps};
use crate::caster::Caster;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::model::Highlight;
use crate::shading::light::{Incident, incident};
use crate::shading::phong::{Mixture, View};
use crate::stats::Quiet;
use crate::trace::{Arrival, Path, Patience, Rules, SecondaryRay, Shadows, Tracer};
use crate::world::{SurfacePoint, World};
use fearless_simd::{Simd, dispatch};
use fearless_simd_macros::simd;

/// Colours rays by these rules, none of which is a mistake.
#[derive(Debug)]
pub struct Shading<'a, R> {
    /// Says which rays leave a surface, and what they bring.
    pub tracer: Tracer<'a, R>,
    /// Casts rays for the rules.
    pub caster: &'a Caster<'a>,
    /// What is known of shadows before any ray is cast, if anything is.
    pub shadow_maps: Option<&'a ShadowMaps>,
}

/// What is kept from one camera ray to the next, and how many rays were cast for them all.
#[derive(Debug)]
pub struct Memory<'a> {
    /// How long secondary rays are followed.
    pub patience: Patience<'a>,
    /// A stack of secondary rays, kept so that the loop allocates no memory.
    pending: Vec<SecondaryRay>,
    mixture: Mixture,
    /// The number of secondary and shadow rays.
    pub rays: u64,
}

impl<'a> Memory<'a> {
    /// Of nothing.
    pub fn new(patience: Patience<'a>) -> Self {
        Self { patience, pending: vec![], mixture: Mixture::default(), rays: 0 }
    }
}

impl<R: Rules> Shading<'_, R> {
    fn world(&self) -> &World {
        self.tracer.world()
    }

    /// The colour along a camera ray, with its secondary rays.
    #[inline(always)]
    pub fn color(&self, ray: &Ray, surface: Option<&SurfacePoint>, memory: &mut Memory) -> Color {
        let rules = self.tracer.rules;
        let Some(surface) = surface else { return rules.background(ray.direction, Path::CAMERA.bounces) };
        let color = self.follow(ray, &Path::CAMERA, surface, memory);
        if memory.pending.is_empty() {
            return color;
        }
        dispatch!(self.caster.level, simd => self.add_secondary(simd, color, memory))
    }

    /// Adds the colours of the secondary rays that wait, and of those that they cause in turn.
    #[simd]
    #[inline(never)]
    fn add_secondary<S: Simd>(&self, _: S, mut color: Color, memory: &mut Memory) -> Color {
        // Only the parts of a branch are copied. It was written in parts just before, so that reading it as whole
        // vectors would fail to forward the stores, and the processor would stall.
        while let Some(SecondaryRay { ray, leaves, path }) = memory.pending.pop() {
            if memory.patience.ends(memory.pending.len()) {
                memory.pending.clear();
                break;
            }
            memory.rays += 1;
            let rules = self.tracer.rules;
            let seen = match self.caster.nearest(&ray, leaves, &mut Quiet) {
                Some(visible) => self.follow(&ray, &path, &rules.surface(&ray, visible), memory),
                None => rules.background(ray.direction, path.bounces),
            };
            color += path.filter * seen;
        }
        color
    }

    /// The local colour of a hit. Its reflected and refracted rays are pushed to the memory's `pending`.
    ///
    /// This is inlined because a colour that is returned through memory would be written in two parts and
    /// read as a whole, so that store forwarding fails and the processor stalls.
    #[inline(always)]
    fn follow(&self, ray: &Ray, path: &Path, surface: &SurfacePoint, memory: &mut Memory) -> Color {
        let Memory { pending, mixture, rays, .. } = memory;
        let material = self.tracer.rules.material(surface, mixture);
        let arrival = Arrival { ray, surface, material };
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
        let Arrival { ray, surface, material } = arrival;
        let highlight = self.tracer.rules.model().highlight;
        let is_inside = highlight == Highlight::Blinn && surface.normal.dot(ray.direction) > 0.0;
        if is_inside && !self.tracer.effects.shade_back {
            return Color::ZERO;
        }
        let normal = if is_inside { -surface.normal } else { surface.normal };
        let to_viewer = -ray.direction;
        let mut color = self.tracer.rules.ambient(surface, material.phong);
        for (light_index, light) in self.world().lights.iter().enumerate() {
            let light = incident(light, surface.position);
            let cosine = normal.dot(light.direction);
            if material.shows(highlight, &light, cosine) {
                let passed = self.light_passed(arrival, (&light, light_index, is_inside), rays);
                if passed != Color::ZERO {
                    color +=
                        passed * material.reflect(highlight, &light, &View { cosine, normal, to_viewer });
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
            let start = self.tracer.shadow_ray(surface, light);
            let starts_within = surface.normal.dot(light.direction) < 0.0;
            return self.tracer.filtered(start, index, starts_within, &mut Quiet);
        }
        if !self.world().primitives_at_light(index).is_empty() {
            return Color::ZERO;
        }
        let blocker = self.blocker(surface, index, is_inside);
        // The ray leaves the only plane.
        let left = if self.tracer.rules.model().epsilon.is_none() { surface.primitive } else { None };
        if blocker == Blocker::Nothing && self.caster.has_no_plane_but(left) {
            return Color::ONE;
        }
        let (ray, leaves) = self.tracer.shadow_ray(surface, light);
        let is_blocked = match blocker {
            Blocker::Any => self.caster.any_from(&ray, leaves, &mut Quiet),
            Blocker::Only(triangle) => {
                self.caster.is_hit(&ray, triangle, leaves) || self.caster.meets_plane(&ray, leaves)
            }
            Blocker::Nothing => self.caster.meets_plane(&ray, leaves),
        };
        if is_blocked { Color::ZERO } else { Color::ONE }
    }

    /// What a ray from a surface to the light with this index may hit. A map knows nothing of a ray from a sphere, and
    /// one from an inner side hits the surface itself.
    #[inline(always)]
    fn blocker(&self, surface: &SurfacePoint, index: usize, is_inside: bool) -> Blocker {
        let is_round = surface.primitive.is_some_and(|primitive| self.caster.is_round(primitive));
        match self.shadow_maps {
            Some(maps) if !is_inside && !is_round => maps.blocker(index, surface.position),
            _ => Blocker::Any,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::caster::Caster;
    use crate::caster::choose::Layout;
    use crate::math::instructions;
    use crate::math::ray::Ray;
    use crate::scene::parser::parse;
    use crate::stats::Counts;
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
    fn camera_rays_have_the_colours_of_the_tracer() {
        let world = World::new(&parse(TEXT).unwrap(), &[]).unwrap();
        let effects = Effects { shadows: Shadows::Opaque, shade_back: true, bounces: 4, min_weight: 0.01 };
        for level in instructions::available() {
            let caster = Caster::with(&world, Layout::Grid([6, 5, 7]), level).unwrap();
            let tracer = Tracer { rules: &caster, effects };
            let shading = Shading { tracer, caster: &caster, shadow_maps: None };
            let (mut memory, mut alone) = (Memory::new(Patience::endless()), Counts::default());
            for ray in (0..1500).map(camera_ray) {
                let visible = caster.nearest(&ray, None, &mut Quiet);
                let surface = visible.map(|visible| world.visible_surface(&ray, visible));
                let color = shading.color(&ray, surface.as_ref(), &mut memory);
                let expected = tracer.color_of(&ray, surface, &mut alone);
                let bits = |color: Color| color.to_array().map(f64::to_bits);
                assert_eq!(bits(color), bits(expected), "{ray:?}");
            }
            // The tracer also casts shadow rays to lights without effect.
            assert!(memory.rays < alone.rays() && memory.rays > alone.non_shadow_rays);
            assert!(alone.non_shadow_rays > 4 * 1500, "{}", alone.non_shadow_rays);
        }
    }
}
