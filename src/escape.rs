//! Text from outside, made fit to be shown on a terminal.

use std::ffi::OsStr;

/// The most characters of a quoted word that are shown.
const LONGEST: usize = 200;

/// `text` with every character that does not print, or that a terminal obeys, written as an escape. So the result
/// is one line, and no control or bidirectional character reaches the terminal.
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

/// A word between backticks, escaped, and cut where it is long. Bytes that are not text become U+FFFD.
pub fn quoted(word: impl AsRef<OsStr>) -> String {
    let word = word.as_ref().to_string_lossy();
    let shown: String = word.chars().take(LONGEST).collect();
    let cut = if shown.len() < word.len() { "..." } else { "" };
    format!("`{}{cut}`", escape(&shown))
}

/// Whether `character` prints as itself: what the standard library would escape does not, apart
/// from the quotes and the backslash.
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
        assert_eq!(quoted("x".repeat(1000)), format!("`{}...`", "x".repeat(LONGEST)));
    }
}
