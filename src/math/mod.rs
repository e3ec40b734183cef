//! Boxes, rays, arithmetic with bounded or no rounding error, and SIMD lanes. All other modules build on
//! these.

pub mod aabb;
pub mod double_double;
pub mod exact_product;
pub(crate) mod exact_sum;
pub(crate) mod exp;
pub mod extremes;
pub(crate) mod f64x4;
pub mod instructions;
pub(crate) mod lanes;
pub(crate) mod ray_lanes;
pub(crate) mod number;
pub mod predicate;
pub(crate) mod prefetch;
pub mod ray;
pub mod robust;
pub mod rounded_affine;
pub mod rounded_point;
pub mod scaled;
pub(crate) mod vector;
#[cfg(test)]
pub(crate) mod worst_case;
