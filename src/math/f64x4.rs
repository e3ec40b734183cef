//! Four floats side by side, so that whole registers do the work: one ray's three axes and a spare
//! place, or one axis of four rays.
//!
//! What stands in the spare place never reaches a result; it may be anything.

use super::instructions::Portable;
use std::ops::{Add, Div, Mul, Sub};

/// Arithmetic place by place. Every implementation gives the same bits.
pub trait F64x4:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The proof that the processor has the instructions that the arithmetic takes.
    type Proof: Copy;
    /// The proof without which this value would not be.
    fn proof(self) -> Self::Proof;
    fn new(proof: Self::Proof, lanes: [f64; 4]) -> Self;
    fn splat(proof: Self::Proof, x: f64) -> Self;
    /// Any other number in all places.
    #[inline(always)]
    fn broadcast(self, x: f64) -> Self {
        Self::splat(self.proof(), x)
    }
    fn to_array(self) -> [f64; 4];
    /// One over each.
    #[inline(always)]
    fn recip(self) -> Self {
        self.broadcast(1.0) / self
    }
    fn abs(self) -> Self;
    /// The lesser; the other's where this one is NaN.
    fn min(self, other: Self) -> Self;
    /// The greater; the other's where this one is NaN.
    fn max(self, other: Self) -> Self;
    /// 1 where this is positive, 0 elsewhere.
    fn one_where_positive(self) -> Self;
    /// `one` where this has a sign, 0 elsewhere.
    fn where_negative(self, one: f64) -> Self;
    /// This where `other` is finite or NaN, `instead` where it is infinite.
    fn unless_infinite(self, other: Self, instead: f64) -> Self;
    /// The places where this is at most `other`, bit 0 for the first; none where one is NaN.
    fn le_mask(self, other: Self) -> u32;
    /// Which of the three axes have a sign, bit 0 for x.
    fn sign_mask(self) -> usize;
    /// The nearest whole numbers, of numbers that are below 2^31.
    fn to_i32(self) -> [i32; 4];
    /// To the nearest whole numbers, of numbers from 0 to 2^51.
    #[inline(always)]
    fn round(self) -> Self {
        (self + self.broadcast(ROUND_TO_INTEGER)) - self.broadcast(ROUND_TO_INTEGER)
    }
    /// To single precision.
    fn to_f32(self) -> [f32; 4];
    /// The least of the three axes; the later one's where an axis is NaN.
    fn min3(self) -> f64;
    /// The greatest of the three axes; the later one's where an axis is NaN.
    fn max3(self) -> f64;
}

/// Added to a number below 2^51 it leaves no bits for a fraction, and the nearest whole number in
/// the lowest ones: 1.5 * 2^52. Faster than a conversion that must also say what becomes of others.
pub const ROUND_TO_INTEGER: f64 = 6_755_399_441_055_744.0;

/// Runs on every machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalar([f64; 4]);

impl Scalar {
    /// Place by place.
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    /// Place by place with another.
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
        self.zip(other, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn one_where_positive(self) -> Self {
        self.map(|x| if x > 0.0 { 1.0 } else { 0.0 })
    }

    #[inline(always)]
    fn where_negative(self, one: f64) -> Self {
        self.map(|x| if x.is_sign_negative() { one } else { 0.0 })
    }

    #[inline(always)]
    fn unless_infinite(self, other: Self, instead: f64) -> Self {
        self.zip(other, |x, y| if y.abs() == f64::INFINITY { instead } else { x })
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
        let min3 = |a: f64, b: f64| if a < b { a } else { b };
        min3(min3(self.0[0], self.0[1]), self.0[2])
    }

    #[inline(always)]
    fn max3(self) -> f64 {
        let max3 = |a: f64, b: f64| if a > b { a } else { b };
        max3(max3(self.0[0], self.0[1]), self.0[2])
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

    const BIG: f64 = 1e300;

    /// Whether two numbers, of which one may be a NaN, are the same.
    fn same(a: f64, b: f64) -> bool {
        a == b && a.is_sign_negative() == b.is_sign_negative() || a.is_nan() && b.is_nan()
    }

    /// What an implementation makes of numbers of all kinds is what scalar arithmetic makes of each.
    fn agrees_with_scalars<F: F64x4>(proof: F::Proof) {
        let numbers = [0.0, -0.0, 1.5, -2.75, 7.0, BIG, -BIG, f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        let four = |i: usize| [0, 1, 3, 4].map(|k| numbers[(i + k) % numbers.len()]);
        for (a, b) in (0..numbers.len()).flat_map(|i| (0..numbers.len()).map(move |j| (four(i), four(j)))) {
            let (x, y) = (F::new(proof, a), F::new(proof, b));
            let check = |name: &str, found: F, expected: fn(f64, f64) -> f64| {
                for (k, found) in found.to_array().into_iter().enumerate() {
                    let expected = expected(a[k], b[k]);
                    assert!(same(found, expected), "{name} of {} and {}: {found}", a[k], b[k]);
                }
            };
            check("sum", x + y, |a, b| a + b);
            check("difference", x - y, |a, b| a - b);
            check("product", x * y, |a, b| a * b);
            check("quotient", x / y, |a, b| a / b);
            check("inverse", x.recip(), |a, _| 1.0 / a);
            check("size", x.abs(), |a, _| a.abs());
            check("lesser", x.min(y), |a, b| if a < b { a } else { b });
            check("greater", x.max(y), |a, b| if a > b { a } else { b });
            check("is positive", x.one_where_positive(), |a, _| f64::from(a > 0.0));
            check(
                "seven by sign",
                x.where_negative(7.0),
                |a, _| if a.is_sign_negative() { 7.0 } else { 0.0 },
            );
            check(
                "three for infinite",
                x.unless_infinite(y, 3.0),
                |a, b| if b.is_infinite() { 3.0 } else { a },
            );
            let le_mask = (0..4).filter(|&k| a[k] <= b[k]).map(|k| 1 << k).sum::<u32>();
            assert_eq!(x.le_mask(y), le_mask, "{a:?} {b:?}");
            let sign_mask = (0..3).filter(|&k| a[k].is_sign_negative()).map(|k| 1 << k).sum::<usize>();
            assert_eq!(x.sign_mask(), sign_mask, "{a:?}");
            let to_f32 = x.to_f32();
            assert!((0..4).all(|k| same(to_f32[k].into(), (a[k] as f32).into())), "{a:?}: {to_f32:?}");
        }
    }

    /// The least and the greatest of the axes, the nearest whole numbers, and that the spare place counts not.
    fn selects_and_rounds<F: F64x4>(proof: F::Proof) {
        for [x, y, z] in
            [[1.0, 2.0, 3.0], [3.0, 1.0, 2.0], [2.0, 3.0, 1.0], [3.0, 2.0, 1.0], [-1.0, -2.0, -0.5]]
        {
            for spare in [-9.0, 9.0, f64::NAN] {
                let axes = F::new(proof, [x, y, z, spare]);
                assert_eq!((axes.min3(), axes.max3()), (x.min(y).min(z), x.max(y).max(z)));
            }
        }
        let late = F::new(proof, [1.0, f64::NAN, 2.0, 0.0]);
        assert_eq!((late.min3(), late.max3()), (2.0, 2.0));
        let numbers = [0.0, 0.49, 0.51, 1e9 + 0.3];
        let [low, up] = [F::new(proof, numbers), F::new(proof, numbers.map(|x| 1.0 + x))];
        assert_eq!(low.round().to_array(), numbers.map(f64::round));
        assert_eq!(low.to_i32(), numbers.map(|x| x.round() as i32));
        assert_eq!(up.to_i32(), low.to_i32().map(|n| n + 1));
        assert_eq!(F::new(proof, numbers.map(|x| -x)).to_i32(), low.to_i32().map(|n| -n));
    }

    #[test]
    fn portable_arithmetic_is_that_of_single_numbers() {
        agrees_with_scalars::<Scalar>(Portable);
        selects_and_rounds::<Scalar>(Portable);
    }

    #[cfg(target_arch = "x86_64")]
    #[test]
    fn the_arithmetic_of_wide_registers_is_that_of_single_numbers() {
        use crate::math::{avx::Avx, instructions::Avx2};
        if let Some(proof) = Avx2::detect() {
            agrees_with_scalars::<Avx>(proof);
            selects_and_rounds::<Avx>(proof);
        }
    }
}
