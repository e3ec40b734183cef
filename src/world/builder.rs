//! Placing the objects of a scene in a world.

use super::{Placement, World, course_sphere_box};
use crate::math::aabb::Aabb;
use crate::math::robust;
use crate::primitive::{ellipsoid::Ellipsoid, plane::Plane, sphere::Sphere};
use crate::scene::error::{Problem, SceneError};
use crate::scene::limits::{LARGEST, SMALLEST_RADIUS, are_in_range};
use crate::scene::mesh::Mesh;
use crate::scene::{MaterialId, MeshFile, Object, Scene};
use glam::DVec3;
use std::borrow::Cow;
use std::mem;

/// A world in the making: materials per list until the numbers are known.
pub struct Builder<'a> {
    meshes: Vec<Cow<'a, Mesh>>,
    files: &'a [MeshFile],
    /// How many objects are still to be placed that name each mesh.
    uses: Vec<usize>,
    world: World,
    /// Runs as in `material_runs`, but each list counted from 0: triangles, spheres, ellipsoids, planes.
    materials: [Vec<(u32, u32)>; 4],
}

impl<'a> Builder<'a> {
    /// Of a world without objects. `meshes` are those that the scene names, in its order.
    pub fn new(world: World, scene: &'a Scene, meshes: Vec<Cow<'a, Mesh>>) -> Self {
        let mut uses = vec![0; meshes.len()];
        for object in &scene.objects {
            if let Object::Mesh { mesh, .. } = object {
                uses[*mesh] += 1;
            }
        }
        Self { meshes, files: &scene.meshes, uses, world, materials: Default::default() }
    }

    pub fn place(&mut self, placement: &Placement) -> Result<(), SceneError> {
        if !placement.matrix.is_finite() {
            return Err(placement.error(Problem::TransformOverflow));
        }
        let map = |p: DVec3| placement.place(p);
        match *placement.object {
            Object::Triangle { vertices, material } => {
                self.triangles(vertices.map(map), &[[0, 1, 2]], placement, material)
            }
            Object::Box { min, max, material } => {
                let corners = Aabb { min, max }.corners().map(map);
                self.triangles(corners, &BOX_FACES, placement, material)
            }
            Object::Mesh { mesh, material } => {
                self.mesh(mesh, placement, material).map_err(|error| self.at_mesh(error, mesh, placement))
            }
            Object::Sphere { center, radius, material } => self.sphere(center, radius, placement, material),
            Object::Plane { normal, offset, material } => self.plane(normal, offset, placement, material),
            Object::Group(_) | Object::Transform { .. } => Ok(()),
        }?;
        if self.fits() { Ok(()) } else { Err(placement.error(Problem::TooManyPrimitives)) }
    }

    /// An error of a mesh that no transform stands around, at the place where the scene names it.
    fn at_mesh(&self, error: SceneError, mesh: usize, placement: &Placement) -> SceneError {
        let file = self.files.get(mesh).filter(|_| placement.transform.is_none());
        file.map_or(error.clone(), |file| SceneError { at: file.at, ..error })
    }

    fn fits(&self) -> bool {
        let w = &self.world;
        w.vertices.len() < u32::MAX as usize && w.finite_count() + w.planes.len() < u32::MAX as usize
    }

    fn triangles(
        &mut self,
        vertices: impl IntoIterator<Item = DVec3>,
        faces: &[[u32; 3]],
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let world = &mut self.world;
        let (first, count) = (world.vertices.len(), world.triangles.len());
        world.vertices.extend(vertices);
        world.triangles.extend(faces.iter().map(|face| face.map(|v| v + first as u32)));
        self.note_triangles(first, count, placement, material)
    }

    fn mesh(&mut self, id: usize, placement: &Placement, material: MaterialId) -> Result<(), SceneError> {
        let map = |p: DVec3| placement.place(p);
        let mesh = mem::take(&mut self.meshes[id]);
        self.uses[id] = self.uses[id].saturating_sub(1);
        let is_last = self.uses[id] == 0;
        match mesh {
            Cow::Owned(mesh) if is_last && self.world.vertices.is_empty() => {
                (self.world.vertices, self.world.triangles) = (mesh.vertices, mesh.triangles);
                if placement.transform.is_some() {
                    self.world.vertices.iter_mut().for_each(|v| *v = map(*v));
                }
                self.note_triangles(0, 0, placement, material)
            }
            mesh => {
                let vertices = mesh.vertices.iter().map(|&v| map(v));
                let result = self.triangles(vertices, &mesh.triangles, placement, material);
                if !is_last {
                    self.meshes[id] = mesh;
                }
                result
            }
        }
    }

    /// Does what is left to do for the world's triangles from `first` and vertices from `first_vertex` on.
    fn note_triangles(
        &mut self,
        first_vertex: usize,
        first: usize,
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        note_run(&mut self.materials[0], first, material);
        // A mirroring matrix turns the winding; two swapped vertices turn it back.
        if robust::is_mirroring(placement.matrix.matrix3) {
            self.world.triangles[first..].iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let new = &self.world.vertices[first_vertex..];
        let bounds =
            if new.iter().all(|v| v.is_finite()) { Aabb::around(new.iter().copied()) } else { BROKEN };
        // An empty group of triangles has an empty, infinite box, which is no fault.
        let is_near = bounds.is_empty() || (are_in_range(bounds.min) && are_in_range(bounds.max));
        self.grow(bounds, is_near, placement)
    }

    fn sphere(
        &mut self,
        center: DVec3,
        radius: f64,
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let matrix = placement.matrix;
        let linear = matrix.matrix3;
        let (middle, max_abs_coord) = (placement.place(center), linear * radius);
        if robust::is_singular(linear) {
            return Err(placement.error(Problem::SingularTransform));
        }
        let half_lengths = if let Some(scale) = robust::similarity_scale(linear) {
            note_run(&mut self.materials[1], self.world.spheres.len(), material);
            self.world.spheres.push(Sphere { center: middle, radius: scale * radius });
            [scale * radius; 3]
        } else {
            note_run(&mut self.materials[2], self.world.ellipsoids.len(), material);
            let ellipsoid = Ellipsoid::new(middle, max_abs_coord);
            self.world.ellipsoids.push(ellipsoid);
            ellipsoid.half_lengths()
        };
        if half_lengths.iter().any(|&length| length < SMALLEST_RADIUS) {
            return Err(placement.error(Problem::RadiusTooSmall));
        }
        let is_near = are_in_range(middle) && are_in_range(half_lengths.into());
        self.grow(course_sphere_box(center, radius, placement), is_near, placement)
    }

    fn plane(
        &mut self,
        normal: DVec3,
        offset: f64,
        placement: &Placement,
        material: MaterialId,
    ) -> Result<(), SceneError> {
        let normal = robust::unit(normal);
        note_run(&mut self.materials[3], self.world.planes.len(), material);
        let plane = match placement.transform {
            None => Plane { normal, offset },
            Some(_) => transformed_plane(normal, offset, placement)?,
        };
        self.world.planes.push(plane);
        if !plane.normal.is_finite() {
            return Err(placement.error(Problem::NoNormal));
        }
        let is_near = plane.offset.abs() <= LARGEST;
        if is_near { Ok(()) } else { Err(placement.error(Problem::CoordinatesTooLarge)) }
    }

    /// Takes the box of a new object, which is refused unless its coordinates are in range.
    fn grow(&mut self, bounds: Aabb, is_near: bool, placement: &Placement) -> Result<(), SceneError> {
        self.world.bounds = self.world.bounds.union(bounds);
        if is_near { Ok(()) } else { Err(placement.error(Problem::CoordinatesTooLarge)) }
    }

    pub fn finish(self) -> Result<World, SceneError> {
        let mut world = self.world;
        let counts = [world.triangles.len(), world.spheres.len(), world.ellipsoids.len(), world.planes.len()];
        let mut start = 0;
        for (runs, count) in self.materials.into_iter().zip(counts) {
            world.material_runs.extend(runs.into_iter().map(|(first, material)| (first + start, material)));
            start += count as u32;
        }
        if !world.bounds.is_empty() {
            world.max_abs_coord = world.bounds.min.abs().max(world.bounds.max.abs()).max_element();
        }
        Ok(world)
    }
}

/// A plane under the transforms around it.
fn transformed_plane(normal: DVec3, offset: f64, placement: &Placement) -> Result<Plane, SceneError> {
    let linear = placement.matrix.matrix3;
    if robust::is_singular(linear) {
        return Err(placement.error(Problem::SingularTransform));
    }
    let there = robust::unit(robust::transformed_normal(linear, normal));
    Ok(Plane { normal: there, offset: there.dot(placement.place(offset * normal)) })
}

/// The box of something whose coordinates overflowed.
const BROKEN: Aabb = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

/// The faces of a box over [`Aabb::corners`], counter-clockwise seen from outside.
const BOX_FACES: [[u32; 3]; 12] = [
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
];

fn note_run(runs: &mut Vec<(u32, u32)>, first: usize, material: MaterialId) {
    if runs.last().is_none_or(|&(_, last)| last as MaterialId != material) {
        runs.push((first as u32, material as u32));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parser::parse;

    #[test]
    fn a_mesh_taken_over_is_the_mesh_copied() {
        let mesh = Mesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let mirrored = "Transform { Scale { -1 2 3 } TriangleMesh { obj_file a.obj } }";
        let sphere = "Sphere { center 0 0 0 radius 1 }";
        let triangle = "Triangle { vertex0 0 0 0 vertex1 1 0 0 vertex2 0 1 0 }";
        for objects in [
            [mirrored, sphere],
            [sphere, mirrored],
            [triangle, mirrored],
            [mirrored, triangle],
            [mirrored, mirrored],
            ["TriangleMesh { obj_file b.obj }", mirrored],
        ] {
            let text = format!(
                "OrthographicCamera {{ center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }}
                 Group {{ numObjects 2 Material {{ }} {} {} }}",
                objects[0], objects[1]
            );
            let scene = parse(&text).unwrap();
            let meshes = vec![mesh.clone(); scene.meshes.len()];
            let copied = World::new(&scene, &meshes).unwrap();
            let taken = World::of_meshes(&scene, meshes).unwrap();
            assert_eq!((taken.vertices, taken.triangles), (copied.vertices, copied.triangles), "{objects:?}");
            assert_eq!(taken.bounds, copied.bounds);
        }
    }
}
