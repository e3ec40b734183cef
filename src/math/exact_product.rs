//! The product of two floats without rounding: a fused multiply-add gives the error of the rounded product.

/// Whether `f64::mul_add` is certain to round only once. Where the processor may have no instruction for it, it is a
/// function of the C library. That of MinGW rounds the product and then the sum, and Microsoft's promises nothing.
const HAS_FUSED: bool = cfg!(any(target_feature = "fma", target_arch = "aarch64", not(windows)));

/// The product a b as the rounded product and its error, whose sum is exact unless one of them overflows or the error
/// underflows.
#[inline(always)]
pub fn exact_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    [product, if uses_fused() { a.mul_add(b, -product) } else { libm::fma(a, b, -product) }]
}

#[cfg(not(test))]
const fn uses_fused() -> bool {
    HAS_FUSED
}

#[cfg(test)]
thread_local! {
    /// Whether the test of this thread runs as on a system where `f64::mul_add` is not fused.
    static IS_WITHOUT_FUSED: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

#[cfg(test)]
fn uses_fused() -> bool {
    HAS_FUSED && !IS_WITHOUT_FUSED.get()
}

/// Runs a test on this system, and then as on one where `f64::mul_add` is not fused.
#[cfg(test)]
pub fn with_and_without_fused(mut test: impl FnMut()) {
    for is_without in [false, true] {
        IS_WITHOUT_FUSED.set(is_without);
        test();
    }
    IS_WITHOUT_FUSED.set(false);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::worst_case::Rng;

    /// A float as an integer times 2^(exponent - 1074).
    fn integer(x: f64) -> (i128, i32) {
        let field = (x.to_bits() >> 52 & 0x7ff) as i32;
        let fraction = (x.to_bits() & ((1 << 52) - 1)) as i128;
        let significand = if field == 0 { fraction } else { fraction | 1 << 52 };
        (if x < 0.0 { -significand } else { significand }, (field - 1).max(0))
    }

    /// Whether the two parts add up to a b, by whole numbers.
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
    fn two_million_products_and_their_errors_add_up() {
        with_and_without_fused(|| {
            let rng = &mut Rng(23);
            for _ in 0..1_000_000 {
                let scale = libm::ldexp(1.0, rng.below(600) as i32 - 300);
                let (a, b) = (rng.signed(), scale * rng.signed());
                let found = exact_product(a, b);
                assert!(is_exact(a, b, found), "{a:e} {b:e} {found:?}");
                assert_eq!(found[0], a * b);
            }
        });
    }

    #[test]
    fn products_of_extreme_factors_are_exact() {
        let (tiny, huge) = (f64::from_bits(1), f64::MAX);
        with_and_without_fused(|| {
            for (a, b) in [(huge, 1.0 / 3.0), (huge, 1e-300), (tiny, huge), (1e-140, 3e-150), (-0.0, huge)] {
                let found = exact_product(a, b);
                assert!(is_exact(a, b, found), "{a:e} {b:e} {found:?}");
            }
        });
        assert!(!is_exact(0.1, 0.1, [0.1 * 0.1, 0.0]));
    }
}
