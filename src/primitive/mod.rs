//! The primitives that a ray can hit, each with its bounds, intersection and surface, in f64 and world space.

pub mod edge_functions;
pub mod ellipsoid;
pub mod plane;
pub mod shape;
pub mod sphere;
pub mod triangle;
