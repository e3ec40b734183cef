//! Adaptive sampling: estimates the number of samples that each pixel needs from its contents.
//!
//! First, rays are cast through the corners of all pixels; adjacent pixels share them. They show the contents of a
//! pixel: an edge that crosses it has corners on both sides. With n stratified samples the squared error of a pixel is
//! about c^2 n^-3/2 / 8 if an edge of contrast c crosses it, g^2 n^-3 / 12 if its colours have a gradient of g, and
//! v / n if it is full of details smaller than its strata, with a variance of v (Mitchell, "Consequences of stratified
//! sampling in graphics", SIGGRAPH 1996). Samples are spent where one more reduces the squared error most, until this
//! reduction is equal in all pixels.
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

/// Squared colour differences along four corners in a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// The square of the part of the step from the second to the third that is not a gradient.
    edge: f32,
    /// The square of the part that is a gradient.
    steady: f32,
    /// The square of the colours' back-and-forth variation.
    back: f32,
}

/// The estimated contents of a pixel before it is probed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contents {
    /// The squared contrast of its edges.
    edge: f32,
    /// The square of its gradient.
    steady: f32,
    /// The variance of details no larger than a pixel.
    variance: f32,
    /// The variance of details known to be in it.
    known: f32,
}

/// Edges of this contrast, in levels, have the target error.
const EDGE: f64 = 160.0;

/// Details no larger than a pixel have 1.4 times the target error if this is their standard deviation, in levels. If
/// samples were spent as for edges, scenes full of such details would have a much larger error.
const SMALL_THINGS: f64 = 36.0;

/// Corners clamp brighter colours to this brightness in pictures of bytes.
pub const BRIGHTEST: f32 = 2.0;

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

impl Adaptive {
    /// The smallest permitted value of `most`.
    pub const BASE: u32 = 4;

    /// The largest permitted value of `most`.
    pub const LIMIT: u32 = 1024;

    /// Returns the approximate average number of samples per pixel if edges cross some pixels.
    pub fn usual(self) -> u32 {
        (self.of_usual_edge() / 3.0).ceil().min(f64::from(self.most)) as u32
    }

    /// Returns the number of samples for a pixel with an edge of the usual contrast.
    fn of_usual_edge(self) -> f64 {
        let ce = EDGE / self.error;
        libm::pow(ce * ce / 8.0, 2.0 / 3.0)
    }

    /// Returns the target squared error, where white is 1.
    pub(super) fn square(self) -> f64 {
        (self.error / LEVELS) * (self.error / LEVELS)
    }

    /// Returns a function that maps contents to the numbers of samples needed for edges, the gradient, known details
    /// and other details.
    pub(super) fn needs(self) -> impl Fn(Contents) -> [f32; 4] {
        // The squared error that one more sample saves.
        let least = 1.5 * self.square() / self.of_usual_edge();
        let [edge_unit, steady_unit] = [1.5 / 8.0 / least, 0.25 / least].map(|unit| unit as f32);
        let of_variance = (SMALL_THINGS / LEVELS / (2.0 * self.square())) as f32;
        move |Contents { edge, steady, variance, known }| {
            let root = |x: f32| x.sqrt().sqrt();
            // Approximates the power of 2/5.
            let of_edge = root(edge_unit * edge) * root(edge_unit * edge).sqrt();
            [of_edge, root(steady_unit * steady), known.sqrt() * of_variance, variance.sqrt() * of_variance]
        }
    }
}

/// Converts a colour to single precision, which is enough to decide.
pub fn finite(color: Color) -> Vec3A {
    color.clamp(Color::ZERO, Color::splat(1e6)).as_vec3a()
}

/// Returns the squared distance of a colour from the range of its pixel's corners. In pictures of bytes, colours
/// brighter than white count as white.
pub fn beyond(color: Vec3A, [a, b, c, d]: [Vec3A; 4], has_floats: bool) -> f32 {
    let between = color.max(a.min(b).min(c).min(d)).min(a.max(b).max(c).max(d));
    let is_white = !has_floats && color.min(between).min_element() >= 1.0;
    if is_white { 0.0 } else { mean_square(color - between) }
}

fn mean_square(v: Vec3A) -> f32 {
    v.length_squared() / 3.0
}

impl Line {
    /// Computes the differences of four corners. The first and the last may be outside the picture, where the gradient
    /// is assumed to continue.
    #[inline(always)]
    pub fn new(first: Option<Vec3A>, second: Vec3A, third: Vec3A, fourth: Option<Vec3A>) -> Self {
        let first = first.unwrap_or(2.0 * second - third);
        let fourth = fourth.unwrap_or(2.0 * third - second);
        let [a, b, c] = [second - first, third - second, fourth - third];
        let steady = a.min(b).min(c).max(Vec3A::ZERO) + a.max(b).max(c).min(Vec3A::ZERO);
        let back = a.abs() + b.abs() + c.abs() - (fourth - first).abs();
        Self { edge: mean_square(b - steady), steady: mean_square(steady), back: mean_square(back) }
    }
}

impl Contents {
    /// Computes the contents from the lines along the rows of corners around a pixel, from the row before it to the row
    /// after it, and from the lines along the columns.
    #[inline(always)]
    pub fn new(rows: [Line; 4], columns: [Line; 4]) -> Self {
        let sides = [rows[1], rows[2], columns[1], columns[2]];
        let back: f32 = rows.iter().chain(&columns).map(|line| line.back).sum();
        Self {
            // An edge that crosses the pixel crosses two of its sides.
            edge: 0.5 * sides.iter().map(|line| line.edge).sum::<f32>(),
            steady: 0.5 * sides.iter().map(|line| line.steady).sum::<f32>(),
            // If colours are a random choice of two, the mean square of each of the eight lines is 8 variances.
            variance: back / 64.0,
            known: 0.0,
        }
    }

    /// Sets the variance of the details known to be in the pixel.
    pub fn with_known(self, known: f32) -> Self {
        Self { known, ..self }
    }

    /// Raises the variance to at least this value.
    pub(super) fn with_variance(self, variance: f32) -> Self {
        Self { variance: self.variance.max(variance), ..self }
    }

    /// Returns the expected squared error with this number of samples.
    pub(super) fn error(&self, count: f32) -> f32 {
        let part = count.recip();
        let Self { edge, steady, variance, known } = *self;
        part * (part.sqrt() * edge / 8.0 + part * part * steady / 12.0 + variance.max(known))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(level: f64) -> Vec3A {
        finite(Color::splat(level / LEVELS))
    }

    /// Returns the contents of the middle pixel of three by three. `level` gives the colour at each corner, in levels.
    fn contents(level: impl Fn(usize, usize) -> f64) -> Contents {
        let line = |at: &dyn Fn(usize) -> f64| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| corner(at(k)));
            Line::new(Some(a), b, c, Some(d))
        };
        let rows = [0, 1, 2, 3].map(|y| line(&|x| level(x, y)));
        let columns = [0, 1, 2, 3].map(|x| line(&|y| level(x, y)));
        Contents::new(rows, columns)
    }

    fn in_levels(Contents { edge, steady, variance, .. }: Contents) -> [f64; 3] {
        [edge, steady, variance].map(|square| f64::from(square).sqrt() * LEVELS)
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?} {expected:?}");
    }

    #[test]
    fn an_edge_is_in_the_pixels_that_it_crosses() {
        let side = |is_beyond: bool| if is_beyond { 90.0 } else { 10.0 };
        assert_near(in_levels(contents(|x, _| side(x > 1))), [80.0, 0.0, 0.0]);
        // The edge cuts a corner off.
        assert_near(in_levels(contents(|x, y| side(x + y > 3))), [80.0, 0.0, 0.0]);
        assert_near(in_levels(contents(|x, _| side(x > 2))), [0.0; 3]);
        assert_near(in_levels(contents(|x, y| side(x + y > 4))), [0.0; 3]);
    }

    #[test]
    fn a_steady_change_is_no_edge() {
        let slope = contents(|x, y| 50.0 + 3.0 * x as f64 - 4.0 * y as f64);
        assert_near(in_levels(slope), [0.0, 5.0, 0.0]);
        let with_edge = contents(|x, _| 50.0 + 3.0 * x as f64 + if x > 1 { 60.0 } else { 0.0 });
        assert_near(in_levels(with_edge), [60.0, 3.0, 0.0]);
        // At the border of the picture the gradient is assumed to continue.
        let [a, b, c] = [1.0, 3.0, 5.0].map(corner);
        let line = Line::new(None, a, b, Some(c));
        assert!(line.edge < 1e-9 && (f64::from(line.steady).sqrt() * LEVELS - 2.0).abs() < 1e-4);
    }

    #[test]
    fn colours_by_chance_have_their_variance() {
        let mut rng = crate::sampling::drand48::Drand48::seeded(3);
        let mut sum = 0.0;
        for _ in 0..4000 {
            let levels: [[f64; 4]; 4] = std::array::from_fn(|_| {
                std::array::from_fn(|_| if rand::RngExt::random::<f64>(&mut rng) < 0.5 { 0.0 } else { 100.0 })
            });
            sum += in_levels(contents(|x, y| levels[y][x]))[2].powi(2);
        }
        assert!((sum / 4000.0 / 2500.0 - 1.0).abs() < 0.05, "{}", sum / 4000.0);
    }

    #[test]
    fn less_error_and_more_contrast_take_more_samples() {
        let needs = |error, level: f64| {
            let square = (level / LEVELS).powi(2) as f32;
            let needs = Adaptive { most: 1024, error }.needs();
            [
                needs(Contents { edge: square, ..Contents::default() })[0],
                needs(Contents { steady: square, ..Contents::default() })[1],
                needs(Contents { known: square, ..Contents::default() })[2],
                needs(Contents { variance: square, ..Contents::default() })[3],
            ]
        };
        assert_eq!(needs(1.0, 0.0), [0.0; 4]);
        let counts = [(8.0, 60.0), (4.0, 60.0), (2.0, 60.0), (2.0, 120.0)].map(|(e, c)| needs(e, c));
        assert!(counts.windows(2).all(|pair| (0..4).all(|k| pair[0][k] < pair[1][k])), "{counts:?}");
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
