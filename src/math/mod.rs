//! What everything stands on: boxes, rays and the robust arithmetic around them.

pub mod aabb;
pub mod double;
pub mod ray;
pub mod robust;
