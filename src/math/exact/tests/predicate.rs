use super::super::*;
use crate::math::worst_case::Rng;

#[test]
fn coplanar_vectors_give_zero_and_nearly_coplanar_ones_a_sign() {
    let (p, q) = (DVec3::new(0.1, 0.7, -0.3), DVec3::new(1.3, 2.0 / 3.0, 0.9));
    // The expected sign follows from p . (beside x q) = (beside - p) . (q x p).
    let beside = p.with_z(p.z.next_up());
    let expected = if q.x * p.y - q.y * p.x > 0.0 { 1 } else { -1 };
    for scale in [2f64.powi(-1000), 1.0, 2f64.powi(1000)] {
        let [p, q, beside] = [p, q, beside].map(|v| scale * v);
        assert_eq!(projected_area(p, [DVec3::ZERO, p, q]), Scaled::ZERO);
        assert_eq!(volume(p, [DVec3::ZERO, p, q]), Scaled::ZERO);
        assert_eq!(projected_area(p, [DVec3::ZERO, beside, q]).sign(), expected);
    }
}

#[test]
fn products_that_agree_to_a_hundred_bits_are_told_apart() {
    let tiny = 2f64.powi(-60);
    let edge = |x: f64, y: f64| [DVec3::new(tiny, tiny, 0.0), DVec3::new(x, y, 0.0)];
    assert_eq!(cross_component(DVec3::splat(0.7), edge(0.1, 0.1), [0, 1]), Scaled::ZERO);
    assert_eq!(cross_component(DVec3::new(0.3, 0.1, 0.0), edge(0.3, 0.1), [0, 1]).sign(), -1);
}

/// Points whose differences are exact, and points where they are rounded or overflow.
#[test]
fn determinants_are_those_of_expanded_products() {
    let rng = &mut Rng(1);
    let mut exact = 0;
    for scale in [1.0, 1e-3, 2f64.powi(-1040), 1.5e308] {
        for digits in [2f64.powi(-20), 2f64.powi(-52), 0.0] {
            for _ in 0..100 {
                let mut point = || {
                    let v = rng.vector();
                    scale * if digits == 0.0 { v } else { (v / digits).round() * digits }
                };
                let (o, [a, b, c]) = (point(), [point(), point(), point()]);
                exact += [(a, o), (b, a), (c, a)]
                    .iter()
                    .filter(|(p, q)| exact_difference(*p, *q).is_some())
                    .count();
                let (mut area, mut six_volumes) = (ExactSum::default(), ExactSum::default());
                six_volumes.add_determinant([a, b, c]);
                for [p, q] in edges([a, b, c]) {
                    area.add_determinant([o, p, q]);
                    six_volumes.add_determinant([-o, p, q]);
                }
                assert_eq!(projected_area(o, [a, b, c]), area.value(), "{o} {a} {b} {c}");
                assert_eq!(volume(o, [a, b, c]), six_volumes.value(), "{o} {a} {b} {c}");
            }
        }
    }
    assert!((1000..2600).contains(&exact), "{exact} of 3600 differences are exact");
}

#[test]
fn volumes_and_area_vectors_are_those_of_whole_numbers() {
    let corners = [[2, -3, 5], [7, 11, -1], [-4, 6, 9]];
    let [a, b, c] = corners;
    for o in [[0, 0, 0], [1, 2, 3], [-5, 4, 8]] {
        let minus = |p: [i32; 3], q: [i32; 3]| [0, 1, 2].map(|i| p[i] - q[i]);
        let (p, q, r) = (minus(b, a), minus(c, a), minus(a, o));
        let area = [[1, 2], [2, 0], [0, 1]].map(|[i, j]| p[i] * q[j] - p[j] * q[i]);
        let expected: i32 = (0..3).map(|i| r[i] * area[i]).sum();
        let vector = |v: [i32; 3]| DVec3::from_array(v.map(f64::from));
        let one = Scaled { significand: 0.5, exponent: 1 };
        assert_eq!(volume(vector(o), corners.map(vector)).over(one), f64::from(expected), "{o:?}");
        let found = area_vector(corners.map(|p| vector(minus(p, o)))).map(|x| x.over(one));
        assert_eq!(found, area.map(f64::from), "{o:?}");
    }
}
