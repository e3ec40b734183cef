//! Points with bounds on their rounding errors.

use glam::DVec3;

/// A point of a surface as it is computed.
#[derive(Clone, Copy)]
pub struct RoundedPoint<'a> {
    /// The point as it is computed.
    pub position: DVec3,
    /// How far along each axis it may be from the surface as the scene describes it. It is computed where it is needed.
    pub error: &'a dyn Fn() -> DVec3,
    /// A point that is farther from a boundary in the space of a checkerboard is certainly on its side of it, whatever
    /// its error is.
    pub boundary_width: f64,
}

/// A point that lies on its surface exactly.
impl From<DVec3> for RoundedPoint<'_> {
    fn from(position: DVec3) -> Self {
        Self { position, error: &|| DVec3::ZERO, boundary_width: f64::INFINITY }
    }
}
