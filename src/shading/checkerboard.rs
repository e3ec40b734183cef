//! The cells of a checkerboard: unit cubes in the texture's space that alternate between two materials.

use crate::math::instructions::Level;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::rounded::{IMAGE_ROUNDINGS, RoundedAffine, RoundedPoint, absolute};
use crate::math::simd::ROUND_TO_INTEGER;
use fearless_simd::dispatch;
use glam::{DMat3, DVec3};

/// Returns true if a point is in a cell whose indices have an odd sum. Cells are half open: a boundary belongs to the
/// cell above it.
///
/// If a surface lies in a boundary, rounding would decide at random, in any precision, on which side each of its
/// points falls. So a coordinate within its error bound of a boundary counts as on the boundary. The bound covers the
/// errors of the point, of the map and of the coordinate itself (`proofs/checkerboard.g`).
#[inline(always)]
pub fn is_in_odd_cell(map: &RoundedAffine, point: &RoundedPoint, level: Level) -> bool {
    dispatch!(level, _simd => is_in_odd_cell_at(map, point))
}

#[inline(always)]
fn is_in_odd_cell_at(map: &RoundedAffine, point: &RoundedPoint) -> bool {
    let values = map.map.transform_point3(point.position);
    let below = values.floor();
    let to_next = below + 1.0 - values;
    let is_between = to_next.cmpge(DVec3::splat(point.boundary_width)).all();
    if !is_between || !below.abs().cmple(DVec3::splat(LARGEST_INDEX)).all() {
        return is_in_odd_cell_exactly(map, point);
    }
    let [x, y, z] = (below + ROUND_TO_INTEGER).to_array().map(f64::to_bits);
    (x ^ y ^ z) & 1 != 0
}

/// The largest index that [`ROUND_TO_INTEGER`] keeps.
const LARGEST_INDEX: f64 = (1u64 << 50) as f64;

/// Returns the result of [`is_in_odd_cell`] if a boundary may be close, or an index is beyond [`LARGEST_INDEX`] or NaN.
#[cold]
fn is_in_odd_cell_exactly(map: &RoundedAffine, point: &RoundedPoint) -> bool {
    let values = map.map.transform_point3(point.position);
    let error_bounds = error_bounds(map, point);
    let cell = |axis: usize| {
        let below = values[axis].floor();
        let is_on_next = below + 1.0 - values[axis] <= error_bounds[axis];
        (if is_on_next { below + 1.0 } else { below }).rem_euclid(2.0)
    };
    (cell(0) + cell(1) + cell(2)) % 2.0 == 1.0
}

/// Returns true if a point lies in a boundary within its error bounds.
pub fn is_in_boundary(map: &RoundedAffine, point: &RoundedPoint) -> bool {
    to_boundaries(map, point).cmple(error_bounds(map, point)).any()
}

/// Returns the distance of each coordinate from the nearest boundary, in units of its error bound.
pub fn error_bounds_to_boundary(map: &RoundedAffine, point: &RoundedPoint) -> DVec3 {
    to_boundaries(map, point) / error_bounds(map, point)
}

/// Returns the distance of each coordinate from the nearest boundary.
fn to_boundaries(map: &RoundedAffine, point: &RoundedPoint) -> DVec3 {
    let values = map.map.transform_point3(point.position);
    (values - values.round()).abs()
}

/// The error bound of a coordinate that depends on only one coordinate of the point, in place of [`IMAGE_ROUNDINGS`].
/// Only one product and one sum are rounded.
const ALONG_AXIS_ROUNDINGS: f64 = 4.0;

/// Returns the largest distances between a boundary and the computed coordinates of a point in it: the sum of the
/// errors of the map, of the point and of the coordinates themselves.
fn error_bounds(map: &RoundedAffine, point: &RoundedPoint) -> DVec3 {
    let (sizes, reach) = (absolute(map.map), point.position.abs());
    let of_map = map.error.transform_point3(reach);
    let of_point = sizes.matrix3 * (point.error)();
    roundings(sizes.matrix3.transpose()) * sizes.transform_point3(reach) + (of_map + of_point)
}

/// Returns the relative error bounds of the coordinates, as parts of the sums of absolute values that they are
/// computed from. `rows` are the absolute values of the map.
fn roundings(rows: DMat3) -> DVec3 {
    let of_row = |row: DVec3| {
        let is_along_axis = row.to_array().into_iter().filter(|&x| x != 0.0).count() <= 1;
        if is_along_axis { ALONG_AXIS_ROUNDINGS } else { IMAGE_ROUNDINGS }
    };
    UNIT_ROUNDOFF * DVec3::new(of_row(rows.x_axis), of_row(rows.y_axis), of_row(rows.z_axis))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::instructions;
    use glam::{DAffine3, DQuat};

    /// Returns the result of [`is_in_odd_cell`], one axis after the other.
    fn is_odd_by_axes(map: &DAffine3, point: DVec3, error: f64) -> bool {
        let (q, rows) = (map.transform_point3(point), map.matrix3.transpose());
        let cell = |axis: usize| {
            let (row, translation) = (rows.col(axis), map.translation[axis]);
            let is_rotated = row.to_array().into_iter().filter(|&x| x != 0.0).count() > 1;
            let roundings = if is_rotated { 16.0 } else { 4.0 };
            let bound = roundings * UNIT_ROUNDOFF * (row.abs().dot(point.abs()) + translation.abs())
                + error * row.abs().element_sum();
            let below = q[axis].floor();
            (if below + 1.0 - q[axis] <= bound { below + 1.0 } else { below }).rem_euclid(2.0)
        };
        (cell(0) + cell(1) + cell(2)) % 2.0 == 1.0
    }

    fn maps() -> Vec<DAffine3> {
        let rotation = DQuat::from_rotation_y(0.7);
        let mut sheared = DAffine3::IDENTITY;
        sheared.matrix3.x_axis.y = 1.0;
        vec![
            DAffine3::IDENTITY,
            DAffine3::from_translation(DVec3::new(8.0, -0.25, 1e5)),
            DAffine3::from_scale(DVec3::new(-0.5, 3.0, 1e-9)),
            DAffine3::from_quat(rotation),
            DAffine3::from_scale_rotation_translation(
                DVec3::splat(2.5),
                rotation,
                DVec3::new(0.5, -7.0, 3.0),
            ),
            DAffine3::from_mat3(DMat3::from_cols(DVec3::Y, DVec3::NEG_Z, DVec3::X)),
            DAffine3::from_mat3(DMat3::from_cols_array(&[0.1, 0.2, 0.3, -0.4, 0.5, -0.6, 0.7, 0.8, 0.9])),
            DAffine3::from_mat3(DMat3::ZERO),
            sheared,
        ]
    }

    /// Coordinates in cells, in boundaries, within a few roundings of them, and beyond the largest index.
    fn numbers() -> Vec<f64> {
        let mut numbers: Vec<f64> =
            [f64::NAN, f64::INFINITY, 1e300, 1e17 + 16.0, 0.3, 0.7, 1e-300, 5e-324].into();
        for boundary in [0.0, 1.0, 2.0, 5.0, 1e6, 2f64.powi(31), 2f64.powi(31) - 1.0, 2f64.powi(53)] {
            let steps = [0u64, 1, 2, 3, 4, 5, 7, 8, 9, 12, 15, 16, 17, 20, 40];
            let below = |step| f64::from_bits(boundary.to_bits().saturating_sub(step));
            numbers.extend(
                steps.into_iter().flat_map(|step| [below(step), f64::from_bits(boundary.to_bits() + step)]),
            );
        }
        numbers.extend(numbers.clone().into_iter().map(|x| -x));
        numbers
    }

    #[test]
    fn the_axes_side_by_side_find_the_cells_of_one_axis_after_the_other() {
        let numbers = numbers();
        let number = |i: usize| numbers[i % numbers.len()];
        let mut counts = [0; 2];
        for (map, error) in maps().into_iter().flat_map(|map| [(map, 0.0), (map, 1e-9)]) {
            let [at_origin, per_distance] = RoundedAffine::from(map).image_error([error, 0.0]);
            let back = map.inverse();
            for i in 0..30 * numbers.len() {
                let point = DVec3::new(number(i), number(i * 7 + 3), number(i * 31 + i / 97));
                // Points that lie in boundaries after a rotation, too.
                for point in [point, back.transform_point3(point)] {
                    let expected = is_odd_by_axes(&map, point, error);
                    let width = at_origin + per_distance * point.abs().element_sum();
                    for (level, width) in
                        instructions::available().into_iter().flat_map(|i| [(i, width), (i, f64::INFINITY)])
                    {
                        let point = RoundedPoint {
                            position: point,
                            error: &|| DVec3::splat(error),
                            boundary_width: width,
                        };
                        let found = is_in_odd_cell(&map.into(), &point, level);
                        assert_eq!(found, expected, "{} {map} {level:?} {width}", point.position);
                    }
                    counts[usize::from(expected)] += 1;
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 10_000), "{counts:?}");
    }

    #[test]
    fn a_point_is_in_a_boundary_where_a_coordinate_is_within_roundings_of_an_integer() {
        let is_in_boundary = |map: DAffine3, y| is_in_boundary(&map.into(), &DVec3::new(0.5, y, 0.3).into());
        let moved = DAffine3::from_translation(DVec3::Y * 8.0);
        for (map, y, roundings, expected) in [
            (DAffine3::IDENTITY, 3.0, 8.0, true),
            (DAffine3::IDENTITY, 3.0, 16.0, false),
            (moved, -5.0, 48.0, true),
            (moved, -5.0, 56.0, false),
            (DAffine3::IDENTITY, 0.0, 0.0, true),
        ] {
            for sign in [1.0, -1.0] {
                assert_eq!(
                    is_in_boundary(map, y + sign * roundings * UNIT_ROUNDOFF),
                    expected,
                    "{y} {roundings}"
                );
            }
        }
    }
}
