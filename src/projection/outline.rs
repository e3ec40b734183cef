//! A triangle's edges and how near it is, as functions of the pixel.
//!
//! With a, b and c a triangle's corners seen from the eye, the line of a ray along D passes within it where
//! the edge functions (b x c).D, (c x a).D and (a x b).D have one sign, and the ray hits it in front of
//! the eye where that is the sign of V = a.(b x c). The *nearness* there, which is one over t in lengths of
//! D, is the functions' sum over V. All are affine in a pixel's x and y (Olano and Greer, Triangle
//! scan conversion using 2D homogeneous coordinates, Graphics Hardware 1997).
//!
//! *Error bound.* Let u = 2^-53 be the unit roundoff, R the length of the longest of a, b and c, and L
//! the canvas's reach.
//!
//! | quantity | at most | error at most |
//! |---|---|---|
//! | a, b, c | R | u R: a difference |
//! | b x c | R^2 | 5.5 u R^2: corners 2, products and a difference 3.5 |
//! | (b x c).D | R^2 L | 13.5 u R^2 L: b x c 5.5, coefficients 4, their sum 4 |
//! | D | L | 5 u L: so much the ray that is cast is off it, beside its length |
//! | V | R^3 | 10 u R^3 |
//!
//! So an edge function is off by less than 32 u R^2 L, a sum of three by 96 u R^2 L, and V by 16 u R^3. A
//! nearness n is off by less than twice (96 u R^2 L + n 16 u R^3) / V where V is clearly not zero. The
//! t that a ray's test computes is off by about a hundred roundings; 256 are allowed for.

use super::{Affine, Canvas};
use crate::math::extremes::greatest;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::primitive::plane::Plane;
use glam::DVec3;
use std::ops::Range;

/// How near something is to the eye, and how far that may be off.
pub struct Layer {
    pub nearness: Affine,
    /// By itself, and as a share of the nearness.
    pub margin: f64,
    pub share: f64,
}

/// By how much the t that a ray's test computes may be off.
const ROUNDINGS_OF_T: f64 = 256.0 * UNIT_ROUNDOFF;

impl Layer {
    /// Of a plane: its normal times the direction over its distance ahead.
    pub fn of_plane(canvas: &Canvas, plane: &Plane) -> Self {
        let center = canvas.eye.center;
        let ahead = canvas.scale * (plane.offset - plane.normal.dot(center));
        let off = 8.0 * UNIT_ROUNDOFF * canvas.scale * (plane.offset.abs() + center.length());
        Self {
            nearness: canvas.affine(plane.normal).scaled(1.0 / ahead),
            margin: 32.0 * UNIT_ROUNDOFF * canvas.reach / ahead.abs(),
            share: off / ahead.abs() + ROUNDINGS_OF_T,
        }
    }
}

/// A triangle in front of the eye.
pub struct Outline {
    /// Positive within the triangle.
    pub edges: [Affine; 3],
    /// How far they may be off.
    pub margin: f64,
    pub layer: Layer,
}

impl Outline {
    /// None where the eye may lie in the triangle's plane, so that signs mean nothing. All numbers are
    /// finite otherwise.
    pub fn new(canvas: &Canvas, corners: [DVec3; 3]) -> Option<Self> {
        /// Distances whose cubes keep their digits.
        const KNOWN: Range<f64> = 1e-9..2.0;
        let [a, b, c] = corners.map(|corner| canvas.seen(corner));
        let longest = greatest([a.length_squared(), b.length_squared(), c.length_squared()]).sqrt();
        let normals = [b.cross(c), c.cross(a), a.cross(b)];
        let volume = a.dot(normals[0]);
        let off = 16.0 * UNIT_ROUNDOFF * longest * longest * longest;
        if !(KNOWN.contains(&longest) && volume.abs() > 64.0 * off) {
            return None;
        }
        let inverse = 1.0 / volume.abs();
        let edges = normals.map(|normal| canvas.affine(volume.signum() * normal));
        let margin = 32.0 * UNIT_ROUNDOFF * longest * longest * canvas.reach;
        let layer = Layer {
            nearness: edges[0].plus(edges[1]).plus(edges[2]).scaled(inverse),
            margin: 6.0 * margin * inverse,
            share: 2.0 * off * inverse + ROUNDINGS_OF_T,
        };
        Some(Self { edges, margin, layer })
    }
}
