//! The peers: other crates that cast rays into triangles.

use crate::contestant::{Cast, FlatRay};
use crate::mesh::corners;
use bvh::aabb::{Aabb, Bounded, IntersectsAabb};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use glam::DVec3;
use nalgebra::{Point3, Vector3};
use obvhs::BvhBuildParams;
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use parry3d::math::Vector;
use parry3d::query::RayCast;
use parry3d::shape::TriMesh;
use raytracer::scene::mesh::Mesh;
use std::cell::Cell;
use std::time::Duration;

/// `obvhs`: a compressed BVH of eight children per node.
pub struct Obvhs {
    tree: CwBvh,
    /// The triangles, in the order of the leaves.
    triangles: Vec<RtTriangle>,
}

impl Obvhs {
    pub fn new(mesh: &Mesh) -> Self {
        let vertex = |v: DVec3| v.as_vec3().into();
        let triangles: Vec<_> =
            corners(mesh).map(|[a, b, c]| Triangle { v0: vertex(a), v1: vertex(b), v2: vertex(c) }).collect();
        let tree =
            build_cwbvh_from_tris(&triangles, BvhBuildParams::medium_build(), &mut Duration::default());
        let ordered = tree.primitive_indices.iter().map(|&i| RtTriangle::from(&triangles[i as usize]));
        let triangles = ordered.collect();
        Self { tree, triangles }
    }
}

fn obvhs_ray(ray: &FlatRay) -> obvhs::ray::Ray {
    obvhs::ray::Ray::new_inf(ray.origin.into(), ray.direction.into())
}

impl Cast for Obvhs {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        let mut hit = obvhs::ray::RayHit::none();
        self.tree.ray_traverse(obvhs_ray(ray), &mut hit, |ray, i| self.triangles[i].intersect(ray));
        f64::from(hit.t)
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        !self.tree.ray_traverse_miss(obvhs_ray(ray), |ray, i| self.triangles[i].intersect(ray))
    }
}

/// `parry3d`: a binary BVH.
pub struct Parry(TriMesh);

impl Parry {
    pub fn new(mesh: &Mesh) -> Self {
        let vertices = mesh.vertices.iter().map(|v| Vector::new(v.x as f32, v.y as f32, v.z as f32));
        Self(TriMesh::new(vertices.collect(), mesh.triangles.clone()).expect("the mesh has triangles"))
    }
}

fn parry_ray(ray: &FlatRay) -> parry3d::query::Ray {
    parry3d::query::Ray::new(ray.origin.to_array().into(), ray.direction.to_array().into())
}

impl Cast for Parry {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        let t = self.0.cast_local_ray(&parry_ray(ray), f32::MAX, false);
        t.map_or(f64::INFINITY, f64::from)
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        // This is its query for the nearest hit. A traversal that stops at any hit was slower.
        self.0.intersects_local_ray(&parry_ray(ray), f32::MAX)
    }
}

/// `bvh`: a binary BVH of boxes, in which the user tests the primitives.
pub struct Boxes {
    tree: Bvh<f32, 3>,
    leaves: Vec<Leaf>,
}

/// A triangle in a leaf.
struct Leaf {
    corner: Vector3<f32>,
    edges: [Vector3<f32>; 2],
    node: usize,
}

/// A ray that ends at its nearest hit, so that no box behind it is entered.
struct Ending {
    ray: bvh::ray::Ray<f32, 3>,
    end: Cell<f32>,
}

impl Boxes {
    pub fn new(mesh: &Mesh) -> Self {
        let vertex = |v: DVec3| Vector3::new(v.x as f32, v.y as f32, v.z as f32);
        let leaf = |[a, b, c]: [_; 3]| Leaf {
            corner: vertex(a),
            edges: [vertex(b) - vertex(a), vertex(c) - vertex(a)],
            node: 0,
        };
        let mut leaves: Vec<_> = corners(mesh).map(leaf).collect();
        Self { tree: Bvh::build(&mut leaves), leaves }
    }
}

impl Bounded<f32, 3> for Leaf {
    fn aabb(&self) -> Aabb<f32, 3> {
        let corners = [self.corner, self.corner + self.edges[0], self.corner + self.edges[1]];
        corners.iter().fold(Aabb::empty(), |all, &corner| all.grow(&Point3::from(corner)))
    }
}

impl BHShape<f32, 3> for Leaf {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }

    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl Leaf {
    /// The test of Moeller and Trumbore for both sides. The crate's own test hits front faces only.
    #[inline(always)]
    fn intersect(&self, ray: &bvh::ray::Ray<f32, 3>) -> f32 {
        let across = ray.direction.cross(&self.edges[1]);
        let inverse = 1.0 / self.edges[0].dot(&across);
        let from_corner = ray.origin.coords - self.corner;
        let u = from_corner.dot(&across) * inverse;
        let along = from_corner.cross(&self.edges[0]);
        let v = ray.direction.dot(&along) * inverse;
        let t = self.edges[1].dot(&along) * inverse;
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 { t } else { f32::INFINITY }
    }
}

impl IntersectsAabb<f32, 3> for Ending {
    #[inline(always)]
    fn intersects_aabb(&self, aabb: &Aabb<f32, 3>) -> bool {
        self.ray.intersection_slice_for_aabb(aabb).is_some_and(|(entry, _)| entry <= self.end.get())
    }
}

/// The fields are set directly, because the crate's constructor would normalise the direction.
#[inline(always)]
fn boxes_ray(ray: &FlatRay) -> bvh::ray::Ray<f32, 3> {
    let direction = Vector3::from(ray.direction.to_array());
    let inv_direction = direction.map(|x| 1.0 / x);
    bvh::ray::Ray { origin: Point3::from(ray.origin.to_array()), direction, inv_direction }
}

impl Cast for Boxes {
    #[inline(always)]
    fn closest(&self, ray: &FlatRay) -> f64 {
        let ending = Ending { ray: boxes_ray(ray), end: Cell::new(f32::INFINITY) };
        // This is faster than the crate's iterators in order of distance.
        for leaf in self.tree.traverse_iterator(&ending, &self.leaves) {
            ending.end.set(ending.end.get().min(leaf.intersect(&ending.ray)));
        }
        f64::from(ending.end.get())
    }

    #[inline(always)]
    fn any(&self, ray: &FlatRay) -> bool {
        let ray = boxes_ray(ray);
        self.tree.traverse_iterator(&ray, &self.leaves).any(|leaf| leaf.intersect(&ray) < f32::INFINITY)
    }
}
