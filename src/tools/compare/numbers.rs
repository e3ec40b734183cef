//! Measures the difference of two pictures of numbers.
//!
//! Two numbers are equal if they are the same, the same infinity, or both not a number (NaN): a picture equals itself.
//! A NaN or an infinity differs from everything else by more than any tolerance.

use super::{Line, percent, same_size};
use crate::diagnostic::Diagnostic;
use crate::picture::{Color, FloatPicture};
use serde::Serialize;
use std::fmt;

/// The difference of A from B.
#[derive(Clone, Debug)]
pub struct NumberComparison {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The first pixel with the largest difference of finite numbers, rows from the top. `None` if all are equal.
    pub largest: Option<NumberDifference>,
    /// The first pixel with the largest difference of finite numbers in parts of B's number, which is not 0.
    pub largest_relative: Option<NumberDifference>,
    /// The root mean square error over all channels in which both numbers are finite.
    pub root_mean_square_error: f64,
    /// The pixels of A and of B with numbers that are not finite.
    pub not_finite: [NotFinite; 2],
    /// The first pixel in which a number that is not finite meets another one.
    pub first_not_finite: Option<NumberDifference>,
    /// The largest difference of each differing pixel. It is infinite if one of the numbers is not finite.
    differences: Vec<f64>,
}

/// A pixel that differs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NumberDifference {
    /// Column and row from the top left.
    pub at: [usize; 2],
    /// The largest difference of a channel.
    pub difference: f64,
    /// The pixel's red, green and blue in A.
    pub a: Color,
    /// The pixel's red, green and blue in B.
    pub b: Color,
}

/// The number of pixels with a number that is not finite.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct NotFinite {
    /// Those with a NaN.
    pub nan: u64,
    /// Those with an infinity.
    pub infinite: u64,
}

impl NumberComparison {
    /// Compares the picture `a` with the reference `b`. Fails if the sizes differ.
    pub fn new(a: &FloatPicture, b: &FloatPicture) -> Result<Self, Diagnostic> {
        let size = same_size([a.size, b.size])?;
        let mut comparison = Self {
            size,
            largest: None,
            largest_relative: None,
            root_mean_square_error: 0.0,
            not_finite: [a, b].map(NotFinite::count),
            first_not_finite: None,
            differences: vec![],
        };
        let (mut squares, mut channels) = (0.0, 0);
        for (index, (&a, &b)) in a.colors.iter().zip(&b.colors).enumerate() {
            for (a, b) in finite_channels(a, b) {
                squares += (a - b).powi(2);
                channels += 1;
            }
            comparison.add(index, a, b);
        }
        comparison.root_mean_square_error = (squares / f64::from(channels.max(1))).sqrt();
        Ok(comparison)
    }

    /// Measures a pixel.
    fn add(&mut self, index: usize, a: Color, b: Color) {
        let at = [index % self.size[0], index / self.size[0]];
        let largest = |differences: &mut dyn Iterator<Item = f64>| {
            let difference = differences.fold(0.0, f64::max);
            NumberDifference { at, difference, a, b }
        };
        let absolute = largest(&mut finite_channels(a, b).map(|(a, b)| (a - b).abs()));
        let with_parts = finite_channels(a, b).filter(|(_, b)| *b != 0.0);
        let relative = largest(&mut with_parts.map(|(a, b)| ((a - b) / b).abs()));
        keep_larger(&mut self.largest, absolute);
        keep_larger(&mut self.largest_relative, relative);
        let meets_another = (0..3).any(|channel| difference(a[channel], b[channel]) == f64::INFINITY);
        if meets_another {
            let all = NumberDifference { difference: f64::INFINITY, ..absolute };
            self.first_not_finite.get_or_insert(all);
            self.differences.push(f64::INFINITY);
        } else if absolute.difference > 0.0 {
            self.differences.push(absolute.difference);
        }
    }

    /// Returns the number of pixels in each picture.
    pub fn pixels(&self) -> u64 {
        self.size.into_iter().product::<usize>() as u64
    }

    /// Returns the number of pixels with a channel that differs by more than this.
    pub fn pixels_differing_by_more_than(&self, most: f64) -> u64 {
        self.differences.iter().filter(|&&difference| difference > most).count() as u64
    }

    /// Returns the number of pixels in which a number that is not finite meets another one.
    pub fn pixels_not_finite_in_one(&self) -> u64 {
        self.pixels_differing_by_more_than(f64::MAX)
    }

    /// Returns the lines of the block.
    pub(super) fn lines(&self) -> Vec<Line> {
        let [width, height] = self.size;
        let counted = |count| format!("{count} ({})", percent(count, self.pixels()));
        let shown = |largest: &Option<NumberDifference>| largest.map_or("0".into(), |it| it.to_string());
        let pair = |count: fn(&NotFinite) -> u64| {
            let [a, b] = self.not_finite.each_ref().map(count);
            format!("{a} against {b}")
        };
        let mut lines = vec![
            ("size", format!("{width}x{height}")),
            ("compared as", "floating-point numbers".into()),
            ("pixels that differ", counted(self.pixels_differing_by_more_than(0.0))),
            ("largest difference", shown(&self.largest)),
            ("largest relative", shown(&self.largest_relative)),
            ("root mean square error", Number(self.root_mean_square_error).to_string()),
            ("pixels that are NaN", pair(|counts| counts.nan)),
            ("pixels that are infinite", pair(|counts| counts.infinite)),
        ];
        if let Some(NumberDifference { at: [x, y], a, b, .. }) = self.first_not_finite {
            let first = format!("first at ({x}, {y}): {} against {}", color(a), color(b));
            let count = self.pixels_not_finite_in_one();
            lines.push(("NaN or infinite in one", format!("{count}, {first}")));
        }
        lines
    }
}

impl NotFinite {
    fn count(picture: &FloatPicture) -> Self {
        let mut counts = Self::default();
        for color in &picture.colors {
            counts.nan += u64::from(color.is_nan());
            counts.infinite += u64::from(color.to_array().into_iter().any(f64::is_infinite));
        }
        counts
    }
}

/// Returns the difference of two numbers: 0 if they are equal, and infinite if only one is finite, or both are not but
/// not the same.
pub(super) fn difference(a: f64, b: f64) -> f64 {
    match a == b || a.is_nan() && b.is_nan() {
        true => 0.0,
        false if a.is_finite() && b.is_finite() => (a - b).abs(),
        false => f64::INFINITY,
    }
}

/// Returns the numbers of the channels that are finite in both.
fn finite_channels(a: Color, b: Color) -> impl Iterator<Item = (f64, f64)> {
    let pairs = a.to_array().into_iter().zip(b.to_array());
    pairs.filter(|(a, b)| a.is_finite() && b.is_finite())
}

fn keep_larger(kept: &mut Option<NumberDifference>, found: NumberDifference) {
    let least = kept.map_or(0.0, |kept| kept.difference);
    if found.difference > least {
        *kept = Some(found);
    }
}

/// A number with as many digits as single precision has.
pub(super) struct Number(pub f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = format!("{:?}", self.0 as f32);
        f.write_str(text.strip_suffix(".0").unwrap_or(&text))
    }
}

/// Formats a colour, or the number that its channels have in common.
fn color(color: Color) -> String {
    let [red, green, blue] = color.to_array().map(|channel| Number(channel).to_string());
    if red == green && green == blue { red } else { format!("({red}, {green}, {blue})") }
}

impl fmt::Display for NumberDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at: [x, y], difference, a, b } = self;
        write!(f, "{} at ({x}, {y}): {} against {}", Number(*difference), color(*a), color(*b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(numbers: &[f64]) -> FloatPicture {
        let colors = numbers.iter().map(|&number| Color::splat(number)).collect();
        FloatPicture { size: [numbers.len(), 1], colors }
    }

    fn compared(a: &[f64], b: &[f64]) -> NumberComparison {
        NumberComparison::new(&picture(a), &picture(b)).unwrap()
    }

    #[test]
    fn numbers_are_neither_clamped_nor_cut() {
        let found = compared(&[13.0, 0.5, 2.0], &[6.0, 0.5, 1.9990234375]);
        let at = |largest: Option<NumberDifference>| largest.map(|it| (it.at, it.difference));
        assert_eq!(at(found.largest), Some(([0, 0], 7.0)));
        assert_eq!(at(found.largest_relative), Some(([0, 0], 7.0 / 6.0)));
        assert_eq!([0.0, 1e-4, 1.0, 7.0].map(|most| found.pixels_differing_by_more_than(most)), [2, 2, 1, 0]);
        let square = (49.0 + 0.0009765625f64.powi(2)) / 3.0;
        assert!((found.root_mean_square_error - square.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_not_finite_equals_only_itself() {
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        let all = [nan, inf, -inf, 1.0, 0.0];
        for (i, &a) in all.iter().enumerate() {
            for (j, &b) in all.iter().enumerate() {
                let found = compared(&[a], &[b]);
                assert_eq!(found.pixels_differing_by_more_than(0.0), u64::from(i != j), "{a} {b}");
                let is_beyond = found.pixels_differing_by_more_than(1e300);
                assert_eq!(is_beyond, u64::from(i != j && i.min(j) < 3), "{a} {b}");
            }
        }
        let found = compared(&[nan, inf, 1.0, nan], &[nan, 2.0, 4.0, 3.0]);
        assert_eq!(found.not_finite, [NotFinite { nan: 2, infinite: 1 }, NotFinite { nan: 1, infinite: 0 }]);
        assert_eq!((found.pixels_not_finite_in_one(), found.root_mean_square_error), (2, 3.0));
        assert_eq!(found.largest.map(|largest| largest.difference), Some(3.0));
        assert_eq!(found.first_not_finite.map(|first| first.at), Some([1, 0]));
    }

    #[test]
    fn parts_of_zero_are_left_out() {
        let found = compared(&[1.0, 2.0], &[0.0, 4.0]);
        assert_eq!(found.largest_relative.map(|it| (it.at, it.difference)), Some(([1, 0], 0.5)));
        assert!(compared(&[1.0], &[0.0]).largest_relative.is_none());
    }

    #[test]
    fn numbers_have_the_digits_of_single_precision() {
        let rows =
            [(6.0, "6"), (0.1f32.into(), "0.1"), (1e30, "1e30"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")];
        for (number, expected) in rows {
            assert_eq!(Number(number).to_string(), expected);
        }
    }
}
