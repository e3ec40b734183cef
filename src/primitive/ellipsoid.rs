//! Ellipsoids: what a sphere becomes under a transform that is no similarity. They alone keep a
//! matrix at trace time.

use super::sphere::{self, Sphere};
use crate::math::{aabb::Aabb, ray::Ray, robust::unit};
use glam::{DMat3, DVec3};

/// The image of the unit sphere under `p -> center + linear * p`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    center: DVec3,
    linear: DMat3,
    inverse: DMat3,
}

impl Ellipsoid {
    /// `linear` is not singular.
    pub fn new(center: DVec3, linear: DMat3) -> Self {
        Self { center, linear, inverse: linear.inverse() }
    }

    /// The tight box: along each axis the ellipsoid reaches as far as its matrix' row is long.
    pub fn bounds(&self) -> Aabb {
        let rows = self.linear.transpose();
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        Aabb { min: self.center - reach, max: self.center + reach }
    }

    /// The nearest crossing on the ray. The direction is not renormalised in the unit sphere's
    /// space, so t is the world's.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let origin = self.inverse * (ray.origin - self.center);
        let unit_sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let roots = unit_sphere.roots(origin, self.inverse * ray.direction)?;
        sphere::first_on_ray(roots, ray)
    }

    /// The outward unit normal, and a surface point within rounding of `point`.
    pub fn surface(&self, point: DVec3) -> (DVec3, DVec3) {
        let on_sphere = unit(self.inverse * (point - self.center));
        let normal = unit(self.inverse.transpose() * on_sphere);
        (normal, self.center + self.linear * on_sphere)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squashed() -> Ellipsoid {
        Ellipsoid::new(DVec3::new(1.0, 2.0, 3.0), DMat3::from_diagonal(DVec3::new(2.0, 0.5, 1.0)))
    }

    #[test]
    fn bounds_touch_the_extremes() {
        let b = squashed().bounds();
        assert_eq!((b.min, b.max), (DVec3::new(-1.0, 1.5, 2.0), DVec3::new(3.0, 2.5, 4.0)));
    }

    #[test]
    fn t_and_normal_are_the_worlds() {
        let e = squashed();
        let ray = Ray::new(DVec3::new(1.0, 12.0, 3.0), DVec3::NEG_Y);
        assert_eq!(e.intersect(&ray), Some(9.5));
        assert_eq!(e.surface(ray.at(9.5)), (DVec3::Y, DVec3::new(1.0, 2.5, 3.0)));
    }
}
