//! Arithmetic with known error bounds: the offset of secondary rays (`proofs/offset.g`), unit vectors and normals at
//! any scale, and the test for singular matrices (`proofs/determinant.g`).

use super::double_double::{Dd, dot};
use super::exact::ExactSum;
use glam::{DAffine3, DMat3, DVec3};

/// The largest relative error of one f64 operation, 2^-53. Error bounds are counted in multiples of it,
/// *roundings* for short.
pub const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;

/// The distance from the surface at which a secondary ray starts, in roundings of the largest coordinate involved.
const OFFSET_ROUNDINGS: f64 = 32.0;

/// Up to this cosine between a ray and the normal, the ray starts along the normal.
const GRAZING_COSINE: f64 = 0.25;

/// The part of a shadow ray that is left out at its end, in roundings of its length: five for the light's distance
/// along the ray, five for the unit direction, and the rest for the t of the hits that it is compared with.
const END_ROUNDINGS: f64 = 16.0;

/// The least offset, which a surface at the origin needs. It is large enough that products with it do not underflow.
const MIN_OFFSET: f64 = 1e-290;

/// Returns the origin of a secondary ray that leaves `point` along the unit vector `direction`, moved so that the ray
/// neither hits the surface it leaves nor skips a surface close by.
///
/// The distance of a computed point from its surface is at most a few roundings of the point's coordinates and of the
/// coordinates from which it was computed, the largest of which is `extent`. Other primitives do not matter: their own
/// tests decide exactly on which side of them the ray starts. `OFFSET_ROUNDINGS` covers the error of the point and of
/// the next test of its own surface, as `proofs/offset.g` and `proofs/offset_ellipsoid.g` prove. Measured: no false and
/// no missed shadow at scales from 1e-6 to 1e6, and beside objects at 1e15.
///
/// The point moves along the direction, so that it stays on the line of the ray and the error of a path does not grow
/// with its bounces. At grazing angles this distance would be long, so the point moves along the normal instead.
#[inline(always)]
pub fn offset_origin(point: DVec3, unit_normal: DVec3, direction: DVec3, extent: f64) -> DVec3 {
    let distance = OFFSET_ROUNDINGS * UNIT_ROUNDOFF * (point.abs().max_element() + extent);
    let distance = distance.max(MIN_OFFSET);
    let cosine = direction.dot(unit_normal);
    if cosine.abs() > GRAZING_COSINE {
        return point + (distance / cosine.abs()) * direction;
    }
    let signed_distance = if cosine < 0.0 { -distance } else { distance };
    point + signed_distance * unit_normal
}

/// Returns the end and the direction of a ray from `origin` to `target`, if [`offset_origin`] has moved the origin off a
/// surface. The end is before the target by the rounding error of its distance.
///
/// A ray that was moved along the normal would pass beside the target, so it is aimed again.
#[inline(always)]
pub fn end_at(target: DVec3, origin: DVec3, unit_normal: DVec3, direction: DVec3) -> (f64, DVec3) {
    const PART: f64 = 1.0 - END_ROUNDINGS * UNIT_ROUNDOFF;
    let way = target - origin;
    let direction =
        if direction.dot(unit_normal).abs() > GRAZING_COSINE { direction } else { way.normalize_or_zero() };
    ((PART * way.dot(direction)).max(0.0), direction)
}

/// Returns `v` scaled to unit length, even if the square of its length overflows or underflows. The result is NaN for a
/// vector without a direction: zero, infinite or NaN.
#[inline(always)]
pub fn unit(v: DVec3) -> DVec3 {
    const REPRESENTABLE: std::ops::Range<f64> = 1e-290..1e290;
    if REPRESENTABLE.contains(&v.length_squared()) { v.normalize() } else { unit_of_extreme(v) }
}

#[cold]
fn unit_of_extreme(v: DVec3) -> DVec3 {
    rescaled(v).normalize()
}

/// Returns the image of a point under an affine map, with each coordinate rounded only once. In plain f64 the error
/// could reach seven roundings of the largest intermediate result.
pub fn transformed(map: &DAffine3, point: DVec3) -> DVec3 {
    DVec3::from_array(transformed_precisely(map, point.to_array().map(Dd::from)).map(Dd::value))
}

/// Computes the image of a point under an affine map in double-double arithmetic.
pub fn transformed_precisely(map: &DAffine3, point: [Dd; 3]) -> [Dd; 3] {
    let rows = map.matrix3.transpose();
    let coordinate = |row: DVec3, offset: f64| dot(row.to_array().map(Dd::from), point) + offset.into();
    let DVec3 { x, y, z } = map.translation;
    [coordinate(rows.x_axis, x), coordinate(rows.y_axis, y), coordinate(rows.z_axis, z)]
}

/// Returns `v` times a power of two such that its largest absolute coordinate is from 0.5 to 1, and the exponent of
/// that power. The scaling is exact unless a coordinate underflows, and leaves zero unchanged.
fn scaled_to_unit(v: DVec3) -> (DVec3, i32) {
    let exponent = libm::frexp(v.abs().max_element()).1;
    (DVec3::from_array(v.to_array().map(|x| libm::ldexp(x, -exponent))), -exponent)
}

/// Returns `v` times a power of two such that no product of its coordinates overflows or is lost to underflow.
pub fn rescaled(v: DVec3) -> DVec3 {
    scaled_to_unit(v).0
}

/// Returns the matrix with each column scaled as by [`scaled_to_unit`], and the exponents. The scaling keeps products
/// in range. It preserves the sign of the determinant and its ratio to Hadamard's bound.
fn with_unit_columns(m: DMat3) -> (DMat3, [i32; 3]) {
    let [(x, i), (y, j), (z, k)] = [m.x_axis, m.y_axis, m.z_axis].map(scaled_to_unit);
    (DMat3::from_cols(x, y, z), [i, j, k])
}

/// Returns a normal to be mapped by the cofactors of a matrix whose columns are scaled by powers of two with these
/// exponents. Each of its coordinates is scaled by the same factor as its column, which preserves the direction of the
/// result, and products stay in range.
fn scaled_like_columns(normal: DVec3, exponents: [i32; 3]) -> DVec3 {
    let (normal, largest) = (rescaled(normal), exponents.into_iter().max().unwrap_or(0));
    DVec3::from_array(std::array::from_fn(|i| libm::ldexp(normal[i], exponents[i] - largest)))
}

/// Returns the image of a normal under a matrix whose determinant has the sign `orientation`, which is not 0. It points
/// to the image of the side to which the normal pointed. Its length is arbitrary.
pub fn transformed_normal(m: DMat3, orientation: i32, normal: DVec3) -> DVec3 {
    let (m, exponents) = with_unit_columns(m);
    cofactor(m) * scaled_like_columns(normal, exponents) * f64::from(orientation)
}

/// Returns the cofactor matrix, which is the inverse transpose times the determinant. Unlike the inverse transpose, it
/// stays finite if the matrix is singular.
pub fn cofactor(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// Returns the largest error of [`transformed_normal`] relative to its length, for a matrix whose numbers have errors
/// of at most `error`.
pub fn transformed_normal_error(m: DMat3, error: DMat3, normal: DVec3) -> f64 {
    /// Two roundings for the cofactors, three for the products with the normal, and the rest for the unit normal's
    /// numbers and this bound's own arithmetic.
    const ROUNDINGS: f64 = 9.0;
    let scaled = |m: DMat3, [i, j, k]: [i32; 3]| {
        let scale = |v: DVec3, exponent| DVec3::from_array(v.to_array().map(|x| libm::ldexp(x, exponent)));
        DMat3::from_cols(scale(m.x_axis, i), scale(m.y_axis, j), scale(m.z_axis, k))
    };
    let (m, exponents) = with_unit_columns(m);
    let (sizes, error) = (m.abs(), scaled(error, exponents));
    let normal = scaled_like_columns(normal, exponents);
    let moved = (unsigned_cofactor(sizes, error) + unsigned_cofactor(error, sizes + error)) * normal.abs();
    let rounded = ROUNDINGS * UNIT_ROUNDOFF * (unsigned_cofactor(sizes, sizes) * normal.abs());
    (moved + rounded).length() / (cofactor(m) * normal).length()
}

/// Returns the cofactor matrix with sums instead of differences, of products of one matrix's numbers with another's.
fn unsigned_cofactor(one: DMat3, other: DMat3) -> DMat3 {
    let cross =
        |p: DVec3, q: DVec3| DVec3::new(p.y * q.z + p.z * q.y, p.z * q.x + p.x * q.z, p.x * q.y + p.y * q.x);
    DMat3::from_cols(
        cross(one.y_axis, other.z_axis),
        cross(one.z_axis, other.x_axis),
        cross(one.x_axis, other.y_axis),
    )
}

/// Returns the exact sign of the determinant of a finite matrix: -1, 0 or 1.
pub fn determinant_sign(m: DMat3) -> i32 {
    let mut determinant = ExactSum::default();
    determinant.add_determinant([m.x_axis, m.y_axis, m.z_axis]);
    determinant.value().sign()
}

/// Returns the factor by which a matrix scales all lengths; `None` if it is not a similarity (to a relative 1e-12).
pub fn similarity_scale(m: DMat3) -> Option<f64> {
    let largest = m.to_cols_array().into_iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
    let exponent = libm::frexp(largest).1;
    let m = DMat3::from_cols_array(&m.to_cols_array().map(|x| libm::ldexp(x, -exponent)));
    let square = m.x_axis.length_squared();
    let gram = m.transpose() * m;
    let deviation = (gram - DMat3::from_diagonal(DVec3::splat(square))).to_cols_array();
    deviation.iter().all(|x| x.abs() <= 1e-12 * square).then(|| libm::ldexp(square.sqrt(), exponent))
}

/// Returns true if the determinant is zero within the rounding errors of its computation and of the matrix entries. A
/// matrix with a NaN counts as singular.
///
/// The determinant is compared with Hadamard's bound, the largest determinant that columns (or rows) of these
/// lengths allow, so that a scaling matrix is not singular however small its factors are. The error of the
/// computed determinant is at most [`DETERMINANT_ROUNDINGS`] of that bound, as `proofs/determinant.g` proves;
/// the remainder of [`SINGULAR_ROUNDINGS`] allows for an error of [`ENTRY_ROUNDINGS`] in each entry.
pub fn is_singular(m: DMat3) -> bool {
    is_singular_by_columns(m) && is_singular_by_columns(m.transpose())
}

/// A determinant up to this multiple of Hadamard's bound, in roundings, counts as zero.
pub const SINGULAR_ROUNDINGS: f64 = 16.0;

/// Error bound of a computed determinant, in roundings of Hadamard's bound.
pub const DETERMINANT_ROUNDINGS: f64 = 6.0;

/// The largest error of the matrix entries, in roundings of each, up to which a matrix with an exact determinant of
/// zero is still recognized as singular.
pub const ENTRY_ROUNDINGS: f64 = 2.5;

fn is_singular_by_columns(m: DMat3) -> bool {
    let (m, _) = with_unit_columns(m);
    let hadamard_bound = m.x_axis.length() * m.y_axis.length() * m.z_axis.length();
    let determinant = m.determinant().abs();
    determinant.is_nan()
        || hadamard_bound.is_nan()
        || determinant <= SINGULAR_ROUNDINGS * UNIT_ROUNDOFF * hadamard_bound
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unit_vectors_are_right_at_any_scale() {
        let v = DVec3::new(3.0, 0.0, -4.0);
        for scale in [1e-320, 1e-200, 1e-100, 1.0, 1e200, 1e307] {
            assert!((unit(scale * v) - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-3, "{scale}");
        }
        assert!(unit(DVec3::ZERO).is_nan() && unit(DVec3::INFINITY).is_nan());
    }

    #[test]
    fn normals_and_scales_are_right_at_any_scale() {
        let r = DMat3::from_cols_array(&[0.6, 0.8, 0.0, -0.8, 0.6, 0.0, 0.0, 0.0, 1.0]);
        let uneven = DMat3::from_diagonal(DVec3::new(1.0, 4.0, -2.0));
        let expected = unit(transformed_normal(r * uneven, -1, DVec3::ONE));
        for exponent in [-1000, -500, 0, 500, 1000] {
            let far = libm::ldexp(1.0, exponent);
            assert_eq!(unit(transformed_normal(r * uneven * far, -1, DVec3::ONE)), expected);
            assert_eq!([far, -far].map(|far| determinant_sign(uneven * far)), [-1, 1]);
            assert_eq!(similarity_scale(r * far), similarity_scale(r).map(|scale| scale * far));
        }
        assert_eq!(similarity_scale(uneven), None);
        let degenerate = DMat3::from_diagonal(DVec3::new(1.0, 1e-250, 1e-250));
        assert_eq!(unit(transformed_normal(degenerate, 1, DVec3::X)), DVec3::X);
    }

    #[test]
    fn small_scales_do_not_make_a_matrix_singular() {
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
    fn the_offset_has_its_distance_from_the_surface_at_every_angle() {
        for far in [1.0, 1e6] {
            let (p, extent) = (far * DVec3::new(1.0, 2.0, -3.0), far * 4.0);
            let expected = OFFSET_ROUNDINGS * UNIT_ROUNDOFF * far * (3.0 + 4.0);
            for cosine in [1.0, 0.6, 0.3, 0.2, 1e-9, -1e-9, -0.2, -0.3, -0.6, -1.0] {
                let direction = DVec3::new(f64::sqrt(1.0 - cosine * cosine), cosine, 0.0);
                let offset = offset_origin(p, DVec3::Y, direction, extent) - p;
                let height = offset.y * cosine.signum();
                assert!((height / expected - 1.0).abs() < 0.1, "{far} {cosine}: {height} {expected}");
                // It is along the direction, except at grazing angles.
                let x = if cosine.abs() > 0.25 { height * direction.x / cosine.abs() } else { 0.0 };
                assert!((offset.x - x).abs() < 0.1 * expected && offset.z == 0.0, "{far} {cosine}: {offset}");
            }
        }
    }

    #[test]
    fn a_transformed_point_is_rounded_only_once() {
        // The large terms cancel, so plain sums lose some of the small terms, whatever their order is.
        let linear = DMat3::from_cols_array(&[1e17, 1.0, 0.5, 3.0, 1e17, -1e16, -1e17, -1e17, 1e16]);
        let map = DAffine3 { matrix3: linear, translation: DVec3::new(7.0, 0.25, -2.0) };
        let exact = |row: DVec3, offset: f64| {
            let quarters = |x: f64| (x * 4.0) as i128;
            (quarters(row.x) + quarters(row.y) + quarters(row.z) + quarters(offset)) as f64 / 4.0
        };
        let rows = map.matrix3.transpose();
        let expected =
            [(rows.x_axis, 7.0), (rows.y_axis, 0.25), (rows.z_axis, -2.0)].map(|(r, s)| exact(r, s));
        assert_eq!(transformed(&map, DVec3::ONE).to_array(), expected);
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
    fn the_sign_of_a_determinant_is_exact() {
        // Whole numbers that agree to 50 bits; the determinants of these matrices are -1, 0 and 1.
        let n = 2f64.powi(50);
        for k in [-1.0, 0.0, 1.0] {
            let (x, y) = (DVec3::new(n, n + 1.0, 0.0), DVec3::new(n - 1.0, n, 0.0));
            let m = DMat3::from_cols(x, y, k * DVec3::Z);
            for scale in [2f64.powi(-900), 1.0, 2f64.powi(900)] {
                assert_eq!(f64::from(determinant_sign(m * scale)), k);
            }
        }
        assert_eq!(determinant_sign(DMat3::from_diagonal(DVec3::new(1.0, -0.0, 1.0))), 0);
    }

    #[test]
    fn a_determinant_counts_as_zero_up_to_a_fraction_of_hadamards_bound() {
        // Two columns have the length sqrt(2), and the third 1, so Hadamard's bound is 2; the rows are alike.
        let with_determinant = |roundings: f64| {
            let e = 2.0 * roundings * UNIT_ROUNDOFF;
            DMat3::from_cols(DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 1.0 + e, 0.0), DVec3::Z)
        };
        for scale in [1e-100, 1.0, 1e100] {
            assert!(is_singular(with_determinant(SINGULAR_ROUNDINGS - 2.0) * scale));
            assert!(!is_singular(with_determinant(SINGULAR_ROUNDINGS + 2.0) * scale));
        }
        assert!(is_singular(DMat3::from_diagonal(DVec3::INFINITY)));
    }

    #[test]
    fn the_error_of_a_transformed_normal_is_within_its_bound() {
        use crate::math::worst_case::Rng;
        use num_rational::BigRational;
        use num_traits::ToPrimitive;
        let exact = |x: f64| BigRational::from_float(x).unwrap();
        let rng = &mut Rng(5);
        let mut largest_part = 0.0f64;
        for k in 0..2000 {
            let flat = if k % 2 == 0 { 1.0 } else { 10f64.powi(-(rng.below(9) as i32)) };
            let m = DMat3::from_cols(rng.vector(), flat * rng.vector(), rng.vector()) * 2f64.powi(200);
            let error = m.abs() * 1e-12;
            let normal = rng.vector();
            // The exact matrix is anywhere within the errors.
            let off = rng.signed();
            let numbers =
                m.to_cols_array().map(|x| exact(x) + exact(1e-12 * off * rng.signed()) * exact(x.abs()));
            let number = |row: usize, column: usize| &numbers[3 * column + row];
            let cofactor = |row: usize, column: usize| {
                let [i, j, k, l] = [(row + 1) % 3, (row + 2) % 3, (column + 1) % 3, (column + 2) % 3];
                number(i, k) * number(j, l) - number(i, l) * number(j, k)
            };
            let scale = exact(2f64.powi(-200)) * exact(2f64.powi(-200));
            let expected: [f64; 3] = std::array::from_fn(|row| {
                let sum =
                    (0..3).map(|column| cofactor(row, column) * exact(normal[column])).sum::<BigRational>();
                (sum * &scale).to_f64().unwrap()
            });
            let (expected, found) =
                (unit(DVec3::from_array(expected)), unit(transformed_normal(m, 1, normal)));
            let angle = expected.cross(found).length();
            let bound = transformed_normal_error(m, error, normal);
            assert!(angle <= bound + 4.0 * UNIT_ROUNDOFF, "{m} {normal}: {angle} {bound}");
            largest_part = largest_part.max(angle / bound);
        }
        assert!(largest_part > 0.1, "the bound is {} times too wide", 1.0 / largest_part);
    }
}
