//! Builds a world from a scene: each object is transformed to world space and appended to the primitives of
//! its kind.

use super::appearance::vertex_normals;
use super::coplanar::WrittenPlanes;
use super::placement::Placement;
use super::plane::{PlacedPlane, Plane};
use super::point_error::{BoundaryWidth, PlacementError};
use super::runs::Runs;
use super::unseen::unseen;
use super::{PlaceInScene, World};
use crate::base::memory::{self, NoMemory};
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::robust;
use crate::scene::limits::{LARGEST, SMALLEST_RADIUS, are_in_range};
use crate::scene::mesh::{Corners, Mesh};
use crate::scene::{Object, Scene};
use crate::world::shape::Shape;
use crate::world::{ellipsoid::Ellipsoid, sphere::Sphere};
use glam::DVec3;
use std::mem;

/// A world under construction. Materials and errors are recorded per kind of primitive, because the ids of the
/// primitives are known only when all objects have been placed.
pub struct Builder<'a> {
    meshes: Vec<Mesh>,
    scene: &'a Scene,
    /// For each mesh, the number of objects still to be placed that use it.
    uses: Vec<usize>,
    world: World,
    /// The materials of triangles, shapes and planes, each with indices from 0.
    materials: [Runs<u32>; 3],
    /// The errors of triangles and shapes.
    errors: [Runs<PlacementError>; 2],
    planes: WrittenPlanes,
    steps: Steps<'a>,
}

impl<'a> Builder<'a> {
    /// Starts from a world without objects. `meshes` are the meshes that the scene names, in its order. Returns an
    /// error if there is too little memory for the copies of the meshes.
    pub fn new(
        world: World,
        scene: &'a Scene,
        meshes: Vec<Mesh>,
        patience: &'a dyn Patience,
    ) -> Result<Self, NoMemory> {
        let (mut uses, mut copied) = (vec![0; meshes.len()], 0);
        for object in &scene.objects {
            match object {
                Object::Mesh { mesh, .. } => {
                    uses[*mesh] += 1;
                    // A single use may take over the lists.
                    copied += if uses[*mesh] > 1 { meshes[*mesh].bytes() } else { 0 };
                }
                Object::Grid { surface, .. } => copied += surface.bytes(),
                _ => {}
            }
        }
        memory::ask(copied)?;
        let (materials, errors, planes) = Default::default();
        let steps = Steps::new(patience);
        Ok(Self { meshes, scene, uses, world, materials, errors, planes, steps })
    }

    /// Places an object. An error reports the position of the object or of the transform around it.
    pub fn place(&mut self, placement: &Placement) -> Result<(), Diagnostic> {
        self.steps.take(1)?;
        if !placement.matrix.is_finite() {
            return Err(placement.error("the transformation's numbers grow too large"));
        }
        match *placement.object {
            Object::Triangle { vertices, .. } => self.triangles(&vertices, &[[0, 1, 2]], placement),
            Object::Box { min, max, .. } => {
                let faces = BOX_FACES.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
                self.triangles(&Aabb { min, max }.corners(), faces.as_flattened(), placement)
            }
            Object::Grid { ref surface, .. } => {
                self.triangles(&surface.vertices, &surface.triangles, placement)
            }
            Object::Mesh { mesh, .. } => self.mesh(mesh, placement),
            Object::Sphere { center, radius, .. } => self.sphere(center, radius, placement),
            Object::Plane { normal, offset, .. } => self.plane((normal, offset), placement),
            Object::Group(_) | Object::Transform { .. } => Ok(()),
        }?;
        if self.ids_fit() {
            Ok(())
        } else {
            Err(placement.error("the scene has too many primitives for 32-bit ids"))
        }
    }

    /// Returns true if 32-bit indices suffice for the vertices and the primitives.
    fn ids_fit(&self) -> bool {
        let w = &self.world;
        w.vertices.len() < u32::MAX as usize && w.finite_count() + w.planes.len() < u32::MAX as usize
    }

    fn triangles(
        &mut self,
        vertices: &[DVec3],
        faces: &[[u32; 3]],
        placement: &Placement,
    ) -> Result<(), Diagnostic> {
        let world = &mut self.world;
        self.steps.take(vertices.len())?;
        let (first, count) = (world.vertices.len(), world.triangles.len());
        world.vertices.extend(vertices.iter().map(|&vertex| placement.world_point(vertex)));
        world.triangles.extend(faces.iter().map(|face| face.map(|v| v + first as u32)));
        self.finish_triangles([first, count], placement, PlacementError::new(placement, vertices))
    }

    /// Places a mesh. The last use of the first mesh takes over its lists instead of copying them.
    fn mesh(&mut self, id: usize, placement: &Placement) -> Result<(), Diagnostic> {
        let mesh = mem::take(&mut self.meshes[id]);
        self.appearance(id, &mesh, placement);
        self.uses[id] = self.uses[id].saturating_sub(1);
        let is_last = self.uses[id] == 0;
        if is_last && self.world.vertices.is_empty() {
            let error = PlacementError::new(placement, &mesh.vertices);
            (self.world.vertices, self.world.triangles) = (mesh.vertices, mesh.triangles);
            if placement.transform.is_some() {
                self.world.vertices.iter_mut().for_each(|v| *v = placement.world_point(*v));
            }
            return self.finish_triangles([0, 0], placement, error);
        }
        let result = self.triangles(&mesh.vertices, &mesh.triangles, placement);
        if !is_last {
            self.meshes[id] = mesh;
        }
        result
    }

    /// Records the normals of a mesh's vertices and the texture coordinates of its triangles, if the scene has them.
    /// The triangles are the next ones to be placed.
    fn appearance(&mut self, id: usize, mesh: &Mesh, placement: &Placement) {
        let world = &mut self.world;
        let linear = (placement.matrix.matrix3, placement.is_mirrored());
        let file = self.scene.meshes.get(id);
        let listed = file.map_or(0, |file| file.vertices).max(mesh.vertices.len());
        if let Some(normals) = vertex_normals(mesh, listed, linear, self.scene.mesh_normals) {
            let (first, all) = (world.vertices.len(), &mut world.vertex_normals);
            all.resize(first, DVec3::ZERO);
            all.extend(normals);
        }
        let named = file.map_or(&[][..], |file| file.texture_coordinates.as_slice());
        if !named.is_empty() {
            let (first, all) = (world.triangles.len(), &mut world.texture_coordinates);
            all.resize(first, None);
            // The winding of a mirrored triangle is reversed, for its texture coordinates as for its vertices.
            let is_mirrored = placement.is_mirrored();
            let wound = |[a, b, c]: Corners| if is_mirrored { [a, c, b] } else { [a, b, c] };
            all.extend(named.iter().map(|corners| corners.map(wound)));
        }
    }

    /// Completes the vertices from index `first_vertex` on and the triangles from index `first` on: records their
    /// material, corrects their winding and checks their coordinates.
    fn finish_triangles(
        &mut self,
        [first_vertex, first]: [usize; 2],
        placement: &Placement,
        error: PlacementError,
    ) -> Result<(), Diagnostic> {
        self.materials[0].push(first, placement.material);
        self.errors[0].push(first, error);
        // A mirroring matrix reverses the winding, and swapping two vertices restores it.
        if placement.is_mirrored() {
            self.world.triangles[first..].iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        let new = &self.world.vertices[first_vertex..];
        let bounds =
            if new.iter().all(|v| v.is_finite()) { Aabb::around(new.iter().copied()) } else { OVERFLOWED };
        // A mesh without triangles has an empty box with infinite corners, which is not an error.
        let is_in_range = bounds.is_empty() || (are_in_range(bounds.min) && are_in_range(bounds.max));
        self.grow(bounds, is_in_range, placement)
    }

    fn sphere(&mut self, center: DVec3, radius: f64, placement: &Placement) -> Result<(), Diagnostic> {
        placement.check_regular()?;
        let (linear, center) = (placement.matrix.matrix3, placement.world_point(center));
        match robust::similarity_scale(linear) {
            Some(scale) => {
                let radius = scale * radius;
                self.shape(Shape::Sphere(Sphere { center, radius }), [radius; 3], placement)
            }
            None => {
                let ellipsoid = Ellipsoid::new(center, linear * radius);
                let half_lengths = ellipsoid.half_lengths();
                self.shape(Shape::Ellipsoid(Box::new(ellipsoid)), half_lengths, placement)
            }
        }
    }

    /// Records a placed shape with semi-axes of these lengths.
    fn shape(&mut self, shape: Shape, [a, b, c]: [f64; 3], placement: &Placement) -> Result<(), Diagnostic> {
        let of_object = placement.object.shape_box().unwrap_or(Aabb::EMPTY);
        let index = self.world.shapes.len();
        let place = PlaceInScene {
            triangles: self.world.triangles.len() as u32,
            others: self.world.planes.len() as u32,
        };
        self.world.shape_places.push(index, place);
        self.materials[1].push(index, placement.material);
        self.errors[1].push(index, PlacementError::new(placement, &[of_object.min, of_object.max]));
        let Aabb { min, max } = shape.form().bounds();
        self.world.shapes.push(shape);
        if a.min(b).min(c) < SMALLEST_RADIUS {
            return Err(placement.error("the object has a radius below 1e-100"));
        }
        let is_in_range = are_in_range(0.5 * (min + max)) && are_in_range(DVec3::new(a, b, c));
        self.grow(placement.course_box(of_object), is_in_range, placement)
    }

    fn plane(&mut self, written: (DVec3, f64), placement: &Placement) -> Result<(), Diagnostic> {
        let world = &mut self.world;
        self.materials[2].push(world.planes.len(), placement.material);
        let place =
            PlaceInScene { triangles: world.triangles.len() as u32, others: world.shapes.len() as u32 };
        let (planes, steps) = (&mut self.planes, &mut self.steps);
        let placed = PlacedPlane::new(placement, written, place, &world.placed_planes, planes, steps)?;
        let Plane { normal, offset } = placed.plane;
        world.planes.push(placed.plane);
        world.placed_planes.push(placed);
        if !normal.is_finite() {
            return Err(placement.error("the plane has no normal"));
        }
        self.grow(Aabb::EMPTY, offset.abs() <= LARGEST, placement)
    }

    /// Extends the world's bounds by the bounds of a new object. Returns an error unless its coordinates are in range.
    fn grow(&mut self, bounds: Aabb, is_in_range: bool, placement: &Placement) -> Result<(), Diagnostic> {
        self.world.bounds = self.world.bounds.union(bounds);
        if is_in_range { Ok(()) } else { Err(placement.error("the object has coordinates beyond 1e100")) }
    }

    /// Returns the finished world, in which the primitives have their ids.
    pub fn finish(self) -> Result<World, Diagnostic> {
        let (mut world, mut steps) = (self.world, self.steps);
        self.planes.unite(&mut world.placed_planes, &mut steps)?;
        world.planes = world.placed_planes.iter().map(|placed| placed.plane).collect();
        let starts = [0, world.triangles.len(), world.finite_count()];
        for (start, runs) in starts.into_iter().zip(self.materials) {
            world.material_ids.append(start, runs);
        }
        for (start, runs) in starts.into_iter().zip(self.errors) {
            world.placement_errors.append(start, runs);
        }
        if !world.bounds.is_empty() {
            world.max_abs_coord = world.bounds.min.abs().max(world.bounds.max.abs()).max_element();
        }
        world.unseen = unseen(&world);
        world.coincidence_margin = world.find_coincidence_margin();
        world.boundary_width = BoundaryWidth::of(&world);
        world.resting_places = world.find_resting_places(&mut steps)?;
        Ok(world)
    }
}

/// The box of an object whose coordinates overflowed.
const OVERFLOWED: Aabb = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };

/// The faces of a box over [`Aabb::corners`], counter-clockwise seen from outside.
const BOX_FACES: [[u32; 4]; 6] =
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

#[cfg(test)]
mod tests;
