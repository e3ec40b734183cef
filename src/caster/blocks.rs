//! Eight triangles at once: their data, and the conservative test of a ray against them.

pub mod triangle8;
pub mod filter;
