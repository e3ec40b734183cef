//! Sums of two floats, with about 106 bits: for the few decisions and differences that 53 bits
//! would lose (Dekker, "A Floating-Point Technique for Extending the Available Precision", Numer.
//! Math. 18, 1971). Only what those need; no operation is exact, all are good to 2^-100.

use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// `hi + lo`, where `lo` is what `hi` lost by rounding.
#[derive(Clone, Copy, Debug)]
pub struct Double {
    hi: f64,
    lo: f64,
}

impl Double {
    /// `a - b`, exactly.
    pub fn difference(a: f64, b: f64) -> Self {
        two_sum(a, -b)
    }

    /// The nearest float.
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }
}

impl From<f64> for Double {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

/// The sum and its rounding error, whichever is larger.
fn two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    let b_part = hi - a;
    Double { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// The same where |a| >= |b|.
fn fast_two_sum(a: f64, b: f64) -> Double {
    let hi = a + b;
    Double { hi, lo: b - (hi - a) }
}

impl Add for Double {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (high, low) = (two_sum(self.hi, b.hi), two_sum(self.lo, b.lo));
        let sum = fast_two_sum(high.hi, high.lo + low.hi);
        fast_two_sum(sum.hi, low.lo + sum.lo)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + Self { hi: -b.hi, lo: -b.lo }
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let hi = self.hi * b.hi;
        let rounding = self.hi.mul_add(b.hi, -hi);
        fast_two_sum(hi, rounding + (self.hi * b.lo + self.lo * b.hi))
    }
}

/// A vector of three.
pub type Double3 = [Double; 3];

/// `a - b`, exactly.
pub fn difference(a: DVec3, b: DVec3) -> Double3 {
    [0, 1, 2].map(|i| Double::difference(a[i], b[i]))
}

pub fn dot(a: Double3, b: Double3) -> Double {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_float_loses_is_kept() {
        let (one, tiny) = (Double::from(1.0), Double::from(1e-25));
        assert_eq!((one + tiny - one).value(), 1e-25);
        let third = Double::from(1.0 / 3.0);
        assert_eq!((third * Double::from(3.0) - one).value(), -0.5f64.powi(54));
        let far = difference(DVec3::splat(1e16), DVec3::splat(0.1));
        assert_eq!((far[0] - Double::from(1e16)).value(), -0.1);
    }
}
