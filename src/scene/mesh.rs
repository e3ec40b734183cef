//! Triangle meshes from Wavefront OBJ text.
//!
//! The text is parsed by `tobj`, after a filter that passes only vertex positions and faces. So the mesh is a
//! single list of vertices and triangles (`tobj` starts a new list at every object, group and material), no
//! material file is opened, and errors in what is not used here are ignored: normals, texture coordinates,
//! colours, and comments in any encoding. Files of positions and triangles only take a faster path, in
//! `plain_obj`.

pub use super::mesh_error::MeshError;
use super::obj_lines::{RelevantLines, is_newline, keyword, with_continued_lines, without_comment, words};
use super::plain_obj;
use crate::memory::{self, NoMemory, make_room};
use glam::DVec3;
use std::cell::Cell;

/// A triangle mesh, with its triangles in the order of the file's faces.
///
/// Vertices that no face uses are left out. Every coordinate is finite and every index is in range.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The positions of the vertices.
    pub vertices: Vec<DVec3>,
    /// The indices of each triangle's vertices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A copy.
    pub fn copied(&self) -> Result<Self, NoMemory> {
        Ok(Self { vertices: memory::copied(&self.vertices)?, triangles: memory::copied(&self.triangles)? })
    }
}

/// Reads a mesh from the bytes of an OBJ file.
///
/// Polygons become fans of triangles around their first vertex. Points, lines, curves and everything else
/// except positions and faces are ignored. A backslash at the end of a line continues it on the next one.
/// Errors: the first error found.
pub fn parse_obj(bytes: &[u8]) -> Result<Mesh, MeshError> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if let Some((vertices, triangles)) = plain_obj::parse(text)? {
        return Ok(Mesh { vertices, triangles });
    }
    match with_continued_lines(text)? {
        Some(text) => parse_obj_fully(&text),
        None => parse_obj_fully(text),
    }
}

/// As [`parse_obj`], but without the faster path for plain files.
pub(super) fn parse_obj_fully(text: &[u8]) -> Result<Mesh, MeshError> {
    let mesh = read_positions_and_faces(text)?;
    if mesh.triangles.is_empty() {
        return Err(MeshError::NoFaces);
    }
    if mesh.vertices.iter().all(|vertex| vertex.is_finite()) {
        return Ok(mesh);
    }
    Err(MeshError::NotFinite { line: line_where(text, is_vertex_beyond_numbers) })
}

fn read_positions_and_faces(text: &[u8]) -> Result<Mesh, MeshError> {
    let options = tobj::LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..Default::default()
    };
    memory::ask(bytes_to_parse(text))?;
    let line = Cell::new(0);
    let mut relevant = RelevantLines::new(text, &line);
    // The filter removes the references to material libraries, so this loader is never called.
    let read = tobj::load_obj_buf(&mut relevant, &options, |_| Err(tobj::LoadError::OpenFileFailed));
    if let Some(line) = relevant.few_corners {
        return Err(MeshError::FewCorners { line });
    }
    let (models, _) = read.map_err(|error| explain(error, text, line.get()))?;
    Ok(joined(&models)?)
}

/// An upper bound on the memory that the OBJ parser takes without asking, in bytes.
fn bytes_to_parse(text: &[u8]) -> u64 {
    /// A face with room for four corners, each of a position, a texture coordinate and a normal.
    const FACE: usize = 112;
    const CORNER: usize = 24;
    /// An entry of the map from the file's vertices to the mesh's, of which an eighth stays empty.
    const MAP_ENTRY: usize = 17;
    let (mut vertices, mut faces, mut corners, mut long) = (0, 0, 0, 0);
    for line in text.split(is_newline) {
        match keyword(line) {
            b"v" => vertices += 1,
            b"f" => {
                let count = words(line).skip(1).count();
                (faces, corners) = (faces + 1, corners + count);
                // More corners than four are in a list of their own.
                long += if count > 4 { grown(count, CORNER) } else { 0 };
            }
            _ => {}
        }
    }
    let positions = 2 * grown(3 * vertices, size_of::<f64>()) + grown(vertices + vertices / 7, MAP_ENTRY);
    let indices = grown(3 * corners, size_of::<u32>()) + grown(faces, size_of::<u32>());
    (positions + grown(faces, FACE) + long + indices) as u64
}

/// The bytes that a list of this number of elements takes at most while it grows: the old list stays until its
/// elements are in one of twice the length.
fn grown(count: usize, size: usize) -> usize {
    count.next_power_of_two() / 2 * 3 * size
}

/// The models joined into one mesh. There is only one model, since the filter removes the lines that would
/// start another, but this function does not rely on it.
fn joined(models: &[tobj::Model]) -> Result<Mesh, NoMemory> {
    let mut mesh = Mesh::default();
    for model in models {
        let first = mesh.vertices.len() as u32;
        let (vertices, _) = model.mesh.positions.as_chunks();
        make_room(&mut mesh.vertices, vertices.len())?;
        mesh.vertices.extend(vertices.iter().map(|&vertex| DVec3::from_array(vertex)));
        let (triangles, _) = model.mesh.indices.as_chunks();
        make_room(&mut mesh.triangles, triangles.len())?;
        mesh.triangles
            .extend(triangles.iter().map(|corners: &[u32; 3]| corners.map(|corner| first + corner)));
    }
    Ok(mesh)
}

/// Converts an error of the OBJ parser, which stopped after `line`.
fn explain(error: tobj::LoadError, text: &[u8], line: usize) -> MeshError {
    use tobj::LoadError as E;
    match error {
        E::PositionParseError | E::ScalingByZeroError | E::ColorParseError => MeshError::BadVertex { line },
        E::FaceParseError => MeshError::BadFace { line },
        E::InvalidPolygon => MeshError::FewCorners { line },
        E::ReadError => MeshError::NotText { line },
        // The parser finds this error only at the end of the file, so the line has to be searched for.
        E::FaceVertexOutOfBounds => no_such_vertex(text),
        other => MeshError::Other { line, message: other.to_string() },
    }
}

fn no_such_vertex(text: &[u8]) -> MeshError {
    let vertices = text.split(is_newline).filter(|line| keyword(line) == b"v").count();
    let mut so_far = 0;
    let line = line_where(text, |line| {
        so_far += usize::from(keyword(line) == b"v");
        keyword(line) == b"f" && words(line).skip(1).any(|corner| !is_vertex(corner, so_far, vertices))
    });
    MeshError::NoSuchVertex { line, vertices }
}

/// Whether a face's `corner` names one of the `all` vertices, of which `so_far` precede the face.
pub(super) fn is_vertex(corner: &[u8], so_far: usize, all: usize) -> bool {
    let index = corner.split(|&byte| byte == b'/').next().unwrap_or_default();
    match str::from_utf8(index).ok().and_then(|index| index.parse::<i64>().ok()) {
        Some(index) if index < 0 => index.unsigned_abs() <= so_far as u64,
        Some(index) => index > 0 && index as u64 <= all as u64,
        None => false,
    }
}

/// Whether a line is a vertex with a number that is not finite, before or after the division by its weight.
fn is_vertex_beyond_numbers(line: &[u8]) -> bool {
    let numbers: Vec<f64> =
        words(line).skip(1).map_while(|word| str::from_utf8(word).ok()?.parse().ok()).collect();
    let weight = if numbers.len() == 4 { numbers[3] } else { 1.0 };
    keyword(line) == b"v" && numbers.iter().take(3).any(|number| !(number / weight).is_finite())
}

/// The number of the first line for which `is_wanted` holds, or else of the last line.
fn line_where(text: &[u8], is_wanted: impl FnMut(&[u8]) -> bool) -> usize {
    let lines = text.split(is_newline);
    lines.clone().map(without_comment).position(is_wanted).map_or(lines.count(), |index| index + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Mesh {
        parse_obj(text.as_bytes()).unwrap()
    }

    fn refuse(text: &str) -> MeshError {
        parse_obj(text.as_bytes()).unwrap_err()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn triangles_keep_the_order_of_the_file() {
        let mesh = read(&format!("{SQUARE}f 3 4 1\nf 1 2 3\n"));
        let corners = mesh.triangles.iter().map(|corners| corners.map(|i| mesh.vertices[i as usize]));
        let [a, b, c, d] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        assert!(corners.eq([[c, d, a], [a, b, c]]));
        assert_eq!(mesh.vertices.len(), 4);
    }

    #[test]
    fn coordinates_are_read_in_full() {
        let mesh = read("v 0.1 1e300 -5e-324\nv 1 2 3\nv 4 5 6\nf 1 2 3");
        assert_eq!(mesh.vertices[0], DVec3::new(0.1, 1e300, -5e-324));
    }

    #[test]
    fn polygons_become_fans() {
        let mesh = read(&format!("{SQUARE}v 0 2 0\nf 1 2 3 4\nf 1 2 3 4 5\n"));
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    }

    #[test]
    fn faces_may_name_more_than_positions() {
        let plain = read(&format!("{SQUARE}f 1 2 3"));
        for face in
            ["1/1 2/2 3/3", "1//9 2//9 3//9", "1/7/7 2/8/8 3/9/9", "1/-99999999/6148914691236517206 2 3"]
        {
            let text = format!("vn 0 0 1\nvt 0 0\n{SQUARE}f {face}");
            assert_eq!(read(&text), plain, "{face}");
        }
    }

    #[test]
    fn negative_indices_count_backwards_from_the_face() {
        let mesh = read(&format!("{SQUARE}f -4 -3 -2\nv 9 9 9\nf -1 -2 -3"));
        assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 2]]);
        assert_eq!(mesh.vertices[3], DVec3::splat(9.0));
    }

    #[test]
    fn groups_and_materials_share_their_vertices() {
        let text = format!(
            "mtllib no/such.mtl\n{SQUARE}o one\ng\nusemtl\nf 1 2 3\no two\nusemtl red\ns off\nf 1 3 4\n"
        );
        let mesh = read(&text);
        assert_eq!((mesh.vertices.len(), mesh.triangles), (4, vec![[0, 1, 2], [0, 2, 3]]));
    }

    #[test]
    fn what_is_not_a_surface_is_ignored() {
        let mesh = read(&format!("{SQUARE}p 1\nl 1 2\nl 1 2 3\nf 1 2 3\ncurv 0 1 1 2 3\nl x\nvn nan\n"));
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }

    #[test]
    fn comments_colours_weights_and_byte_order_marks() {
        let bytes =
            b"\xef\xbb\xbfv 0 0 0 # \xe9\r\n# \xff\r\n v 2 0 0 2\r\nv\t0 1 0 .1 .2 .3\r\nf 1 2 3 # f 9\r\n";
        let mesh = parse_obj(bytes).unwrap();
        assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    }

    #[test]
    fn meshes_without_faces() {
        for text in ["", "\n", "# nothing", SQUARE, "binary \0 rubbish"] {
            assert_eq!(refuse(text), MeshError::NoFaces);
        }
    }

    #[test]
    fn errors_name_the_malformed_line() {
        for (vertex, error) in [
            ("v 1 2", MeshError::BadVertex { line: 5 }),
            ("v 1 2 x", MeshError::BadVertex { line: 5 }),
            ("v 1 2 3 0", MeshError::BadVertex { line: 5 }),
            ("v 1 2 3 4 5", MeshError::BadVertex { line: 5 }),
            ("f 1 2 x", MeshError::BadFace { line: 5 }),
            ("f 1 2 3.5", MeshError::BadFace { line: 5 }),
            ("f 1 2 99999999999999999999", MeshError::BadFace { line: 5 }),
            ("f", MeshError::FewCorners { line: 5 }),
            ("f 1 2", MeshError::FewCorners { line: 5 }),
            ("f 1 2 0", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f 1 2 5", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f 1 2 -5", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f 1 2 9223372036854775807", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f 1 2 -9223372036854775808", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f / / /", MeshError::NoSuchVertex { line: 5, vertices: 4 }),
            ("f 1 2 1/2/3/4", MeshError::BadFace { line: 5 }),
        ] {
            assert_eq!(refuse(&format!("{SQUARE}{vertex}\n\nf 1 2 3\n")), error, "{vertex}");
        }
    }

    #[test]
    fn coordinates_must_be_finite() {
        for vertex in ["nan 0 0", "0 inf 0", "0 0 -1e999", "1e300 0 0 1e-300"] {
            let text = format!("{SQUARE}v {vertex}\nf 1 2 5\n");
            assert_eq!(refuse(&text), MeshError::NotFinite { line: 5 }, "{vertex}");
        }
    }

    #[test]
    fn lines_that_matter_must_be_text() {
        assert_eq!(parse_obj(b"v 0 0 0\nv 0 \xff 0\n"), Err(MeshError::NotText { line: 2 }));
    }

    #[test]
    fn no_truncation_panics() {
        let text = format!("{SQUARE}vt 0 0\nvn 0 0 1\nf 1/1/1 2//1 -2\nf 1 2 3 4\nv 1 1 1 1 1 1\n");
        for end in 0..text.len() {
            let _ = parse_obj(&text.as_bytes()[..end]);
        }
    }

    #[test]
    fn the_error_names_the_first_face_with_a_missing_vertex() {
        for (corner, line) in [("6", 7), ("0", 7), ("-6", 7), ("-5", 9), ("5", 9), ("1", 9)] {
            let text = format!("{SQUARE}v 0 2 0\nf 1/1 -5 5//1\nf 2 3 {corner}\n#\nf 1 2 7\nf 1 2 8\n");
            assert_eq!(refuse(&text), MeshError::NoSuchVertex { line, vertices: 5 }, "{corner}");
        }
        // A negative index counts from its face, however many vertices follow.
        let text = format!("{SQUARE}f -1 -2 -4\nf -1 -2 -5\nv 0 2 0\n");
        assert_eq!(refuse(&text), MeshError::NoSuchVertex { line: 6, vertices: 5 });
    }
}
