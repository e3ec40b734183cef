//! Reads triangle meshes from Wavefront OBJ text.
//!
//! Files with only positions and triangles take a faster path in `plain`. Of all others, `statements` makes plain
//! statements, `tobj` reads these, and `polygon` cuts faces into triangles.

mod plain;
mod statements;
#[cfg(test)]
mod tests;
mod words;

use super::foreign_format::foreign;
use super::mesh::{Mesh, NamedFile, ObjFile};
use super::polygon::{OutlineFault, triangulate};
use crate::base::patience::{Endless, Patience, Steps};
use crate::base::shortcut::Shortcut;
use crate::diagnostic::Diagnostic;
use glam::{DVec2, DVec3};
use plain::keep_used;
pub use plain::memory_for;
use statements::{MeshWarning, Statements};
use std::borrow::Cow;
use std::io::{self, BufReader, Read};
use tobj::{LoadError, LoadOptions, load_obj_buf};
pub use words::LIBRARY;
use words::{each_once, files_in};

/// Reads a mesh from the bytes of an OBJ file, with its texture coordinates if `is_textured`.
///
/// Polygons become triangles. Points, lines, curves, normals and materials are ignored. Fails with one error, or when the
/// patience is over.
pub fn read_obj(bytes: &[u8], is_textured: bool, patience: &dyn Patience) -> Result<ObjFile, Diagnostic> {
    let text = trimmed(bytes);
    if Shortcut::PlainMeshes.is_taken()
        && let Some((mesh, vertices)) = plain::parse(text, patience)
    {
        return Ok(ObjFile { mesh, vertices, ..ObjFile::default() });
    }
    patience.check()?;
    if let Some(error) = foreign(bytes) {
        return Err(error);
    }
    read_any(text, is_textured, patience)
}

/// Reads a mesh without texture coordinates.
pub fn parse_obj(bytes: &[u8]) -> Result<Mesh, Diagnostic> {
    read_obj(bytes, false, &Endless).map(|file| file.mesh)
}

/// Returns the files that a mesh or a material library names.
pub fn named_files(kind: &str, bytes: &[u8]) -> Vec<NamedFile> {
    files_in(kind, trimmed(bytes))
}

/// Returns the text of a mesh file. Positions of errors refer to it.
pub fn text(bytes: &[u8]) -> Cow<'_, str> {
    String::from_utf8_lossy(trimmed(bytes))
}

/// Removes a byte order mark, and the zero bytes and end-of-file characters that some systems append.
fn trimmed(bytes: &[u8]) -> &[u8] {
    const END_OF_FILE: u8 = 0x1a;
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let end = text.iter().rposition(|&byte| byte != 0 && byte != END_OF_FILE);
    &text[..end.map_or(0, |last| last + 1)]
}

/// Reads a mesh from any text without a byte order mark, with texture coordinates if `is_textured`.
pub(super) fn read_any(
    text: &[u8],
    is_textured: bool,
    patience: &dyn Patience,
) -> Result<ObjFile, Diagnostic> {
    let mut statements = Statements::read(text, is_textured, patience)?;
    let mut lines = BufReader::new(PatientReader { rest: &statements.lines, patience });
    let read = load_obj_buf(&mut lines, &LoadOptions::default(), |_| Err(LoadError::OpenFileFailed));
    patience.check()?;
    let (models, _) = read?;
    let found = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
    let mut vertices: Vec<DVec3> =
        found.positions.as_chunks().0.iter().copied().map(DVec3::from_array).collect();
    let triangles = triangles(&mut statements, &found.indices, &vertices, patience)?;
    // `keep_used` expects indices that count from 1.
    let mut faces: Vec<[u32; 3]> =
        triangles.iter().map(|corners| corners.map(|corner| found.indices[corner] + 1)).collect();
    keep_used(&mut vertices, &mut faces);
    let coordinate = |corner: usize| {
        // `tobj` also has a coordinate for a corner that names none.
        statements.corners[corner].coordinate?;
        let index = found.texcoord_indices[corner] as usize;
        Some(DVec2::from_array(found.texcoords.as_chunks().0[index]))
    };
    let of_triangle = |&[a, b, c]: &[usize; 3]| Some([coordinate(a)?, coordinate(b)?, coordinate(c)?]);
    let has_coordinates = is_textured && statements.coordinates.total > 0;
    let texture_coordinates =
        if has_coordinates { triangles.iter().map(of_triangle).collect() } else { vec![] };
    Ok(ObjFile {
        mesh: Mesh { vertices, triangles: faces },
        vertices: statements.vertices.total as usize,
        texture_coordinates,
        warnings: statements.described_warnings(),
        files: each_once(statements.files),
    })
}

/// Hands out a text until the patience is over.
struct PatientReader<'a> {
    rest: &'a [u8],
    patience: &'a dyn Patience,
}

impl Read for PatientReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.patience.check().map_err(io::Error::other)?;
        self.rest.read(buffer)
    }
}

/// Returns the triangles of all faces as places in the list of corners. `indices` are the corners' vertices.
fn triangles(
    statements: &mut Statements<'_>,
    indices: &[u32],
    vertices: &[DVec3],
    patience: &dyn Patience,
) -> Result<Vec<[usize; 3]>, Diagnostic> {
    /// The steps of work that a corner of a polygon counts for.
    const STEPS_PER_CORNER: usize = 64;
    let (mut steps, mut triangles, mut start) = (Steps::new(patience), vec![], 0);
    for (keyword, count) in std::mem::take(&mut statements.faces) {
        let first = start;
        start += count;
        steps.take(if count > 4 { STEPS_PER_CORNER * count } else { 1 })?;
        if count == 3 {
            triangles.push([first, first + 1, first + 2]);
            continue;
        }
        let outline: Vec<DVec3> =
            indices[first..start].iter().map(|&index| vertices[index as usize]).collect();
        let polygon = triangulate(&outline);
        triangles.extend(polygon.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
        match polygon.fault {
            Some(OutlineFault::Crosses) => statements.warn(MeshWarning::CrossingOutline, keyword),
            Some(OutlineFault::EnclosesNothing) => statements.warn(MeshWarning::EmptyOutline, keyword),
            None => {}
        }
    }
    Ok(triangles)
}
