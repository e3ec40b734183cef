//! A ray in SIMD lanes ([`f64x4`]), by its axes.

use super::number::Number;
use super::ray::Ray;
use fearless_simd::{Simd, SimdFrom, f64x4};

/// All axes of a ray.
#[derive(Clone, Copy, Debug)]
pub struct RayLanes<S: Simd> {
    /// Where t is 0.
    pub origin: f64x4<S>,
    /// The direction, of any length.
    pub direction: f64x4<S>,
    /// The reciprocal of the direction.
    pub inv_direction: f64x4<S>,
}

impl<S: Simd> RayLanes<S> {
    /// Rays with this origin and direction.
    #[inline(always)]
    pub fn new(origin: f64x4<S>, direction: f64x4<S>) -> Self {
        Self { origin, direction, inv_direction: direction.recip() }
    }

    /// The three axes of a ray. The unused lanes repeat numbers that are in registers anyway.
    #[inline(always)]
    pub fn all_axes(simd: S, ray: &Ray) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        Self::new(
            f64x4::simd_from(simd, [o.x, o.y, o.z, d.x]),
            f64x4::simd_from(simd, [d.x, d.y, d.z, ray.t_max]),
        )
    }
}
