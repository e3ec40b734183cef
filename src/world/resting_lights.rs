//! Point lights that lie on a surface.
//!
//! A ray from elsewhere to such a light ends on the surface, so roundings of the ray would decide whether it meets the
//! surface. This module decides it once for each light: an opaque surface shadows everything from a light that lies on
//! it, on both of its sides.

use super::World;
use super::point_error::weights;
use crate::math::exact::area_vector;
use crate::math::robust::{UNIT_ROUNDOFF, unit};
use crate::scene::Light;
use crate::world::plane::Plane;
use crate::world::shape::Shape;
use glam::DVec3;

/// The largest distance between a surface and a light that lies on it, in roundings of the largest of their
/// coordinates. It is added to the flattening error of the surface. It allows for the rounded coordinates of a light
/// that was computed to lie on the surface.
const RESTING_ROUNDINGS: f64 = 32.0;

/// A surface on which a light lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestingPlace {
    /// The primitive's id.
    pub primitive: u32,
    /// The outward normal at the light, for a round surface.
    outward: Option<DVec3>,
}

impl RestingPlace {
    /// Returns true if a ray to the light that meets this primitive meets it at the light. `leaves` is true if the ray
    /// goes outwards at the hit. A round surface has two crossings, and the ray goes outwards at only one of them.
    pub fn is_crossed(&self, primitive: u32, direction: DVec3, leaves: bool) -> bool {
        primitive == self.primitive
            && self.outward.is_none_or(|outward| (outward.dot(direction) >= 0.0) == leaves)
    }
}

impl World {
    /// Returns the surfaces on which the light with this index lies.
    #[inline(always)]
    pub fn primitives_at_light(&self, light: usize) -> &[RestingPlace] {
        self.resting_places.get(light).map_or(&[], Vec::as_slice)
    }

    /// Returns the surfaces on which each light lies.
    pub(super) fn find_resting_places(&self) -> Vec<Vec<RestingPlace>> {
        let places = |light: &Light| match *light {
            Light::Point { position, .. } => places_at(position, self),
            Light::Directional { .. } => vec![],
        };
        self.lights.iter().map(places).collect()
    }
}

/// Returns the surfaces on which a point lies, in the order of their ids.
fn places_at(point: DVec3, world: &World) -> Vec<RestingPlace> {
    let flat = |primitive| RestingPlace { primitive, outward: None };
    let mut found: Vec<_> = triangles_at(point, world).into_iter().map(flat).collect();
    let first_shape = world.triangles.len() as u32;
    found.extend((first_shape..).zip(&world.shapes).filter_map(|(primitive, shape)| {
        let outward = normal_at(point, shape, world.flattening_error(primitive, point).max_element())?;
        Some(RestingPlace { primitive, outward: Some(outward) })
    }));
    let planes = (world.first_plane()..).zip(&world.planes);
    let lies_on_plane = |&(id, plane): &(u32, &Plane)| {
        let flattening = world.flattening_error(id, point).length();
        plane.ahead_of(point).abs() <= margin(point, plane.offset.abs()) + flattening
    };
    found.extend(planes.filter(lies_on_plane).map(|(id, _)| flat(id)));
    found
}

/// Returns the outward normal of a shape at a point that lies on it, if the shape may have moved by `moved`.
fn normal_at(point: DVec3, shape: &Shape, moved: f64) -> Option<DVec3> {
    /// The number of steps. A step ends beside a flat shape if the point is beyond its rim, however close to its plane.
    const STEPS: usize = 3;
    let margin = margin(point, shape.form().extent()) + moved;
    let (center, _, inverse) = shape.form().unit_sphere_maps();
    let (mut place, mut outward) = (point, DVec3::ZERO);
    for _ in 0..STEPS {
        // The length is 1 on the surface, and the gradient gives the distance to it.
        let on_unit_sphere = inverse * (place - center);
        let length = on_unit_sphere.length();
        let gradient = inverse.transpose() * (on_unit_sphere / length);
        outward = unit(gradient);
        let height = (length - 1.0) / gradient.dot(outward);
        // Also false for a NaN.
        let is_close = height.abs() <= margin;
        if !is_close {
            return None;
        }
        place -= height * outward;
    }
    Some(outward)
}

/// Returns the triangles on which a point lies: inside them, on an edge or at a corner.
fn triangles_at(point: DVec3, world: &World) -> Vec<u32> {
    let mut found = vec![];
    let margin = margin(point, world.max_abs_coord) + world.largest_flattening_error();
    let to_bounds = point.clamp(world.bounds.min, world.bounds.max) - point;
    if world.triangles.is_empty() || to_bounds.abs().max_element() > margin {
        return found;
    }
    for (id, &[a, b, c]) in world.triangles.iter().enumerate() {
        // Most triangles lie to one side along one axis.
        let [a, b, c] = [a, b, c].map(|vertex| &world.vertices[vertex as usize]);
        let (x, y) = ([a.x, b.x, c.x], [a.y, b.y, c.y]);
        if is_beside(x, point.x, margin) || is_beside(y, point.y, margin) {
            continue;
        }
        if lies_on(point, id, world) {
            found.push(id as u32);
        }
    }
    found
}

/// Returns true if three coordinates are all less than another one, or all greater, by more than the margin.
#[inline(always)]
fn is_beside([a, b, c]: [f64; 3], point: f64, margin: f64) -> bool {
    a.min(b).min(c) > point + margin || a.max(b).max(c) < point - margin
}

fn margin(point: DVec3, extent: f64) -> f64 {
    RESTING_ROUNDINGS * UNIT_ROUNDOFF * point.abs().max_element().max(extent)
}

/// Returns true if a point lies on a triangle. No point lies on a triangle without area, which no ray hits.
///
/// Each corner's error is weighted by the corner's weight at the nearest point of the triangle, since a distant corner
/// has little influence at the light.
fn lies_on(point: DVec3, triangle: usize, world: &World) -> bool {
    let corners = world.corners(triangle);
    let errors = corners.map(|corner| {
        let flattening = world.flattening_error(triangle as u32, corner).max_element();
        margin(point, corner.abs().max_element()) + flattening
    });
    // Divided by the largest size, so that no product overflows, and no product that matters underflows.
    let relative = corners.map(|corner| corner - point);
    let unit = relative.iter().map(|v| v.abs().max_element()).fold(errors[0], f64::max);
    let relative = relative.map(|v| v / unit);
    let is_at_edge = [[0, 1], [1, 2], [2, 0]].into_iter().any(|[i, j]| {
        let (distance, part) = distance_to_edge([relative[i], relative[j]]);
        distance * unit <= (1.0 - part) * errors[i] + part * errors[j]
    });
    let is_inside = || {
        let [u, v, w] = weights(point, corners);
        is_above(relative) && height(relative) * unit <= u * errors[0] + v * errors[1] + w * errors[2]
    };
    (is_at_edge || is_inside()) && area_vector(corners).iter().any(|component| component.sign() != 0)
}

/// Returns the distance of the origin from an edge, and the part of the edge before the nearest point.
fn distance_to_edge([p, q]: [DVec3; 2]) -> (f64, f64) {
    let along = q - p;
    let square = along.length_squared();
    let nearest = if square > 0.0 { (-p.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    // From the nearer end, which has the smaller rounding error.
    let from_nearer = if nearest <= 0.5 { p + nearest * along } else { q - (1.0 - nearest) * along };
    (from_nearer.length(), nearest)
}

/// Returns true if the foot of the origin on a triangle's plane lies within the triangle.
fn is_above([a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    [[a, b], [b, c], [c, a]].into_iter().all(|[p, q]| p.cross(q).dot(normal) >= 0.0)
}

/// Returns the distance of the origin from a triangle's plane, measured from the nearest corner, which has the smallest
/// rounding error.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let nearest = [a, b, c].into_iter().min_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
    nearest.map_or(f64::INFINITY, |corner| corner.dot(normal).abs() / normal.length())
}
