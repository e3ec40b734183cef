//! Adaptive sampling: samples where they are needed, without bias.
//!
//! A pixel starts with a sample in each of its quarters. Where the samples around a quarter disagree, it is divided into
//! four, and so on. The sample of a stratum stays in the part that it lies in, and the others get new ones. A pixel's
//! colour is the mean of its samples, weighted by the areas of their strata.
//!
//! *Without bias.* Were a pixel finished when its own samples agree, those would be preferred that miss something: the
//! samples that decide would be those that count (Kirk and Arvo, "Unbiased sampling techniques for image synthesis",
//! SIGGRAPH 1991). Their remedy is to throw the deciding samples away. Here none is: whether a stratum is divided is
//! decided by all samples but its own, and its own does not influence those. So what a stratum contributes has the expected
//! value of its colours, whatever the others are, and the sum of all strata has that of the pixel's. Therefore
//!
//! * a stratum looks at the other three that were made with it, and outside them at those that were made with the one from
//!   which it comes, and so on up to the quarters of pixels; it never looks at what those have been divided into, which may
//!   depend on its own sample,
//! * how often a stratum may be divided does not depend on how many samples others have taken.

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
    /// The error of a pixel's colour that is aimed at, in levels.
    pub error: f64,
}

/// A part of a pixel with its sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stratum {
    /// The column of the pixel.
    pub column: usize,
    /// The sample's offset from the pixel's centre.
    pub offset: DVec2,
    /// The sample's colour.
    pub color: Color,
    /// The lower left corner, from that of the pixel, in pixels.
    corner: DVec2,
    /// Its side in pixels, a power of 1/2.
    size: f64,
}

/// The first samples of a pixel, one in each quarter: bottom left, bottom right, top left, top right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quarters {
    offsets: [DVec2; 4],
    colors: [Color; 4],
    /// For each sample the variance that its surface may have without showing it, such as that of highlights.
    hidden: [f64; 4],
}

/// A pixel's first samples among those of the 3 x 3 pixels around it, row by row from the bottom left. Those outside
/// the picture are missing.
pub type Neighborhood<'a> = [[Option<&'a Quarters>; 3]; 3];

/// A pixel before it is divided.
#[derive(Clone, Copy, Debug)]
pub struct Undivided<'a> {
    /// Its column.
    pub column: usize,
    /// Its first samples and those around it.
    pub around: Neighborhood<'a>,
    /// The variance that is known to be in it, whatever the samples say.
    pub known: f64,
    /// Its random numbers.
    pub rng: Drand48,
}

/// A stratum is divided where this would lessen the squared error of the pixel by more, for each new sample, than some
/// amount. It is that at which a pixel has the error that is asked for if its colours have this standard deviation, in
/// levels, in each of its strata.
///
/// With the same amount in all pixels the error of the picture is the least for all samples. A pixel with an edge
/// gets less error than is asked for, and one full of details more; it was chosen so that the pictures of
/// `examples/sampling_marks` have the error that is asked for at most.
const USUAL_DEVIATION: f64 = 10.0;

/// What is known of a pixel without samples counts in strata that have been divided this often at most. Smaller ones are
/// as small as what they may miss.
const BLIND_DEPTH: u32 = 3;

/// The samples around a stratum, and the parameters of the plane through their colours.
const AROUND: usize = 8;
const PLANE: usize = 3;

/// The number of levels from black to white.
const LEVELS: f64 = 255.0;

impl Adaptive {
    /// The number of samples that each pixel has at least.
    pub const BASE: u32 = 4;

    /// The number of samples above which no pixel gets any.
    pub const LIMIT: u32 = 1024;

    /// How often a pixel is divided into four at most.
    fn depth(&self) -> u32 {
        self.most.checked_ilog2().unwrap_or(0) / 2
    }

    /// The variance from which a stratum is divided that is the result of so many divisions of a pixel into four.
    fn variance_to_divide(&self, depth: u32) -> f64 {
        // With strata of area a and variance v, a^2 v is the squared error of one. It is divided where this is above t. If
        // all are like this, the error of their sum is a v, which is the root of v t.
        let error = self.error / LEVELS;
        let usual = USUAL_DEVIATION / LEVELS;
        let least = (error * error / usual) * (error * error / usual);
        least * f64::from(1u32 << (4 * depth).min(31))
    }
}

impl Stratum {
    /// The part of the pixel that it takes up, a power of 1/4.
    pub fn area(&self) -> f64 {
        self.size * self.size
    }

    /// The quarter of a pixel with its first sample.
    fn quarter(column: usize, quarters: &Quarters, place: usize) -> Self {
        let corner = DVec2::new((place % 2) as f64, (place / 2) as f64) * 0.5;
        let (offset, color) = (quarters.offsets[place], quarters.colors[place]);
        Self { column, offset, color, corner, size: 0.5 }
    }

    /// The quarter that the sample lies in.
    fn own_quarter(&self) -> usize {
        let middle = self.corner + 0.5 * self.size;
        let [right, up]: [bool; 2] = (self.offset + 0.5).cmpge(middle).into();
        usize::from(right) + 2 * usize::from(up)
    }

    /// This quarter of it, with the sample if that lies in it, and otherwise with a place for a new one.
    fn part(self, quarter: usize, is_own: bool, rng: &mut Drand48) -> Self {
        let size = 0.5 * self.size;
        let corner = self.corner + size * DVec2::new((quarter % 2) as f64, (quarter / 2) as f64);
        let offset = if is_own {
            self.offset
        } else {
            corner + size * DVec2::new(rng.random(), rng.random()) - 0.5
        };
        Self { offset, corner, size, ..self }
    }
}

impl Quarters {
    /// Samples at these offsets from the pixel's centre, with their colours and the variance that each may hide.
    pub fn new(offsets: [DVec2; 4], colors: [Color; 4], hidden: [f64; 4]) -> Self {
        Self { offsets, colors, hidden }
    }
}

/// Strata that were made together: the quarters of a pixel or of another stratum, with their first samples.
#[derive(Clone, Copy, Debug)]
struct Family {
    /// The index of the pixel.
    pixel: usize,
    /// The index of the family that the divided stratum belongs to; none for the quarters of a pixel.
    parent: Option<usize>,
    /// The column and row of the lower left one among strata of its size.
    corner: [isize; 2],
    strata: [Stratum; 4],
    /// The indices of the families that they have been divided into.
    children: [Option<usize>; 4],
}

/// The strata of some pixels.
#[derive(Debug)]
pub struct Strata<'a> {
    settings: Adaptive,
    pixels: Vec<Undivided<'a>>,
    /// The families of all pixels: those of pixels first, in their order, and then those of each further depth.
    families: Vec<Family>,
    /// The first family of the last depth, and that depth.
    last: (usize, u32),
    /// The strata in the end, pixel by pixel.
    strata: Vec<Stratum>,
}

/// A stratum by the index of its family and its own in the family.
pub type StratumIndex = (usize, usize);

impl<'a> Strata<'a> {
    /// Of no pixels yet.
    pub fn new(settings: Adaptive) -> Self {
        Self { settings, pixels: vec![], families: vec![], last: (0, 1), strata: vec![] }
    }

    /// Starts with these pixels. Those without first samples are left out.
    pub fn start(&mut self, pixels: impl Iterator<Item = Undivided<'a>>) {
        self.pixels.clear();
        self.families.clear();
        self.last = (0, 1);
        for pixel in pixels {
            let Some(quarters) = pixel.around[1][1] else { continue };
            self.families.push(Family {
                pixel: self.pixels.len(),
                parent: None,
                corner: [0; 2],
                strata: [0, 1, 2, 3].map(|place| Stratum::quarter(pixel.column, quarters, place)),
                children: [None; 4],
            });
            self.pixels.push(pixel);
        }
    }

    /// Divides the strata that were made last where that is needed, and enters those that need a sample. All others must
    /// have their colours. None are needed in the end.
    pub fn divide(&mut self, new: &mut Vec<StratumIndex>) {
        new.clear();
        let (first, depth) = self.last;
        let end = self.families.len();
        self.last = (end, depth + 1);
        if depth >= self.settings.depth() {
            return;
        }
        let least = self.settings.variance_to_divide(depth);
        for family in first..end {
            let known = if depth <= BLIND_DEPTH { self.pixels[self.families[family].pixel].known } else { 0.0 };
            if known >= least {
                (0..4).for_each(|place| self.divide_one((family, place), new));
                continue;
            }
            let block = self.block(family);
            if block.is_even() {
                continue;
            }
            for place in 0..4 {
                if f64::from(block.variance(place)) >= least {
                    self.divide_one((family, place), new);
                }
            }
        }
    }

    /// Divides a stratum into four.
    fn divide_one(&mut self, (parent, place): StratumIndex, new: &mut Vec<StratumIndex>) {
        let index = self.families.len();
        let Family { pixel, corner, strata, .. } = self.families[parent];
        let rng = &mut self.pixels[pixel].rng;
        let own = strata[place].own_quarter();
        let strata = [0, 1, 2, 3].map(|quarter| {
            if quarter != own {
                new.push((index, quarter));
            }
            strata[place].part(quarter, quarter == own, rng)
        });
        let corner = [0, 1].map(|axis| 2 * (corner[axis] + (place >> axis & 1) as isize));
        self.families.push(Family { pixel, parent: Some(parent), corner, strata, children: [None; 4] });
        self.families[parent].children[place] = Some(index);
    }

    /// A stratum.
    pub fn stratum(&mut self, (family, place): StratumIndex) -> &mut Stratum {
        &mut self.families[family].strata[place]
    }

    /// The strata of a family and those around them.
    fn block(&self, family: usize) -> Block {
        let Family { corner, .. } = self.families[family];
        let mut block = Block { samples: [[0.0; 4]; 16], missing: 0 };
        for (k, sample) in block.samples.iter_mut().enumerate() {
            let place = [corner[0] + (k % 4) as isize - 1, corner[1] + (k / 4) as isize - 1];
            match self.first(family, place) {
                Some(found) => *sample = found,
                None => block.missing |= 1 << k,
            }
        }
        block
    }

    /// The sample at a place among strata of the size of a family's: that of the smallest stratum there that was made
    /// together with those or with any that they come from.
    fn first(&self, mut family: usize, [mut x, mut y]: [isize; 2]) -> Option<BlockSample> {
        loop {
            let Family { pixel, parent, corner, strata, .. } = &self.families[family];
            let Some(parent) = parent else { return self.pixels[*pixel].first([x, y]) };
            if let [i @ 0..2, j @ 0..2] = [x - corner[0], y - corner[1]] {
                return Some(block_sample(strata[(2 * j + i) as usize].color, 0.0));
            }
            (x, y, family) = (x.div_euclid(2), y.div_euclid(2), *parent);
        }
    }

    /// The strata in the end, pixel by pixel.
    pub fn finish(&mut self) -> impl Iterator<Item = &[Stratum]> {
        self.strata.clear();
        for pixel in 0..self.pixels.len() {
            add_leaves(&self.families, pixel, &mut self.strata);
        }
        self.strata.chunk_by(|a, b| a.column == b.column)
    }
}

/// Adds the strata of a family that have not been divided, and those of its children.
fn add_leaves(families: &[Family], family: usize, leaves: &mut Vec<Stratum>) {
    let Family { strata, children, .. } = &families[family];
    for (stratum, child) in strata.iter().zip(children) {
        match child {
            Some(child) => add_leaves(families, *child, leaves),
            None => leaves.push(*stratum),
        }
    }
}

impl Undivided<'_> {
    /// The first sample of a quarter, which is counted from the lower left of the pixel and may lie in a pixel beside it.
    fn first(&self, [x, y]: [isize; 2]) -> Option<BlockSample> {
        let index = |place: isize| (1 + place.div_euclid(2)) as usize;
        let quarters = self.around[index(y)][index(x)]?;
        let place = (2 * y.rem_euclid(2) + x.rem_euclid(2)) as usize;
        Some(block_sample(quarters.colors[place], quarters.hidden[place]))
    }
}

/// A colour, and the variance that it may hide. No more than single precision is needed to decide.
type BlockSample = [f32; 4];

fn block_sample(color: Color, hidden: f64) -> BlockSample {
    [color.x as f32, color.y as f32, color.z as f32, hidden as f32]
}

/// The samples of the strata of a family, in the middle, and of those around them: four rows of four.
struct Block {
    samples: [BlockSample; 16],
    /// A bit for each that is outside the picture.
    missing: u32,
}

impl Block {
    /// Whether no stratum has a variance, because all samples are the same and hide nothing.
    fn is_even(&self) -> bool {
        let [r, g, b, _] = self.samples[5];
        self.missing == 0 && self.samples.iter().all(|sample| *sample == [r, g, b, 0.0])
    }

    /// The variance of the colours around a stratum, beside that of the plane through them, but at least what they may hide.
    ///
    /// If colours are a plane, what is left of them is due to where in their strata the samples lie, which is the variance
    /// within a stratum.
    fn variance(&self, place: usize) -> f32 {
        let first = place % 2 + 4 * (place / 2);
        let mut ring = [0, 1, 2, 4, 6, 8, 9, 10].map(|k| self.samples[first + k]);
        let hidden = ring.iter().fold(0.0, |most: f32, sample| most.max(sample[3]));
        if self.missing != 0 {
            self.complete(first, &mut ring);
        }
        let mut mean = [0.0; 4];
        ring.iter().for_each(|sample| (0..4).for_each(|i| mean[i] += sample[i]));
        mean = mean.map(|sum| sum / AROUND as f32);
        let (mut squares, mut per_x, mut per_y) = ([0.0; 4], [0.0; 4], [0.0; 4]);
        const X: [f32; AROUND] = [-1.0, 0.0, 1.0, -1.0, 1.0, -1.0, 0.0, 1.0];
        const Y: [f32; AROUND] = [-1.0, -1.0, -1.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        for (k, sample) in ring.iter().enumerate() {
            for i in 0..4 {
                let off = sample[i] - mean[i];
                squares[i] += off * off;
                per_x[i] += X[k] * off;
                per_y[i] += Y[k] * off;
            }
        }
        let left = |i: usize| squares[i] - (per_x[i] * per_x[i] + per_y[i] * per_y[i]) / 6.0;
        let variance = (left(0) + left(1) + left(2)) / (3 * (AROUND - PLANE)) as f32;
        // A colour that is not finite is not made better by more samples.
        if variance.is_finite() { variance.max(hidden) } else { hidden }
    }

    /// Gives the mean of the others to those around a stratum that are outside the picture.
    fn complete(&self, first: usize, ring: &mut [BlockSample; AROUND]) {
        let is_missing = [0, 1, 2, 4, 6, 8, 9, 10].map(|k| self.missing >> (first + k) & 1 == 1);
        let mut sum = [0.0; 4];
        ring.iter().for_each(|sample| (0..4).for_each(|i| sum[i] += sample[i]));
        let count = is_missing.iter().filter(|is_missing| !**is_missing).count().max(1) as f32;
        for (sample, is_missing) in ring.iter_mut().zip(is_missing) {
            if is_missing {
                *sample = sum.map(|sum| sum / count);
            }
        }
    }
}

#[cfg(test)]
mod tests;
