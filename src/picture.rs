//! Pictures in memory, and the conversion of their colours to bytes.

use crate::base::memory::{Bytes, with_room};
use glam::DVec3;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt;

/// Linear red, green and blue. 1 is the brightest value that a picture shows, but larger ones are allowed.
pub type Color = DVec3;

/// Bytes per pixel: red, green, blue.
pub const CHANNELS: usize = 3;

/// The error for a picture without pixels, or with too many pixels for the memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BadSize {
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
}

impl fmt::Display for BadSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self { width: 0, .. } | Self { height: 0, .. } => {
                f.write_str("a picture needs at least one pixel each way")
            }
            Self { width, height } => {
                let bytes = (*width as u64).saturating_mul(*height as u64).saturating_mul(CHANNELS as u64);
                let size = Bytes(bytes);
                write!(f, "no memory for a picture of {width} x {height} pixels, at least {size}")
            }
        }
    }
}

impl std::error::Error for BadSize {}

/// A picture of 8-bit RGB pixels, which are stored in rows from the top. The accessors count rows from the
/// bottom, as the camera does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    width: u32,
    height: u32,
    pixels: Vec<u8>,
}

/// A rectangle of pixels. The pixel in the top left corner of the picture is (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Window {
    /// The leftmost column.
    pub x: usize,
    /// The topmost row, counted from the top.
    pub y: usize,
    /// The width in pixels.
    pub width: usize,
    /// The height in pixels.
    pub height: usize,
}

impl Window {
    /// Returns the window that has all pixels of a picture of this width and height.
    pub fn whole([width, height]: [usize; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Returns the column that follows the rightmost one.
    pub fn right(&self) -> usize {
        self.x + self.width
    }

    /// Returns the row that follows the lowest one.
    pub fn bottom(&self) -> usize {
        self.y + self.height
    }

    /// Returns true if the window has pixels and all of them are in a picture of this width and height.
    pub fn fits(&self, [width, height]: [usize; 2]) -> bool {
        let is_within = |at: usize, side: usize, whole: usize| side > 0 && at < whole && side <= whole - at;
        is_within(self.x, self.width, width) && is_within(self.y, self.height, height)
    }

    /// Returns true if the pixel in this column and row is in the window.
    pub fn contains(&self, [x, y]: [usize; 2]) -> bool {
        (self.x..self.right()).contains(&x) && (self.y..self.bottom()).contains(&y)
    }

    /// Returns true if the two windows have a pixel in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.x < other.right() && other.x < self.right() && self.y < other.bottom() && other.y < self.bottom()
    }
}

/// A picture of colours as rendered: neither clamped nor truncated to bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct FloatPicture {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The colour of each pixel, row by row from the top.
    pub colors: Vec<Color>,
}

impl FloatPicture {
    /// Returns an empty picture with room for this width and height. A picture without pixels, or with too many for the
    /// memory, is an error.
    pub fn with_room(size: [usize; 2]) -> Result<Self, BadSize> {
        let failed = || BadSize { width: size[0], height: size[1] };
        let count = size[0].checked_mul(size[1]).filter(|&count| count > 0).ok_or_else(failed)?;
        Ok(Self { size, colors: with_room(count).map_err(|_| failed())? })
    }

    /// Converts the colours to bytes with [`truncate_to_bytes`], and counts the colours with a NaN.
    pub fn to_bytes(&self) -> (Vec<u8>, u64) {
        let mut bytes = vec![0; self.colors.len() * CHANNELS];
        let nans = truncate_to_bytes::<RED_FIRST>(&self.colors, &mut bytes);
        (bytes, nans)
    }

    /// Rounds the numbers to those that a floating-point file holds.
    #[must_use]
    pub fn in_single_precision(mut self) -> Self {
        self.colors.iter_mut().for_each(|color| *color = color.as_vec3().as_dvec3());
        self
    }

    /// Returns the picture of bytes that is written to a file.
    pub fn to_picture(&self) -> Picture {
        let [width, height] = self.size.map(|n| n as u32);
        Picture::from_rgb(width, height, self.to_bytes().0)
    }
}

/// A picture in the form of its file.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Bytes, from 0 to 255.
    Bytes(Picture),
    /// Numbers, neither clamped nor truncated.
    Numbers(FloatPicture),
}

impl Pixels {
    /// Returns a picture of zeros.
    pub fn zeros(size @ [width, height]: [usize; 2], are_numbers: bool) -> Result<Self, BadSize> {
        if are_numbers {
            let mut picture = FloatPicture::with_room(size)?;
            picture.colors.resize(width * height, Color::ZERO);
            return Ok(Self::Numbers(picture));
        }
        let side = |side: usize| u32::try_from(side).unwrap_or(u32::MAX);
        Picture::new(side(width), side(height)).map(Self::Bytes)
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Bytes(picture) => picture.size(),
            Self::Numbers(picture) => picture.size,
        }
    }

    /// Consumes the picture and returns its bytes, to which numbers are truncated.
    pub fn into_bytes(self) -> Picture {
        match self {
            Self::Bytes(picture) => picture,
            Self::Numbers(picture) => picture.to_picture(),
        }
    }

    /// Sets pixels from this column and row on, counted from the top left. Returns the number of colours with a NaN that
    /// become black.
    pub fn set(&mut self, [x, y]: [usize; 2], colors: &[Color]) -> u64 {
        let start = y * self.size()[0] + x;
        match self {
            Self::Bytes(picture) => {
                let bytes = &mut picture.pixels[start * CHANNELS..][..colors.len() * CHANNELS];
                truncate_to_bytes::<RED_FIRST>(colors, bytes)
            }
            Self::Numbers(picture) => {
                picture.colors[start..][..colors.len()].copy_from_slice(colors);
                0
            }
        }
    }

    /// Returns the bytes, to which numbers are truncated.
    pub fn bytes(&self) -> Cow<'_, Picture> {
        match self {
            Self::Bytes(picture) => Cow::Borrowed(picture),
            Self::Numbers(picture) => Cow::Owned(picture.to_picture()),
        }
    }
}

/// The index of red in a pixel's bytes if red comes first, for [`truncate_to_bytes`].
pub const RED_FIRST: usize = 0;
/// The index of red in a pixel's bytes if blue comes first, for [`truncate_to_bytes`].
pub const BLUE_FIRST: usize = 2;

/// Converts colours to bytes, [`CHANNELS`] for each with red at index `RED`: 255 times each channel,
/// truncated (not rounded) to a whole number and clamped to 0..=255, as in the course's program. NaN becomes
/// 0. Returns the number of colours with a NaN.
#[inline]
pub fn truncate_to_bytes<const RED: usize>(colors: &[Color], bytes: &mut [u8]) -> u64 {
    let mut has_nan = false;
    for (pixel, color) in bytes.chunks_exact_mut(CHANNELS).zip(colors) {
        // The sum is NaN if any channel is NaN, or if two are opposite infinities. Testing each channel takes longer.
        has_nan |= (color.x + color.y + color.z).is_nan();
        // The conversion truncates, clamps and maps NaN to 0.
        let [red, green, blue] = (255.0 * color).to_array().map(|channel| channel as u8);
        (pixel[RED], pixel[1], pixel[2 - RED]) = (red, green, blue);
    }
    if has_nan { colors.iter().filter(|color| color.is_nan()).count() as u64 } else { 0 }
}

impl Picture {
    /// Returns a black picture. A picture without pixels, or with too many for the memory, is an error.
    pub fn new(width: u32, height: u32) -> Result<Self, BadSize> {
        let failed = || BadSize { width: width as usize, height: height as usize };
        let size = byte_count(width, height).filter(|&size| size > 0).ok_or_else(failed)?;
        let mut pixels = with_room(size).map_err(|_| failed())?;
        pixels.resize(size, 0);
        Ok(Self { width, height, pixels })
    }

    /// Returns a picture of these bytes. Their number must be `width * height * 3`.
    pub fn from_rgb(width: u32, height: u32, pixels: Vec<u8>) -> Self {
        debug_assert_eq!(Some(pixels.len()), byte_count(width, height));
        Self { width, height, pixels }
    }

    /// Returns the width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        [self.width as usize, self.height as usize]
    }

    /// The width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the bytes of the pixels: red, green and blue of each, in rows from the top.
    pub fn pixels(&self) -> &[u8] {
        &self.pixels
    }

    /// Consumes the picture and returns the bytes of the pixels.
    pub fn into_pixels(self) -> Vec<u8> {
        self.pixels
    }

    /// Returns the bytes of the pixels for modification.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.pixels
    }

    /// Returns the pixel in column `i` and row `j`, counted from the bottom left; `None` if it is outside the picture.
    pub fn get(&self, i: u32, j: u32) -> Option<[u8; CHANNELS]> {
        let is_inside = i < self.width && j < self.height;
        let row = is_inside.then(|| self.height - 1 - j)?;
        let start = (row as usize * self.width as usize + i as usize) * CHANNELS;
        self.pixels.get(start..)?.first_chunk().copied()
    }

    /// Returns the bytes of row `j`, counted from the bottom. `j` must be less than the height.
    pub fn row_mut(&mut self, j: usize) -> &mut [u8] {
        let bytes = self.width as usize * CHANNELS;
        let from_top = self.height as usize - 1 - j;
        &mut self.pixels[from_top * bytes..][..bytes]
    }
}

fn byte_count(width: u32, height: u32) -> Option<usize> {
    let pixels = u64::from(width) * u64::from(height);
    usize::try_from(pixels).ok()?.checked_mul(CHANNELS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_colour_with_a_nan_is_counted_once() {
        let colors = vec![Color::new(1.0, f64::NAN, 0.2), Color::splat(f64::NAN), Color::splat(0.5)];
        let (bytes, nans) = FloatPicture { size: [3, 1], colors }.to_bytes();
        assert_eq!((bytes, nans), (vec![255, 0, 51, 0, 0, 0, 127, 127, 127], 2));
    }

    #[test]
    fn impossible_sizes_are_errors() {
        for (width, height) in [(0, 5), (5, 0), (u32::MAX, u32::MAX)] {
            assert!(matches!(Picture::new(width, height), Err(BadSize { .. })));
        }
    }
}
