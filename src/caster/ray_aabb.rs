//! The intersection of rays with an axis-aligned box by the slab method (Kay and Kajiya, "Ray Tracing Complex
//! Scenes", SIGGRAPH 1986). It gives the interval of t in which the grid is traversed.

use crate::math::aabb::Aabb;
use crate::math::extremes::max;
use crate::math::f64x4::FourLanes;
use crate::math::number::Number;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;
use crate::math::robust::UNIT_ROUNDOFF;
use fearless_simd::{Simd, SimdFrom, f64x4};
use glam::DVec3;

/// An axis-aligned box in SIMD lanes: its two corners, each with an unused fourth lane.
#[derive(Clone, Debug, PartialEq)]
pub struct SimdAabb {
    /// The corner with the smallest coordinates.
    pub min: [f64; 4],
    max: [f64; 4],
}

impl SimdAabb {
    /// A box in SIMD lanes.
    pub fn new(bounds: &Aabb) -> Self {
        let corner = |v: DVec3| [v.x, v.y, v.z, 0.0];
        Self { min: corner(bounds.min), max: corner(bounds.max) }
    }

    /// Whether the line of a ray certainly misses the box, however far away its origin is.
    ///
    /// The error of a crossing is three roundings of the distance to it, which may be many times the size of
    /// the box. The box is padded by more than that.
    pub fn is_surely_missed(&self, ray: &Ray) -> bool {
        let corners = self.min.iter().chain(&self.max);
        let max_corner_coord = corners.fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let max_distance = ray.origin.abs().max_element() + max_corner_coord;
        let padding = 128.0 * UNIT_ROUNDOFF * max_distance + f64::MIN_POSITIVE;
        let (mut entry, mut exit) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..3 {
            let (origin, direction) = (ray.origin[axis], ray.direction[axis]);
            let distances = [self.min[axis] - padding - origin, self.max[axis] + padding - origin];
            if direction == 0.0 && distances[0] * distances[1] > 0.0 {
                return true;
            } else if direction != 0.0 {
                let [t0, t1] = distances.map(|distance| distance / direction);
                (entry, exit) = (entry.max(t0.min(t1)), exit.min(t0.max(t1)));
            }
        }
        entry > exit
    }

    /// The lower and upper faces of all axes, for one ray.
    #[inline(always)]
    fn all_axes<S: Simd>(&self, simd: S) -> [f64x4<S>; 2] {
        [f64x4::simd_from(simd, self.min), f64x4::simd_from(simd, self.max)]
    }
}

/// The t at which rays cross the two faces of a slab, the nearer first.
#[inline(always)]
fn crossings<S: Simd>([min, max]: [f64x4<S>; 2], ray_lanes: &RayLanes<S>) -> [f64x4<S>; 2] {
    let t_of_min = (min - ray_lanes.origin) * ray_lanes.inv_direction;
    let t_of_max = (max - ray_lanes.origin) * ray_lanes.inv_direction;
    [t_of_min.min(t_of_max), t_of_min.max(t_of_max)]
}

/// The t at which a ray enters and leaves a box, and the ray itself.
#[derive(Clone, Copy, Debug)]
pub struct RayInterval<S: Simd> {
    /// At least the ray's `t_min`.
    pub entry: f64,
    /// Finite, and possibly beyond the ray's end.
    pub exit: f64,
    /// All axes of the ray.
    pub ray_lanes: RayLanes<S>,
}

/// The interval of t from `t_min` on in which a ray is in the box, or none when it does not begin until after
/// `t_max`.
#[inline(always)]
pub fn intersect_aabb<S: Simd>(
    simd_bounds: &SimdAabb,
    ray_lanes: RayLanes<S>,
    t_min: f64,
    t_max: f64,
) -> Option<RayInterval<S>> {
    let [near, far] = crossings(simd_bounds.all_axes(ray_lanes.origin.proof()), &ray_lanes);
    let entry = max(near.max3(), t_min);
    let exit = far.min3();
    // A ray in the plane of a face has a NaN there and counts as a miss, which is right because the bounds
    // are padded so that no primitive reaches the faces. A ray with a zero direction has an infinite exit.
    let passes = near.le_mask(far) & 7 == 7 && entry <= exit && entry <= t_max && exit < f64::INFINITY;
    passes.then_some(RayInterval { entry, exit, ray_lanes })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_aimed_at_a_box_never_counts_as_surely_missing_it() {
        let bounds = Aabb { min: DVec3::new(-1.0, 2.0, 3.0), max: DVec3::new(0.5, 2.5, 3.0) };
        let simd_bounds = SimdAabb::new(&bounds);
        let mut missed = 0;
        for i in 0..20_000 {
            let fraction = |k: f64| libm::fmod(k * f64::from(i), 1.0);
            let target =
                bounds.min + DVec3::new(fraction(0.618), fraction(0.754), fraction(0.569)) * bounds.extent();
            let distance = libm::exp2(60.0 * fraction(0.819));
            let origin =
                distance * DVec3::new(fraction(0.137) - 0.5, fraction(0.273) - 0.5, fraction(0.391) - 0.5);
            // Because the direction is rounded, the exact line may miss the box by a little; the padding
            // allows for it.
            let direction = (target - origin).normalize();
            assert!(!simd_bounds.is_surely_missed(&Ray::new(origin, direction)), "{origin} {target}");
            assert!(!simd_bounds.is_surely_missed(&Ray::new(origin, direction * libm::exp2(-900.0))));
            let beside = Ray::new(origin, target + DVec3::splat(1e-9 * distance + 3.0) - origin);
            missed += usize::from(simd_bounds.is_surely_missed(&beside));
        }
        assert!(missed > 19_000, "{missed}");
        let parallel = Ray::new(DVec3::new(0.0, 2.25, -9.0), DVec3::Z);
        assert!(!simd_bounds.is_surely_missed(&parallel));
        assert!(simd_bounds.is_surely_missed(&Ray { origin: parallel.origin + DVec3::Y, ..parallel }));
    }

    #[test]
    fn a_ray_within_a_face_of_a_large_or_a_tiny_box_does_not_surely_miss_it() {
        for size in [1e6, 1.0, 1e-200] {
            let simd_bounds = SimdAabb::new(&Aabb { min: DVec3::ZERO, max: DVec3::splat(size) });
            for height in [0.0, 0.5, 1.0] {
                let ray = Ray::new(DVec3::new(0.5, height, 0.5) * size, DVec3::X);
                assert!(!simd_bounds.is_surely_missed(&ray), "{size} {height}");
            }
        }
        // Here products with the unit roundoff underflow.
        let size = 4.0 * f64::MIN_POSITIVE;
        let simd_bounds = SimdAabb::new(&Aabb { min: DVec3::ZERO, max: DVec3::splat(size) });
        let touching = Ray::new(DVec3::new(-1.0, 1.0, 0.5) * size, DVec3::new(1.0, -1.0, 0.0));
        assert!(!simd_bounds.is_surely_missed(&touching));
    }
}
