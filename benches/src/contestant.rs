//! What casts rays into a mesh: this project's caster and its peers behind one trait.

use glam::Vec3;
use raytracer::math::ray::Ray;

/// A ray in single precision, the same for all.
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

/// Casts rays. Each makes its own kind of ray of a [`FlatRay`], which is part of the cast.
pub trait Cast {
    /// The distance to the nearest hit; infinite where there is none.
    fn closest(&self, ray: &FlatRay) -> f64;
    /// How many rays hit, by their nearest hit, whose distance is looked for in single precision at least.
    fn count_closest(&self, rays: &[FlatRay]) -> usize {
        rays.iter().filter(|ray| self.closest(ray) < f64::INFINITY).count()
    }
    /// Whether anything is hit.
    fn any(&self, ray: &FlatRay) -> bool;
}

/// Casts many rays at a time, so that no call by pointer is in the loop.
pub trait Contestant {
    /// How many rays hit, by their nearest hit.
    fn count_closest(&self, rays: &[FlatRay]) -> usize;
    /// How many rays hit anything.
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
