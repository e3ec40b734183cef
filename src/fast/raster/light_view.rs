//! The picture of the finite primitives from a light: projects the points of the world into it.
//!
//! All of these primitives are inside the picture and well ahead of a point light, so nothing is clipped. The
//! coordinates of points are accurate to a small fraction of a pixel. Otherwise there is no such picture.

use super::edge_functions::{EdgeFunctions, ErrorBound};
use super::flat_triangle::{self, Projected};
use super::triangle_bounds::ScreenVertex;
use super::{Screen, ScreenProjection};
use crate::math::aabb::Aabb;
use crate::math::extremes::max;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::math::simd::ROUND_TO_INTEGER;
use crate::scene::Light;
use glam::{DVec2, DVec3};

/// Upper bound, in pixels, on the error of the pixel coordinates of a point, and on the distance in the picture
/// between the point and the ray from it to the light.
pub const SCREEN_ERROR: f64 = 1.0 / 1024.0;

/// The largest distance between the rays of a pixel and its centre: half a pixel, the error of both coordinates and
/// rays, and a margin.
const REACH: f64 = 0.5 + 1.0 / 64.0;

/// The margin in pixels between the primitives and the border of the picture.
const MARGIN: f64 = 2.0;

/// The largest ratio of a coordinate across the view of a point light to the depth.
const MAX_STEEPNESS: f64 = 4.0;

/// The error of a pixel coordinate is less than this many roundings of the coordinates involved, in pixels at the
/// least depth. A difference has one rounding, its product with an axis four, the depth and the division the same
/// number times [`MAX_STEEPNESS`], and the axes are orthogonal to within eight. The direction of a shadow ray has
/// five, and its origin is moved by at most 32.
const ROUNDINGS: f64 = 256.0;

/// The picture from a light.
#[derive(Clone, Copy, Debug)]
pub struct LightView {
    /// The light, or a point among the primitives if the light is infinitely far away.
    origin: DVec3,
    /// The unit vector from the light.
    toward: DVec3,
    /// The vectors to the right and up in the picture, in pixels per unit of length, or per unit of the tangent for a
    /// point light.
    axes: [DVec3; 2],
    /// The least depth of the primitives from a point light. `None` for a directional light.
    min_depth: Option<f64>,
    /// Upper bound on the distance of the primitives from `origin`.
    max_distance: f64,
    /// The largest coordinate of a point whose position in the picture is known.
    max_abs_position: f64,
    /// The number of pixels along each side.
    size: usize,
    /// Both coordinates of the middle of the picture. It is stored because to compute it from `size` for each point
    /// takes longer. The centres of pixels are at whole numbers.
    middle: f64,
}

impl LightView {
    /// Returns the picture of this box. Returns `None` if a point light is too close to the box, or if numbers are too
    /// large or too small.
    pub fn new(light: &Light, bounds: &Aabb, size: usize) -> Option<Self> {
        let center = 0.5 * (bounds.min + bounds.max);
        let (origin, toward, is_point) = match *light {
            Light::Directional { direction, .. } => (center, direction, false),
            Light::Point { position, .. } => (position, (center - position).normalize_or_zero(), true),
        };
        let corners = bounds.corners().map(|corner| corner - origin);
        let max_distance = 1.000_001 * corners.map(DVec3::length).into_iter().fold(0.0, f64::max);
        let min_depth = corners.map(|corner| corner.dot(toward)).into_iter().fold(f64::INFINITY, f64::min);
        let min_depth = is_point.then_some(min_depth);
        if min_depth.is_some_and(|depth| max_distance > MAX_STEEPNESS * depth) {
            return None;
        }
        let axes = across(toward, bounds.max - bounds.min);
        let middle = 0.5 * size as f64 - 0.5;
        let mut view =
            Self { origin, toward, axes, min_depth, max_distance, max_abs_position: 0.0, size, middle };
        let extent = bounds.corners().map(|corner| view.project(corner).at.abs());
        let extent = extent.into_iter().fold(DVec2::ZERO, DVec2::max);
        let scale = (0.5 * size as f64 - MARGIN) / extent;
        view.axes = [scale.x * view.axes[0], scale.y * view.axes[1]];
        view.max_abs_position = view.usable_position()?;
        let largest = bounds.min.abs().max(bounds.max.abs()).max(origin.abs()).max_element();
        (largest <= view.max_abs_position).then_some(view)
    }

    /// Returns the largest coordinate for which the errors are below [`SCREEN_ERROR`].
    fn usable_position(&self) -> Option<f64> {
        let per_unit = self.axes[0].length().max(self.axes[1].length()) / self.min_depth.unwrap_or(1.0);
        let largest = SCREEN_ERROR / (ROUNDINGS * UNIT_ROUNDOFF * per_unit);
        (1e-100..1e100).contains(&largest).then_some(largest)
    }

    /// Projects a point into the picture.
    #[inline(always)]
    pub fn project(&self, point: DVec3) -> Projected {
        let from_origin = point - self.origin;
        let depth = from_origin.dot(self.toward);
        let at = DVec2::new(from_origin.dot(self.axes[0]), from_origin.dot(self.axes[1]));
        match self.min_depth {
            Some(min_depth) => Projected { at: at / depth, nearness: min_depth / depth },
            None => Projected { at, nearness: 2.0 - depth / self.max_distance },
        }
    }

    /// Returns the pixel through which a ray from a point to the light passes the primitives. If the ray starts
    /// between the primitives and a point light, or behind the light, it hits none of them, so any pixel is correct.
    #[inline(always)]
    pub fn pixel(&self, point: DVec3) -> MapPlace {
        // Also false for a NaN.
        let is_usable = point.abs().max_element() <= self.max_abs_position;
        let place = self.project(point).at + self.middle;
        if !is_usable {
            MapPlace::Unknown
        } else if place.max_element() < 2.0 * self.middle + 0.5 {
            MapPlace::Pixel([nearest_pixel(place.x), nearest_pixel(place.y)])
        } else {
            MapPlace::Outside
        }
    }
}

impl ScreenProjection for LightView {
    fn screen(&self) -> Screen {
        // If several primitives are in one place, it does not matter which one blocks the light.
        Screen {
            middle: DVec2::splat(self.middle),
            width: self.size,
            reach: REACH,
            nothing: 0.0,
            same_place: ErrorBound::NONE,
        }
    }

    fn vertex(&self, point: DVec3) -> ScreenVertex {
        self.project(point).on(DVec2::splat(self.middle))
    }

    fn edge_functions(&self, corners: [DVec3; 3]) -> Option<EdgeFunctions> {
        flat_triangle::edge_functions(corners.map(|corner| self.project(corner)), SCREEN_ERROR)
    }
}

/// Returns the index of the pixel whose centre is nearest to a coordinate inside the picture or below it. A negative
/// coordinate or NaN becomes 0, which is in the margin.
#[inline(always)]
fn nearest_pixel(coordinate: f64) -> usize {
    // This is faster than to truncate with `as`, which must also handle NaN and numbers out of range.
    (max(coordinate, 0.0) + ROUND_TO_INTEGER).to_bits() as u32 as usize
}

/// The position of a ray to the light in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MapPlace {
    /// In this column and row.
    Pixel([usize; 2]),
    /// Outside the picture, beside all primitives.
    Outside,
    /// Rounding errors may be too large.
    Unknown,
}

/// Returns two unit vectors at right angles to `toward` and to each other. The first one is approximately along the
/// longest side of the box as seen along `toward`, so that an oblong box fills the picture.
fn across(toward: DVec3, sides: DVec3) -> [DVec3; 2] {
    let beside = DVec3::AXES.map(|axis| axis - axis.dot(toward) * toward);
    let seen = |k: usize| sides[k] * beside[k].length();
    let longest = (0..3).fold(0, |best, k| if seen(k) > seen(best) { k } else { best });
    let first = beside[longest].normalize_or_zero();
    [first, toward.cross(first).normalize_or_zero()]
}
