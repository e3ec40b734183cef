//! Close calls: decisions that different rounding could reverse, so another correct tracer may differ.

use super::objects::ObjectPart;
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::world::edge_functions::Sides;
use crate::world::shape::{Form, Shape};
use crate::world::triangle::Shear;
use crate::world::{Primitive, World};
use serde::Serialize;
use std::fmt;

/// The kind of a close call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CloseCallKind {
    /// The ray passes an edge of a triangle within the error bound of its edge function.
    Edge,
    /// The ray is tangent to a sphere or an ellipsoid.
    Tangent,
    /// The ray is parallel to a plane.
    Parallel,
    /// The ray hits something at the same distance as the visible hit.
    SameT,
    /// The ray hits something at its origin.
    Start,
    /// The ray hits something at the light.
    End,
    /// The cosine between a normal and a direction is about 0.
    Cosine,
    /// The point lies on a boundary between a checkerboard's squares.
    Boundary,
    /// The ray hits a surface at the critical angle of total internal reflection.
    Critical,
}

/// A decision that a few roundings could reverse.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CloseCall {
    /// The kind.
    pub kind: CloseCallKind,
    /// The object involved, if any.
    pub object: Option<ObjectPart>,
}

/// Cosines up to this are about 0. The scalar product of two rounded unit vectors is accurate to within half of it.
const COSINE_BOUND: f64 = 8.0 * UNIT_ROUNDOFF;

/// Two values of t closer than this many roundings of the coordinates involved count as equal.
const SAME_T_ROUNDINGS: f64 = 16.0;

/// A hit this close to the origin of a ray may be the surface that it leaves: secondary rays start up to 128 roundings
/// from it.
const START_ROUNDINGS: f64 = 256.0;

impl CloseCall {
    /// Makes a close call that involves no other object.
    pub(super) fn of(kind: CloseCallKind) -> Self {
        Self { kind, object: None }
    }
}

/// Returns true if a few roundings could change the byte of a channel.
pub fn is_about_to_change(channel: f64) -> bool {
    const ROUNDINGS: f64 = 16.0;
    let level = 255.0 * channel;
    let whole = level.round();
    (1.0..=255.0).contains(&whole) && (level - whole).abs() <= ROUNDINGS * UNIT_ROUNDOFF * whole
}

/// Returns true if a cosine is about 0.
pub fn is_about_zero(cosine: f64) -> bool {
    cosine.abs() <= COSINE_BOUND
}

/// The largest number of close calls reported for a ray.
const MAX_CLOSE_CALLS: usize = 1 << 8;

/// Returns the first primitives of the world with which a ray has a close call, except the one that it leaves. `sees`
/// is the primitive that it hits first, and its t. Examines every primitive.
pub fn close_primitives(
    world: &World,
    ray: &Ray,
    leaves: Option<u32>,
    sees: Option<(u32, f64)>,
) -> Vec<(CloseCallKind, u32)> {
    let search = Search { world, ray, sees, shear: Shear::new(ray) };
    let count = world.finite_count() + world.planes.len();
    (0..count as u32)
        .filter(|&id| leaves != Some(id))
        .filter_map(|id| search.close_call(id).map(|kind| (kind, id)))
        .take(MAX_CLOSE_CALLS)
        .collect()
}

struct Search<'a> {
    world: &'a World,
    ray: &'a Ray,
    sees: Option<(u32, f64)>,
    shear: Shear<'a>,
}

impl Search<'_> {
    fn close_call(&self, id: u32) -> Option<CloseCallKind> {
        // The part of the line that the ray could reach with different rounding.
        let far = self.sees.map_or(self.ray.t_max, |(_, t)| t);
        let margin = self.roundings(START_ROUNDINGS, if far.is_finite() { far } else { 0.0 });
        let reach = Ray { t_min: self.ray.t_min - margin, t_max: far + margin, ..*self.ray };
        match self.world.primitive(id) {
            Primitive::Triangle(i) => self.of_triangle(id, i, &reach),
            Primitive::Shape(i) => self.of_shape(id, &self.world.shapes[i], &reach),
            Primitive::Plane(i) => self.of_plane(id, i, &reach),
        }
    }

    fn of_triangle(&self, id: u32, i: usize, reach: &Ray) -> Option<CloseCallKind> {
        let corners = self.world.corners_in_place(i);
        match self.shear.sides(corners) {
            Sides::Outside => None,
            Sides::Unsure => self.overlaps(reach, i).then_some(CloseCallKind::Edge),
            Sides::Inside => self.shear.intersect(corners).and_then(|t| self.same_t(t, id)),
        }
    }

    fn of_shape(&self, id: u32, shape: &Shape, reach: &Ray) -> Option<CloseCallKind> {
        if shape.tangent_at(self.ray).is_some_and(|t| reach.covers(t)) {
            return Some(CloseCallKind::Tangent);
        }
        shape.roots(self.ray)?.into_iter().find_map(|t| self.same_t(t, id))
    }

    fn of_plane(&self, id: u32, i: usize, reach: &Ray) -> Option<CloseCallKind> {
        let plane = &self.world.planes[i];
        if is_about_zero(plane.normal.dot(self.ray.direction)) {
            let height = plane.ahead_of(self.ray.origin).abs();
            return (height <= self.roundings(START_ROUNDINGS, 0.0)).then_some(CloseCallKind::Parallel);
        }
        plane.intersect(reach).and_then(|t| self.same_t(t, id))
    }

    /// Returns `count` roundings of the coordinates at the ray's `t`.
    fn roundings(&self, count: f64, t: f64) -> f64 {
        let largest = self.ray.origin.abs().max_element() + self.world.max_abs_coord + t.abs();
        count * UNIT_ROUNDOFF * largest
    }

    fn same_t(&self, t: f64, id: u32) -> Option<CloseCallKind> {
        let near = |other: f64, count: f64| (t - other).abs() <= self.roundings(count, t);
        match self.sees {
            Some((sees, at)) if sees != id && near(at, SAME_T_ROUNDINGS) => Some(CloseCallKind::SameT),
            _ if near(self.ray.t_min, START_ROUNDINGS) => Some(CloseCallKind::Start),
            seen if near(self.ray.t_max, START_ROUNDINGS) && seen.is_none_or(|(sees, _)| sees == id) => {
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

impl fmt::Display for CloseCall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("close call: ")?;
        f.write_str(match self.kind {
            CloseCallKind::Edge => "within roundings the ray passes through an edge",
            CloseCallKind::Tangent => "within roundings the ray is tangent",
            CloseCallKind::Parallel => "within roundings the ray lies in a plane",
            CloseCallKind::SameT => "within roundings something else is as near",
            CloseCallKind::Start => "within roundings the ray starts in a surface",
            CloseCallKind::End => "within roundings the ray ends in a surface",
            CloseCallKind::Cosine => "the cosine between normal and direction is 0 within roundings",
            CloseCallKind::Critical => "the angle is that of total internal reflection within roundings",
            CloseCallKind::Boundary => "the point lies in a boundary of the checkerboard within roundings",
        })?;
        match &self.object {
            Some(object) => write!(f, ": {object}"),
            None => Ok(()),
        }
    }
}
