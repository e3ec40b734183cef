//! The largest difference that passes a check.

use super::Comparison;
use serde::Serialize;

/// At most `pixels` pixels may differ by more than `levels` levels. The default requires equality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tolerance {
    /// The largest channel difference permitted for all pixels.
    pub levels: u8,
    /// The number of pixels that may differ by more.
    pub pixels: u64,
}

impl Tolerance {
    /// Returns true if the difference is within the tolerance.
    pub fn accepts(&self, comparison: &Comparison) -> bool {
        comparison.pixels_differing_by_more_than(self.levels) <= self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Picture;

    #[test]
    fn both_numbers_are_the_last_that_pass() {
        let black = Picture::new(4, 1).unwrap();
        let other = Picture::from_rgb(4, 1, vec![0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 7]);
        let comparison = Comparison::new(&other, &black).unwrap();
        let rows = [(0, 3), (4, 3), (5, 2), (6, 1), (7, 0), (255, 0)];
        for (levels, pixels) in rows {
            assert!(Tolerance { levels, pixels }.accepts(&comparison), "{levels} {pixels}");
            assert!(
                pixels == 0 || !Tolerance { levels, pixels: pixels - 1 }.accepts(&comparison),
                "{levels}"
            );
        }
    }

    #[test]
    fn the_default_accepts_equal_pictures_alone() {
        let black = Picture::new(2, 1).unwrap();
        let other = Picture::from_rgb(2, 1, vec![0, 0, 0, 0, 0, 1]);
        let accepts = |a: &Picture| Tolerance::default().accepts(&Comparison::new(a, &black).unwrap());
        assert!(accepts(&black));
        assert!(!accepts(&other));
    }
}
