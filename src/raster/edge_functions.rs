//! A triangle's edges and how near it is, as functions of the pixel.
//!
//! With a, b and c a triangle's corners seen from the eye, the line of a ray along D passes within it where
//! the edge functions (b x c).D, (c x a).D and (a x b).D have one sign, and the ray hits it in front of
//! the eye where that is the sign of V = a.(b x c). The *nearness* there, which is one over t in lengths of
//! D, is the functions' sum over V. All are affine in a pixel's x and y (Olano and Greer, Triangle
//! scan conversion using 2D homogeneous coordinates, Graphics Hardware 1997).
//!
//! *Error bounds*, as `proofs/raster_edges.g` and `proofs/raster_depths.g` prove them. Let u = 2^-53 be
//! the unit roundoff, R the length of the longest of a, b and c, and L the canvas's reach.
//!
//! | quantity | at most | error at most |
//! |---|---|---|
//! | a, b, c | R | u R: a difference |
//! | b x c | R^2 | 4.62 u R^2: corners 2, a product 1, a difference 1, of terms that add up to 2 R^2 / sqrt(3) |
//! | (b x c).D | R^2 L | 4.62 u R^2 L for b x c; its coefficients 3, their sum 3; 6 for D |
//! | V | R^3 | 9.24 u R^3: 8 of terms that add up to 2 R^3 / sqrt(3) |
//!
//! D is off by a rounding of h and v here, and five roundings in the ray that is cast, beside its length. So an
//! edge function is off by less than 17 u R^2 L. Two additions, a division and a product more, a nearness n
//! is off by less than (64 u R^2 L + n 10 u R^3) / V where V is clearly not zero.
//!
//! *The t of the ray's test.* It is taken from weights w_i and depths z_i of the sheared corners where the
//! triangle is well seen: where (E_x + E_y) Z is at most 32 times its area A (twice the true one), E and Z being
//! its extents across and along. A sheared corner is off by 4.6 u R across. This moves the crossing by as much, on a
//! plane whose depth changes by at most (E_x + E_y) Z / A = 32 in that unit: by 147 u R. A weight is off by
//! 2 u |x y'| + 2 u |x' y| <= 4 u E_x E_y, and Z / A times three of them is at most 96 u (E_x + E_y) <= 544 u R. With u R of
//! a depth itself and 6 u Z + 2 u R for the formula that is less than 712 u R along the longest axis, so
//! 1234 u R along the ray. Elsewhere t is taken from the exact plane. Hence 1 / t, which is n in
//! lengths of D, is off by less than T_ROUNDINGS u R n of itself.

use super::{Affine, Viewport};
use crate::math::extremes::max3;
use crate::math::robust::UNIT_ROUNDOFF as U;
use crate::primitive::plane::Plane;
use glam::DVec3;
use std::ops::Range;

/// How near something is to the eye, and how far that may be off.
pub struct InvDepthPlane {
    pub inv_depth: Affine,
    pub error_bound: ErrorBound,
}

/// How far a function of the pixel may be off, beside single precision: a polynomial in its own value,
/// whose coefficients these are.
#[derive(Clone, Copy)]
pub struct ErrorBound(pub [f64; 3]);

impl ErrorBound {
    /// For values of this magnitude at most.
    pub fn at(self, bound: f64) -> f64 {
        let [constant, linear, square] = self.0;
        constant + (linear + square * bound) * bound
    }
}

/// How far an edge function may be off, in roundings of R^2 L.
const EDGE_ROUNDINGS: f64 = 17.0;
/// How far a nearness may be off, in roundings of R^2 L / V.
const INV_DEPTH_ROUNDINGS: f64 = 64.0;
/// How far V may be off, in roundings of R^3.
const VOLUME_ROUNDINGS: f64 = 10.0;
/// How many of its error bounds V has to be away from zero.
const VOLUME_CLEARANCE: f64 = 64.0;
/// How far the t that a ray's test finds may be off, in roundings of R / t, relatively.
const T_ROUNDINGS: f64 = 1250.0;
/// How far the nearness of a plane may be off, in roundings of L over its distance ahead.
const PLANE_ROUNDINGS: f64 = 19.0;

impl InvDepthPlane {
    /// Of a plane: its normal times the direction over its distance ahead.
    pub fn of_plane(viewport: &Viewport, plane: &Plane) -> Self {
        // The ray's test computes the same difference of the same numbers, so that its error changes nothing.
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

/// The normals of the planes through the eye and each edge, and V.
pub fn normals_and_volume([a, b, c]: [DVec3; 3]) -> ([DVec3; 3], f64) {
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    (normals, a.dot(normals[0]))
}

/// How far the V of corners that are at most so far from the eye may be off.
pub fn volume_error_bound(longest: f64) -> f64 {
    VOLUME_ROUNDINGS * U * longest * longest * longest
}

/// A triangle in front of the eye.
pub struct EdgeFunctions {
    /// Positive within the triangle.
    pub edges: [Affine; 3],
    pub edge_error_bound: f64,
    pub inv_depth_plane: InvDepthPlane,
}

impl EdgeFunctions {
    /// None where the eye may lie in the triangle's plane, so that signs mean nothing. All numbers are
    /// finite otherwise.
    pub fn new(viewport: &Viewport, corners: [DVec3; 3]) -> Option<Self> {
        /// Distances whose cubes keep their digits.
        const KNOWN: Range<f64> = 1e-9..2.0;
        let [a, b, c] = corners.map(|corner| viewport.eye_space(corner));
        let longest = max3([a.length_squared(), b.length_squared(), c.length_squared()]).sqrt();
        let (normals, volume) = normals_and_volume([a, b, c]);
        let volume_error_bound = volume_error_bound(longest);
        if !(KNOWN.contains(&longest) && volume.abs() > VOLUME_CLEARANCE * volume_error_bound) {
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
