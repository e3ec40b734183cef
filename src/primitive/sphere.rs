//! Spheres, by the quadratic form that survives distance.

use crate::math::{aabb::Aabb, ray::Ray};
use glam::DVec3;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    pub center: DVec3,
    pub radius: f64,
}

impl Sphere {
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    /// The nearest crossing on the ray: the nearer root, or the farther where the nearer lies off it.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        first_on_ray(roots(ray.origin - self.center, ray.direction, self.radius)?, ray)
    }

    /// The outward unit normal, and the surface point nearest to `point`.
    pub fn surface(&self, point: DVec3) -> (DVec3, DVec3) {
        let normal = (point - self.center).normalize();
        (normal, self.center + self.radius * normal)
    }
}

/// The nearer of two ordered crossings that lies on the ray.
pub fn first_on_ray(roots: [f64; 2], ray: &Ray) -> Option<f64> {
    roots.into_iter().find(|&t| ray.covers(t))
}

/// Both crossings of a line with the sphere around the origin, in order.
///
/// The discriminant is taken from the line's distance to the centre and the second root from the
/// product of the roots, so that neither loses its digits to a cancellation (Haines, Guenther,
/// Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, ch. 7).
pub fn roots(origin: DVec3, direction: DVec3, radius: f64) -> Option<[f64; 2]> {
    let a = direction.length_squared();
    let b = -origin.dot(direction);
    let nearest = origin + (b / a) * direction;
    let discriminant = radius * radius - nearest.length_squared();
    if discriminant < 0.0 || discriminant.is_nan() {
        return None;
    }
    let q = b + f64::copysign((a * discriminant).sqrt(), b);
    let c = origin.length_squared() - radius * radius;
    let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
    Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_root_outside_and_the_farther_inside() {
        let sphere = Sphere { center: DVec3::new(0.0, 0.0, 5.0), radius: 2.0 };
        assert_eq!(sphere.intersect(&Ray::new(DVec3::ZERO, DVec3::Z)), Some(3.0));
        assert_eq!(sphere.intersect(&Ray::new(sphere.center, DVec3::Z)), Some(2.0));
        assert_eq!(sphere.intersect(&Ray::new(DVec3::ZERO, DVec3::NEG_Z)), None);
    }

    #[test]
    fn a_direction_of_any_length_scales_t() {
        let sphere = Sphere { center: DVec3::new(0.0, 0.0, 5.0), radius: 2.0 };
        assert_eq!(sphere.intersect(&Ray::new(DVec3::ZERO, DVec3::Z * 0.5)), Some(6.0));
    }

    #[test]
    fn an_orthographic_ray_sees_what_is_behind_its_origin() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let ray = Ray { t_min: f64::NEG_INFINITY, ..Ray::new(DVec3::new(0.0, 0.0, -5.0), DVec3::NEG_Z) };
        assert_eq!(sphere.intersect(&ray), Some(-6.0));
    }
}
