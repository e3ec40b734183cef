//! The scene as its author wrote it: no rendering knowledge, no I/O.
//!
//! Objects form a tree that lives in one arena (`Scene::objects`), so that a scene nested a
//! hundred thousand levels deep is built, walked and dropped without recursion.

pub mod error;
mod keyword;
pub mod lexer;
pub mod material;
pub mod mesh;
mod obj_lines;
mod parse_material;
mod parse_object;
pub mod parser;
mod plain_obj;
mod reader;
pub(crate) mod snippet;
mod transform;

use glam::{DAffine3, DVec3};
use material::Material;

/// Linear red, green, blue; 1 is the brightest that a picture shows, larger values are legal.
pub type Color = DVec3;

/// A place in the scene text, both counted from 1; `column` counts characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Position {
    pub line: u32,
    pub column: u32,
}

/// Everything that a scene file says.
#[derive(Clone, Debug)]
pub struct Scene {
    pub camera: Camera,
    pub background: Background,
    pub lights: Vec<Light>,
    pub materials: Vec<Material>,
    /// The arena. Every object stands behind those inside it, so that the root is the last.
    pub objects: Vec<Object>,
    pub root: ObjectId,
    /// The mesh files named by the scene, each once. [`Object::Mesh`] points here.
    pub meshes: Vec<MeshFile>,
}

/// Index into [`Scene::objects`].
pub type ObjectId = usize;
/// Index into [`Scene::materials`].
pub type MaterialId = usize;

/// A mesh file as named by the scene, and where it was first named.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshFile {
    pub name: String,
    pub at: Position,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// `size` is the length of the longer side of the picture.
    Orthographic { center: DVec3, direction: DVec3, up: DVec3, size: f64 },
    /// `angle` is the full angle over the longer side of the picture, in degrees.
    Perspective { center: DVec3, direction: DVec3, up: DVec3, angle: f64 },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    pub color: Color,
    pub ambient: Color,
}

impl Default for Background {
    /// The course's: mid grey, no ambient light.
    fn default() -> Self {
        Self { color: Color::splat(0.5), ambient: Color::ZERO }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines along `direction`, which need not be a unit vector.
    Directional { direction: DVec3, color: Color },
    /// Falls off as 1 / (a0 + a1 d + a2 d^2) over the distance d.
    Point { position: DVec3, color: Color, attenuation: [f64; 3] },
}

/// A node of the object tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    Group(Vec<ObjectId>),
    /// `matrix` maps the child's space to the parent's. It may be singular.
    Transform {
        matrix: DAffine3,
        child: ObjectId,
        at: Position,
    },
    Sphere {
        center: DVec3,
        radius: f64,
        material: MaterialId,
    },
    /// The points p with n.p = offset, n being `normal` scaled to unit length.
    Plane {
        normal: DVec3,
        offset: f64,
        material: MaterialId,
    },
    Triangle {
        vertices: [DVec3; 3],
        material: MaterialId,
    },
    /// The 2003 edition's axis-aligned box.
    Box {
        min: DVec3,
        max: DVec3,
        material: MaterialId,
    },
    /// `mesh` is an index into [`Scene::meshes`].
    Mesh {
        mesh: usize,
        material: MaterialId,
    },
}
