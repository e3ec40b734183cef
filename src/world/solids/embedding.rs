//! Which meshes are embedded, that is, bound a solid and do not touch themselves.

use super::contact::{MeshFace, meet_properly, segment_misses};
use super::neighbors::all_overlapping;
use super::orientation::side;
use super::{MARGIN, Solid, has_balanced_edges, sorted_edges};
use crate::math::aabb::Aabb;
use crate::math::predicate::projected_area;
use crate::math::ray::Ray;
use crate::primitive::triangle::{self, Shear};
use crate::world::World;
use glam::DVec3;
use std::ops::Range;

/// The maximum number of triangles of a mesh, and of times that one of them is compared with a component.
const MAX_TRIANGLES: usize = 1 << 20;
const MAX_VISITS: usize = 1 << 24;

/// The solid that a mesh bounds, if its triangles meet only at the vertices and the edges that they share, and its
/// winding number is one behind and zero before each of them.
pub fn embedded(world: &World, ids: &Range<u32>) -> Option<Solid> {
    let triangles = &world.triangles[ids.start as usize..ids.end as usize];
    if triangles.is_empty() || triangles.len() > MAX_TRIANGLES {
        return None;
    }
    let edges = sorted_edges(triangles);
    let mesh = Mesh::new(world, triangles);
    let is_embedded = has_balanced_edges(&edges)
        && mesh.faces().all(|face| face.axis().is_some())
        && all_overlapping(&mesh.boxes, |i, j| meet_properly(&mesh.face(i), &mesh.face(j)))
        && mesh.is_around_its_inside(&components(triangles.len(), &edges));
    let bounds = mesh.boxes.iter().fold(Aabb::EMPTY, |all, &bounds| all.union(bounds));
    is_embedded.then(|| Solid { ids: ids.clone(), bounds, is_simple: true })
}

/// One face of each component. Faces of a component are connected by edges that only two faces have.
fn components(count: usize, edges: &[(u64, u32)]) -> Vec<u32> {
    let mut parents: Vec<u32> = (0..count as u32).collect();
    for uses in edges.chunk_by(|one, other| one.0 == other.0) {
        if let [one, other] = uses {
            let [one, other] = [one, other].map(|edge| root(&mut parents, edge.1 >> 1));
            parents[one as usize] = other;
        }
    }
    (0..count as u32).filter(|&face| parents[face as usize] == face).collect()
}

/// The face that stands for a face's component so far. The way to it is halved.
fn root(parents: &mut [u32], mut face: u32) -> u32 {
    while parents[face as usize] != face {
        let above = parents[parents[face as usize] as usize];
        parents[face as usize] = above;
        face = above;
    }
    face
}

/// The triangles of a mesh with their boxes.
struct Mesh<'w> {
    world: &'w World,
    triangles: &'w [[u32; 3]],
    boxes: Vec<Aabb>,
}

impl<'w> Mesh<'w> {
    fn new(world: &'w World, triangles: &'w [[u32; 3]]) -> Self {
        let corners = |face: &[u32; 3]| face.map(|i| world.vertices[i as usize]);
        let boxes = triangles.iter().map(|face| Aabb::around(corners(face))).collect();
        Self { world, triangles, boxes }
    }

    #[inline]
    fn face(&self, index: usize) -> MeshFace {
        let ids = self.triangles[index];
        MeshFace { ids, corners: ids.map(|i| self.world.vertices[i as usize]) }
    }

    fn faces(&self) -> impl Iterator<Item = MeshFace> + '_ {
        (0..self.triangles.len()).map(|index| self.face(index))
    }

    /// The faces whose boxes touch a box.
    fn near(&self, bounds: Aabb) -> impl Iterator<Item = (usize, MeshFace)> + '_ {
        let touches = move |with: &Aabb| bounds.min.cmple(with.max).all() && with.min.cmple(bounds.max).all();
        let near = (0..self.boxes.len()).filter(move |&index| touches(&self.boxes[index]));
        near.map(|index| (index, self.face(index)))
    }

    /// Whether the winding number is zero before each of these faces, as far as this can be told.
    fn is_around_its_inside(&self, faces: &[u32]) -> bool {
        faces.len().saturating_mul(self.triangles.len()) <= MAX_VISITS
            && faces.iter().all(|&face| self.winding_number_before(face as usize) == Some(0))
    }

    /// The winding number before a face; none if it is not certain. It is that of a point close to the face, if nothing
    /// is between the two.
    fn winding_number_before(&self, index: usize) -> Option<i32> {
        let face = self.face(index);
        // Not the centre, which is often exactly before an edge.
        let inner = triangle::point(face.corners, [0.52, 0.29, 0.19]);
        let step = MARGIN * self.world.max_abs_coord * triangle::normal(face.corners);
        let ends = [inner + step, inner - step];
        let sides = |of: &MeshFace| ends.map(|end| side(of.corners, end));
        let is_before = sides(&face) == [1, -1] && !segment_misses(ends, [1, -1], &face);
        let is_close = is_before
            && self
                .near(Aabb::around(ends))
                .all(|(other, with)| other == index || segment_misses(ends, sides(&with), &with));
        if is_close { self.winding_number(ends[0]) } else { None }
    }

    /// The winding number of a point: the number of faces by which a ray from there leaves, minus the number of those
    /// by which it enters. None if the point is in the plane of a face that the ray's line crosses.
    fn winding_number(&self, point: DVec3) -> Option<i32> {
        let ray = Ray::new(point, DVec3::X);
        let shear = Shear::new(&ray);
        let ahead = Aabb { min: point, max: point.with_x(f64::INFINITY) };
        let mut sum = 0;
        for (_, MeshFace { corners: [a, b, c], .. }) in self.near(ahead) {
            if shear.intersect([&a, &b, &c]).is_some() {
                let leaves = projected_area(ray.direction, [a, b, c]).sign();
                match side([a, b, c], point) * leaves {
                    0 => return None,
                    // The ray's start is behind a face that it leaves by.
                    ahead => sum += if ahead < 0 { leaves } else { 0 },
                }
            }
        }
        Some(sum)
    }
}

#[cfg(test)]
mod tests;
