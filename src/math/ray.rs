//! Rays and hits.

use glam::DVec3;
use serde::Serialize;

/// The points `origin + t * direction` with `t_min <= t < t_max`.
///
/// The order of the fields lets vector instructions load them four at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[repr(C)]
pub struct Ray {
    /// The point at t = 0.
    pub origin: DVec3,
    /// The smallest t of a hit: 0, the epsilon of a scene that has one, or minus infinity for an orthographic camera,
    /// which also sees objects behind its plane.
    pub t_min: f64,
    /// The direction, which need not be a unit vector. Its length is the unit of t.
    pub direction: DVec3,
    /// The upper end of t, which no hit reaches; infinite for a ray without an end.
    pub t_max: f64,
}

impl Ray {
    /// Returns a ray from `origin` without an end.
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
    }

    /// Returns the point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    /// Returns true if `t` lies on the ray. A NaN or an infinity never does.
    pub fn covers(&self, t: f64) -> bool {
        t >= self.t_min && t < self.t_max && t > f64::NEG_INFINITY
    }
}

/// The primitive that a ray hits first. `World::hit` computes the hit itself, only for callers that need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// The primitive's id in its world.
    pub primitive: u32,
    /// An upper bound on t. For all primitives except triangles it is t itself.
    pub t_bound: f64,
}

/// The hit of a ray on a primitive of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Hit {
    /// The ray parameter, accurate to a few rounding errors.
    pub t: f64,
    /// The primitive's id in its world.
    #[serde(skip)]
    pub primitive: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ray() -> Ray {
        let (origin, direction) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(5.0, 6.0, 7.0));
        Ray { origin, t_min: 4.0, direction, t_max: 8.0 }
    }

    #[test]
    fn a_ray_covers_its_start_and_not_its_end() {
        let covered = |ray: Ray, ts: [f64; 4]| ts.map(|t| ray.covers(t));
        assert_eq!(covered(ray(), [3.9, 4.0, 7.9, 8.0]), [false, true, true, false]);
        let endless = Ray { t_min: f64::NEG_INFINITY, t_max: f64::INFINITY, ..ray() };
        let ends = [f64::NEG_INFINITY, -1e300, 1e300, f64::INFINITY];
        assert_eq!(covered(endless, ends), [false, true, true, false]);
        assert!(!endless.covers(f64::NAN));
        assert!(Ray::new(ray().origin, ray().direction).covers(0.0));
    }
}
