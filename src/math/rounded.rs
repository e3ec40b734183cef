//! Affine maps and points of surfaces with bounds on their rounding errors.

use super::robust::{UNIT_ROUNDOFF, determinant_sign};
use glam::{DAffine3, DMat3, DVec3};
use std::ops::Mul;

/// An affine map as computed, with a bound on its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoundedAffine {
    /// The map as computed.
    pub map: DAffine3,
    /// The largest error of each of its numbers.
    pub error: DAffine3,
    /// The exact sign of the map's determinant: -1, 0 or 1. It is the product of the signs of its factors'
    /// determinants.
    pub orientation: i32,
}

/// The error bound of each number of a product, in roundings of the same number of the product of absolute values: four
/// roundings for three products, two sums and the translation, and one for the bound's own arithmetic.
const PRODUCT_ROUNDINGS: f64 = 5.0;

/// The error bound of a computed coordinate of an image, in roundings of the sum of absolute values from which it is
/// computed: four for three products and three sums, and the rest for the rounded numbers that an author writes.
pub const IMAGE_ROUNDINGS: f64 = 16.0;

impl RoundedAffine {
    /// The identity.
    pub const IDENTITY: Self = Self { map: DAffine3::IDENTITY, error: DAffine3::ZERO, orientation: 1 };

    /// Returns the error bound of the images of points. Both bounds apply along any axis and have two parts:
    /// `at_origin`, and `per_distance` for each unit of the sum of the coordinates' absolute values.
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

    /// Returns true if all numbers of the map are finite.
    pub fn is_finite(&self) -> bool {
        self.map.is_finite()
    }
}

/// Converts a map without errors.
impl From<DAffine3> for RoundedAffine {
    fn from(map: DAffine3) -> Self {
        Self { map, error: DAffine3::ZERO, orientation: determinant_sign(map.matrix3) }
    }
}

/// Composes two maps; the right one is applied first.
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

/// Returns the error bound of a product: |A| E + D |B| + D E for factors with the errors D and E, and the roundings.
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

/// Returns the map with the absolute value of each number.
pub fn absolute(map: DAffine3) -> DAffine3 {
    let DMat3 { x_axis, y_axis, z_axis } = map.matrix3;
    DAffine3 {
        matrix3: DMat3::from_cols(x_axis.abs(), y_axis.abs(), z_axis.abs()),
        translation: map.translation.abs(),
    }
}

/// A point of a surface as computed, with a bound on its error.
#[derive(Clone, Copy)]
pub struct RoundedPoint<'a> {
    /// The point as computed.
    pub position: DVec3,
    /// Computes the largest distance along each axis between the point and the surface that the scene describes.
    pub error: &'a dyn Fn() -> DVec3,
    /// The width of the boundaries of checkerboards. A point farther from a boundary, in the space of a checkerboard,
    /// is certainly on its side of the boundary.
    pub boundary_width: f64,
}

/// Converts a point that lies exactly on its surface.
impl From<DVec3> for RoundedPoint<'_> {
    fn from(position: DVec3) -> Self {
        Self { position, error: &|| DVec3::ZERO, boundary_width: f64::INFINITY }
    }
}

#[cfg(test)]
mod tests;
