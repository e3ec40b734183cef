//! Reads any OBJ text: its vertices and faces. Everything else is left out.

use super::keyword::nearest;
use super::mesh::Mesh;
use super::mesh_error::{DoubtKind, Instead, MeshDoubt, MeshError, MeshFault};
use super::obj_lines::{COMMON, Keyword, Statement, position, statements};
use super::plain_obj::keep_used;
use super::polygon::triangulate;
use glam::DVec3;

/// Reads a mesh from a text without a byte order mark, and what is doubtful in it, in the order of the text.
/// Errors: the first error found.
pub fn read(text: &[u8]) -> Result<(Mesh, Vec<MeshDoubt>), MeshError> {
    let mut reader = Reader { text, ..Reader::default() };
    reader.read().map_err(|Stop(offset, fault)| MeshError { at: Some(position(text, offset)), fault })?;
    if reader.faces.is_empty() {
        return Err(reader.no_faces());
    }
    let mesh = reader.mesh();
    let found = [reader.unknown, reader.surfaces, reader.crossings];
    let mut doubts: Vec<MeshDoubt> = found.into_iter().filter_map(|found| found.doubt(text)).collect();
    doubts.sort_by_key(|doubt| (doubt.at.line, doubt.at.column));
    Ok((mesh, doubts))
}

/// Why a text is read no further: a fault, and the byte where it is.
struct Stop(usize, MeshFault);

/// Statements of one doubtful kind.
#[derive(Default)]
struct Found {
    /// The kind, and the byte where the first is.
    first: Option<(usize, DoubtKind)>,
    count: usize,
}

impl Found {
    fn add(&mut self, offset: usize, kind: impl FnOnce() -> DoubtKind) {
        self.count += 1;
        if self.first.is_none() {
            self.first = Some((offset, kind()));
        }
    }

    fn doubt(self, text: &[u8]) -> Option<MeshDoubt> {
        let (offset, kind) = self.first?;
        Some(MeshDoubt { at: position(text, offset), kind, others: self.count - 1 })
    }
}

/// A face: where its statement starts, and the end of its corners in the list of all.
struct Face {
    offset: usize,
    end: usize,
}

#[derive(Default)]
struct Reader<'a> {
    text: &'a [u8],
    vertices: Vec<DVec3>,
    /// Vertices that no face may use: their number, and what is wrong where.
    unfit: Vec<(usize, usize, MeshFault)>,
    /// The corners of all faces, which count vertices from 1.
    corners: Vec<u32>,
    faces: Vec<Face>,
    has_lines: bool,
    unknown: Found,
    surfaces: Found,
    crossings: Found,
}

impl<'a> Reader<'a> {
    fn offset(&self, part: &[u8]) -> usize {
        offset(self.text, part)
    }

    /// A fault at a word.
    fn fault<T>(&self, word: &[u8], fault: MeshFault) -> Result<T, Stop> {
        Err(Stop(self.offset(word), fault))
    }

    /// A fault behind the last word of a statement.
    fn fault_at_end<T>(&self, statement: Statement, fault: MeshFault) -> Result<T, Stop> {
        let content = statement.content;
        Err(Stop(self.offset(content) + content.trim_ascii_end().len(), fault))
    }

    fn read(&mut self) -> Result<(), Stop> {
        for statement in statements(self.text) {
            let Some(word) = statement.words().next() else { continue };
            match Keyword::of(word) {
                Some(Keyword::Vertex) => self.vertex(statement)?,
                Some(Keyword::Face) => self.face(statement)?,
                Some(Keyword::Surface) => self.surfaces.add(offset(self.text, word), || DoubtKind::Surface),
                Some(Keyword::Line) => self.has_lines = true,
                Some(Keyword::Other) => {}
                None => self.unknown.add(offset(self.text, word), || unknown(word)),
            }
        }
        let is_missing = |&corner: &u32| corner as usize > self.vertices.len();
        if let Some(place) = self.corners.iter().position(is_missing) {
            return self.missing(place);
        }
        self.refuse_unfit()
    }

    fn vertex(&mut self, statement: Statement<'a>) -> Result<(), Stop> {
        let count = statement.words().count() - 1;
        // A colour follows the position, of which only a weight is a part.
        let wanted = if count == 4 { 4 } else { 3 };
        let (mut numbers, mut known) = ([0.0, 0.0, 0.0, 1.0], 0);
        let mut not_finite = None;
        for word in statement.words().skip(1).take(wanted) {
            numbers[known] = self.number(word)?;
            if !numbers[known].is_finite() && not_finite.is_none() {
                not_finite = Some(word);
            }
            known += 1;
        }
        if is_cut_number(statement) {
            not_finite = statement.words().last();
        } else if known < 3 {
            return self.fault_at_end(statement, MeshFault::BadVertex { word: None });
        }
        if count == 5 || count > 7 {
            let surplus = statement.words().nth(if count == 5 { 5 } else { 8 }).unwrap_or_default();
            return self.fault(surplus, MeshFault::SurplusNumbers { count });
        }
        let [x, y, z, weight] = numbers;
        let position = DVec3::new(x, y, z) / weight;
        let last = |place| statement.words().nth(place).unwrap_or_default();
        let unfit = match not_finite {
            Some(word) => Some((word, MeshFault::NotFinite)),
            None if weight == 0.0 => Some((last(4), MeshFault::ZeroWeight)),
            None if !position.is_finite() => {
                let beyond = position.to_array().iter().position(|x| !x.is_finite()).unwrap_or(0);
                Some((last(1 + beyond), MeshFault::NotFinite))
            }
            None => None,
        };
        if let Some((word, fault)) = unfit {
            let offset = self.offset(word);
            self.unfit.push((self.vertices.len(), offset, fault));
        }
        self.vertices.push(position);
        Ok(())
    }

    /// A number. Those that other programs write for what is not finite are not finite.
    fn number(&self, word: &[u8]) -> Result<f64, Stop> {
        let Ok(text) = str::from_utf8(word) else { return self.not_text(word) };
        if let Ok(number) = text.parse() {
            return Ok(number);
        }
        let lower = text.to_ascii_lowercase();
        if ["nan(", "-nan(", "+nan("].iter().any(|start| lower.starts_with(start)) {
            return Ok(f64::NAN);
        }
        self.fault(word, MeshFault::BadVertex { word: Some(shown(word)) })
    }

    fn not_text<T>(&self, word: &[u8]) -> Result<T, Stop> {
        let good = str::from_utf8(word).map_or_else(|error| error.valid_up_to(), str::len);
        self.fault(&word[good..], MeshFault::NotText)
    }

    fn face(&mut self, statement: Statement<'a>) -> Result<(), Stop> {
        let first = self.corners.len();
        for word in statement.words().skip(1) {
            let Ok(text) = str::from_utf8(word) else { return self.not_text(word) };
            let Some(index) = corner(text) else {
                return self.fault(word, MeshFault::BadFace { word: shown(word) });
            };
            // A negative index counts back from the face.
            let number = if index < 0 { index.saturating_add(1 + self.vertices.len() as i64) } else { index };
            match u32::try_from(number) {
                Ok(number @ 1..) => self.corners.push(number),
                _ => return self.no_such_vertex(word, index),
            }
        }
        if self.corners.len() < first + 3 {
            return self.fault_at_end(statement, MeshFault::FewCorners);
        }
        let offset = self.offset(statement.content);
        self.faces.push(Face { offset, end: self.corners.len() });
        Ok(())
    }

    fn no_such_vertex<T>(&self, word: &[u8], index: i64) -> Result<T, Stop> {
        let is_vertex = |statement: &Statement| statement.words().next() == Some(b"v");
        let vertices = statements(self.text).filter(is_vertex).count();
        self.fault(word, MeshFault::NoSuchVertex { index, vertices })
    }

    /// The fault that there is no vertex for the corner at this place of the list of all.
    fn missing(&self, place: usize) -> Result<(), Stop> {
        let face = self.faces.partition_point(|face| face.end <= place);
        let first = face.checked_sub(1).map_or(0, |before| self.faces[before].end);
        let statement = self.faces.get(face).and_then(|face| statements(&self.text[face.offset..]).next());
        let word = statement.and_then(|statement| statement.words().nth(1 + place - first));
        self.no_such_vertex(word.unwrap_or_default(), i64::from(self.corners[place]))
    }

    /// The fault of the first unfit vertex that a face uses.
    fn refuse_unfit(&mut self) -> Result<(), Stop> {
        if self.unfit.is_empty() {
            return Ok(());
        }
        let mut is_used = vec![false; self.vertices.len()];
        self.corners.iter().for_each(|&corner| is_used[corner as usize - 1] = true);
        let unfit = std::mem::take(&mut self.unfit);
        match unfit.into_iter().find(|&(vertex, ..)| is_used[vertex]) {
            Some((_, offset, fault)) => Err(Stop(offset, fault)),
            None => Ok(()),
        }
    }

    /// The error of a text without faces.
    fn no_faces(self) -> MeshError {
        let (first, instead) = match (self.unknown.first, self.surfaces.first) {
            (_, Some((offset, _))) => (Some(offset), Instead::Surfaces),
            (Some((offset, DoubtKind::UnknownWord { word, .. })), _) => (Some(offset), Instead::Word(word)),
            _ if self.text.is_empty() => (None, Instead::Nothing),
            _ if self.has_lines => (None, Instead::Lines),
            _ => (None, Instead::NoArea),
        };
        MeshError { at: first.map(|offset| position(self.text, offset)), fault: MeshFault::NoFaces(instead) }
    }

    /// The triangles of all faces, in their order.
    fn mesh(&mut self) -> Mesh {
        let mut triangles: Vec<[u32; 3]> = Vec::with_capacity(self.corners.len() - 2 * self.faces.len());
        let (mut start, mut polygon) = (0, vec![]);
        for face in &self.faces {
            let corners = &self.corners[start..face.end];
            start = face.end;
            if let &[a, b, c] = corners {
                triangles.push([a, b, c]);
                continue;
            }
            polygon.clear();
            polygon.extend(corners.iter().map(|&corner| self.vertices[corner as usize - 1]));
            let found = triangulate(&polygon);
            if found.fault.is_some() {
                self.crossings.add(face.offset, || DoubtKind::Crossing);
            }
            triangles
                .extend(found.triangles.into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
        }
        let mut vertices = std::mem::take(&mut self.vertices);
        keep_used(&mut vertices, &mut triangles);
        Mesh { vertices, triangles }
    }
}

/// The byte of a text where a slice of it starts.
fn offset(text: &[u8], part: &[u8]) -> usize {
    (part.as_ptr() as usize).saturating_sub(text.as_ptr() as usize)
}

/// The vertex index of a corner of the form `v`, `v/vt`, `v//vn` or `v/vt/vn`, also with nothing behind a slash. One
/// that is too large for its type is the largest or the smallest.
fn corner(word: &str) -> Option<i64> {
    let mut parts = word.split('/');
    let vertex = index(parts.next()?)?;
    let others_are_indices = parts.clone().all(|part| part.is_empty() || index(part).is_some());
    (others_are_indices && parts.count() <= 2).then_some(vertex)
}

fn index(word: &str) -> Option<i64> {
    let digits = word.strip_prefix(['-', '+']).unwrap_or(word);
    let is_index = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    let largest = if word.starts_with('-') { i64::MIN } else { i64::MAX };
    is_index.then(|| word.parse().unwrap_or(largest))
}

/// Whether a vertex ends in a number such as `1.#IND` or `-1.#QNAN`, which older programs for Windows write for what is
/// not finite, and which its comment seems to cut.
fn is_cut_number(statement: Statement) -> bool {
    const ENDINGS: [&[u8]; 4] = [b"#IND", b"#INF", b"#QNAN", b"#SNAN"];
    statement.content.ends_with(b"1.") && ENDINGS.iter().any(|ending| statement.comment.starts_with(ending))
}

/// The doubt about a word that is no keyword.
fn unknown(word: &[u8]) -> DoubtKind {
    let word = shown(word);
    let near = nearest(&word, &COMMON);
    DoubtKind::UnknownWord { word, near }
}

/// A word for a message, which shows no more of it.
fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 1000;
    String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).into_owned()
}
