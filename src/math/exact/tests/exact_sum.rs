use super::super::*;

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
    // Two bits do so as well as one, whichever is the higher.
    for place in 54..300 {
        let two_bits = [[0.5f64.powi(place), 1.0, 1.0], [tiny; 3]];
        let above = sum(&[tie[0], tie[1], two_bits[0], two_bits[1]]);
        assert_eq!(above.significand, 0.5 + half_an_ulp, "{place}");
    }
}
