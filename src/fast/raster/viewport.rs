//! The view from an eye: projects the points of the world in front of a perspective camera.

use super::edge_functions::{EDGE_ROUNDINGS, EdgeFunctions, ErrorBound, InvDepthPlane};
use super::triangle_bounds::{self, ScreenVertex};
use super::{Affine, Footprint, Screen, ScreenProjection};
use crate::camera::{Eye, TURN_ROUNDINGS};
use crate::math::aabb::Aabb;
use crate::world::plane::Plane;
use glam::{DVec2, DVec3};

/// The factor of the `max_direction_length` of a turned eye. All error bounds are at least proportional to this
/// length. For an edge function, the factor adds exactly the further roundings of a direction. It adds more than these
/// for the depths of triangles, which have 47.5 roundings and to which the roundings of a direction apply 2.6 times,
/// and for the depths of planes, which have 19 roundings.
const TURNED: f64 = 1.0 + TURN_ROUNDINGS / EDGE_ROUNDINGS;

/// The projection onto the picture.
///
/// The direction of a pixel's ray is d + x h + y v, where x and y are in pixels from the eye's `middle`.
pub struct Viewport {
    pub eye: Eye,
    /// A power of two that scales all finite primitives to within a distance of 1 from the eye.
    pub scale: f64,
    /// The vectors whose dot products with a point at depth 1 are the point's x and y.
    pub axes: [DVec3; 2],
    /// Upper bound on the distance of the outermost pixel centres from the eye's `middle` along each axis, in pixels.
    pub far: DVec2,
    /// Upper bound on |d| + |x h| + |y v|, times [`TURNED`] if the eye is turned.
    pub max_direction_length: f64,
    pub screen: Screen,
}

impl Viewport {
    /// Returns `None` if numbers are too large or too small for the error bounds, or if the view is so narrow or so
    /// skewed that the error of a projected vertex may exceed a small fraction of a pixel. The last parameter is
    /// [`World::coincidence_reach_by_t`].
    pub fn new(
        eye: Eye,
        bounds: Aabb,
        size: [usize; 2],
        footprint: Footprint,
        [margin, per_t]: [f64; 2],
    ) -> Option<Self> {
        let distance = |corner: DVec3| (corner - eye.center).length();
        let farthest = bounds.corners().map(distance).into_iter().fold(0.0, f64::max);
        let scale = libm::ldexp(1.0, -libm::frexp(farthest).1);
        let axes = [eye.right, eye.up].map(|axis| axis / axis.length_squared());
        let [width, height] = size;
        let last = DVec2::new(width as f64, height as f64) - 1.0;
        // The `middle` of a turned eye is not exact.
        let clearance = if eye.is_turned { 1.0 } else { 0.0 };
        let far = eye.middle.abs().max((last - eye.middle).abs()) + clearance;
        let (across, along) = ((far.x + 0.5) * eye.right.length(), (far.y + 0.5) * eye.up.length());
        let allowed = if eye.is_turned { TURNED } else { 1.0 };
        let max_direction_length = allowed * (eye.direction.length() + across + along);
        let screen_error = triangle_bounds::screen_error_bound(&eye, axes, max_direction_length);
        let is_usual = (1e-60..1e60).contains(&scale)
            && max_direction_length < 1e12
            && screen_error < triangle_bounds::MAX_SCREEN_ERROR;
        // With n = 1 / t, a difference of e in t is a difference of less than e n^2 in n. The directions of rays are
        // no shorter than 1.
        let same_place = ErrorBound([0.0, per_t, margin * scale]);
        let screen = Screen { middle: eye.middle, width, reach: footprint.reach(), nothing: 0.0, same_place };
        is_usual.then_some(Self { eye, scale, axes, far, max_direction_length, screen })
    }

    /// Returns a point relative to the eye, scaled.
    pub fn eye_space(&self, point: DVec3) -> DVec3 {
        (point - self.eye.center) * self.scale
    }

    /// Returns the dot product of `normal` and a pixel's ray direction, as a function of the pixel.
    pub fn affine(&self, normal: DVec3) -> Affine {
        let Eye { direction, right, up, .. } = self.eye;
        Affine { constant: normal.dot(direction), per_x: normal.dot(right), per_y: normal.dot(up) }
    }
}

impl ScreenProjection for Viewport {
    fn screen(&self) -> Screen {
        self.screen
    }

    fn plane(&self, plane: &Plane) -> Option<InvDepthPlane> {
        Some(InvDepthPlane::of_plane(self, plane))
    }

    fn vertex(&self, point: DVec3) -> ScreenVertex {
        ScreenVertex::of(point, self)
    }

    fn are_outside<const N: usize>(&self, points: [DVec3; N]) -> bool {
        triangle_bounds::is_outside_frustum(self, points)
    }

    fn edge_functions(&self, corners: [DVec3; 3]) -> Option<EdgeFunctions> {
        EdgeFunctions::new(self, corners)
    }
}
