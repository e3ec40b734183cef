//! An Owen-scrambled Sobol' sequence for each pixel. The first n points of a sequence are spread evenly for any n, and
//! best for powers of two. So a pixel can get more samples at any time, and all of them count.
//!
//! The sequence is Sobol's first two dimensions: of the first 2^m points, each of the 2^m equal rectangles of any shape
//! that halvings of the pixel give contains one. Owen's scrambling exchanges the halves of the pixel at random, then the
//! halves of the halves, and so on. It keeps this property, and each point alone is uniformly distributed, so averages
//! have no bias (Owen, "Scrambled net variance for integrals of smooth functions", Annals of Statistics 1997). A hash
//! of the digits stands for the random exchanges (Burley, "Practical hash-based Owen scrambling", JCGT 2020, with
//! Vegdahl's constants).

use super::drand48::Drand48;
use glam::DVec2;

/// The sequence of a pixel.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    /// The random numbers that scramble each dimension.
    seeds: [u64; 2],
}

/// The distance of neighbouring coordinates.
const STEP: f64 = 1.0 / (1u64 << 32) as f64;

impl Sobol {
    /// Returns the sequence that this state of the generator scrambles.
    #[inline(always)]
    pub fn scrambled_by(rng: Drand48) -> Self {
        Self { seeds: [mixed(2 * rng.state()), mixed(2 * rng.state() + 1)] }
    }

    /// Returns the offset of a point from the pixel's centre, in [-0.5, 0.5).
    #[inline(always)]
    pub fn offset(self, index: u32) -> DVec2 {
        let [x, y] = [index, second(index)];
        let coordinate = |digits: u32, seed| f64::from(scrambled(digits, seed).reverse_bits()) * STEP - 0.5;
        DVec2::new(coordinate(x, self.seeds[0]), coordinate(y, self.seeds[1]))
    }
}

/// Returns the coordinate of a point in the second dimension, with its binary digits in reverse order. The first
/// dimension has the digits of the index itself. Digit j of the second is the sum of the digits k of the index for which
/// the binomial coefficient of k over j is odd, that is, for which k has all bits of j.
#[inline(always)]
fn second(index: u32) -> u32 {
    let steps = [(16, 0x0000_FFFF), (8, 0x00FF_00FF), (4, 0x0F0F_0F0F), (2, 0x3333_3333), (1, 0x5555_5555)];
    steps.into_iter().fold(index, |digits, (shift, mask)| digits ^ (digits >> shift & mask))
}

/// Exchanges halves of intervals at random. Each digit of the result depends on the digits before it, which are the
/// lower bits, and all 2^32 values of the lower half of the seed give different results.
#[inline(always)]
fn scrambled(digits: u32, seed: u64) -> u32 {
    let [add, factor] = [seed as u32, (seed >> 32) as u32 | 1];
    let digits = digits ^ digits.wrapping_mul(0x3d20_adea);
    let digits = digits.wrapping_add(add).wrapping_mul(factor);
    let digits = digits ^ digits.wrapping_mul(0x0552_6c56);
    digits ^ digits.wrapping_mul(0x53a2_2864)
}

/// Mixes the bits of a number (the finalizer of SplitMix64).
#[inline(always)]
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(seed: u32, count: u32) -> Vec<DVec2> {
        let sequence = Sobol::scrambled_by(Drand48::seeded(seed));
        (0..count).map(|index| sequence.offset(index) + 0.5).collect()
    }

    #[test]
    fn each_rectangle_of_any_shape_contains_one_point() {
        for seed in 0..20 {
            for bits in 0..=8 {
                for columns in 0..=bits {
                    let shape = DVec2::new(f64::from(1 << columns), f64::from(1 << (bits - columns)));
                    let mut cells: Vec<[u32; 2]> = points(seed, 1 << bits)
                        .iter()
                        .map(|p| [(p.x * shape.x) as u32, (p.y * shape.y) as u32])
                        .collect();
                    cells.sort_unstable();
                    cells.dedup();
                    assert_eq!(cells.len(), 1 << bits, "{shape}");
                }
            }
        }
    }

    #[test]
    fn each_point_is_uniform_over_all_pixels() {
        let count = 4000;
        for index in [0, 1, 2, 3, 100] {
            let mut sums = [DVec2::ZERO; 2];
            for seed in 0..count {
                let point = points(seed, index + 1)[index as usize];
                assert!(point.min_element() >= 0.0 && point.max_element() < 1.0);
                sums[0] += point - 0.5;
                sums[1] += DVec2::new((point.x - 0.5) * (point.y - 0.5), point.x * point.x - 1.0 / 3.0);
            }
            let [mean, moments] = sums.map(|sum| (sum / f64::from(count)).abs().max_element());
            // The standard errors are at most 0.005.
            assert!(mean < 0.02 && moments < 0.02, "{index}: {mean} {moments}");
        }
    }

    #[test]
    fn pixels_have_different_points() {
        let mut first: Vec<u64> = (0..1000).map(|seed| points(seed, 1)[0].x.to_bits()).collect();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 1000);
    }
}
