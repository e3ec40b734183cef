//! Measures the difference of two pictures of bytes.

use super::edges::EdgeMap;
use super::{
    Line, Rgb, block, colors, largest_channel_difference, mean_flip, percent, same_size, sum_of_squares,
};
use crate::base::patience::{Endless, Patience};
use crate::diagnostic::Diagnostic;
use crate::picture::Picture;
use serde::Serialize;
use std::fmt;

/// The difference of A from B. `Display` prints a block in the form of the statistics.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The first pixel with the largest difference, rows from the top. `None` if the pictures are equal.
    pub largest: Option<LargestDifference>,
    /// The root mean square error over all channels, in levels.
    pub root_mean_square_error: f64,
    /// The mean error of LDR-FLIP, from 0 to 1. `None` if skipped: it takes longer than everything else.
    pub mean_flip: Option<f64>,
    /// The number of differing pixels on an edge of B or next to one.
    pub differing_near_edges: u64,
    /// The number of pixels for each largest channel difference, in levels.
    pixels_by_levels: [u64; 256],
}

/// The pixel with the largest difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct LargestDifference {
    /// Column and row from the top left.
    pub at: [usize; 2],
    /// The largest difference of a channel.
    pub levels: u8,
    /// The pixel's red, green and blue in A.
    pub a: [u8; 3],
    /// The pixel's red, green and blue in B.
    pub b: [u8; 3],
}

impl Comparison {
    /// Compares the picture `a` with the reference `b`. Fails if the sizes differ.
    pub fn new(a: &Picture, b: &Picture) -> Result<Self, Diagnostic> {
        Self::within(a, b, &Endless)
    }

    /// Compares like [`new`](Self::new), but returns soon with an unspecified result after the patience is over.
    pub fn within(a: &Picture, b: &Picture, patience: &dyn Patience) -> Result<Self, Diagnostic> {
        let mean_flip = Some(mean_flip(a, b, patience)?);
        Ok(Self { mean_flip, ..Self::without_flip(a, b, &EdgeMap::new(b))? })
    }

    /// Compares without FLIP. `edges` are the edges of `b`. Fails if the sizes differ.
    pub(super) fn without_flip(a: &Picture, b: &Picture, edges: &EdgeMap) -> Result<Self, Diagnostic> {
        let mut comparison = Self {
            size: same_size([a.size(), b.size()])?,
            largest: None,
            root_mean_square_error: 0.0,
            mean_flip: None,
            differing_near_edges: 0,
            pixels_by_levels: [0; 256],
        };
        let mut squares = 0;
        for (index, (&a, &b)) in colors(a).iter().zip(colors(b)).enumerate().filter(|(_, (a, b))| a != b) {
            squares += sum_of_squares(a, b);
            comparison.add(index, a, b, edges);
        }
        comparison.pixels_by_levels[0] = comparison.pixels() - comparison.pixels_that_differ();
        comparison.root_mean_square_error = (squares as f64 / (3 * comparison.pixels()) as f64).sqrt();
        Ok(comparison)
    }

    /// Counts a differing pixel.
    fn add(&mut self, index: usize, a: Rgb, b: Rgb, edges: &EdgeMap) {
        let at @ [x, y] = [index % self.size[0], index / self.size[0]];
        let levels = largest_channel_difference(a, b);
        self.pixels_by_levels[usize::from(levels)] += 1;
        self.differing_near_edges += u64::from(edges.is_near_edge(x, y));
        if self.largest.is_none_or(|largest| largest.levels < levels) {
            self.largest = Some(LargestDifference { at, levels, a, b });
        }
    }

    /// Returns the number of pixels in each picture.
    pub fn pixels(&self) -> u64 {
        self.size.into_iter().product::<usize>() as u64
    }

    /// Returns the number of differing pixels.
    pub fn pixels_that_differ(&self) -> u64 {
        self.pixels_differing_by_more_than(0)
    }

    /// Returns the number of pixels with a channel that differs by more than `levels`.
    pub fn pixels_differing_by_more_than(&self, levels: u8) -> u64 {
        self.pixels_by_levels.iter().skip(usize::from(levels) + 1).sum()
    }

    /// Returns the peak signal-to-noise ratio in dB. It is infinite if the pictures are equal.
    pub fn psnr(&self) -> f64 {
        20.0 * libm::log10(255.0 / self.root_mean_square_error)
    }

    /// Returns the lines of the block as labels and values.
    pub(super) fn lines(&self) -> Vec<Line> {
        let [width, height] = self.size;
        let counted = |count| format!("{count} ({})", percent(count, self.pixels()));
        let differing = self.pixels_that_differ();
        let flip = self.mean_flip.map(|mean| ("mean FLIP", format!("{mean:.6}")));
        let lines = [
            ("size", format!("{width}x{height}")),
            ("pixels that differ", counted(differing)),
            ("by more than one level", counted(self.pixels_differing_by_more_than(1))),
            ("largest difference", self.largest.map_or("0".into(), |largest| largest.to_string())),
            ("root mean square error", format!("{:.6} levels", self.root_mean_square_error)),
            ("PSNR", format!("{:.2} dB", self.psnr())),
        ];
        let edges = ("differing beside an edge", percent(self.differing_near_edges, differing));
        lines.into_iter().chain(flip).chain([edges]).collect()
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&block(self.lines()))
    }
}

impl fmt::Display for LargestDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { at: [x, y], levels, a, b } = self;
        let color = |[red, green, blue]: &Rgb| format!("({red}, {green}, {blue})");
        write!(f, "{levels} at ({x}, {y}): {} against {}", color(a), color(b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::Pixels;
    use crate::tools::compare::Difference;

    /// Returns a picture of 5 by 4 pixels: grey on the left, white in the last column.
    fn reference() -> Picture {
        let rows = [[100; 12].as_slice(), &[255; 3]].concat().repeat(4);
        Picture::from_rgb(5, 4, rows)
    }

    fn changed(changes: &[(usize, usize, Rgb)]) -> Picture {
        let mut bytes = reference().pixels().to_vec();
        for &(x, y, color) in changes {
            bytes[(y * 5 + x) * 3..][..3].copy_from_slice(&color);
        }
        Picture::from_rgb(5, 4, bytes)
    }

    fn comparison(changes: &[(usize, usize, Rgb)]) -> Comparison {
        Comparison::new(&changed(changes), &reference()).unwrap()
    }

    #[test]
    fn pixels_are_counted_by_their_largest_channel() {
        let found = comparison(&[(0, 0, [101, 99, 100]), (1, 0, [100, 98, 101]), (2, 0, [90, 100, 110])]);
        let counts = [0, 1, 2, 9, 10, 255].map(|levels| found.pixels_differing_by_more_than(levels));
        assert_eq!(counts, [3, 2, 1, 1, 0, 0]);
        assert_eq!((found.pixels(), found.pixels_that_differ()), (20, 3));
        assert_eq!(found.pixels_by_levels.iter().sum::<u64>(), 20);
    }

    #[test]
    fn of_equally_large_differences_the_first_from_the_top_left_is_named() {
        let found = comparison(&[(3, 1, [100, 130, 100]), (0, 2, [70, 100, 100]), (1, 0, [100, 100, 129])]);
        let expected = LargestDifference { at: [3, 1], levels: 30, a: [100, 130, 100], b: [100; 3] };
        assert_eq!(found.largest, Some(expected));
    }

    #[test]
    fn the_error_is_over_all_channels() {
        let found = comparison(&[(1, 1, [103, 96, 100])]);
        assert_eq!(found.root_mean_square_error, (25.0_f64 / 60.0).sqrt());
        let mean_square = found.root_mean_square_error.powi(2);
        assert!((found.psnr() - 10.0 * (255.0_f64.powi(2) / mean_square).log10()).abs() < 1e-9);
    }

    #[test]
    fn many_pictures_are_compared_as_each_of_them_is() {
        let pictures =
            [changed(&[]), changed(&[(0, 0, [7; 3])]), changed(&[(4, 3, [0; 3]), (1, 1, [99; 3])])];
        let each = pictures.each_ref().map(|picture| {
            let alone = Comparison::new(picture, &reference()).unwrap();
            Comparison { mean_flip: None, ..alone }
        });
        let own = Pixels::Bytes(reference());
        let found = Difference::of_each(&pictures.map(Pixels::Bytes), &own).unwrap();
        for (found, alone) in found.iter().zip(each) {
            assert!(matches!(found, Difference::Levels(found) if **found == alone));
        }
        let other = [reference(), Picture::new(7, 3).unwrap()].map(Pixels::Bytes);
        assert!(Difference::of_each(&other, &own).is_err());
    }

    #[test]
    fn edges_are_those_of_the_reference() {
        // The edge is between columns 3 and 4; columns 2 to 4 are within one pixel of it.
        let found = comparison(&[(0, 0, [0; 3]), (1, 0, [99; 3]), (2, 0, [99; 3]), (4, 3, [0; 3])]);
        assert_eq!(found.differing_near_edges, 2);
    }
}
