//! Correlated multi-jittered samples (Kensler, Pixar technical memo 13-01, 2013). Each stratum of a grid contains one
//! random point, as with jittered samples. In addition they form an n-rooks pattern: if a pixel with n samples is
//! divided into n columns and n rows, each contains one sample.

use super::drand48::Drand48;
use glam::DVec2;
use rand::RngExt;

/// The largest number of columns in a pixel.
const MOST_COLUMNS: usize = 40;

/// The offsets of a pixel's samples from its centre, in [-0.5, 0.5).
#[derive(Clone, Debug)]
pub struct MultiJittered {
    rng: Drand48,
    /// The numbers of columns and rows of strata.
    strata: [usize; 2],
    /// The subcolumn of the samples in each row of strata, and the subrow of the samples in each column.
    places: [[u8; MOST_COLUMNS]; 2],
    next: usize,
}

impl MultiJittered {
    /// Returns the largest number of random numbers drawn for `samples` samples.
    pub fn draws(samples: u32) -> u64 {
        2 * u64::from(samples) + 2 * MOST_COLUMNS as u64
    }

    /// Returns the columns and rows of the grid nearest to a square with at least `samples` strata and at most `most`,
    /// which is limited to 1024.
    pub fn strata(samples: u32, most: u32) -> [u32; 2] {
        let samples = samples.clamp(1, most.clamp(1, 1024));
        let rows = samples.isqrt();
        let columns = samples.div_ceil(rows);
        if columns * rows > most { [samples / rows, rows] } else { [columns, rows] }
    }

    /// Creates a sampler with one sample in each stratum.
    pub fn new([columns, rows]: [u32; 2], mut rng: Drand48) -> Self {
        // The subcolumns of a row's samples, and the subrows of a column's samples.
        let places = [rows, columns].map(|count| permutation(count as usize, &mut rng));
        Self { rng, strata: [columns as usize, rows as usize], places, next: 0 }
    }
}

/// Returns the numbers below `count` in random order.
#[inline(always)]
fn permutation(count: usize, rng: &mut Drand48) -> [u8; MOST_COLUMNS] {
    let mut numbers = std::array::from_fn(|k| k as u8);
    for k in (1..count.min(MOST_COLUMNS)).rev() {
        let other = (rng.random::<f64>() * (k + 1) as f64) as usize;
        numbers.swap(k, other);
    }
    numbers
}

// Not a closure, because closures are not compiled for the caller's instruction set.
impl Iterator for MultiJittered {
    type Item = DVec2;

    #[inline(always)]
    fn next(&mut self) -> Option<DVec2> {
        let [columns, rows] = self.strata;
        let (i, j) = (self.next % columns, self.next / columns);
        if j == rows {
            return None;
        }
        self.next += 1;
        let strata = DVec2::new(columns as f64, rows as f64);
        let within = DVec2::new(f64::from(self.places[0][j]), f64::from(self.places[1][i]));
        let random = DVec2::new(self.rng.random(), self.rng.random());
        let in_stratum = (within + random) / DVec2::new(strata.y, strata.x);
        Some((DVec2::new(i as f64, j as f64) + in_stratum) / strata - 0.5)
    }

    #[inline(always)]
    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.strata[0] * self.strata[1] - self.next;
        (left, Some(left))
    }
}

impl ExactSizeIterator for MultiJittered {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_stratum_column_and_row_has_one() {
        for samples in 1..=1024 {
            let offsets: Vec<DVec2> =
                MultiJittered::new(MultiJittered::strata(samples, 1024), Drand48::seeded(samples)).collect();
            let count = offsets.len();
            let rows = samples.isqrt() as usize;
            assert!(
                count >= samples as usize && count < samples as usize + rows.max(1) || count == 1024,
                "{samples} {count}"
            );
            let columns = count / rows;
            let distinct = |cells: [usize; 2]| {
                let cell = |offset: &DVec2| {
                    let [x, y] = [0, 1].map(|axis| ((offset[axis] + 0.5) * cells[axis] as f64) as usize);
                    assert!(x < cells[0] && y < cells[1]);
                    x + y * cells[0]
                };
                offsets.iter().map(cell).collect::<std::collections::HashSet<_>>().len()
            };
            assert_eq!([[columns, rows], [count, 1], [1, count]].map(distinct), [count; 3], "{samples}");
        }
    }

    #[test]
    fn there_are_no_more_than_the_most() {
        for most in 1..=1024 {
            for samples in [1, most / 2, most, 2000] {
                let count = MultiJittered::strata(samples, most).into_iter().product::<u32>() as usize;
                assert!(
                    (1..=most as usize).contains(&count)
                        && count >= (samples.min(most) as usize).saturating_sub(32)
                );
            }
        }
    }

    #[test]
    fn samples_are_spread_evenly() {
        let mut sum = [[0u32; 6]; 6];
        for seed in 0..3000 {
            for offset in MultiJittered::new([3, 2], Drand48::seeded(seed).jumped(9)) {
                let [x, y] = [offset.x, offset.y].map(|x| ((x + 0.5) * 6.0) as usize);
                sum[y][x] += 1;
            }
        }
        // 500 with a standard deviation of 22 in each.
        assert!(sum.iter().flatten().all(|count| (400..600).contains(count)), "{sum:?}");
    }
}
