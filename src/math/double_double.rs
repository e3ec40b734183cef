//! Double-double arithmetic: a number is the unevaluated sum of two floats, about 106 bits, for the few computations
//! that need more precision than f64 (Dekker, "A Floating-Point Technique for Extending the Available Precision",
//! Numer. Math. 18, 1971).
//!
//! The relative error of every operation is below 2^-100. Products are exact through a fused multiply-add, which gives
//! the error of the rounded product.

use glam::DVec3;
use std::ops::{Add, Div, Mul, Sub};

/// Returns the product a b as the rounded product and its error. Their sum is exact unless one of them overflows or the
/// error underflows.
#[inline(always)]
pub fn exact_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    // `f64::mul_add` may be a function of the C library, of which some round twice.
    [product, libm::fma(a, b, -product)]
}

/// A double-double number: the unevaluated sum of a float and a correction of at most half an ulp.
#[derive(Clone, Copy, Debug)]
pub struct Dd {
    high: f64,
    low: f64,
}

impl Dd {
    /// Returns the exact difference of two floats.
    pub fn difference(a: f64, b: f64) -> Self {
        let high = a - b;
        let minus_b = high - a;
        Self { high, low: (a - (high - minus_b)) - (b + minus_b) }
    }

    /// Returns the two floats, the low part first.
    pub fn parts(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// Returns the number times 2 to the power of `exponent`, without an error unless it overflows or underflows.
    pub fn times_exp2(self, exponent: i32) -> Self {
        let [low, high] = self.parts().map(|part| libm::ldexp(part, exponent));
        Self { high, low }
    }

    /// Returns the number rounded to the nearest float.
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
        let [high, rounding] = exact_product(self.high, other.high);
        renormalized(high, rounding + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = self.value() / other.value();
        let rest = self - other * first.into();
        renormalized(first, rest.value() / other.value())
    }
}

/// Returns the same sum with `high` rounded to the nearest float (Dekker's fast two-sum).
fn renormalized(high: f64, low: f64) -> Dd {
    let sum = high + low;
    Dd { high: sum, low: low - (sum - high) }
}

/// Returns the exact difference of two points, by coordinate.
pub fn difference(a: DVec3, b: DVec3) -> [Dd; 3] {
    [Dd::difference(a.x, b.x), Dd::difference(a.y, b.y), Dd::difference(a.z, b.z)]
}

/// Returns a vector minus a point.
pub fn minus(a: [Dd; 3], b: DVec3) -> [Dd; 3] {
    [a[0] - b.x.into(), a[1] - b.y.into(), a[2] - b.z.into()]
}

/// Returns the dot product of two vectors.
pub fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the cross product of two vectors.
pub fn cross(a: [Dd; 3], b: [Dd; 3]) -> [Dd; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The square of the sine of an angle, as a fraction.
pub struct SquaredSine {
    /// The square of the cross product of two vectors.
    pub numerator: Dd,
    /// The product of the squares of their lengths.
    pub denominator: Dd,
}

impl SquaredSine {
    /// Returns the squared sine of the angle between two vectors of any length.
    pub fn of(one: DVec3, other: [Dd; 3]) -> Self {
        let one = one.to_array().map(Dd::from);
        let across = cross(one, other);
        Self { numerator: dot(across, across), denominator: dot(one, one) * dot(other, other) }
    }
}

#[cfg(test)]
mod tests;
