//! Secondary rays: which ones leave a surface.

use super::event::{Event, Observer, PathEnd, Secondary};
use super::optics::{is_critical, reflected, refracted_between};
use super::{Lit, Tracer};
use crate::math::ray::Ray;
use crate::math::robust::offset_origin;
use crate::mode::Mode;
use crate::scene::Color;
use crate::scene::limits::BRIGHTEST;
use crate::world::SurfacePoint;
use glam::DVec3;

/// The history of a ray since it left the camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// The factor by which its colour contributes to the picture.
    pub filter: Color,
    /// The product of the lengths of the colours along the path, which is the weight in the course's program.
    weight: f64,
    pub bounces: u32,
    /// The index of refraction of the medium around the ray.
    index: f64,
}

impl Path {
    /// The path of a camera ray.
    pub const CAMERA: Self = Self { filter: Color::ONE, weight: 1.0, bounces: 0, index: 1.0 };
}

/// A secondary ray that has not been traced yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct SecondaryRay {
    pub ray: Ray,
    /// The primitive that the ray leaves.
    pub leaves: Option<u32>,
    pub path: Path,
}

impl<M: Mode> Tracer<'_, M> {
    #[inline(always)]
    pub(super) fn secondary(&self, surface: &SurfacePoint, direction: DVec3) -> Ray {
        Ray::new(
            offset_origin(surface.position, surface.normal, direction, self.world().max_abs_coord),
            direction,
        )
    }

    #[inline(always)]
    pub(super) fn reflect<P: Observer>(
        &self,
        path: &Path,
        lit: &Lit,
        pending: &mut Vec<SecondaryRay>,
        probe: &mut P,
    ) {
        let color = lit.material.phong.reflective;
        let Some((filter, weight)) = self.filter_and_weight(path, color) else {
            if P::OBSERVES {
                probe.observe(Secondary::Reflected.ends(too_light(path, color)));
            }
            return;
        };
        let ray = self.secondary(&lit.surface, reflected(lit.direction, lit.surface.normal));
        let path = Path { filter, weight, bounces: path.bounces + 1, index: path.index };
        if P::OBSERVES {
            let exclude = lit.surface.triangle;
            probe.observe(Event::Pushed { kind: Secondary::Reflected, ray, exclude, filter, weight });
        }
        pending.push(SecondaryRay { ray, leaves: lit.surface.primitive, path });
    }

    #[inline(always)]
    pub(super) fn refract<P: Observer>(
        &self,
        path: &Path,
        lit: &Lit,
        pending: &mut Vec<SecondaryRay>,
        probe: &mut P,
    ) {
        let material = lit.material.phong;
        let Some((filter, weight)) = self.filter_and_weight(path, material.transparent) else {
            if P::OBSERVES {
                probe.observe(Secondary::Refracted.ends(too_light(path, material.transparent)));
            }
            return;
        };
        let (d, n) = (lit.direction, lit.surface.normal);
        let entering = d.dot(n) < 0.0;
        let (normal, index) = if entering { (n, material.index_of_refraction) } else { (-n, 1.0) };
        let indices = [path.index, index];
        if P::OBSERVES && is_critical(d, normal, indices) {
            probe.observe(Event::Critical);
        }
        let primitive = lit.surface.primitive;
        let precise_normal = || self.world().precise_normal(primitive, n);
        let Some(direction) = refracted_between(d, normal, indices, precise_normal) else {
            if P::OBSERVES {
                probe.observe(Secondary::Refracted.ends(PathEnd::TotalReflection));
            }
            return;
        };
        let ray = self.secondary(&lit.surface, direction);
        let path = Path { filter, weight, bounces: path.bounces + 1, index };
        if P::OBSERVES {
            let exclude = lit.surface.triangle;
            probe.observe(Event::Pushed { kind: Secondary::Refracted, ray, exclude, filter, weight });
        }
        pending.push(SecondaryRay { ray, leaves: lit.surface.primitive, path });
    }

    /// The filter and the weight of a secondary ray, if its weight is large enough for it to be traced.
    #[inline(always)]
    fn filter_and_weight(&self, path: &Path, color: Color) -> Option<(Color, f64)> {
        let weight = path.weight * color.length();
        let bound = Color::splat(BRIGHTEST);
        (weight > self.effects.min_weight).then(|| ((path.filter * color).clamp(-bound, bound), weight))
    }
}

/// Why a secondary ray ends that weighs too little, or nothing at all.
fn too_light(path: &Path, color: Color) -> PathEnd {
    PathEnd::of(color, PathEnd::Weight { weight: path.weight * color.length() })
}
