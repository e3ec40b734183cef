//! Arithmetic whose error is bounded, and the offsets that follow from the bounds.

use super::double_double::{Dd, dot};
use glam::{DAffine3, DMat3, DVec3};

/// The largest relative error of one rounded f64 operation, 2^-53.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// How far a secondary ray starts from the surface it leaves, in roundings of the numbers around.
const OFFSET_ROUNDINGS: f64 = 32.0;

/// Where a secondary ray along the unit vector `direction` starts, so that it neither meets the
/// surface it leaves nor skips what stands close by.
///
/// A point computed on a surface is off it by a few roundings of its coordinates and of those of
/// the primitives around it, the largest of which is `max_abs_coord`. `OFFSET_ROUNDINGS` cover both that error
/// and the intersection test's own (`proofs/offset.g`): measured 0 false and 0 missed shadows at scales 1e-6 to 1e6.
///
/// The point moves that far from the surface along the direction, so that it stays on its line and
/// a path's error does not grow with its bounces; along the normal where that would be a long way.
pub fn offset_origin(point: DVec3, unit_normal: DVec3, direction: DVec3, max_abs_coord: f64) -> DVec3 {
    const STEEP: f64 = 0.25;
    let distance = OFFSET_ROUNDINGS * UNIT_ROUNDOFF * (point.abs().max_element() + max_abs_coord);
    let slope = direction.dot(unit_normal);
    if slope.abs() > STEEP {
        return point + (distance / slope.abs()) * direction;
    }
    let side = if slope < 0.0 { -distance } else { distance };
    point + side * unit_normal
}

/// `v` scaled to unit length, also where the square of its length is not representable; NaN for a
/// vector without a direction.
pub fn unit(v: DVec3) -> DVec3 {
    const REPRESENTABLE: std::ops::Range<f64> = 1e-290..1e290;
    if REPRESENTABLE.contains(&v.length_squared()) { v.normalize() } else { unit_of_extreme(v) }
}

#[cold]
fn unit_of_extreme(v: DVec3) -> DVec3 {
    rescaled(v).normalize()
}

/// A point under an affine map, each coordinate rounded but once. In plain arithmetic it may be off by
/// seven roundings of the longest vector on its way.
pub fn transformed(map: &DAffine3, point: DVec3) -> DVec3 {
    let (rows, point) = (map.matrix3.transpose(), point.to_array().map(Dd::from));
    let coordinate =
        |row: DVec3, shift: f64| (dot(row.to_array().map(Dd::from), point) + shift.into()).value();
    let DVec3 { x, y, z } = map.translation;
    DVec3::new(coordinate(rows.x_axis, x), coordinate(rows.y_axis, y), coordinate(rows.z_axis, z))
}

/// `v` scaled by a power of two, which rounds nothing, so that its largest coordinate is about 1; and
/// the exponent of what it was scaled by. Zero stays as it is.
fn scaled_to_unit(v: DVec3) -> (DVec3, i32) {
    let exponent = libm::frexp(v.abs().max_element()).1;
    (DVec3::from_array(v.to_array().map(|x| libm::ldexp(x, -exponent))), -exponent)
}

/// `v` scaled by a power of two so that no product of its coordinates leaves the range of numbers.
pub fn rescaled(v: DVec3) -> DVec3 {
    scaled_to_unit(v).0
}

/// The matrix with each column scaled by a power of two of its own, and their exponents. This changes
/// neither a determinant's sign nor its share of Hadamard's bound, and keeps products in range.
fn with_unit_columns(m: DMat3) -> (DMat3, [i32; 3]) {
    let [(x, i), (y, j), (z, k)] = [m.x_axis, m.y_axis, m.z_axis].map(scaled_to_unit);
    (DMat3::from_cols(x, y, z), [i, j, k])
}

/// The image of a plane's normal under a matrix that is not singular, outward as before; of any length.
///
/// It is the cofactor matrix, the inverse transpose times the determinant, that maps normals. A factor of
/// a column is one over that factor of the normal's coordinate.
pub fn transformed_normal(m: DMat3, normal: DVec3) -> DVec3 {
    let (m, exponents) = with_unit_columns(m);
    let largest = exponents.into_iter().max().unwrap_or(0);
    let normal = rescaled(normal);
    let shrunk: [f64; 3] = std::array::from_fn(|i| libm::ldexp(normal[i], exponents[i] - largest));
    cofactor(m) * DVec3::from_array(shrunk) * m.determinant().signum()
}

/// The cofactor matrix: the inverse transpose times the determinant. It maps normals, and unlike
/// the inverse transpose it stays finite when the matrix is singular.
fn cofactor(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// Whether a matrix turns a left hand into a right one.
pub fn is_mirroring(m: DMat3) -> bool {
    with_unit_columns(m).0.determinant() < 0.0
}

/// The factor by which a matrix scales every length, if it does so within rounding.
pub fn similarity_scale(m: DMat3) -> Option<f64> {
    let largest = m.to_cols_array().into_iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let exponent = libm::frexp(largest).1;
    let m = DMat3::from_cols_array(&m.to_cols_array().map(|x| libm::ldexp(x, -exponent)));
    let square = m.x_axis.length_squared();
    let gram = m.transpose() * m;
    let off = (gram - DMat3::from_diagonal(DVec3::splat(square))).to_cols_array();
    off.iter().all(|x| x.abs() <= 1e-12 * square).then(|| libm::ldexp(square.sqrt(), exponent))
}

/// Whether the determinant is zero up to its rounding and that of the matrix' own entries.
///
/// The determinant is compared with the largest that columns, or rows, of these lengths allow
/// (Hadamard's bound), so a matrix that only scales, however little, is never taken for singular. The
/// computed one is off by at most [`DETERMINANT_ROUNDINGS`] of that bound, as
/// `proofs/determinant.g` proves; the rest is for [`ENTRY_ROUNDINGS`] of the entries.
pub fn is_singular(m: DMat3) -> bool {
    is_singular_by_columns(m) && is_singular_by_columns(m.transpose())
}

/// The share of Hadamard's bound, in roundings, up to which a determinant counts as zero.
pub const SINGULAR_ROUNDINGS: f64 = 16.0;

/// How far a computed determinant may be off, in roundings of Hadamard's bound.
pub const DETERMINANT_ROUNDINGS: f64 = 6.0;

/// How far all entries of a matrix may be off, in roundings of each, so that one with a determinant of zero is
/// still taken for singular.
pub const ENTRY_ROUNDINGS: f64 = 2.5;

fn is_singular_by_columns(m: DMat3) -> bool {
    let (m, _) = with_unit_columns(m);
    let allowed = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let determinant = m.determinant().abs();
    determinant.is_nan() || allowed.is_nan() || determinant <= SINGULAR_ROUNDINGS * UNIT_ROUNDOFF * allowed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offset_goes_to_the_side_the_ray_leaves_by() {
        let p = DVec3::new(1.0, 2.0, 3.0);
        let up = offset_origin(p, DVec3::Y, DVec3::new(1.0, 1e-9, 0.0), 4.0);
        let down = offset_origin(p, DVec3::Y, DVec3::new(1.0, -1e-9, 0.0), 4.0);
        assert!(up.y > p.y && down.y < p.y);
        assert!((up.y - p.y) < 1e-13);
        let steep = offset_origin(p, DVec3::Y, DVec3::new(0.6, -0.8, 0.0), 4.0);
        assert!(steep.y < p.y && (steep.y - p.y) > -1e-13 && steep.x > p.x);
    }

    #[test]
    fn every_vector_has_its_direction() {
        let v = DVec3::new(3.0, 0.0, -4.0);
        for scale in [1e-320, 1e-200, 1e-100, 1.0, 1e200, 1e307] {
            assert!((unit(scale * v) - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-3, "{scale}");
        }
        assert!(unit(DVec3::ZERO).is_nan() && unit(DVec3::INFINITY).is_nan());
    }

    #[test]
    fn cofactor_is_the_inverse_transpose_times_the_determinant() {
        let m = DMat3::from_cols_array(&[2.0, 1.0, 0.5, -1.0, 3.0, 0.25, 0.0, 1.0, 4.0]);
        let expected = m.inverse().transpose() * m.determinant();
        assert!(cofactor(m).abs_diff_eq(expected, 1e-12));
    }

    #[test]
    fn normals_and_scales_are_right_at_any_scale() {
        let r = DMat3::from_cols_array(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        let uneven = DMat3::from_diagonal(DVec3::new(1.0, 4.0, -2.0));
        let expected = unit(transformed_normal(r * uneven, DVec3::ONE));
        for exponent in [-1000, -500, 0, 500, 1000] {
            let far = libm::ldexp(1.0, exponent);
            assert_eq!(unit(transformed_normal(r * uneven * far, DVec3::ONE)), expected);
            assert!(is_mirroring(uneven * far) && !is_mirroring(uneven * -far));
            assert_eq!(similarity_scale(r * far), similarity_scale(r).map(|scale| scale * far));
        }
        assert_eq!(similarity_scale(uneven), None);
        let flat = DMat3::from_diagonal(DVec3::new(1.0, 1e-250, 1e-250));
        assert_eq!(unit(transformed_normal(flat, DVec3::X)), DVec3::X);
    }

    #[test]
    fn only_truly_singular_matrices_are_singular() {
        let r = DMat3::from_cols_array(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        let scale = |s: f64| DMat3::from_diagonal(DVec3::new(1.0, s, 1.0));
        assert!(!is_singular(scale(1e-30)));
        assert!(!is_singular(r * scale(1e-30)));
        for far in [1e-300, 1e-160, 1e-110, 1e103, 1e160, 1e300] {
            assert!(!is_singular(r * far) && !is_singular(r * scale(far)) && !is_singular(scale(far) * r));
        }
        assert!(is_singular(scale(0.0)));
        assert!(is_singular(r * scale(0.0) * r));
        assert!(is_singular(DMat3::NAN));
    }

    #[test]
    fn an_offset_leaves_the_surface_by_its_roundings_on_every_way() {
        for far in [1.0, 1e6] {
            let (p, max_abs_coord) = (far * DVec3::new(1.0, 2.0, -3.0), far * 4.0);
            let expected = OFFSET_ROUNDINGS * UNIT_ROUNDOFF * far * (3.0 + 4.0);
            for slope in [1.0, 0.6, 0.3, 0.2, 1e-9, -1e-9, -0.2, -0.3, -0.6, -1.0] {
                let direction = DVec3::new(f64::sqrt(1.0 - slope * slope), slope, 0.0);
                let off = offset_origin(p, DVec3::Y, direction, max_abs_coord) - p;
                let away = off.y * slope.signum();
                assert!((away / expected - 1.0).abs() < 0.1, "{far} {slope}: {away} {expected}");
                // Along the direction, so that the ray stays on its line, unless that is a long way.
                let aside = if slope.abs() > 0.25 { away * direction.x / slope.abs() } else { 0.0 };
                assert!((off.x - aside).abs() < 0.1 * expected && off.z == 0.0, "{far} {slope}: {off}");
            }
        }
    }

    #[test]
    fn a_transformed_point_is_rounded_but_once() {
        // The large terms cancel, and plain sums in any order lose some of the small ones.
        let linear = DMat3::from_cols_array(&[1e17, 1.0, 0.5, 3.0, 1e17, -1e16, -1e17, -1e17, 1e16]);
        let map = DAffine3 { matrix3: linear, translation: DVec3::new(7.0, 0.25, -2.0) };
        let exact = |row: DVec3, shift: f64| {
            let to_i32 = |x: f64| (x * 4.0) as i128;
            (to_i32(row.x) + to_i32(row.y) + to_i32(row.z) + to_i32(shift)) as f64 / 4.0
        };
        let rows = map.matrix3.transpose();
        let expected =
            [(rows.x_axis, 7.0), (rows.y_axis, 0.25), (rows.z_axis, -2.0)].map(|(r, s)| exact(r, s));
        assert_eq!(transformed(&map, DVec3::ONE).to_array(), expected);
    }

    #[test]
    fn a_transformed_normal_stands_upright_on_the_transformed_surface() {
        let r = DMat3::from_cols_array(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        let normal = DVec3::new(1.0, -2.0, 0.5);
        for scale in
            [DVec3::ONE, DVec3::new(1.0, 4.0, -2.0), DVec3::new(64.0, 0.125, 1.0), DVec3::new(-3.0, 1e3, 7.0)]
        {
            let m = r * DMat3::from_diagonal(scale) * r.transpose();
            let there = unit(transformed_normal(m, normal));
            for tangent in [DVec3::new(2.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 4.0)] {
                assert!(there.dot(unit(m * tangent)).abs() < 1e-12, "{scale}");
            }
            assert!(there.dot(m * normal) > 0.0, "{scale}");
        }
    }

    #[test]
    fn only_similarities_have_a_scale() {
        let r = DMat3::from_cols_array(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        for scale in [1e-200, 0.3, 1.0, 5.0, 1e200] {
            for m in [r, r.transpose(), -r, DMat3::IDENTITY] {
                let found = similarity_scale(m * scale).unwrap_or(f64::NAN);
                assert!((found / scale - 1.0).abs() < 1e-15, "{scale}: {found}");
            }
            let sheared = DMat3::from_cols(DVec3::X, DVec3::new(1e-6, 1.0, 0.0), DVec3::Z);
            let uneven = DMat3::from_diagonal(DVec3::new(1.0, 1.0 + 1e-6, 1.0));
            for m in [sheared, uneven, r * sheared, uneven * r, sheared.transpose()] {
                assert_eq!(similarity_scale(m * scale), None, "{scale}");
            }
        }
    }

    #[test]
    fn a_matrix_that_flattens_turns_no_hand() {
        assert!(!is_mirroring(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0))));
    }

    #[test]
    fn a_determinant_counts_as_zero_up_to_its_share_of_the_bound() {
        // The two long columns are sqrt(2) long, so the bound is 2; so are the rows.
        let with_share = |roundings: f64| {
            let e = 2.0 * roundings * UNIT_ROUNDOFF;
            DMat3::from_cols(DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 1.0 + e, 0.0), DVec3::Z)
        };
        for scale in [1e-100, 1.0, 1e100] {
            assert!(is_singular(with_share(SINGULAR_ROUNDINGS - 2.0) * scale));
            assert!(!is_singular(with_share(SINGULAR_ROUNDINGS + 2.0) * scale));
        }
        assert!(is_singular(DMat3::from_diagonal(DVec3::INFINITY)));
    }
}
