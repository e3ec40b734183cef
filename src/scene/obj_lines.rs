//! Splits an OBJ text into statements and their words.
//!
//! Lines end with a line feed, a carriage return, or both. A statement is a line without its comment. A backslash at
//! the end of a line, also before blanks, continues the statement on the next line, unless that starts with a keyword
//! of its own: the backslash behind `usemtl wood\` belongs to the name.

use super::Position;

/// A keyword of OBJ ("Advanced Visualizer Manual", appendix B, Wavefront 1995), by what is done with its statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keyword {
    /// A vertex.
    Vertex,
    /// A polygon. `fo` is its old name.
    Face,
    /// A texture coordinate.
    Texture,
    /// A curved surface or a patch, which is left out.
    Surface,
    /// Points, lines and curves, which have no area.
    Line,
    /// Whatever else does not change what a mesh covers.
    Other,
}

const OTHERS: &str = "vn g s o usemtl mtllib vp cstype deg bmat step parm trim hole scrv sp end con mg bevel c_interp \
                      d_interp lod usemap maplib shadow_obj trace_obj ctech stech res t vw";

/// Keywords for which others may have been meant.
pub const COMMON: [&str; 10] = ["v", "f", "vt", "vn", "g", "o", "s", "usemtl", "mtllib", "l"];

impl Keyword {
    /// The keyword that this word is.
    pub fn of(word: &[u8]) -> Option<Self> {
        match word {
            b"v" => Some(Self::Vertex),
            b"f" | b"fo" => Some(Self::Face),
            b"vt" => Some(Self::Texture),
            b"surf" | b"bsp" | b"bzp" | b"cdc" | b"cdp" => Some(Self::Surface),
            b"p" | b"l" | b"curv" | b"curv2" => Some(Self::Line),
            _ => OTHERS.split(' ').any(|other| other.as_bytes() == word).then_some(Self::Other),
        }
    }
}

/// A statement: its words, and where it stands.
#[derive(Clone, Copy, Debug)]
pub struct Statement<'a> {
    /// From its first character to its last, without a comment. It may be of several lines.
    pub content: &'a [u8],
    /// What follows on its last line: nothing, or a comment.
    pub comment: &'a [u8],
}

impl<'a> Statement<'a> {
    /// The words.
    pub fn words(self) -> impl Iterator<Item = &'a [u8]> {
        let is_break = |byte: &u8| is_blank(byte) || is_line_end(byte);
        let mut rest = self.content;
        std::iter::from_fn(move || {
            loop {
                let start = rest.iter().position(|byte| !is_break(byte))?;
                let length = rest[start..].iter().position(is_break).unwrap_or(rest.len() - start);
                let (word, after) = rest[start..].split_at(length);
                rest = after;
                match word.strip_suffix(b"\\").filter(|_| is_at_line_end(after)) {
                    None => return Some(word),
                    Some([]) => {}
                    Some(word) => return Some(word),
                }
            }
        })
    }
}

/// The statements of a text that are not empty, in its order.
pub fn statements(mut rest: &[u8]) -> impl Iterator<Item = Statement<'_>> {
    let next = move || {
        let start = rest.iter().position(|byte| !is_blank(byte) && !is_line_end(byte))?;
        let text = &rest[start..];
        let mut line = 0;
        loop {
            let is_end = |byte: &u8| is_line_end(byte) || *byte == b'#';
            let end = line + text[line..].iter().position(is_end).unwrap_or(text.len() - line);
            let (content, after) = text.split_at(end);
            let comment = line_of(after);
            rest = after_line_end(&after[comment.len()..]);
            let goes_on = comment.is_empty()
                && content[line..].trim_ascii_end().ends_with(b"\\")
                && !rest.is_empty()
                && !starts_with_keyword(rest);
            if !goes_on {
                return Some(Statement { content, comment });
            }
            line = text.len() - rest.len();
        }
    };
    std::iter::from_fn(next).filter(|statement| !statement.content.is_empty())
}

fn is_blank(byte: &u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c')
}

fn is_line_end(byte: &u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

/// Whether only blanks stand before the end of the line.
fn is_at_line_end(text: &[u8]) -> bool {
    text.iter().find(|byte| !is_blank(byte)).is_none_or(is_line_end)
}

/// A text up to the end of its first line.
fn line_of(text: &[u8]) -> &[u8] {
    &text[..text.iter().position(is_line_end).unwrap_or(text.len())]
}

/// The text after the line end that it starts with.
fn after_line_end(text: &[u8]) -> &[u8] {
    text.strip_prefix(b"\r\n").unwrap_or(text.get(1..).unwrap_or_default())
}

fn starts_with_keyword(text: &[u8]) -> bool {
    let line = Statement { content: line_of(text), comment: b"" };
    line.words().next().is_some_and(|word| Keyword::of(word).is_some())
}

/// The position of a byte of a text.
pub fn position(text: &[u8], offset: usize) -> Position {
    let before = String::from_utf8_lossy(&text[..offset]).replace("\r\n", "\n");
    let start = before.rfind(['\n', '\r']).map_or(0, |end| end + 1);
    let [lines, characters] =
        [before[..start].matches(['\n', '\r']).count(), before[start..].chars().count()];
    Position { line: lines as u32 + 1, column: characters as u32 + 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of all statements, with `|` between statements.
    fn split(text: &str) -> String {
        let all = statements(text.as_bytes()).map(|statement| {
            let words: Vec<_> = statement.words().map(String::from_utf8_lossy).collect();
            words.join(" ")
        });
        all.collect::<Vec<_>>().join("|")
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
        assert_eq!(split("v 1 \\\n\nv 2"), "v 1|v 2");
        assert_eq!(split("g a \\\nb\nf 1 # c \\\nf 2 \\"), "g a b|f 1|f 2");
        assert_eq!(split("f 1 \\ 2"), "f 1 \\ 2");
    }

    #[test]
    fn positions_count_lines_and_characters() {
        let text = "a\r\nb\rä c\n\nd".as_bytes();
        let at = |byte: u8| {
            let offset = text.iter().position(|&other| other == byte).unwrap();
            let Position { line, column } = position(text, offset);
            (line, column)
        };
        assert_eq!([b'a', b'b', b'c', b'd'].map(at), [(1, 1), (2, 1), (3, 3), (5, 1)]);
        assert_eq!(position(text, text.len()), Position { line: 5, column: 2 });
    }
}
