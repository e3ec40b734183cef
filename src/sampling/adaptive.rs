//! Adaptive sampling: how many samples a pixel needs.
//!
//! Rays through the corners of all pixels are cast first, once for the four pixels at each. They say what is in a pixel: an
//! edge that crosses it has corners on both sides. From them, and from what is known without any ray, follows the number
//! of samples of a pixel, and these alone are its colour. So that has the expected value that it would have with any
//! number of samples: the rays that decide do not count, and those that count do not decide (Kirk and Arvo, "Unbiased
//! sampling techniques for image synthesis", SIGGRAPH 1991). They are not even random.
//!
//! With n samples in strata the squared error of a pixel is about c^2 n^-3/2 / 8 if an edge of contrast c crosses it,
//! g^2 n^-3 / 12 if its colours change steadily by g, and v / n if it is full of things that are smaller than its strata,
//! with a variance of v (Mitchell, "Consequences of stratified sampling in graphics", SIGGRAPH 1996). Samples are spent
//! where one more lessens the squared error by most, down to the same amount in all pixels.

use crate::scene::Color;
use glam::Vec3A;
use serde::Serialize;

/// How far adaptive sampling goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// The largest number of samples of a pixel, from [`BASE`](Self::BASE) to [`LIMIT`](Self::LIMIT).
    pub most: u32,
    /// The error of a pixel's colour that is aimed at, in levels.
    pub error: f64,
}

/// What a ray through a corner of pixels sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Its colour. No more than single precision is needed to decide.
    pub color: Vec3A,
    /// The variance that its surface may have without showing it, such as that of highlights.
    pub hidden: f32,
    /// The material of the surface, if there is any.
    pub material: Option<u32>,
    /// How far ahead the surface is.
    pub depth: f32,
}

/// The colours of four corners in a line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Line {
    /// The square of the step from the second to the third that is not a part of a steady change.
    edge: f32,
    /// The square of the step that is.
    steady: f32,
    /// The square of how far the colours go back and forth.
    back: f32,
}

/// What the corners of a pixel and of those around it tell of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contents {
    /// The squared contrast of edges in it.
    edge: f32,
    /// The square of a steady change.
    steady: f32,
    /// The variance of things that are no larger than a pixel.
    variance: f32,
}

/// Edges of this contrast, in levels, have the error that is asked for.
const EDGE: f64 = 160.0;

/// Things that are no larger than a pixel have 1.4 times the error that is asked for if this is their standard
/// deviation, in levels. Were samples spent as for edges, scenes that are full of them would have much more.
const SMALL_THINGS: f64 = 36.0;

/// The part of the squared contrast of edges that pixels around get: between two edges may be a gap that no corner sees.
const BESIDE_EDGES: f32 = 1.0 / 1024.0;

/// Colours that are brighter are as bright as this.
const BRIGHTEST: f64 = 2.0;

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

impl Adaptive {
    /// The number of samples that each pixel may have at least.
    pub const BASE: u32 = 4;

    /// The number of samples above which no pixel gets any.
    pub const LIMIT: u32 = 1024;

    /// About the number of samples of a pixel on average, where edges cross some of them.
    pub fn usual(self) -> u32 {
        (self.of_usual_edge() / 3.0).ceil().min(f64::from(self.most)) as u32
    }

    /// The number of samples of a pixel with an edge of the usual contrast.
    fn of_usual_edge(self) -> f64 {
        let ce = EDGE / self.error;
        libm::pow(ce * ce / 8.0, 2.0 / 3.0)
    }

    /// How many samples pixels need, by their contents.
    pub fn counts(self) -> impl Fn(Contents) -> u32 {
        let square = self.error * self.error / (LEVELS * LEVELS);
        // The squared error that one more sample saves.
        let least = 1.5 * square / self.of_usual_edge();
        let [edge_unit, steady_unit] = [1.5 / 8.0 / least, 0.25 / least].map(|unit| unit as f32);
        let of_variance = (SMALL_THINGS / LEVELS / (2.0 * square)) as f32;
        move |Contents { edge, steady, variance }| {
            let root = |x: f32| x.sqrt().sqrt();
            // About the power of 2/5.
            let of_edge = root(edge_unit * edge) * root(edge_unit * edge).sqrt();
            let of_steady = root(steady_unit * steady);
            // NaN for what is not finite or 0 / 0, which more samples do not make better.
            let count = of_edge.max(of_steady).max(variance.sqrt() * of_variance).ceil();
            (count as u32).clamp(1, self.most)
        }
    }
}

impl Corner {
    /// The one that follows two, if colours change steadily.
    fn beyond(self, before: Self) -> Self {
        Self { color: 2.0 * self.color - before.color, ..self }
    }
}

/// The colour of a corner.
pub fn color_of_corner(color: Color) -> Vec3A {
    color.clamp(Color::ZERO, Color::splat(BRIGHTEST)).as_vec3a()
}

impl Line {
    /// Of four corners, the first and the last of which may be outside the picture.
    #[inline(always)]
    pub fn new(first: Option<Corner>, second: Corner, third: Corner, fourth: Option<Corner>) -> Self {
        let first = first.unwrap_or(second.beyond(third)).color;
        let fourth = fourth.unwrap_or(third.beyond(second)).color;
        let [a, b, c] = [second.color - first, third.color - second.color, fourth - third.color];
        let steady = a.min(b).min(c).max(Vec3A::ZERO) + a.max(b).max(c).min(Vec3A::ZERO);
        let back = a.abs() + b.abs() + c.abs() - (fourth - first).abs();
        let mean_square = |v: Vec3A| v.length_squared() / 3.0;
        Self { edge: mean_square(b - steady), steady: mean_square(steady), back: mean_square(back) }
    }
}

impl Contents {
    /// By the lines along the rows of corners around a pixel, from the one before it to the one after it, and those along the
    /// columns.
    #[inline(always)]
    pub fn new(rows: [Line; 4], columns: [Line; 4]) -> Self {
        let sides = [rows[1], rows[2], columns[1], columns[2]];
        let back: f32 = rows.iter().chain(&columns).map(|line| line.back).sum();
        Self {
            // An edge that crosses the pixel crosses two of its sides.
            edge: 0.5 * sides.iter().map(|line| line.edge).sum::<f32>(),
            steady: 0.5 * sides.iter().map(|line| line.steady).sum::<f32>(),
            // Where colours are one of two by chance, the mean square of each of eight is 8 variances.
            variance: back / 64.0,
        }
    }

    /// With at least this variance, and with a part of the squared contrast of edges around it.
    pub fn among(self, variance: f32, edges: f32) -> Self {
        let edge = self.edge.max(BESIDE_EDGES * edges);
        Self { edge, variance: self.variance.max(variance), ..self }
    }

    /// The squared contrast of edges, and the variance of things that are no larger than a pixel.
    pub fn edge_and_variance(&self) -> [f32; 2] {
        [self.edge, self.variance]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(level: f64) -> Corner {
        let color = color_of_corner(Color::splat(level / LEVELS));
        Corner { color, hidden: 0.0, material: None, depth: 1.0 }
    }

    /// The contents of the middle pixel of three by three, whose colours in levels depend on the place.
    fn contents(level: impl Fn(usize, usize) -> f64) -> Contents {
        let line = |at: &dyn Fn(usize) -> f64| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| corner(at(k)));
            Line::new(Some(a), b, c, Some(d))
        };
        let rows = [0, 1, 2, 3].map(|y| line(&|x| level(x, y)));
        let columns = [0, 1, 2, 3].map(|x| line(&|y| level(x, y)));
        Contents::new(rows, columns)
    }

    fn in_levels(Contents { edge, steady, variance }: Contents) -> [f64; 3] {
        [edge, steady, variance].map(|square| f64::from(square).sqrt() * LEVELS)
    }

    fn assert_near(found: [f64; 3], expected: [f64; 3]) {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?} {expected:?}");
    }

    #[test]
    fn an_edge_is_in_the_pixels_that_it_crosses() {
        let side = |is_beyond: bool| if is_beyond { 90.0 } else { 10.0 };
        assert_near(in_levels(contents(|x, _| side(x > 1))), [80.0, 0.0, 0.0]);
        // It cuts a corner off.
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
        // At the border of the picture it is assumed to go on.
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
        let count = |most, error, level: f64| {
            let square = (level / LEVELS).powi(2) as f32;
            let count = Adaptive { most, error }.counts();
            let all = [
                Contents { edge: square, ..Contents::default() },
                Contents { steady: square, ..Contents::default() },
                Contents { variance: square, ..Contents::default() },
            ];
            all.map(count)
        };
        assert_eq!(count(1024, 1.0, 0.0), [1; 3]);
        assert_eq!(count(1024, 0.0, 1.0), [1024; 3]);
        assert_eq!(count(1024, 0.0, 0.0), [1; 3]);
        assert_eq!(count(64, 1e-9, 1.0), [64; 3]);
        assert_eq!(count(64, 1.0, f64::NAN), [1; 3]);
        let counts = [(8.0, 60.0), (4.0, 60.0), (2.0, 60.0), (2.0, 120.0)].map(|(e, c)| count(1024, e, c));
        assert!(counts.windows(2).all(|pair| (0..3).all(|k| pair[0][k] < pair[1][k])), "{counts:?}");
        let usual = [16.0, 4.0, 1.0, 0.0].map(|error| Adaptive { most: 512, error }.usual());
        assert!(usual[0] >= 1 && usual.is_sorted() && usual[3] == 512, "{usual:?}");
    }
}
