//! Reads any OBJ text with `tobj`.
//!
//! `tobj` is handed normal statements: vertices, texture coordinates and faces alone, each on one line, with indices that
//! count from 1. What it would refuse, drop or mistake in silence is read here: continued lines, comments, colours,
//! indices out of range, numbers that are not finite, and words that are no keywords.

use super::keyword::nearest;
use super::mesh::ObjFile;
use super::mesh_error::{MeshDoubt, MeshError, corner_hint, number_hint};
use super::obj_lines::{COMMON, Keyword, Statement, position, statements};
use super::plain_obj::keep_used;
use super::polygon::{OutlineFault, triangulate};
use crate::escape::quoted;
use glam::{DVec2, DVec3};
use std::fmt::Write as _;

/// Reads a mesh from a text without a byte order mark, with its texture coordinates if they matter.
/// Errors: the first error found.
pub fn read(text: &[u8], is_textured: bool) -> Result<ObjFile, MeshError> {
    let mut statements = Normal { text, is_textured, ..Normal::default() };
    statements.read()?;
    let Normal { vertices, coordinates, faces, unfit, unknown, surfaces, lines, .. } = statements;
    let options = tobj::LoadOptions::default();
    let read = tobj::load_obj_buf(&mut lines.as_bytes(), &options, |_| Err(tobj::LoadError::OpenFileFailed));
    let model = read.map(|(mut models, _)| models.pop().map(|model| model.mesh).unwrap_or_default());
    let found = model.map_err(|error| MeshError { at: None, message: error.to_string(), hint: None })?;
    let mut positions: Vec<DVec3> =
        found.positions.as_chunks().0.iter().copied().map(DVec3::from_array).collect();
    let first_unfit =
        positions.iter().filter(|vertex| !vertex.is_finite()).map(|vertex| vertex.y as usize).min();
    if let Some((offset, fault)) = first_unfit.and_then(|index| unfit.get(index)) {
        return Err(fault.at(text, *offset));
    }
    let place = |corner: usize| {
        let [u, v] = *found.texcoords.as_chunks().0.get(*found.texcoord_indices.get(corner)? as usize)?;
        (u.is_finite() && v.is_finite()).then_some(DVec2::new(u, v))
    };
    let mut file = ObjFile { vertices, ..ObjFile::default() };
    let (mut start, [mut crossing, mut empty]) = (0, [Found::default(), Found::default()]);
    let mut add = |corners: [usize; 3]| {
        // `keep_used` takes indices that count from 1.
        file.mesh.triangles.push(corners.map(|corner| found.indices[corner] + 1));
        if coordinates > 0 {
            let [a, b, c] = corners.map(place);
            file.texture_coordinates.push(a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]));
        }
    };
    for (face, offset) in faces.into_iter().enumerate() {
        let count = found.face_arities.get(face).map_or(3, |&count| count as usize);
        let corners = start..start + count;
        start += count;
        if count == 3 {
            add([corners.start, corners.start + 1, corners.start + 2]);
            continue;
        }
        let outline: Vec<DVec3> =
            found.indices[corners.clone()].iter().map(|&k| positions[k as usize]).collect();
        let polygon = triangulate(&outline);
        polygon.triangles.iter().for_each(|triangle| add(triangle.map(|corner| corners.start + corner)));
        match polygon.fault {
            Some(OutlineFault::Crosses) => crossing.add(offset, || {
                let hint = "what it covers is a guess: divide it into triangles when the mesh is exported";
                ("the outline of the polygon crosses itself".into(), Some(hint.into()))
            }),
            Some(OutlineFault::EnclosesNothing) => {
                empty.add(offset, || ("the outline of the polygon encloses nothing".into(), None));
            }
            None => {}
        }
    }
    keep_used(&mut positions, &mut file.mesh.triangles);
    file.mesh.vertices = positions;
    let statements = ["; so is another", "; so are"];
    let outlines = ["; so does that of another", "; so do those of"];
    let all = [(unknown, statements), (surfaces, statements), (crossing, outlines), (empty, outlines)];
    file.doubts.extend(all.into_iter().filter_map(|(found, others)| found.doubt(text, others)));
    file.doubts.sort_by_key(|doubt| (doubt.at.line, doubt.at.column));
    Ok(file)
}

/// What is wrong, and advice.
struct Fault(String, Option<&'static str>);

impl Fault {
    fn at(&self, text: &[u8], offset: usize) -> MeshError {
        let hint = self.1.map(str::to_owned);
        MeshError { at: Some(position(text, offset)), message: self.0.clone(), hint }
    }
}

/// Statements of one doubtful kind: the byte where the first is, its description and advice.
#[derive(Default)]
struct Found {
    first: Option<(usize, (String, Option<String>))>,
    others: usize,
}

impl Found {
    fn add(&mut self, offset: usize, describe: impl FnOnce() -> (String, Option<String>)) {
        match self.first {
            Some(_) => self.others += 1,
            None => self.first = Some((offset, describe())),
        }
    }

    fn doubt(self, text: &[u8], [one, more]: [&str; 2]) -> Option<MeshDoubt> {
        let (offset, (mut message, hint)) = self.first?;
        match self.others {
            0 => {}
            1 => message += one,
            others => message += &format!("{more} {others} more"),
        }
        Some(MeshDoubt { at: position(text, offset), message, hint })
    }
}

/// The statements of a text, as `tobj` is to read them.
#[derive(Default)]
struct Normal<'a> {
    text: &'a [u8],
    is_textured: bool,
    lines: String,
    /// The number of vertices, and of texture coordinates.
    vertices: usize,
    coordinates: usize,
    /// The largest index of a texture coordinate.
    last_coordinate: usize,
    /// Where each face stands.
    faces: Vec<usize>,
    /// Corners whose vertices come later: their indices, and where they stand.
    ahead: Vec<(i64, usize)>,
    /// What is wrong with vertices that no face may use, and where. `tobj` gets its index in this list in place of such a
    /// vertex, after an infinite number.
    unfit: Vec<(usize, Fault)>,
    has_lines: bool,
    unknown: Found,
    surfaces: Found,
}

impl<'a> Normal<'a> {
    fn read(&mut self) -> Result<(), MeshError> {
        self.lines.reserve(self.text.len());
        if self.is_textured {
            self.lines += NO_COORDINATE;
        }
        for statement in statements(self.text) {
            let Some(word) = statement.words().next() else { continue };
            let offset = self.offset(word);
            match Keyword::of(word) {
                Some(Keyword::Vertex) => self.vertex(statement)?,
                Some(Keyword::Face) => self.face(statement)?,
                Some(Keyword::Texture) if self.is_textured => self.coordinate(statement)?,
                Some(Keyword::Surface) => self.surfaces.add(offset, || {
                    let hint = "convert it to polygons when the mesh is exported";
                    ("a curved surface is left out".into(), Some(hint.into()))
                }),
                Some(Keyword::Line) => self.has_lines = true,
                Some(Keyword::Texture | Keyword::Other) => {}
                None => self.unknown.add(offset, || {
                    let hint = nearest(&shown(word), &COMMON).map(|near| format!("did you mean `{near}`?"));
                    (format!("{} is no keyword of OBJ, and its line is left out", quoted(shown(word))), hint)
                }),
            }
        }
        self.lines += &NO_COORDINATE.repeat(self.last_coordinate.saturating_sub(self.coordinates));
        if let Some(&(index, offset)) = self.ahead.iter().find(|(index, _)| *index > self.vertices as i64) {
            return self.no_such_vertex(offset, index);
        }
        if self.faces.is_empty() { Err(self.no_faces()) } else { Ok(()) }
    }

    fn offset(&self, part: &[u8]) -> usize {
        (part.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize)
    }

    /// The error of a word, or of the place behind a statement's last one.
    fn error<T>(
        &self,
        word: &[u8],
        message: impl Into<String>,
        hint: Option<&'static str>,
    ) -> Result<T, MeshError> {
        Err(Fault(message.into(), hint).at(self.text, self.offset(word)))
    }

    /// A word as text.
    fn utf8(&self, word: &'a [u8]) -> Result<&'a str, MeshError> {
        str::from_utf8(word).or_else(|error| self.error(&word[error.valid_up_to()..], "not UTF-8 text", None))
    }

    fn vertex(&mut self, statement: Statement<'a>) -> Result<(), MeshError> {
        let count = statement.words().count() - 1;
        // A colour follows the position, of which only a weight is a part.
        let wanted = if count == 4 { 4 } else { 3 };
        let (mut numbers, mut words) = ([0.0, 0.0, 0.0, 1.0], [""; 4]);
        for (place, word) in statement.words().skip(1).take(wanted).enumerate() {
            words[place] = self.utf8(word)?;
            numbers[place] = self.number(words[place], "a vertex needs three numbers")?;
        }
        let is_cut = is_cut_number(statement);
        if count < 3 && !is_cut {
            return self.error(end_of(statement), "a vertex needs three numbers", None);
        }
        if count == 5 || count > 7 {
            let surplus = statement.words().nth(if count == 5 { 5 } else { 8 }).unwrap_or_default();
            let rule = "it needs three, and may have a weight or a colour of three or four";
            return self.error(surplus, format!("a vertex has {count} numbers: {rule}"), None);
        }
        self.vertices += 1;
        let [x, y, z, weight] = numbers;
        let position = [x / weight, y / weight, z / weight];
        let not_finite = Fault("a vertex has a coordinate that is not finite".into(), None);
        let unfit = match numbers.iter().chain(&position).position(|number| !number.is_finite()) {
            _ if is_cut => Some((statement.words().last().unwrap_or_default(), not_finite)),
            Some(4..) if weight == 0.0 => {
                let message = "a vertex has the weight 0, which puts it infinitely far away";
                Some((
                    words[3].as_bytes(),
                    Fault(message.into(), Some("leave out the fourth number, or make it 1")),
                ))
            }
            Some(place) => Some((words[place % 4].as_bytes(), not_finite)),
            None => None,
        };
        _ = match (unfit, words, position) {
            (Some((word, fault)), ..) => {
                self.unfit.push((self.offset(word), fault));
                writeln!(self.lines, "v inf {} 0", self.unfit.len() - 1)
            }
            (None, [x, y, z, ""], _) => writeln!(self.lines, "v {x} {y} {z}"),
            (None, _, [x, y, z]) => writeln!(self.lines, "v {x} {y} {z}"),
        };
        Ok(())
    }

    /// A number. Those that other programs write for what is not finite are not finite.
    fn number(&self, word: &str, rule: &str) -> Result<f64, MeshError> {
        let unsigned = word.strip_prefix(['-', '+']).unwrap_or(word);
        let is_nan = || unsigned.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("nan("));
        match word.parse() {
            Ok(number) => Ok(number),
            Err(_) if is_nan() => Ok(f64::NAN),
            Err(_) => {
                let message = format!("{rule}, and {} is none", quoted(shown(word.as_bytes())));
                self.error(word.as_bytes(), message, number_hint(word))
            }
        }
    }

    fn coordinate(&mut self, statement: Statement<'a>) -> Result<(), MeshError> {
        let mut words = ["0"; 2];
        for (place, word) in statement.words().skip(1).take(2).enumerate() {
            let word = self.utf8(word)?;
            let number = self.number(word, "a texture coordinate needs numbers")?;
            words[place] = if number.is_finite() { word } else { "nan" };
        }
        self.coordinates += 1;
        _ = writeln!(self.lines, "vt {} {}", words[0], words[1]);
        Ok(())
    }

    fn face(&mut self, statement: Statement<'a>) -> Result<(), MeshError> {
        self.lines.push('f');
        let mut count = 0;
        for word in statement.words().skip(1) {
            let text = self.utf8(word)?;
            let Some((vertex, coordinate)) = corner(text) else {
                let rule = "a face needs vertex indices such as `1 2 3`";
                let message = format!("{rule}, and {} is none", quoted(shown(word)));
                return self.error(word, message, corner_hint(text));
            };
            // A negative index counts back from the face.
            let absolute = |index: i64, known: usize| {
                if index < 0 { index.saturating_add(1 + known as i64) } else { index }
            };
            let index = absolute(vertex, self.vertices);
            if !(1..=i64::from(u32::MAX)).contains(&index) {
                return self.no_such_vertex(self.offset(word), vertex);
            }
            if index > self.vertices as i64 {
                self.ahead.push((index, self.offset(word)));
            }
            _ = write!(self.lines, " {index}");
            if self.is_textured {
                let coordinate = absolute(coordinate, self.coordinates);
                // The first one of `tobj` stands for all that do not exist.
                let coordinate =
                    if (1..=self.text.len() as i64).contains(&coordinate) { coordinate } else { 0 };
                self.last_coordinate = self.last_coordinate.max(coordinate as usize);
                _ = write!(self.lines, "/{}", coordinate + 1);
            }
            count += 1;
        }
        if count < 3 {
            let hint = "a line between two vertices is written `l 1 2`";
            return self.error(end_of(statement), "a face needs at least three vertices", Some(hint));
        }
        self.lines.push('\n');
        self.faces.push(self.offset(statement.content));
        Ok(())
    }

    fn no_such_vertex<T>(&self, offset: usize, index: i64) -> Result<T, MeshError> {
        let is_vertex = |statement: &Statement| statement.words().next() == Some(b"v");
        let count = statements(self.text).filter(is_vertex).count();
        let message = format!("a face names a vertex that does not exist; the mesh has {count}");
        let hint = match index {
            0 => Some("indices start with 1"),
            ..0 => Some("a negative index counts back from the face: -1 is the vertex before it"),
            _ => None,
        };
        Err(Fault(message, hint).at(self.text, offset))
    }

    /// The error of a text without faces.
    fn no_faces(&self) -> MeshError {
        let (first, why, hint) = match (&self.surfaces.first, &self.unknown.first) {
            (Some((offset, _)), _) => (
                Some(offset),
                ", only curved surfaces, which are not read".into(),
                Some("convert them to polygons when the mesh is exported".into()),
            ),
            (_, Some((offset, _))) => {
                let word =
                    statements(&self.text[*offset..]).next().and_then(|statement| statement.words().next());
                let word = quoted(shown(word.unwrap_or_default()));
                (Some(offset), format!(", and {word} is no keyword of OBJ"), None)
            }
            _ if self.text.is_empty() => (None, ": the file is empty".into(), None),
            _ if self.has_lines => (None, ", only points, lines or curves".into(), None),
            _ => (None, String::new(), None),
        };
        let at = first.map(|&offset| position(self.text, offset));
        MeshError { at, message: format!("{NO_FACES}{why}"), hint }
    }
}

/// How the error of a text without faces begins.
pub const NO_FACES: &str = "the mesh has no faces";

/// Stands for the coordinates of corners that have none.
const NO_COORDINATE: &str = "vt nan nan\n";

/// The empty rest of a statement behind its last word.
fn end_of(statement: Statement<'_>) -> &[u8] {
    &statement.content[statement.content.trim_ascii_end().len()..]
}

/// The indices of a corner's vertex and texture coordinate, which is 0 if there is none. The corner is of the form `v`,
/// `v/vt`, `v//vn` or `v/vt/vn`, also with nothing behind a slash. An index that is too large for its type is the largest
/// or the smallest.
fn corner(word: &str) -> Option<(i64, i64)> {
    let mut parts = word.split('/');
    let vertex = index(parts.next()?)?;
    let mut other = || parts.next().filter(|part| !part.is_empty()).map_or(Some(0), index);
    let (coordinate, _) = (other()?, other()?);
    parts.next().is_none().then_some((vertex, coordinate))
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

/// A word for a message, which shows no more of it.
fn shown(word: &[u8]) -> String {
    const LONGEST: usize = 1000;
    String::from_utf8_lossy(&word[..word.len().min(LONGEST)]).into_owned()
}
