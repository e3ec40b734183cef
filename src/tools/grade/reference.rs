//! A reference, and the verdict on a picture.

use crate::picture::{FloatPicture, Pixels};
use crate::tools::causes::{Finding, MAX_UNEXPLAINED, Original, explain};
use crate::tools::compare::{Difference, Scale, Tolerance};
use std::fmt;

/// The condition on which a picture passes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    Equal,
    /// Rounding of single precision explains all differing pixels but two. Where no scene is known, the pictures are equal.
    Rounding,
    Tolerance(Tolerance),
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Equal => f.write_str("none"),
            Self::Rounding => write!(f, "rounding of single precision, and {MAX_UNEXPLAINED} pixels"),
            Self::Tolerance(Tolerance { levels, pixels }) => write!(f, "{levels} levels, {pixels} pixels"),
        }
    }
}

/// A picture to grade by.
pub struct Reference<'r> {
    pub pixels: Pixels,
    /// Its colours, if they are known.
    colors: Option<FloatPicture>,
    /// The scene, if its mistakes can be tried.
    original: Option<Original<'r>>,
}

/// The verdict on a picture that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verdict {
    pub passes: bool,
    /// The number of pixels that rounding does not explain, if that is the rule and the scene is known.
    pub unexplained: Option<u64>,
}

impl<'r> Reference<'r> {
    /// A picture from a file.
    pub fn of_file(pixels: Pixels) -> Self {
        Self { pixels, colors: None, original: None }
    }

    /// A rendered picture, whose file has bytes or numbers.
    pub fn rendered(colors: FloatPicture, has_numbers: bool) -> Self {
        let pixels = in_file(&colors, has_numbers);
        Self { pixels, colors: Some(colors), original: None }
    }

    /// A rendered picture of a scene whose mistakes can be tried.
    pub fn of_scene(original: Original<'r>, has_numbers: bool) -> Self {
        Self { pixels: in_file(original.colors(), has_numbers), colors: None, original: Some(original) }
    }

    /// Judges a picture with this difference.
    pub fn judge(&self, rule: Rule, picture: &Pixels, difference: &Difference) -> Verdict {
        let unexplained = match (rule, &self.original, difference) {
            (Rule::Tolerance(tolerance), ..) => {
                return Verdict { passes: tolerance.accepts(difference), unexplained: None };
            }
            (Rule::Rounding, Some(original), Difference::Levels(_)) => {
                Some(original.unexplained(&picture.bytes()))
            }
            _ => None,
        };
        let left = unexplained.unwrap_or(difference.pixels_that_differ());
        let most = if unexplained.is_some() { MAX_UNEXPLAINED } else { 0 };
        Verdict { passes: left <= most as u64, unexplained }
    }

    /// Finds why a picture differs.
    pub fn explain(&self, picture: &Pixels) -> Option<Finding> {
        explain(self.original.as_ref(), &self.pixels, self.colors.as_ref(), picture)
    }

    /// Returns the scale on which the reference and this picture are shown, if they are compared by their numbers.
    pub fn scale(&self, picture: &Pixels) -> Option<Scale> {
        match (&self.pixels, picture) {
            (Pixels::Numbers(own), Pixels::Numbers(_)) => Some(Scale::of(&[own])),
            _ => None,
        }
    }
}

/// Returns a rendered picture as it is in its file.
fn in_file(colors: &FloatPicture, has_numbers: bool) -> Pixels {
    match has_numbers {
        true => Pixels::Numbers(colors.clone().in_single_precision()),
        false => Pixels::Bytes(colors.to_picture()),
    }
}
