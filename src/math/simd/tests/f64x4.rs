//! Compares the lanes with scalar arithmetic.

use super::super::{FourLanes, ROUND_TO_INTEGER, sums, swap_halves};
use crate::math::instructions;
use crate::math::simd::Number;
use fearless_simd::{Simd, SimdFrom, dispatch, f64x4};

const HUGE: f64 = 1e300;

/// Returns true if two floats have the same value and sign, or are both NaN.
fn is_identical(a: f64, b: f64) -> bool {
    a == b && a.is_sign_negative() == b.is_sign_negative() || a.is_nan() && b.is_nan()
}

const NUMBERS: [f64; 10] =
    [0.0, -0.0, 1.5, -2.75, 7.0, HUGE, -HUGE, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];

/// Returns the results of every operation on two numbers, with their names.
fn results<N: Number>(x: N, y: N) -> [(&'static str, N); 11] {
    [
        ("sum", x + y),
        ("difference", x - y),
        ("product", x * y),
        ("quotient", x / y),
        ("negative", -x),
        ("reciprocal", x.recip()),
        ("absolute value", x.abs()),
        ("minimum", x.min(y)),
        ("maximum", x.max(y)),
        ("square root", x.sqrt()),
        ("selection by order", x.select_lt(y, x + y, x - y)),
    ]
}

/// Returns the results of these operations in plain arithmetic.
fn expected(a: f64, b: f64) -> [f64; 11] {
    let (min, max) = (if a < b { a } else { b }, if a > b { a } else { b });
    let selected = if a < b { a + b } else { a - b };
    [a + b, a - b, a * b, a / b, -a, 1.0 / a, f64::abs(a), min, max, f64::sqrt(a), selected]
}

#[test]
fn one_number_agrees_with_plain_arithmetic() {
    for (a, b) in NUMBERS.iter().flat_map(|&a| NUMBERS.map(|b| (a, b))) {
        for ((name, found), expected) in results(a, b).into_iter().zip(expected(a, b)) {
            assert!(is_identical(found, expected), "{name} of {a} and {b}: {found}");
        }
        assert_eq!([a.le_mask(b), a.lt_mask(b)], [u32::from(a <= b), u32::from(a < b)], "{a} {b}");
    }
}

/// Checks every operation against scalar arithmetic, for zeros, ordinary and huge numbers, infinities and
/// NaN.
fn agrees_with_scalars<S: Simd>(simd: S) {
    let numbers = NUMBERS;
    let four = |i: usize| [0, 1, 3, 4].map(|k| numbers[(i + k) % numbers.len()]);
    for (a, b) in (0..numbers.len()).flat_map(|i| (0..numbers.len()).map(move |j| (four(i), four(j)))) {
        let (x, y) = (f64x4::simd_from(simd, a), f64x4::simd_from(simd, b));
        for (i, (name, found)) in results(x, y).into_iter().enumerate() {
            for (k, found) in found.to_array().into_iter().enumerate() {
                assert!(
                    is_identical(found, expected(a[k], b[k])[i]),
                    "{name} of {} and {}: {found}",
                    a[k],
                    b[k]
                );
            }
        }
        let le_mask = (0..4).filter(|&k| a[k] <= b[k]).map(|k| 1 << k).sum::<u32>();
        let lt_mask = (0..4).filter(|&k| a[k] < b[k]).map(|k| 1 << k).sum::<u32>();
        assert_eq!([x.le_mask(y), x.lt_mask(y)], [le_mask, lt_mask], "{a:?} {b:?}");
        let sign_mask = (0..3).filter(|&k| a[k].is_sign_negative()).map(|k| 1 << k).sum::<usize>();
        assert_eq!(x.sign_mask(), sign_mask, "{a:?}");
        let to_f32 = x.to_f32();
        assert!((0..4).all(|k| is_identical(to_f32[k].into(), (a[k] as f32).into())), "{a:?}: {to_f32:?}");
    }
}

/// Checks minima and maxima of the axes, which must not depend on the unused lane, and rounding.
fn selects_and_rounds<S: Simd>(simd: S) {
    for [x, y, z] in [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0], [3.0, 2.0, 1.0], [-1.0, -2.0, -0.5]]
    {
        for unused in [-9.0, 9.0, f64::NAN] {
            let axes = f64x4::simd_from(simd, [x, y, z, unused]);
            assert_eq!((axes.min3(), axes.max3()), (x.min(y).min(z), x.max(y).max(z)));
        }
    }
    let with_nan = f64x4::simd_from(simd, [1.0, f64::NAN, 2.0, 0.0]);
    assert_eq!((with_nan.min3(), with_nan.max3()), (2.0, 2.0));
    // Of equal numbers the last one counts.
    for [x, y, z] in [[0.0, 0.0, -0.0], [-0.0, -0.0, 0.0]] {
        let zeros = f64x4::simd_from(simd, [x, y, z, 1.0]);
        assert!([zeros.min3(), zeros.max3()].iter().all(|&zero| is_identical(zero, z)));
    }
    let numbers = [0.0, 0.49, 0.51, 1e9 + 0.3];
    let [lanes, next] = [f64x4::simd_from(simd, numbers), f64x4::simd_from(simd, numbers.map(|x| 1.0 + x))];
    for i in -9..9 {
        let numbers = [0.0, 0.25, 0.5, 0.75].map(|fraction| f64::from(i) + fraction);
        assert_eq!(
            fearless_simd::SimdFloat::ceil(f64x4::simd_from(simd, numbers)).to_array(),
            numbers.map(f64::ceil)
        );
    }
    for x in [0.0, -0.0, 0.5, 0.75, 254.5, 255.5, 1e9 + 0.3, ROUND_TO_INTEGER / 3.0, 2e18, HUGE, f64::NAN] {
        let around = [x, -x, x.next_up(), -x.next_down()];
        let floors = fearless_simd::SimdFloat::floor(f64x4::simd_from(simd, around)).to_array();
        assert!((0..4).all(|k| floors[k] == around[k].floor() || x.is_nan() && floors[k].is_nan()), "{x}");
    }
    let rows = [0.1, 0.25, -3.0, HUGE].map(|x| [x, 1e-17, 2.0 * x, 0.7]);
    let found = sums(rows.map(|row| f64x4::simd_from(simd, row))).to_array();
    assert_eq!(found, rows.map(|[a, b, c, d]| (a + c) + (b + d)));
    let [a, b, c, d] = numbers;
    assert_eq!(swap_halves(lanes).to_array(), [c, d, a, b]);
    assert_eq!(lanes.to_i32(), numbers.map(|x| x.round() as i32));
    assert_eq!(next.to_i32(), lanes.to_i32().map(|n| n + 1));
    assert_eq!(f64x4::simd_from(simd, numbers.map(|x| -x)).to_i32(), lanes.to_i32().map(|n| -n));
}

#[test]
fn lanes_agree_with_scalar_arithmetic() {
    for level in instructions::available() {
        dispatch!(level, simd => agrees_with_scalars(simd));
        dispatch!(level, simd => selects_and_rounds(simd));
    }
}
