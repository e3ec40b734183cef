//! Triangle meshes.

use crate::diagnostic::Diagnostic;
use glam::{DVec2, DVec3};

/// A triangle mesh, with its triangles in the order of the file's faces.
///
/// Contains no unused vertices. Every coordinate is finite and every index is in range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    pub vertices: Vec<DVec3>,
    /// The indices of each triangle's vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns the size of the lists in bytes.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.vertices.as_slice()) + size_of_val(self.triangles.as_slice())) as u64
    }
}

/// The kind of a file, as in "texture", and its name as it is written in a scene or a mesh.
pub type NamedFile = (&'static str, String);

/// The texture coordinates at a triangle's corners, to the right and up.
pub type Corners = [DVec2; 3];

/// The contents of an OBJ file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ObjFile {
    pub mesh: Mesh,
    /// The number of `v` lines, including vertices that no face uses.
    pub vertices: usize,
    /// The texture coordinates of each triangle, if requested; `None` for a triangle without them. The list is empty if
    /// the file has none.
    pub texture_coordinates: Vec<Option<Corners>>,
    /// The files that it names, none of which is read.
    pub files: Vec<NamedFile>,
    /// Warnings about the file in its order, one of each kind.
    pub warnings: Vec<Diagnostic>,
}
