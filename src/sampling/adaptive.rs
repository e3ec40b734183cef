//! Adaptive sampling: samples where they are needed.
//!
//! A pixel is divided into 2 x 2 strata with a sample in each. Where the samples disagree, strata are divided into four
//! in turn: the sample stays in the quarter that it lies in, and each of the others gets a new one. A pixel's colour is
//! the mean of its samples, weighted by the areas of their strata, so that it stays stratified wherever it ends. The
//! samples of the pixels around take part in the decision, so that a small thing is found by all pixels that it
//! touches as soon as it is found by one.

use super::drand48::Drand48;
use crate::scene::Color;
use glam::DVec2;
use rand::RngExt;
use serde::Serialize;

/// How far adaptive sampling goes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Adaptive {
    /// The largest number of samples of a pixel, from [`BASE`](Self::BASE) to [`LIMIT`](Self::LIMIT).
    pub most: u32,
    /// The estimated error of a pixel's colour, in levels, up to which it gets more samples.
    pub error: f64,
}

/// A part of a pixel with its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// The sample's offset from the pixel's centre.
    pub offset: DVec2,
    /// The sample's colour.
    pub color: Color,
    /// How often the pixel was divided: its side is 2^-depth.
    depth: u32,
    /// The column and row, from the bottom left, among strata of this depth.
    place: [usize; 2],
}

/// The first samples of a pixel, one in each quarter: bottom left, bottom right, top left, top right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quarters {
    offsets: [DVec2; 4],
    colors: [Color; 4],
    /// The variance of the samples, as the mean of the channels.
    variance: f64,
}

/// A pixel's first samples among those of the 3 x 3 pixels around it, row by row from the bottom left. Those outside
/// the picture are missing.
pub type Neighborhood<'a> = [[Option<&'a Quarters>; 3]; 3];

/// The share of the squared differences between a sample and the four around it that is the variance within its
/// stratum.
///
/// It is 1/8 if all samples are independent, and less at an edge or a gradient.
const SHARE: f64 = 1.0 / 8.0;

/// How much of the variance of the samples around counts in a pixel whose own samples agree. It was chosen by
/// experiment: with more of it flat pixels beside edges take too many samples, with less small things are missed.
const PRIOR: f64 = 0.3;

/// A pixel is not divided further than into 2^5 by 2^5 strata.
const MAX_DEPTH: u32 = 5;

/// The square of a level, the step from one byte to the next.
const SQUARE_LEVEL: f64 = 1.0 / (255.0 * 255.0);

impl Adaptive {
    /// The number of samples that each pixel has at least.
    pub const BASE: u32 = 4;

    /// The number of samples above which no pixel gets any.
    pub const LIMIT: u32 = 1 << (2 * MAX_DEPTH);
}

impl Stratum {
    /// The part of the pixel that it takes up, a power of 1/4.
    pub fn area(&self) -> f64 {
        1.0 / (1u64 << (2 * self.depth)) as f64
    }

    /// The quarter that the sample lies in.
    fn own_quarter(&self) -> [usize; 2] {
        let side = (2u64 << self.depth) as f64;
        let fine = ((self.offset + 0.5) * side).to_array();
        [0, 1].map(|axis| usize::from(fine[axis] >= (2 * self.place[axis] + 1) as f64))
    }

    /// This quarter of it, with the sample if that lies in it, and otherwise with a place for a new one.
    fn quarter(&self, quarter: [usize; 2], rng: &mut Drand48) -> Self {
        let place = [0, 1].map(|axis| 2 * self.place[axis] + quarter[axis]);
        let divided = Self { depth: self.depth + 1, place, ..*self };
        if quarter == self.own_quarter() {
            return divided;
        }
        let side = (2u64 << self.depth) as f64;
        let random = DVec2::new(rng.random(), rng.random());
        let corner = DVec2::new(place[0] as f64, place[1] as f64);
        Self { offset: (corner + random) / side - 0.5, ..divided }
    }
}

impl Quarters {
    /// Samples at these offsets from the pixel's centre, with their colours.
    pub fn new(offsets: [DVec2; 4], colors: [Color; 4]) -> Self {
        let mean = colors.iter().sum::<Color>() / 4.0;
        let squares = colors.map(|color| (color - mean).length_squared());
        Self { offsets, colors, variance: squares.iter().sum::<f64>() / 9.0 }
    }

    fn color(&self, [x, y]: [usize; 2]) -> Color {
        self.colors[2 * y + x]
    }
}

/// The strata of one pixel.
#[derive(Debug, Default)]
pub struct Strata {
    strata: Vec<Stratum>,
    /// For each place of the finest strata, row by row, the index of the stratum that it belongs to.
    indices: Vec<u32>,
    /// The squared error that each stratum is estimated to cause.
    errors: Vec<f64>,
    /// The strata to divide.
    chosen: Vec<usize>,
}

impl Strata {
    /// Starts with a pixel's quarters.
    pub fn start(&mut self, quarters: &Quarters) {
        let strata = (0..4).map(|k| Stratum {
            offset: quarters.offsets[k],
            color: quarters.colors[k],
            depth: 1,
            place: [k % 2, k / 2],
        });
        self.strata.clear();
        self.strata.extend(strata);
    }

    /// All strata.
    pub fn all(&self) -> &[Stratum] {
        &self.strata
    }

    /// Divides strata where that is needed, and returns those that need a sample; none if the pixel is finished. The
    /// strata of the last call must have got their colours.
    pub fn divide(&mut self, settings: Adaptive, around: &Neighborhood, rng: &mut Drand48) -> &mut [Stratum] {
        let sampled = self.strata.len();
        self.choose(settings, around);
        for chosen in std::mem::take(&mut self.chosen) {
            let stratum = self.strata[chosen];
            for quarter in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                let divided = stratum.quarter(quarter, rng);
                if quarter == stratum.own_quarter() {
                    self.strata[chosen] = divided;
                } else {
                    self.strata.push(divided);
                }
            }
        }
        &mut self.strata[sampled..]
    }

    /// Chooses the strata to divide: those that cause more than their part of the error that is allowed.
    fn choose(&mut self, settings: Adaptive, around: &Neighborhood) {
        self.chosen.clear();
        let allowed = settings.error * settings.error * SQUARE_LEVEL;
        let room = (settings.most as usize).saturating_sub(self.strata.len()) / 3;
        if room == 0 || self.estimate(around) <= allowed {
            return;
        }
        let part = allowed / self.strata.len() as f64;
        let causes_too_much = |&k: &usize| self.errors[k] > part && self.strata[k].depth < MAX_DEPTH;
        self.chosen.extend((0..self.strata.len()).filter(causes_too_much));
        if self.chosen.len() > room {
            let errors = &self.errors;
            self.chosen.sort_by(|a, b| errors[*b].total_cmp(&errors[*a]));
            self.chosen.truncate(room);
        }
    }

    /// Estimates the squared error that each stratum causes, and returns their sum.
    fn estimate(&mut self, around: &Neighborhood) -> f64 {
        let depth = self.index();
        let count = self.strata.len() as f64;
        // What the samples around say counts less the more samples the pixel has itself.
        let prior = PRIOR * prior_variance(around) * (4.0 / count) * (4.0 / count);
        self.errors.clear();
        let mut sum = 0.0;
        for stratum in &self.strata {
            let variance = (SHARE * self.contrast(stratum, depth, around)).max(prior);
            let error = stratum.area() * stratum.area() * variance;
            self.errors.push(error);
            sum += error;
        }
        sum
    }

    /// Enters each stratum at its places, and returns the depth of the finest.
    fn index(&mut self) -> u32 {
        let depth = self.strata.iter().map(|stratum| stratum.depth).max().unwrap_or(0);
        let side = 1 << depth;
        self.indices.clear();
        self.indices.resize(side * side, 0);
        for (index, stratum) in self.strata.iter().enumerate() {
            let size = 1 << (depth - stratum.depth);
            let [x, y] = stratum.place.map(|place| place * size);
            for row in self.indices.chunks_mut(side).skip(y).take(size) {
                row[x..x + size].fill(index as u32);
            }
        }
        depth
    }

    /// The sum of the squared differences, as the mean of the channels, between a stratum's sample and those to its
    /// left and right, below and above.
    fn contrast(&self, stratum: &Stratum, depth: u32, around: &Neighborhood) -> f64 {
        let side = 1usize << depth;
        let size = 1 << (depth - stratum.depth);
        let [x, y] = stratum.place.map(|place| place * size);
        let [middle_x, middle_y] = [x + size / 2, y + size / 2];
        let inside = |x: usize, y: usize| Some(self.strata[self.indices[y * side + x] as usize].color);
        // The quarter of a pixel beside this one.
        let half = |place: usize| usize::from(2 * place >= side);
        let outside = |[i, j]: [usize; 2], quarter| around[j][i].map(|pixel| pixel.color(quarter));
        let beside = [
            if x > 0 { inside(x - 1, middle_y) } else { outside([0, 1], [1, half(middle_y)]) },
            if x + size < side { inside(x + size, middle_y) } else { outside([2, 1], [0, half(middle_y)]) },
            if y > 0 { inside(middle_x, y - 1) } else { outside([1, 0], [half(middle_x), 1]) },
            if y + size < side { inside(middle_x, y + size) } else { outside([1, 2], [half(middle_x), 0]) },
        ];
        let squares = beside.into_iter().flatten().map(|color| (color - stratum.color).length_squared());
        squares.sum::<f64>() / 3.0
    }
}

/// The mean variance of the first samples of a pixel and those around it.
fn prior_variance(around: &Neighborhood) -> f64 {
    let (sum, count) = around
        .iter()
        .flatten()
        .flatten()
        .fold((0.0, 0.0), |(sum, count), quarters| (sum + quarters.variance, count + 1.0));
    sum / count
}

#[cfg(test)]
mod tests;
