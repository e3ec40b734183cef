//! Conservative screen-space bounds of triangles, and of boxes around other primitives: the pixels whose rays may hit
//! them.
//!
//! This is the first step of rasterization. First all vertices are projected onto the picture. Then the bounds of each
//! triangle are computed from its projected vertices. A triangle that has a vertex beside or behind the eye is either
//! certainly outside the view frustum, or its bounds are the whole picture. `proofs/raster_bounds.g` proves that the
//! bounds leave out no pixel.

use super::viewport::Viewport;
use super::{Screen, ScreenProjection};
use crate::camera::Eye;
use crate::math::extremes::{max, min};
use crate::math::robust::UNIT_ROUNDOFF;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// A vertex projected onto the picture.
#[derive(Clone, Copy)]
pub struct ScreenVertex {
    /// The pixel coordinates in units of 1 / [`SUBPIXELS`], truncated.
    at: [i32; 2],
    /// The inverse of its depth in front of the eye, or one of the constants [`ASIDE`] and [`BEHIND`].
    inv_depth: f32,
}

/// The fixed-point resolution of screen coordinates per pixel. Integers compare faster than floats.
const SUBPIXELS: i32 = 64;

/// The inverse depth of a point so far from the viewing direction that it cannot be projected accurately.
const ASIDE: f32 = 0.0;
/// The inverse depth of a point that is certainly behind the eye.
const BEHIND: f32 = -1.0;

/// The largest ratio of a point's distance to its depth for which the point is projected.
pub const MAX_STEEPNESS: f64 = 1024.0;

/// The error bound of a screen coordinate from rounding a point's products and the division, in units of u times
/// the point's distance over its depth, times `max_direction_length` and the length of an axis.
pub const SCREEN_ROUNDINGS: f64 = 2.5;

/// The error bound of a screen coordinate from rounding the rays, the axis and the cosines in
/// [`screen_error_bound`], in units of u times the square of `max_direction_length` and the length of an axis.
const EYE_ROUNDINGS: f64 = 31.0;

/// The part of the allowed error that [`screen_error_bound`] may use, since it omits terms of second order.
const SCREEN_CLEARANCE: f64 = 0.9;

/// The largest error bound of screen coordinates, in pixels, with which a view is rasterized. The error is then less
/// than half of the padding of [`Span::around`]. The other half covers the truncation to fixed point.
pub const MAX_SCREEN_ERROR: f64 = SCREEN_CLEARANCE / SUBPIXELS as f64;

/// The error bound of a point's depth, in units of u times the point's distance.
pub const BEHIND_ROUNDINGS: f64 = 2.75;

/// Returns the error bound of screen coordinates in this view, in pixels. Errors come from rounding, and from the
/// eye's vectors, which are not quite orthogonal. This matters if the eye looks almost along the upward direction.
///
/// A coordinate along one axis is at most `max_direction_length` - 1 times the axis's length, or outside the
/// picture, and along the other axis at most [`MAX_STEEPNESS`] times. A cosine between two vectors changes
/// the depth by that fraction of both, and the coordinate in proportion.
pub fn screen_error_bound(eye: &Eye, axes: [DVec3; 2], max_direction_length: f64) -> f64 {
    let [right, up] = [eye.right, eye.up].map(DVec3::normalize);
    let cosines = DVec3::new(right.dot(up), right.dot(eye.direction), up.dot(eye.direction));
    let skew = cosines.abs().element_sum() * (MAX_STEEPNESS + max_direction_length);
    let roundings = SCREEN_ROUNDINGS * MAX_STEEPNESS + EYE_ROUNDINGS * max_direction_length;
    (skew + roundings * UNIT_ROUNDOFF) * max_direction_length * axes[0].length().max(axes[1].length())
}

impl ScreenVertex {
    /// Returns a vertex at these pixel coordinates.
    pub fn at(pixel: DVec2, inv_depth: f64) -> Self {
        // A coordinate far outside the picture may be clamped, since only comparisons with pixels matter.
        let at = (pixel * f64::from(SUBPIXELS)).to_array().map(|x| x.clamp(-1e9, 1e9) as i32);
        Self { at, inv_depth: inv_depth as f32 }
    }

    /// Projects a point of world space.
    pub fn of(point: DVec3, viewport: &Viewport) -> Self {
        let point = viewport.eye_space(point);
        let (depth, distance) = (point.dot(viewport.eye.direction), point.length());
        if MAX_STEEPNESS * depth > distance {
            let inv_depth = 1.0 / depth;
            Self::at(pixel_coordinates(point, inv_depth, viewport), inv_depth)
        } else {
            let is_behind = depth < -BEHIND_ROUNDINGS * UNIT_ROUNDOFF * distance;
            Self { at: [0; 2], inv_depth: if is_behind { BEHIND } else { ASIDE } }
        }
    }
}

/// Returns the screen coordinates of a point relative to the eye, in pixels.
#[inline(always)]
pub fn pixel_coordinates(point: DVec3, inv_depth: f64, viewport: &Viewport) -> DVec2 {
    let [right, up] = viewport.axes;
    DVec2::new(point.dot(right), point.dot(up)) * inv_depth + viewport.eye.middle
}

/// A triangle's id and its screen-space bounds: a rectangle of pixels outside which no ray hits it.
#[derive(Clone, Copy)]
pub struct TriangleBounds {
    pub id: u32,
    pub columns: Span,
    pub rows: Span,
    /// An upper bound on the inverse depth of the triangle's points.
    pub max_inv_depth: f32,
}

impl TriangleBounds {
    /// Returns the bounds of the primitive with these corners, which has the vertices `on_screen`, or `None` if it
    /// covers no pixel of these rows.
    #[inline]
    pub fn new<const N: usize>(
        view: &impl ScreenProjection,
        screen: &Screen,
        rows: &Range<usize>,
        on_screen: [ScreenVertex; N],
        corners: impl FnOnce() -> [DVec3; N],
        id: u32,
    ) -> Option<Self> {
        let [least, most] =
            on_screen.iter().fold([f32::INFINITY, f32::NEG_INFINITY], |[least, most], vertex| {
                [min(least, vertex.inv_depth), max(most, vertex.inv_depth)]
            });
        let all = 0..screen.width;
        if least > 0.0 {
            let [columns, rows] = [(0, &all), (1, rows)]
                .map(|(axis, pixels)| Span::around(on_screen, axis, pixels, screen.reach));
            let is_seen = !columns.is_empty() && !rows.is_empty();
            // The factor exceeds the error of single precision, so the result is an upper bound.
            is_seen.then_some(Self { id, columns, rows, max_inv_depth: 1.000_001 * most })
        } else if most < 0.0 || view.are_outside(corners()) {
            None
        } else {
            // Any pixel, at any depth.
            Some(Self { id, columns: Span::new(&all), rows: Span::new(rows), max_inv_depth: f32::INFINITY })
        }
    }

    /// Returns the number of pixels within the bounds.
    pub fn pixels(&self) -> usize {
        self.columns.range().len() * self.rows.range().len()
    }
}

/// The error bound of a point's signed distance from a side plane of the frustum, in units of u times the
/// point's distance from the eye, times the plane's coefficients.
pub const SIDE_ROUNDINGS: f64 = 4.3;

/// Returns true if all points certainly lie beyond one of the four side planes of the view frustum.
pub fn is_outside_frustum<const N: usize>(viewport: &Viewport, points: [DVec3; N]) -> bool {
    let points = points.map(|point| viewport.eye_space(point));
    (0..2).any(|k| {
        let axis = viewport.axes[k];
        // The plane runs a pixel and a half outside the last centre, which exceeds the error of a pixel's
        // ray.
        let border = viewport.far[k] + 1.5;
        let error_bound = SIDE_ROUNDINGS * UNIT_ROUNDOFF * (axis.length() + border);
        let beyond = |point: DVec3, sign: f64| {
            sign * point.dot(axis) > border * point.dot(viewport.eye.direction) + error_bound * point.length()
        };
        [1.0, -1.0].into_iter().any(|sign| points.into_iter().all(|point| beyond(point, sign)))
    })
}

/// A half-open range of columns or rows.
#[derive(Clone, Copy)]
pub struct Span {
    first: u16,
    end: u16,
}

/// The largest number of columns or rows that a [`Span`] can hold.
pub const MAX_PIXELS: usize = u16::MAX as usize;

impl Span {
    fn new(pixels: &Range<usize>) -> Self {
        Self { first: pixels.start as u16, end: pixels.end as u16 }
    }

    /// Returns the range of `pixels` whose centres lie between the vertices along an axis, or at most `reach` beside
    /// them, up to the error of both.
    #[inline(always)]
    pub fn around<const N: usize>(
        vertices: [ScreenVertex; N],
        axis: usize,
        pixels: &Range<usize>,
        reach: f64,
    ) -> Self {
        /// One subpixel for the error of a coordinate and one for its truncation.
        const PADDING: i32 = 2;
        let padding = PADDING + (reach * f64::from(SUBPIXELS)).ceil() as i32;
        let [least, most] = vertices.iter().fold([i32::MAX, i32::MIN], |[least, most], vertex| {
            [least.min(vertex.at[axis]), most.max(vertex.at[axis])]
        });
        let first = (least - padding + (SUBPIXELS - 1)) / SUBPIXELS;
        let last = (most + padding).div_euclid(SUBPIXELS);
        let [start, end] = [pixels.start as i32, pixels.end as i32];
        Self { first: first.clamp(start, end) as u16, end: (last + 1).clamp(start, end) as u16 }
    }

    fn is_empty(self) -> bool {
        self.first >= self.end
    }

    pub fn range(self) -> Range<usize> {
        usize::from(self.first)..usize::from(self.end)
    }
}

/// Returns true if a triangle's vertices run counter-clockwise on the screen, up to rounding. This only affects the
/// order of drawing.
pub fn is_front(corners: [ScreenVertex; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.at.map(i64::from));
    (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fast::raster::edge_functions::ErrorBound;

    /// Returns a viewport along -z of eight rows of eight pixels. Each pixel is an eighth wide at distance 1.
    fn viewport() -> Viewport {
        let (right, up) = (DVec3::X / 8.0, DVec3::Y / 8.0);
        let eye = Eye {
            center: DVec3::ZERO,
            direction: DVec3::NEG_Z,
            right,
            up,
            middle: DVec2::splat(3.5),
            is_turned: false,
        };
        Viewport {
            eye,
            scale: 1.0,
            axes: [8.0 * DVec3::X, 8.0 * DVec3::Y],
            far: DVec2::splat(3.5),
            max_direction_length: 2.0,
            screen: Screen {
                middle: DVec2::splat(3.5),
                width: 8,
                reach: 0.0,
                nothing: 0.0,
                same_place: ErrorBound::NONE,
            },
        }
    }

    /// Returns a point at this depth, this number of pixels beside the picture's middle.
    fn beside(x: f64, y: f64, depth: f64) -> DVec3 {
        depth * DVec3::new(x / 8.0, y / 8.0, -1.0)
    }

    #[test]
    fn only_what_is_well_ahead_is_projected() {
        const { assert!(BEHIND < ASIDE) };
        let inv_depth =
            |x: f64, depth: f64| ScreenVertex::of(DVec3::new(x, 0.0, -depth), &viewport()).inv_depth;
        for (x, depth) in [(0.0, 0.25), (1.0, 0.25), (1.0, 1.0 / 1000.0), (1.0, 2.0)] {
            assert_eq!(inv_depth(x, depth), (1.0 / depth) as f32, "{x} {depth}");
        }
        for (x, depth) in [(1.0, 1.0 / 1030.0), (1.0, 0.0), (1.0, 1e-16), (1.0, -1e-16), (1e-30, -1e-46)] {
            assert_eq!(inv_depth(x, depth), ASIDE, "{x} {depth}");
        }
        for (x, depth) in [(0.0, -1.0), (1.0, -1e-14), (1e-30, -1e-44), (1e-3, -1e-3)] {
            assert_eq!(inv_depth(x, depth), BEHIND, "{x} {depth}");
        }
    }

    #[test]
    fn a_point_takes_the_pixels_whose_centres_are_hardly_beside_it() {
        let columns = |parts: i32| {
            Span::around([ScreenVertex { at: [parts, 0], inv_depth: 1.0 }; 3], 0, &(0..8), 0.0).range()
        };
        for off in -2..=2 {
            assert_eq!(columns(5 * SUBPIXELS + off), 5..6, "{off}");
        }
        for off in [3, 4, 31, 32, 60, 61] {
            assert!(columns(5 * SUBPIXELS + off).is_empty(), "{off}");
        }
        assert!(columns(-SUBPIXELS).is_empty() && columns(8 * SUBPIXELS).is_empty());
        let spread = [-1000, 300, 200].map(|parts| ScreenVertex { at: [0, parts], inv_depth: 1.0 });
        assert_eq!(Span::around(spread, 1, &(2..8), 0.0).range(), 2..5);
    }

    #[test]
    fn only_what_lies_beyond_one_side_plane_is_outside_the_frustum() {
        let triangle = |x: f64, y: f64| {
            [beside(x, y, 0.25), beside(x + 0.1, y, 0.5), DVec3::new(x, y, 0.1 * (x.abs() + y.abs()))]
        };
        for (x, y) in [(5.1, 0.0), (-5.3, 1.0), (0.0, 5.1), (1.0, -5.1)] {
            assert!(is_outside_frustum(&viewport(), triangle(x, y)), "{x} {y}");
        }
        for (x, y) in [(4.9, 0.0), (-4.9, 1.0), (0.0, 4.9), (1.0, -4.9), (0.0, 0.0)] {
            assert!(!is_outside_frustum(&viewport(), triangle(x, y)), "{x} {y}");
        }
        let [left, right] = [-9.0, 9.0].map(|x| beside(x, 0.0, 0.5));
        assert!(!is_outside_frustum(&viewport(), [left, right, beside(0.0, 9.0, 0.5)]));
        // A triangle on the plane itself, or within some roundings of it, is not outside.
        let mut nearly = beside(5.0, 0.0, 0.5);
        for _ in 0..8 {
            assert!(!is_outside_frustum(&viewport(), [nearly; 3]), "{nearly}");
            nearly.x = nearly.x.next_up();
        }
    }

    #[test]
    fn screen_error_grows_as_the_angles_of_the_eye_are_less_right() {
        assert_eq!(MAX_SCREEN_ERROR * f64::from(SUBPIXELS), SCREEN_CLEARANCE);
        let eye = viewport().eye;
        let bound = |eye: &Eye| screen_error_bound(eye, viewport().axes, viewport().max_direction_length);
        let roundings = SCREEN_ROUNDINGS * MAX_STEEPNESS + EYE_ROUNDINGS * 2.0;
        assert_eq!(bound(&eye), roundings * UNIT_ROUNDOFF * 2.0 * 8.0);
        let skew = Eye { up: (DVec3::Y + 1e-8 * DVec3::Z) / 8.0, ..eye };
        let ratio = bound(&skew) / ((MAX_STEEPNESS + 2.0) * 2.0 * 8.0);
        assert!((1e-8..1.1e-8).contains(&ratio), "{ratio}");
    }

    /// In a view so wide that an axis is short, most of the error comes from the border.
    #[test]
    fn the_distance_from_a_side_plane_has_the_error_of_axis_and_border() {
        let eye = Eye { right: DVec3::X * 100.0, up: DVec3::Y * 100.0, ..viewport().eye };
        let wide = Viewport { eye, axes: [DVec3::X / 100.0, DVec3::Y / 100.0], ..viewport() };
        let outside = |part: f64| {
            // On the plane x / 100 = 5, and this number of error bounds beside it.
            let on_plane = DVec3::new(500.0, 0.0, -1.0);
            let bound = SIDE_ROUNDINGS * UNIT_ROUNDOFF * (0.01 + 5.0) * on_plane.length();
            is_outside_frustum(&wide, [on_plane + DVec3::X * 100.0 * part * bound; 3])
        };
        assert_eq!([0.1, 0.5, 0.9, 1.1, 2.0].map(outside), [false, false, false, true, true]);
    }
}
