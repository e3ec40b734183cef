//! Boxes, rays, arithmetic with bounded or no rounding error, and SIMD lanes. All other modules build on these.

pub mod aabb;
pub(crate) mod box_tree;
pub mod ray;
pub mod extremes;
pub mod instructions;
pub(crate) mod simd;
pub(crate) mod vector;
pub mod double_double;
pub mod exact;
pub mod robust;
pub mod rounded;
#[cfg(test)]
pub(crate) mod worst_case;
