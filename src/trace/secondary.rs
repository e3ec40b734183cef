//! Secondary rays: the reflected and the refracted ray at a surface.

use super::observer::{Event, Observer, PathEnd, Secondary};
use super::optics::{mirrored_part, reflected, refracted_between};
use super::{Arrival, Hints, Tracer};
use crate::math::double_double::SquaredSine;
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::limits::BRIGHTEST;
use crate::scene::model::Split;
use crate::world::SurfacePoint;
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
    /// The primitive on which the ray starts.
    pub leaves: Option<u32>,
    pub path: Path,
}

impl Arrival<'_> {
    fn is_entering(&self) -> bool {
        self.ray.direction.dot(self.surface.normal) < 0.0
    }

    /// Returns the indices of refraction in front of the surface and behind it.
    fn indices(&self) -> [f64; 2] {
        let behind = if self.is_entering() { self.material.phong.index_of_refraction } else { 1.0 };
        [self.path.index, behind]
    }

    /// Returns the part of the light that is reflected. At an opaque surface it is 1.
    fn mirrored_part(&self) -> f64 {
        if self.material.phong.transparent == Color::ZERO {
            return 1.0;
        }
        mirrored_part(self.ray.direction.dot(self.surface.normal).abs(), self.indices())
    }
}

impl<H: Hints> Tracer<'_, H> {
    /// Pushes the reflected ray if it is to be traced.
    #[inline(always)]
    pub(super) fn reflect<O: Observer>(
        &self,
        arrival: &Arrival,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) {
        let kind = Secondary::Reflected;
        let color = match self.world().lighting.split {
            Split::Colors => arrival.material.phong.reflective,
            Split::Schlick => arrival.material.phong.reflective * arrival.mirrored_part(),
        };
        let Some(path) = self.next_path(kind, arrival.path, color, observer) else { return };
        let direction = reflected(arrival.ray.direction, arrival.surface.normal);
        pending.push(self.secondary_ray(kind, arrival, direction, path, observer));
    }

    /// Pushes the refracted ray if it is to be traced.
    #[inline(always)]
    pub(super) fn refract<O: Observer>(
        &self,
        arrival: &Arrival,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) {
        let kind = Secondary::Refracted;
        let color = match self.world().lighting.split {
            Split::Colors => arrival.material.phong.transparent,
            Split::Schlick => arrival.material.phong.transparent * (1.0 - arrival.mirrored_part()),
        };
        let Some(path) = self.next_path(kind, arrival.path, color, observer) else { return };
        let (direction, normal, indices) = (arrival.ray.direction, arrival.surface.normal, arrival.indices());
        let against = if arrival.is_entering() { normal } else { -normal };
        observer.observe(|| Event::Refracting { direction, normal: against, indices });
        // The closure takes copies. References to the ray or its path would force them into memory, written part by
        // part and read as vectors, which stalls the processor.
        let (line, surface) = ((arrival.ray.origin, direction), arrival.surface);
        match refracted_between(direction, against, indices, move || self.precise_sine(line, surface)) {
            Some(direction) => {
                let path = Path { index: indices[1], ..path };
                pending.push(self.secondary_ray(kind, arrival, direction, path, observer));
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
        arrival: &Arrival,
        direction: DVec3,
        path: Path,
        observer: &mut O,
    ) -> SecondaryRay {
        let ray = self.departing(arrival.surface, direction);
        let Path { filter, weight, .. } = path;
        let exclude = arrival.surface.triangle;
        observer.observe(|| Event::Pushed { kind, ray, exclude, filter, weight });
        SecondaryRay { ray, leaves: self.origin_primitive(arrival.surface), path }
    }

    /// Returns the sine of the angle between the ray and the surface's normal. It has less rounding than the unit
    /// normal if the exact normal is known.
    #[inline(always)]
    fn precise_sine(&self, line: (DVec3, DVec3), surface: &SurfacePoint) -> SquaredSine {
        // A smooth normal is not the exact normal of the triangle.
        let is_smooth = self.world().has_smooth_normals() && surface.triangle.is_some();
        let primitive = surface.primitive.filter(|_| !is_smooth);
        self.world().precise_sine(line, primitive, surface.normal)
    }
}
