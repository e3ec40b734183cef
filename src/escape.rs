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

/// A word as the shells of this system read it: those of POSIX, or cmd.exe and PowerShell.
pub fn shell_word<W: AsRef<OsStr>>(word: W) -> String {
    if cfg!(windows) { windows_word(&word.as_ref().to_string_lossy()) } else { posix_word(word.as_ref()) }
}

/// A word between single quotes if it has other characters than those of plain names, and with escape sequences between
/// `$'` and `'` if it has bytes that do not print, which the plainest shells do not read.
fn posix_word(word: &OsStr) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:=@%,".contains(c);
    match word.to_str() {
        // zsh takes what follows a first `=` for the name of a program.
        Some(word) if !word.is_empty() && word.chars().all(is_plain) && !word.starts_with('=') => {
            word.to_owned()
        }
        Some(word) if word.chars().all(prints) => format!("'{}'", word.replace('\'', "'\\''")),
        _ => format!(
            "$'{}'",
            word.as_encoded_bytes().iter().map(|&byte| escaped_byte(byte)).collect::<String>()
        ),
    }
}

/// A word that cmd.exe and PowerShell read alike: between double quotes if it has other characters than those of plain
/// names. What PowerShell replaces between them stands between single quotes, which cmd.exe does not know. Neither can
/// be told characters that do not print: those are escaped as in a message.
fn windows_word(word: &str) -> String {
    /// Those that end a text between double quotes in PowerShell, or are replaced in it.
    const REPLACED: [char; 5] = ['$', '`', '\u{201c}', '\u{201d}', '\u{201e}'];
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/\\._-+:=".contains(c);
    // PowerShell takes `-a.b` for two words, unless it is a number.
    let is_split = word.starts_with('-') && word.contains(['.', ':']) && word.parse::<f64>().is_err();
    let shown = escape(word);
    if !word.is_empty() && word.chars().all(is_plain) && !is_split {
        shown
    } else if word.contains(REPLACED) {
        let doubled = shown.chars().flat_map(|c| {
            let is_quote = matches!(c, '\'' | '\u{2018}'..='\u{201b}');
            std::iter::repeat_n(c, if is_quote { 2 } else { 1 })
        });
        format!("'{}'", doubled.collect::<String>())
    } else {
        // A backslash before the closing quote would make it one of the word.
        let backslashes = shown.len() - shown.trim_end_matches('\\').len();
        format!("\"{shown}{}\"", "\\".repeat(backslashes))
    }
}

fn escaped_byte(byte: u8) -> String {
    match byte {
        b'\'' | b'\\' => format!("\\{}", byte as char),
        b' '..=b'~' => (byte as char).to_string(),
        _ => format!("\\x{byte:02x}"),
    }
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

    #[test]
    fn a_shell_reads_one_word() {
        for (word, expected) in [
            ("a/b-1.txt", "a/b-1.txt"),
            ("a b", "'a b'"),
            ("it's", "'it'\\''s'"),
            ("$(x)", "'$(x)'"),
            ("", "''"),
            ("=a", "'=a'"),
            ("C:\\a", "'C:\\a'"),
        ] {
            assert_eq!(posix_word(word.as_ref()), expected);
        }
    }

    #[test]
    fn both_shells_of_windows_read_one_word() {
        for (word, expected) in [
            ("C:\\a/b-1.txt", "C:\\a/b-1.txt"),
            ("-size", "-size"),
            ("-.5e-3", "-.5e-3"),
            ("-a.tga", "\"-a.tga\""),
            ("a b", "\"a b\""),
            ("a & b", "\"a & b\""),
            ("it's", "\"it's\""),
            ("a,b;(c)", "\"a,b;(c)\""),
            ("a b\\", "\"a b\\\\\""),
            ("", "\"\""),
            ("$x's", "'$x''s'"),
            ("`\u{2019}", "'`\u{2019}\u{2019}'"),
            ("a\u{202e}b", "\"a\\u{202e}b\""),
            ("\u{e9}.tga", "\"\u{e9}.tga\""),
        ] {
            assert_eq!(windows_word(word), expected);
        }
        assert_eq!(shell_word("a b"), if cfg!(windows) { "\"a b\"" } else { "'a b'" });
    }
}
