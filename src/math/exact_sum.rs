//! Sums of products of floats without rounding, overflow or underflow: in fixed point, with a place for every
//! bit that a product of three floats can have (Kulisch, "Computer Arithmetic and Validity", 2nd edition, de
//! Gruyter, 2013).
//!
//! Every finite float is a whole number below 2^53 times 2^(e - 1074), with e from 0 to 2045. So a product of
//! three is a whole number below 2^159 times 2^(e - 3222), with e from 0 to 6135: 6294 bits hold it, and 6400
//! bits the sum of more products than a program can add.

use super::scaled::Scaled;
use glam::DVec3;

/// An exact sum, as digits to the base 2^64, the least significant first. Carries are left in the digits
/// until the sum is asked for.
#[derive(Debug)]
pub struct ExactSum {
    digits: [i128; DIGITS],
    /// All digits before the first of these, and from the second on, are zero.
    used: [usize; 2],
}

/// One more than the bits need, below all others, so that every digit has one below it.
const DIGITS: usize = 1 + 6400 / 64;

/// The exponent of the last digit's last bit.
const LOWEST_EXPONENT: i32 = -3 * 1074 - 64;

/// A finite float taken apart: `significand * 2^(exponent - 1074)`, apart from the sign.
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

    /// Adds the determinant of the matrix with these finite rows, or columns.
    pub fn add_determinant(&mut self, [p, q, r]: [DVec3; 3]) {
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            self.add_product([p[i], q[j], r[k]]);
            self.add_product([-p[i], q[k], r[j]]);
        }
    }

    /// The sum, rounded to the nearest float of unbounded exponent. Its sign is exact, and it is zero only
    /// if the sum is.
    pub fn value(mut self) -> Scaled {
        let is_negative = self.carry() < 0;
        if is_negative {
            self.digits_in_use().iter_mut().for_each(|digit| *digit = -*digit);
            self.carry();
        }
        let Scaled { significand, exponent } = self.value_without_carries();
        Scaled { significand: if is_negative { -significand } else { significand }, exponent }
    }

    fn digits_in_use(&mut self) -> &mut [i128] {
        let [first, end] = self.used;
        self.digits.get_mut(first..end).unwrap_or_default()
    }

    /// Leaves digits from 0 to 2^64 - 1, and returns what is carried out of them: 0, or -1 for a negative sum,
    /// to which the digits then are the two's complement.
    fn carry(&mut self) -> i128 {
        self.digits_in_use().iter_mut().fold(0, |carried, digit| {
            let sum = *digit + carried;
            *digit = sum & i128::from(u64::MAX);
            sum >> 64
        })
    }

    /// The value of digits from 0 to 2^64 - 1.
    fn value_without_carries(&self) -> Scaled {
        let [first, end] = self.used;
        let Some(highest) = (first..end).rev().find(|&i| self.digits[i] != 0) else { return Scaled::ZERO };
        let two_digits = (self.digits[highest] as u128) << 64 | self.digits[highest - 1] as u128;
        // These are 65 bits or more, so that all bits below them only tell whether the sum lies above a tie.
        let has_more = self.digits[..highest - 1].iter().skip(first).any(|&digit| digit != 0);
        let (significand, exponent) = libm::frexp((two_digits | u128::from(has_more)) as f64);
        Scaled { significand, exponent: exponent + LOWEST_EXPONENT + 64 * (highest as i32 - 1) }
    }
}

/// The digits of a product of less than 256 bits, the least significant first.
fn product(a: u128, b: u128) -> [u64; 4] {
    let halves = |x: u128| [x as u64, (x >> 64) as u64].map(u128::from);
    let ([a_low, a_high], [b_low, b_high]) = (halves(a), halves(b));
    let [first, carried] = halves(a_low * b_low);
    let ([cross, cross_high], [other, other_high]) = (halves(a_low * b_high), halves(a_high * b_low));
    let [second, carried] = halves(carried + cross + other);
    let [third, fourth] = halves(a_high * b_high + carried + cross_high + other_high);
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
    fn a_product_keeps_its_value_and_sign() {
        assert_eq!(sum(&[[3.0, -0.5, 7.0]]), Scaled { significand: -10.5 / 16.0, exponent: 4 });
        assert_eq!(sum(&[]), Scaled::ZERO);
        assert_eq!(sum(&[[0.0, 1.0, 1.0], [-0.0, 5.0, 2.0]]), Scaled::ZERO);
    }

    #[test]
    fn the_smallest_and_the_largest_products_are_in_reach() {
        let (min3, most) = (f64::from_bits(1), f64::MAX);
        assert_eq!(sum(&[[min3; 3]]), Scaled { significand: 0.5, exponent: -3221 });
        assert_eq!(sum(&[[-most; 3]]), Scaled { significand: -1.0 + 3.0 * 0.5f64.powi(53), exponent: 3072 });
        let all = [[most; 3], [min3; 3], [-most, most, most], [min3, -min3, min3], [min3; 3]];
        assert_eq!(sum(&all), Scaled { significand: 0.5, exponent: -3221 });
    }

    #[test]
    fn many_large_products_carry_into_the_highest_digits() {
        let all = vec![[-f64::MAX; 3]; 1 << 12];
        assert_eq!(sum(&all).exponent, 3072 + 12);
    }

    #[test]
    fn a_bit_far_below_a_tie_decides_it() {
        let (half_an_ulp, tiny) = (0.5f64.powi(53), 0.5f64.powi(1000));
        let tie = [[1.0; 3], [half_an_ulp, 1.0, 1.0]];
        assert_eq!(sum(&tie).significand, 0.5);
        assert_eq!(sum(&[tie[0], tie[1], [tiny; 3]]).significand, 0.5 + half_an_ulp);
        assert_eq!(sum(&[tie[0], tie[1], [-tiny, tiny, tiny]]).significand, 0.5);
    }
}
