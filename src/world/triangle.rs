//! Triangles, by the watertight test of Woop, Benthin and Wald (JCGT 2(1), 2013), made exact: a hit is decided as if
//! there were no rounding. So a ray through an edge or a vertex that triangles of a closed mesh share hits exactly one
//! of them.
//!
//! This holds for all finite coordinates and directions. The t of a hit is accurate to within rounding, and
//! the normal has unit length. A triangle whose t would overflow counts as missed. The point of a hit is
//! accurate as long as no coordinate exceeds 2^500.

use crate::math::exact::{
    Scaled, area_vector, cross_component, edge_functions as exact_edge_functions, on_one_scale,
    projected_area, volume,
};
use crate::math::ray::Ray;
use crate::math::robust::unit;
use crate::math::simd::Number;
use crate::math::vector::Vector;
use crate::world::edge_functions::{
    Sides, edge_functions, is_depth_certain, is_interpolation_accurate, sheared,
};
use glam::DVec3;

/// The part of the test that depends only on the ray: the shear that maps its direction to the z axis, after a
/// permutation of the axes that makes the direction longest along z.
#[derive(Clone, Copy, Debug)]
pub struct Shear<'r> {
    ray: &'r Ray,
    axes: [usize; 3],
    /// The ray's origin, with its axes permuted.
    origin: Vector<f64>,
    /// The shear along x and y per unit of z.
    slopes: [f64; 2],
    /// The factor that converts a depth along z to t.
    t_per_depth: f64,
}

/// Returns the point of a triangle with these barycentric weights, which need not add up to one. Its error comes only
/// from rounding the vertices. So the point is at most this error beyond an edge, however distant the ray's origin is.
#[inline(always)]
pub fn point([a, b, c]: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    interpolated([a.into(), b.into(), c.into()], weights).into()
}

/// Returns the largest absolute coordinate of the corners.
#[inline(always)]
pub fn extent(corners: [DVec3; 3]) -> f64 {
    largest_coordinate(corners.map(Vector::from))
}

/// Computes [`extent`] in any number of lanes.
#[inline(always)]
pub(crate) fn largest_coordinate<N: Number>([a, b, c]: [Vector<N>; 3]) -> N {
    let Vector { x, y, z } = a.abs().max(b.abs()).max(c.abs());
    x.max(y).max(z)
}

/// Computes [`point`] in any number of lanes.
#[inline(always)]
pub(crate) fn interpolated<N: Number>([a, b, c]: [Vector<N>; 3], [u, v, w]: [N; 3]) -> Vector<N> {
    (a * u + b * v + c * w) / (u + v + w)
}

impl<'r> Shear<'r> {
    /// Returns the shear for a ray. A ray whose direction is zero or not finite misses every triangle.
    #[inline(always)]
    pub fn new(ray: &'r Ray) -> Self {
        let d = ray.direction.to_array();
        let [x, y, z] = d.map(f64::abs);
        // Without branches, because they would be unpredictable for rays in all directions.
        let z = usize::from(!((x > y) & (x > z))) + usize::from((z >= x) & (z >= y));
        static ACROSS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];
        let [x, y] = ACROSS[z];
        // No t is meaningful for a direction of infinite length. The NaN makes every triangle a miss.
        let t_per_depth = if d[z].is_finite() { 1.0 / d[z] } else { f64::NAN };
        let slopes = [d[x] / d[z], d[y] / d[z]];
        let o = ray.origin.to_array();
        Self { ray, axes: [x, y, z], origin: Vector { x: o[x], y: o[y], z: o[z] }, slopes, t_per_depth }
    }

    /// Maps a vertex to the sheared space: x and y are its distances from the ray, and z is its depth along the longest
    /// axis.
    #[inline(always)]
    fn apply(&self, vertex: &DVec3) -> Vector<f64> {
        // The vertex is indexed in place as an array. Indexing a glam vector branches, and a copy would be stored to
        // memory before it is indexed.
        let v: &[f64; 3] = vertex.as_ref();
        let [x, y, z] = self.axes;
        sheared(Vector { x: v[x], y: v[y], z: v[z] } - self.origin, self.slopes)
    }

    /// Returns the t at which the ray's line crosses the triangle, whatever its winding. It may be negative.
    ///
    /// The line crosses the triangle if the three edge functions have the same sign. A sign within the error bound is
    /// decided in exact arithmetic. If an edge function is exactly zero, its sign is decided as if the ray were moved
    /// by an infinitesimal amount. So two triangles never disagree about the edge they share, and a triangle without
    /// area, or one that contains the ray's direction, is missed without opening a gap.
    #[inline(always)]
    pub fn intersect(&self, corners: [&DVec3; 3]) -> Option<f64> {
        let (a, b, c) = self.sheared(corners);
        let [u, v, w] = edge_functions([a, b, c]);
        match Sides::new([u, v, w], [a, b, c]) {
            Sides::Outside => return None,
            Sides::Unsure => {
                let corners = corners.map(|&v| v);
                self.decide(corners)?;
                return self.exact_t(corners, [a.z, b.z, c.z]);
            }
            Sides::Inside => {}
        }
        let sum = u + v + w;
        // In this form another order of the vertices changes t by little more than its rounding error.
        let depth = a.z + (v * (b.z - a.z) + w * (c.z - a.z)) / sum;
        let t = self.t_per_depth * depth;
        // The sign of t is exact: it tells the side of the triangle on which the ray begins.
        if is_interpolation_accurate([a, b, c], sum)
            && is_depth_certain(depth, sum, [a, b, c])
            && t.is_finite()
        {
            return Some(t);
        }
        self.exact_t(corners.map(|&v| v), [a.z, b.z, c.z])
    }

    /// Returns the barycentric weights of the crossing up to a common factor. They are `None` exactly if
    /// [`intersect`](Self::intersect) finds no crossing, except for a t that overflows.
    #[inline(always)]
    pub fn weights(&self, corners: [&DVec3; 3]) -> Option<[f64; 3]> {
        let (a, b, c) = self.sheared(corners);
        let weights = edge_functions([a, b, c]);
        match Sides::new(weights, [a, b, c]) {
            Sides::Inside => Some(weights),
            Sides::Outside => None,
            Sides::Unsure => self.decide(corners.map(|&v| v)),
        }
    }

    /// Returns the point where the ray crosses the triangle with this unit normal, computed along the ray and moved
    /// into the triangle's plane. Its error is relative to its own coordinates, however far away the corners are.
    #[cold]
    pub fn precise_point(&self, corners: [&DVec3; 3], normal: DVec3) -> Option<DVec3> {
        let (a, b, c) = self.sheared(corners);
        let corners = corners.map(|&v| v);
        let along = self.ray.at(self.exact_t(corners, [a.z, b.z, c.z])?);
        let area = area_vector(corners);
        let largest = Scaled::largest(area);
        let length = DVec3::from_array(area.map(|x| x.over(largest))).length();
        Some(along + volume(along, corners).over(largest) / length * normal)
    }

    /// Returns the side of the edges on which the ray passes, as far as rounded numbers tell.
    pub fn sides(&self, corners: [&DVec3; 3]) -> Sides {
        let (a, b, c) = self.sheared(corners);
        Sides::new(edge_functions([a, b, c]), [a, b, c])
    }

    #[inline(always)]
    fn sheared(&self, [p, q, r]: [&DVec3; 3]) -> (Vector<f64>, Vector<f64>, Vector<f64>) {
        // Written out, because a mapped array would be stored to memory and loaded again.
        (self.apply(p), self.apply(q), self.apply(r))
    }

    /// Returns the t at which the ray crosses the triangle's plane, from exact determinants that are rounded before the
    /// division.
    #[cold]
    fn exact_t(&self, vertices: [DVec3; 3], depths: [f64; 3]) -> Option<f64> {
        let Ray { origin, direction, .. } = *self.ray;
        if !direction.is_finite() {
            return None;
        }
        let t = volume(origin, vertices).over(projected_area(direction, vertices));
        // Clamped to the rounded t of the vertices, so that triangles in one plane across an axis agree on t.
        let [p, q, r] = depths.map(|z| self.t_per_depth * z);
        let (min, max) = (p.min(q).min(r), p.max(q).max(r));
        let t = if min.is_finite() && max.is_finite() { t.max(min).min(max) } else { t };
        t.is_finite().then_some(t)
    }

    /// Returns the edge functions with exact signs, all divided by the same power of two, if the ray, moved by an
    /// infinitesimal amount, passes on the same side of all three edges.
    #[cold]
    fn decide(&self, vertices: [DVec3; 3]) -> Option<[f64; 3]> {
        let Ray { origin, direction, .. } = *self.ray;
        if ![origin, direction].iter().chain(&vertices).all(|v| v.is_finite()) {
            return None;
        }
        let weights = exact_edge_functions(origin, direction, vertices);
        let sides = [0, 1, 2].map(|i| match weights[i].sign() {
            0 => self.side_of_edge_met([vertices[(i + 1) % 3], vertices[(i + 2) % 3]]),
            side => side,
        });
        let inside = sides[0] != 0 && sides[0] == sides[1] && sides[1] == sides[2];
        inside.then(|| on_one_scale(weights))
    }

    /// Returns the side on which a ray passes an edge if it meets the edge's line exactly: as if the ray were moved in
    /// the sheared plane by an infinitesimal amount towards negative x, and by an infinitely smaller amount towards
    /// negative y. Returns zero for an edge that is parallel to the ray.
    fn side_of_edge_met(&self, edge: [DVec3; 2]) -> i32 {
        let (d, [x, y, z]) = (self.ray.direction, self.axes);
        let sheared = |axis: usize| cross_component(d, edge, [z, axis]).sign();
        [sheared(y), -sheared(x)].into_iter().find(|&side| side != 0).unwrap_or(0)
    }
}

/// Returns true if a triangle has an area. If rounded products do not decide, exact arithmetic does. No ray hits a
/// triangle without area.
#[inline(always)]
pub fn has_area([a, b, c]: [&DVec3; 3]) -> bool {
    // One coordinate of the normal decides for most triangles with an area.
    (b.x - a.x) * (c.y - a.y) != (b.y - a.y) * (c.x - a.x) || exactly_has_area([*a, *b, *c])
}

#[cold]
fn exactly_has_area(triangle: [DVec3; 3]) -> bool {
    area_vector(triangle).iter().any(|coordinate| coordinate.sign() != 0)
}

/// The squared tangent of the angle between two edges at which rounding the edges changes the normal by 2^-20.
const NEEDLE: f64 = 1.0 / (1u64 << 60) as f64;
/// The squared length of the cross product of two edges above which underflow does not matter.
const SHORT: f64 = 1e-280;

/// Returns the outward unit normal. The vertices run counter-clockwise seen from outside. Its error is at most 2^-20
/// for every triangle with an area, and it is NaN for a triangle without area.
#[inline(always)]
pub fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (normal, accurate) = rounded_normal([a.into(), b.into(), c.into()]);
    if accurate != 0 { normal.into() } else { exact_normal([a, b, c]) }
}

/// Returns the normal from rounded numbers, and the set of the lanes in which its error is at most 2^-20.
#[inline(always)]
pub(crate) fn rounded_normal<N: Number>([a, b, c]: [Vector<N>; 3]) -> (Vector<N>, u32) {
    let (p, q) = (b - a, c - a);
    let (normal, along) = (p.cross(q), p.dot(q));
    let square = normal.dot(normal);
    let splat = |number: f64| square.broadcast(number);
    let is_wide = (splat(NEEDLE) * (along * along) + splat(SHORT)).lt_mask(square);
    (normal.normalized(), is_wide & square.le_mask(splat(f64::MAX)))
}

#[cold]
fn exact_normal(triangle: [DVec3; 3]) -> DVec3 {
    unit(DVec3::from_array(on_one_scale(area_vector(triangle))))
}

#[cfg(test)]
mod tests;
