//! Command lines to paste, as the shells of a system read them.

use super::escape::{escape, prints};
use std::ffi::OsStr;

/// The shells of a system. They all read the words that are written here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shell {
    /// The shell of POSIX, bash and zsh.
    Posix,
    /// cmd.exe and PowerShell.
    Windows,
}

impl Shell {
    /// The shells of the system for which the program is built.
    pub const OF_SYSTEM: Self = if cfg!(windows) { Self::Windows } else { Self::Posix };

    /// A word as these shells read it.
    pub fn word<W: AsRef<OsStr>>(self, word: W) -> String {
        match self {
            Self::Posix => posix_word(word.as_ref()),
            Self::Windows => windows_word(&word.as_ref().to_string_lossy()),
        }
    }

    /// The word for a program, which starts a line. cmd.exe ends the name of a program at a slash. PowerShell takes a
    /// word between quotes for a text, unless `&` comes before it, with which no line of cmd.exe may start; a program
    /// whose path has blanks is called as PowerShell does, which starts programs by their whole paths.
    pub fn program(self, program: impl AsRef<OsStr>) -> String {
        let word = match self {
            Self::Posix => return self.word(program),
            Self::Windows => self.word(program.as_ref().to_string_lossy().replace('/', "\\")),
        };
        if word.starts_with(['"', '\'']) { format!("& {word}") } else { word }
    }
}

/// A word as it is if all its characters are plain, with escape sequences between `$'` and `'` if it has bytes that do
/// not print (the simplest shells do not read this form), and otherwise between single quotes.
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

fn escaped_byte(byte: u8) -> String {
    match byte {
        b'\'' | b'\\' => format!("\\{}", byte as char),
        b' '..=b'~' => (byte as char).to_string(),
        _ => format!("\\x{byte:02x}"),
    }
}

/// A word that cmd.exe and PowerShell read alike: as it is if all its characters are plain, and otherwise between
/// double quotes. Three cases have no form that both read. A word with characters that PowerShell replaces between
/// double quotes is put between single quotes, which cmd.exe does not know. cmd.exe replaces `%NAME%` everywhere.
/// Neither has a form for characters that do not print, so they are escaped as in a message.
fn windows_word(word: &str) -> String {
    /// Characters that end a text between double quotes in PowerShell, or are replaced in it.
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

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(Shell::Posix.word(word), expected);
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
            assert_eq!(Shell::Windows.word(word), expected);
        }
    }

    #[test]
    fn a_program_is_called_and_not_printed() {
        for (program, posix, windows) in [
            ("raytracer", "raytracer", "raytracer"),
            ("target/release/raytracer", "target/release/raytracer", "target\\release\\raytracer"),
            ("C:\\rt.exe", "'C:\\rt.exe'", "C:\\rt.exe"),
            ("C:\\Anna B\\rt.exe", "'C:\\Anna B\\rt.exe'", "& \"C:\\Anna B\\rt.exe\""),
            ("/a$b/rt", "'/a$b/rt'", "& '\\a$b\\rt'"),
        ] {
            assert_eq!(Shell::Posix.program(program), posix);
            assert_eq!(Shell::Windows.program(program), windows);
        }
    }
}
