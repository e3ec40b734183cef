//! Turns an OBJ text into plain statements for `tobj`.
//!
//! One pass validates every number and index, and writes vertices, texture coordinates and faces, one per line, with
//! indices that count from 1. So `tobj` gets nothing that it would reject, drop or misread silently: continued lines,
//! comments, colours, indices out of range, numbers that are not finite, white space beyond ASCII, unknown keywords.

use super::plain::digits;
use super::words::{COMMON, files_of, is_keyword, next_statement, position};
use crate::base::escape::quoted;
use crate::base::patience::{Patience, Steps};
use crate::diagnostic::{Diagnostic, Severity};
use crate::scene::foreign_format::foreign_without_faces;
use crate::scene::lexer::nearest;
use crate::scene::mesh::NamedFile;
use crate::scene::polygon::MOST_CORNERS;
use std::collections::{BTreeMap, BTreeSet};

/// The plain statements of an OBJ text.
#[derive(Default)]
pub struct Statements<'a> {
    text: &'a [u8],
    /// True if texture coordinates are read.
    is_textured: bool,
    /// The statements for `tobj`. A point that is not finite is written as zeros.
    pub lines: Vec<u8>,
    pub vertices: Points<'a>,
    pub coordinates: Points<'a>,
    /// The keywords of texture coordinates outside the picture, by their numbers.
    outside: BTreeMap<i64, &'a [u8]>,
    /// The keyword and the number of corners of each face.
    pub faces: Vec<(&'a [u8], usize)>,
    /// The corners of all faces.
    pub corners: Vec<Corner<'a>>,
    pub files: Vec<NamedFile>,
    /// True if there are points, lines or curves.
    has_lines: bool,
    /// The first word of each kind of warning, and the number of all.
    warnings: BTreeMap<MeshWarning, (&'a [u8], usize)>,
}

/// The vertices or the texture coordinates of a text.
#[derive(Default)]
pub struct Points<'a> {
    /// The name of their kind.
    name: &'static str,
    /// The number of points so far.
    pub total: i64,
    /// Words that make a point infinite or NaN, by its number.
    infinite: BTreeMap<i64, &'a [u8]>,
}

/// A corner of a face. Numbers of points count from 1. An index that counts back beyond the first point stays negative.
pub struct Corner<'a> {
    word: &'a [u8],
    vertex: i64,
    /// `None` unless `is_textured`.
    pub coordinate: Option<i64>,
}

/// Something in a mesh that is valid, but probably a mistake, ordered by how well it explains that a mesh has no faces.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum MeshWarning {
    CurvedSurface,
    Command,
    UnknownKeyword,
    CrossingOutline,
    EmptyOutline,
    OutsidePicture,
}

impl<'a> Statements<'a> {
    /// Reads a text without a byte order mark. Fails with one error: a point that is missing, else the first statement that
    /// is not valid, else that there are no faces, else a point that is not finite.
    pub fn read(text: &'a [u8], is_textured: bool, patience: &dyn Patience) -> Result<Self, Diagnostic> {
        let mut all = Self {
            text,
            is_textured,
            lines: Vec::with_capacity(text.len()),
            vertices: Points { name: "vertex", ..Points::default() },
            coordinates: Points { name: "texture coordinate", ..Points::default() },
            ..Self::default()
        };
        let (mut rest, mut words, mut steps) = (text, vec![], Steps::new(patience));
        let mut fault = None;
        while next_statement(&mut rest, &mut words) {
            steps.take(words.len())?;
            all.vertices.total += i64::from(words[0] == b"v");
            all.coordinates.total += i64::from(words[0] == b"vt");
            // After a fault, points are only counted.
            if fault.is_none() {
                fault = all.add(&words).err();
            }
        }
        // Faces may precede the points that they name, so missing points are known only now. They precede the fault.
        let fault =
            all.missing_point().or(fault).or_else(|| all.without_faces()).or_else(|| all.infinite_point());
        if let Some(fault) = fault {
            return Err(fault);
        }
        for keyword in all.used_words(&all.outside, |corner| corner.coordinate) {
            all.warn(MeshWarning::OutsidePicture, keyword);
        }
        Ok(all)
    }

    fn add(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        self.files.extend(files_of(words));
        match words[0] {
            b"v" => return self.vertex(words),
            b"vt" if self.is_textured => return self.coordinate(words),
            b"f" | b"fo" => return self.face(words),
            b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp" => self.warn(MeshWarning::CurvedSurface, words[0]),
            b"call" | b"csh" => self.warn(MeshWarning::Command, words[0]),
            b"p" | b"l" | b"curv" | b"curv2" => self.has_lines = true,
            word if is_keyword(word) => {}
            word if self.is_hidden_keyword(word) => {
                return Err(self.unlike(word, "a line begins with a keyword and a blank", Some(ODD_BLANK)));
            }
            word => self.warn(MeshWarning::UnknownKeyword, word),
        }
        Ok(())
    }

    fn vertex(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        const RULE: &str = "a vertex needs three numbers";
        let count = words.len() - 1;
        // A fourth number alone is a weight. More numbers after the third are a colour, which is ignored.
        let used = if count == 4 { 4 } else { count.min(3) };
        let numbers = self.numbers(&words[1..=used], [0.0, 0.0, 0.0, 1.0], RULE)?;
        if count < 3 {
            return Err(self.fault(words[count], RULE, None));
        }
        if count == 5 || count > 7 {
            let rule = "it needs three, and may have a weight or a colour of three or four";
            let first_superfluous = words[count.min(8)];
            return Err(self.fault(first_superfluous, format!("a vertex has {count} numbers: {rule}"), None));
        }
        let weight = numbers[3];
        let infinite = |numbers: [f64; 4]| numbers.iter().position(|number| !number.is_finite());
        let unfit = match infinite(numbers) {
            Some(place) => Some(words[1 + place]),
            None if weight == 0.0 => Some(words[4]),
            None => infinite(numbers.map(|number| number / weight)).map(|place| words[1 + place]),
        };
        self.write_point(&words[..=used], unfit.is_some());
        self.vertices.add_infinite(unfit);
        Ok(())
    }

    /// Adds a texture coordinate. Missing numbers are 0.
    fn coordinate(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        /// The largest distance of a texture coordinate from 0 to 1 that is taken for a rounding error of the program
        /// that wrote it. It moves the picture by less than a texel of most pictures.
        const VISIBLY_OUTSIDE: f64 = 1e-3;
        let mut line: [&[u8]; 3] = [words[0], b"0", b"0"];
        let used = &words[..words.len().min(3)];
        line[..used.len()].copy_from_slice(used);
        let numbers = self.numbers(&used[1..], [0.0; 2], "a texture coordinate needs numbers")?;
        if numbers.iter().any(|number| (number - 0.5).abs() > 0.5 + VISIBLY_OUTSIDE) {
            self.outside.insert(self.coordinates.total, words[0]);
        }
        let unfit = numbers.iter().position(|number| !number.is_finite()).map(|place| words[1 + place]);
        self.write_point(&line, unfit.is_some());
        self.coordinates.add_infinite(unfit);
        Ok(())
    }

    /// Parses words. Other programs' spellings of infinity and NaN give numbers that are not finite.
    fn numbers<const N: usize>(
        &self,
        words: &[&[u8]],
        mut numbers: [f64; N],
        rule: &str,
    ) -> Result<[f64; N], Diagnostic> {
        for (number, word) in numbers.iter_mut().zip(words) {
            let text = String::from_utf8_lossy(word);
            let is_nan = |text: &str| text.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("nan("));
            *number = match text.parse() {
                Ok(number) => number,
                Err(_) if text.contains("1.#") || is_nan(text.trim_start_matches(['-', '+'])) => f64::NAN,
                Err(_) => return Err(self.unlike(word, rule, number_hint(&text))),
            };
        }
        Ok(numbers)
    }

    /// Writes a vertex or a texture coordinate. One that is not finite is written as zeros.
    fn write_point(&mut self, words: &[&[u8]], is_infinite: bool) {
        let zeros: [&[u8]; 4] = [words[0], b"0", b"0", b"0"];
        for word in if is_infinite { &zeros } else { words } {
            self.lines.extend_from_slice(word);
            self.lines.push(b' ');
        }
        self.lines.push(b'\n');
    }

    fn face(&mut self, words: &[&'a [u8]]) -> Result<(), Diagnostic> {
        self.lines.push(b'f');
        for &word in &words[1..] {
            let Some([Some(vertex), coordinate, _]) = corner(word) else {
                let hint = corner_hint(&String::from_utf8_lossy(word));
                return Err(self.unlike(word, "a face needs vertex indices such as `1 2 3`", hint));
            };
            let vertex = self.vertices.number(vertex);
            let coordinate = coordinate.filter(|_| self.is_textured);
            let coordinate = coordinate.map(|index| self.coordinates.number(index));
            self.lines.push(b' ');
            // An index that is still negative names a missing point, and the lines are not used.
            push_decimal(vertex.unsigned_abs(), &mut self.lines);
            if let Some(coordinate) = coordinate {
                self.lines.push(b'/');
                push_decimal(coordinate.unsigned_abs(), &mut self.lines);
            }
            self.corners.push(Corner { word, vertex, coordinate });
        }
        self.lines.push(b'\n');
        let count = words.len() - 1;
        if count < 3 {
            let hint = "a line between two vertices is written `l 1 2`";
            return Err(self.fault(words[count], "a face needs at least three vertices", Some(hint)));
        }
        if count > MOST_CORNERS {
            let message = format!("a face has {count} corners: {MOST_CORNERS} are the most");
            return Err(self.fault(words[0], message, Some("export the mesh as triangles")));
        }
        self.faces.push((words[0], count));
        Ok(())
    }

    /// Returns the error for the first corner that names a missing vertex or texture coordinate.
    fn missing_point(&self) -> Option<Diagnostic> {
        self.corners.iter().find_map(|&Corner { word, vertex, coordinate }| {
            let of_vertex = self.missing(word, &self.vertices, vertex);
            of_vertex.or_else(|| self.missing(word, &self.coordinates, coordinate?))
        })
    }

    /// Returns the error that a corner names a missing point, or `None` if there is a point with this number.
    fn missing(&self, corner: &[u8], points: &Points<'_>, number: i64) -> Option<Diagnostic> {
        let &Points { name, total, .. } = points;
        if (1..=total).contains(&number) {
            return None;
        }
        let hint = match number {
            0 => Some("indices start with 1"),
            ..0 => Some(&*format!("a negative index counts back from the face: -1 is the {name} before it")),
            _ => None,
        };
        let message = format!("a face names a {name} that does not exist; the mesh has {total}");
        Some(self.fault(corner, message, hint))
    }

    /// Returns the error that there are no faces, with the most likely reason.
    fn without_faces(&self) -> Option<Diagnostic> {
        if !self.faces.is_empty() {
            return None;
        }
        let warning = self.warnings.iter().next().map(|(&kind, &(word, _))| self.described(kind, word));
        let why = match &warning {
            Some(warning) => format!(": {}", warning.message),
            None if self.text.is_empty() => ": the file is empty".to_owned(),
            None if self.has_lines => ", only points, lines or curves".to_owned(),
            None => String::new(),
        };
        let faceless = Diagnostic::error(format!("the mesh has no faces{why}"));
        let hinted = warning.map(|warning| Diagnostic { message: faceless.message.clone(), ..warning });
        foreign_without_faces(self.text).or(hinted).or(Some(faceless))
    }

    /// Returns the error for the first vertex, or else texture coordinate, that a face uses and that is not finite.
    fn infinite_point(&self) -> Option<Diagnostic> {
        let vertices = self.used_words(&self.vertices.infinite, |corner| Some(corner.vertex));
        let Some(word) = vertices.first() else {
            let coordinates = self.used_words(&self.coordinates.infinite, |corner| corner.coordinate);
            let fault = |word: &&[u8]| self.fault(word, "a texture coordinate is not finite", None);
            return coordinates.first().map(fault);
        };
        let is_weightless = str::from_utf8(word).is_ok_and(|word| word.parse() == Ok(0.0));
        Some(match is_weightless {
            true => {
                let hint = "leave it out, or make it 1";
                self.fault(word, "a vertex has the weight 0: it is at infinity", Some(hint))
            }
            false => self.fault(word, "a vertex has a coordinate that is not finite", None),
        })
    }

    /// Returns the words of the points that faces use, in the order of their numbers. `number` returns the number of a
    /// corner's point.
    fn used_words(
        &self,
        words: &BTreeMap<i64, &'a [u8]>,
        number: fn(&Corner<'a>) -> Option<i64>,
    ) -> Vec<&'a [u8]> {
        let named = self.corners.iter().filter_map(|corner| words.get_key_value(&number(corner)?));
        named.collect::<BTreeSet<_>>().into_iter().map(|(_, &word)| word).collect()
    }

    /// Returns true for a keyword that is read, with an odd blank before or behind it.
    fn is_hidden_keyword(&self, word: &[u8]) -> bool {
        let text = String::from_utf8_lossy(word);
        let keyword = text.split(is_odd_blank).find(|part| !part.is_empty());
        let is_read = matches!(keyword, Some("v" | "f" | "fo")) || self.is_textured && keyword == Some("vt");
        is_read && text.contains(is_odd_blank)
    }

    /// Notes a statement to warn of, by one of its words.
    pub fn warn(&mut self, kind: MeshWarning, word: &'a [u8]) {
        self.warnings.entry(kind).or_insert((word, 0)).1 += 1;
    }

    /// Returns a warning about the first statement of each kind, in the order of the text.
    pub fn described_warnings(&self) -> Vec<Diagnostic> {
        let warning = |(&kind, &(word, count)): (&MeshWarning, &(&[u8], usize))| {
            let Diagnostic { message, places, hint, .. } = self.described(kind, word);
            let others = if count > 1 { format!(" (and {} more)", count - 1) } else { String::new() };
            Diagnostic { severity: Severity::Warning, message: message + &others, places, hint }
        };
        let mut warnings: Vec<_> = self.warnings.iter().map(warning).collect();
        warnings.sort_by_key(|warning| warning.position().map(|at| (at.line, at.column)));
        warnings
    }

    /// Returns the description of a warning about a word, as an error. Warnings have another severity.
    fn described(&self, kind: MeshWarning, word: &[u8]) -> Diagnostic {
        let (message, hint) = match kind {
            MeshWarning::CurvedSurface => {
                ("a curved surface is ignored", Some("export the mesh as polygons"))
            }
            MeshWarning::Command if word == b"csh" => ("`csh` is ignored: no command of a file is run", None),
            MeshWarning::Command => (
                "`call` is ignored, and so is the file that it names",
                Some("insert the lines of that file here"),
            ),
            MeshWarning::UnknownKeyword => {
                let name = String::from_utf8_lossy(word);
                let hint = nearest(&name, &COMMON).map(|near| format!("did you mean `{near}`?"));
                let message = format!("{} is not a keyword of OBJ; its line is ignored", quoted(&*name));
                return self.fault(word, message, hint.as_deref());
            }
            MeshWarning::CrossingOutline => (
                "the outline of the polygon crosses itself",
                Some("its triangles are a guess: export the mesh as triangles"),
            ),
            MeshWarning::EmptyOutline => ("the outline of the polygon encloses nothing", None),
            MeshWarning::OutsidePicture => (
                "a texture coordinate is outside 0 to 1: there the picture's edge continues",
                Some("keep the coordinates from 0 to 1: a picture is not repeated"),
            ),
        };
        self.fault(word, message, hint)
    }

    /// Returns the error that a rule is broken by a word, which it names.
    fn unlike(&self, word: &[u8], rule: &str, hint: Option<&str>) -> Diagnostic {
        let found = quoted(&*String::from_utf8_lossy(word));
        self.fault(word, format!("{rule}, found {found}"), hint)
    }

    /// Returns the error for a word.
    fn fault(&self, word: &[u8], message: impl Into<String>, hint: Option<&str>) -> Diagnostic {
        let hint = hint.map(str::to_owned);
        Diagnostic { hint, ..Diagnostic::error(message) }.at(position(self.text, word))
    }
}

impl<'a> Points<'a> {
    /// Notes the word that makes the last point infinite or NaN, if any.
    fn add_infinite(&mut self, word: Option<&'a [u8]>) {
        self.infinite.extend(word.map(|word| (self.total, word)));
    }

    /// Returns the number of the point with this index. A negative index counts back from the last point.
    fn number(&self, index: i64) -> i64 {
        if index < 0 && -index <= self.total { index + 1 + self.total } else { index }
    }
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

/// Writes a number in decimal, in fewer steps than `write!`.
fn push_decimal(number: u64, text: &mut Vec<u8>) {
    if number >= 10 {
        push_decimal(number / 10, text);
    }
    text.push(b'0' + (number % 10) as u8);
}

/// Suggests a fix for a word that is not a corner.
fn corner_hint(word: &str) -> Option<&'static str> {
    odd_character_hint(word).or(match word {
        _ if word.contains([',', ';']) => Some("indices are separated by blanks"),
        _ if word.matches('/').count() > 2 => {
            Some("a corner has at most three indices: of its position, texture coordinate and normal")
        }
        _ if word.starts_with('/') => Some("the index of the position comes first"),
        _ if is_number(word) => Some("indices are whole numbers"),
        _ => None,
    })
}

/// Suggests a fix for a word that is not a number.
fn number_hint(word: &str) -> Option<&'static str> {
    let has_decimal_comma = word.matches(',').count() == 1 && !word.ends_with(',');
    odd_character_hint(word).or(match word {
        _ if has_decimal_comma && is_number(&word.replace(',', ".")) => {
            Some("a decimal point is needed, not a comma")
        }
        _ if word.split([',', ';']).all(|part| part.is_empty() || is_number(part)) => {
            Some("numbers are separated by blanks")
        }
        _ if is_number(&word.replace(['d', 'D'], "e")) => Some("an exponent is written with `e`, as in 1e-5"),
        _ => None,
    })
}

/// Suggests a fix for a word with a character that is neither in numbers nor in corners.
fn odd_character_hint(word: &str) -> Option<&'static str> {
    match word {
        "\\" => Some("a backslash continues a statement only at the end of a line"),
        _ if word.contains('\0') => Some("the word has a zero byte: the file may be damaged"),
        _ if word.contains(is_odd_blank) && word.contains(|c: char| c.is_ascii_digit()) => Some(ODD_BLANK),
        _ => None,
    }
}

fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::patience::Endless;

    #[test]
    fn statements_become_plain() {
        let text = "v 1 2 \\\n3 # first\nvt .5\nv 4 5 6 2\nv 7 8 9 .1 .2 .3\n\
                    v nan 0 0\no x\nfo -4/1/7 2// +3/-1\nf 1 2 3\n";
        let plain = |is_textured| {
            let statements = Statements::read(text.as_bytes(), is_textured, &Endless).ok().unwrap();
            String::from_utf8(statements.lines).unwrap().replace(" \n", "\n")
        };
        let vertices = ["v 1 2 3\n", "v 4 5 6 2\nv 7 8 9\nv 0 0 0\n"];
        assert_eq!(plain(true), vertices.join("vt .5 0\n") + "f 1/1 2 3/1\nf 1 2 3\n");
        assert_eq!(plain(false), vertices.concat() + "f 1 2 3\nf 1 2 3\n");
    }
}
