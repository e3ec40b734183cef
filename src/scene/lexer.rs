//! Splits scene text into words with their positions, and compares them with keywords.
//!
//! A word is a run of characters without white space. A brace is always a word of its own, so `Sphere{` is two words.
//! `#` and `//` start a comment that ends with the line, but only where a word could start. Inside a word they are
//! ordinary characters, so file names such as `parts//cube.obj` and `cube#2.obj` work. Lines end with a line feed, a
//! carriage return, or both.

use crate::base::escape::quoted;
use crate::diagnostic::Position;

/// A word of the scene text. Its text is empty only at the end of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word<'a> {
    pub text: &'a str,
    pub at: Position,
}

impl Word<'_> {
    pub fn is_end(&self) -> bool {
        self.text.is_empty()
    }

    /// Returns the word quoted for messages.
    pub fn quoted(&self) -> String {
        if self.is_end() { "the end of the file".to_owned() } else { quoted(self.text) }
    }
}

/// Splits a text into words, in time linear in its length.
pub struct Lexer<'a> {
    rest: &'a str,
    at: Position,
    /// The position after the last word. Errors at the end of the text are reported here, so that the displayed line is
    /// not empty.
    after_last_word: Position,
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a str) -> Self {
        let start = Position { line: 1, column: 1 };
        Self { rest: text, at: start, after_last_word: start }
    }

    /// Returns the next word. At the end of the text, every call returns an empty word.
    pub fn next_word(&mut self) -> Word<'a> {
        self.skip_blanks_and_comments();
        let at = self.at;
        let text = self.advance(word_length(self.rest));
        if text.is_empty() {
            return Word { text, at: self.after_last_word };
        }
        self.after_last_word = self.at;
        Word { text, at }
    }

    /// Returns the position of the first `character` outside comments.
    pub fn first(mut self, character: char) -> Option<Position> {
        loop {
            let Word { text, at } = self.next_word();
            if let Some(start) = text.find(character) {
                let before = text[..start].chars().count() as u32;
                return Some(Position { column: at.column.saturating_add(before), ..at });
            }
            if text.is_empty() {
                return None;
            }
        }
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            self.advance(self.rest.len() - self.rest.trim_start().len());
            if !self.rest.starts_with('#') && !self.rest.starts_with("//") {
                return;
            }
            self.advance(self.rest.find(['\n', '\r']).unwrap_or(self.rest.len()));
        }
    }

    /// Advances by `bytes` bytes and returns them as text.
    fn advance(&mut self, bytes: usize) -> &'a str {
        let (passed, rest) = self.rest.split_at(bytes);
        let mut characters = passed.chars().peekable();
        while let Some(character) = characters.next() {
            let ends_line = character == '\n' || character == '\r' && characters.peek() != Some(&'\n');
            if ends_line {
                self.at = Position { line: self.at.line.saturating_add(1), column: 1 };
            } else {
                self.at.column = self.at.column.saturating_add(1);
            }
        }
        self.rest = rest;
        passed
    }
}

/// Returns the length in bytes of the first word of `text`, which must not start with white space.
fn word_length(text: &str) -> usize {
    if text.starts_with(['{', '}']) {
        return 1;
    }
    text.find(|character: char| character.is_whitespace() || matches!(character, '{' | '}'))
        .unwrap_or(text.len())
}

/// Returns true if `word` is `keyword`. Field names may also be written with underscores, as on the grammar page of
/// 2003 (`num_objects` for `numObjects`).
pub fn is_keyword(word: &str, keyword: &str) -> bool {
    word == keyword
        || (keyword.starts_with(|first: char| first.is_ascii_lowercase()) && is_snake_case(word, keyword))
}

fn is_snake_case(word: &str, keyword: &str) -> bool {
    let expected = keyword.chars().flat_map(|character| {
        let separator = character.is_ascii_uppercase().then_some('_');
        separator.into_iter().chain([character.to_ascii_lowercase()])
    });
    word.chars().eq(expected)
}

/// Returns the keyword that the author of `word` most likely meant: the one with the smallest edit distance, if at most
/// a third of the characters differ.
pub fn nearest<'k>(word: &str, keywords: &[&'k str]) -> Option<&'k str> {
    // All keywords are shorter. The limit bounds the time for hostile input.
    const MAX_LENGTH: usize = 40;
    if !word.starts_with(char::is_alphabetic) || word.len() > MAX_LENGTH {
        return None;
    }
    let plain = simplified(word);
    let max_distance = ((plain.chars().count() + 1) / 3).max(1);
    keywords
        .iter()
        .map(|&keyword| (strsim::levenshtein(&plain, &simplified(keyword)), keyword))
        .filter(|&(distance, _)| distance <= max_distance)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, keyword)| keyword)
}

/// Returns the word without the most common confusions: case and underscores.
fn simplified(word: &str) -> String {
    word.chars().filter(|&character| character != '_').flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<(&str, u32, u32)> {
        let mut lexer = Lexer::new(text);
        std::iter::from_fn(|| Some(lexer.next_word()).filter(|word| !word.is_end()))
            .map(|word| (word.text, word.at.line, word.at.column))
            .collect()
    }

    #[test]
    fn braces_are_words_even_when_they_touch_others() {
        assert_eq!(words("a{b}}"), [("a", 1, 1), ("{", 1, 2), ("b", 1, 3), ("}", 1, 4), ("}", 1, 5)]);
    }

    #[test]
    fn comments_run_to_the_end_of_the_line() {
        assert_eq!(
            words("# x\na // y {\n//\nb{// z\n}#"),
            [("a", 2, 1), ("b", 4, 1), ("{", 4, 2), ("}", 5, 1)]
        );
    }

    #[test]
    fn comment_marks_inside_a_word_belong_to_it() {
        assert_eq!(words("a//b c#d /e"), [("a//b", 1, 1), ("c#d", 1, 6), ("/e", 1, 10)]);
    }

    #[test]
    fn every_kind_of_line_end_counts_once() {
        let expected = [("a", 1, 1), ("b", 2, 1), ("c", 4, 1)];
        for text in ["a\nb\n\nc", "a\r\nb\r\n\r\nc", "a\rb\r\rc", "a #\rb //\r\rc"] {
            assert_eq!(words(text), expected, "{text:?}");
        }
    }

    #[test]
    fn columns_count_characters_not_bytes() {
        assert_eq!(words("äöü x"), [("äöü", 1, 1), ("x", 1, 5)]);
    }

    #[test]
    fn fields_may_be_spelt_with_underscores() {
        assert!(is_keyword("numObjects", "numObjects"));
        assert!(is_keyword("num_objects", "numObjects"));
        assert!(is_keyword("index_of_refraction", "indexOfRefraction"));
        assert!(is_keyword("obj_file", "obj_file"));
        assert!(!is_keyword("num_Objects", "numObjects"));
        assert!(!is_keyword("numobjects", "numObjects"));
        assert!(!is_keyword("material_index", "MaterialIndex"));
    }

    #[test]
    fn a_word_too_long_or_without_a_letter_has_no_nearest_keyword() {
        let long = "a".repeat(40);
        assert_eq!(nearest(&long, &[&long]), Some(long.as_str()));
        let longer = "a".repeat(41);
        assert_eq!((nearest(&longer, &[&longer]), nearest("1", &["1"])), (None, None));
    }

    #[test]
    fn a_third_of_a_word_may_be_wrong() {
        assert_eq!((nearest("xy", &["xz"]), nearest("xy", &["wz"])), (Some("xz"), None));
        assert_eq!(nearest("abcde", &["abcxy"]), Some("abcxy"));
        assert_eq!(nearest("abcdef", &["abcxyz"]), None);
    }
}
