//! Splits an OBJ text into statements and their words.
//!
//! Lines end with a line feed, a carriage return, or both. A comment begins with `#`. A backslash at the end of a line,
//! also before trailing blanks, continues the statement on the next line. If the next line starts with a keyword, as
//! after `usemtl wood\`, or a comment follows, the backslash is dropped and the statement ends.

use crate::diagnostic::Position;
use crate::scene::mesh::NamedFile;
use std::collections::BTreeSet;

/// The keywords of OBJ ("Advanced Visualizer Manual", appendix B, Wavefront 1995). `fo` is an old name of `f`.
const KEYWORDS: &str = "v vt vn f fo g s o usemtl mtllib p l surf bsp bzp cdc cdp curv curv2 vp cstype deg bmat step \
                        parm trim hole scrv sp end con mg bevel c_interp d_interp lod usemap maplib shadow_obj \
                        trace_obj ctech stech res t vw";

/// Common keywords, suggested when an unknown word is found.
pub const COMMON: [&str; 10] = ["v", "f", "vt", "vn", "g", "o", "s", "usemtl", "mtllib", "l"];

pub fn is_keyword(word: &[u8]) -> bool {
    KEYWORDS.split(' ').any(|keyword| keyword.as_bytes() == word)
}

/// The kind of the files that `mtllib` names.
pub const LIBRARY: &str = "material library";

/// Returns the files that a statement names, if any. A material library may have blanks in its name.
pub fn files_of(words: &[&[u8]]) -> Vec<NamedFile> {
    let (kind, names) = match words[0] {
        b"mtllib" => (LIBRARY, &words[1..]),
        b"maplib" => ("texture library", &words[1..]),
        b"call" | b"shadow_obj" | b"trace_obj" => ("mesh", &words[1..words.len().min(2)]),
        _ => return vec![],
    };
    named(kind, names, names)
}

/// Returns the files that these words may name: each one of `single`, or all of them with blanks between.
fn named(kind: &'static str, single: &[&[u8]], all: &[&[u8]]) -> Vec<NamedFile> {
    let whole = (all.len() > 1).then(|| all.join(&b' '));
    let names = single.iter().map(|name| name.to_vec()).chain(whole);
    names.map(|name| (kind, String::from_utf8_lossy(&name).into_owned())).collect()
}

/// Returns the pictures that a statement of a material library names: the last word, or all after the keyword.
fn pictures_of(words: &[&[u8]]) -> Vec<NamedFile> {
    const KEYWORDS: [&[u8]; 5] = [b"bump", b"disp", b"decal", b"refl", b"norm"];
    if !words[0].starts_with(b"map_") && !KEYWORDS.contains(&words[0]) {
        return vec![];
    }
    named("texture", &words[words.len().max(2) - 1..], &words[1..])
}

/// Returns the files that a material library, or else an OBJ text, names.
pub fn files_in(kind: &str, mut text: &[u8]) -> Vec<NamedFile> {
    let of_statement = if kind == LIBRARY { pictures_of } else { files_of };
    let (mut words, mut files) = (vec![], vec![]);
    while next_statement(&mut text, &mut words) {
        files.extend(of_statement(&words));
    }
    each_once(files)
}

/// Returns files without those that were named before.
pub fn each_once(mut files: Vec<NamedFile>) -> Vec<NamedFile> {
    let mut named = BTreeSet::new();
    files.retain(|file| named.insert(file.clone()));
    files
}

/// Reads the first statement of `rest` into `words` and advances `rest` behind it. Returns false if there is none.
pub fn next_statement<'a>(rest: &mut &'a [u8], words: &mut Vec<&'a [u8]>) -> bool {
    words.clear();
    loop {
        *rest = after_blanks(rest);
        match rest.first() {
            None => return !words.is_empty(),
            Some(b'\n' | b'\r') => {
                *rest = after_line_end(rest);
                if !words.is_empty() {
                    return true;
                }
            }
            Some(b'#') => {
                *rest =
                    &rest[rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len())..];
            }
            Some(_) => {
                let word = first_word(rest);
                *rest = after_blanks(&rest[word.len()..]);
                let is_last = matches!(rest.first(), None | Some(b'\n' | b'\r' | b'#'));
                let Some(start) = word.strip_suffix(b"\\").filter(|_| is_last) else {
                    words.push(word);
                    continue;
                };
                words.extend(Some(start).filter(|start| !start.is_empty()));
                if !rest.starts_with(b"#") {
                    *rest = after_line_end(rest);
                }
                let next = first_word(after_blanks(rest));
                if is_keyword(next.strip_suffix(b"\\").unwrap_or(next)) && !words.is_empty() {
                    return true;
                }
            }
        }
    }
}

fn after_blanks(text: &[u8]) -> &[u8] {
    let is_other = |byte: &u8| !matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c');
    &text[text.iter().position(is_other).unwrap_or(text.len())..]
}

/// Returns the text after its leading line end.
fn after_line_end(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\r\n").or(text.get(1..)).unwrap_or_default()
}

/// Returns the first word of a text. Older Windows programs write `1.#IND` or `-1.#QNAN` for numbers that are not
/// finite.
fn first_word(text: &[u8]) -> &[u8] {
    const ENDINGS: [&[u8]; 4] = [b"#IND", b"#INF", b"#QNAN", b"#SNAN"];
    let end_of_word = |text: &[u8]| {
        let is_end = |byte: &u8| *byte <= b'#' && matches!(byte, b' ' | b'\t'..=b'\r' | b'#');
        text.iter().position(is_end).unwrap_or(text.len())
    };
    let (word, after) = text.split_at(end_of_word(text));
    if word.ends_with(b"1.") && ENDINGS.iter().any(|ending| after.starts_with(ending)) {
        return &text[..word.len() + 1 + end_of_word(&after[1..])];
    }
    word
}

/// Returns the position of `part` in `text`.
pub fn position(text: &[u8], part: &[u8]) -> Position {
    let before = &text[..part.as_ptr() as usize - text.as_ptr() as usize];
    let before = String::from_utf8_lossy(before).replace("\r\n", "\n");
    let start = before.rfind(['\n', '\r']).map_or(0, |end| end + 1);
    let [lines, characters] =
        [before[..start].matches(['\n', '\r']).count(), before[start..].chars().count()];
    Position { line: lines as u32 + 1, column: characters as u32 + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the words of all statements, with `|` between statements.
    fn split(text: &str) -> String {
        let (mut rest, mut words, mut all) = (text.as_bytes(), vec![], vec![]);
        while next_statement(&mut rest, &mut words) {
            all.push(String::from_utf8(words.join(&b' ')).unwrap());
        }
        all.join("|")
    }

    #[test]
    fn lines_end_with_a_line_feed_a_carriage_return_or_both() {
        assert_eq!(split("v 1 2\nf\t3\r\n\r\r\n\n g\x0bx # c\rf 4#d\r#e\n  \nl"), "v 1 2|f 3|g x|f 4|l");
        assert_eq!(split(" \n\r# only\n"), "");
    }

    #[test]
    fn a_backslash_continues_a_statement_unless_a_keyword_follows() {
        for end in ["\n", "\r", "\r\n", " \t\n"] {
            assert_eq!(split(&format!("f 1 \\{end}2\\{end} 3 \\{end}4\nf 5")), "f 1 2 3 4|f 5", "{end:?}");
            assert_eq!(split(&format!("usemtl a\\{end}f 1 2 3")), "usemtl a|f 1 2 3", "{end:?}");
        }
        assert_eq!(split("usemtl a\\\nf\\\n 1 2 \\ # c\n3"), "usemtl a|f 1 2|3");
        assert_eq!(split("v 1 \\\n\nv 2"), "v 1|v 2");
        assert_eq!(split("g a \\\nb\nf 1 # c \\\nf 2 \\"), "g a b|f 1|f 2");
        assert_eq!(split("f 1 \\ 2"), "f 1 \\ 2");
    }

    #[test]
    fn positions_count_lines_and_characters() {
        let text = "a\r\nb\rä c\n\nd".as_bytes();
        let at = |byte: u8| {
            let offset = text.iter().position(|&other| other == byte).unwrap();
            let Position { line, column } = position(text, &text[offset..]);
            (line, column)
        };
        assert_eq!([b'a', b'b', b'c', b'd'].map(at), [(1, 1), (2, 1), (3, 3), (5, 1)]);
        assert_eq!(position(text, &text[text.len()..]), Position { line: 5, column: 2 });
    }

    #[test]
    fn a_file_that_is_named_again_is_listed_once() {
        let names = |kind, text: &str| files_in(kind, text.as_bytes()).len();
        assert_eq!(names("mesh", "mtllib a.mtl\nmtllib b.mtl\nmtllib a.mtl\n"), 2);
        assert_eq!(names(LIBRARY, "map_Kd a.png\nbump a.png\nmap_Kd\n"), 1);
    }
}
