//! Reads a list of transformations and composes them into one affine map.

use super::reader::{Parsed, Reader};
use crate::diagnostic::Diagnostic;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::rounded::RoundedAffine;
use glam::{DAffine3, DMat3, DVec3};

/// The keywords that start a transformation. `Matrix4f` belongs to the editions from 2012 on.
pub const TRANSFORMATIONS: [&str; 9] =
    ["Translate", "Scale", "UniformScale", "XRotate", "YRotate", "ZRotate", "Rotate", "Matrix", "Matrix4f"];

/// Returns true if the next word starts a transformation in the current edition.
pub fn is_at_transformation(reader: &Reader<'_>) -> bool {
    let word = reader.peek().text;
    TRANSFORMATIONS.contains(&word) && !reader.is_of_other_edition(word)
}

/// A transformation as written in a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Factor {
    /// A translation or a scale.
    Plain(DAffine3),
    /// A right-handed rotation around an axis of any length.
    Rotation { axis: DVec3, degrees: f64 },
    /// A matrix.
    Matrix(DAffine3),
}

impl Factor {
    /// Returns the product of this transformation and the ones before it in the list, like the course's program.
    ///
    /// A transformation is multiplied from the right, so the last one acts first. The exception is a matrix, which is
    /// multiplied from the left.
    pub fn after(self, before: RoundedAffine) -> RoundedAffine {
        match self {
            Self::Plain(map) => before * map.into(),
            Self::Rotation { axis, degrees } => before * rotation(axis, degrees),
            Self::Matrix(map) => RoundedAffine::from(map) * before,
        }
    }
}

/// A list of transformations and its product.
#[derive(Clone, Debug, PartialEq)]
pub struct Transformations {
    pub factors: Box<[Factor]>,
    pub matrix: RoundedAffine,
}

/// Reads transformations up to the first word that does not start one, and composes them. Fails if a transformation is
/// malformed or the product overflows.
pub fn parse_transformations(reader: &mut Reader<'_>) -> Parsed<Transformations> {
    let (mut factors, mut matrix) = (vec![], RoundedAffine::IDENTITY);
    while is_at_transformation(reader) {
        let at = reader.peek().at;
        let is_matrix = reader.is_at("Matrix") || reader.is_at("Matrix4f");
        let factor = if is_matrix { parse_matrix(reader)? } else { parse_factor(reader)? };
        matrix = factor.after(matrix);
        if !matrix.is_finite() {
            return Err(Diagnostic::error("the transformation's numbers grow too large").at(at));
        }
        factors.push(factor);
    }
    Ok(Transformations { factors: factors.into(), matrix })
}

/// Reads any transformation except `Matrix`. The 2003 edition puts braces around the values of all transformations, the
/// 2004 edition only around those for `Rotate`. Both forms are accepted.
fn parse_factor(reader: &mut Reader<'_>) -> Parsed<Factor> {
    let name = reader.take().text;
    if name == "Rotate" {
        reader.open_brace(name)?;
    }
    let is_braced = name == "Rotate" || reader.accept("{");
    let factor = match name {
        "Translate" => Factor::Plain(DAffine3::from_translation(reader.vector()?)),
        "Scale" => Factor::Plain(DAffine3::from_scale(reader.vector()?)),
        "UniformScale" => Factor::Plain(DAffine3::from_scale(DVec3::splat(reader.number()?))),
        "XRotate" => Factor::Rotation { axis: DVec3::X, degrees: reader.number()? },
        "YRotate" => Factor::Rotation { axis: DVec3::Y, degrees: reader.number()? },
        "ZRotate" => Factor::Rotation { axis: DVec3::Z, degrees: reader.number()? },
        _ => Factor::Rotation { axis: reader.direction()?, degrees: reader.number()? },
    };
    if is_braced {
        reader.close(name)?;
    }
    Ok(factor)
}

/// Reads `Matrix { ... }`, sixteen numbers in row-major order, or `Matrix4f { ... }`, in column-major order.
fn parse_matrix(reader: &mut Reader<'_>) -> Parsed<Factor> {
    reader.block(|reader, name| {
        let mut rows = [[0.0; 4]; 4];
        for place in 0..16 {
            let (at, number) = (reader.peek().at, reader.number()?);
            let [row, column] =
                if name == "Matrix" { [place / 4, place % 4] } else { [place % 4, place / 4] };
            rows[row][column] = number;
            if row == 3 && number != [0.0, 0.0, 0.0, 1.0][column] {
                return Err(Diagnostic::error("the last row of a `Matrix` must be 0 0 0 1").at(at));
            }
        }
        let [x, y, z, _] = rows;
        Ok(Factor::Matrix(from_rows([x, y, z])))
    })
}

/// Returns the right-handed rotation around `axis` by `degrees`.
///
/// Like the course's program, does not normalise the axis. An axis of another length than 1 distorts the object.
fn rotation(axis: DVec3, degrees: f64) -> RoundedAffine {
    let (sine, cosine) = sine_and_cosine(degrees);
    let DVec3 { x, y, z } = axis;
    let rest = 1.0 - cosine;
    let map = from_rows([
        [rest * x * x + cosine, rest * x * y - sine * z, rest * x * z + sine * y, 0.0],
        [rest * x * y + sine * z, rest * y * y + cosine, rest * y * z - sine * x, 0.0],
        [rest * x * z - sine * y, rest * y * z + sine * x, rest * z * z + cosine, 0.0],
    ]);
    let is_exact = degrees % 90.0 == 0.0 && [DVec3::X, DVec3::Y, DVec3::Z].contains(&axis.abs());
    if is_exact { map.into() } else { RoundedAffine { error: rotation_error(axis.abs()), ..map.into() } }
}

/// Error bounds of the terms of a rotation matrix, in roundings of the axis's numbers in them: `rest` times two numbers
/// of the axis, the sine times one number, and the cosine (`proofs/checkerboard.g`).
const REST_ROUNDINGS: f64 = 11.0;
const SINE_ROUNDINGS: f64 = 5.0;
const COSINE_ROUNDINGS: f64 = 5.0;

/// Returns the error bounds of a rotation matrix. `axis` contains the absolute values of the rotation's axis.
fn rotation_error(axis: DVec3) -> DAffine3 {
    let DVec3 { x, y, z } = axis;
    let of_rest = DMat3::from_cols(axis * x, axis * y, axis * z) * REST_ROUNDINGS;
    let of_sine = DMat3::from_cols(DVec3::new(0.0, z, y), DVec3::new(z, 0.0, x), DVec3::new(y, x, 0.0))
        * SINE_ROUNDINGS;
    let of_cosine = DMat3::from_diagonal(DVec3::splat(COSINE_ROUNDINGS));
    DAffine3::from_mat3((of_rest + of_sine + of_cosine) * UNIT_ROUNDOFF)
}

/// Returns the sine and cosine of an angle in degrees. They are exact at multiples of 90 and identical on all machines.
fn sine_and_cosine(degrees: f64) -> (f64, f64) {
    // The remainder is exact, and so is its difference from the nearest multiple of 90 degrees.
    let turn = degrees % 360.0;
    let quarters = (turn / 90.0).round();
    let (sine, cosine) = libm::sincos((turn - 90.0 * quarters).to_radians());
    let (sine, cosine) = match (quarters as i64).rem_euclid(4) {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    };
    // Adding zero converts a negative zero to a positive one.
    (sine + 0.0, cosine + 0.0)
}

fn from_rows(rows: [[f64; 4]; 3]) -> DAffine3 {
    let column = |index: usize| DVec3::new(rows[0][index], rows[1][index], rows[2][index]);
    DAffine3::from_mat3_translation(DMat3::from_cols(column(0), column(1), column(2)), column(3))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;
    use crate::math::worst_case::Rng;
    use crate::scene::edition::Edition;
    use num_rational::BigRational;
    use num_traits::{Signed, ToPrimitive, Zero};

    fn read(text: &str) -> DAffine3 {
        parse_transformations(&mut Reader::new(Edition::Y2004, text, &Endless)).unwrap().matrix.map
    }

    #[test]
    fn quarter_turns_are_exact() {
        let quarter = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
        for turns in -9..=9_i32 {
            let exact = sine_and_cosine(f64::from(turns) * 90.0);
            assert_eq!(exact, quarter[turns.rem_euclid(4) as usize]);
            assert!(!<[f64; 2]>::from(exact).iter().any(|x| *x == 0.0 && x.is_sign_negative()));
        }
        assert_eq!(read("XRotate -90").matrix3, DMat3::from_cols(DVec3::X, DVec3::NEG_Z, DVec3::Y));
    }

    #[test]
    fn rotations_are_right_handed() {
        for (text, from, to) in [
            ("XRotate 90", DVec3::Y, DVec3::Z),
            ("YRotate 90", DVec3::Z, DVec3::X),
            ("ZRotate 90", DVec3::X, DVec3::Y),
            ("Rotate { 0 0 1 90 }", DVec3::X, DVec3::Y),
        ] {
            assert_eq!(read(text).transform_vector3(from), to, "{text}");
        }
    }

    #[test]
    fn the_axis_is_used_as_given() {
        // Computed by hand for the axis (0, 0, 2) and 90 degrees, whose cosine is 0 and sine 1.
        let expected =
            DMat3::from_cols(DVec3::new(0.0, 2.0, 0.0), DVec3::new(-2.0, 0.0, 0.0), DVec3::Z * 4.0);
        assert_eq!(read("Rotate { 0 0 2 90 }").matrix3, expected);
    }

    #[test]
    fn a_matrix_acts_after_the_transformations_before_it() {
        let map = read("Translate 1 0 0 Matrix { 2 0 0 0  0 2 0 0  0 0 2 5  0 0 0 1 } UniformScale 3");
        assert_eq!(map.transform_point3(DVec3::ONE), DVec3::new(8.0, 6.0, 11.0));
    }

    #[test]
    fn a_matrix_is_read_row_by_row() {
        let map = read("Matrix { 1 2 3 4 5 6 7 8 9 10 11 12 0 0 0 1 }");
        assert_eq!(map.transform_point3(DVec3::X), DVec3::new(5.0, 13.0, 21.0));
    }

    #[test]
    fn braces_of_the_2003_edition_are_read() {
        assert_eq!(
            read("Translate { 1 2 3 } Scale{2 3 4} XRotate { 90 } UniformScale{2}"),
            read("Translate 1 2 3 Scale 2 3 4 XRotate 90 UniformScale 2")
        );
    }

    #[test]
    fn the_sine_of_a_tiny_angle_is_accurate() {
        let (sine, cosine) = sine_and_cosine(1e-20);
        assert_eq!((sine, cosine), (1e-20f64.to_radians(), 1.0));
    }

    fn exact(x: f64) -> BigRational {
        BigRational::from_float(x).unwrap()
    }

    /// Returns sine and cosine to more than 40 digits, computed by their series.
    fn exact_sine_and_cosine(degrees: f64) -> [BigRational; 2] {
        let pi: BigRational = "31415926535897932384626433832795028841971693993751/10000000000000000000000000000000000000000000000000"
            .parse()
            .unwrap();
        let angle = exact(degrees) * pi / exact(180.0);
        let mut sums = [exact(0.0), exact(0.0)];
        let mut term = exact(1.0);
        for n in 1..80 {
            let sign = if (n - 1) / 2 % 2 == 0 { exact(1.0) } else { exact(-1.0) };
            sums[n % 2] += &term * sign;
            // The truncated digits are far below the required precision.
            term = (term * &angle / exact(n as f64) * exact(2f64.powi(200))).round() / exact(2f64.powi(200));
        }
        let [sine, cosine] = sums;
        [sine, cosine]
    }

    #[test]
    fn rotations_are_within_their_error_bounds() {
        let rng = &mut Rng(3);
        let mut largest_part = 0.0f64;
        for k in 0..400 {
            let axis =
                if k % 2 == 0 { rng.vector().normalize() } else { [DVec3::X, DVec3::Y, DVec3::Z][k / 2 % 3] };
            let degrees = 360.0 * rng.signed();
            let [sine, cosine] = exact_sine_and_cosine(degrees);
            let [x, y, z] = axis.to_array().map(exact);
            let rest = exact(1.0) - &cosine;
            let expected = [
                [&rest * &x * &x + &cosine, &rest * &x * &y - &sine * &z, &rest * &x * &z + &sine * &y],
                [&rest * &x * &y + &sine * &z, &rest * &y * &y + &cosine, &rest * &y * &z - &sine * &x],
                [&rest * &x * &z - &sine * &y, &rest * &y * &z + &sine * &x, &rest * &z * &z + &cosine],
            ];
            let RoundedAffine { map, error, .. } = rotation(axis, degrees);
            for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                let off = (exact(map.matrix3.col(j)[i]) - &expected[i][j]).abs();
                let bound = exact(error.matrix3.col(j)[i]);
                assert!(off <= bound, "{axis} {degrees}: {off} is more than {bound}");
                if !bound.is_zero() {
                    largest_part = largest_part.max((off / bound).to_f64().unwrap());
                }
            }
        }
        assert!(largest_part > 0.1, "the bound is {} times too wide", 1.0 / largest_part);
    }

    #[test]
    fn quarter_turns_and_scales_have_no_error() {
        for text in ["ZRotate 90", "Scale 0.1 0.2 0.3", "Rotate { 0 -1 0 270 }", "Translate 0.1 0.2 0.3"] {
            let map = parse_transformations(&mut Reader::new(Edition::Y2004, text, &Endless)).unwrap().matrix;
            assert_eq!(map.error, DAffine3::ZERO, "{text}");
        }
        let turned =
            parse_transformations(&mut Reader::new(Edition::Y2004, "ZRotate 30", &Endless)).unwrap().matrix;
        assert!(turned.error.matrix3.x_axis.x > 0.0);
    }
}
