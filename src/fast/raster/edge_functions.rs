//! The edge functions and the inverse depth of a triangle, as affine functions of the pixel.
//!
//! The rasterizer computes them once per triangle and tile (Olano and Greer, "Triangle Scan Conversion using 2D
//! Homogeneous Coordinates", Graphics Hardware 1997). Let a, b and c be a triangle's corners relative to the eye. The
//! line through the eye along D passes through the triangle if the edge functions (b x c).D, (c x a).D and (a x b).D
//! have the same sign. The hit is in front of the eye if V = a.(b x c) has this sign, too. V is six times the signed
//! volume of the tetrahedron of the triangle and the eye. The *inverse depth*, 1 / t with t in units of the length of
//! D, is the sum of the edge functions over V.
//!
//! *Error bounds*, proved by `proofs/raster_edges.g` and `proofs/raster_depths.g`. Let u = 2^-53 be the unit
//! roundoff, R the length of the longest of a, b and c, and L the viewport's `max_direction_length`.
//!
//! | quantity | its magnitude is at most | its error is at most |
//! |---|---|---|
//! | a, b, c | R | u R, for one difference |
//! | b x c | R^2 | 4.47 u R^2: 3 roundings (corners 2, product) of terms <= 2 R^2 / sqrt(3), 1 for the difference |
//! | (b x c).D | R^2 L | 4.47 u R^2 L from b x c, 3 for the coefficients, 3 for their sum, 6 for D |
//! | V | R^3 | 8.47 u R^3: 4.47 from b x c, 1 for a, 3 for the product |
//!
//! The 6 roundings of D are one in the pixel's steps `right` and `up` here, and five in the ray that is cast, whose
//! length does not matter. Hence the error of an edge function is less than 16.5 u R^2 L. The inverse depth n takes
//! two more additions, a division and a product, but the sum of its three normals is at most 2.6 R^2, to which most of
//! the roundings apply. If V is clearly not zero, the error of n is less than (47.5 u R^2 L + n 8.5 u R^3) / V.
//!
//! If V is clearly not zero, the relative error of the t of the ray's own test is less than `T_ROUNDINGS` u R / t, as
//! `proofs/triangle_t.g` proves. n is 1 / t.

use super::Affine;
use super::viewport::Viewport;
use crate::math::extremes::max3;
use crate::math::robust::UNIT_ROUNDOFF as U;
use crate::world::edge_functions::T_ROUNDINGS;
use crate::world::plane::Plane;
use glam::DVec3;
use std::ops::Range;

/// The inverse depth of a triangle or a plane as a function of the pixel, with its error bound.
pub struct InvDepthPlane {
    pub inv_depth: Affine,
    pub error_bound: ErrorBound,
}

/// The error bound of a function of the pixel, without the errors of single precision. It is a polynomial in the
/// magnitude of the function, given by its coefficients from the constant term on.
#[derive(Clone, Copy)]
pub struct ErrorBound(pub [f64; 3]);

impl ErrorBound {
    pub const NONE: Self = Self([0.0; 3]);

    /// Returns the error bound for values whose magnitude is at most `max_abs`.
    pub fn at(self, max_abs: f64) -> f64 {
        let [constant, linear, square] = self.0;
        constant + (linear + square * max_abs) * max_abs
    }

    /// Returns the bound of the sum of two errors.
    pub fn plus(self, other: Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.0, other.0);
        Self([a + d, b + e, c + f])
    }
}

/// The error bound of an edge function, in units of u R^2 L.
pub const EDGE_ROUNDINGS: f64 = 16.5;
/// The error bound of an inverse depth, without the error of V, in units of u R^2 L / V.
const INV_DEPTH_ROUNDINGS: f64 = 47.5;
/// The error bound of V, in units of u R^3.
const VOLUME_ROUNDINGS: f64 = 8.5;
/// The least ratio of V to its error bound for which the sign of V is known and a division by V is accurate.
const VOLUME_CLEARANCE: f64 = 1024.0;
/// The error bound of a plane's inverse depth, in units of u L over the plane's distance from the eye.
const PLANE_ROUNDINGS: f64 = 19.0;

impl InvDepthPlane {
    /// Returns the inverse depth of a plane: normal.D over the distance from the eye to the plane along the normal.
    pub fn of_plane(viewport: &Viewport, plane: &Plane) -> Self {
        // The ray's test computes the same distance from the same numbers, so both share its error.
        let ahead = viewport.scale * plane.ahead_of(viewport.eye.center);
        Self {
            inv_depth: viewport.affine(plane.normal).scaled(1.0 / ahead),
            error_bound: ErrorBound([
                PLANE_ROUNDINGS * U * viewport.max_direction_length / ahead.abs(),
                0.0,
                0.0,
            ]),
        }
    }
}

/// Returns the normals of the planes through the eye and each edge, and V, for corners relative to the eye.
pub fn normals_and_volume([a, b, c]: [DVec3; 3]) -> ([DVec3; 3], f64) {
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    (normals, a.dot(normals[0]))
}

/// Returns the error bound of V for corners whose distance from the eye is at most `longest`.
pub fn volume_error_bound(longest: f64) -> f64 {
    VOLUME_ROUNDINGS * U * longest * longest * longest
}

/// The edge functions and the inverse depth of a triangle.
pub struct EdgeFunctions {
    /// The edge functions, with the sign that makes them positive within a triangle in front of the eye.
    pub edges: [Affine; 3],
    pub edge_error_bound: f64,
    pub inv_depth_plane: InvDepthPlane,
}

impl EdgeFunctions {
    /// Returns `None` if the eye may lie in the triangle's plane. The sign of V, and with it every other sign, is then
    /// unknown. Otherwise all numbers of the result are finite.
    pub fn new(viewport: &Viewport, corners: [DVec3; 3]) -> Option<Self> {
        /// Distances whose cubes neither underflow nor overflow.
        const USABLE_DISTANCES: Range<f64> = 1e-9..2.0;
        let [a, b, c] = corners.map(|corner| viewport.eye_space(corner));
        let longest = max3([a.length_squared(), b.length_squared(), c.length_squared()]).sqrt();
        let (normals, volume) = normals_and_volume([a, b, c]);
        let volume_error_bound = volume_error_bound(longest);
        let is_clear = volume.abs() > VOLUME_CLEARANCE * volume_error_bound;
        if !(USABLE_DISTANCES.contains(&longest) && is_clear) {
            return None;
        }
        let inverse = 1.0 / volume.abs();
        let edges = normals.map(|normal| viewport.affine(volume.signum() * normal));
        let product = U * longest * longest * viewport.max_direction_length;
        let inv_depth_plane = InvDepthPlane {
            inv_depth: edges[0].plus(edges[1]).plus(edges[2]).scaled(inverse),
            error_bound: ErrorBound([
                INV_DEPTH_ROUNDINGS * product * inverse,
                volume_error_bound * inverse,
                T_ROUNDINGS * U * longest,
            ]),
        };
        Some(Self { edges, edge_error_bound: EDGE_ROUNDINGS * product, inv_depth_plane })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Eye;
    use crate::fast::raster::Screen;
    use glam::DVec2;

    #[test]
    fn the_error_of_a_plane_grows_with_the_longest_direction_and_falls_with_its_distance() {
        let eye = Eye {
            center: DVec3::ZERO,
            direction: DVec3::NEG_Z,
            right: DVec3::X,
            up: DVec3::Y,
            middle: DVec2::splat(3.5),
            is_turned: false,
        };
        let viewport = Viewport {
            eye,
            scale: 0.5,
            axes: [DVec3::X, DVec3::Y],
            far: DVec2::splat(3.5),
            max_direction_length: 3.0,
            screen: Screen {
                middle: eye.middle,
                width: 8,
                reach: 0.0,
                nothing: 0.0,
                same_place: ErrorBound::NONE,
            },
        };
        let inv_depth_plane = InvDepthPlane::of_plane(&viewport, &Plane { normal: DVec3::Z, offset: -4.0 });
        assert_eq!(inv_depth_plane.error_bound.0, [PLANE_ROUNDINGS * U * 3.0 / 2.0, 0.0, 0.0]);
        assert_eq!(inv_depth_plane.inv_depth.at(0.0, 0.0), 0.5);
    }

    #[test]
    fn the_error_of_a_volume_grows_with_the_cube_of_the_distance() {
        assert_eq!(volume_error_bound(4.0), 64.0 * VOLUME_ROUNDINGS * U);
    }
}
