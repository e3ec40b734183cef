//! Supersampling: sample positions in a pixel, reconstruction filters, and the film that sums samples.

pub mod sample_packet;
pub mod drand48;
pub mod c_rand;
pub mod blur;
pub mod filter;
pub mod sum;
pub mod spread;
pub mod film;
pub mod sobol;
pub mod sampler;
