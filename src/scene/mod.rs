//! The scene as its author wrote it, read from text. This module does not depend on rendering. Only [`load`] opens
//! files.
//!
//! Objects form a tree that is stored in one arena (`Scene::objects`), so that a scene nested a hundred
//! thousand levels deep is built, traversed and dropped without recursion.

pub mod edition;
mod filled_cells;
pub(crate) mod foreign_format;
pub mod lexer;
pub mod limits;
pub mod load;
pub mod material;
pub mod mesh;
pub mod model;
pub mod obj;
mod parse_material;
mod parse_objects;
mod parse_view;
pub mod parser;
mod polygon;
mod reader;
pub mod texels;
pub(crate) mod transform;

pub use crate::diagnostic::Position;
use crate::math::aabb::Aabb;
use crate::math::rounded::RoundedAffine;
use crate::picture::Color;
use glam::DVec3;
use material::Material;
pub use material::MaterialId;
use mesh::{Corners, Mesh};
use model::{Lighting, MeasureColors, MeshNormals, Screen, Shows};
use serde::Serialize;
use std::sync::Arc;
use texels::{CubeFaces, ImageFile};
use transform::Factor;

/// A scene: the contents of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub camera: Camera,
    pub background: Background,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    /// The arena of the object tree. Every object comes after its children, so the root is the last.
    pub objects: Vec<Object>,
    pub root: ObjectId,
    /// The mesh files that the scene names, without duplicates.
    pub meshes: Vec<MeshFile>,
    /// The pictures that the scene names, without duplicates.
    pub images: Vec<ImageFile>,
    /// The faces of the cube map for rays that hit nothing, as indices into [`Scene::images`]. `None` for a plain
    /// colour.
    pub cube_map: Option<CubeFaces>,
    pub screen: Screen,
    pub lighting: Lighting,
    pub mesh_normals: MeshNormals,
    pub measure_colors: MeasureColors,
    pub shows: Shows,
    pub positions: Positions,
}

/// The positions of keywords in a scene's text. A scene built by a program may leave them empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Positions {
    pub camera: Position,
    pub lights: Vec<Position>,
    pub materials: Vec<Position>,
    pub objects: Vec<Position>,
}

impl Positions {
    /// Returns the position of a light, by its index.
    pub fn light(&self, index: usize) -> Position {
        self.lights.get(index).copied().unwrap_or_default()
    }

    pub fn material(&self, id: MaterialId) -> Position {
        self.materials.get(id).copied().unwrap_or_default()
    }

    pub fn object(&self, id: ObjectId) -> Position {
        self.objects.get(id).copied().unwrap_or_default()
    }
}

pub type ObjectId = usize;

/// A node of the object tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    Group(Vec<ObjectId>),
    /// Maps `child` to the parent's space by `matrix`, the product of `factors`, which may be singular. `at` is the
    /// position of `Transform` in the text.
    Transform {
        matrix: RoundedAffine,
        factors: Box<[Factor]>,
        child: ObjectId,
        at: Position,
    },
    Sphere {
        center: DVec3,
        radius: f64,
        material: MaterialId,
    },
    /// The points p with n.p = `offset`, where n is `normal` scaled to unit length.
    Plane {
        normal: DVec3,
        offset: f64,
        material: MaterialId,
    },
    /// A triangle. Its vertices are counter-clockwise seen from outside.
    Triangle {
        vertices: [DVec3; 3],
        material: MaterialId,
    },
    /// The axis-aligned box of the 2003 edition.
    Box {
        min: DVec3,
        max: DVec3,
        material: MaterialId,
    },
    /// The 2003 edition's cells filled by a sphere, stored as the faces between filled and empty cells.
    Grid {
        surface: Arc<Mesh>,
        material: MaterialId,
    },
    /// A triangle mesh from the file with the index `mesh` in [`Scene::meshes`].
    Mesh {
        mesh: usize,
        material: MaterialId,
    },
}

impl Object {
    /// Returns the keyword that begins the object in the text.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Group(_) => "Group",
            Self::Transform { .. } => "Transform",
            Self::Sphere { .. } => "Sphere",
            Self::Plane { .. } => "Plane",
            Self::Triangle { .. } => "Triangle",
            Self::Box { .. } => "Box",
            Self::Grid { .. } => "Grid",
            Self::Mesh { .. } => "TriangleMesh",
        }
    }

    /// Returns the number of primitives that the object has in world space. `None` if its mesh is not in `meshes`.
    pub fn primitives(&self, meshes: &[Mesh]) -> Option<usize> {
        match self {
            Self::Group(_) | Self::Transform { .. } => Some(0),
            Self::Sphere { .. } | Self::Plane { .. } | Self::Triangle { .. } => Some(1),
            Self::Box { .. } => Some(12),
            Self::Grid { surface, .. } => Some(surface.triangles.len()),
            Self::Mesh { mesh, .. } => meshes.get(*mesh).map(|mesh| mesh.triangles.len()),
        }
    }

    /// Returns the surface's material if the object is a primitive.
    pub fn material(&self) -> Option<MaterialId> {
        match *self {
            Self::Group(_) | Self::Transform { .. } => None,
            Self::Sphere { material, .. }
            | Self::Plane { material, .. }
            | Self::Triangle { material, .. }
            | Self::Box { material, .. }
            | Self::Grid { material, .. }
            | Self::Mesh { material, .. } => Some(material),
        }
    }

    /// Returns the shape's bounding box before any transform. The course's program bounds a transformed shape by the
    /// box of the transformed corners.
    pub fn shape_box(&self) -> Option<Aabb> {
        match *self {
            Self::Sphere { center, radius, .. } => Some(Aabb { min: center - radius, max: center + radius }),
            _ => None,
        }
    }
}

/// A mesh file that the scene names, with the data known after reading it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    pub name: String,
    /// The position of its first mention in the scene.
    pub at: Position,
    /// The number of vertices in the file, including those that no face uses.
    pub vertices: usize,
    /// The texture coordinates of the triangles, if the scene has pictures. May be shorter than the list of triangles.
    pub texture_coordinates: Arc<Vec<Option<Corners>>>,
}

/// A camera. Its directions need not be unit vectors. The component of `up` perpendicular to `direction` points up in
/// the picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Camera {
    /// A camera with parallel rays. `center` is in the middle of the picture. `size` is the length of its longer side.
    Orthographic { center: DVec3, direction: DVec3, up: DVec3, size: f64 },
    /// A camera with rays from `center`. `angle` is the full viewing angle over the longer side, in degrees.
    Perspective { center: DVec3, direction: DVec3, up: DVec3, angle: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// The colour of rays that hit nothing.
    pub color: Color,
    /// The ambient light, which arrives at every surface.
    pub ambient: Color,
}

impl Default for Background {
    /// The course's default: mid grey and no ambient light.
    fn default() -> Self {
        Self { color: Color::splat(0.5), ambient: Color::ZERO }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Parallel light without attenuation. It travels along `direction`, which need not be a unit vector.
    Directional { direction: DVec3, color: Color },
    /// Light from a point, attenuated by the factor 1 / (a0 + a1 d + a2 d^2) at the distance d.
    Point { position: DVec3, color: Color, attenuation: [f64; 3] },
}
