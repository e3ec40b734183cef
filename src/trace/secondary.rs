//! Secondary rays: which ones leave a surface.

use super::observer::{Event, Observer, PathEnd, Secondary};
use super::optics::refracted_between;
use super::rules::{Departure, Rules};
use super::{Arrival, Tracer};
use crate::math::ray::Ray;
use crate::picture::Color;
use crate::scene::limits::BRIGHTEST;
use crate::scene::model::Split;
use glam::DVec3;

/// The history of a ray since it left the camera.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Path {
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
pub(crate) struct SecondaryRay {
    pub ray: Ray,
    /// The primitive that the ray leaves.
    pub leaves: Option<u32>,
    pub path: Path,
}

impl<R: Rules> Tracer<'_, R> {
    /// Pushes the reflected ray, if one is followed.
    #[inline(always)]
    pub(crate) fn reflect<O: Observer>(
        &self,
        path: &Path,
        arrival: &Arrival,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) {
        let kind = Secondary::Reflected;
        let color = match self.rules.model().split {
            Split::Colors => arrival.material.phong.reflective,
            Split::Schlick => arrival.material.phong.reflective * self.mirrored_part(path, arrival),
        };
        let branch = self.filter_and_weight(kind, path, color);
        let Some((filter, weight)) = branch.or_end(kind, observer) else { return };
        let direction = self.rules.reflected(arrival.ray.direction, arrival.surface.normal);
        let path = Path { filter, weight, bounces: path.bounces + 1, index: path.index };
        pending.push(self.branch(kind, arrival, direction, path, observer));
    }

    /// Pushes the refracted ray, if one is followed.
    #[inline(always)]
    pub(crate) fn refract<O: Observer>(
        &self,
        path: &Path,
        arrival: &Arrival,
        pending: &mut Vec<SecondaryRay>,
        observer: &mut O,
    ) {
        let kind = Secondary::Refracted;
        let material = arrival.material.phong;
        let color = match self.rules.model().split {
            Split::Colors => material.transparent,
            Split::Schlick => material.transparent * (1.0 - self.mirrored_part(path, arrival)),
        };
        let branch = self.filter_and_weight(kind, path, color);
        let Some((filter, weight)) = branch.or_end(kind, observer) else { return };
        let (direction, normal) = (arrival.ray.direction, arrival.surface.normal);
        let is_entering = direction.dot(normal) < 0.0;
        let against = if is_entering { normal } else { -normal };
        let indices = self.rules.indices(path.index, material, is_entering);
        observer.observe(|| Event::Refracting { direction, normal: against, indices });
        let sine = || self.rules.precise_sine(arrival.ray.origin, direction, arrival.surface);
        let refracted = refracted_between(direction, against, indices, sine);
        let (onwards, index) = match refracted {
            Some(refracted) => (Some(refracted), if is_entering { indices[1] } else { 1.0 }),
            None => (self.rules.totally_reflected(direction, normal), path.index),
        };
        let Some(direction) = onwards.ok_or(PathEnd::TotalReflection).or_end(kind, observer) else {
            return;
        };
        let path = Path { filter, weight, bounces: path.bounces + 1, index };
        pending.push(self.branch(kind, arrival, direction, path, observer));
    }

    /// How much of the light is mirrored at a surface; all at one that is opaque.
    fn mirrored_part(&self, path: &Path, arrival: &Arrival) -> f64 {
        let material = arrival.material.phong;
        if material.transparent == Color::ZERO {
            return self.rules.mirrored(1.0);
        }
        let cosine = arrival.ray.direction.dot(arrival.surface.normal);
        let indices = self.rules.indices(path.index, material, cosine < 0.0);
        self.rules.mirrored(mirrored_part(cosine.abs(), indices))
    }

    #[inline(always)]
    fn branch<O: Observer>(
        &self,
        kind: Secondary,
        arrival: &Arrival,
        direction: DVec3,
        path: Path,
        observer: &mut O,
    ) -> SecondaryRay {
        let (ray, leaves) = self.rules.departing(Departure::Secondary(kind), arrival.surface, direction);
        let Path { filter, weight, .. } = path;
        let exclude = arrival.surface.triangle;
        observer.observe(|| Event::Pushed { kind, ray, exclude, filter, weight });
        SecondaryRay { ray, leaves, path }
    }

    /// The filter and the weight of a secondary ray, if it is traced.
    #[inline(always)]
    fn filter_and_weight(&self, kind: Secondary, path: &Path, color: Color) -> Result<(Color, f64), PathEnd> {
        if path.bounces >= self.effects.bounces {
            return Err(PathEnd::of(color, PathEnd::Bounces));
        }
        let weight = path.weight * color.length();
        if weight > self.effects.min_weight {
            let bound = Color::splat(BRIGHTEST);
            let filter = path.filter * self.rules.filter(kind, color);
            Ok((filter.clamp(-bound, bound), weight))
        } else {
            Err(PathEnd::of(color, PathEnd::Weight { weight }))
        }
    }
}

/// How much of the light is mirrored at a transparent surface between two media, whose indices of refraction are that
/// in front of it and that behind it, by Schlick's approximation ("An Inexpensive BRDF Model for Physically-based
/// Rendering", Computer Graphics Forum 13(3), 1994). `cosine` is that of the angle in front.
pub(crate) fn mirrored_part(cosine: f64, [front, behind]: [f64; 2]) -> f64 {
    let ratio = front / behind;
    let refracted_square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if refracted_square < 0.0 {
        return 1.0;
    }
    // The larger one of the angles in front of the surface and behind it counts.
    let cosine = if front <= behind { cosine } else { refracted_square.sqrt() };
    // As in the course's program, the medium behind is compared with empty space, whatever is in front. So nothing is
    // mirrored at a right angle where a ray leaves an object.
    let root = (behind - 1.0) / (behind + 1.0);
    let straight = root * root;
    // Products in a fixed order, which are the same on every machine.
    let (grazing, square) = (1.0 - cosine, (1.0 - cosine) * (1.0 - cosine));
    straight + (1.0 - straight) * (grazing * (square * square))
}

/// A step on the way of a secondary ray, or its end.
trait OrEnd<T> {
    /// The step, if there is one. Otherwise the observer is told why no ray of this kind is followed.
    fn or_end<O: Observer>(self, kind: Secondary, observer: &mut O) -> Option<T>;
}

impl<T> OrEnd<T> for Result<T, PathEnd> {
    #[inline(always)]
    fn or_end<O: Observer>(self, kind: Secondary, observer: &mut O) -> Option<T> {
        match self {
            Ok(step) => Some(step),
            Err(end) => {
                observer.observe(|| Event::NotFollowed { kind, end });
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_media_the_one_behind_decides_how_much_is_mirrored() {
        let near = |cosine, indices, expected: f64| (mirrored_part(cosine, indices) - expected).abs() < 1e-15;
        assert!(near(1.0, [1.0, 2.0], 1.0 / 9.0) && near(1.0, [2.0, 1.0], 0.0));
        // A ray that is mirrored on the outside may meet the surface from within.
        assert!(near(0.5, [1.0, 1.0], 1.0 / 32.0) && near(1.0, [2.0, 2.0], 1.0 / 9.0));
        // The sine is 0.3, and 0.6 behind the surface.
        assert!(near(0.91f64.sqrt(), [2.0, 1.0], 0.2f64.powi(5)));
        assert!(near(0.8, [1.0, 2.0], 1.0 / 9.0 + 8.0 / 9.0 * 0.2f64.powi(5)));
        assert_eq!([0.0, 0.86].map(|cosine| mirrored_part(cosine, [2.0, 1.0])), [1.0; 2]);
    }
}
