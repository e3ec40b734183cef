//! The exponential function of four numbers at once, with the bits of [`libm::exp`].

use super::f64x4::FourLanes;
use super::number::Number;
use fearless_simd::{Simd, f64x4};

/// exp(x) for x from -708, below which results would be subnormal, to 0.
///
/// The steps are those of `libm::exp` (FreeBSD's e_exp.c, Sun Microsystems, 2004), so that the result has the
/// same bits: x = k ln 2 + r with an integer k and |r| at most ln(2) / 2, and exp(r) = 1 + r + r c / (2 - c)
/// with c = r - (P1 r^2 + ... + P5 r^10). Where that function branches, this one selects.
#[inline(always)]
pub fn exp_of_negative<S: Simd>(x: f64x4<S>) -> f64x4<S> {
    /// ln 2 in two parts, of which the first has so few bits that its product with k is exact.
    const LN_2: [f64; 2] = [0.6931471803691238, 1.9082149292705877e-10];
    const P: [f64; 5] = [
        0.16666666666666602,
        -0.0027777777777015593,
        6.613756321437934e-5,
        -1.6533902205465252e-6,
        4.1381367970572385e-8,
    ];
    // Above the first, k is 0; above the second, exp(x) is 1 + x. `libm::exp` compares the upper halves of the
    // bits.
    let (no_multiple, no_square) =
        (-f64::from_bits(0x3FD6_2E42_FFFF_FFFF), -f64::from_bits(0x3E30_0000_FFFF_FFFF));
    let splat = |number: f64| x.broadcast(number);
    let (zero, one) = (splat(0.0), splat(1.0));

    // The conversion to an integer rounds towards zero, which is upwards here.
    let multiple = fearless_simd::SimdFloat::ceil(splat(std::f64::consts::LOG2_E) * x - splat(0.5));
    let k = x.select_lt(splat(no_multiple), multiple, zero);
    let high = x - k * splat(LN_2[0]);
    let low = k * splat(LN_2[1]);
    let r = high - low;
    let square = r * r;
    let polynomial = P.into_iter().rev().map(splat).reduce(|sum, p| p + square * sum).unwrap_or(zero);
    let c = r - square * polynomial;
    let curved = x.select_lt(splat(no_square), r * c / (splat(2.0) - c), zero);
    (one + ((curved - low) + high)).times_exp2(k)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use fearless_simd::{SimdFrom, dispatch};

    const LOWEST_ARGUMENT: f64 = -708.0;

    /// Arguments of every magnitude, and those on both sides of where `libm::exp` branches or k changes.
    fn arguments() -> Vec<f64> {
        let mut all = vec![0.0, -0.0, LOWEST_ARGUMENT, -f64::MIN_POSITIVE, -f64::from_bits(1)];
        let borders = (1..1020).map(|k| (f64::from(k) - 0.5) * std::f64::consts::LN_2);
        let high_words = [0x3E30_0000u64, 0x3E30_0001, 0x3FD6_2E42, 0x3FD6_2E43, 0x3FF0_A2B2, 0x3FF0_A2B3];
        let high_words = high_words.map(|word| f64::from_bits(word << 32));
        for border in borders.chain(high_words) {
            for step in -40..40 {
                all.push(-f64::from_bits(border.to_bits().wrapping_add_signed(step)));
            }
        }
        for i in 0..200_000 {
            let fraction = f64::from(i) * 0.618_033_988_749_894_9 % 1.0;
            all.extend([-fraction, -40.0 * fraction, LOWEST_ARGUMENT * fraction]);
            all.push(-libm::exp2(-60.0 * fraction) * (1.0 + f64::from(i % 977) / 977.0));
        }
        // The borders of k up to the rounding of ln 2 and of its reciprocal.
        all.extend((0..40_000).map(|i| -0.5 * std::f64::consts::LN_2 - f64::from(i) * 2.5e-14));
        all.retain(|x| *x >= LOWEST_ARGUMENT);
        all
    }

    fn agrees_with_libm<S: Simd>(simd: S) {
        for arguments in arguments().chunks_exact(4) {
            let four = [arguments[0], arguments[1], arguments[2], arguments[3]];
            let found = exp_of_negative(f64x4::simd_from(simd, four)).to_array();
            for (x, found) in four.into_iter().zip(found) {
                assert_eq!(found.to_bits(), libm::exp(x).to_bits(), "exp({x:e}) is {found}");
            }
        }
    }

    #[test]
    fn lanes_have_the_bits_of_libm() {
        for level in instructions::available() {
            dispatch!(level, simd => agrees_with_libm(simd));
        }
    }
}
