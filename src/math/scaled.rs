//! Floats whose exponent cannot overflow or underflow.

/// `significand * 2^exponent`; the significand is from 0.5 to 1, apart from its sign, or it is zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled {
    /// From 0.5 to 1, apart from its sign, or zero.
    pub significand: f64,
    /// Of two.
    pub exponent: i32,
}

impl Scaled {
    /// Zero, below every other exponent.
    pub const ZERO: Self = Self { significand: 0.0, exponent: i32::MIN / 2 };

    /// -1, 0 or 1.
    pub fn sign(self) -> i32 {
        (self.significand > 0.0) as i32 - (self.significand < 0.0) as i32
    }

    /// The quotient as an ordinary float, which may be infinite, or a NaN where both are zero.
    pub fn over(self, divisor: Self) -> f64 {
        libm::ldexp(self.significand / divisor.significand, self.exponent - divisor.exponent)
    }
}

/// The numbers, all divided by the same power of two, so that the largest is from 0.5 to 1.
pub fn on_one_scale(numbers: [Scaled; 3]) -> [f64; 3] {
    let largest = numbers.iter().fold(i32::MIN / 2, |largest, number| largest.max(number.exponent));
    numbers.map(|number| libm::ldexp(number.significand, number.exponent - largest))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_and_shares_do_not_depend_on_the_scale() {
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
