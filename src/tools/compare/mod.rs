//! Compares two pictures: how much they differ, where, and how visible the difference is.
//!
//! A is the examined picture, B the reference. Pixels are given by column and row from the top left, (0, 0), as in
//! picture viewers.

mod difference;
mod difference_picture;
mod edges;
mod flip;

pub use difference::{Comparison, LargestDifference, Tolerance};
pub use difference_picture::DifferencePicture;
pub(crate) use edges::EdgeMap;
use flip::mean_flip;

use crate::diagnostic::Diagnostic;
use crate::picture::{Color, Picture};

/// A pixel's red, green and blue byte.
pub(crate) type Rgb = [u8; 3];

/// Returns the pixels row by row from the top.
pub(crate) fn colors(picture: &Picture) -> &[Rgb] {
    picture.pixels().as_chunks().0
}

/// Returns a colour that is cut to these bytes. It lies halfway between two bytes, so that no rounding changes them.
pub(crate) fn color_of(pixel: Rgb) -> Color {
    Color::from_array(pixel.map(|byte| (f64::from(byte) + 0.5) / 255.0))
}

/// Returns the largest difference of a channel, in levels.
pub(crate) fn largest_channel_difference(a: Rgb, b: Rgb) -> u8 {
    let [red, green, blue] = [0, 1, 2].map(|channel: usize| a[channel].abs_diff(b[channel]));
    red.max(green).max(blue)
}

/// Returns the sum of the channels' squared differences, in levels.
pub(crate) fn sum_of_squares(a: Rgb, b: Rgb) -> u64 {
    a.iter().zip(b).map(|(&a, b)| u64::from(a.abs_diff(b)).pow(2)).sum()
}

/// Returns the width and height of both pictures. Fails if the sizes differ.
pub(crate) fn common_size(a: &Picture, b: &Picture) -> Result<[u32; 2], Diagnostic> {
    let [a, b] = [a, b].map(|picture| [picture.width(), picture.height()]);
    if a == b { Ok(a) } else { Err(sizes_differ(a, b)) }
}

/// Returns the error for two pictures with these different widths and heights.
pub fn sizes_differ([aw, ah]: [u32; 2], [bw, bh]: [u32; 2]) -> Diagnostic {
    Diagnostic::error(format!("the pictures differ in size: {aw} x {ah} pixels against {bw} x {bh}"))
}
