//! The laws of reflection, refraction and absorption.

use crate::math::double_double::{Dd, SquaredSine};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::picture::Color;
use glam::DVec3;

/// Returns the fraction of light that is transmitted over a distance inside a transparent object: the object's colour
/// to the power of the distance. A negative channel has no such power and transmits nothing.
pub fn transmittance(color: Color, distance: f64) -> Color {
    Color::from_array(color.to_array().map(|channel| libm::pow(channel.max(0.0), distance)))
}

/// Returns the direction of a reflected ray, as a unit vector. The normal may point to either side.
#[inline(always)]
pub fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// If the square of a refracted ray's normal component is below this times the ratio of the indices, its sign is
/// computed exactly. The error of the square is twice the error of the normal times the ratio, since the ratio times
/// the sine of the angle is about 1 there. The error of [`triangle::normal`](crate::world::triangle::normal) is at
/// most 2^-20. Directions and ratios are off by a few roundings at most.
const CRITICAL: f64 = 1.0 / (1u64 << 18) as f64;

/// Refraction and total reflection are a close call within this number of roundings times the ratio of the indices.
const CLOSE_ROUNDINGS: f64 = 32.0;

/// Returns the direction of a refracted ray as a unit vector, or `None` at total internal reflection. `ratio` is the
/// index of refraction in front of the surface over the one behind it, and `normal` points against `direction`.
pub fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    refracted_between(direction, normal, [ratio, 1.0], || {
        SquaredSine::of(direction, normal.to_array().map(Dd::from))
    })
}

/// Returns the direction of a refracted ray like [`refracted`], but between two media, with the `indices` of
/// refraction in front of the surface and behind it. `sine` returns the sine of the angle between the direction and
/// the normal, with less rounding.
///
/// The direction is the sum of its tangential and its normal component. Both are accurate at grazing incidence, where
/// a formula that subtracts cosines suffers from cancellation.
#[inline(always)]
pub fn refracted_between(
    direction: DVec3,
    normal: DVec3,
    indices: [f64; 2],
    sine: impl FnOnce() -> SquaredSine,
) -> Option<DVec3> {
    let ratio = indices[0] / indices[1];
    let (tangential, normal_squared) = components(direction, normal, ratio);
    let is_refracted = if normal_squared.abs() > CRITICAL * ratio {
        normal_squared > 0.0
    } else {
        is_refracted_precisely(sine(), indices)
    };
    is_refracted.then(|| (tangential - normal_squared.max(0.0).sqrt() * normal).normalize())
}

/// Returns the tangential component of a refracted ray's direction, and the square of the normal component.
///
/// The square is 1 - |tangential|^2, or equivalently (1 - ratio^2) + (ratio * cosine)^2. The form that subtracts the
/// smaller number has less cancellation.
#[inline(always)]
fn components(direction: DVec3, normal: DVec3, ratio: f64) -> (DVec3, f64) {
    let cosine = direction.dot(normal);
    let tangential = ratio * (direction - cosine * normal);
    let normal_squared = if ratio * ratio < 1.5 {
        (1.0 - ratio) * (1.0 + ratio) + (ratio * cosine) * (ratio * cosine)
    } else {
        1.0 - tangential.length_squared()
    };
    (tangential, normal_squared)
}

/// Returns true if the sine of the angle times the index in front is at most the index behind. Compares the squares in
/// double-double arithmetic, with a relative error of at most 2^-96. The result is exact if the products have few
/// digits.
#[cold]
fn is_refracted_precisely(SquaredSine { numerator, denominator }: SquaredSine, indices: [f64; 2]) -> bool {
    // A common factor keeps the squares of extreme indices in range.
    let largest = indices[0].max(indices[1]);
    let exponent = libm::frexp(largest).1;
    let [front, behind] = indices.map(|index| {
        let index = Dd::from(libm::ldexp(index, -exponent));
        index * index
    });
    (behind * denominator - front * numerator).value() >= 0.0
}

/// Returns the part of the light that is reflected at a transparent surface, given the indices of refraction in front
/// of it and behind it, by Schlick's approximation ("An Inexpensive BRDF Model for Physically-based Rendering",
/// Computer Graphics Forum 13(3), 1994). `cosine` is the cosine of the angle in front.
pub(crate) fn mirrored_part(cosine: f64, [front, behind]: [f64; 2]) -> f64 {
    let ratio = front / behind;
    let refracted_square = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if refracted_square < 0.0 {
        return 1.0;
    }
    // The larger of the angles in front of the surface and behind it counts.
    let cosine = if front <= behind { cosine } else { refracted_square.sqrt() };
    // As in the course's program, the medium behind is compared with empty space, whatever is in front. So a ray that
    // leaves an object at a right angle is not reflected.
    let root = (behind - 1.0) / (behind + 1.0);
    let straight = root * root;
    // A fixed order of the products gives the same result on every machine.
    let (grazing, square) = (1.0 - cosine, (1.0 - cosine) * (1.0 - cosine));
    straight + (1.0 - straight) * (grazing * (square * square))
}

/// Returns true if a few roundings could turn refraction into total reflection, or the reverse.
pub fn is_critical(direction: DVec3, normal: DVec3, [front, behind]: [f64; 2]) -> bool {
    let ratio = front / behind;
    let (_, normal_squared) = components(direction, normal, ratio);
    normal_squared.abs() <= CLOSE_ROUNDINGS * UNIT_ROUNDOFF * ratio
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_media_the_one_behind_decides_how_much_is_mirrored() {
        let near = |cosine, indices, expected: f64| (mirrored_part(cosine, indices) - expected).abs() < 1e-15;
        assert!(near(1.0, [1.0, 2.0], 1.0 / 9.0) && near(1.0, [2.0, 1.0], 0.0));
        // A ray that is reflected on the outside may hit the surface from within.
        assert!(near(0.5, [1.0, 1.0], 1.0 / 32.0) && near(1.0, [2.0, 2.0], 1.0 / 9.0));
        // The sine is 0.3, and 0.6 behind the surface.
        assert!(near(0.91f64.sqrt(), [2.0, 1.0], 0.2f64.powi(5)));
        assert!(near(0.8, [1.0, 2.0], 1.0 / 9.0 + 8.0 / 9.0 * 0.2f64.powi(5)));
        assert_eq!([0.0, 0.86].map(|cosine| mirrored_part(cosine, [2.0, 1.0])), [1.0; 2]);
    }
}
