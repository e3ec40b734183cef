//! Shows where in an OBJ file an error lies.

use super::Position;
use super::excerpt::line_with_caret;
use super::mesh::MeshError;
use super::obj_lines::{is_newline, keyword, without_comment, words};

impl MeshError {
    /// The line of the error; none for an error of the whole file.
    pub fn line(&self) -> Option<usize> {
        match *self {
            Self::NoFaces | Self::Memory(_) => None,
            Self::BadVertex { line }
            | Self::NotFinite { line }
            | Self::BadFace { line }
            | Self::FewCorners { line }
            | Self::NoSuchVertex { line, .. }
            | Self::NotText { line }
            | Self::Other { line, .. } => Some(line),
        }
    }
}

/// The line with the error, with a caret under the word in question. None for an error of the whole file.
pub fn excerpt(error: &MeshError, text: &[u8]) -> Option<(Position, String)> {
    let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
    let number = error.line()?;
    let line = text.split(is_newline).nth(number.checked_sub(1)?)?;
    let offset = wrong_part(error, line, text).min(line.len());
    let before = String::from_utf8_lossy(&line[..offset]);
    let column = before.chars().count() + 1;
    let at = Position { line: u32::try_from(number).ok()?, column: u32::try_from(column).ok()? };
    Some((at, line_with_caret(String::from_utf8_lossy(line).trim_end_matches('\r'), at)))
}

/// Where in its line the error lies, in bytes: at the first word that is wrong, or behind the last if too few
/// are there.
fn wrong_part(error: &MeshError, line: &[u8], text: &[u8]) -> usize {
    let content = without_comment(line);
    let mut values = words(content).skip(1);
    let wrong = match error {
        MeshError::BadVertex { .. } => {
            let bad = words(content).skip(1).find(|word| number(word).is_none());
            let is_scaled_by_zero = words(content).count() == 5;
            bad.or_else(|| words(content).nth(if is_scaled_by_zero { 4 } else { 5 }))
        }
        MeshError::NotFinite { .. } => values.find(|word| !number(word).is_some_and(f64::is_finite)),
        MeshError::BadFace { .. } => values.find(|corner| !is_corner(corner)),
        MeshError::NoSuchVertex { vertices, .. } => {
            let lines = text.split(is_newline).take(error.line().unwrap_or(0));
            let so_far = lines.filter(|line| keyword(line) == b"v").count();
            values.find(|corner| !super::mesh::is_vertex(corner, so_far, *vertices))
        }
        MeshError::NotText { .. } => {
            return str::from_utf8(line).map_or_else(|error| error.valid_up_to(), |_| 0);
        }
        MeshError::FewCorners { .. } => None,
        MeshError::NoFaces | MeshError::Memory(_) | MeshError::Other { .. } => words(content).next(),
    };
    match wrong {
        // A word is a slice of its line.
        Some(word) => word.as_ptr() as usize - line.as_ptr() as usize,
        None => content.trim_ascii_end().len(),
    }
}

fn number(word: &[u8]) -> Option<f64> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// Whether a corner has the form `v`, `v/vt`, `v//vn` or `v/vt/vn`.
fn is_corner(corner: &[u8]) -> bool {
    let parts: Vec<&[u8]> = corner.split(|&byte| byte == b'/').collect();
    let is_index = |part: &&[u8]| str::from_utf8(part).is_ok_and(|part| part.parse::<i64>().is_ok());
    let is_absent_or_index = |part: &&[u8]| part.is_empty() || is_index(part);
    parts.len() <= 3 && parts.first().is_some_and(is_index) && parts.iter().skip(1).all(is_absent_or_index)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::parse_obj;

    #[test]
    fn the_caret_stands_under_the_wrong_word() {
        for marked in [
            "v 1 @x 3",
            "v 1 2@",
            "v 1 2 3 @0",
            "v 1 2 3 4 @5",
            "v 1 @nan 3",
            "v 1e300 0 @-1e999",
            "f 1 @2.5 3",
            "f 1 2/ @x 3",
            "f 1 2 @1/2/3/4",
            "f 1 2@",
            "f 1 2@ # two",
            "f 1 2 @9",
            "f 1 @-5 2",
            "  f 1 @0 2",
            "f@",
        ] {
            let (before, after) = marked.split_once('@').unwrap();
            let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{before}{after}\r\nf 1 2 4\n");
            let error = parse_obj(text.as_bytes()).unwrap_err();
            let (at, shown) = excerpt(&error, text.as_bytes()).unwrap();
            let column = before.len() as u32 + 1;
            assert_eq!(at, Position { line: 4, column }, "{marked}: {error:?}");
            assert!(shown.starts_with(&format!("    4 | {before}{after}\n")), "{shown}");
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_shown() {
        let text = b"v 0 0 0\nv 0 \xff 0\n";
        let (at, shown) = excerpt(&parse_obj(text).unwrap_err(), text).unwrap();
        assert_eq!(
            (at, shown.as_str()),
            (Position { line: 2, column: 5 }, "    2 | v 0 \u{fffd} 0\n      |     ^")
        );
        assert_eq!(excerpt(&MeshError::NoFaces, b""), None);
    }
}
