//! Sums of two floats, about 106 bits, for the few places that f64 is too short for (Dekker, "A
//! Floating-Point Technique for Extending the Available Precision", Numer. Math. 18, 1971).
//!
//! Every operation is off by less than 2^-100 of its result.

use glam::DVec3;
use std::ops::{Add, Mul, Sub};

/// The unevaluated sum of a float and its rounding error.
#[derive(Clone, Copy, Debug)]
pub struct Dd {
    high: f64,
    low: f64,
}

impl Dd {
    /// The exact difference of two floats.
    pub fn difference(a: f64, b: f64) -> Self {
        let high = a - b;
        let part = high - a;
        Self { high, low: (a - (high - part)) - (b + part) }
    }

    /// The two floats, the smaller first.
    pub fn parts(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The nearest float.
    pub fn value(self) -> f64 {
        self.high + self.low
    }
}

impl From<f64> for Dd {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (s, t) = (Self::difference(self.high, -other.high), Self::difference(self.low, -other.low));
        let first = renormalized(s.high, s.low + t.high);
        renormalized(first.high, first.low + t.low)
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + Self { high: -other.high, low: -other.low }
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let rounding = self.high.mul_add(other.high, -high);
        renormalized(high, rounding + (self.high * other.low + self.low * other.high))
    }
}

/// The same sum with everything in `high` that fits there.
fn renormalized(high: f64, low: f64) -> Dd {
    let sum = high + low;
    Dd { high: sum, low: low - (sum - high) }
}

/// The exact difference of two points.
pub fn difference(a: DVec3, b: DVec3) -> [Dd; 3] {
    [Dd::difference(a.x, b.x), Dd::difference(a.y, b.y), Dd::difference(a.z, b.z)]
}

/// The dot product.
pub fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_float_loses_is_kept() {
        let tiny = 2f64.powi(-90);
        assert_eq!((Dd::difference(1.0, tiny) - Dd::from(1.0)).value(), -tiny);
        let x = Dd::difference(1.0, -2f64.powi(-50));
        assert_eq!((x * x - Dd::from(1.0 + 2f64.powi(-49))).value(), 2f64.powi(-100));
    }
}
