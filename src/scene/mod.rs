//! The scene as its author wrote it, read from text. This module knows nothing of rendering, and only
//! [`load`] opens files.
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
mod object;
pub mod model;
mod obj_lines;
mod obj_reader;
mod parse_material;
mod parse_objects;
mod parse_view;
pub mod parser;
mod plain_obj;
mod polygon;
mod reader;
pub mod texels;
mod transform;

pub use crate::diagnostic::Position;
use crate::picture::Color;
use glam::DVec3;
use material::Material;
use mesh::Corners;
use model::Model;
pub use object::Object;
use std::sync::Arc;
use texels::{CubeFaces, ImageFile};
pub(crate) use transform::is_transformation;

/// A scene, with everything that its file contains.
#[derive(Clone, Debug)]
pub struct Scene {
    pub camera: Camera,
    pub background: Background,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    /// The position of each material's keyword in the text. A scene that a program makes may leave it empty.
    pub material_positions: Vec<Position>,
    /// The arena of the object tree. Every object comes after its children, so the root is the last.
    pub objects: Vec<Object>,
    /// The position of each object's keyword in the text. A scene that a program makes may leave it empty.
    pub positions: Vec<Position>,
    /// The group that contains all objects.
    pub root: ObjectId,
    /// The mesh files that the scene names, each once. [`Object::Mesh`] has an index into this list.
    pub meshes: Vec<MeshFile>,
    /// The pictures that the scene names, each once.
    pub images: Vec<ImageFile>,
    /// What rays see that hit nothing, by indices into [`Scene::images`], if that is more than a colour.
    pub cube_map: Option<CubeFaces>,
    pub model: Model,
}

/// Index into [`Scene::objects`].
pub type ObjectId = usize;
/// Index into [`Scene::materials`].
pub type MaterialId = usize;

/// A mesh file that the scene names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// The name as written.
    pub name: String,
    /// The position where the scene first names it.
    pub at: Position,
    /// The number of vertices that it lists, with those that no face uses, once it has been read.
    pub vertices: usize,
    /// The texture coordinates of its triangles, once it has been read, if the scene has pictures. It may be shorter than
    /// the mesh.
    pub texture_coordinates: Arc<Vec<Option<Corners>>>,
}

/// A camera. Its directions need not be unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// A camera whose rays are parallel.
    Orthographic {
        center: DVec3,
        direction: DVec3,
        /// The vector whose part perpendicular to the direction points up in the picture.
        up: DVec3,
        /// The length of the longer side of the picture.
        size: f64,
    },
    /// A camera whose rays start in one point.
    Perspective {
        center: DVec3,
        direction: DVec3,
        /// The vector whose part perpendicular to the direction points up in the picture.
        up: DVec3,
        /// The full viewing angle over the longer side of the picture, in degrees.
        angle: f64,
    },
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
    /// Parallel light without attenuation.
    Directional {
        /// The direction in which the light travels, which need not be a unit vector.
        direction: DVec3,
        /// The colour, which is the same everywhere.
        color: Color,
    },
    /// Light from a point, attenuated by the factor 1 / (a0 + a1 d + a2 d^2) at the distance d.
    Point {
        position: DVec3,
        /// The colour before attenuation.
        color: Color,
        /// The coefficients a0, a1 and a2.
        attenuation: [f64; 3],
    },
}
