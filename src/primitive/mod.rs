//! What a ray can hit: one file each with bounds and intersection, all in f64 and world space.

pub mod edge_functions;
pub mod ellipsoid;
pub mod plane;
pub mod sphere;
pub mod triangle;
