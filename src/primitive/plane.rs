//! Infinite planes. They have no bounds, so every ray is tested against each of them.

use crate::math::ray::Ray;
use glam::DVec3;

/// The points p with `normal . p = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A unit vector.
    pub normal: DVec3,
    /// The distance from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// The t where the ray crosses the plane. None where the ray is parallel to it, or where the direction is
    /// too long for its product with the normal to be finite.
    pub fn intersect(&self, ray: &Ray) -> Option<f64> {
        let rate = self.normal.dot(ray.direction);
        let t = self.ahead_of(ray.origin) / rate;
        (ray.covers(t) && rate.is_finite()).then_some(t)
    }

    /// The signed distance from a point to the plane, positive where the normal points from it to the plane.
    #[inline]
    pub fn ahead_of(&self, point: DVec3) -> f64 {
        self.offset - self.normal.dot(point)
    }

    /// The same points, with the normal to the other side.
    pub fn reversed(self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// The point of the plane nearest to `point`. This removes the rounding error of `origin + t * direction`
    /// across the plane, so that a solid texture with a boundary in the plane does not flicker.
    pub fn project(&self, point: DVec3) -> DVec3 {
        point - (self.normal.dot(point) - self.offset) * self.normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parallel_ray_misses_even_inside_the_plane() {
        let floor = Plane { normal: DVec3::Y, offset: 0.0 };
        for y in [-1.0, 0.0, 1.0] {
            assert_eq!(floor.intersect(&Ray::new(DVec3::new(0.0, y, 0.0), DVec3::X)), None);
        }
    }

    #[test]
    fn both_sides_are_hit() {
        let floor = Plane { normal: DVec3::Y, offset: -1.0 };
        assert_eq!(floor.intersect(&Ray::new(DVec3::Y, DVec3::NEG_Y)), Some(2.0));
        assert_eq!(floor.intersect(&Ray::new(DVec3::splat(-3.0), DVec3::Y)), Some(2.0));
        assert_eq!(floor.intersect(&Ray::new(DVec3::Y, DVec3::Y)), None);
    }

    #[test]
    fn a_point_is_projected_along_the_normal() {
        let plane = Plane { normal: DVec3::new(0.0, 0.6, 0.8), offset: -1.0 };
        let projected = plane.project(DVec3::new(7.0, 5.0, 2.5));
        assert!((projected - DVec3::new(7.0, 1.4, -2.3)).length() < 1e-15, "{projected}");
    }
}
