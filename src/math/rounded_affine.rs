//! Affine maps and points with bounds on their rounding errors.

use super::robust::{UNIT_ROUNDOFF, determinant_sign};
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Mul;

/// An affine map as it is computed, and how far the exact one may be from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundedAffine {
    /// The map as it is computed.
    pub map: DAffine3,
    /// The largest error of each of its numbers.
    pub error: DAffine3,
    /// The sign of its determinant, -1, 0 or 1. It is exact: the product of the signs of its factors' determinants.
    pub orientation: i32,
}

/// The error bound of each number of a product, in roundings of the same number of the product of absolute values: four
/// roundings for three products, two sums and the translation, and one for the bound's own arithmetic.
const PRODUCT_ROUNDINGS: f64 = 5.0;

/// The error bound of a computed coordinate of an image, in roundings of the sum of absolute values that it is computed
/// from: four for three products and three sums, and the rest for the numbers that an author writes, which are rounded,
/// too.
pub const IMAGE_ROUNDINGS: f64 = 16.0;

impl RoundedAffine {
    /// The identity.
    pub const IDENTITY: Self = Self { map: DAffine3::IDENTITY, error: DAffine3::ZERO, orientation: 1 };

    /// A map without errors.
    pub fn exact(map: DAffine3) -> Self {
        Self { map, error: DAffine3::ZERO, orientation: determinant_sign(map.matrix3) }
    }

    /// The error bound of the images of points whose errors along any axis are at most the first number, and the second
    /// one more for each unit of the sum of their coordinates' absolute values: along any axis, in the same form.
    pub fn image_error(&self, [at_origin, per_distance]: [f64; 2]) -> [f64; 2] {
        let (sizes, error) = (absolute(self.map), self.error);
        let rows = sizes.matrix3 * DVec3::ONE;
        let widest = rows.max_element();
        let rounding = IMAGE_ROUNDINGS * UNIT_ROUNDOFF;
        let of_translation = (error.translation + sizes.translation * rounding).max_element();
        let of_matrix =
            (error.matrix3 + sizes.matrix3 * rounding).to_cols_array().into_iter().fold(0.0, f64::max);
        [widest * at_origin + of_translation, widest * per_distance + of_matrix]
    }

    /// Whether all numbers of the map are finite.
    pub fn is_finite(&self) -> bool {
        self.map.is_finite()
    }
}

impl From<DAffine3> for RoundedAffine {
    fn from(map: DAffine3) -> Self {
        Self::exact(map)
    }
}

/// The composition: the right one acts first.
impl Mul for RoundedAffine {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        match (self == Self::IDENTITY, other == Self::IDENTITY) {
            (true, _) => other,
            (_, true) => self,
            _ => Self {
                map: self.map * other.map,
                error: product_error(self, other),
                orientation: self.orientation * other.orientation,
            },
        }
    }
}

/// The error bound of a product: |A| E + D |B| + D E for factors with the errors D and E, and the roundings.
fn product_error(one: RoundedAffine, other: RoundedAffine) -> DAffine3 {
    let (a, b, d, e) = (absolute(one.map), absolute(other.map), one.error, other.error);
    let linear = a.matrix3 * e.matrix3 + d.matrix3 * (b.matrix3 + e.matrix3);
    let translation = a.matrix3 * e.translation + d.matrix3 * (b.translation + e.translation) + d.translation;
    let (sizes, rounding) = (a * b, PRODUCT_ROUNDINGS * UNIT_ROUNDOFF);
    DAffine3 {
        matrix3: linear + sizes.matrix3 * rounding,
        translation: translation + sizes.translation * rounding,
    }
}

/// The map with the absolute value of each number.
pub fn absolute(map: DAffine3) -> DAffine3 {
    let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(x_axis.abs(), y_axis.abs(), z_axis.abs()),
        translation: map.translation.abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    /// A factor off an exact one by at most its error bound.
    fn factor(rng: &mut Rng) -> (RoundedAffine, Exact) {
        let scale = 2f64.powi((8.0 * rng.vector().x) as i32);
        let cols = [rng.vector(), rng.vector(), rng.vector()].map(|v| scale * v);
        let map = DAffine3 {
            matrix3: DMat3::from_cols(cols[0], cols[1], cols[2]),
            translation: 9.0 * rng.vector(),
        };
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
        let map = RoundedAffine::exact(DAffine3::from_scale(DVec3::new(0.1, -3.0, 7.0)));
        assert_eq!([RoundedAffine::IDENTITY * map, map * RoundedAffine::IDENTITY], [map; 2]);
        assert_eq!(map.error, DAffine3::ZERO);
        assert!((map * map).error.transform_point3(DVec3::ONE).min_element() > 0.0);
    }
}
