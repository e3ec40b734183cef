//! Reads any OBJ text with `tobj`.
//!
//! `tobj` gets normalised statements: only vertices, texture coordinates and faces, one per line, with indices that
//! count from 1. This module handles the input that `tobj` would reject, drop or misread silently: continued lines,
//! comments, colours, indices out of range, numbers that are not finite, and unknown keywords.

use super::foreign_format::foreign_without_faces;
use super::lexer::nearest;
use super::mesh::ObjFile;
use super::obj_lines::{COMMON, is_keyword, next_statement, position};
use super::plain_obj::{digits, keep_used};
use super::polygon::{MOST_CORNERS, OutlineFault, triangulate};
use crate::base::escape::quoted;
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::{Diagnostic, Severity};
use glam::{DVec2, DVec3};
use std::io::{self, BufRead, Read, Write as _};
use tobj::{LoadError, LoadOptions, load_obj_buf};

/// Reads a mesh from a text without a byte order mark, with texture coordinates if `is_textured`. Fails with the first
/// error found.
pub fn read(text: &[u8], is_textured: bool, patience: &dyn Patience) -> Result<ObjFile, Diagnostic> {
    let read_with = |totals| read_normal(Normal { text, is_textured, totals, ..Normal::new(patience) });
    // `tobj` checks numbers and indices but does not report where an error is. A second reading finds the position.
    read_with(None).or_else(|_| {
        patience.check()?;
        let (mut rest, mut words, mut totals) = (text, vec![], [0; 2]);
        while next_statement(&mut rest, &mut words) {
            totals[0] += i64::from(words[0] == b"v");
            totals[1] += i64::from(words[0] == b"vt");
        }
        read_with(Some(totals))
    })
}

fn read_normal(mut normal: Normal<'_>) -> Result<ObjFile, Diagnostic> {
    normal.read()?;
    let text = normal.text;
    let mut lines = PatientReader { rest: &normal.lines, patience: normal.patience };
    let read = load_obj_buf(&mut lines, &LoadOptions::default(), |_| Err(LoadError::OpenFileFailed));
    let (models, _) = read?;
    let found = models.into_iter().next().map(|model| model.mesh).unwrap_or_default();
    let mut positions: Vec<DVec3> =
        found.positions.as_chunks().0.iter().copied().map(DVec3::from_array).collect();
    let unfit = positions.iter().filter(|vertex| !vertex.is_finite()).map(DVec3::to_array);
    if let Some([_, offset, is_weightless]) = unfit.min_by(|a, b| a[1].total_cmp(&b[1])) {
        let (message, hint) = match is_weightless {
            1.0 => ("a vertex has the weight 0: it is at infinity", Some("leave it out, or make it 1")),
            _ => ("a vertex has a coordinate that is not finite", None),
        };
        // On the first reading this is not an offset.
        return Err(fault(text, &text[(offset as usize).min(text.len())..], message, hint));
    }
    let (mut triangles, mut start) = (vec![], 0);
    let [mut crossing, mut empty] = [Doubt::default(), Doubt::default()];
    for (statement, count) in normal.faces {
        normal.steps.take(if count > 4 { STEPS_PER_CORNER * count } else { 1 })?;
        let first = start;
        start += count;
        if count == 3 {
            triangles.push([first, first + 1, first + 2]);
            continue;
        }
        let outline: Vec<_> = found.indices[first..start].iter().map(|&k| positions[k as usize]).collect();
        let polygon = triangulate(&outline);
        triangles.extend(polygon.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
        match polygon.fault {
            Some(OutlineFault::Crosses) => crossing.add(|| {
                let hint = "its triangles are a guess: export the mesh as triangles";
                fault(text, statement, "the outline of the polygon crosses itself", Some(hint))
            }),
            Some(OutlineFault::EnclosesNothing) => {
                empty.add(|| fault(text, statement, "the outline of the polygon encloses nothing", None));
            }
            None => {}
        }
    }
    let mut file = ObjFile { vertices: normal.known[0] as usize, ..ObjFile::default() };
    // `keep_used` expects indices that count from 1.
    file.mesh.triangles = triangles.iter().map(|corners| corners.map(|k| found.indices[k] + 1)).collect();
    keep_used(&mut positions, &mut file.mesh.triangles);
    file.mesh.vertices = positions;
    if normal.known[1] > 0 {
        let place = |corner: usize| {
            let place = found.texcoords.as_chunks().0[found.texcoord_indices[corner] as usize];
            Some(DVec2::from_array(place)).filter(|place| normal.is_placed[corner] && place.is_finite())
        };
        let places = triangles.iter().map(|&[a, b, c]| Some([place(a)?, place(b)?, place(c)?]));
        file.texture_coordinates = places.collect();
    }
    let doubts = [normal.unknown, normal.surfaces, crossing, empty];
    file.doubts = doubts.into_iter().filter_map(Doubt::told).collect();
    file.doubts.sort_by_key(|doubt| doubt.position().map(|at| (at.line, at.column)));
    Ok(file)
}

/// The first doubtful statement of a kind, and the number of others.
#[derive(Default)]
struct Doubt(Option<Diagnostic>, usize);

impl Doubt {
    fn add(&mut self, describe: impl FnOnce() -> Diagnostic) {
        self.1 += usize::from(self.0.is_some());
        self.0.get_or_insert_with(describe);
    }

    fn told(self) -> Option<Diagnostic> {
        let first = self.0?;
        let others = if self.1 > 0 { format!(" (and {} more)", self.1) } else { String::new() };
        Some(Diagnostic { severity: Severity::Warning, message: first.message + &others, ..first })
    }
}

/// The steps of work that a corner of a polygon counts for.
const STEPS_PER_CORNER: usize = 64;

/// Hands out a text until the patience is over.
struct PatientReader<'a> {
    rest: &'a [u8],
    patience: &'a dyn Patience,
}

impl Read for PatientReader<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.rest.read(buffer)
    }
}

impl BufRead for PatientReader<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        const PART: usize = 1 << 16;
        self.patience.check().map_err(io::Error::other)?;
        Ok(&self.rest[..self.rest.len().min(PART)])
    }

    fn consume(&mut self, count: usize) {
        self.rest = &self.rest[count..];
    }
}

/// The statements of a text, normalised for `tobj`.
struct Normal<'a> {
    text: &'a [u8],
    is_textured: bool,
    /// The total numbers of vertices and texture coordinates. Present only on the second reading, which checks
    /// everything.
    totals: Option<[i64; 2]>,
    /// The numbers read so far. Texture coordinates are counted only if `is_textured`.
    known: [i64; 2],
    lines: Vec<u8>,
    /// The statement of each face, and the number of its corners.
    faces: Vec<(&'a [u8], usize)>,
    /// True for each corner with a texture coordinate.
    is_placed: Vec<bool>,
    unknown: Doubt,
    surfaces: Doubt,
    patience: &'a dyn Patience,
    steps: Steps<'a>,
}

impl<'a> Normal<'a> {
    fn new(patience: &'a dyn Patience) -> Self {
        let (text, is_textured, totals, known, lines) = Default::default();
        let (faces, is_placed, unknown, surfaces) = Default::default();
        let steps = Steps::new(patience);
        Self { text, is_textured, totals, known, lines, faces, is_placed, unknown, surfaces, patience, steps }
    }

    fn read(&mut self) -> Result<(), Diagnostic> {
        let text = self.text;
        let (mut rest, mut words, mut has_lines) = (text, vec![], false);
        self.lines.reserve(text.len());
        while next_statement(&mut rest, &mut words) {
            self.steps.take(words.len())?;
            match words[0] {
                b"v" => self.vertex(&words)?,
                b"vt" if self.is_textured => self.coordinate(&words)?,
                b"f" | b"fo" => self.face(&words)?,
                b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp" => self.surfaces.add(|| {
                    let hint = "export the mesh as polygons";
                    fault(text, words[0], "a curved surface is ignored", Some(hint))
                }),
                b"p" | b"l" | b"curv" | b"curv2" => has_lines = true,
                word if is_keyword(word) => {}
                word => self.unknown.add(|| {
                    let name = String::from_utf8_lossy(word);
                    let hint = nearest(&name, &COMMON).map(|near| format!("did you mean `{near}`?"));
                    let message = format!("{} is not a keyword of OBJ; its line is ignored", quoted(&*name));
                    fault(text, word, message, hint.as_deref())
                }),
            }
        }
        if !self.faces.is_empty() {
            return Ok(());
        }
        if let Some(error) = foreign_without_faces(text) {
            return Err(error);
        }
        let doubt = self.surfaces.0.take().or(self.unknown.0.take());
        let why = match &doubt {
            Some(doubt) => format!(": {}", doubt.message),
            None if text.is_empty() => ": the file is empty".to_owned(),
            None if has_lines => ", only points, lines or curves".to_owned(),
            None => String::new(),
        };
        let message = format!("the mesh has no faces{why}");
        Err(match doubt {
            Some(doubt) => Diagnostic { message, ..doubt },
            None => Diagnostic::error(message),
        })
    }

    /// Adds a vertex. A vertex that is not finite is an error only if a face uses it. It is stored as an infinite
    /// number, the offset of the faulty word, and 1 if the fault is a weight of 0.
    fn vertex(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        let (count, rule) = (words.len() - 1, "a vertex needs three numbers");
        // If there are four numbers, the fourth is a weight. Other numbers after the third are a colour and are
        // ignored.
        let wanted = count.min(if count == 4 { 4 } else { 3 });
        let mut numbers = [0.0, 0.0, 0.0, 1.0];
        for (number, word) in numbers.iter_mut().zip(&words[1..=wanted]) {
            *number = self.number(word, rule)?;
        }
        if count < 3 {
            return Err(fault(self.text, words[count], rule, None));
        }
        if count == 5 || count > 7 {
            let rule = "it needs three, and may have a weight or a colour of three or four";
            let message = format!("a vertex has {count} numbers: {rule}");
            return Err(fault(self.text, words[count.min(8)], message, None));
        }
        self.known[0] += 1;
        let divided = numbers.map(|number| number / numbers[3]);
        match numbers.iter().chain(&divided).position(|number| !number.is_finite()) {
            None => self.line(&words[..=wanted]),
            Some(place) => {
                let is_weightless = place > 3 && numbers[3] == 0.0;
                let word = words[1 + if is_weightless { 3 } else { place % 4 }];
                let offset = word.as_ptr() as usize - self.text.as_ptr() as usize;
                _ = writeln!(self.lines, "v inf {offset} {}", u8::from(is_weightless));
            }
        }
        Ok(())
    }

    /// Adds a texture coordinate. Missing numbers are 0.
    fn coordinate(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        let mut line: [&[u8]; 3] = [b"vt", b"0", b"0"];
        for (place, word) in line[1..].iter_mut().zip(&words[1..]) {
            let number = self.number(word, "a texture coordinate needs numbers")?;
            *place = if number.is_finite() { word } else { b"nan" };
        }
        self.known[1] += 1;
        self.line(&line);
        Ok(())
    }

    fn line(&mut self, words: &[&[u8]]) {
        for word in words {
            self.lines.extend_from_slice(word);
            self.lines.push(b' ');
        }
        self.lines.push(b'\n');
    }

    /// Parses a number, on the second reading only. Other programs' spellings of infinity and NaN give numbers that are
    /// not finite.
    fn number(&self, word: &[u8], rule: &str) -> Result<f64, Diagnostic> {
        if self.totals.is_none() {
            return Ok(1.0);
        }
        let text = String::from_utf8_lossy(word);
        let start = text.trim_start_matches(['-', '+']).get(..4).unwrap_or_default();
        match text.parse() {
            Ok(number) => Ok(number),
            Err(_) if text.contains("1.#") || start.eq_ignore_ascii_case("nan(") => Ok(f64::NAN),
            Err(_) => Err(self.not(word, rule, false)),
        }
    }

    /// Returns the error that a word breaks a rule.
    fn not(&self, word: &[u8], rule: &str, is_corner: bool) -> Diagnostic {
        let shown = String::from_utf8_lossy(word);
        fault(self.text, word, format!("{rule}, found {}", quoted(&*shown)), hint(&shown, is_corner))
    }

    fn face(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        let [vertices, coordinates] = self.totals.unwrap_or([u32::MAX.into(), i64::MAX]);
        // A negative index counts back from the face.
        let absolute = |index: i64, known| if index < 0 { index.saturating_add(1 + known) } else { index };
        let mut decimal = itoa::Buffer::new();
        self.lines.push(b'f');
        for &word in &words[1..] {
            let Some([vertex, coordinate, _]) = corner(word) else {
                return Err(self.not(word, "a face needs vertex indices such as `1 2 3`", true));
            };
            let index = absolute(vertex, self.known[0]);
            if !(1..=vertices).contains(&index) {
                let hint = match vertex {
                    0 => Some("indices start with 1"),
                    ..0 => Some("a negative index counts back from the face: -1 is the vertex before it"),
                    _ => None,
                };
                let message = format!("a face names a vertex that does not exist; the mesh has {vertices}");
                return Err(fault(self.text, word, message, hint));
            }
            self.lines.push(b' ');
            self.lines.extend_from_slice(decimal.format(index).as_bytes());
            if self.is_textured {
                let index = absolute(coordinate, self.known[1]);
                let is_placed = (1..=coordinates).contains(&index);
                self.is_placed.push(is_placed);
                if is_placed {
                    self.lines.push(b'/');
                    self.lines.extend_from_slice(decimal.format(index).as_bytes());
                }
            }
        }
        if words.len() < 4 {
            let (last, hint) = (words[words.len() - 1], "a line between two vertices is written `l 1 2`");
            return Err(fault(self.text, last, "a face needs at least three vertices", Some(hint)));
        }
        let count = words.len() - 1;
        if count > MOST_CORNERS {
            let message = format!("a face has {count} corners: {MOST_CORNERS} are the most");
            return Err(fault(self.text, words[0], message, Some("export the mesh as triangles")));
        }
        self.lines.push(b'\n');
        self.faces.push((words[0], count));
        Ok(())
    }
}

/// Returns the error for a part of a text.
fn fault(text: &[u8], part: &[u8], message: impl Into<String>, hint: Option<&str>) -> Diagnostic {
    Diagnostic { hint: hint.map(str::to_owned), ..Diagnostic::error(message) }.at(position(text, part))
}

/// Parses the indices of a corner; missing ones are 0. The forms are `v`, `v/vt`, `v//vn` and `v/vt/vn`, where a slash
/// may be followed by nothing. `None` for any other word.
fn corner(word: &[u8]) -> Option<[i64; 3]> {
    let mut indices = [0; 3];
    let mut parts = word.split(|&byte| byte == b'/');
    for (index, part) in indices.iter_mut().zip(&mut parts) {
        let unsigned = part.strip_prefix(b"-").or(part.strip_prefix(b"+")).unwrap_or(part);
        let (value, count, rest) = digits(unsigned, 0);
        if !rest.is_empty() || count == 0 && !part.is_empty() {
            return None;
        }
        // 18 digits fit into an i64.
        let value = if count > 18 { i64::MAX } else { value as i64 };
        *index = if part.starts_with(b"-") { -value } else { value };
    }
    (parts.next().is_none() && !word.starts_with(b"/")).then_some(indices)
}

/// Suggests a fix for a word that is not a number or not a corner.
fn hint(word: &str, is_corner: bool) -> Option<&'static str> {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    Some(match word {
        "\\" => "a backslash continues a statement only at the end of a line",
        _ if word.contains('\0') => "the word has a zero byte: the file may be damaged",
        _ if is_corner && word.contains([',', ';']) => "indices are separated by blanks",
        _ if is_corner && word.matches('/').count() > 2 => {
            "a corner has at most three indices: of its position, texture coordinate and normal"
        }
        _ if is_corner && word.starts_with('/') => "the index of the position comes first",
        _ if is_corner && is_number(word) => "indices are whole numbers",
        _ if word.matches(',').count() == 1 && !word.ends_with(',') && is_number(&word.replace(',', ".")) => {
            "a decimal point is needed, not a comma"
        }
        _ if word.split([',', ';']).all(|part| part.is_empty() || is_number(part)) => {
            "numbers are separated by blanks"
        }
        _ if is_number(&word.replace(['d', 'D'], "e")) => "an exponent is written with `e`, as in 1e-5",
        _ => return None,
    })
}
