//! Flattening: converts the object tree with its transforms to lists of primitives in world space.
//!
//! Only ellipsoids that are not spheres keep a matrix. The primitives of all lists share one range of ids, in the order
//! triangles, shapes, planes.

pub mod edge_functions;
pub mod ellipsoid;
pub mod plane;
pub mod shape;
pub mod sphere;
pub mod triangle;
mod appearance;
mod builder;
mod coincidence;
mod coplanar;
mod objects;
mod placement;
mod point_error;
mod resting_lights;
mod runs;
mod surface;
#[cfg(test)]
pub(crate) mod test_worlds;
mod unseen;
pub(crate) mod triangle4;

use crate::base::memory;
use crate::base::patience::{Endless, Patience};
use crate::diagnostic::Diagnostic;
use crate::math::aabb::Aabb;
use crate::math::ray::{Hit, Ray, Visible};
use crate::math::robust;
use crate::picture::Color;
use crate::scene::limits;
use crate::scene::mesh::{Corners, Mesh};
use crate::scene::model::{Lighting, MeasureColors};
use crate::scene::texels::Texels;
use crate::scene::{Light, MaterialId, Scene, material::Material};
use builder::Builder;
use glam::DVec3;
use plane::{PlacedPlane, Plane};
use point_error::{BoundaryWidth, PlacementError};
use runs::Runs;
use shape::Shape;
use std::ops::Range;
use std::sync::Arc;

pub use objects::{Objects, PlacedObject};
pub use placement::{Placement, placements};
pub use resting_lights::RestingPlace;
pub use surface::SurfacePoint;

/// A scene in world space, ready to be traced.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// The vertices of the triangles.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The finite primitives that no ray sees, in ascending order.
    unseen: Vec<u32>,
    /// The shapes, whose ids follow those of the triangles.
    pub shapes: Vec<Shape>,
    /// The planes, which have the last ids.
    pub planes: Vec<Plane>,
    /// The placements of the planes. May be shorter than `planes`.
    placed_planes: Vec<PlacedPlane>,
    /// The places of the shapes in the scene, for runs of shapes. May be empty.
    shape_places: Runs<PlaceInScene>,
    /// The flattening errors of triangles and shapes.
    placement_errors: Runs<PlacementError>,
    boundary_width: BoundaryWidth,
    /// The part of [`World::coincidence_reach`] that does not depend on t.
    coincidence_margin: f64,
    /// The scene's materials.
    pub materials: Vec<Material>,
    /// The lights; the directions of directional ones are unit vectors.
    pub lights: Vec<Light>,
    /// The colour of a ray that hits nothing.
    pub background: Color,
    /// The ambient light, which reaches every surface.
    pub ambient: Color,
    /// The bounds of the finite primitives; empty if there are none. They are computed as in the course's program, so
    /// they are not tight around a rotated sphere.
    pub bounds: Aabb,
    /// The largest absolute coordinate of the finite primitives, which bounds the rounding errors of
    /// positions.
    pub max_abs_coord: f64,
    /// The materials of the primitives.
    material_ids: Runs<u32>,
    /// The surfaces on which each light lies.
    resting_places: Vec<Vec<RestingPlace>>,
    /// The rules by which surfaces reflect and transmit light.
    pub lighting: Lighting,
    /// The colours of depths and normals.
    pub measure_colors: MeasureColors,
    /// A vector along the normal of each vertex of a smooth mesh; zero for other vertices. May be shorter than
    /// `vertices`.
    vertex_normals: Vec<DVec3>,
    /// The texture coordinates of the triangles. May be shorter than `triangles`.
    texture_coordinates: Vec<Option<Corners>>,
    /// The pictures that the scene names.
    images: Vec<Arc<Texels>>,
    /// The cube map, which colours the rays that hit nothing.
    cube_map: Option<[Arc<Texels>; 6]>,
}

/// The place of a shape or a plane among the primitives of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PlaceInScene {
    /// The number of triangles before it.
    triangles: u32,
    /// The number of primitives of the other of these two kinds before it.
    others: u32,
}

impl PlaceInScene {
    /// The place of a primitive that no scene placed.
    const LAST: Self = Self { triangles: u32::MAX, others: 0 };
}

/// A primitive by its kind and its index in the world's list of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// Index into [`World::triangles`].
    Triangle(usize),
    /// Index into [`World::shapes`].
    Shape(usize),
    /// Index into [`World::planes`].
    Plane(usize),
}

impl World {
    /// Builds the world of a scene. `meshes` are the meshes that the scene names, in its order. Returns an error if an
    /// object cannot be placed in world space, or if there is too little memory for the copies of the meshes.
    pub fn new(scene: &Scene, meshes: &[Mesh]) -> Result<Self, Diagnostic> {
        Self::copying(scene, meshes, &Endless)
    }

    /// Builds the world of a scene as [`World::new`] does, as long as there is patience.
    pub fn copying(scene: &Scene, meshes: &[Mesh], patience: &dyn Patience) -> Result<Self, Diagnostic> {
        memory::ask(meshes.iter().map(Mesh::bytes).sum())?;
        Self::within(scene, meshes.to_vec(), patience)
    }

    /// Builds the world of a scene as [`World::copying`] does, and takes the meshes.
    pub fn within(scene: &Scene, meshes: Vec<Mesh>, patience: &dyn Patience) -> Result<Self, Diagnostic> {
        limits::check(scene)?;
        let world = Self {
            materials: scene.materials.clone(),
            lights: scene.lights.iter().map(|&l| with_unit_direction(l)).collect(),
            background: scene.background.color,
            // As in the course's program, a scene without lights is lit evenly and shows its flat colours.
            ambient: if scene.lights.is_empty() { Color::ONE } else { scene.background.ambient },
            lighting: scene.lighting,
            measure_colors: scene.measure_colors,
            images: scene.images.iter().map(|image| image.texels.clone()).collect(),
            cube_map: scene.cube_map.map(|faces| faces.map(|face| scene.images[face].texels.clone())),
            ..Self::default()
        };
        let mut builder = Builder::new(world, scene, meshes, patience)?;
        placements(scene).try_for_each(|placement| builder.place(&placement))?;
        builder.finish()
    }

    /// Returns the ids of all primitives.
    pub fn ids(&self) -> Range<u32> {
        0..(self.finite_count() + self.planes.len()) as u32
    }

    /// Returns the number of primitives with finite bounds: all except the planes.
    pub fn finite_count(&self) -> usize {
        self.triangles.len() + self.shapes.len()
    }

    /// Returns the number of finite primitives that rays may see.
    pub fn visible_count(&self) -> usize {
        self.finite_count() - self.unseen.len()
    }

    /// Returns the largest number of surface crossings on a line: one for each flat primitive, two for each round one.
    /// A loop along a ray stops after this number of steps, even if rounding errors keep it from ending.
    pub fn most_crossings(&self) -> usize {
        self.triangles.len() + 2 * self.shapes.len() + self.planes.len()
    }

    /// Returns true if a ray may see the primitive: it has an area, and no equal one comes before it.
    #[inline(always)]
    pub fn may_be_seen(&self, primitive: u32) -> bool {
        self.unseen.is_empty() || self.unseen.binary_search(&primitive).is_err()
    }

    /// Returns the primitive with this id.
    pub fn primitive(&self, id: u32) -> Primitive {
        let i = id as usize;
        if i < self.triangles.len() {
            Primitive::Triangle(i)
        } else if i < self.finite_count() {
            Primitive::Shape(i - self.triangles.len())
        } else {
            Primitive::Plane(i - self.finite_count())
        }
    }

    /// Returns the id of the first plane. Planes have the last ids.
    pub fn first_plane(&self) -> u32 {
        self.finite_count() as u32
    }

    /// Returns the tight bounds of the shapes, in the order of their ids.
    pub fn boxes(&self) -> impl Iterator<Item = Aabb> + '_ {
        self.shapes.iter().map(|shape| shape.form().bounds())
    }

    /// Returns the tight bounds of a primitive, which are empty for a plane.
    pub fn box_of(&self, id: u32) -> Aabb {
        match self.primitive(id) {
            Primitive::Triangle(i) => Aabb::around(self.corners(i)),
            Primitive::Shape(i) => self.shapes[i].form().bounds(),
            Primitive::Plane(_) => Aabb::EMPTY,
        }
    }

    /// Returns the vertices of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        // Written out, because a mapped array would be stored to memory and loaded again.
        let [a, b, c] = self.corners_in_place(triangle);
        [*a, *b, *c]
    }

    /// Returns references to the vertices of a triangle, for callers that read the coordinates in another order.
    #[inline(always)]
    pub fn corners_in_place(&self, triangle: usize) -> [&DVec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [&self.vertices[a as usize], &self.vertices[b as usize], &self.vertices[c as usize]]
    }

    /// Returns true if a ray's hit of the primitive `one` at `t` precedes its hit of `other` at `other_t`.
    ///
    /// The nearer hit precedes. At equal t, the primitive that [comes first](Self::comes_first) precedes, so that the
    /// result depends neither on the grid nor on the order of tests.
    #[inline]
    pub fn precedes(&self, (t, one): (f64, u32), (other_t, other): (f64, u32)) -> bool {
        t < other_t || (t == other_t && self.comes_first(one, other))
    }

    /// Returns true if `one` comes before `other`. Primitives are ordered by the positions of their objects in the
    /// scene, and triangles of one object by their ids.
    #[cold]
    pub fn comes_first(&self, one: u32, other: u32) -> bool {
        // The number of triangles before a primitive, and the number of shapes and planes before it. A triangle follows
        // the shapes and planes with as many triangles before them.
        let place = |id: u32| {
            let (found, index) = match self.primitive(id) {
                Primitive::Triangle(_) => return (id, u32::MAX),
                Primitive::Shape(k) => (self.shape_places.get(k as u32), k as u32),
                Primitive::Plane(k) => (self.placed_planes.get(k).map(|plane| &plane.place), k as u32),
            };
            let PlaceInScene { triangles, others } = found.copied().unwrap_or(PlaceInScene::LAST);
            (triangles, others.saturating_add(index))
        };
        (place(one), one) < (place(other), other)
    }

    /// Returns the nearest t at which a ray hits a primitive.
    #[inline(always)]
    pub fn crossing(&self, ray: &Ray, primitive: u32) -> Option<f64> {
        match self.primitive(primitive) {
            Primitive::Triangle(i) => {
                triangle::Shear::new(ray).intersect(self.corners_in_place(i)).filter(|&t| ray.covers(t))
            }
            Primitive::Shape(i) => self.shapes[i].intersect(ray),
            Primitive::Plane(i) => self.planes[i].intersect(ray),
        }
    }

    /// Returns the hit of a ray, computed from the primitive that the ray hits first. If the t of a triangle
    /// cannot be computed, the bound stands for it.
    pub fn hit(&self, ray: &Ray, Visible { primitive, t_bound }: Visible) -> Hit {
        let t = match self.primitive(primitive) {
            Primitive::Triangle(i) => triangle::Shear::new(ray).intersect(self.corners_in_place(i)),
            _ => None,
        };
        Hit { t: t.unwrap_or(t_bound), primitive }
    }

    /// Returns true if the primitive with this id is a triangle.
    #[inline(always)]
    pub fn is_triangle(&self, primitive: u32) -> bool {
        primitive < self.triangles.len() as u32
    }

    /// Returns true if the primitive with this id is a shape.
    #[inline(always)]
    pub fn is_shape(&self, primitive: u32) -> bool {
        !self.is_triangle(primitive) && primitive < self.first_plane()
    }

    #[inline(always)]
    pub(crate) fn material_of(&self, primitive: u32) -> MaterialId {
        self.material_run(primitive).1
    }

    /// Returns the run of primitives around this one that share its material, and the material.
    #[inline(always)]
    pub(crate) fn material_run(&self, primitive: u32) -> (Range<u32>, MaterialId) {
        let (run, &material) = self.material_ids.around(primitive);
        (run, material as MaterialId)
    }
}

fn with_unit_direction(light: Light) -> Light {
    match light {
        Light::Directional { direction, color } => {
            Light::Directional { direction: robust::unit(direction), color }
        }
        point => point,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_of_two_hits_precedes_and_at_the_same_t_the_lower_object() {
        let world = test_worlds::world_of(&[
            "Plane { normal 0 1 0 offset 1 }",
            "Triangle { vertex0 0 0 1 vertex1 1 0 1 vertex2 0 1 1 }",
        ]);
        // The plane comes first in the scene, and the triangle has the lower id.
        let precedes = |t: f64, one: u32, other: u32| world.precedes((t, one), (2.0, other));
        assert_eq!([1.0, 2.0, 3.0].map(|t| precedes(t, 1, 0)), [true, true, false]);
        assert_eq!([1.0, 2.0, 3.0].map(|t| precedes(t, 0, 1)), [true, false, false]);
    }
}
