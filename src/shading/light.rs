//! The light that arrives at a point from a light source.

use crate::picture::Color;
use crate::scene::Light;
use crate::scene::limits::LARGEST;
use glam::DVec3;
use serde::Serialize;

/// The light that arrives at a point from one source.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Incident {
    /// Unit vector towards the light.
    pub direction: DVec3,
    /// The distance to the light; infinite for a directional light.
    pub distance: f64,
    /// The light's colour times its attenuation at this distance.
    pub color: Color,
}

/// Returns the light that arrives at `point`. The direction of a directional light must be a unit vector.
#[inline(always)]
pub fn incident(light: &Light, point: DVec3) -> Incident {
    let (direction, distance, factor) = match *light {
        Light::Directional { direction, .. } => (-direction, f64::INFINITY, 1.0),
        Light::Point { position, attenuation: [a0, a1, a2], .. } => {
            let to_light = position - point;
            let distance = to_light.length();
            // A light at the point itself has no direction and gives no light.
            let direction = unit_or_zero(to_light);
            let falloff = a0 + a1 * distance + a2 * distance * distance;
            // As in the course, a negative attenuation gives no light. The upper limit keeps the factor finite.
            let factor = if falloff > 0.0 { (1.0 / falloff).min(LARGEST) } else { 0.0 };
            (direction, distance, factor)
        }
    };
    // The result is built in one place for all kinds of light, so that it stays in registers.
    let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
    Incident { direction, distance, color: color * factor }
}

/// Returns the unit vector along `v`, or zero if its length is zero, infinite or NaN.
///
/// The library's function tests that the reciprocal of the length is finite and positive, which takes longer. Both
/// tests hold for the same vectors, because a length is a square root: unless it is zero, it is at least 1e-162.
#[inline(always)]
pub fn unit_or_zero(v: DVec3) -> DVec3 {
    let length = v.length();
    if length > 0.0 && length <= f64::MAX { v * (1.0 / length) } else { DVec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_falloff_makes_no_nan() {
        for attenuation in [[0.0; 3], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]] {
            let light = Light::Point { position: DVec3::Y, color: Color::ONE, attenuation };
            let at = incident(&light, DVec3::Y);
            assert!(at.color.is_finite() && at.direction.is_finite());
        }
    }

    #[test]
    fn unit_vectors_have_the_bits_of_the_library_s() {
        let lengths = [0.0, 5e-324, 1e-309, 1e-308, 1e-200, 1e-162, 2.3e-162, 1e-150, 0.3, 1.0, 7e7, 1e150];
        let large = [1e154, 1.3e154, 1e155, 1e300, f64::MAX, f64::INFINITY, f64::NAN];
        for length in lengths.into_iter().chain(large) {
            for way in [DVec3::X, DVec3::NEG_Z, DVec3::new(0.3, -0.4, 0.5), DVec3::new(1.0, 0.0, 1e-8)] {
                let v = way * length;
                let [found, expected] =
                    [unit_or_zero(v), v.normalize_or_zero()].map(|u| u.to_array().map(f64::to_bits));
                assert_eq!(found, expected, "{v}");
            }
        }
    }

    #[test]
    fn a_light_without_falloff_or_with_a_negative_one_is_dark() {
        for attenuation in [[0.0; 3], [-1.0, 0.0, 0.0], [1.0, 0.0, -1.0]] {
            let light = Light::Point { position: DVec3::Y * 3.0, color: Color::ONE, attenuation };
            assert_eq!(incident(&light, DVec3::ZERO).color, Color::ZERO);
        }
    }
}
