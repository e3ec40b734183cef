//! Compares two pictures: how much they differ, where, and how visible the difference is.
//!
//! Two pictures of numbers, as floating-point files have them, are compared by their numbers. All others are compared by
//! their bytes, in levels.
//!
//! A is the examined picture, B the reference. Pixels are given by column and row from the top left, (0, 0), as in
//! picture viewers.

mod difference;
mod difference_picture;
mod edges;
mod flip;
mod numbers;

pub use difference::{Comparison, LargestDifference};
pub use difference_picture::{Brightness, DifferencePicture, Scale};
pub(crate) use edges::EdgeMap;
use flip::mean_flip;
pub use numbers::{NotFinite, NumberComparison, NumberDifference};

use crate::diagnostic::Diagnostic;
use crate::picture::{Color, Picture, Pixels};
use crate::stats::RULE;
use rayon::prelude::*;
use serde::Serialize;

/// The difference of a picture from a reference.
#[derive(Clone, Debug)]
pub enum Difference {
    /// Between bytes.
    Levels(Box<Comparison>),
    /// Between numbers.
    Numbers(Box<NumberComparison>),
}

impl Difference {
    /// Compares the picture `a` with the reference `b`. Fails if the sizes differ.
    pub fn new(a: &Pixels, b: &Pixels) -> Result<Self, Diagnostic> {
        match (a, b) {
            (Pixels::Numbers(a), Pixels::Numbers(b)) => {
                NumberComparison::new(a, b).map(Box::new).map(Self::Numbers)
            }
            _ => Comparison::new(&a.bytes(), &b.bytes()).map(Box::new).map(Self::Levels),
        }
    }

    /// Compares each of these pictures with the reference `b`, without FLIP. Fails if the sizes differ.
    pub fn of_each(pictures: &[Pixels], b: &Pixels) -> Result<Vec<Self>, Diagnostic> {
        let bytes = b.bytes();
        let edges = EdgeMap::new(&bytes);
        let compare = |a: &Pixels| match (a, b) {
            (Pixels::Numbers(_), Pixels::Numbers(_)) => Self::new(a, b),
            _ => Comparison::without_flip(&a.bytes(), &bytes, &edges).map(Box::new).map(Self::Levels),
        };
        pictures.par_iter().map(compare).collect()
    }

    /// Returns the number of pixels in each picture.
    pub fn pixels(&self) -> u64 {
        match self {
            Self::Levels(comparison) => comparison.pixels(),
            Self::Numbers(comparison) => comparison.pixels(),
        }
    }

    /// Returns the number of differing pixels.
    pub fn pixels_that_differ(&self) -> u64 {
        self.pixels_differing_by_more_than(0.0)
    }

    /// Returns the number of pixels with a channel that differs by more than this many levels, or by more than this
    /// number.
    pub fn pixels_differing_by_more_than(&self, most: f64) -> u64 {
        match self {
            // The differences of bytes are whole numbers.
            Self::Levels(comparison) => comparison.pixels_differing_by_more_than(most as u8),
            Self::Numbers(comparison) => comparison.pixels_differing_by_more_than(most),
        }
    }

    /// Returns the largest difference, in levels or of numbers. It is infinite if one of two numbers is not finite.
    pub fn largest(&self) -> f64 {
        match self {
            Self::Levels(comparison) => comparison.largest.map_or(0.0, |largest| largest.levels.into()),
            Self::Numbers(comparison) => {
                comparison.first_not_finite.or(comparison.largest).map_or(0.0, |largest| largest.difference)
            }
        }
    }

    /// Returns the root mean square error, in levels or of numbers.
    pub fn root_mean_square_error(&self) -> f64 {
        match self {
            Self::Levels(comparison) => comparison.root_mean_square_error,
            Self::Numbers(comparison) => comparison.root_mean_square_error,
        }
    }

    /// Returns the block, which ends with these lines.
    pub fn block(&self, more: impl IntoIterator<Item = Line>) -> String {
        let lines = match self {
            Self::Levels(comparison) => comparison.lines(),
            Self::Numbers(comparison) => comparison.lines(),
        };
        block(lines.into_iter().chain(more))
    }
}

/// At most `pixels` pixels may differ by more than `levels`. The default requires equality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Tolerance {
    /// The difference permitted for all pixels: in levels, or of numbers.
    pub levels: f64,
    /// The number of pixels that may differ by more.
    pub pixels: u64,
}

impl Tolerance {
    /// Returns true if the difference is within the tolerance.
    pub fn accepts(&self, difference: &Difference) -> bool {
        difference.pixels_differing_by_more_than(self.levels) <= self.pixels
    }
}

/// A line of a block: its label and value.
pub type Line = (&'static str, String);

/// Returns a block in the form of the statistics.
fn block(lines: impl IntoIterator<Item = Line>) -> String {
    let line = |(label, value): Line| format!("  {label:<27}{value}\n");
    let lines: String = lines.into_iter().map(line).collect();
    format!("{RULE}\nPICTURE COMPARISON\n{lines}{RULE}\n")
}

/// Formats a percentage with four decimals, so that one pixel in a million shows. Returns `NULL` if `whole` is 0, as in
/// the statistics.
fn percent(part: u64, whole: u64) -> String {
    match whole {
        0 => "NULL".to_owned(),
        _ => format!("{:.4}%", 100.0 * part as f64 / whole as f64),
    }
}

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

/// Returns the width and height of two pictures. Fails if they differ.
fn same_size([a, b]: [[usize; 2]; 2]) -> Result<[usize; 2], Diagnostic> {
    if a == b { Ok(a) } else { Err(sizes_differ(a, b)) }
}

/// Returns the error for two pictures with these different widths and heights.
pub fn sizes_differ(a @ [aw, ah]: [usize; 2], b @ [bw, bh]: [usize; 2]) -> Diagnostic {
    let relation = relation(a, b).map_or(String::new(), |is| format!("; the first {is}"));
    Diagnostic::error(format!(
        "the pictures differ in size: {aw} x {ah} pixels against {bw} x {bh}{relation}"
    ))
}

/// Says how a picture of the width and height `a` comes from one of `b`, if that is simple.
pub fn relation([aw, ah]: [usize; 2], [bw, bh]: [usize; 2]) -> Option<String> {
    let times = |[w, h]: [usize; 2], [small_w, small_h]: [usize; 2]| {
        let factor = w.checked_div(small_w).filter(|&factor| factor > 1)?;
        let is_multiple = small_w.checked_mul(factor) == Some(w) && small_h.checked_mul(factor) == Some(h);
        is_multiple.then_some(factor)
    };
    match (times([aw, ah], [bw, bh]), times([bw, bh], [aw, ah])) {
        (Some(2), _) => Some("is twice the size".into()),
        (Some(factor), _) => Some(format!("is {factor} times the size")),
        (_, Some(2)) => Some("is half the size".into()),
        (_, Some(factor)) => Some(format!("is 1/{factor} of the size")),
        _ if [aw, ah] == [bh, bw] => Some("is transposed: its width and height are swapped".into()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::relation;

    #[test]
    fn simple_relations_of_sizes_are_named() {
        for (a, expected) in [([10, 10], None), ([80, 30], None), ([40, 31], None), ([0, 0], None)] {
            assert_eq!(relation(a, [40, 30]).as_deref(), expected, "{a:?}");
        }
        assert_eq!(relation([1, 1], [9, 9]).as_deref(), Some("is 1/9 of the size"));
    }
}
