//! Four f64 lanes in one SIMD value. They hold the three axes of one ray and an unused fourth lane, or one
//! axis of four rays.
//!
//! The unused lane never influences a result and may hold any value.

use super::extremes;
use super::instructions::Portable;
use std::ops::{Add, Div, Mul, Sub};

/// Lane-wise arithmetic. Every implementation gives the same bits.
pub trait F64x4:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Proves that the processor has the instructions that the implementation uses.
    type Proof: Copy;
    /// The proof that this value was made with.
    fn proof(self) -> Self::Proof;
    /// A value with these lanes.
    fn new(proof: Self::Proof, lanes: [f64; 4]) -> Self;
    /// `x` in all lanes.
    fn splat(proof: Self::Proof, x: f64) -> Self;
    /// `x` in all lanes, with the proof of this value.
    #[inline(always)]
    fn broadcast(self, x: f64) -> Self {
        Self::splat(self.proof(), x)
    }
    /// The lanes as an array.
    fn to_array(self) -> [f64; 4];
    /// The reciprocals.
    #[inline(always)]
    fn recip(self) -> Self {
        self.broadcast(1.0) / self
    }
    /// The absolute values.
    fn abs(self) -> Self;
    /// The minima; the lane of `other` where either one is NaN.
    fn min(self, other: Self) -> Self;
    /// The maxima; the lane of `other` where either one is NaN.
    fn max(self, other: Self) -> Self;
    /// 1 where this is greater than 0, and 0 elsewhere.
    fn one_where_positive(self) -> Self;
    /// `value` where the sign bit is set (so also for -0), and 0 elsewhere.
    fn where_negative(self, value: f64) -> Self;
    /// This value where `other` is finite or NaN, and `replacement` where it is infinite.
    fn unless_infinite(self, other: Self, replacement: f64) -> Self;
    /// The square roots.
    fn sqrt(self) -> Self;
    /// `then` where this is less than `other`, and `otherwise` elsewhere.
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self;
    /// The product with 2 to the power of these integers, where neither this nor the product is zero,
    /// subnormal, infinite or NaN.
    fn times_exp2(self, exponents: Self) -> Self;
    /// The set of lanes where this is at most `other`, bit 0 for the first lane. A lane with a NaN is not in
    /// it.
    fn le_mask(self, other: Self) -> u32;
    /// The set of axes (the first three lanes) whose sign bit is set, bit 0 for x.
    fn sign_mask(self) -> usize;
    /// The nearest integers, for absolute values below 2^31.
    fn to_i32(self) -> [i32; 4];
    /// Rounds to the nearest integers, for absolute values below 2^51.
    #[inline(always)]
    fn round(self) -> Self {
        (self + self.broadcast(ROUND_TO_INTEGER)) - self.broadcast(ROUND_TO_INTEGER)
    }
    /// Rounds up to integers, for absolute values below 2^51. An integer keeps its value but may lose a sign
    /// of zero.
    #[inline(always)]
    fn ceil(self) -> Self {
        let nearest = self.round();
        nearest + (self - nearest).one_where_positive()
    }
    /// Rounds to single precision.
    fn to_f32(self) -> [f32; 4];
    /// The minimum of the three axes; when two are compared and one is NaN, the later axis counts.
    fn min3(self) -> f64;
    /// The maximum of the three axes; when two are compared and one is NaN, the later axis counts.
    fn max3(self) -> f64;
}

/// 1.5 * 2^52. A number below 2^51 plus this constant is so large that its last bit stands for 1: the sum is
/// rounded to an integer, which its lowest bits hold. That is faster than a conversion with `as`, which must
/// also handle NaN and numbers out of range.
pub const ROUND_TO_INTEGER: f64 = 1.5 * (1u64 << 52) as f64;

/// The number of bits below a float's exponent.
pub const EXPONENT_SHIFT: i32 = 52;

/// Four lanes in an array, for processors without AVX.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalar([f64; 4]);

impl Scalar {
    /// Applies `f` to each lane.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    /// Applies `f` to each pair of lanes.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl F64x4 for Scalar {
    type Proof = Portable;

    #[inline(always)]
    fn proof(self) -> Portable {
        Portable
    }

    #[inline(always)]
    fn new(_: Portable, lanes: [f64; 4]) -> Self {
        Self(lanes)
    }

    #[inline(always)]
    fn splat(_: Portable, x: f64) -> Self {
        Self([x; 4])
    }

    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, extremes::min)
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, extremes::max)
    }

    #[inline(always)]
    fn one_where_positive(self) -> Self {
        self.map(|x| if x > 0.0 { 1.0 } else { 0.0 })
    }

    #[inline(always)]
    fn where_negative(self, value: f64) -> Self {
        self.map(|x| if x.is_sign_negative() { value } else { 0.0 })
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, replacement: f64) -> Self {
        self.zip(other, |x, y| if y.abs() == f64::INFINITY { replacement } else { x })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i] < other.0[i] { then.0[i] } else { otherwise.0[i] }))
    }

    #[inline(always)]
    fn times_exp2(self, exponents: Self) -> Self {
        self.zip(exponents, |x, n| {
            f64::from_bits(x.to_bits().wrapping_add((n + ROUND_TO_INTEGER).to_bits() << EXPONENT_SHIFT))
        })
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        (0..4).fold(0, |set, i| set | u32::from(self.0[i] <= other.0[i]) << i)
    }

    #[inline(always)]
    fn sign_mask(self) -> usize {
        let sign = |axis: usize| usize::from(self.0[axis].is_sign_negative()) << axis;
        sign(0) | sign(1) | sign(2)
    }

    #[inline(always)]
    fn to_i32(self) -> [i32; 4] {
        self.0.map(|x| (x + ROUND_TO_INTEGER).to_bits() as i32)
    }

    #[inline(always)]
    fn to_f32(self) -> [f32; 4] {
        self.0.map(|x| x as f32)
    }

    #[inline(always)]
    fn min3(self) -> f64 {
        let [x, y, z, _] = self.0;
        extremes::min3([x, y, z])
    }

    #[inline(always)]
    fn max3(self) -> f64 {
        let [x, y, z, _] = self.0;
        extremes::max3([x, y, z])
    }
}

impl Add for Scalar {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl Sub for Scalar {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl Mul for Scalar {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Div for Scalar {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HUGE: f64 = 1e300;

    /// Whether two floats have the same value and sign, or are both NaN.
    fn is_identical(a: f64, b: f64) -> bool {
        a == b && a.is_sign_negative() == b.is_sign_negative() || a.is_nan() && b.is_nan()
    }

    /// Checks every operation against scalar arithmetic, for zeros, ordinary and huge numbers, infinities and
    /// NaN.
    fn agrees_with_scalars<F: F64x4>(proof: F::Proof) {
        let numbers = [0.0, -0.0, 1.5, -2.75, 7.0, HUGE, -HUGE, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let four = |i: usize| [0, 1, 3, 4].map(|k| numbers[(i + k) % numbers.len()]);
        for (a, b) in (0..numbers.len()).flat_map(|i| (0..numbers.len()).map(move |j| (four(i), four(j)))) {
            let (x, y) = (F::new(proof, a), F::new(proof, b));
            let check = |name: &str, found: F, expected: fn(f64, f64) -> f64| {
                for (k, found) in found.to_array().into_iter().enumerate() {
                    let expected = expected(a[k], b[k]);
                    assert!(is_identical(found, expected), "{name} of {} and {}: {found}", a[k], b[k]);
                }
            };
            check("sum", x + y, |a, b| a + b);
            check("difference", x - y, |a, b| a - b);
            check("product", x * y, |a, b| a * b);
            check("quotient", x / y, |a, b| a / b);
            check("reciprocal", x.recip(), |a, _| 1.0 / a);
            check("absolute value", x.abs(), |a, _| a.abs());
            check("minimum", x.min(y), |a, b| if a < b { a } else { b });
            check("maximum", x.max(y), |a, b| if a > b { a } else { b });
            check("square root", x.sqrt(), |a, _| a.sqrt());
            let less = x.select_lt(y, x + y, x - y);
            check("selection by order", less, |a, b| if a < b { a + b } else { a - b });
            check("is positive", x.one_where_positive(), |a, _| f64::from(a > 0.0));
            check("seven where negative", x.where_negative(7.0), |a, _| {
                if a.is_sign_negative() { 7.0 } else { 0.0 }
            });
            check(
                "three where infinite",
                x.unless_infinite(y, 3.0),
                |a, b| if b.is_infinite() { 3.0 } else { a },
            );
            let le_mask = (0..4).filter(|&k| a[k] <= b[k]).map(|k| 1 << k).sum::<u32>();
            assert_eq!(x.le_mask(y), le_mask, "{a:?} {b:?}");
            let sign_mask = (0..3).filter(|&k| a[k].is_sign_negative()).map(|k| 1 << k).sum::<usize>();
            assert_eq!(x.sign_mask(), sign_mask, "{a:?}");
            let to_f32 = x.to_f32();
            assert!(
                (0..4).all(|k| is_identical(to_f32[k].into(), (a[k] as f32).into())),
                "{a:?}: {to_f32:?}"
            );
        }
    }

    /// Checks minima and maxima of the axes, which must not depend on the unused lane, and rounding.
    fn selects_and_rounds<F: F64x4>(proof: F::Proof) {
        for [x, y, z] in
            [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0], [3.0, 2.0, 1.0], [-1.0, -2.0, -0.5]]
        {
            for unused in [-9.0, 9.0, f64::NAN] {
                let axes = F::new(proof, [x, y, z, unused]);
                assert_eq!((axes.min3(), axes.max3()), (x.min(y).min(z), x.max(y).max(z)));
            }
        }
        let with_nan = F::new(proof, [1.0, f64::NAN, 2.0, 0.0]);
        assert_eq!((with_nan.min3(), with_nan.max3()), (2.0, 2.0));
        // Of equal numbers the last one counts.
        for [x, y, z] in [[0.0, 0.0, -0.0], [-0.0, -0.0, 0.0]] {
            let zeros = F::new(proof, [x, y, z, 1.0]);
            assert!([zeros.min3(), zeros.max3()].iter().all(|&zero| is_identical(zero, z)));
        }
        let numbers = [0.0, 0.49, 0.51, 1e9 + 0.3];
        let [lanes, next] = [F::new(proof, numbers), F::new(proof, numbers.map(|x| 1.0 + x))];
        assert_eq!(lanes.round().to_array(), numbers.map(f64::round));
        assert_eq!(F::new(proof, numbers.map(|x| -x)).round().to_array(), numbers.map(|x| (-x).round()));
        for i in -9..9 {
            let numbers = [0.0, 0.25, 0.5, 0.75].map(|fraction| f64::from(i) + fraction);
            assert_eq!(F::new(proof, numbers).ceil().to_array(), numbers.map(f64::ceil));
        }
        assert_eq!(lanes.to_i32(), numbers.map(|x| x.round() as i32));
        assert_eq!(next.to_i32(), lanes.to_i32().map(|n| n + 1));
        assert_eq!(F::new(proof, numbers.map(|x| -x)).to_i32(), lanes.to_i32().map(|n| -n));
        for (x, exponents) in [(-1.75, [0, 1, -1, 7]), (1.0, [1023, -1022, 52, -53]), (1e-300, [1030; 4])] {
            let products = F::splat(proof, x).times_exp2(F::new(proof, exponents.map(f64::from)));
            assert_eq!(products.to_array(), exponents.map(|n| libm::ldexp(x, n)));
        }
    }

    #[test]
    fn portable_lanes_agree_with_scalar_arithmetic() {
        agrees_with_scalars::<Scalar>(Portable);
        selects_and_rounds::<Scalar>(Portable);
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn avx_lanes_agree_with_scalar_arithmetic() {
        use crate::math::{avx::Avx, instructions::Avx2};
        if let Some(proof) = Avx2::detect() {
            agrees_with_scalars::<Avx>(proof);
            selects_and_rounds::<Avx>(proof);
        }
    }
}
