//! What is to be rendered.

use crate::camera::Camera;
use crate::caster::Caster;
use crate::grid::visualize::Occupancy;
use crate::projection::Projection;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::stats::Probe;
use crate::trace::Effects;
use std::ops::Range;

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

impl Request<'_> {
    /// What the rays through the pixels' centres in these rows hit first, if they are cast, none of them is
    /// counted, and there is a cheaper way than casting them.
    pub fn projection<P: Probe>(
        &self,
        camera: &Camera,
        caster: &Caster,
        rows: Range<usize>,
    ) -> Option<Projection> {
        let samples_centers = self.sampler.is_center() && matches!(self.view, View::Scene(_));
        let asks = samples_centers || self.depth.is_some() || self.normals;
        if P::COUNTS || !asks { None } else { Projection::new(camera, caster, self.size, rows) }
    }
}
