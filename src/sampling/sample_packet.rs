//! Samples of neighbouring pixels that pass through the stages together: first their rays, then the hits, then the
//! surfaces there, and then the colours.

use crate::math::ray::{Ray, Visible};
use crate::picture::Color;
use crate::world::SurfacePoint;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// The place of a sample in a row of pixels.
#[derive(Clone, Copy, Debug)]
pub struct SamplePlace {
    /// The column of its pixel.
    pub column: usize,
    /// The offset from the pixel's centre, in pixels.
    pub offset: DVec2,
    /// Whether it is the last sample of its pixel.
    pub is_last: bool,
}

/// A sample in a row of pixels, and what its ray hits. The ray is in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Sample {
    /// The ray through the place.
    pub ray: Ray,
    /// The surface that the ray hits first, once it has been computed.
    pub surface: Option<SurfacePoint>,
    /// What the ray hits first, once it has been cast.
    pub visible: Option<Visible>,
    /// Where the ray comes from.
    pub source: SamplePlace,
}

/// The colours of the samples of a packet. Others than those of its samples have no meaning.
pub type PacketColors = [Color; SamplePacket::SIZE];

/// A sample that has not been placed.
const UNPLACED: Sample = Sample {
    ray: Ray { origin: DVec3::ZERO, t_min: 0.0, direction: DVec3::ZERO, t_max: 0.0 },
    surface: None,
    visible: None,
    source: SamplePlace { column: 0, offset: DVec2::ZERO, is_last: false },
};

/// What is wanted of the rays of a packet.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// The first hits.
    pub hits: bool,
    /// The surfaces there.
    pub surfaces: bool,
    /// The colours.
    pub colors: bool,
}

/// Up to [`SIZE`](Self::SIZE) samples of a row.
#[derive(Debug)]
pub struct SamplePacket {
    /// The places of samples, the first of which are taken. They stay where they are from one packet to the next,
    /// because it would take longer to make whole samples than to change what is different.
    places: [Sample; Self::SIZE],
    count: usize,
}

impl Default for SamplePacket {
    fn default() -> Self {
        Self { places: [UNPLACED; Self::SIZE], count: 0 }
    }
}

impl SamplePacket {
    /// The maximum number of samples: so many that their stages overlap, and so few that they stay in the cache.
    pub const SIZE: usize = 32;

    /// The samples.
    #[inline(always)]
    pub fn samples(&self) -> &[Sample] {
        &self.places[..self.count]
    }

    /// The samples, to enter what their rays hit.
    #[inline(always)]
    pub fn samples_mut(&mut self) -> &mut [Sample] {
        &mut self.places[..self.count]
    }

    /// Removes all samples.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether there is room for no more.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == Self::SIZE
    }

    /// Adds the centres of the pixels in these columns.
    #[inline(always)]
    pub fn push_centers(&mut self, columns: Range<usize>) {
        for column in columns {
            self.push(column, DVec2::ZERO, true);
        }
    }

    /// Adds a sample of the pixel in this column, unless the packet is full.
    #[inline(always)]
    pub fn push(&mut self, column: usize, offset: DVec2, is_last: bool) {
        if let Some(place) = self.places.get_mut(self.count) {
            place.source = SamplePlace { column, offset, is_last };
            (place.visible, place.surface) = (None, None);
            self.count += 1;
        }
    }

    /// All places, of which those behind the samples may be written, too.
    #[inline(always)]
    pub fn places_mut(&mut self) -> &mut [Sample; Self::SIZE] {
        &mut self.places
    }
}
