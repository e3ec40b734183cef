use super::super::*;
use crate::math::worst_case::Rng;

/// Returns a float as an integer and an exponent: the integer times 2^(exponent - 1074).
fn integer(x: f64) -> (i128, i32) {
    let field = (x.to_bits() >> 52 & 0x7ff) as i32;
    let fraction = (x.to_bits() & ((1 << 52) - 1)) as i128;
    let significand = if field == 0 { fraction } else { fraction | 1 << 52 };
    (if x < 0.0 { -significand } else { significand }, (field - 1).max(0))
}

/// Returns true if the two parts add up to a b, in integer arithmetic.
fn is_exact(a: f64, b: f64, [product, error]: [f64; 2]) -> bool {
    let ((a, i), (b, j)) = (integer(a), integer(b));
    // All are multiples of the last bits of a and b.
    let unit = i + j - 1074;
    let multiple = |x: f64| {
        let (significand, exponent) = integer(x);
        match exponent - unit {
            _ if significand == 0 => 0,
            shift if shift < 0 => significand >> -shift,
            shift => significand << shift,
        }
    };
    let is_whole = |x: f64| x == 0.0 || integer(x).0.trailing_zeros() as i32 >= unit - integer(x).1;
    is_whole(product) && is_whole(error) && multiple(product) + multiple(error) == a * b
}

#[test]
fn a_million_products_and_their_errors_add_up() {
    let rng = &mut Rng(23);
    for _ in 0..1_000_000 {
        let scale = libm::ldexp(1.0, rng.below(600) as i32 - 300);
        let (a, b) = (rng.signed(), scale * rng.signed());
        let found = exact_product(a, b);
        assert!(is_exact(a, b, found), "{a:e} {b:e} {found:?}");
        assert_eq!(found[0], a * b);
    }
}

#[test]
fn products_of_extreme_factors_are_exact() {
    let (tiny, huge) = (f64::from_bits(1), f64::MAX);
    for (a, b) in [(huge, 1.0 / 3.0), (huge, 1e-300), (tiny, huge), (1e-140, 3e-150), (-0.0, huge)] {
        let found = exact_product(a, b);
        assert!(is_exact(a, b, found), "{a:e} {b:e} {found:?}");
    }
    assert!(!is_exact(0.1, 0.1, [0.1 * 0.1, 0.0]));
}
