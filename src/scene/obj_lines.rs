//! Filters the lines of an OBJ text: only vertex positions and faces are passed to the parser.

use crate::memory::{NoMemory, with_room};
use std::cell::Cell;
use std::io::{BufRead, Read};

/// A byte stream that consists of the vertex and face lines of an OBJ text.
pub struct RelevantLines<'a> {
    /// The text after the current line.
    rest: &'a [u8],
    /// The part of the current line that has not been consumed, without its line end.
    current: &'a [u8],
    /// Whether the line end of the current line has not been consumed.
    owes_newline: bool,
    /// The number of the current line, in a cell so that the caller can read it while the parser holds the
    /// stream.
    line: &'a Cell<usize>,
    /// The line of the first face of one or two vertices. The parser would ignore it, so the stream ends
    /// there.
    pub few_corners: Option<usize>,
}

impl<'a> RelevantLines<'a> {
    pub fn new(text: &'a [u8], line: &'a Cell<usize>) -> Self {
        Self { rest: text, current: b"", owes_newline: false, line, few_corners: None }
    }

    /// Advances to the next relevant line, or to the end.
    fn next_line(&mut self) {
        while !self.rest.is_empty() {
            let end = self.rest.iter().position(is_newline).unwrap_or(self.rest.len());
            let (line, behind) = self.rest.split_at(end);
            self.rest = behind.get(1..).unwrap_or_default();
            self.line.set(self.line.get() + 1);
            if let Some(relevant) = self.relevant_part(without_comment(line)) {
                self.current = relevant;
                self.owes_newline = true;
                return;
            }
        }
    }

    /// The part of a line that is passed to the parser; none for an irrelevant line.
    fn relevant_part(&mut self, line: &'a [u8]) -> Option<&'a [u8]> {
        match keyword(line) {
            b"v" => Some(without_colour(line)),
            b"f" if words(line).nth(3).is_none() => {
                self.few_corners = Some(self.line.get());
                self.rest = b"";
                None
            }
            b"f" => Some(line),
            _ => None,
        }
    }
}

/// A vertex line without the colour that some programs write after the position. The parser requires a colour
/// for every vertex or for none.
fn without_colour(line: &[u8]) -> &[u8] {
    const WITH_COLOUR: usize = 1 + 3 + 3;
    if words(line).count() != WITH_COLOUR {
        return line;
    }
    let position = words(line).nth(3).unwrap_or_default();
    // A word is a slice of its line, so the distance between their ends is the length of what follows the
    // word.
    let after = line.as_ptr_range().end as usize - position.as_ptr_range().end as usize;
    &line[..line.len() - after]
}

impl Read for RelevantLines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let available = self.fill_buf()?;
        let length = available.len().min(buffer.len());
        buffer[..length].copy_from_slice(&available[..length]);
        self.consume(length);
        Ok(length)
    }
}

impl BufRead for RelevantLines<'_> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.current.is_empty() && !self.owes_newline {
            self.next_line();
        }
        Ok(if self.current.is_empty() && self.owes_newline { b"\n" } else { self.current })
    }

    fn consume(&mut self, amount: usize) {
        if self.current.is_empty() {
            self.owes_newline &= amount == 0;
        } else {
            self.current = self.current.get(amount..).unwrap_or_default();
        }
    }
}

/// A text in which no line is continued by a backslash at its end; none if that is so already.
///
/// The parts of a continued line become one line, with empty lines after it, so that every other line keeps its
/// number. A comment is not continued: its last word may well be the name of a folder.
pub fn with_continued_lines(text: &[u8]) -> Result<Option<Vec<u8>>, NoMemory> {
    if !text.split(is_newline).any(|line| unfinished(line).is_some()) {
        return Ok(None);
    }
    let mut joined = with_room(text.len() + 1)?;
    let mut owed = 0;
    for line in text.split(is_newline) {
        if let Some(part) = unfinished(line) {
            joined.extend_from_slice(part);
            joined.push(b' ');
            owed += 1;
        } else {
            joined.extend_from_slice(line);
            joined.extend(std::iter::repeat_n(b'\n', owed + 1));
            owed = 0;
        }
    }
    Ok(Some(joined))
}

/// A line that is continued on the next one, without its backslash.
fn unfinished(line: &[u8]) -> Option<&[u8]> {
    let part = line.strip_suffix(b"\r").unwrap_or(line).strip_suffix(b"\\")?;
    (!part.contains(&b'#')).then_some(part)
}

/// Whether a byte ends a line.
pub fn is_newline(byte: &u8) -> bool {
    *byte == b'\n'
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The first word of a line, which tells its kind; empty for a blank line.
pub fn keyword(line: &[u8]) -> &[u8] {
    words(line).next().unwrap_or_default()
}

/// A line up to its comment.
pub fn without_comment(line: &[u8]) -> &[u8] {
    line.split(|&byte| byte == b'#').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relevant_lines_are_the_same_read_by_bytes_and_by_lines() {
        let text = b"# c\nv 1 2 3 # d\nvn 1 2 3\n\nf 1 2 3\nl 1 2\nv 4 5 6 .1 .2 .3";
        let (line, mut bytes) = (Cell::new(0), vec![]);
        RelevantLines::new(text, &line).read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, b"v 1 2 3 \nf 1 2 3\nv 4 5 6\n");
        assert_eq!(line.get(), 7);
        let lines: Vec<_> = RelevantLines::new(text, &line).lines().map(Result::unwrap).collect();
        assert_eq!(lines, ["v 1 2 3 ", "f 1 2 3", "v 4 5 6"]);
    }
}
