//! The transforms applied to the primitives of the world.

use crate::scene::mesh::Mesh;
use crate::scene::{Object, Scene};
use crate::world::{Placement, Primitive, World, placements};
use glam::{DMat3, DVec3};

/// The matrices that transformed the primitives to world space.
#[derive(Debug)]
pub struct ObjectSpaces<'a> {
    world: &'a World,
    /// Runs of triangles, shapes and planes: the index of the first primitive, and the matrix of the run.
    runs: [Vec<(usize, DMat3)>; 3],
}

/// The number of triangles in a box.
const BOX_TRIANGLES: usize = 12;

impl<'a> ObjectSpaces<'a> {
    /// Collects the matrices. `world` must be built from `scene` and `meshes`.
    pub fn new(scene: &Scene, meshes: &[Mesh], world: &'a World) -> Self {
        let mut spaces = Self { world, runs: Default::default() };
        let mut counts = [0; 3];
        for placement in placements(scene) {
            let Some((kind, count)) = primitives(&placement, meshes) else { continue };
            spaces.runs[kind].push((counts[kind], placement.matrix.matrix3));
            counts[kind] += count;
        }
        spaces
    }

    /// Returns the normal in the primitive's own space, with any length.
    pub fn normal(&self, primitive: u32, normal: DVec3) -> DVec3 {
        // The inverse transpose transformed it to world space.
        self.matrix(primitive).transpose() * normal
    }

    /// Returns the matrix that transformed a primitive to world space.
    pub fn matrix(&self, primitive: u32) -> DMat3 {
        let (kind, index) = match self.world.primitive(primitive) {
            Primitive::Triangle(index) => (0, index),
            Primitive::Shape(index) => (1, index),
            Primitive::Plane(index) => (2, index),
        };
        let runs = &self.runs[kind];
        let run = runs.partition_point(|&(first, _)| first <= index);
        runs.get(run.wrapping_sub(1)).map_or(DMat3::IDENTITY, |&(_, matrix)| matrix)
    }
}

/// Returns the kind and the number of an object's primitives.
fn primitives(placement: &Placement, meshes: &[Mesh]) -> Option<(usize, usize)> {
    match *placement.object {
        Object::Triangle { .. } => Some((0, 1)),
        Object::Box { .. } => Some((0, BOX_TRIANGLES)),
        Object::Grid { ref surface, .. } => Some((0, surface.triangles.len())),
        Object::Mesh { mesh, .. } => Some((0, meshes.get(mesh)?.triangles.len())),
        Object::Plane { .. } => Some((2, 1)),
        _ => placement.object.shape_box().map(|_| (1, 1)),
    }
}
