//! The picture of an orthographic camera. Nothing is clipped, since such a camera also sees objects behind it.
//!
//! *Error bounds.* The error of a point's coordinates comes from the roundings of the point, the axes and the ray that
//! is cast, a few times the rounding of the largest coordinate, and from the camera's axes, which are not quite
//! orthogonal. The error of the distances along rays comes from the roundings of the ray's test, up to
//! [`T_ROUNDINGS`]. If the sum of all errors may exceed a small fraction of a pixel, or of the depth of the finite
//! primitives, there is no view.

use super::edge_functions::{EdgeFunctions, ErrorBound, InvDepthPlane};
use super::flat_triangle::{self, NEARNESS_ERROR, Projected};
use super::triangle_bounds::ScreenVertex;
use super::{Affine, Footprint, Screen, ScreenProjection};
use crate::camera::Eye;
use crate::math::aabb::Aabb;
use crate::math::robust::UNIT_ROUNDOFF as U;
use crate::world::edge_functions::T_ROUNDINGS;
use crate::world::plane::Plane;
use glam::{DVec2, DVec3};

/// The largest error of a coordinate, in pixels.
const MAX_SCREEN_ERROR: f64 = 1.0 / 1024.0;

/// The largest error of a depth, in units of the radius of the primitives' bounds.
const MAX_DEPTH_ERROR: f64 = 0.5 * NEARNESS_ERROR;

/// The error of a coordinate or a depth is less than this many roundings of the largest number involved.
const ROUNDINGS: f64 = 2.0 * T_ROUNDINGS;

/// The view of an orthographic camera.
pub struct ParallelView {
    eye: Eye,
    /// The vectors to the right and up in the picture, in pixels per unit of length.
    axes: [DVec3; 2],
    /// The middle of the primitives' bounds.
    middle: DVec3,
    /// Upper bound on the distance of the primitives from `middle`.
    radius: f64,
    /// The largest coordinate and distance involved.
    extent: f64,
    /// Upper bound on the error of the coordinates of a point and of a ray in the picture, in pixels.
    screen_error: f64,
    screen: Screen,
}

impl ParallelView {
    /// Returns `None` if errors may be too large. The last parameter is
    /// [`coincidence_reach_by_t`](crate::world::World::coincidence_reach_by_t).
    pub fn new(
        eye: Eye,
        bounds: &Aabb,
        width: usize,
        footprint: Footprint,
        [margin, per_t]: [f64; 2],
    ) -> Option<Self> {
        let middle = 0.5 * (bounds.min + bounds.max);
        let radius = 1.000_001 * (bounds.max - middle).length();
        let lengths = [eye.right, eye.up].map(DVec3::length);
        let across = (eye.middle.x + 1.0) * lengths[0] + (eye.middle.y + 1.0) * lengths[1];
        let distance = (middle - eye.center).length() + radius + across;
        let extent = distance + eye.center.abs().max_element();
        let [right, up] = [eye.right / lengths[0], eye.up / lengths[1]];
        let cosines = [right.dot(up), right.dot(eye.direction), up.dot(eye.direction)];
        let skew = cosines.map(f64::abs).iter().sum::<f64>();
        let error = (skew + ROUNDINGS * U) * extent;
        let pixels_per_unit = 1.0 / lengths[0].min(lengths[1]);
        let screen_error = pixels_per_unit * error + interpolation_error(pixels_per_unit * distance);
        let reach = footprint.reach();
        let same_place = ErrorBound([(margin + per_t * extent) / radius, 0.0, 0.0]);
        let screen = Screen { middle: eye.middle, width, reach, nothing: f32::NEG_INFINITY, same_place };
        // All comparisons are false for a NaN.
        let is_usual = (1e-100..1e100).contains(&radius)
            && (1e-100..1e100).contains(&pixels_per_unit)
            && screen_error < MAX_SCREEN_ERROR
            && error < MAX_DEPTH_ERROR * radius;
        let axes = [eye.right, eye.up].map(|step| step / step.length_squared());
        is_usual.then_some(Self { eye, axes, middle, radius, extent, screen_error, screen })
    }

    /// Projects a point into the picture.
    fn project(&self, point: DVec3) -> Projected {
        let across = point - self.eye.center;
        Projected {
            at: DVec2::new(across.dot(self.axes[0]), across.dot(self.axes[1])),
            nearness: 2.0 - (point - self.middle).dot(self.eye.direction) / self.radius,
        }
    }
}

impl ScreenProjection for ParallelView {
    fn screen(&self) -> Screen {
        self.screen
    }

    /// Returns the nearness of a plane, which has no limits.
    fn plane(&self, plane: &Plane) -> Option<InvDepthPlane> {
        let Eye { center, direction, right, up, .. } = self.eye;
        // The ray's test computes the same rate from the same numbers, so both share its error.
        let rate = plane.normal.dot(direction);
        let t = Affine {
            constant: plane.ahead_of(center) - (self.middle - center).dot(direction) * rate,
            per_x: -plane.normal.dot(right),
            per_y: -plane.normal.dot(up),
        };
        let depth = t.scaled(1.0 / (rate * self.radius));
        let nearness = Affine { constant: 2.0 - depth.constant, ..depth.scaled(-1.0) };
        let largest = self.extent + plane.offset.abs();
        let error_bound = ErrorBound([
            NEARNESS_ERROR + ROUNDINGS * U * largest / (rate * self.radius).abs(),
            ROUNDINGS * U,
            0.0,
        ]);
        Some(InvDepthPlane { inv_depth: nearness, error_bound })
    }

    fn vertex(&self, point: DVec3) -> ScreenVertex {
        self.project(point).on(self.screen.middle)
    }

    fn edge_functions(&self, corners: [DVec3; 3]) -> Option<EdgeFunctions> {
        flat_triangle::edge_functions(corners.map(|corner| self.project(corner)), self.screen_error)
    }
}

/// Returns the error of coordinates that is assumed for triangles up to this number of pixels from the middle, because
/// of the roundings of interpolated numbers. The linear part, a billionth, covers the roundings of
/// [`flat_triangle`](super::flat_triangle). With the quadratic part, the area of a triangle that is not seen edge on,
/// relative to the squared distance, is large enough for the error bound [`T_ROUNDINGS`] of the ray's t.
fn interpolation_error(pixels: f64) -> f64 {
    1e-9 * pixels + 1e-13 * pixels * pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_rational::BigRational;
    use num_traits::ToPrimitive;

    /// Returns a vector of exact numbers.
    fn exact(v: DVec3) -> [BigRational; 3] {
        v.to_array().map(|x| BigRational::from_float(x).unwrap())
    }

    fn number(x: f64) -> BigRational {
        BigRational::from_float(x).unwrap()
    }

    fn dot([a, b, c]: &[BigRational; 3], [d, e, f]: &[BigRational; 3]) -> BigRational {
        a * d + b * e + c * f
    }

    /// Returns the sum of a vector and `factor` times another one.
    fn moved(a: &[BigRational; 3], factor: &BigRational, b: &[BigRational; 3]) -> [BigRational; 3] {
        [0, 1, 2].map(|i| &a[i] + factor * &b[i])
    }

    /// Returns a view of a box of this size, at this distance from the origin.
    fn view(size: f64, far: f64) -> ParallelView {
        let middle = far * DVec3::new(1.0 / 3.0, -0.7, 0.3);
        let bounds = Aabb { min: middle - size, max: middle + size };
        let direction = DVec3::new(0.48, 0.6, 0.64);
        let (right, up) = (DVec3::new(-0.8, 0.0, 0.6) / 3.0, DVec3::new(0.36, -0.8, 0.48) / 3.0);
        let eye = Eye { center: middle, direction, right, up, middle: DVec2::splat(31.5), is_turned: false };
        ParallelView::new(eye, &bounds, 64, Footprint::Center, [0.0; 2]).unwrap()
    }

    /// Returns the error of a plane's nearness at a pixel, and its error bound.
    fn error_and_bound(view: &ParallelView, plane: &Plane, x: f64, y: f64) -> [f64; 2] {
        let Eye { center, direction, right, up, .. } = view.eye;
        let (normal, d) = (exact(plane.normal), exact(direction));
        let origin = moved(&moved(&exact(center), &number(x), &exact(right)), &number(y), &exact(up));
        // Use the same rate as the ray's test.
        let rate = number(plane.normal.dot(direction));
        let t = (number(plane.offset) - dot(&normal, &origin)) / rate;
        let from_middle = moved(&moved(&origin, &t, &d), &number(-1.0), &exact(view.middle));
        let nearness = number(2.0) - dot(&from_middle, &d) / number(view.radius);
        let computed = view.plane(plane).unwrap();
        let value = computed.inv_depth.at(x, y);
        let error = (number(value) - nearness).to_f64().unwrap().abs();
        [error, computed.error_bound.at(value.abs())]
    }

    #[test]
    fn the_nearness_of_a_plane_along_the_rays_is_within_its_error_bound() {
        let mut largest = 0.0f64;
        for far in [0.0, 1.0, 1e6, 1e9] {
            let view = view(1e4, far);
            for (k, tilt) in [1.0, 0.1, 1e-3, 1e-5, 1e-7, -1e-9].into_iter().enumerate() {
                let across = (view.eye.right + 0.3 * k as f64 * view.eye.up).normalize();
                let normal = (across + tilt * view.eye.direction).normalize();
                let offset = normal.dot(view.middle) + 0.1 * k as f64;
                for (x, y) in [(0.5, -3.5), (31.5, 31.5), (-31.5, 7.5)] {
                    let [error, bound] = error_and_bound(&view, &Plane { normal, offset }, x, y);
                    assert!(error <= bound, "{far} {tilt} {x} {y}: {error} {bound}");
                    largest = largest.max(error);
                }
            }
        }
        // The error is larger than for planes at right angles to the rays, so the bound must grow with the slope.
        assert!(largest > 10.0 * NEARNESS_ERROR, "{largest}");
    }

    #[test]
    fn there_is_no_view_with_large_errors() {
        let good = view(1.0, 0.0).eye;
        let bounds = |size: f64| Aabb { min: DVec3::splat(-size), max: DVec3::splat(size) };
        let is_drawn = |eye: Eye, size: f64| {
            ParallelView::new(eye, &bounds(size), 64, Footprint::Center, [0.0; 2]).is_some()
        };
        assert!(is_drawn(good, 1.0) && is_drawn(good, 1e-4) && is_drawn(good, 1e4));
        // The primitives are small, large, or far away, or the axes are not at right angles.
        assert!(!is_drawn(good, 1e-9) && !is_drawn(good, 1e5) && !is_drawn(good, 1e6));
        assert!(!is_drawn(Eye { center: DVec3::splat(1e12), ..good }, 1.0));
        assert!(!is_drawn(Eye { up: good.up + 1e-4 * good.right, ..good }, 1.0));
        // The depths are too inexact, though the pixels are large.
        let coarse = Eye { right: 1e5 * good.right, up: 1e5 * good.up, ..good };
        assert!(is_drawn(coarse, 1.0) && !is_drawn(Eye { center: DVec3::splat(1e9), ..coarse }, 1.0));
        assert!(is_drawn(Eye { center: DVec3::splat(1e9), ..coarse }, 1e4));
    }
}
