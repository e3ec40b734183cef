//! Adaptive sampling: estimates the number of samples that each pixel needs from its contents.
//!
//! First, rays are cast through the corners of all pixels; adjacent pixels share them. An edge that crosses a pixel has
//! corners on both sides. With n stratified samples the squared error of a pixel is about c^2 n^-3/2 / 8 if an edge of
//! contrast c crosses it, and v / n if it is full of details smaller than its strata, with a variance of v (Mitchell,
//! "Consequences of stratified sampling in graphics", SIGGRAPH 1996). Samples are spent where one more reduces the
//! squared error most, until this reduction is equal in all pixels.
//!
//! Probes find details between corners; see [`allotment`](super::allotment). Corners and probes do not contribute to
//! the picture and do not depend on its random numbers. So the estimate is unbiased: the picture has the same expected
//! value as with any fixed number of samples (Kirk and Arvo, "Unbiased sampling techniques for image synthesis",
//! SIGGRAPH 1991).

use crate::picture::Color;
use glam::Vec3A;
use serde::Serialize;

/// The settings of adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// The largest number of samples per pixel, from [`BASE`](Self::BASE) to [`LIMIT`](Self::LIMIT).
    pub most: u32,
    /// The target error of the picture, in levels.
    pub error: f64,
}

/// The estimated contents of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contents {
    /// The squared contrast of its edges.
    pub edge: f32,
    /// The variance of details no larger than the pixel.
    pub variance: f32,
}

/// Corners clamp brighter colours to this brightness in pictures of bytes.
pub const BRIGHTEST: f32 = 2.0;

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

/// The contrast of a usual edge in levels, and the part of the pixels that such edges cross. They only serve to guess
/// the number of rays before any is cast.
const USUAL_EDGE: f64 = 160.0;
const CROSSED: f64 = 1.0 / 3.0;

/// [`Contents::needs`] grow with the inverse of the least reduction to these powers.
pub(super) const EDGE_POWER: f32 = 0.4;
pub(super) const DETAIL_POWER: f32 = 0.5;

impl Adaptive {
    /// The smallest permitted value of `most`.
    pub const BASE: u32 = 4;

    /// The largest permitted value of `most`.
    pub const LIMIT: u32 = 1024;

    /// Returns the approximate average number of samples per pixel.
    pub fn usual(self) -> u32 {
        let ratio = USUAL_EDGE / self.error;
        let of_edge = libm::pow(ratio * ratio / 8.0, 2.0 / 3.0);
        (CROSSED * of_edge).ceil().min(f64::from(self.most)) as u32
    }

    /// Returns the target squared error, where white is 1.
    pub(super) fn square(self) -> f64 {
        (self.error / LEVELS) * (self.error / LEVELS)
    }
}

impl Contents {
    /// Returns the expected squared errors of edges and of details with this number of samples.
    pub(super) fn errors(self, count: f32) -> [f64; 2] {
        [self.edge / (8.0 * count * count.sqrt()), self.variance / count].map(f64::from)
    }

    /// Returns the numbers of samples from which on one more reduces the squared error of edges, or of details, by less
    /// than 1: where the derivative is -1.
    pub(super) fn needs(self) -> [f32; 2] {
        [libm::powf(3.0 / 16.0 * self.edge, EDGE_POWER), self.variance.sqrt()]
    }
}

/// Converts a colour to single precision, which is enough to decide.
pub fn finite(color: Color) -> Vec3A {
    color.clamp(Color::ZERO, Color::splat(1e6)).as_vec3a()
}

/// Returns the squared distance of a colour from the range of its pixel's corners. In pictures of bytes, colours
/// brighter than white count as white.
pub fn beyond(color: Vec3A, [a, b, c, d]: [Vec3A; 4], has_floats: bool) -> f32 {
    let between = color.max(a.min(b).min(c.min(d))).min(a.max(b).max(c.max(d)));
    let is_white = !has_floats && color.min(between).min_element() >= 1.0;
    if is_white { 0.0 } else { mean_square(color - between) }
}

/// Returns the squares of two parts of the colours at four corners in a line: of the step from the second to the third
/// that is no gradient, and of their back-and-forth variation. The first and the last may be outside the picture, where
/// the gradient is assumed to continue.
#[inline(always)]
pub fn edge_and_variation([first, second, third, fourth]: [Option<Vec3A>; 4]) -> [f32; 2] {
    let (Some(second), Some(third)) = (second, third) else { return [0.0; 2] };
    let first = first.unwrap_or(2.0 * second - third);
    let fourth = fourth.unwrap_or(2.0 * third - second);
    let [a, b, c] = [second - first, third - second, fourth - third];
    let gradient = a.min(b).min(c).max(Vec3A::ZERO) + a.max(b).max(c).min(Vec3A::ZERO);
    let variation = a.abs() + b.abs() + c.abs() - (fourth - first).abs();
    [b - gradient, variation].map(mean_square)
}

fn mean_square(v: Vec3A) -> f32 {
    v.length_squared() / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(level: f64) -> Option<Vec3A> {
        Some(finite(Color::splat(level / LEVELS)))
    }

    /// Returns the edge and the variation along corners of these levels, in levels.
    fn found(line: [Option<f64>; 4]) -> [f64; 2] {
        edge_and_variation(line.map(|level| corner(level?)))
            .map(|square| (f64::from(square).sqrt() * LEVELS * 1e3).round() / 1e3)
    }

    #[test]
    fn edges_are_steps_without_the_gradient_around_them() {
        assert_eq!(found([10.0, 10.0, 90.0, 90.0].map(Some)), [80.0, 0.0]);
        assert_eq!(found([10.0, 10.0, 10.0, 90.0].map(Some)), [0.0, 0.0]);
        assert_eq!(found([50.0, 53.0, 56.0, 59.0].map(Some)), [0.0, 0.0]);
        assert_eq!(found([50.0, 53.0, 116.0, 119.0].map(Some)), [60.0, 0.0]);
        assert_eq!(found([50.0, 90.0, 50.0, 90.0].map(Some)), [40.0, 80.0]);
        // At the border of the picture the gradient is assumed to continue.
        assert_eq!(found([None, Some(1.0), Some(3.0), Some(5.0)]), [0.0, 0.0]);
        assert_eq!(found([Some(1.0), Some(1.0), None, None]), [0.0, 0.0]);
    }

    #[test]
    fn the_variation_of_colours_by_chance_is_eight_variances() {
        let mut rng = crate::sampling::drand48::Drand48::seeded(3);
        let mut level = || if rand::RngExt::random::<f64>(&mut rng) < 0.5 { 0.0 } else { 100.0 };
        let sum: f64 = (0..20_000).map(|_| found([(); 4].map(|()| Some(level())))[1].powi(2)).sum();
        assert!((sum / 20_000.0 / (8.0 * 2500.0) - 1.0).abs() < 0.05, "{}", sum / 20_000.0);
    }

    #[test]
    fn a_sample_more_than_needed_saves_less_than_the_least() {
        for least in [1e-3f32, 1e-5, 1e-7] {
            for (edge, variance, power) in [(0.3, 0.0, EDGE_POWER), (0.0, 0.2, DETAIL_POWER)] {
                let contents = Contents { edge, variance };
                let need = contents.needs().iter().sum::<f32>() * least.recip().powf(power);
                let error = |count: f32| contents.errors(count).into_iter().sum::<f64>();
                let saved = (error(0.99 * need) - error(1.01 * need)) / (0.02 * f64::from(need));
                assert!((saved / f64::from(least) - 1.0).abs() < 0.01, "{contents:?} {least} {need} {saved}");
            }
        }
    }

    #[test]
    fn smaller_errors_take_more_samples() {
        let usual = [16.0, 4.0, 1.0, 0.0].map(|error| Adaptive { most: 512, error }.usual());
        assert!(usual[0] >= 1 && usual.is_sorted() && usual[3] == 512, "{usual:?}");
    }

    #[test]
    fn only_what_differs_from_corners_is_beyond_them() {
        let corners = [Vec3A::ONE, 0.5 * Vec3A::ONE, 3.0 * Vec3A::ONE, Vec3A::ONE];
        let square = |level: f32, has_floats| beyond(Vec3A::splat(level), corners, has_floats);
        assert_eq!([0.75, 2.0, 5.0].map(|level| square(level, false)), [0.0; 3]);
        assert_eq!([0.25, 2.0, 5.0].map(|level| square(level, true)), [0.0625, 0.0, 4.0]);
    }
}
