//! What is to be rendered.

use crate::camera::Camera;
use crate::grid::Caster;
use crate::raster::VisibilityBuffer;
use crate::render::grid_view::Occupancy;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::stats::Probe;
use crate::trace::Effects;
use std::ops::Range;

/// What the colour picture shows.
#[derive(Clone, Copy, Debug)]
pub enum View<'a> {
    /// The scene, with these effects.
    Scene(Effects),
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy),
}

/// Which pictures are wanted, and how the colours are sampled.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// What the colour picture shows.
    pub view: View<'a>,
    /// Where the samples of a pixel lie.
    pub sampler: Sampler,
    /// How samples become pixels.
    pub filter: Filter,
    /// The colour picture.
    pub color: bool,
    /// The depth picture, white and black at these distances.
    pub depth: Option<[f64; 2]>,
    /// The picture of the normals.
    pub normals: bool,
    /// The picture of the samples, each pixel enlarged so many times.
    pub samples: Option<usize>,
}

impl Request<'_> {
    /// Whether colours are to be traced. Counters alone also want that.
    pub fn traces_colors<P: Probe>(&self) -> bool {
        self.color || self.samples.is_some() || P::COUNTS
    }

    /// Whether the pixels' centres are measured, whatever is sampled.
    pub fn measures(&self) -> bool {
        self.depth.is_some() || self.normals
    }

    /// Whether the rays that colours are traced along are those through the centres, and cast.
    pub fn casts_centers<P: Probe>(&self) -> bool {
        self.traces_colors::<P>() && self.sampler.is_center() && matches!(self.view, View::Scene(_))
    }

    /// What the rays through the pixels' centres in these rows hit first, if they are cast, none of them is
    /// counted, and there is a cheaper way than casting them.
    pub fn visibility<P: Probe>(
        &self,
        camera: &Camera,
        caster: &Caster,
        rows: Range<usize>,
    ) -> Option<VisibilityBuffer> {
        let asks = self.measures() || self.casts_centers::<P>();
        (asks && !P::COUNTS).then(|| VisibilityBuffer::new(camera, caster, self.size, rows))?
    }
}
