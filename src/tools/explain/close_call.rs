//! Finds close calls: decisions that different rounding could reverse, so another correct tracer may differ.

use super::explainer::Explainer;
use super::tree::{CloseCall, CloseCallKind};
use crate::math::ray::{Hit, Ray};
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::edge_functions::Sides;
use crate::world::shape::{Shape, UnitSphereMaps};
use crate::world::triangle::Shear;
use crate::world::{Primitive, World};

/// Cosines up to this are about 0. The scalar product of two rounded unit vectors is accurate to within half of it.
const COSINE_BOUND: f64 = 8.0 * UNIT_ROUNDOFF;

/// Two values of t closer than this many roundings of the coordinates involved count as equal.
const SAME_T_ROUNDINGS: f64 = 16.0;

/// A hit this close to the origin of a ray may be the surface that it leaves: secondary rays start up to 128 roundings
/// from it.
const START_ROUNDINGS: f64 = 256.0;

/// A line whose distance from a sphere's surface is at most this many roundings is tangent.
const TANGENT_ROUNDINGS: f64 = 16.0;

/// Returns true if a cosine is about 0.
pub fn is_about_zero(cosine: f64) -> bool {
    cosine.abs() <= COSINE_BOUND
}

/// The largest number of close calls reported for a ray.
const MAX_CLOSE_CALLS: usize = 1 << 8;

impl Explainer<'_, '_> {
    /// Returns the first close calls of a ray with primitives other than the one that it leaves. `sees` is its first hit.
    /// Examines every primitive.
    pub fn close_calls(&self, ray: &Ray, origin_primitive: Option<u32>, sees: Option<Hit>) -> Vec<CloseCall> {
        let search = Search { world: self.world, ray, sees, shear: Shear::new(ray) };
        let others = self.world.ids().filter(|&id| origin_primitive != Some(id));
        let found = others.filter_map(|id| {
            let kind = search.close_call(id)?;
            Some(CloseCall { kind, object: Some(self.object(id)) })
        });
        found.take(MAX_CLOSE_CALLS).collect()
    }
}

struct Search<'a> {
    world: &'a World,
    ray: &'a Ray,
    sees: Option<Hit>,
    shear: Shear<'a>,
}

impl Search<'_> {
    fn close_call(&self, id: u32) -> Option<CloseCallKind> {
        // The part of the line that the ray could reach with different rounding.
        let far = self.sees.map_or(self.ray.t_max, |hit| hit.t);
        let margin = self.roundings(START_ROUNDINGS, if far.is_finite() { far } else { 0.0 });
        let reach = Ray { t_min: self.ray.t_min - margin, t_max: far + margin, ..*self.ray };
        match self.world.primitive(id) {
            Primitive::Triangle(i) => {
                let corners = self.world.corners_in_place(i);
                match self.shear.sides(corners) {
                    Sides::Outside => None,
                    Sides::Unsure => self.overlaps(&reach, i).then_some(CloseCallKind::Edge),
                    Sides::Inside => self.same_t(self.shear.intersect(corners)?, id),
                }
            }
            Primitive::Shape(i) => {
                let shape = &self.world.shapes[i];
                if tangent_at(shape, self.ray).is_some_and(|t| reach.covers(t)) {
                    return Some(CloseCallKind::Tangent);
                }
                shape.form().roots(self.ray)?.into_iter().find_map(|t| self.same_t(t, id))
            }
            Primitive::Plane(i) => {
                let plane = &self.world.planes[i];
                if is_about_zero(plane.normal.dot(self.ray.direction)) {
                    let height = plane.ahead_of(self.ray.origin).abs();
                    let is_in_plane = height <= self.roundings(START_ROUNDINGS, 0.0);
                    return is_in_plane.then_some(CloseCallKind::Parallel);
                }
                self.same_t(plane.intersect(&reach)?, id)
            }
        }
    }

    /// Returns `count` roundings of the coordinates at the ray's `t`.
    fn roundings(&self, count: f64, t: f64) -> f64 {
        let largest = self.ray.origin.abs().max_element() + self.world.max_abs_coord + t.abs();
        count * UNIT_ROUNDOFF * largest
    }

    fn same_t(&self, t: f64, id: u32) -> Option<CloseCallKind> {
        let near = |other: f64, count: f64| (t - other).abs() <= self.roundings(count, t);
        match self.sees {
            Some(hit) if hit.primitive != id && near(hit.t, SAME_T_ROUNDINGS) => Some(CloseCallKind::SameT),
            _ if near(self.ray.t_min, START_ROUNDINGS) => Some(CloseCallKind::Start),
            seen if near(self.ray.t_max, START_ROUNDINGS) && seen.is_none_or(|hit| hit.primitive == id) => {
                Some(CloseCallKind::End)
            }
            _ => None,
        }
    }

    /// Returns true if the range of t of a triangle's corners overlaps the ray.
    fn overlaps(&self, reach: &Ray, triangle: usize) -> bool {
        let corners = self.world.corners(triangle);
        let t = corners.map(|corner| (corner - reach.origin).dot(reach.direction));
        let (first, last) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
        let exact = self.shear.intersect(self.world.corners_in_place(triangle));
        exact.map_or(first < reach.t_max && last >= reach.t_min, |t| reach.covers(t))
    }
}

/// Returns the t at which the line of a ray with a unit direction is tangent to a shape within roundings.
fn tangent_at(shape: &Shape, ray: &Ray) -> Option<f64> {
    let UnitSphereMaps { center, inverse, .. } = shape.form().unit_sphere_maps();
    let (o, d) = (inverse * (ray.origin - center), inverse * ray.direction);
    let (moment, length) = (o.cross(d).length(), d.length());
    let is_tangent =
        (moment - length).abs() <= TANGENT_ROUNDINGS * UNIT_ROUNDOFF * (o.length() * length + length);
    is_tangent.then(|| (center - ray.origin).dot(ray.direction))
}
