//! The lines of an OBJ text that matter to a mesh of positions and faces.

use std::cell::Cell;
use std::io::{BufRead, Read};

/// The vertex and face lines of an OBJ text, and nothing else, as a source of bytes.
pub struct RelevantLines<'a> {
    /// The text behind the current line.
    rest: &'a [u8],
    /// What is left to hand out of the current line, without its end.
    current: &'a [u8],
    /// Whether the current line's end is still to be handed out.
    owes_newline: bool,
    /// The number of the current line, shared with who looks while the reader holds this.
    line: &'a Cell<usize>,
    /// The first face of one or two vertices. The reader would drop it in silence, so it ends the text here.
    pub few_corners: Option<usize>,
}

impl<'a> RelevantLines<'a> {
    pub fn new(text: &'a [u8], line: &'a Cell<usize>) -> Self {
        Self { rest: text, current: b"", owes_newline: false, line, few_corners: None }
    }

    /// Moves on to the next line that matters, or to the end.
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

    /// What the reader shall see of a line, if anything.
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

/// A vertex line without the colour that some programs write behind the position. The reader
/// wants a colour for every vertex or for none.
fn without_colour(line: &[u8]) -> &[u8] {
    const WITH_COLOUR: usize = 1 + 3 + 3;
    if words(line).count() != WITH_COLOUR {
        return line;
    }
    let position = words(line).nth(3).unwrap_or_default();
    // A word is part of its line, so the distance of their ends is the length behind the word.
    let behind = line.as_ptr_range().end as usize - position.as_ptr_range().end as usize;
    &line[..line.len() - behind]
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

/// Whether a byte ends a line.
pub fn is_newline(byte: &u8) -> bool {
    *byte == b'\n'
}

/// The words of a line.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// The first word of a line, which says what the line is; empty for a blank line.
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
    fn the_lines_that_matter_are_read_alike_by_bytes_and_by_lines() {
        let text = b"# c\nv 1 2 3 # d\nvn 1 2 3\n\nf 1 2 3\nl 1 2\nv 4 5 6 .1 .2 .3";
        let (line, mut bytes) = (Cell::new(0), vec![]);
        RelevantLines::new(text, &line).read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, b"v 1 2 3 \nf 1 2 3\nv 4 5 6\n");
        assert_eq!(line.get(), 7);
        let lines: Vec<_> = RelevantLines::new(text, &line).lines().map(Result::unwrap).collect();
        assert_eq!(lines, ["v 1 2 3 ", "f 1 2 3", "v 4 5 6"]);
    }
}
