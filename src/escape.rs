//! Escapes text from files and arguments, so that it is safe on a terminal, in a page and in a table.

use std::ffi::OsStr;

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

/// A word between backticks, escaped, and truncated if it is long. Bytes that are not UTF-8 become U+FFFD.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    format!("`{}`", truncated(word))
}

/// The same without backticks.
pub fn truncated(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    let shown: String = word.chars().take(MAX_QUOTED).collect();
    let ellipsis = if shown.len() < word.len() { "..." } else { "" };
    escape(&shown) + ellipsis
}

/// Whether `character` is printed unchanged. These are the characters that the standard library does not
/// escape, and the quotes and the backslash.
pub fn prints(character: char) -> bool {
    matches!(character, '\'' | '"' | '\\') || character.escape_debug().count() == 1
}

/// A text that is nothing but text in HTML, also between quotes. Control characters, and those that change the
/// direction of writing, are written as escape sequences.
pub fn html(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in escape(text).chars() {
        match character {
            '&' => shown += "&amp;",
            '<' => shown += "&lt;",
            '>' => shown += "&gt;",
            '"' => shown += "&quot;",
            '\'' => shown += "&#39;",
            other => shown.push(other),
        }
    }
    shown
}

/// A field of comma-separated values: the text between quotes (RFC 4180). One that a spreadsheet would take for a
/// formula starts with an apostrophe.
pub fn csv_field(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    let apostrophe = if is_formula { "'" } else { "" };
    format!("\"{apostrophe}{}\"", text.replace('"', "\"\""))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        assert_eq!(html("<a b=\"'&\u{202e}"), "&lt;a b=&quot;&#39;&amp;\\u{202e}");
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
