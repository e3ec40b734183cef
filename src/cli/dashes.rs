//! Flags have one dash, as in the course. clap's have two.

use std::ffi::{OsStr, OsString};

/// A word of the command line as clap reads it: `-word` as `--word`, a negative number in the form that clap takes for
/// one, and any other word with a dash as the name of a file.
pub(super) fn double(word: &OsStr) -> OsString {
    let with = |start: &str| {
        let mut long = OsString::from(start);
        long.push(word);
        long
    };
    match word.as_encoded_bytes() {
        [b'-', letter, ..] if letter.is_ascii_alphabetic() => with("-"),
        [b'-', second, ..] if *second != b'-' => {
            match word.to_str().map(|text| (text, text.parse::<f64>())) {
                Some((text, Ok(number))) if number.is_finite() && text.contains(['.', 'e', 'E']) => {
                    number.to_string().into()
                }
                Some((_, Ok(_))) => word.to_owned(),
                _ => with("./"),
            }
        }
        _ => word.to_owned(),
    }
}

/// A text of clap with one dash before each flag.
pub(super) fn single(text: &str) -> String {
    let mut parts = text.split("--");
    let mut single = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let starts_word = !single.ends_with(|c: char| c.is_alphanumeric());
        single += if starts_word && part.starts_with(|c: char| c.is_ascii_alphabetic()) { "-" } else { "--" };
        single += part;
    }
    single
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_numbers_and_files_are_told_apart() {
        for (word, doubled) in [
            ("-size", "--size"),
            ("--size", "--size"),
            ("-h", "--h"),
            ("-", "-"),
            ("--", "--"),
            ("-3", "-3"),
            ("-.5", "-0.5"),
            ("-1e-3", "-0.001"),
            ("-3.", "-3"),
            ("-99999999999999999999", "-99999999999999999999"),
            ("-5.tga", "./-5.tga"),
            ("a-b", "a-b"),
        ] {
            assert_eq!(double(OsStr::new(word)), OsStr::new(doubled), "{word}");
        }
    }

    #[test]
    fn only_dashes_before_flags_go() {
        assert_eq!(single("'--size <w>' a--b -- --x"), "'-size <w>' a--b -- -x");
    }
}
