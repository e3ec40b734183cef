//! The trait of everything that casts rays into a mesh: this project's caster and its peers.

use glam::Vec3;
use raytracer::math::ray::Ray;

/// A ray in single precision, which is the same for all contestants.
#[derive(Clone, Copy, Debug)]
pub struct FlatRay {
    pub origin: Vec3,
    pub direction: Vec3,
}

impl FlatRay {
    /// The ray, rounded.
    pub fn new(ray: &Ray) -> Self {
        Self { origin: ray.origin.as_vec3(), direction: ray.direction.as_vec3() }
    }

    /// This ray in double precision.
    pub fn exact(&self) -> Ray {
        Ray::new(self.origin.as_dvec3(), self.direction.as_dvec3())
    }
}

/// Casts rays. The conversion of a [`FlatRay`] to a contestant's own type of ray is part of the cast.
pub trait Cast {
    /// The distance to the nearest hit; infinite if there is none.
    fn closest(&self, ray: &FlatRay) -> f64;
    /// The number of rays that hit, by queries for the nearest hit with its distance in at least single
    /// precision.
    fn count_closest(&self, rays: &[FlatRay]) -> usize {
        rays.iter().filter(|ray| self.closest(ray) < f64::INFINITY).count()
    }
    /// Whether the ray hits anything.
    fn any(&self, ray: &FlatRay) -> bool;
}

/// Casts many rays per call, so that there is no dynamic dispatch in the loop.
pub trait Contestant {
    /// The number of rays that hit, by queries for the nearest hit.
    fn count_closest(&self, rays: &[FlatRay]) -> usize;
    /// The number of rays that hit, by queries for any hit.
    fn count_any(&self, rays: &[FlatRay]) -> usize;
    /// The distance to each ray's nearest hit.
    fn distances(&self, rays: &[FlatRay]) -> Vec<f64>;
    /// Whether each ray hits anything.
    fn hits(&self, rays: &[FlatRay]) -> Vec<bool>;
}

impl<C: Cast> Contestant for C {
    fn count_closest(&self, rays: &[FlatRay]) -> usize {
        Cast::count_closest(self, rays)
    }

    fn count_any(&self, rays: &[FlatRay]) -> usize {
        rays.iter().filter(|ray| self.any(ray)).count()
    }

    fn distances(&self, rays: &[FlatRay]) -> Vec<f64> {
        rays.iter().map(|ray| self.closest(ray)).collect()
    }

    fn hits(&self, rays: &[FlatRay]) -> Vec<bool> {
        rays.iter().map(|ray| self.any(ray)).collect()
    }
}
