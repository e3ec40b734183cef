use super::super::*;
use num_rational::BigRational;
use num_traits::Signed;

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}

fn exact_sum(x: Dd) -> BigRational {
    exact(x.high) + exact(x.low)
}

/// Returns a number from an even distribution in [-0.5, 0.5), with all bits of the significand in use.
fn sample(i: u32, step: f64) -> f64 {
    (i as f64 * step).fract() - 0.5
}

/// Returns numbers of both signs and of magnitudes from 2^-20 to 2^20, with all bits of both parts in use.
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
    for (x, y) in sums().zip(sums().skip(7)) {
        let (exact_x, exact_y) = (exact_sum(x), exact_sum(y));
        assert_accurate(x + y, &exact_x + &exact_y, "sum");
        assert_accurate(x - y, &exact_x - &exact_y, "difference");
        assert_accurate(x * y, &exact_x * &exact_y, "product");
        assert_accurate(x / y, &exact_x / &exact_y, "quotient");
    }
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
