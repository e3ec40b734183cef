//! The normals of triangles so thin that the plain cross product of two edges is zero or no number.

use crate::math::double_double::{Dd, cross, difference};
use crate::math::robust::unit;
use glam::DVec3;

/// The outward unit normal by twice the digits; none where even these show no area.
///
/// The edges are those at the corner opposite the longest edge: of two long edges to a far corner, the
/// difference is lost when they are rounded.
#[cold]
pub fn normal(corners: [DVec3; 3]) -> Option<DVec3> {
    let corners = rescaled(corners);
    let length = |k: usize| (corners[(k + 1) % 3] - corners[(k + 2) % 3]).length_squared();
    let apex = (0..3).max_by(|&i, &j| length(i).total_cmp(&length(j)))?;
    let [a, b, c] = [0, 1, 2].map(|k| corners[(apex + k) % 3]);
    let normal = unit(DVec3::from_array(cross(difference(b, a), difference(c, a)).map(Dd::value)));
    normal.is_finite().then_some(normal)
}

/// The corners moved by none and scaled by a power of two, so that the longest edge is about 1.
fn rescaled(corners: [DVec3; 3]) -> [DVec3; 3] {
    let [a, b, c] = corners;
    let longest = (b - a).abs().max((c - a).abs()).max_element();
    let exponent = libm::frexp(longest).1;
    corners.map(|v| DVec3::from_array(v.to_array().map(|x| libm::ldexp(x, -exponent))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_needle_to_a_far_corner_has_its_normal() {
        let (near, beside, far) = (DVec3::ZERO, DVec3::Y, DVec3::X * 1e90);
        for turned in [[near, far, beside], [far, beside, near], [beside, near, far]] {
            assert_eq!(normal(turned), Some(DVec3::Z));
            assert_eq!(normal(turned.map(|v| v * 1e-150)), Some(DVec3::Z));
        }
    }

    #[test]
    fn what_rounding_hides_is_seen() {
        // The point lies on the side's line as far as a plain product tells.
        let e = f64::EPSILON;
        let corners = [DVec3::ZERO, DVec3::new(1.0, 1.0 + e, 0.0), DVec3::new(1.0 + e, 1.0 + 2.0 * e, 0.0)];
        assert_eq!((corners[1] - corners[0]).cross(corners[2] - corners[0]), DVec3::ZERO);
        assert_eq!(normal(corners), Some(-DVec3::Z));
        assert_eq!(normal([DVec3::ZERO, DVec3::ONE, 0.5 * DVec3::ONE]), None);
    }
}
