//! Secondary rays: the reflected and the refracted ray at a surface, the stack on which they wait, and the end of a
//! trace that takes too long.

use super::observer::{Event, Observer, PathEnd, Secondary};
use super::optics::{mirrored_part, reflected, refracted_between};
use super::{Arrival, Hints, Tracer};
use crate::caster::RayOrigin;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::sampling::sample_packet::SamplePacket;
use crate::scene::limits::BRIGHTEST;
use crate::scene::material::Material;
use crate::scene::model::Split;
use crate::shading::phong::Mixture;
use crate::world::{SurfacePoint, World};
use glam::DVec3;

/// The history of a ray since it left the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// The factor by which its colour contributes to the picture.
    pub filter: Color,
    /// The product of the lengths of the colours along the path: the weight in the course's program.
    weight: f64,
    pub bounces: u32,
    /// The index of refraction of the medium around the ray.
    index: f64,
}

impl Path {
    pub const CAMERA: Self = Self { filter: Color::ONE, weight: 1.0, bounces: 0, index: 1.0 };
}

/// A secondary ray that waits to be traced.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondaryRay {
    pub ray: Ray,
    pub origin: RayOrigin,
    pub path: Path,
}

/// The number of rays between two calls of [`IsOver`]. Such rare calls take no measurable time.
const RAYS_AT_ONCE: usize = 1 << 9;

/// The number of tests of primitives between two calls of [`IsOver`], if each ray is tested against all of them. They
/// take less than a second.
const TESTS_AT_ONCE: usize = 1 << 24;

/// The number of octaves of noise between two calls of [`IsOver`], if each ray evaluates all textures. They take some
/// hundredths of a second.
const OCTAVES_AT_ONCE: usize = 1 << 20;

/// The approximate number of secondary rays of one camera ray that may wait at once. They take about 30 MB per thread.
/// Each bounce adds at most one ray to the stack, so only rays that split that many times reach this limit.
pub const MOST_WAITING: usize = 1 << 18;

/// Returns true if no more rays are to be traced. The parameter is the number of rays that wait. It is called now and
/// then, since one camera ray may cause more secondary rays than can ever be traced.
pub type IsOver<'a> = &'a (dyn Fn(usize) -> bool + Sync);

/// The secondary rays of a camera ray that wait, and the number of rays until the next question whether to go on.
pub struct RayStack<'a> {
    /// The secondary rays that wait to be traced. The stack is empty between two camera rays.
    pub(super) pending: Vec<SecondaryRay>,
    pub(super) mixture: Mixture,
    is_over: IsOver<'a>,
    /// The number of rays between two calls of `is_over`, without shadow rays.
    at_once: u32,
    /// The number of rays until the next call.
    left: u32,
    is_cut: bool,
}

impl<'a> RayStack<'a> {
    /// Returns a stack whose rays are traced until `is_over` returns true. Each ray may cause a shadow ray
    /// to each light of the world, may be tested against all primitives, and may evaluate all textures.
    pub fn until(is_over: IsOver<'a>, world: &World) -> Self {
        let tested = RAYS_AT_ONCE.min(TESTS_AT_ONCE / world.ids().len().max(1));
        let at_once = tested / (1 + world.lights.len());
        let at_once = at_once.min(OCTAVES_AT_ONCE / octaves(&world.materials).max(1)).max(1) as u32;
        let (pending, mixture) = Default::default();
        Self { pending, mixture, is_over, at_once, left: at_once, is_cut: false }
    }

    /// Returns true if rays were left out.
    pub(crate) fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// Returns true if a packet of rays takes so long that `is_over` is to be called within it.
    #[inline(always)]
    pub(super) fn asks_within_packets(&self) -> bool {
        self.at_once < SamplePacket::SIZE as u32
    }

    /// Notes that this number of rays was traced. Returns true if no more are to be traced.
    #[inline(always)]
    pub(crate) fn spend(&mut self, rays: u32) -> bool {
        self.left = self.left.saturating_sub(rays);
        self.left == 0 && self.ask()
    }

    #[cold]
    fn ask(&mut self) -> bool {
        self.is_cut = self.is_cut || (self.is_over)(self.pending.len());
        self.left = if self.is_cut { 1 } else { self.at_once };
        self.is_cut
    }
}

/// Returns the number of octaves of all textures. A texture without noise counts as one.
fn octaves(materials: &[Material]) -> usize {
    let of = |material: &Material| match material {
        Material::Texture(texture) => texture.pattern.octaves() as usize + 1,
        Material::Phong(_) | Material::Painted(..) => 0,
    };
    materials.iter().map(of).sum()
}

impl Default for RayStack<'_> {
    /// Returns a stack whose rays are all traced.
    fn default() -> Self {
        let (pending, mixture) = Default::default();
        Self { pending, mixture, is_over: &|_| false, at_once: u32::MAX, left: u32::MAX, is_cut: false }
    }
}

impl<H: Hints> Tracer<'_, H> {
    /// Pushes the reflected and the refracted ray if they are to be traced.
    #[inline(always)]
    pub(super) fn push_secondary<O: Observer>(
        &self,
        arrival: &Arrival,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) {
        let Arrival { ray, path, surface, material } = arrival;
        let (direction, normal, phong) = (ray.direction, surface.normal, &material.phong);
        let cosine = direction.dot(normal);
        let is_entering = cosine < 0.0;
        // In front of the surface and behind it.
        let indices = [path.index, if is_entering { phong.index_of_refraction } else { 1.0 }];
        let (mut reflective, mut transparent) = (phong.reflective, phong.transparent);
        // An opaque surface mirrors all light.
        if self.world().lighting.split == Split::Schlick && transparent != Color::ZERO {
            let part = mirrored_part(cosine.abs(), indices);
            reflective *= part;
            transparent *= 1.0 - part;
        }

        let kind = Secondary::Reflected;
        if let Some(path) = self.next_path(kind, path, reflective, observer) {
            pending.push(self.secondary_ray(kind, surface, reflected(direction, normal), path, observer));
        }

        let kind = Secondary::Refracted;
        let Some(path) = self.next_path(kind, path, transparent, observer) else { return };
        let against = if is_entering { normal } else { -normal };
        observer.observe(|| Event::Refracting { direction, normal: against, indices });
        // A smooth normal is not the exact normal of the triangle.
        let is_smooth = self.world().has_smooth_normals() && surface.triangle.is_some();
        let (world, primitive) = (self.world(), surface.primitive.filter(|_| !is_smooth));
        let precise_sine = || world.precise_sine((ray.origin, direction), primitive, normal);
        match refracted_between(direction, against, indices, precise_sine) {
            Some(direction) => {
                let path = Path { index: indices[1], ..path };
                pending.push(self.secondary_ray(kind, surface, direction, path, observer));
            }
            None => observer.observe(|| Event::NotFollowed { kind, end: PathEnd::TotalReflection }),
        }
    }

    /// Returns the path of a secondary ray whose colour is multiplied by `color`, or `None` if it is not to be traced.
    #[inline(always)]
    fn next_path<O: Observer>(
        &self,
        kind: Secondary,
        path: &Path,
        color: Color,
        observer: &mut O,
    ) -> Option<Path> {
        let weight = path.weight * color.length();
        let end = if color == Color::ZERO {
            PathEnd::NoColor
        } else if path.bounces >= self.effects.bounces {
            PathEnd::Bounces
        } else if weight > self.effects.min_weight {
            let bound = Color::splat(BRIGHTEST);
            let filter = (path.filter * color).clamp(-bound, bound);
            return Some(Path { filter, weight, bounces: path.bounces + 1, index: path.index });
        } else {
            PathEnd::Weight { weight }
        };
        observer.observe(|| Event::NotFollowed { kind, end });
        None
    }

    #[inline(always)]
    fn secondary_ray<O: Observer>(
        &self,
        kind: Secondary,
        surface: &SurfacePoint,
        direction: DVec3,
        path: Path,
        observer: &mut O,
    ) -> SecondaryRay {
        let ray = self.departing(surface, direction);
        let Path { filter, weight, .. } = path;
        observer.observe(|| Event::Pushed { kind, ray, filter, weight });
        SecondaryRay { ray, origin: self.origin(surface), path }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;
    use std::fmt::Write;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Returns the number of questions within 2000 rays in a scene with this number of nested textures.
    fn questions(textures: usize) -> usize {
        let mut materials = format!("Materials {{ numMaterials {} Material {{ }} ", 1 + textures);
        for below in 0..textures {
            write!(materials, "Noise {{ materialIndex {below} materialIndex 0 octaves 64 }} ").unwrap();
        }
        let text = format!(
            "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }} {materials} }}
             Group {{ numObjects 1 MaterialIndex {textures} Sphere {{ center 0 0 0 radius 1 }} }}"
        );
        let world = World::new(&parse(&text).unwrap(), &[]).unwrap();
        let asked = AtomicUsize::new(0);
        let is_over = |_| {
            asked.fetch_add(1, Ordering::Relaxed);
            false
        };
        let mut stack = RayStack::until(&is_over, &world);
        assert_eq!(stack.asks_within_packets(), textures > 1000);
        assert!((0..2000).all(|_| !stack.spend(1)));
        asked.into_inner()
    }

    #[test]
    fn rays_that_evaluate_many_textures_ask_more_often() {
        assert_eq!([questions(1), questions(100), questions(2000), questions(20_000)], [3, 12, 250, 2000]);
    }
}
