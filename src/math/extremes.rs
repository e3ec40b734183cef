//! The lesser and the greater of numbers, in one instruction each: unlike the library's, these have no
//! opinion on NaN, and give the second where either is one.

use glam::DVec3;

/// The lesser of two.
#[inline(always)]
pub fn min<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// The greater of two.
#[inline(always)]
pub fn max<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The least of three.
#[inline(always)]
pub fn min3<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    min(min(a, b), c)
}

/// The greatest of three.
#[inline(always)]
pub fn max3<T: PartialOrd>([a, b, c]: [T; 3]) -> T {
    max(max(a, b), c)
}

/// The corners of the box around three points.
#[inline(always)]
pub fn box_corners([a, b, c]: [DVec3; 3]) -> [DVec3; 2] {
    let axis = |axis: usize| [a[axis], b[axis], c[axis]];
    let (x, y, z) = (axis(0), axis(1), axis(2));
    [DVec3::new(min3(x), min3(y), min3(z)), DVec3::new(max3(x), max3(y), max3(z))]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_extremes_of_three_stand_in_any_place() {
        for numbers in [[1, 2, 3], [1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]] {
            assert_eq!((min3(numbers), max3(numbers)), (1, 3));
        }
        assert_eq!((min(1, 2), min(2, 1), max(1, 2), max(2, 1)), (1, 1, 2, 2));
    }

    /// As the processor's instructions do it: neither of two zeros is the lesser.
    #[test]
    fn the_second_is_given_where_neither_is_the_extreme() {
        for pick in [min, max] {
            assert!(pick(0.0, f64::NAN).is_nan() && pick(f64::NAN, 0.0) == 0.0);
            assert!(pick(0.0, -0.0).is_sign_negative() && pick(-0.0, 0.0).is_sign_positive());
        }
    }

    #[test]
    fn a_box_around_three_points_touches_the_outermost() {
        let points = [DVec3::new(1.0, 6.0, -7.0), DVec3::new(2.0, 5.0, 9.0), DVec3::new(3.0, 4.0, 8.0)];
        assert_eq!(box_corners(points), [DVec3::new(1.0, 4.0, -7.0), DVec3::new(3.0, 6.0, 9.0)]);
    }
}
