//! Reads any OBJ text with `tobj`.
//!
//! `tobj` gets normalised statements: only vertices, texture coordinates and faces, one per line, with indices that
//! count from 1. This module handles the input that `tobj` would reject, drop or misread silently: continued lines,
//! comments, colours, indices out of range, numbers that are not finite, white space beyond ASCII, and unknown keywords.

use super::foreign_format::foreign_without_faces;
use super::lexer::nearest;
use super::mesh::{NamedFile, ObjFile};
use super::obj_lines::{COMMON, files_of, is_keyword, next_statement, position};
use super::plain_obj::{digits, keep_used};
use super::polygon::{MOST_CORNERS, OutlineFault, triangulate};
use crate::base::escape::quoted;
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::{Diagnostic, Severity};
use glam::{DVec2, DVec3};
use std::collections::BTreeSet;
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
        return Err(fault(text, at_offset(text, offset), message, hint));
    }
    // `tobj` would ignore the indices. The second reading finds the first of them.
    if normal.coordinates.is_empty() && normal.places.iter().any(Option::is_some) {
        return Err(Diagnostic::error("the mesh has no texture coordinates"));
    }
    let place = |corner: usize| {
        normal.places[corner].map(|_| found.texcoords.as_chunks().0[found.texcoord_indices[corner] as usize])
    };
    let unfit = (0..normal.places.len()).filter_map(place).filter(|[u, v]| !(u.is_finite() && v.is_finite()));
    if let Some([_, offset]) = unfit.min_by(|a, b| a[1].total_cmp(&b[1])) {
        let message = "a texture coordinate is not finite";
        return Err(fault(text, at_offset(text, offset), message, None));
    }
    let (mut triangles, mut start) = (vec![], 0);
    let [mut crossing, mut empty, mut outside] = [Doubt::default(), Doubt::default(), Doubt::default()];
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
    let mut file = ObjFile { vertices: normal.vertices as usize, files: normal.files, ..ObjFile::default() };
    // `keep_used` expects indices that count from 1.
    file.mesh.triangles = triangles.iter().map(|corners| corners.map(|k| found.indices[k] + 1)).collect();
    keep_used(&mut positions, &mut file.mesh.triangles);
    file.mesh.vertices = positions;
    if !normal.coordinates.is_empty() {
        let corner = |corner: usize| place(corner).map(DVec2::from_array);
        let corners = triangles.iter().map(|&[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?]));
        file.texture_coordinates = corners.collect();
        let is_outside = |&index: &usize| {
            corner(index).is_some_and(|place| (place - 0.5).abs().max_element() > 0.5 + VISIBLY_OUTSIDE)
        };
        let outer = (0..normal.places.len()).filter(is_outside).filter_map(|index| normal.places[index]);
        let all: BTreeSet<usize> = outer.collect();
        for coordinate in all {
            outside.add(|| {
                let message = "a texture coordinate is outside 0 to 1: there the picture's edge continues";
                let hint = "keep the coordinates from 0 to 1: a picture is not repeated";
                fault(text, normal.coordinates[coordinate], message, Some(hint))
            });
        }
    }
    let doubts = [normal.unknown, normal.surfaces, normal.commands, crossing, empty, outside];
    file.doubts = doubts.into_iter().filter_map(Doubt::told).collect();
    file.doubts.sort_by_key(|doubt| doubt.position().map(|at| (at.line, at.column)));
    Ok(file)
}

/// The largest distance of a texture coordinate from 0 to 1 that is taken for a rounding error of the program that
/// wrote it. It moves the picture by less than a texel of most pictures.
const VISIBLY_OUTSIDE: f64 = 1e-3;

/// Returns the text from an offset on that was stored in place of a number. On the first reading such a number is no
/// offset.
fn at_offset(text: &[u8], offset: f64) -> &[u8] {
    &text[(offset as usize).min(text.len())..]
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
    /// The number of vertices read so far.
    vertices: i64,
    /// The statements of the texture coordinates read so far, if `is_textured`.
    coordinates: Vec<&'a [u8]>,
    lines: Vec<u8>,
    /// The statement of each face, and the number of its corners.
    faces: Vec<(&'a [u8], usize)>,
    /// The index of each corner's texture coordinate, if `is_textured`.
    places: Vec<Option<usize>>,
    files: Vec<NamedFile>,
    unknown: Doubt,
    surfaces: Doubt,
    commands: Doubt,
    patience: &'a dyn Patience,
    steps: Steps<'a>,
}

impl<'a> Normal<'a> {
    fn new(patience: &'a dyn Patience) -> Self {
        Self {
            text: &[],
            is_textured: false,
            totals: None,
            vertices: 0,
            coordinates: vec![],
            lines: vec![],
            faces: vec![],
            places: vec![],
            files: vec![],
            unknown: Doubt::default(),
            surfaces: Doubt::default(),
            commands: Doubt::default(),
            patience,
            steps: Steps::new(patience),
        }
    }

    fn read(&mut self) -> Result<(), Diagnostic> {
        let text = self.text;
        let (mut rest, mut words, mut has_lines) = (text, vec![], false);
        self.lines.reserve(text.len());
        while next_statement(&mut rest, &mut words) {
            self.steps.take(words.len())?;
            self.files.extend(files_of(&words));
            match words[0] {
                b"v" => self.vertex(&words)?,
                b"vt" if self.is_textured => self.coordinate(&words)?,
                b"f" | b"fo" => self.face(&words)?,
                b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp" => self.surfaces.add(|| {
                    let hint = "export the mesh as polygons";
                    fault(text, words[0], "a curved surface is ignored", Some(hint))
                }),
                b"call" => self.commands.add(|| {
                    let hint = "insert the lines of that file here";
                    fault(text, words[0], "`call` is ignored, and so is the file that it names", Some(hint))
                }),
                b"csh" => self
                    .commands
                    .add(|| fault(text, words[0], "`csh` is ignored: no command of a file is run", None)),
                b"p" | b"l" | b"curv" | b"curv2" => has_lines = true,
                word if is_keyword(word) => {}
                word if self.is_hidden_keyword(word) => {
                    let found = quoted(&*String::from_utf8_lossy(word));
                    let message = format!("a line begins with a keyword and a blank, found {found}");
                    return Err(fault(text, word, message, Some(ODD_BLANK)));
                }
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
        let doubt = self.surfaces.0.take().or(self.commands.0.take()).or(self.unknown.0.take());
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
        self.vertices += 1;
        let divided = numbers.map(|number| number / numbers[3]);
        match numbers.iter().chain(&divided).position(|number| !number.is_finite()) {
            None => self.line(&words[..=wanted]),
            Some(place) => {
                let is_weightless = place > 3 && numbers[3] == 0.0;
                let word = words[1 + if is_weightless { 3 } else { place % 4 }];
                _ = writeln!(self.lines, "v inf {} {}", self.offset(word), u8::from(is_weightless));
            }
        }
        Ok(())
    }

    /// Adds a texture coordinate. Missing numbers are 0. One that is not finite is an error only if a face uses it. It is
    /// stored as an infinite number and the offset of the faulty word.
    fn coordinate(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        let mut line: [&[u8]; 3] = [b"vt", b"0", b"0"];
        let mut unfit = None;
        for (place, &word) in line[1..].iter_mut().zip(&words[1..]) {
            let number = self.number(word, "a texture coordinate needs numbers")?;
            *place = word;
            unfit = unfit.or((!number.is_finite()).then_some(word));
        }
        self.coordinates.push(words[0]);
        match unfit {
            None => self.line(&line),
            Some(word) => _ = writeln!(self.lines, "vt inf {}", self.offset(word)),
        }
        Ok(())
    }

    /// Returns true for a keyword that is read, with an odd blank before or behind it.
    fn is_hidden_keyword(&self, word: &[u8]) -> bool {
        let text = String::from_utf8_lossy(word);
        let mut parts = text.split(is_odd_blank).filter(|part| !part.is_empty());
        match parts.next() {
            Some("v" | "f" | "fo") => text.contains(is_odd_blank),
            Some("vt") => self.is_textured && text.contains(is_odd_blank),
            _ => false,
        }
    }

    /// Returns the offset of a word in the text.
    fn offset(&self, word: &[u8]) -> usize {
        word.as_ptr() as usize - self.text.as_ptr() as usize
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
        // `tobj` would cut a word at white space beyond ASCII.
        if self.totals.is_none() && word.is_ascii() {
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
        let mut decimal = itoa::Buffer::new();
        self.lines.push(b'f');
        for &word in &words[1..] {
            let Some([Some(vertex), coordinate, _]) = corner(word) else {
                return Err(self.not(word, "a face needs vertex indices such as `1 2 3`", true));
            };
            let index = self.absolute(vertex, [self.vertices, vertices], "vertex", word)?;
            self.lines.push(b' ');
            self.lines.extend_from_slice(decimal.format(index).as_bytes());
            if !self.is_textured {
                continue;
            }
            let known = [self.coordinates.len() as i64, coordinates];
            let from_start = |index| self.absolute(index, known, "texture coordinate", word);
            let index = coordinate.map(from_start).transpose()?;
            self.places.push(index.map(|index| index as usize - 1));
            if let Some(index) = index {
                self.lines.push(b'/');
                self.lines.extend_from_slice(decimal.format(index).as_bytes());
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

    /// Returns an index that counts from 1, of a vertex or texture coordinate in the corner `word`. A negative one counts
    /// back from the face. There are `before` of its kind so far, and `all` in the file.
    fn absolute(
        &self,
        index: i64,
        [before, all]: [i64; 2],
        name: &str,
        word: &[u8],
    ) -> Result<i64, Diagnostic> {
        let absolute = if index < 0 { index.saturating_add(1 + before) } else { index };
        if (1..=all).contains(&absolute) {
            return Ok(absolute);
        }
        let hint = match index {
            0 => Some("indices start with 1".to_owned()),
            ..0 => Some(format!("a negative index counts back from the face: -1 is the {name} before it")),
            _ => None,
        };
        let message = format!("a face names a {name} that does not exist; the mesh has {all}");
        Err(fault(self.text, word, message, hint.as_deref()))
    }
}

/// Returns the error for a part of a text.
fn fault(text: &[u8], part: &[u8], message: impl Into<String>, hint: Option<&str>) -> Diagnostic {
    Diagnostic { hint: hint.map(str::to_owned), ..Diagnostic::error(message) }.at(position(text, part))
}

/// Parses the indices of a corner. The forms are `v`, `v/vt`, `v//vn` and `v/vt/vn`, where a slash may be followed by
/// nothing. `None` for any other word.
fn corner(word: &[u8]) -> Option<[Option<i64>; 3]> {
    let mut indices = [None; 3];
    let mut parts = word.split(|&byte| byte == b'/');
    for (index, part) in indices.iter_mut().zip(&mut parts) {
        let unsigned = part.strip_prefix(b"-").or(part.strip_prefix(b"+")).unwrap_or(part);
        let (value, count, rest) = digits(unsigned, 0);
        if !rest.is_empty() || count == 0 && !part.is_empty() {
            return None;
        }
        // 18 digits fit into an i64.
        let value = if count > 18 { i64::MAX } else { value as i64 };
        let signed = if part.starts_with(b"-") { -value } else { value };
        *index = Some(signed).filter(|_| !part.is_empty());
    }
    (parts.next().is_none() && !word.starts_with(b"/")).then_some(indices)
}

const ODD_BLANK: &str =
    "it contains a blank that is not ASCII, such as a no-break space: write an ordinary one";

/// Returns true for white space that does not separate the words of OBJ, for characters of no width, and for bytes that
/// are no text, which a no-break space is in other encodings.
fn is_odd_blank(character: char) -> bool {
    let has_no_width = matches!(character, '\u{200b}'..='\u{200f}' | '\u{2060}' | '\u{feff}');
    let is_blank = !character.is_ascii() && character.is_whitespace();
    is_blank || has_no_width || character == char::REPLACEMENT_CHARACTER
}

/// Suggests a fix for a word that is not a number or not a corner.
fn hint(word: &str, is_corner: bool) -> Option<&'static str> {
    let is_number = |word: &str| word.parse::<f64>().is_ok();
    Some(match word {
        "\\" => "a backslash continues a statement only at the end of a line",
        _ if word.contains('\0') => "the word has a zero byte: the file may be damaged",
        _ if word.contains(is_odd_blank) && word.contains(|c: char| c.is_ascii_digit()) => ODD_BLANK,
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
