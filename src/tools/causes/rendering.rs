//! A picture rendered by this program, and how another one differs from it.

use crate::picture::{Color, FloatPicture};
use crate::tools::compare::{Rgb, largest_channel_difference};

/// The largest error of a colour in single precision, in levels.
const ROUNDING: f64 = 1.0 / 64.0;

/// A pixel of a rendered picture: its colour as bytes, and the bytes to which rounding may change it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RenderedPixel {
    pub bytes: Rgb,
    low: Rgb,
    high: Rgb,
}

impl RenderedPixel {
    pub fn new(color: Color) -> Self {
        // The conversion truncates, clamps and maps NaN to 0.
        let moved = |levels: f64| color.to_array().map(|channel| (255.0 * channel + levels) as u8);
        Self { bytes: moved(0.0), low: moved(-ROUNDING), high: moved(ROUNDING) }
    }

    /// Returns the levels by which a pixel differs by more than the rounding of a colour.
    pub fn levels(&self, pixel: Rgb) -> u8 {
        let levels = |channel: usize| {
            let (byte, low, high) = (pixel[channel], self.low[channel], self.high[channel]);
            low.saturating_sub(byte).max(byte.saturating_sub(high))
        };
        levels(0).max(levels(1)).max(levels(2))
    }

    /// Returns true if a pixel differs by more than one level.
    pub fn differs_visibly(&self, pixel: Rgb) -> bool {
        largest_channel_difference(pixel, self.bytes) > 1 && self.levels(pixel) > 0
    }

    /// Returns true if a pixel is brighter in the channel that differs most.
    pub fn is_below(&self, pixel: Rgb) -> bool {
        let signed = |channel: usize| i16::from(pixel[channel]) - i16::from(self.bytes[channel]);
        let largest = [0, 1, 2].map(signed).into_iter().max_by_key(|difference| difference.abs());
        largest.is_some_and(|difference| difference > 0)
    }
}

/// A picture rendered by this program, perhaps with mistakes.
#[derive(Clone, Debug)]
pub struct Rendering {
    pub colors: Vec<Color>,
    pub pixels: Vec<RenderedPixel>,
}

impl Rendering {
    pub fn new(picture: FloatPicture) -> Self {
        let pixels = picture.colors.iter().map(|&color| RenderedPixel::new(color)).collect();
        Self { colors: picture.colors, pixels }
    }

    /// Returns true if the pictures are equal up to rounding.
    pub fn is_like(&self, other: &Self) -> bool {
        self.pixels.iter().zip(&other.pixels).all(|(pixel, other)| pixel.levels(other.bytes) == 0)
    }
}
