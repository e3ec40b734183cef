//! Double-double arithmetic: unevaluated sums of two floats, about 106 bits (Dekker, "A
//! Floating-Point Technique for Extending the Available Precision", Numer. Math. 18, 1971; Joldes,
//! Muller, Popescu, "Tight and Rigorous Error Bounds for Basic Building Blocks of Double-Word
//! Arithmetic", ACM TOMS 44(2), 2017). Each operation is off by less than 2^-100 of its result.

use glam::DVec3;
use raytracer::math::double_double::exact_product;
use std::ops::{Add, Div, Mul, Neg, Sub};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dd {
    pub hi: f64,
    pub lo: f64,
}

/// The sum, and its exact rounding error.
fn two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    let b_part = hi - a;
    Dd { hi, lo: (a - (hi - b_part)) + (b - b_part) }
}

/// The same where |a| >= |b|.
fn fast_two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    Dd { hi, lo: b - (hi - a) }
}

fn two_product(a: f64, b: f64) -> Dd {
    let [hi, lo] = exact_product(a, b);
    Dd { hi, lo }
}

impl Dd {
    pub const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    pub fn sqrt(self) -> Self {
        if self.hi == 0.0 {
            return Self::ZERO;
        }
        let root = self.hi.sqrt();
        let rest = self - two_product(root, root);
        fast_two_sum(root, rest.hi / (2.0 * root))
    }

    /// Whether it is above, below or equal to zero.
    pub fn sign(self) -> i32 {
        let first = if self.hi == 0.0 { self.lo } else { self.hi };
        (first > 0.0) as i32 - (first < 0.0) as i32
    }
}

impl From<f64> for Dd {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl Neg for Dd {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Dd {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        let (high, low) = (two_sum(self.hi, b.hi), two_sum(self.lo, b.lo));
        let v = fast_two_sum(high.hi, high.lo + low.hi);
        fast_two_sum(v.hi, low.lo + v.lo)
    }
}

impl Sub for Dd {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        self + -b
    }
}

impl Mul for Dd {
    type Output = Self;
    fn mul(self, b: Self) -> Self {
        let high = two_product(self.hi, b.hi);
        let cross = self.lo.mul_add(b.hi, self.hi.mul_add(b.lo, self.lo * b.lo));
        fast_two_sum(high.hi, high.lo + cross)
    }
}

impl Div for Dd {
    type Output = Self;
    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let rest = self - b * first.into();
        let second = rest.hi / b.hi;
        let last = (rest - b * second.into()).hi / b.hi;
        fast_two_sum(first, second) + last.into()
    }
}

/// A vector of three.
pub type Dd3 = [Dd; 3];

pub fn vector(v: DVec3) -> Dd3 {
    v.to_array().map(Dd::from)
}

pub fn sub(a: &Dd3, b: &Dd3) -> Dd3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn add(a: &Dd3, b: &Dd3) -> Dd3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn scaled(a: &Dd3, factor: Dd) -> Dd3 {
    a.map(|x| x * factor)
}

pub fn dot(a: &Dd3, b: &Dd3) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: &Dd3, b: &Dd3) -> Dd3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[test]
fn double_double_keeps_thirty_digits() {
    let third = Dd::from(1.0) / Dd::from(3.0);
    assert!((third * 3.0.into() - 1.0.into()).abs().value() < 1e-31);
    let root = Dd::from(2.0).sqrt();
    assert!((root * root - 2.0.into()).abs().value() < 1e-31);
    assert_eq!((Dd::from(1.0) + 1e-25.into() - 1.0.into()).value(), 1e-25);
}
