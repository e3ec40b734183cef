//! Escapes text from files and arguments, so that it is safe to print on a terminal.

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
    let word = word.as_ref().to_string_lossy();
    let shown: String = word.chars().take(MAX_QUOTED).collect();
    let ellipsis = if shown.len() < word.len() { "..." } else { "" };
    format!("`{}{ellipsis}`", escape(&shown))
}

/// Whether `character` is printed unchanged. These are the characters that the standard library does not
/// escape, and the quotes and the backslash.
pub fn prints(character: char) -> bool {
    matches!(character, '\'' | '"' | '\\') || character.escape_debug().count() == 1
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
}
