//! Goes on after an error, so that a run reports all independent errors of a scene and none that only follow
//! from another.

use super::error::SceneError;
use super::lexer::Lexer;
use super::reader::{Parsed, Reader};
use super::warning::SceneWarning;

/// The largest number of errors that are reported at once.
pub const MAX_ERRORS: usize = 10;

/// What is wrong or doubtful in the text that has been read.
#[derive(Default)]
pub struct Findings {
    /// At most [`MAX_ERRORS`], in the order in which they were found.
    pub errors: Vec<SceneError>,
    pub warnings: Vec<SceneWarning>,
    /// Whether every brace of the text has its partner, once somebody asked.
    is_balanced: Option<bool>,
}

impl Reader<'_> {
    /// Records an error, unless it is known.
    pub fn report(&mut self, error: SceneError) {
        let errors = &mut self.findings.errors;
        if errors.len() < MAX_ERRORS && !errors.contains(&error) {
            errors.push(error);
        }
    }

    /// Records an error inside an item of a list, and skips the item. `outer` is the number of open braces
    /// before it. The error is returned if nobody can tell where the item ends.
    pub fn recover(&mut self, error: SceneError, outer: usize) -> Parsed<()> {
        self.report(error.clone());
        if self.is_balanced() && self.skip_item(outer) { Ok(()) } else { Err(error) }
    }

    /// Whether every brace has its partner. Only then the depth tells where a block ends.
    pub fn is_balanced(&mut self) -> bool {
        *self.findings.is_balanced.get_or_insert_with(|| has_balanced_braces(self.text))
    }

    /// Skips an item, of which any part may have been read. False if the next words are no item.
    pub fn skip_item(&mut self, outer: usize) -> bool {
        if self.depth == outer {
            let is_word = !self.peek().is_end() && !self.is_at("{") && !self.is_at("}");
            if !is_word {
                return false;
            }
            self.take();
            if !self.is_at("{") {
                return false;
            }
            self.take();
        }
        self.skip_to_depth(outer);
        true
    }

    /// Skips words until no more than `depth` braces are open.
    pub fn skip_to_depth(&mut self, depth: usize) {
        while self.depth > depth && !self.peek().is_end() {
            self.take();
        }
    }
}

fn has_balanced_braces(text: &str) -> bool {
    let mut lexer = Lexer::new(text);
    let mut open = 0_usize;
    loop {
        match lexer.next_word() {
            word if word.is_end() => return open == 0,
            word if word.text == "{" => open += 1,
            word if word.text == "}" => match open.checked_sub(1) {
                Some(fewer) => open = fewer,
                None => return false,
            },
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn braces_are_balanced_if_each_has_its_partner() {
        for (text, expected) in [
            ("a { b { } } c { }", true),
            ("", true),
            ("{", false),
            ("}", false),
            ("} {", false),
            ("# }", true),
        ] {
            assert_eq!(Reader::new(text).is_balanced(), expected, "{text}");
        }
    }

    #[test]
    fn an_item_is_skipped_from_anywhere_in_it() {
        for taken in 0..7 {
            let mut reader = Reader::new("Sphere { a { b } } next");
            for _ in 0..taken {
                reader.take();
            }
            // Once the keyword is taken the brace after it is no longer an item.
            assert_eq!(
                (reader.skip_item(0), reader.peek().text),
                (taken != 1, if taken == 1 { "{" } else { "next" })
            );
        }
    }
}
