//! Reads cameras.

use super::Camera;
use super::reader::{Parsed, Reader};
use crate::diagnostic::Diagnostic;
use crate::math::robust::unit;
use glam::DVec3;

/// Reads an `OrthographicCamera`.
pub fn parse_orthographic_camera(reader: &mut Reader<'_>) -> Parsed<Camera> {
    let name = reader.open()?.text;
    let (center, direction, up) = parse_view(reader)?;
    let size = reader.positive_field("size")?;
    reader.close(name)?;
    Ok(Camera::Orthographic { center, direction, up, size })
}

/// Reads a `PerspectiveCamera`.
pub fn parse_perspective_camera(reader: &mut Reader<'_>) -> Parsed<Camera> {
    let name = reader.open()?.text;
    let (center, direction, up) = parse_view(reader)?;
    reader.keyword("angle")?;
    let rule = "must be above 0 and below 180 degrees";
    let angle = reader.number_that("angle", rule, |angle| angle > 0.0 && angle < 180.0)?;
    reader.close(name)?;
    Ok(Camera::Perspective { center, direction, up, angle })
}

/// Reads the fields that both cameras share: center, direction and up.
fn parse_view(reader: &mut Reader<'_>) -> Parsed<(DVec3, DVec3, DVec3)> {
    let center = reader.vector_field("center")?;
    let direction = reader.direction_field("direction")?;
    reader.keyword("up")?;
    let at = reader.peek().at;
    let up = reader.nonzero_vector("up")?;
    if are_parallel(direction, up) {
        return Err(Diagnostic::error("`up` must not be parallel to `direction`").at(at));
    }
    Ok((center, direction, up))
}

/// Whether two nonzero vectors are parallel, up to rounding.
fn are_parallel(a: DVec3, b: DVec3) -> bool {
    const MAX_SINE: f64 = 1e-12;
    unit(a).cross(unit(b)).length() < MAX_SINE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_parallel_is_not_parallel() {
        assert!(are_parallel(DVec3::ONE, DVec3::ONE * -3.0));
        assert!(are_parallel(DVec3::ONE * 1e-300, DVec3::ONE * 1e300));
        assert!(!are_parallel(DVec3::Y, DVec3::new(1e-6, 1.0, 0.0)));
    }

    #[test]
    fn vectors_are_parallel_within_less_than_1e_12() {
        let parallel = |angle: f64| are_parallel(DVec3::X * 3.0, DVec3::new(-1.0, angle, 0.0));
        assert_eq!([0.0, 0.99e-12, 1e-12, 1e-9].map(parallel), [true, true, false, false]);
    }
}
