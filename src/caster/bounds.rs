//! Boxes around groups of primitives, and the entry of a ray into such a box.
//!
//! Rays are intersected with a box by the slab method (Kay and Kajiya, "Ray Tracing Complex Scenes", SIGGRAPH 1986).

use crate::caster::block::Frame;
use crate::math::aabb::Aabb;
use crate::math::extremes::max;
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::simd::{FourLanes, Number, RayLanes};
use fearless_simd::{Simd, SimdFrom, f64x4};
use glam::DVec3;

/// A box around primitives that are searched together, with the coordinates in which the filter tests them.
#[derive(Debug)]
pub struct Region {
    simd_bounds: SimdAabb,
    pub frame: Frame,
    /// The error bounds of the filter and the DDA hold for rays whose origin is at most this far from the frame's centre
    /// along each axis.
    max_origin_distance: f64,
}

/// How a ray enters a region.
#[derive(Clone, Copy, Debug)]
pub enum Entry<S: Simd> {
    /// The ray misses the box.
    Misses,
    /// The ray is inside the box in this interval.
    Passes(RayInterval<S>),
    /// The origin is so far away that the error bounds do not hold. Every primitive must be tested exactly.
    TooFar,
}

/// Maximum distance of a ray's origin in cells, 2^31: the rounding errors of a hit point then stay below the
/// padding that `proofs/dda.g` assumes.
pub const MAX_ORIGIN_CELLS: f64 = 2147483648.0;

/// Maximum distance of a ray's origin in box sizes. This is at most 2^20 units of the filter's frame, for which the
/// proof of the filter holds.
const MAX_ORIGIN_BOXES: f64 = (1u32 << 19) as f64;

impl Region {
    /// Returns the region of a box. `min_cell_size` is the smallest edge length of the cells into which it is divided,
    /// or infinity without a grid.
    pub fn new(bounds: &Aabb, min_cell_size: f64) -> Self {
        let max_origin_distance =
            (bounds.extent().max_element() * MAX_ORIGIN_BOXES).min(min_cell_size * MAX_ORIGIN_CELLS);
        Self { simd_bounds: SimdAabb::new(bounds), frame: Frame::new(bounds), max_origin_distance }
    }

    /// Returns how the ray enters the box, like [`entry`](Self::entry), but [`Entry::Misses`] also for a ray from too far
    /// away that certainly misses the box.
    #[inline(always)]
    pub fn certain_entry<S: Simd>(&self, simd: S, ray: &Ray, last: f64) -> Entry<S> {
        match self.entry(simd, ray, last) {
            Entry::TooFar if self.simd_bounds.is_surely_missed(ray) => Entry::Misses,
            entry => entry,
        }
    }

    /// Returns how the ray, up to t = `last`, enters the box.
    #[inline(always)]
    pub fn entry<S: Simd>(&self, simd: S, ray: &Ray, last: f64) -> Entry<S> {
        let ray_lanes = RayLanes::all_axes(simd, ray);
        let from_center = ray_lanes.origin - f64x4::simd_from(simd, self.frame.center);
        // A NaN is not within any distance.
        let is_in_proven_range = from_center.abs().max3() <= self.max_origin_distance;
        if !is_in_proven_range {
            return Entry::TooFar;
        }
        match intersect_aabb(&self.simd_bounds, ray_lanes, ray.t_min, last) {
            Some(interval) => Entry::Passes(interval),
            None => Entry::Misses,
        }
    }
}

/// A box by its two corners, each with an unused fourth lane.
#[derive(Clone, Debug, PartialEq)]
pub struct SimdAabb {
    /// The corner with the smallest coordinates.
    pub min: [f64; 4],
    max: [f64; 4],
}

impl SimdAabb {
    pub fn new(bounds: &Aabb) -> Self {
        let corner = |v: DVec3| [v.x, v.y, v.z, 0.0];
        Self { min: corner(bounds.min), max: corner(bounds.max) }
    }

    /// Returns true if the line of a ray certainly misses the box, however far away its origin is.
    ///
    /// The error of a crossing is three roundings of the distance to it, which may be many times the size of
    /// the box. The box is padded by more than that.
    fn is_surely_missed(&self, ray: &Ray) -> bool {
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
}

/// The t at which a ray enters and leaves a box, and the ray's coordinates.
#[derive(Clone, Copy, Debug)]
pub struct RayInterval<S: Simd> {
    /// At least the ray's `t_min`.
    pub entry: f64,
    /// Finite, and possibly beyond the ray's end.
    pub exit: f64,
    /// All axes of the ray.
    pub ray_lanes: RayLanes<S>,
}

/// Returns the interval of t from `t_min` on in which a ray is in the box; `None` if the ray misses the box or the
/// interval begins after `t_max`.
#[inline(always)]
pub fn intersect_aabb<S: Simd>(
    simd_bounds: &SimdAabb,
    ray_lanes: RayLanes<S>,
    t_min: f64,
    t_max: f64,
) -> Option<RayInterval<S>> {
    let face = |corner: [f64; 4]| f64x4::simd_from(ray_lanes.origin.proof(), corner);
    let t_of_min = (face(simd_bounds.min) - ray_lanes.origin) * ray_lanes.inv_direction;
    let t_of_max = (face(simd_bounds.max) - ray_lanes.origin) * ray_lanes.inv_direction;
    let (near, far) = (t_of_min.min(t_of_max), t_of_min.max(t_of_max));
    let entry = max(near.max3(), t_min);
    let exit = far.min3();
    // A ray in the plane of a face has a NaN there and counts as a miss, which is right because the bounds
    // are padded so that no primitive reaches the faces. A ray with a zero direction has an infinite exit.
    let passes = near.le_mask(far) & 7 == 7 && entry <= exit && entry <= t_max && exit < f64::INFINITY;
    passes.then_some(RayInterval { entry, exit, ray_lanes })
}

/// Returns a slightly larger box, which contains all hits in spite of rounding and has a positive extent along every
/// axis.
pub fn widened(bounds: Aabb) -> Aabb {
    let extent = bounds.extent();
    let max_abs_coord = bounds.min.abs().max(bounds.max.abs()).max_element();
    let max_extent = extent.max_element();
    // The factors are powers of two, so that a scene scaled by a power of two has the same cells.
    let min_extent = (max_extent * 2f64.powi(-10)).max(max_abs_coord * 2f64.powi(-30)).max(f64::MIN_POSITIVE);
    let padding = [0, 1, 2]
        .map(|axis| if extent[axis] < min_extent { min_extent } else { extent[axis] * 2f64.powi(-20) });
    let padding = DVec3::from_array(padding);
    Aabb { min: bounds.min - padding, max: bounds.max + padding }
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

    #[test]
    fn an_origin_may_be_as_many_boxes_or_cells_away_as_the_proofs_hold_for() {
        let bounds = Aabb { min: DVec3::ONE, max: DVec3::new(2.0, 3.0, 5.0) };
        let distance = |cell_size| Region::new(&bounds, cell_size).max_origin_distance;
        assert_eq!(distance(f64::INFINITY), 4.0 * MAX_ORIGIN_BOXES);
        assert_eq!(distance(1.0 / 65536.0), MAX_ORIGIN_CELLS / 65536.0);
    }

    #[test]
    fn a_widened_box_is_slightly_larger_on_all_sides_and_never_flat() {
        let bounds = Aabb { min: DVec3::new(-1.0, 3.0, 5.0), max: DVec3::new(1.0, 4.0, 5.0) };
        let larger = widened(bounds);
        let [below, above] = [bounds.min - larger.min, larger.max - bounds.max];
        assert_eq!(below, DVec3::new(2.0 / 1048576.0, 1.0 / 1048576.0, 2.0 / 1024.0));
        assert_eq!(below, above);
        // Far from the origin, where the spacing of floats is large.
        let far = DVec3::new(1.0, -1048576.0, 2.0);
        let larger = widened(Aabb { min: far, max: far });
        assert_eq!(
            (far - larger.min, larger.max - far),
            (DVec3::splat(1.0 / 1024.0), DVec3::splat(1.0 / 1024.0))
        );
    }
}
