//! Formats numbers with the number of digits that a reader compares.

use glam::DVec3;
use std::fmt;

/// A number with nine significant digits, without trailing zeros.
pub struct Short(pub f64);

/// Three numbers in parentheses.
pub struct Triple(pub DVec3);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const PLAIN: std::ops::Range<f64> = 1e-4..1e9;
        let rounded: f64 = format!("{:.8e}", self.0).parse().unwrap_or(self.0);
        // Adding zero turns a negative zero into a positive one.
        let rounded = rounded + 0.0;
        if rounded == 0.0 || PLAIN.contains(&rounded.abs()) || !rounded.is_finite() {
            write!(f, "{rounded}")
        } else {
            write!(f, "{rounded:e}")
        }
    }
}

impl fmt::Display for Triple {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0.to_array().map(Short);
        write!(f, "({x}, {y}, {z})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nine_digits_are_shown_and_none_that_says_nothing() {
        for (number, text) in [
            (1.0 / 3.0, "0.333333333"),
            (0.1 + 0.2, "0.3"),
            (-0.0, "0"),
            (123456789.4, "123456789"),
            (-2.5e-7, "-2.5e-7"),
            (1e100, "1e100"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(Short(number).to_string(), text);
        }
    }
}
