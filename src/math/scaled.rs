//! Floats with an exponent of their own, which cannot overflow or underflow: the results of
//! [`super::predicate`].

/// The number `significand * 2^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled {
    /// Zero, or with an absolute value from 0.5 to 1.
    pub significand: f64,
    /// The exponent of two.
    pub exponent: i32,
}

impl Scaled {
    /// Zero, with an exponent below that of all other numbers.
    pub const ZERO: Self = Self { significand: 0.0, exponent: i32::MIN / 2 };

    /// The sign: -1, 0 or 1.
    pub fn sign(self) -> i32 {
        (self.significand > 0.0) as i32 - (self.significand < 0.0) as i32
    }

    /// The quotient as an ordinary float: infinite when it overflows, NaN when both are zero.
    pub fn over(self, divisor: Self) -> f64 {
        libm::ldexp(self.significand / divisor.significand, self.exponent - divisor.exponent)
    }
}

/// The numbers divided by a common power of two, such that the largest absolute value is from 0.5 to 1.
pub fn on_one_scale(numbers: [Scaled; 3]) -> [f64; 3] {
    let largest = numbers.iter().fold(i32::MIN / 2, |largest, number| largest.max(number.exponent));
    numbers.map(|number| libm::ldexp(number.significand, number.exponent - largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_and_common_scaling_do_not_depend_on_the_exponents() {
        for exponent in [-6000, 0, 6000] {
            let [one, three] =
                [(0.5, 1), (0.75, 2)].map(|(s, e)| Scaled { significand: s, exponent: e + exponent });
            assert_eq!(three.over(one), 3.0);
            assert_eq!(on_one_scale([one, three, Scaled::ZERO]), [0.25, 0.75, 0.0]);
        }
        assert_eq!(on_one_scale([Scaled::ZERO; 3]), [0.0; 3]);
        assert_eq!(Scaled::ZERO.over(Scaled { significand: -0.5, exponent: 3000 }), 0.0);
        assert!(Scaled::ZERO.over(Scaled::ZERO).is_nan());
    }
}
