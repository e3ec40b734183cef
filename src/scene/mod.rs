//! The scene as its author wrote it: no rendering knowledge, no I/O.
//!
//! Objects form a tree that lives in one arena (`Scene::objects`), so that a scene nested a
//! hundred thousand levels deep is built, walked and dropped without recursion.

pub mod error;
mod keyword;
pub mod lexer;
pub mod limits;
pub mod material;
pub mod mesh;
mod obj_lines;
mod parse_material;
mod parse_object;
pub mod parser;
mod plain_obj;
mod reader;
pub(crate) mod excerpt;
mod transform;

use glam::{DAffine3, DVec3};
use material::Material;

/// Linear red, green, blue; 1 is the brightest that a picture shows, larger values are legal.
pub type Color = DVec3;

/// A place in the scene text, both counted from 1; `column` counts characters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Position {
    /// The line.
    pub line: u32,
    /// The character in its line.
    pub column: u32,
}

/// Everything that a scene file says.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the scene is seen by.
    pub camera: Camera,
    /// What is seen where nothing stands, and the ambient light.
    pub background: Background,
    /// The lights, in the order of the text.
    pub lights: Vec<Light>,
    /// The materials, in the order of the text.
    pub materials: Vec<Material>,
    /// The arena. Every object stands behind those inside it, so that the root is the last.
    pub objects: Vec<Object>,
    /// The group that holds everything.
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
    /// The name as written.
    pub name: String,
    /// Where it was first named.
    pub at: Position,
}

/// What the scene is seen by. Directions need not be unit vectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Camera {
    /// `size` is the length of the longer side of the picture.
    Orthographic {
        /// The centre.
        center: DVec3,
        /// Where it looks.
        direction: DVec3,
        /// Up in the picture, but for what of it runs along the direction.
        up: DVec3,
        /// The length of the longer side of the picture.
        size: f64,
    },
    /// `angle` is the full angle over the longer side of the picture, in degrees.
    Perspective {
        /// The centre.
        center: DVec3,
        /// Where it looks.
        direction: DVec3,
        /// Up in the picture, but for what of it runs along the direction.
        up: DVec3,
        /// The full angle over the longer side of the picture, in degrees.
        angle: f64,
    },
}

/// What the `Background` block says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Background {
    /// Seen where a ray meets nothing.
    pub color: Color,
    /// Reaches every surface.
    pub ambient: Color,
}

impl Default for Background {
    /// The course's: mid grey, no ambient light.
    fn default() -> Self {
        Self { color: Color::splat(0.5), ambient: Color::ZERO }
    }
}

/// A source of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// Shines along `direction`, which need not be a unit vector.
    Directional {
        /// Where it shines.
        direction: DVec3,
        /// Its colour, the same everywhere.
        color: Color,
    },
    /// Falls off as 1 / (a0 + a1 d + a2 d^2) over the distance d.
    Point {
        /// Where it stands.
        position: DVec3,
        /// Its colour, before it falls off.
        color: Color,
        /// a0, a1 and a2.
        attenuation: [f64; 3],
    },
}

/// A node of the object tree.
#[derive(Clone, Debug, PartialEq)]
pub enum Object {
    /// Objects side by side.
    Group(Vec<ObjectId>),
    /// `matrix` maps the child's space to the parent's. It may be singular.
    Transform {
        /// From the child's space to the parent's.
        matrix: DAffine3,
        /// The object that is transformed.
        child: ObjectId,
        /// Where the text says so.
        at: Position,
    },
    /// The points at `radius` from the centre.
    Sphere {
        /// The centre.
        center: DVec3,
        /// Positive.
        radius: f64,
        /// What the surface is made of.
        material: MaterialId,
    },
    /// The points p with n.p = offset, n being `normal` scaled to unit length.
    Plane {
        /// Need not be of unit length.
        normal: DVec3,
        /// The plane's distance from the origin along its normal.
        offset: f64,
        /// What the surface is made of.
        material: MaterialId,
    },
    /// A triangle, counter-clockwise seen from outside.
    Triangle {
        /// The corners.
        vertices: [DVec3; 3],
        /// What the surface is made of.
        material: MaterialId,
    },
    /// The 2003 edition's axis-aligned box.
    Box {
        /// The corner of the least coordinates.
        min: DVec3,
        /// The corner of the greatest coordinates.
        max: DVec3,
        /// What the surface is made of.
        material: MaterialId,
    },
    /// `mesh` is an index into [`Scene::meshes`].
    Mesh {
        /// Index into [`Scene::meshes`].
        mesh: usize,
        /// What the surface is made of.
        material: MaterialId,
    },
}
