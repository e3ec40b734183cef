//! The laws of reflection, refraction and absorption.

use crate::scene::Color;
use glam::DVec3;

/// The fraction of light that is transmitted over a distance inside a transparent object: the object's colour
/// to the power of the distance. A negative channel, which has no such power, transmits nothing.
pub fn transmittance(color: Color, distance: f64) -> Color {
    Color::from_array(color.to_array().map(|channel| libm::pow(channel.max(0.0), distance)))
}

/// The direction of a reflected ray, as a unit vector. The normal may point to either side.
#[inline(always)]
pub fn reflected(direction: DVec3, normal: DVec3) -> DVec3 {
    (direction - 2.0 * direction.dot(normal) * normal).normalize()
}

/// The direction of a refracted ray, as a unit vector; none at total internal reflection. `ratio` is the
/// index of refraction in front of the surface over the one behind it, and `normal` points against
/// `direction`.
///
/// The direction is computed as the sum of its tangential and its normal component, because both are then
/// accurate at grazing incidence, where a formula that subtracts cosines suffers from cancellation. The
/// square of the normal component is 1 - |tangential|^2, or equivalently (1 - ratio^2) + (ratio * cosine)^2.
/// Of these two the one that subtracts the smaller number has less cancellation.
#[inline(always)]
pub fn refracted(direction: DVec3, normal: DVec3, ratio: f64) -> Option<DVec3> {
    let cosine = direction.dot(normal);
    let tangential = ratio * (direction - cosine * normal);
    let normal_squared = if ratio * ratio < 1.5 {
        (1.0 - ratio) * (1.0 + ratio) + (ratio * cosine) * (ratio * cosine)
    } else {
        1.0 - tangential.length_squared()
    };
    (normal_squared >= 0.0).then(|| (tangential - normal_squared.sqrt() * normal).normalize())
}
