//! Point lights that lie on a triangle: in its inside, on an edge or at a corner.
//!
//! The ray from a surface to such a light ends on the triangle, so that it would be roundings of the ray that decide
//! whether it meets the triangle. It is decided here once for each light: an opaque triangle shadows everything from a
//! light that lies on it, on both of its sides.

use super::World;
use super::point_error::weights;
use crate::math::predicate::area_vector;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::scene::Light;
use glam::DVec3;

/// How far from a triangle a light may be that lies on it, in roundings of the largest of their coordinates. The
/// corners of a triangle under transforms are off by a few roundings, and so is a light that was computed to lie on it.
const RESTING_ROUNDINGS: f64 = 32.0;

/// For each light the triangles that it lies on; empty if no light lies on any.
#[derive(Clone, Debug, Default)]
pub(super) struct RestingLights(Vec<Vec<u32>>);

impl RestingLights {
    pub(super) fn of(world: &World) -> Self {
        let triangles = |light: &Light| match *light {
            Light::Point { position, .. } => triangles_at(position, world),
            Light::Directional { .. } => vec![],
        };
        let all: Vec<_> = world.lights.iter().map(triangles).collect();
        let rests = all.iter().any(|triangles| !triangles.is_empty());
        Self(if rests { all } else { vec![] })
    }

    #[inline(always)]
    pub(super) fn triangles(&self, light: usize) -> &[u32] {
        self.0.get(light).map_or(&[], Vec::as_slice)
    }
}

/// The triangles on which a point lies.
fn triangles_at(point: DVec3, world: &World) -> Vec<u32> {
    let mut found = vec![];
    let margin = margin(point, DVec3::splat(world.max_abs_coord));
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
        if lies_on(point, [*a, *b, *c]) {
            found.push(id as u32);
        }
    }
    found
}

/// Whether three coordinates are all less than another one, or all greater, by more than the margin.
#[inline(always)]
fn is_beside([a, b, c]: [f64; 3], point: f64, margin: f64) -> bool {
    a.min(b).min(c) > point + margin || a.max(b).max(c) < point - margin
}

fn margin(point: DVec3, corner: DVec3) -> f64 {
    RESTING_ROUNDINGS * UNIT_ROUNDOFF * point.abs().max(corner.abs()).max_element()
}

/// Whether a point lies on a triangle. Nothing lies on one without area, which no ray hits.
///
/// Each corner's roundings count by its weight at the nearest point of the triangle, since a corner that is far away is not
/// where the light is.
fn lies_on(point: DVec3, corners: [DVec3; 3]) -> bool {
    let sizes = corners.map(|corner| corner.abs().max_element());
    let margin = |size: f64| margin(point, DVec3::splat(size));
    // Divided by the largest size, so that no product overflows, and none that matters underflows.
    let relative = corners.map(|corner| corner - point);
    let unit = relative.iter().map(|v| v.abs().max_element()).fold(margin(sizes[0]), f64::max);
    let relative = relative.map(|v| v / unit);
    let is_at_edge = [[0, 1], [1, 2], [2, 0]].into_iter().any(|[i, j]| {
        let (distance, part) = distance_to_edge([relative[i], relative[j]]);
        distance * unit <= margin((1.0 - part) * sizes[i] + part * sizes[j])
    });
    let is_inside = || {
        let [u, v, w] = weights(point, corners);
        is_above(relative) && height(relative) * unit <= margin(u * sizes[0] + v * sizes[1] + w * sizes[2])
    };
    (is_at_edge || is_inside()) && area_vector(corners).iter().any(|component| component.sign() != 0)
}

/// The distance of the origin from an edge, and the part of the edge before the nearest point.
fn distance_to_edge([p, q]: [DVec3; 2]) -> (f64, f64) {
    let along = q - p;
    let square = along.length_squared();
    let nearest = if square > 0.0 { (-p.dot(along) / square).clamp(0.0, 1.0) } else { 0.0 };
    // From the nearer end, which has the smaller rounding error.
    let from_nearer = if nearest <= 0.5 { p + nearest * along } else { q - (1.0 - nearest) * along };
    (from_nearer.length(), nearest)
}

/// Whether the foot of the origin on a triangle's plane lies within the triangle.
fn is_above([a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    [[a, b], [b, c], [c, a]].into_iter().all(|[p, q]| p.cross(q).dot(normal) >= 0.0)
}

/// The distance of the origin from a triangle's plane, measured from the nearest corner, which has the smallest
/// rounding error.
fn height([a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let nearest = [a, b, c].into_iter().min_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
    nearest.map_or(f64::INFINITY, |corner| corner.dot(normal).abs() / normal.length())
}
