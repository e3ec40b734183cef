//! LDR-FLIP: measures how visible the difference of two pictures is to an observer who flips between them.
//!
//! Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild, "FLIP: A Difference Evaluator for Alternating
//! Images", HPG 2020. Uses the constants and the border handling (the outermost pixels repeat) of the reference
//! implementation. The reference computes in f32, this module in f64.

mod color;
mod filter;
#[cfg(test)]
mod tests;
mod tile;

use super::{colors, same_size};
use crate::base::patience::Patience;
use crate::diagnostic::Diagnostic;
use crate::picture::Picture;
use color::ColorSpace;
use filter::{FeatureFilters, SpatialFilters};
use rayon::prelude::*;
use std::f64::consts::PI;
use tile::{FilteredTile, PictureTile, tiles};

/// The resolution of a display 0.7 m wide with 3840 pixels per row, seen from 0.7 m: 67.02.
const PIXELS_PER_DEGREE: f64 = 3840.0 * PI / 180.0;

/// The exponent of colour differences.
const COLOR_EXPONENT: f64 = 0.7;
/// Colour differences below this fraction of the largest one fill the lower part of the error's range.
const LOWER_COLOR_PART: f64 = 0.4;
/// The part of the error's range used for small colour differences.
const LOWER_ERROR_PART: f64 = 0.95;
/// The exponent of feature differences is a square root.
const FEATURE_SCALE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// The filters and constants of LDR-FLIP at the distance of the reference implementation.
struct Flip {
    colors: ColorSpace,
    spatial: SpatialFilters,
    features: FeatureFilters,
    /// The difference of the two most distant colours, raised to [`COLOR_EXPONENT`].
    largest_color_difference: f64,
}

/// Returns the mean error of the picture `a` against the reference `b`, from 0 to 1, or soon an unspecified result after
/// the patience is over. Fails if the sizes differ.
///
/// Tiles are computed in parallel and summed in a fixed order, so the result does not depend on the number of threads.
pub fn mean_flip(a: &Picture, b: &Picture, patience: &dyn Patience) -> Result<f64, Diagnostic> {
    let [width, height] = same_size([a.size(), b.size()])?;
    let colors = ColorSpace::default();
    let flip = Flip {
        spatial: SpatialFilters::new(),
        features: FeatureFilters::new(),
        largest_color_difference: libm::pow(colors.largest_difference(), COLOR_EXPONENT),
        colors,
    };
    let tiles: Vec<PictureTile> = tiles(width, height).collect();
    let sum = |tile: &PictureTile| if patience.is_over() { 0.0 } else { flip.sum_of_errors(a, b, tile) };
    let sums: Vec<f64> = tiles.par_iter().map(sum).collect();
    Ok(sums.iter().sum::<f64>() / (width * height) as f64)
}

impl Flip {
    /// Returns the sum of the errors in a tile. A pixel's error depends only on pixels within the filters' radius. If
    /// they are equal, it is exactly 0.
    fn sum_of_errors(&self, a: &Picture, b: &Picture, tile: &PictureTile) -> f64 {
        let radius = self.spatial.radius().max(self.features.radius());
        let windows = [a, b].map(|picture| tile.window(picture.size()[0], colors(picture), radius));
        if windows[0] == windows[1] {
            return 0.0;
        }
        let [a, b] = windows.map(|window| self.filtered(&window, tile));
        (0..tile.width * tile.height).map(|pixel| self.error(&a, &b, pixel)).sum()
    }

    fn error(&self, a: &FilteredTile, b: &FilteredTile, pixel: usize) -> f64 {
        let [one, other] = [a, b].map(|tile| tile.color(pixel));
        if one == other {
            return 0.0;
        }
        let [one, other] = [one, other].map(|color| self.colors.to_perceived(color));
        let color = self.redistributed(libm::pow(color::distance(one, other), COLOR_EXPONENT));
        let [one, other] = [a, b].map(|tile| tile.features(pixel));
        let feature = (one - other).abs().max_element();
        libm::pow(color, 1.0 - (FEATURE_SCALE * feature).sqrt())
    }

    /// Maps colour differences to 0..=1, with most of the range for small ones.
    fn redistributed(&self, difference: f64) -> f64 {
        let largest = self.largest_color_difference;
        let split = LOWER_COLOR_PART * largest;
        match difference < split {
            true => difference * (LOWER_ERROR_PART / split),
            false => LOWER_ERROR_PART + (difference - split) / (largest - split) * (1.0 - LOWER_ERROR_PART),
        }
    }
}
