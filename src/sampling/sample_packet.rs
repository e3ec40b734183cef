//! Samples of neighbouring pixels that pass through the stages together: rays, first hits, surfaces, colours.

use crate::math::ray::{Ray, Visible};
use crate::picture::Color;
use crate::world::SurfacePoint;
use glam::{DVec2, DVec3};

/// A sample in a row of pixels, and the hit of its ray. The ray is in one cache line.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Sample {
    /// The ray through the sample.
    pub ray: Ray,
    /// The surface at the first hit, once computed.
    pub surface: Option<SurfacePoint>,
    /// The first hit of the ray, once cast.
    pub visible: Option<Visible>,
    /// The column of its pixel.
    pub column: usize,
    /// The offset from the pixel's centre, in pixels.
    pub offset: DVec2,
    /// True for the last sample of its pixel.
    pub is_last: bool,
}

/// An unused slot.
const UNPLACED: Sample = Sample {
    ray: Ray { origin: DVec3::ZERO, t_min: 0.0, direction: DVec3::ZERO, t_max: 0.0 },
    surface: None,
    visible: None,
    column: 0,
    offset: DVec2::ZERO,
    is_last: false,
};

/// The stages that samples pass through, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The rays are computed.
    Rays,
    /// Their first hits are found.
    Hits,
    /// The surfaces there are computed.
    Surfaces,
    /// The colours are computed.
    Colors,
}

/// Up to [`SIZE`](Self::SIZE) samples of a row.
#[derive(Debug)]
pub struct SamplePacket {
    /// The samples, followed by unused slots. Slots are reused from one packet to the next, because overwriting the
    /// changed parts is faster than building whole samples.
    places: [Sample; Self::SIZE],
    /// The colours of the samples. Entries beyond the samples have no meaning.
    colors: [Color; Self::SIZE],
    count: usize,
}

impl Default for SamplePacket {
    fn default() -> Self {
        Self { places: [UNPLACED; Self::SIZE], colors: [Color::ZERO; Self::SIZE], count: 0 }
    }
}

impl SamplePacket {
    /// The maximum number of samples: large enough for the stages to overlap, small enough for the cache.
    pub const SIZE: usize = 32;

    /// Returns the samples.
    #[inline(always)]
    pub fn samples(&self) -> &[Sample] {
        &self.places[..self.count]
    }

    /// Returns the samples, so that hits can be stored in them.
    #[inline(always)]
    pub fn samples_mut(&mut self) -> &mut [Sample] {
        &mut self.places[..self.count]
    }

    /// Returns the colours of the samples.
    #[inline(always)]
    pub fn colors(&self) -> &[Color] {
        &self.colors[..self.count]
    }

    /// Returns the samples, and their colours to be set.
    #[inline(always)]
    pub fn colors_mut(&mut self) -> impl Iterator<Item = (&Sample, &mut Color)> {
        self.places[..self.count].iter().zip(&mut self.colors)
    }

    /// Removes all samples.
    #[inline(always)]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Returns true if the packet is full.
    #[inline(always)]
    pub fn is_full(&self) -> bool {
        self.count == Self::SIZE
    }

    /// Adds a sample of the pixel in this column, unless the packet is full.
    #[inline(always)]
    pub fn push(&mut self, column: usize, offset: DVec2, is_last: bool) {
        if let Some(place) = self.places.get_mut(self.count) {
            (place.column, place.offset, place.is_last) = (column, offset, is_last);
            (place.visible, place.surface) = (None, None);
            self.count += 1;
        }
    }

    /// Returns all slots. Slots after the last sample may be written, too.
    #[inline(always)]
    pub fn places_mut(&mut self) -> &mut [Sample; Self::SIZE] {
        &mut self.places
    }
}
