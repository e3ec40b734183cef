//! The primitives that the objects of a scene became.

use super::{World, placements};
use crate::scene::mesh::Mesh;
use crate::scene::{Object, ObjectId, Scene};
use glam::DAffine3;
use std::ops::Range;

/// An object with its primitives.
#[derive(Clone, Debug)]
pub struct PlacedObject {
    /// The object's index in [`Scene::objects`].
    pub id: ObjectId,
    /// The ids of its primitives in the world.
    pub primitives: Range<u32>,
    /// From object space to world space.
    pub matrix: DAffine3,
}

/// The objects of a scene, in the order of their first primitives.
#[derive(Clone, Debug)]
pub struct Objects(Vec<PlacedObject>);

impl Objects {
    /// Lists the objects of a scene, from which the world was built. Returns `None` if a mesh is not in `meshes`.
    pub fn new(scene: &Scene, meshes: &[Mesh], world: &World) -> Option<Self> {
        // The ids count triangles, shapes and planes, each in the order of the scene.
        let mut next = [0, world.triangles.len(), world.finite_count()].map(|id| id as u32);
        let mut objects = [const { vec![] }; 3];
        for placement in placements(scene) {
            let kind = match placement.object {
                Object::Group(_) | Object::Transform { .. } => continue,
                Object::Triangle { .. } | Object::Box { .. } | Object::Grid { .. } | Object::Mesh { .. } => 0,
                Object::Sphere { .. } => 1,
                Object::Plane { .. } => 2,
            };
            let primitives = next[kind]..next[kind] + placement.object.primitives(meshes)? as u32;
            next[kind] = primitives.end;
            objects[kind].push(PlacedObject { id: placement.id, primitives, matrix: placement.matrix });
        }
        Some(Self(objects.concat()))
    }

    /// Returns the object that a primitive belongs to.
    pub fn of(&self, primitive: u32) -> &PlacedObject {
        let next = self.0.partition_point(|object| object.primitives.start <= primitive);
        // An object without primitives starts where the one before it ends, and so precedes the next.
        &self.0[next.saturating_sub(1)]
    }

    /// Returns the objects.
    pub fn iter(&self) -> impl Iterator<Item = &PlacedObject> {
        self.0.iter()
    }
}
