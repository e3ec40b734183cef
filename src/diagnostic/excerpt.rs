//! Excerpts for error messages: a line of a text with a caret under one of its characters.

use super::Position;
use crate::base::escape::prints;

/// The largest number of characters of a line that are shown.
const MAX_SHOWN: usize = 100;

/// The line of `text` at `at`, with its number, and a second line with a caret. There is no final line end.
///
/// Every character takes one column, so that the caret is aligned: a tab becomes a blank, and an unprintable
/// character becomes the replacement character. Of a long line only the part around the caret is shown.
pub fn with_caret(text: &str, at: Position) -> String {
    let (line, caret) = clipped(line_of(text, at.line), at.column as usize);
    let number = at.line.to_string();
    let width = number.len().max(5);
    format!("{number:>width$} | {line}\n{:>width$} | {:caret$}^", "", "")
}

/// Line `number` of `text`, counted from 1, without its end.
fn line_of(text: &str, number: u32) -> &str {
    let mut rest = text;
    for _ in 1..number {
        rest = after_line_end(rest);
    }
    rest.split(['\n', '\r']).next().unwrap_or_default()
}

/// The text after the first line end of `text`. The two characters `\r\n` are one line end.
fn after_line_end(text: &str) -> &str {
    let Some(end) = text.find(['\n', '\r']) else { return "" };
    let from_end = &text[end..];
    from_end.strip_prefix("\r\n").unwrap_or(&from_end[1..])
}

/// The printable part of `line` around `column`, and the number of columns to the left of the caret.
fn clipped(line: &str, column: usize) -> (String, usize) {
    let length = line.chars().count();
    let caret = column.saturating_sub(1).min(length);
    let start =
        if length <= MAX_SHOWN { 0 } else { caret.saturating_sub(MAX_SHOWN / 2).min(length - MAX_SHOWN) };
    let before = if start > 0 { "..." } else { "" };
    let after = if start + MAX_SHOWN < length { "..." } else { "" };
    let shown: String = line.chars().skip(start).take(MAX_SHOWN).map(one_column).collect();
    (
        format!("{before}{}{after}", if after.is_empty() { shown.trim_end() } else { &shown }),
        before.len() + caret - start,
    )
}

/// The character that replaces `character` in an excerpt and takes exactly one column.
fn one_column(character: char) -> char {
    match character {
        '\t' => ' ',
        _ if prints(character) => character,
        _ => char::REPLACEMENT_CHARACTER,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The excerpt's first line, and the character above the caret.
    fn show(text: &str, line: u32, column: u32) -> (String, Option<char>) {
        let rendered = with_caret(text, Position { line, column });
        let (top, bottom) = rendered.split_once('\n').unwrap();
        (top.to_owned(), top.chars().nth(bottom.chars().count() - 1))
    }

    #[test]
    fn the_caret_stands_under_its_character() {
        assert_eq!(show("one\ntwo three", 2, 5), ("    2 | two three".into(), Some('t')));
        assert_eq!(show("one\r\ntwo\r\n", 2, 2), ("    2 | two".into(), Some('w')));
        assert_eq!(show("one\rtwo", 2, 3).1, Some('o'));
        assert_eq!(show("\t\tx", 1, 3), ("    1 |   x".into(), Some('x')));
        assert_eq!(show("ä\u{7}\u{202e}x", 1, 4), ("    1 | ä\u{fffd}\u{fffd}x".into(), Some('x')));
    }

    #[test]
    fn a_long_line_is_clipped_around_the_caret() {
        let line = format!("{}X{}", "a".repeat(5_000), "b".repeat(5_000));
        let (shown, above) = show(&line, 1, 5_001);
        assert_eq!(above, Some('X'));
        assert!(shown.len() < 120 && shown.ends_with("b...") && shown.contains("| ...a"));
        assert_eq!(show(&line, 1, 1).1, Some('a'));
        assert!(show(&line, 1, 10_001).0.ends_with('b'));
    }

    #[test]
    fn positions_outside_the_text_do_not_panic() {
        for (line, column) in [(0, 0), (1, 99), (99, 1), (1_000, u32::MAX)] {
            show("short\n", line, column);
        }
        show("", 1, 1);
    }

    #[test]
    fn wide_line_numbers_keep_the_caret_in_place() {
        let text = "\n".repeat(1_234_566) + "ab";
        assert_eq!(show(&text, 1_234_567, 2), ("1234567 | ab".into(), Some('b')));
    }

    #[test]
    fn the_end_of_a_long_line_is_shown_in_full() {
        let line = (0..3 * MAX_SHOWN).map(|i| (b'a' + (i % 26) as u8) as char).collect::<String>();
        let (shown, above) = show(&line, 1, 3 * MAX_SHOWN as u32);
        assert_eq!(shown, format!("    1 | ...{}", &line[2 * MAX_SHOWN..]));
        assert_eq!(above, line.chars().last());
        assert_eq!(show(&line[..MAX_SHOWN], 1, 1).0, format!("    1 | {}", &line[..MAX_SHOWN]));
    }
}
