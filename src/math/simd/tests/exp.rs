use super::super::*;
use crate::math::instructions;
use fearless_simd::{SimdFrom, dispatch};

const LOWEST_ARGUMENT: f64 = -708.0;

/// Returns arguments of every magnitude, and arguments on both sides of each branch of `libm::exp` and each change of
/// k.
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
        let found = FourLanes::to_array(exp_of_negative(f64x4::simd_from(simd, four)));
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
