//! The ranges of a scene's numbers that guarantee results without overflow or NaN.
//!
//! Geometry multiplies up to three coordinates, and the inverse of a radius. Shading multiplies the colours of lights
//! and materials along the path of secondary rays and shadows. Within these limits all products stay below the largest
//! f64.

use glam::DVec3;

/// The largest magnitude of a number in a scene, and of a coordinate in world space.
pub const LARGEST: f64 = 1e100;

/// The smallest radius of a sphere, or semi-axis of an ellipsoid, in world space.
pub const SMALLEST_RADIUS: f64 = 1e-100;

/// The largest magnitude of a colour channel.
pub const BRIGHTEST: f64 = 1e30;

/// Returns true if the magnitudes of all coordinates are at most [`LARGEST`]. A NaN is out of range.
pub fn are_in_range(coordinates: DVec3) -> bool {
    coordinates.abs().cmple(DVec3::splat(LARGEST)).all()
}
