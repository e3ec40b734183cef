//! Four f64 lanes in one SIMD value. They hold the three axes of one ray and an unused fourth lane, or one
//! axis of four rays.
//!
//! The unused lane never influences a result and may hold any value.

use super::extremes;
use super::instructions::Portable;
use super::number::Number;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The number of lanes.
pub const LANES: usize = 4;

/// Four numbers, and what one number alone does not need. Every implementation gives the same bits.
pub trait F64x4: Number {
    /// A value with these lanes.
    fn new(proof: Self::Proof, lanes: [f64; 4]) -> Self;
    /// The lanes as an array.
    fn to_array(self) -> [f64; 4];
    /// 1 where this is greater than 0, and 0 elsewhere.
    fn one_where_positive(self) -> Self;
    /// This value where `other` is finite or NaN, and `replacement` where it is infinite.
    fn unless_infinite(self, other: Self, replacement: f64) -> Self;
    /// The product with 2 to the power of these integers, where neither this nor the product is zero,
    /// subnormal, infinite or NaN.
    fn times_exp2(self, exponents: Self) -> Self;
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
    /// Rounds down to integers. A result of 0 may have either sign.
    fn floor(self) -> Self;
    /// The sum of the lanes of each of these, (a + b) + (c + d).
    fn sums(of: [Self; 4]) -> Self;
    /// The last two lanes, and then the first two.
    fn swap_halves(self) -> Self;
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
    // Each lane is named, because a function of the standard library, such as an array's `map`, is not always inlined.

    /// Applies `f` to each lane.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let [x, y, z, w] = self.0;
        Self([f(x), f(y), f(z), f(w)])
    }

    /// Applies `f` to each pair of lanes.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let ([x, y, z, w], other) = (self.0, other.0);
        Self([f(x, other[0]), f(y, other[1]), f(z, other[2]), f(w, other[3])])
    }
}

impl Number for Scalar {
    type Proof = Portable;

    #[inline(always)]
    fn proof(self) -> Portable {
        Portable
    }

    #[inline(always)]
    fn splat(_: Portable, x: f64) -> Self {
        Self([x; 4])
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
    fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    #[inline(always)]
    fn select_lt(self, other: Self, then: Self, otherwise: Self) -> Self {
        Self(std::array::from_fn(|i| if self.0[i] < other.0[i] { then.0[i] } else { otherwise.0[i] }))
    }

    #[inline(always)]
    fn le_mask(self, other: Self) -> u32 {
        (0..4).fold(0, |set, i| set | u32::from(self.0[i] <= other.0[i]) << i)
    }

    #[inline(always)]
    fn lt_mask(self, other: Self) -> u32 {
        (0..4).fold(0, |set, i| set | u32::from(self.0[i] < other.0[i]) << i)
    }
}

impl F64x4 for Scalar {
    #[inline(always)]
    fn new(_: Portable, lanes: [f64; 4]) -> Self {
        Self(lanes)
    }

    #[inline(always)]
    fn to_array(self) -> [f64; 4] {
        self.0
    }

    #[inline(always)]
    fn one_where_positive(self) -> Self {
        self.map(|x| if x > 0.0 { 1.0 } else { 0.0 })
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, replacement: f64) -> Self {
        self.zip(other, |x, y| if y.abs() == f64::INFINITY { replacement } else { x })
    }

    #[inline(always)]
    fn times_exp2(self, exponents: Self) -> Self {
        self.zip(exponents, |x, n| {
            f64::from_bits(x.to_bits().wrapping_add((n + ROUND_TO_INTEGER).to_bits() << EXPONENT_SHIFT))
        })
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
    fn floor(self) -> Self {
        // The library's function takes three times as long where the compilation target lacks SSE4.1.
        self.map(|x| {
            if x.abs() < ROUND_TO_INTEGER / 3.0 {
                let nearest = (x + ROUND_TO_INTEGER) - ROUND_TO_INTEGER;
                nearest - f64::from((nearest > x) as u8)
            } else {
                x.floor()
            }
        })
    }

    #[inline(always)]
    fn sums(of: [Self; 4]) -> Self {
        Self(of.map(|Self([a, b, c, d])| (a + b) + (c + d)))
    }

    #[inline(always)]
    fn swap_halves(self) -> Self {
        let [a, b, c, d] = self.0;
        Self([c, d, a, b])
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

impl Neg for Scalar {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|x| -x)
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
mod tests;
