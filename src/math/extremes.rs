//! Minima and maxima that compile to one instruction each. Unlike `f64::min` and `f64::max`, which avoid NaN, they
//! return their second argument if either one is NaN.

/// Returns the minimum of two, or the second if they are unordered or equal.
#[inline(always)]
pub fn min<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// Returns the maximum of two, or the second if they are unordered or equal.
#[inline(always)]
pub fn max<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// Returns the minimum of three.
#[inline(always)]
pub fn min3<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    min(min(a, b), c)
}

/// Returns the maximum of three.
#[inline(always)]
pub fn max3<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    max(max(a, b), c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extremes_are_found_in_every_order() {
        for numbers in [[1, 2, 3], [1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]] {
            assert_eq!((min3(numbers), max3(numbers)), (1, 3));
        }
        assert_eq!((min(1, 2), min(2, 1), max(1, 2), max(2, 1)), (1, 1, 2, 2));
    }

    /// The results equal those of the processor's instructions. Zeros of different sign are equal.
    #[test]
    fn the_second_argument_is_returned_when_neither_is_the_extreme() {
        for extreme in [min, max] {
            assert!(extreme(0.0, f64::NAN).is_nan() && extreme(f64::NAN, 0.0) == 0.0);
            assert!(extreme(0.0, -0.0).is_sign_negative() && extreme(-0.0, 0.0).is_sign_positive());
        }
    }
}
