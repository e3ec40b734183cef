//! Sums of products of floats without rounding, overflow or underflow: a fixed-point accumulator that is wide
//! enough for every bit of a product of three floats (Kulisch, "Computer Arithmetic and Validity", 2nd
//! edition, de Gruyter, 2013).
//!
//! Every finite float is an integer below 2^53 times 2^(e - 1074), with e from 0 to 2045. Hence a product of
//! three floats is an integer below 2^159 times 2^(e - 3222), with e from 0 to 6135. It fits into 6294 bits,
//! and 6400 bits hold the sum of more products than a program can add.

use super::scaled::Scaled;
use glam::DVec3;

/// An exact sum as digits in base 2^64, the least significant first. A digit may temporarily be negative or
/// exceed 64 bits: carries are propagated only when the value is read.
#[derive(Debug)]
pub struct ExactSum {
    digits: [i128; DIGITS],
    /// The first digit in use and the end of the digits in use; all others are zero.
    used: [usize; 2],
}

/// One digit more than the bits need, below all others, so that every digit in use has a lower neighbour.
const DIGITS: usize = 1 + 6400 / 64;

/// The exponent of the least significant bit of the lowest digit.
const LOWEST_EXPONENT: i32 = -3 * 1074 - 64;

/// The decomposition of a finite float: its absolute value is `significand * 2^(exponent - 1074)`.
struct Parts {
    is_negative: bool,
    significand: u64,
    exponent: usize,
}

impl Parts {
    fn of(x: f64) -> Self {
        let (fraction, field) = (x.to_bits() & ((1 << 52) - 1), (x.to_bits() >> 52 & 0x7ff) as usize);
        let significand = if field == 0 { fraction } else { fraction | 1 << 52 };
        Self { is_negative: x.is_sign_negative(), significand, exponent: field.saturating_sub(1) }
    }
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { digits: [0; DIGITS], used: [DIGITS, 0] }
    }
}

impl ExactSum {
    /// Adds the product of three finite floats.
    pub fn add_product(&mut self, factors: [f64; 3]) {
        let [a, b, c] = factors.map(Parts::of);
        if a.significand == 0 || b.significand == 0 || c.significand == 0 {
            return;
        }
        let bit = a.exponent + b.exponent + c.exponent;
        let first = 1 + bit / 64;
        let ab = u128::from(a.significand) * u128::from(b.significand);
        let product = product(ab, u128::from(c.significand) << (bit % 64));
        let digits = self.digits[first..first + 4].iter_mut().zip(product.map(i128::from));
        if a.is_negative ^ b.is_negative ^ c.is_negative {
            digits.for_each(|(sum, digit)| *sum -= digit);
        } else {
            digits.for_each(|(sum, digit)| *sum += digit);
        }
        self.used = [self.used[0].min(first), self.used[1].max(first + 4)];
    }

    /// Adds the determinant of the 3x3 matrix with these rows (or columns), which must be finite.
    pub fn add_determinant(&mut self, [p, q, r]: [DVec3; 3]) {
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            self.add_product([p[i], q[j], r[k]]);
            self.add_product([-p[i], q[k], r[j]]);
        }
    }

    /// The sum, rounded to the nearest float of unbounded exponent. Its sign is exact, and it is zero only if
    /// the sum is zero.
    pub fn value(mut self) -> Scaled {
        let is_negative = self.carry() < 0;
        if is_negative {
            self.digits_in_use().iter_mut().for_each(|digit| *digit = -*digit);
            self.carry();
        }
        let Scaled { significand, exponent } = self.normalized_value();
        Scaled { significand: if is_negative { -significand } else { significand }, exponent }
    }

    fn digits_in_use(&mut self) -> &mut [i128] {
        let [first, end] = self.used;
        self.digits.get_mut(first..end).unwrap_or_default()
    }

    /// Propagates carries, so that every digit is from 0 to 2^64 - 1, and returns the carry out of the
    /// highest digit: 0, or -1 for a negative sum, whose two's complement the digits then are.
    fn carry(&mut self) -> i128 {
        self.digits_in_use().iter_mut().fold(0, |carry, digit| {
            let sum = *digit + carry;
            *digit = sum & i128::from(u64::MAX);
            sum >> 64
        })
    }

    /// The value after carries have been propagated, for a sum that is not negative.
    fn normalized_value(&self) -> Scaled {
        let [first, end] = self.used;
        let Some(highest) = (first..end).rev().find(|&i| self.digits[i] != 0) else { return Scaled::ZERO };
        let two_digits = (self.digits[highest] as u128) << 64 | self.digits[highest - 1] as u128;
        // These two digits have at least 65 significant bits, so all lower bits matter only as a sticky bit:
        // they decide whether the sum lies above a tie.
        let sticky = self.digits[..highest - 1].iter().skip(first).any(|&digit| digit != 0);
        let (significand, exponent) = libm::frexp((two_digits | u128::from(sticky)) as f64);
        Scaled { significand, exponent: exponent + LOWEST_EXPONENT + 64 * (highest as i32 - 1) }
    }
}

/// The product of two 128-bit integers as digits in base 2^64, the least significant first. The product must
/// be less than 2^256.
fn product(a: u128, b: u128) -> [u64; 4] {
    let halves = |x: u128| [x as u64, (x >> 64) as u64].map(u128::from);
    let ([a_low, a_high], [b_low, b_high]) = (halves(a), halves(b));
    let [first, carry] = halves(a_low * b_low);
    let ([lh_low, lh_high], [hl_low, hl_high]) = (halves(a_low * b_high), halves(a_high * b_low));
    let [second, carry] = halves(carry + lh_low + hl_low);
    let [third, fourth] = halves(a_high * b_high + carry + lh_high + hl_high);
    [first, second, third, fourth].map(|digit| digit as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(products: &[[f64; 3]]) -> Scaled {
        let mut sum = ExactSum::default();
        products.iter().for_each(|&factors| sum.add_product(factors));
        sum.value()
    }

    #[test]
    fn a_product_has_its_value_and_sign() {
        assert_eq!(sum(&[[3.0, -0.5, 7.0]]), Scaled { significand: -10.5 / 16.0, exponent: 4 });
        assert_eq!(sum(&[]), Scaled::ZERO);
        assert_eq!(sum(&[[0.0, 1.0, 1.0], [-0.0, 5.0, 2.0]]), Scaled::ZERO);
    }

    #[test]
    fn the_smallest_and_the_largest_products_are_representable() {
        let (tiny, huge) = (f64::from_bits(1), f64::MAX);
        assert_eq!(sum(&[[tiny; 3]]), Scaled { significand: 0.5, exponent: -3221 });
        assert_eq!(sum(&[[-huge; 3]]), Scaled { significand: -1.0 + 3.0 * 2f64.powi(-53), exponent: 3072 });
        let all = [[huge; 3], [tiny; 3], [-huge, huge, huge], [tiny, -tiny, tiny], [tiny; 3]];
        assert_eq!(sum(&all), Scaled { significand: 0.5, exponent: -3221 });
    }

    #[test]
    fn many_large_products_carry_into_the_highest_digits() {
        let all = vec![[-f64::MAX; 3]; 1 << 12];
        assert_eq!(sum(&all).exponent, 3072 + 12);
    }

    #[test]
    fn a_bit_far_below_breaks_a_tie() {
        let (half_an_ulp, tiny) = (2f64.powi(-53), 2f64.powi(-1000));
        let tie = [[1.0; 3], [half_an_ulp, 1.0, 1.0]];
        assert_eq!(sum(&tie).significand, 0.5);
        assert_eq!(sum(&[tie[0], tie[1], [tiny; 3]]).significand, 0.5 + half_an_ulp);
        assert_eq!(sum(&[tie[0], tie[1], [-tiny, tiny, tiny]]).significand, 0.5);
        // Two bits do so as well as one, whichever the higher is.
        for place in 54..300 {
            let two_bits = [[0.5f64.powi(place), 1.0, 1.0], [tiny; 3]];
            let above = sum(&[tie[0], tie[1], two_bits[0], two_bits[1]]);
            assert_eq!(above.significand, 0.5 + half_an_ulp, "{place}");
        }
    }
}
