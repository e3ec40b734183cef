//! How rays enter the bounds of a structure or of a branch with a frame of its own.

use crate::caster::blocks::triangle8::Frame;
use crate::caster::ray_aabb::{RayInterval, SimdAabb, intersect_aabb};
use crate::math::f64x4::F64x4;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;

/// How a ray enters bounds.
#[derive(Clone, Copy, Debug)]
pub enum Entry<F> {
    /// The ray misses the bounds.
    Misses,
    /// The ray is inside the bounds in this interval.
    Passes(RayInterval<F>),
    /// The origin is so far away that the error bounds of the filter and the DDA do not hold.
    TooFar,
}

/// How a ray, up to t = `last`, enters bounds with this frame, within this distance of whose centre the error bounds
/// hold.
#[inline(always)]
pub fn ray_entry<F: F64x4>(
    proof: F::Proof,
    simd_bounds: &SimdAabb,
    frame: &Frame,
    max_origin_distance: f64,
    ray: &Ray,
    last: f64,
) -> Entry<F> {
    let ray_lanes = RayLanes::<F>::all_axes(proof, ray);
    let from_center = ray_lanes.origin - F::new(proof, frame.center);
    // A NaN is not within any distance.
    let is_in_proven_range = from_center.abs().max3() <= max_origin_distance;
    if !is_in_proven_range {
        return Entry::TooFar;
    }
    intersect_aabb(simd_bounds, ray_lanes, ray.t_min, last).map_or(Entry::Misses, Entry::Passes)
}
