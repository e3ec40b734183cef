//! Samplers: the positions of the samples within a pixel.

use super::c_rand::CRand;
use super::drand48::{Drand48, Jump};
use super::sobol::Sobol;
use crate::scene::edition::Edition;
use glam::DVec2;
use rand::RngExt;
use serde::{Serialize, Serializer};

/// The distribution of samples over a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Pattern {
    /// Independent, uniformly distributed points.
    Random,
    /// The centres of the strata of a grid.
    Uniform,
    /// A random point in each stratum of a grid.
    Jittered,
    /// The first points of an Owen-scrambled Sobol' sequence ([`Sobol`]).
    Sobol,
    /// One point, displaced by the random numbers of [`CRand`], which are drawn row by row.
    Displaced,
}

impl Pattern {
    /// Returns the flag for the pattern in an edition of the course, without the dash.
    pub fn flag(self, edition: Edition) -> &'static str {
        match (self, edition) {
            (Self::Uniform, Edition::Aalto) => "regular_samples",
            (Self::Random, Edition::Aalto) | (Self::Uniform, _) => "uniform_samples",
            (Self::Random, _) => "random_samples",
            (Self::Jittered, _) => "jittered_samples",
            (Self::Sobol, _) => "sobol_samples",
            (Self::Displaced, _) => "jitter",
        }
    }
}

/// Generates the sample positions of every pixel of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sampler {
    pattern: Pattern,
    count: u32,
    #[serde(rename = "seed", serialize_with = "seed")]
    rng: Drand48,
}

fn seed<S: Serializer>(rng: &Drand48, serializer: S) -> Result<S::Ok, S::Error> {
    rng.seed().serialize(serializer)
}

impl Sampler {
    /// One sample at the centre of the pixel.
    pub const CENTER: Self = Self { pattern: Pattern::Uniform, count: 1, rng: Drand48::UNSEEDED };

    /// Creates a sampler with `count` samples per pixel, but at least one.
    pub fn new(pattern: Pattern, count: u32, rng: Drand48) -> Self {
        Self { pattern, count: count.max(1), rng }
    }

    /// One sample anywhere in the pixel, as in assignment 5 of 2012.
    pub const DISPLACED: Self = Self { pattern: Pattern::Displaced, ..Self::CENTER };

    /// Returns the random numbers from a pixel on, given by its column and row from the bottom left in a picture of
    /// this width. `None` if the samples use another generator.
    pub fn c_rand(&self, [column, row]: [usize; 2], width: usize) -> Option<CRand> {
        let before = || 2 * (row as u64 * width as u64 + column as u64);
        (self.pattern == Pattern::Displaced).then(|| CRand::unseeded().jumped(before()))
    }

    /// Creates a sampler for adaptive samples. Their number replaces its own.
    pub const fn of_adaptive(rng: Drand48) -> Self {
        Self { pattern: Pattern::Sobol, count: 2, rng }
    }

    /// Returns the Sobol' sequence of a pixel with adaptive samples, given by its index in the course's order. It does
    /// not depend on the number of samples.
    pub fn sequence(&self, index: u64) -> Sobol {
        Sobol::scrambled_by(self.rng.jumped(index))
    }

    /// Returns a sampler with other random numbers.
    pub fn with_rng(self, rng: Drand48) -> Self {
        Self { rng, ..self }
    }

    /// Returns the distribution of the samples.
    pub fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// Returns the random numbers at the start of the picture.
    pub fn rng(&self) -> Drand48 {
        self.rng
    }

    /// Returns the number of samples per pixel.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the numbers of columns and rows of strata in a pixel: the grid of exactly `count` cells that is nearest
    /// to a square, with at least as many columns as rows. It has 4 x 2 cells for 8 samples, and one row for a prime
    /// number.
    pub fn strata(&self) -> [u32; 2] {
        let rows = (1..=self.count.isqrt()).rev().find(|rows| self.count.is_multiple_of(*rows)).unwrap_or(1);
        [self.count / rows, rows]
    }

    /// Returns true if a pixel has one sample, at its centre.
    pub fn is_center(&self) -> bool {
        self.pattern == Pattern::Uniform && self.count == 1
    }

    /// Returns the offsets of a pixel's samples from its centre, in [-0.5, 0.5). `index` counts the pixels in the
    /// course's order, column by column from the left, each from the bottom. Every sample takes two random numbers, so
    /// the generator jumps over the numbers of the preceding pixels.
    pub fn offsets(self, index: u64) -> Offsets {
        self.pixels(index, 0).next_offsets()
    }

    /// Returns the offsets of several pixels: the pixel with the index `first`, and then every `step`-th pixel.
    pub fn pixels(self, first: u64, step: u64) -> Pixels {
        let draws = |pixels: u64| 2 * pixels * u64::from(self.count);
        let strata = match self.pattern {
            // The samples count as one row.
            Pattern::Sobol => [self.count, 1],
            _ => self.strata(),
        };
        let strata = DVec2::from_array(strata.map(f64::from));
        let rng = self.rng.jumped(draws(first));
        let Self { pattern, count, .. } = self;
        let offsets = Offsets { pattern, rng, strata, corner: DVec2::ZERO, left: count };
        Pixels { offsets, jump: Jump::of(draws(step)) }
    }
}

/// The offsets of the samples of several pixels, at equal steps in the course's order.
#[derive(Clone, Debug)]
pub struct Pixels {
    /// The offsets of the next pixel.
    offsets: Offsets,
    /// The draws from one pixel to the next.
    jump: Jump,
}

impl Pixels {
    /// Returns the offsets of the next pixel.
    #[inline(always)]
    pub fn next_offsets(&mut self) -> Offsets {
        let offsets = self.offsets.clone();
        self.offsets.rng = offsets.rng.after(self.jump);
        offsets
    }
}

/// The offsets of a pixel's samples from its centre.
#[derive(Clone, Debug)]
pub struct Offsets {
    pattern: Pattern,
    rng: Drand48,
    /// The numbers of columns and rows of strata.
    strata: DVec2,
    /// The column and the row of the next sample's stratum.
    corner: DVec2,
    /// The number of samples left.
    left: u32,
}

// Not a closure, because closures are not compiled for the caller's instruction set.
impl Iterator for Offsets {
    type Item = DVec2;

    #[inline(always)]
    fn next(&mut self) -> Option<DVec2> {
        self.left = self.left.checked_sub(1)?;
        let (strata, corner) = (self.strata, self.corner);
        self.corner.x += 1.0;
        if self.corner.x == strata.x {
            self.corner = DVec2::new(0.0, corner.y + 1.0);
        }
        Some(match self.pattern {
            // In this form the offsets of opposite strata are exact negatives of each other.
            Pattern::Uniform => (2.0 * corner + 1.0 - strata) / (2.0 * strata),
            Pattern::Jittered => {
                let (x, y) = (self.rng.random(), self.rng.random());
                (corner + DVec2::new(x, y)) / strata - 0.5
            }
            Pattern::Sobol => Sobol::scrambled_by(self.rng).offset(corner.x as u32),
            // The course's program draws y first here. `Displaced` samples do not use this iterator.
            Pattern::Random | Pattern::Displaced => {
                let (y, x) = (self.rng.random(), self.rng.random());
                DVec2::new(x, y) - 0.5
            }
        })
    }

    #[inline(always)]
    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left as usize, Some(self.left as usize))
    }
}

impl ExactSizeIterator for Offsets {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_at_equal_steps_have_their_own_offsets() {
        for (pattern, count) in
            [(Pattern::Random, 5), (Pattern::Jittered, 12), (Pattern::Uniform, 3), (Pattern::Sobol, 7)]
        {
            let sampler = Sampler::new(pattern, count, Drand48::seeded(3));
            for (first, step) in [(0, 1), (7, 480), (123_456, 0)] {
                let mut pixels = sampler.pixels(first, step);
                for k in 0..20 {
                    let mut offsets = pixels.next_offsets();
                    assert_eq!(offsets.len(), count as usize);
                    assert!(sampler.offsets(first + k * step).eq(offsets.by_ref()));
                    assert_eq!((offsets.len(), offsets.next()), (0, None));
                }
            }
        }
    }

    #[test]
    fn a_sampler_knows_how_many_samples_it_takes_and_where() {
        let sampler = |pattern, count| Sampler::new(pattern, count, Drand48::UNSEEDED);
        let counts = [0, 1, 2, 7].map(|count| sampler(Pattern::Random, count).count());
        assert_eq!(counts, [1, 1, 2, 7]);
        assert!(Sampler::CENTER.is_center());
        assert!(!sampler(Pattern::Uniform, 2).is_center() && !sampler(Pattern::Random, 1).is_center());
    }
}
