use super::super::*;
use crate::math::worst_case::Rng;
use num_rational::BigRational;
use num_traits::{Signed, Zero};

type Exact = [[BigRational; 4]; 3];

fn exact(x: f64) -> BigRational {
    BigRational::from_float(x).unwrap()
}

fn rows(map: DAffine3) -> [[f64; 4]; 3] {
    let [a, b, c, t] = [map.matrix3.x_axis, map.matrix3.y_axis, map.matrix3.z_axis, map.translation];
    [0, 1, 2].map(|i| [a[i], b[i], c[i], t[i]])
}

fn product(one: &Exact, other: &Exact) -> Exact {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let sum = (0..3).map(|k| &one[i][k] * &other[k][j]).sum::<BigRational>();
            if j == 3 { sum + &one[i][3] } else { sum }
        })
    })
}

/// Returns a factor that differs from an exact one by at most its error bound.
fn factor(rng: &mut Rng) -> (RoundedAffine, Exact) {
    let scale = 2f64.powi((8.0 * rng.vector().x) as i32);
    let cols = [rng.vector(), rng.vector(), rng.vector()].map(|v| scale * v);
    let map =
        DAffine3 { matrix3: DMat3::from_cols(cols[0], cols[1], cols[2]), translation: 9.0 * rng.vector() };
    let error =
        DAffine3 { matrix3: absolute(map).matrix3 * 1e-15, translation: map.translation.abs() * 1e-15 };
    let off = rng.vector().x;
    let exact = rows(map).map(|row| row.map(|x| exact(x) + exact(1e-15 * off) * exact(x.abs())));
    (RoundedAffine { error, ..map.into() }, exact)
}

#[test]
fn the_exact_product_is_within_the_error_bound() {
    let rng = &mut Rng(7);
    let mut largest_part = 0.0f64;
    for _ in 0..300 {
        let (mut found, mut expected) = factor(rng);
        for _ in 0..1 + rng.below(5) {
            let (next, exact_next) = factor(rng);
            found = found * next;
            expected = product(&expected, &exact_next);
        }
        for (i, j) in (0..3).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let error = (exact(rows(found.map)[i][j]) - &expected[i][j]).abs();
            let bound = exact(rows(found.error)[i][j]);
            assert!(error <= bound, "{i} {j}");
            let part = if bound.is_zero() {
                0.0
            } else {
                num_traits::ToPrimitive::to_f64(&(error / bound)).unwrap()
            };
            largest_part = largest_part.max(part);
        }
    }
    assert!(largest_part > 0.2, "the bound is {} times too wide", 1.0 / largest_part);
}

#[test]
fn the_identity_adds_no_error() {
    let map = RoundedAffine::from(DAffine3::from_scale(DVec3::new(0.1, -3.0, 7.0)));
    assert_eq!([RoundedAffine::IDENTITY * map, map * RoundedAffine::IDENTITY], [map; 2]);
    assert_eq!(map.error, DAffine3::ZERO);
    assert!((map * map).error.transform_point3(DVec3::ONE).min_element() > 0.0);
}
