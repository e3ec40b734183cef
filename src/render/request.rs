//! What is to be rendered.

use crate::grid::visualize::Occupancy;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::trace::Effects;

/// What the colour picture shows.
#[derive(Clone, Copy, Debug)]
pub enum View<'a> {
    Scene(Effects),
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy),
}

/// Which pictures are wanted, and how the colours are sampled.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Width and height in pixels.
    pub size: [usize; 2],
    pub view: View<'a>,
    pub sampler: Sampler,
    pub filter: Filter,
    /// The colour picture.
    pub color: bool,
    /// The depth picture, white and black at these distances.
    pub depth: Option<[f64; 2]>,
    pub normals: bool,
    /// The picture of the samples, each pixel enlarged so many times.
    pub samples: Option<usize>,
}
