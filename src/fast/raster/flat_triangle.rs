//! Triangles in a picture without clipping: all of their vertices are projected to it.
//!
//! *Error bounds.* Let the error of a vertex, and of a ray, be at most e pixels along each axis. For vertices a and b
//! and a point q, the error of the edge function (a - q) x (b - q) is then at most 2.83 e (|a - q| + |b - q|) + 8 e^2.
//! The error of the interpolated nearness at a point within the triangle is at most the change that moving the
//! vertices and the ray makes: e for each axis times the slope. The roundings of both are far smaller if the
//! triangle's area exceeds the error of an edge function, and e is at least a billionth of the vertices' distances
//! from the middle of the picture.

use super::Affine;
use super::edge_functions::{EdgeFunctions, ErrorBound, InvDepthPlane};
use super::triangle_bounds::ScreenVertex;
use glam::DVec2;

/// The position of a point in a picture.
#[derive(Clone, Copy)]
pub struct Projected {
    /// The position in pixels, relative to the middle of the picture.
    pub at: DVec2,
    /// An affine function of `at` on each plane. It is larger for nearer points, and from 0 to 3 on the finite
    /// primitives.
    pub nearness: f64,
}

impl Projected {
    /// Returns the point as a vertex on a screen with this middle.
    pub fn on(self, middle: DVec2) -> ScreenVertex {
        ScreenVertex::at(self.at + middle, self.nearness)
    }
}

/// The error bound of a nearness: far more than the roundings of a number of at most 3.
pub const NEARNESS_ERROR: f64 = 3e-6;

/// Returns the edge functions of a triangle, with its nearness in place of the inverse depth, or `None` if it may be
/// seen edge on. The error of the corners is at most `screen_error` pixels along each axis.
pub fn edge_functions(corners: [Projected; 3], screen_error: f64) -> Option<EdgeFunctions> {
    let [a, b, c] = corners.map(|corner| corner.at);
    let area = (b - a).perp_dot(c - a);
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let edge_error_bound = 8.0 * screen_error * (longest + 2.0);
    if area.abs() <= 2.0 * edge_error_bound {
        return None;
    }
    let edges = [(b, c), (c, a), (a, b)].map(|(p, q)| {
        let along = area.signum() * (q - p);
        Affine { constant: along.y * p.x - along.x * p.y, per_x: -along.y, per_y: along.x }
    });
    let [x, y, z] = [0, 1, 2].map(|k| edges[k].scaled(corners[k].nearness / area.abs()));
    let nearness = x.plus(y).plus(z);
    let error = NEARNESS_ERROR + 4.0 * nearness.variation(screen_error);
    let inv_depth_plane = InvDepthPlane { inv_depth: nearness, error_bound: ErrorBound([error, 0.0, 0.0]) };
    Some(EdgeFunctions { edges, edge_error_bound, inv_depth_plane })
}
