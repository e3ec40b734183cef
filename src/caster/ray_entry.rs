//! How rays enter the bounds of a structure or of a branch with a frame of its own.

use crate::caster::blocks::triangle8::Frame;
use crate::caster::ray_aabb::{RayInterval, SimdAabb, intersect_aabb};
use crate::math::f64x4::FourLanes;
use crate::math::number::Number;
use crate::math::ray::Ray;
use crate::math::ray_lanes::RayLanes;
use fearless_simd::{Simd, SimdFrom, f64x4};

/// How a ray enters bounds.
#[derive(Clone, Copy, Debug)]
pub enum Entry<S: Simd> {
    /// The ray misses the bounds.
    Misses,
    /// The ray is inside the bounds in this interval.
    Passes(RayInterval<S>),
    /// The origin is so far away that the error bounds of the filter and the DDA do not hold.
    TooFar,
}

/// How a ray, up to t = `last`, enters bounds with this frame, within this distance of whose centre the error bounds
/// hold.
#[inline(always)]
pub fn ray_entry<S: Simd>(
    simd: S,
    simd_bounds: &SimdAabb,
    frame: &Frame,
    max_origin_distance: f64,
    ray: &Ray,
    last: f64,
) -> Entry<S> {
    let ray_lanes = RayLanes::all_axes(simd, ray);
    let from_center = ray_lanes.origin - f64x4::simd_from(simd, frame.center);
    // A NaN is not within any distance.
    let is_in_proven_range = from_center.abs().max3() <= max_origin_distance;
    if !is_in_proven_range {
        return Entry::TooFar;
    }
    intersect_aabb(simd_bounds, ray_lanes, ray.t_min, last).map_or(Entry::Misses, Entry::Passes)
}
