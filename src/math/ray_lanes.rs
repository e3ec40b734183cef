//! A ray in SIMD lanes ([`F64x4`]), by its axes.

use super::f64x4::F64x4;
use super::ray::Ray;

/// All axes of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayLanes<F> {
    /// Where t is 0.
    pub origin: F,
    /// The direction, of any length.
    pub direction: F,
    /// The reciprocal of the direction.
    pub inv_direction: F,
}

impl<F: F64x4> RayLanes<F> {
    /// Rays with this origin and direction.
    #[inline(always)]
    pub fn new(origin: F, direction: F) -> Self {
        Self { origin, direction, inv_direction: direction.recip() }
    }

    /// The three axes of a ray. The unused lanes repeat numbers that are in registers anyway.
    #[inline(always)]
    pub fn all_axes(proof: F::Proof, ray: &Ray) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        Self::new(F::new(proof, [o.x, o.y, o.z, d.x]), F::new(proof, [d.x, d.y, d.z, ray.t_max]))
    }
}
