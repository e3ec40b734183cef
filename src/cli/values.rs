//! Single values of flags: numbers in a range, and the names of pictures.

use super::error::{CliError, Problem};
use super::flags::Flag;
use super::raw::Raw;
use crate::image_io::Format;
use serde::Serializer;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// Whether a file's name has this ending, in upper or lower case.
pub(super) fn ends_in(word: &OsStr, ending: &str) -> bool {
    let (bytes, ending) = (word.as_encoded_bytes(), ending.as_bytes());
    let start = bytes.len().checked_sub(ending.len());
    start.is_some_and(|start| bytes[start..].eq_ignore_ascii_case(ending))
}

/// A path in a JSON document, where what is not UTF-8 in it is replaced by U+FFFD.
pub(super) fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// The same, and null for no path.
pub(super) fn lossy_or_null<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(path) => lossy(path, serializer),
        None => serializer.serialize_none(),
    }
}

pub(super) fn bad(flag: &Flag, word: &OsStr, problem: Problem) -> CliError {
    CliError::BadValue { flag: flag.name, word: word.to_owned(), problem }
}

pub(super) fn picture_name(flag: &Flag, word: &OsStr) -> Result<PathBuf, CliError> {
    match Format::of(Path::new(word)) {
        Some(_) => Ok(word.into()),
        None => Err(bad(flag, word, Problem::NotPicture)),
    }
}

/// The name of a picture that has bytes and not floating-point numbers.
pub(super) fn byte_picture_name(flag: &Flag, word: &OsStr) -> Result<PathBuf, CliError> {
    match Format::of(Path::new(word)) {
        Some(format) if !format.is_float() => Ok(word.into()),
        _ => Err(bad(flag, word, Problem::NotBytes)),
    }
}

/// The name of a picture to write and its format, which stands in the word after the name if the name does not tell it.
/// `-` means standard output, which on most systems is also called `/dev/stdout`.
pub(super) fn picture_file(
    flag: &Flag,
    name: &OsStr,
    format: Option<&OsStr>,
) -> Result<(PathBuf, Format), CliError> {
    let is_standard_output = name == "-" || name == "/dev/stdout";
    let problem = if is_standard_output { Problem::NoFormat } else { Problem::NotPicture };
    let format = match format {
        None => Format::of(Path::new(name)).ok_or_else(|| bad(flag, name, problem))?,
        Some(word) => {
            let named = word.to_str().and_then(Format::named);
            named.ok_or_else(|| bad(flag, word, Problem::NotFormat))?
        }
    };
    Ok((if is_standard_output { "-".into() } else { name.into() }, format))
}

/// The integer values of a flag, each from `range.0` to `range.1`.
pub(super) fn wholes<const N: usize>(
    raw: &Raw,
    flag: &Flag,
    range: (u32, u32),
) -> Result<Option<[u32; N]>, CliError> {
    let Some(words) = raw.values::<N>(flag)? else { return Ok(None) };
    let mut numbers = [0; N];
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = whole(word, range).map_err(|problem| bad(flag, word, problem))?;
    }
    Ok(Some(numbers))
}

pub(super) fn whole(word: &OsStr, (min, max): (u32, u32)) -> Result<u32, Problem> {
    let text = word.to_str().ok_or(Problem::NotWhole)?;
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(Problem::NotWhole);
    }
    // The word consists of digits, so it fails to parse only if it is negative or too large.
    text.parse().ok().filter(|n| (min..=max).contains(n)).ok_or(Problem::Outside { min, max })
}

pub(super) fn finite(flag: &Flag, word: &OsStr) -> Result<f64, CliError> {
    let number = word.to_str().and_then(|text| text.parse::<f64>().ok());
    number.filter(|n| n.is_finite()).ok_or_else(|| bad(flag, word, Problem::NotFinite))
}
