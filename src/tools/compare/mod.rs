//! Two pictures side by side: how far they differ, where, and how visible that is.
//!
//! A is the picture in question, B the reference. Pixels are named by column and row from the top
//! left, (0, 0), as picture viewers do.

mod difference;
mod difference_picture;
mod edges;
mod error;
mod flip;
mod tolerance;

pub use difference::{Comparison, LargestDifference};
pub use difference_picture::DifferencePicture;
pub(crate) use edges::EdgeMap;
pub use error::CompareError;
pub use flip::{Flip, PIXELS_PER_DEGREE};
pub use tolerance::Tolerance;

use crate::picture::Picture;

/// A pixel's red, green and blue byte.
pub(crate) type Rgb = [u8; 3];

/// The pixels row by row from the top.
pub(crate) fn colors(picture: &Picture) -> &[Rgb] {
    picture.pixels().as_chunks().0
}

/// The largest difference of a channel, in levels.
pub(crate) fn largest_channel_difference(a: Rgb, b: Rgb) -> u8 {
    let [red, green, blue] = [0, 1, 2].map(|channel: usize| a[channel].abs_diff(b[channel]));
    red.max(green).max(blue)
}

/// The sum of the squared differences of the channels, in levels.
pub(crate) fn sum_of_squares(a: Rgb, b: Rgb) -> u64 {
    a.iter().zip(b).map(|(&a, b)| u64::from(a.abs_diff(b)).pow(2)).sum()
}

/// Width and height of both, which must be the same.
fn common_size(a: &Picture, b: &Picture) -> Result<[u32; 2], CompareError> {
    let [a, b] = [a, b].map(|picture| [picture.width(), picture.height()]);
    match a == b {
        true => Ok(a),
        false => Err(CompareError::Sizes { a, b }),
    }
}
