//! Several samples a pixel: where they fall, how they are weighted, how they add up.

pub mod drand48;
pub mod filter;
pub mod film;
pub mod sampler;
