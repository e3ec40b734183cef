//! Double-double arithmetic: a number is the unevaluated sum of two floats, about 106 bits, for the few
//! computations that f64 is not precise enough for (Dekker, "A Floating-Point Technique for Extending the
//! Available Precision", Numer. Math. 18, 1971).
//!
//! The relative error of every operation is below 2^-100.

use super::exact_product::exact_product;
use glam::DVec3;
use std::ops::{Add, Div, Mul, Sub};

/// A double-double number: the unevaluated sum of a float and a correction of at most half an ulp.
#[derive(Clone, Copy, Debug)]
pub struct Dd {
    high: f64,
    low: f64,
}

impl Dd {
    /// The exact difference of two floats.
    pub fn difference(a: f64, b: f64) -> Self {
        let high = a - b;
        let minus_b = high - a;
        Self { high, low: (a - (high - minus_b)) - (b + minus_b) }
    }

    /// The two floats, the low part first.
    pub fn parts(self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// The number times 2 to the power of `exponent`, without an error unless it overflows or underflows.
    pub fn times_exp2(self, exponent: i32) -> Self {
        let [low, high] = self.parts().map(|part| libm::ldexp(part, exponent));
        Self { high, low }
    }

    /// The number rounded to the nearest float.
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

/// The same sum with `high` rounded to the nearest float (Dekker's fast two-sum).
fn renormalized(high: f64, low: f64) -> Dd {
    let sum = high + low;
    Dd { high: sum, low: low - (sum - high) }
}

/// The exact difference of two points, by coordinate.
pub fn difference(a: DVec3, b: DVec3) -> [Dd; 3] {
    [Dd::difference(a.x, b.x), Dd::difference(a.y, b.y), Dd::difference(a.z, b.z)]
}

/// A vector minus a point.
pub fn minus(a: [Dd; 3], b: DVec3) -> [Dd; 3] {
    [a[0] - b.x.into(), a[1] - b.y.into(), a[2] - b.z.into()]
}

/// The dot product of two vectors.
pub fn dot(a: [Dd; 3], b: [Dd; 3]) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product of two vectors.
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
    /// The angle between two vectors of any length.
    pub fn of(one: DVec3, other: [Dd; 3]) -> Self {
        let one = one.to_array().map(Dd::from);
        let across = cross(one, other);
        Self { numerator: dot(across, across), denominator: dot(one, one) * dot(other, other) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::exact_product::with_and_without_fused;
    use num_rational::BigRational;
    use num_traits::Signed;

    fn exact(x: f64) -> BigRational {
        BigRational::from_float(x).unwrap()
    }

    fn exact_sum(x: Dd) -> BigRational {
        exact(x.high) + exact(x.low)
    }

    /// Evenly distributed in [-0.5, 0.5), with all bits of the significand in use.
    fn sample(i: u32, step: f64) -> f64 {
        (i as f64 * step).fract() - 0.5
    }

    /// Numbers of both signs and of magnitudes from 2^-20 to 2^20, with all bits of both parts in use.
    fn sums() -> impl Iterator<Item = Dd> {
        (1..400).map(|i| {
            let high = sample(i, 2f64.sqrt()) * 2f64.powi((i % 41) as i32 - 20);
            renormalized(high, sample(i, 3f64.sqrt()) * 2f64.powi(-52) * high)
        })
    }

    fn assert_accurate(found: Dd, true_value: BigRational, operation: &str) {
        let error = (exact_sum(found) - &true_value).abs();
        assert!(error <= true_value.abs() * exact(2f64.powi(-100)), "inaccurate {operation}: {found:?}");
        assert_eq!(found.high, found.high + found.low, "the {operation} is not renormalized");
    }

    #[test]
    fn the_relative_error_of_operations_is_below_two_to_the_minus_100() {
        with_and_without_fused(|| {
            for (x, y) in sums().zip(sums().skip(7)) {
                let (exact_x, exact_y) = (exact_sum(x), exact_sum(y));
                assert_accurate(x + y, &exact_x + &exact_y, "sum");
                assert_accurate(x - y, &exact_x - &exact_y, "difference");
                assert_accurate(x * y, &exact_x * &exact_y, "product");
                assert_accurate(x / y, &exact_x / &exact_y, "quotient");
            }
        });
    }

    #[test]
    fn cancellation_loses_no_digits() {
        for (x, y) in sums().zip(sums().skip(7)) {
            let near = Dd { high: x.high, low: 0.3 * x.low };
            assert_accurate(x - near, exact_sum(x) - exact_sum(near), "difference of neighbours");
            assert_accurate(x + y - x, exact_sum(x + y) - exact_sum(x), "sum that cancels");
        }
    }

    #[test]
    fn the_difference_of_two_floats_is_exact_whichever_is_larger() {
        for i in 1..400 {
            let (a, b) = (sample(i, 2f64.sqrt()), sample(i, 3f64.sqrt()) * 2f64.powi((i % 81) as i32 - 40));
            let found = Dd::difference(a, b);
            assert_eq!(exact_sum(found), exact(a) - exact(b));
            assert_eq!(found.parts(), [found.low, found.high]);
            assert_eq!(found.value(), a - b);
        }
        // A tie between two floats rounds to the even one.
        assert_eq!(Dd::difference(1.0, -2f64.powi(-53)).value(), 1.0);
    }

    #[test]
    fn dot_products_and_differences_of_vectors() {
        let vector = |x: f64, y: f64, z: f64| [x, y, z].map(Dd::from);
        let (a, b) = (vector(2.0, 3.0, 7.0), vector(11.0, 17.0, 29.0));
        assert_eq!(dot(a, b).value(), 276.0);
        let between = difference(DVec3::new(5.0, 7.0, 9.0), DVec3::new(1.0, 2.0, 3.0));
        assert_eq!(between.map(Dd::value), [4.0, 5.0, 6.0]);
    }

    #[test]
    fn bits_that_a_single_float_would_lose_are_kept() {
        let tiny = 2f64.powi(-90);
        assert_eq!((Dd::difference(1.0, tiny) - Dd::from(1.0)).value(), -tiny);
        let x = Dd::difference(1.0, -2f64.powi(-50));
        assert_eq!((x * x - Dd::from(1.0 + 2f64.powi(-49))).value(), 2f64.powi(-100));
    }
}
