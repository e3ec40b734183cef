//! Spheres, by the quadratic form that survives distance.

use crate::math::double_double::{Dd, difference, dot};
use crate::math::{aabb::Aabb, ray::Ray, robust::UNIT_ROUNDOFF, robust::unit};
use glam::DVec3;

/// The points at `radius` from `center`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// The centre.
    pub center: DVec3,
    /// Positive.
    pub radius: f64,
}

impl Sphere {
    /// The tight box.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    /// The nearest crossing on the ray: the nearer root, or the farther where the nearer lies off it.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        first_on_ray(self.roots(ray.origin, ray.direction)?, ray)
    }

    /// Both crossings of a line, in order.
    ///
    /// The discriminant is taken from the line's distance to the centre and the second root from
    /// the product of the roots, so that neither loses its digits to a cancellation (Haines,
    /// Guenther, Akenine-Moeller, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing
    /// Gems, ch. 7). Two differences still cancel: the discriminant where the line almost touches
    /// the sphere, and the origin's power where it lies almost on it. There they are computed with
    /// twice the digits.
    pub fn roots(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let from_center = origin - self.center;
        let a = direction.length_squared();
        let b = -from_center.dot(direction);
        let nearest = from_center + (b / a) * direction;
        let mut discriminant = self.radius * self.radius - nearest.length_squared();
        if discriminant.abs() <= self.radius * self.discriminant_doubt(from_center) {
            discriminant = self.precise_discriminant(origin, direction);
        }
        if discriminant < 0.0 || discriminant.is_nan() {
            return None;
        }
        let q = b + f64::copysign((a * discriminant).sqrt(), b);
        let c = self.power(origin, from_center);
        let (t0, t1) = if q == 0.0 { (0.0, 0.0) } else { (c / q, q / a) };
        Some(if t0 < t1 { [t0, t1] } else { [t1, t0] })
    }

    /// Below this, times the radius, the discriminant may have lost more than half of its digits.
    fn discriminant_doubt(&self, from_center: DVec3) -> f64 {
        const CLOSE: f64 = 1.0 / (1 << 20) as f64;
        CLOSE * self.radius + 64.0 * UNIT_ROUNDOFF * from_center.abs().max_element()
    }

    /// The square of the radius less that of the line's distance to the centre.
    #[cold]
    fn precise_discriminant(&self, origin: DVec3, direction: DVec3) -> f64 {
        let f = difference(origin, self.center);
        let d = direction.to_array().map(Dd::from);
        let r = Dd::from(self.radius);
        let (a, b) = (dot(d, d), dot(f, d));
        (b * b - a * (dot(f, f) - r * r)).value() / a.value()
    }

    /// The square of the origin's distance to the centre less that of the radius.
    fn power(&self, origin: DVec3, from_center: DVec3) -> f64 {
        const CLOSE: f64 = 1.0 / (1 << 10) as f64;
        let square = self.radius * self.radius;
        let power = from_center.length_squared() - square;
        if power.abs() > CLOSE * square { power } else { self.precise_power(origin) }
    }

    #[cold]
    fn precise_power(&self, origin: DVec3) -> f64 {
        let f = difference(origin, self.center);
        let r = Dd::from(self.radius);
        (dot(f, f) - r * r).value()
    }

    /// The outward unit normal, and the surface point nearest to `point`, where `ray` meets it.
    ///
    /// Where the radius is below the rounding of the centre, the point may be the centre itself. Then
    /// the sphere is a point, and shows its front.
    pub fn surface(&self, ray: &Ray, point: DVec3) -> (DVec3, DVec3) {
        let outward = point - self.center;
        let normal = unit(if outward == DVec3::ZERO { -ray.direction } else { outward });
        (normal, self.center + self.radius * normal)
    }
}

/// The nearer of two ordered crossings that lies on the ray.
pub fn first_on_ray(roots: [f64; 2], ray: &Ray) -> Option<f64> {
    roots.into_iter().find(|&t| ray.covers(t))
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

    #[test]
    fn a_line_that_touches_has_one_crossing_twice_and_one_that_misses_none() {
        let sphere = Sphere { center: DVec3::ZERO, radius: 1.0 };
        let from = |y| sphere.roots(DVec3::new(0.0, y, -5.0), DVec3::Z);
        assert_eq!(from(1.0), Some([5.0, 5.0]));
        assert_eq!([from(1.0 + f64::EPSILON), from(1.5), from(f64::NAN)], [None; 3]);
        assert_eq!(sphere.roots(DVec3::new(0.0, 0.0, -5.0), DVec3::ZERO), None);
    }
}
