//! Exact arithmetic: sums of products of floats without rounding, overflow or underflow, and geometric predicates that
//! use them.
//!
//! A sum is a fixed-point accumulator that is wide enough for every bit of a product of three floats (Kulisch,
//! "Computer Arithmetic and Validity", 2nd edition, de Gruyter, 2013). Every finite float is an integer below 2^53
//! times 2^(e - 1074), with e from 0 to 2045. Hence a product of three floats is an integer below 2^159 times 2^(e -
//! 3222), with e from 0 to 6135. It fits into 6294 bits, and 6400 bits hold the sum of more products than a program can
//! add.
//!
//! The predicates are the determinants that decide if and where a ray meets a triangle. They are computed from the
//! given coordinates and rounded only once, at the end, so they are correct for all finite floats. The triangle test
//! calls them if its own error bound does not decide. Differences of points may be rounded, and may overflow. In that
//! case products are expanded instead: (p - o) x (q - o) = p x q + q x o + o x p.

use super::double_double::Dd;
use glam::DVec3;

/// The number `significand * 2^exponent`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaled {
    /// Zero, or with an absolute value from 0.5 to 1.
    pub significand: f64,
    /// The exponent of two.
    pub exponent: i32,
}

impl Scaled {
    /// Zero. Its exponent is below the exponents of all other numbers.
    pub const ZERO: Self = Self { significand: 0.0, exponent: i32::MIN / 2 };

    /// Returns the sign: -1, 0 or 1.
    pub fn sign(self) -> i32 {
        (self.significand > 0.0) as i32 - (self.significand < 0.0) as i32
    }

    /// Returns the absolute value in a form that can be compared.
    pub fn magnitude(self) -> (i32, f64) {
        (self.exponent, self.significand.abs())
    }

    /// Returns the number with the largest absolute value.
    pub fn largest(numbers: [Self; 3]) -> Self {
        let larger = |one: Self, other: Self| if other.magnitude() > one.magnitude() { other } else { one };
        numbers.into_iter().fold(Self::ZERO, larger)
    }

    /// Returns the quotient as an ordinary float: infinite if it overflows, NaN if both are zero.
    pub fn over(self, divisor: Self) -> f64 {
        libm::ldexp(self.significand / divisor.significand, self.exponent - divisor.exponent)
    }
}

/// Returns the numbers divided by a common power of two, such that the largest absolute value is from 0.5 to 1.
pub fn on_one_scale(numbers: [Scaled; 3]) -> [f64; 3] {
    let largest = Scaled::largest(numbers).exponent;
    numbers.map(|number| libm::ldexp(number.significand, number.exponent - largest))
}

/// An exact sum as digits in base 2^64, the least significant first. A digit may temporarily be negative or
/// exceed 64 bits: carries are propagated only when the value is read.
#[derive(Debug)]
pub struct ExactSum {
    digits: [i128; DIGITS],
    /// The first digit in use and the end of the digits in use; all others are zero.
    used: [usize; 2],
}

/// The number of digits: one more than the bits need, below all others, so that every digit in use has a lower
/// neighbour.
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

    /// Returns the sum, rounded to the nearest float of unbounded exponent. Its sign is exact, and it is zero only if
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

    /// Propagates carries, so that every digit is from 0 to 2^64 - 1. Returns the carry out of the highest digit: 0, or
    /// -1 for a negative sum, which the digits then hold in two's complement.
    fn carry(&mut self) -> i128 {
        self.digits_in_use().iter_mut().fold(0, |carry, digit| {
            let sum = *digit + carry;
            *digit = sum & i128::from(u64::MAX);
            sum >> 64
        })
    }

    /// Returns the value after carries have been propagated, for a sum that is not negative.
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

/// Returns the product of two 128-bit integers as digits in base 2^64, the least significant first. The product must be
/// less than 2^256.
fn product(a: u128, b: u128) -> [u64; 4] {
    let halves = |x: u128| [x as u64, (x >> 64) as u64].map(u128::from);
    let ([a_low, a_high], [b_low, b_high]) = (halves(a), halves(b));
    let [first, carry] = halves(a_low * b_low);
    let ([lh_low, lh_high], [hl_low, hl_high]) = (halves(a_low * b_high), halves(a_high * b_low));
    let [second, carry] = halves(carry + lh_low + hl_low);
    let [third, fourth] = halves(a_high * b_high + carry + lh_high + hl_high);
    [first, second, third, fourth].map(|digit| digit as u64)
}

/// Returns the edges of a triangle, each opposite to the vertex of the same index.
fn edges<T: Copy>([a, b, c]: [T; 3]) -> [[T; 2]; 3] {
    [[b, c], [c, a], [a, b]]
}

/// Returns the edge functions `d . ((p - o) x (q - o))` of a ray from `o` along `d`, where the edge from p to q is
/// opposite to each vertex in turn.
pub fn edge_functions(o: DVec3, d: DVec3, triangle: [DVec3; 3]) -> [Scaled; 3] {
    edges(triangle).map(|[p, q]| projected_area(d, [o, p, q]))
}

/// Returns the difference of two points, if no coordinate of it is rounded. It is not rounded for points close to each
/// other, unless they are close to zero (Sterbenz, "Floating-Point Computation", Prentice-Hall 1974).
fn exact_difference(a: DVec3, b: DVec3) -> Option<DVec3> {
    let is_exact = (0..3).all(|axis| Dd::difference(a[axis], b[axis]).parts()[0] == 0.0);
    is_exact.then_some(a - b)
}

/// Returns `d . ((b - a) x (c - a))`: twice the signed area of a triangle projected along `d`, times the length of `d`.
pub fn projected_area(d: DVec3, triangle: [DVec3; 3]) -> Scaled {
    let [a, b, c] = triangle;
    let mut sum = ExactSum::default();
    match (exact_difference(b, a), exact_difference(c, a)) {
        (Some(p), Some(q)) => sum.add_determinant([d, p, q]),
        _ => edges(triangle).into_iter().for_each(|[p, q]| sum.add_determinant([d, p, q])),
    }
    sum.value()
}

/// Returns `(a - o) . ((b - a) x (c - a))`: six times the signed volume of the tetrahedron of a point and a triangle.
pub fn volume(o: DVec3, triangle: [DVec3; 3]) -> Scaled {
    let [a, b, c] = triangle;
    let mut sum = ExactSum::default();
    match (exact_difference(a, o), exact_difference(b, a), exact_difference(c, a)) {
        (Some(r), Some(p), Some(q)) => sum.add_determinant([r, p, q]),
        _ => {
            sum.add_determinant(triangle);
            edges(triangle).into_iter().for_each(|[p, q]| sum.add_determinant([-o, p, q]));
        }
    }
    sum.value()
}

/// Returns `(b - a) x (c - a)`: the normal of a triangle, whose length is twice the triangle's area.
pub fn area_vector(triangle: [DVec3; 3]) -> [Scaled; 3] {
    [[1, 2], [2, 0], [0, 1]].map(|[i, j]| {
        let mut sum = ExactSum::default();
        for [p, q] in edges(triangle) {
            sum.add_product([p[i], q[j], 1.0]);
            sum.add_product([-p[j], q[i], 1.0]);
        }
        sum.value()
    })
}

/// Returns one component of a cross product, `d[i] * (q - p)[j] - d[j] * (q - p)[i]`.
pub fn cross_component(d: DVec3, [p, q]: [DVec3; 2], [i, j]: [usize; 2]) -> Scaled {
    let mut sum = ExactSum::default();
    for (point, sign) in [(q, 1.0), (p, -1.0)] {
        sum.add_product([sign, d[i], point[j]]);
        sum.add_product([-sign, d[j], point[i]]);
    }
    sum.value()
}

#[cfg(test)]
mod tests;
