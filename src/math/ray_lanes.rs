//! Rays in SIMD lanes ([`F64x4`]): one ray by its axes, or a packet of four rays.

use super::f64x4::F64x4;
use super::ray::Ray;

/// All axes of one ray, or one axis of four rays.
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

/// Four rays in structure-of-arrays layout: each value holds one quantity of all four rays.
#[derive(Clone, Copy, Debug)]
pub struct RayPacket4<F> {
    /// Origins and directions along x, y and z.
    pub axes: [RayLanes<F>; 3],
    pub t_min: F,
    pub t_max: F,
}

impl<F: F64x4> RayPacket4<F> {
    /// Transposes four rays.
    #[inline(always)]
    pub fn new(proof: F::Proof, [a, b, c, d]: [&Ray; 4]) -> Self {
        let four = |lanes| F::new(proof, lanes);
        let x = four([a.origin.x, b.origin.x, c.origin.x, d.origin.x]);
        let y = four([a.origin.y, b.origin.y, c.origin.y, d.origin.y]);
        let z = four([a.origin.z, b.origin.z, c.origin.z, d.origin.z]);
        let to_x = four([a.direction.x, b.direction.x, c.direction.x, d.direction.x]);
        let to_y = four([a.direction.y, b.direction.y, c.direction.y, d.direction.y]);
        let to_z = four([a.direction.z, b.direction.z, c.direction.z, d.direction.z]);
        Self {
            axes: [RayLanes::new(x, to_x), RayLanes::new(y, to_y), RayLanes::new(z, to_z)],
            t_min: four([a.t_min, b.t_min, c.t_min, d.t_min]),
            t_max: four([a.t_max, b.t_max, c.t_max, d.t_max]),
        }
    }
}
