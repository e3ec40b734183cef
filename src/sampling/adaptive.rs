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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Corner {
    /// Its colour. No more than single precision is needed to decide.
    color: [f32; 3],
    /// The variance that its surface may have without showing it, such as that of highlights.
    hidden: f32,
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

/// What is known of a pixel: the squared contrast of edges in it, the square of a steady change, and a variance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contents {
    edge: f32,
    steady: f32,
    variance: f32,
}

/// The contrast of edges and the standard deviation of small things whose pixels get the error that is asked for.
fn env(name: &str, default: f64) -> f64 { std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default) }

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

impl Adaptive {
    /// The number of samples that each pixel may have at least.
    pub const BASE: u32 = 4;

    /// The number of samples above which no pixel gets any.
    pub const LIMIT: u32 = 1024;

    /// How many samples pixels need, by their contents.
    pub fn counts(self) -> impl Fn(Contents) -> u32 {
        let square = self.error * self.error / (LEVELS * LEVELS);
        let (ce, cv, cap) = (env("CE", 160.0) / LEVELS, env("CV", 64.0) / LEVELS, env("VE", 1.4));
        // The squared error that one more sample saves.
        let least = 1.5 * square / libm::pow(ce * ce / (8.0 * square), 2.0 / 3.0);
        let of_variance = cv / (cap * cap * square);
        move |Contents { edge, steady, variance }| {
            let [edge, steady, variance] = [edge, steady, variance].map(f64::from);
            let of_edge = libm::pow(1.5 / 8.0 * edge / least, 0.4);
            let of_steady = (0.25 * steady / least).sqrt().sqrt();
            // NaN for what is not finite or 0 / 0, which more samples do not make better.
            let count = of_edge.max(of_steady).max(variance.sqrt() * of_variance).ceil();
            (count as u32).clamp(1, self.most)
        }
    }
}

impl Corner {
    /// Of this colour, with the variance that it may hide.
    pub fn new(color: Color, hidden: f64) -> Self {
        let color = color.to_array().map(|channel| channel.clamp(0.0, 2.0) as f32);
        Self { color, hidden: hidden as f32 }
    }

    /// The one that follows two, if colours change steadily.
    fn beyond(self, before: Self) -> Self {
        let color = [0, 1, 2].map(|k| 2.0 * self.color[k] - before.color[k]);
        Self { color, ..self }
    }
}

impl Line {
    /// Of four corners, the first and the last of which may be outside the picture.
    #[inline(always)]
    pub fn new(first: Option<Corner>, second: Corner, third: Corner, fourth: Option<Corner>) -> Self {
        let first = first.unwrap_or(second.beyond(third));
        let fourth = fourth.unwrap_or(third.beyond(second));
        let mut line = Self::default();
        for k in 0..3 {
            let [a, b, c, d] = [first, second, third, fourth].map(|corner| corner.color[k]);
            let steps = [b - a, c - b, d - c];
            let (least, most) = (steps[0].min(steps[1]).min(steps[2]), steps[0].max(steps[1]).max(steps[2]));
            let steady = least.max(0.0) + most.min(0.0);
            let back = steps[0].abs() + steps[1].abs() + steps[2].abs() - (d - a).abs();
            line.edge += (steps[1] - steady) * (steps[1] - steady) / 3.0;
            line.steady += steady * steady / 3.0;
            line.back += back * back / 3.0;
        }
        line
    }
}

impl Contents {
    /// By the lines along the rows of corners around a pixel, from the one before it to the one after it, those along the
    /// columns, its corners, and what is known without them.
    #[inline(always)]
    pub fn new(rows: [Line; 4], columns: [Line; 4], corners: [Corner; 4], known: f64) -> Self {
        let sides = [rows[1], rows[2], columns[1], columns[2]];
        let back: f32 = rows.iter().chain(&columns).map(|line| line.back).sum();
        let hidden = corners.iter().fold(known as f32, |most, corner| most.max(corner.hidden));
        Self {
            // An edge that crosses the pixel crosses two of its sides.
            edge: 0.5 * sides.iter().map(|line| line.edge).sum::<f32>(),
            steady: 0.5 * sides.iter().map(|line| line.steady).sum::<f32>(),
            // Where colours are one of two by chance, the mean square is 8 variances.
            variance: hidden.max(back / 64.0),
        }
    }
}
