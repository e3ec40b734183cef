//! What everything stands on: boxes, rays and the robust arithmetic around them.

pub mod aabb;
pub mod double_double;
pub mod exact_sum;
pub mod extremes;
pub mod four;
pub mod packet;
pub mod predicate;
pub mod prefetch;
pub mod ray;
pub mod robust;
pub mod scaled;
