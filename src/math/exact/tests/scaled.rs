use super::super::*;

#[test]
fn quotients_and_common_scaling_do_not_depend_on_the_exponents() {
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
