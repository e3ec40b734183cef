//! Escapes text from files and arguments, so that it is safe on a terminal, in a page and in a table.

use std::ffi::OsStr;
use std::fmt::{self, Write};

/// The number of characters after which a quoted word is truncated.
const MAX_QUOTED: usize = 200;

/// `text` with every unprintable character, and every control character of a terminal, written as an escape
/// sequence. So the result is one line, and no control or bidirectional character reaches the terminal.
pub fn escape(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if prints(character) {
            shown.push(character);
        } else {
            shown.extend(character.escape_debug());
        }
    }
    shown
}

/// A word like [`truncated`], between backticks. Bytes that are not UTF-8 become U+FFFD.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    format!("`{}`", truncated(word))
}

/// A word, escaped, and truncated if it is long.
pub fn truncated(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    let shown: String = word.chars().take(MAX_QUOTED).collect();
    let ellipsis = if shown.len() < word.len() { "..." } else { "" };
    escape(&shown) + ellipsis
}

/// Returns true if `character` is printed unchanged: the standard library does not escape it, or it is a quote or the
/// backslash.
pub fn prints(character: char) -> bool {
    matches!(character, '\'' | '"' | '\\') || character.escape_debug().count() == 1
}

/// Escapes text for HTML, also between quotes. Templates apply it to every value that they show. Control characters,
/// and characters that change the direction of writing, become escape sequences.
#[derive(Clone, Copy, Debug)]
pub struct Html;

impl askama::filters::Escaper for Html {
    fn write_escaped_str<W: Write>(&self, mut page: W, text: &str) -> fmt::Result {
        for character in escape(text).chars() {
            match character {
                '&' => page.write_str("&amp;")?,
                '<' => page.write_str("&lt;")?,
                '>' => page.write_str("&gt;")?,
                '"' => page.write_str("&quot;")?,
                '\'' => page.write_str("&#39;")?,
                other => page.write_char(other)?,
            }
        }
        Ok(())
    }
}

/// A field of comma-separated values: the text between quotes (RFC 4180). An apostrophe comes before text that a
/// spreadsheet would take for a formula.
pub fn csv_field(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    let apostrophe = if is_formula { "'" } else { "" };
    format!("\"{apostrophe}{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use askama::filters::Escaper;

    #[test]
    fn escaped_text_cannot_steer_a_terminal() {
        assert_eq!(escape("a\\'\"é\u{1b}\u{202e}\n"), "a\\'\"é\\u{1b}\\u{202e}\\n");
    }

    #[test]
    fn a_quoted_word_is_short_and_one_line() {
        assert_eq!(quoted("a\u{202e}b.tga"), "`a\\u{202e}b.tga`");
        assert_eq!(quoted("x".repeat(1000)), format!("`{}...`", "x".repeat(MAX_QUOTED)));
    }

    #[test]
    fn text_is_nothing_but_text_in_a_page() {
        let mut page = String::new();
        Html.write_escaped_str(&mut page, "<a b=\"'&\u{202e}").unwrap();
        assert_eq!(page, "&lt;a b=&quot;&#39;&amp;\\u{202e}");
    }

    #[test]
    fn fields_neither_end_nor_compute() {
        for (text, expected) in [
            ("anna", "\"anna\""),
            ("a,\"b\"\n", "\"a,\"\"b\"\"\n\""),
            ("=1+1", "\"'=1+1\""),
            ("-a", "\"'-a\""),
            ("@a", "\"'@a\""),
            ("a=1", "\"a=1\""),
        ] {
            assert_eq!(csv_field(text), expected);
        }
    }
}
