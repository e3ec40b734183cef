//! The values that a flag is given, and what definitions of flags make of them: numbers in a range, and the names of
//! files.

use super::error::{CliError, Problem};
use super::flag::Flag;
use super::outputs::Output;
use super::raw::unexpected;
use crate::image_io::Format;
use crate::render::Layer;
use serde::Serializer;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The values of a flag as words.
pub(super) struct Values<'a> {
    pub flag: &'static Flag,
    pub words: Vec<&'a OsStr>,
    /// The whole command line.
    pub line: &'a [OsString],
}

/// The values of a flag that writes a picture, and the name of the format where it stands by itself.
pub(super) type OutputWords<'a, const N: usize> = ([&'a OsStr; N], Option<&'a OsStr>);

impl<'a> Values<'a> {
    /// The error for one of the values.
    pub fn bad(&self, word: &OsStr, problem: Problem) -> CliError {
        CliError::BadValue { flag: self.flag.name, word: word.to_owned(), problem }
    }

    /// The words of a flag that takes `N` of them.
    pub fn exactly<const N: usize>(&self) -> Result<[&'a OsStr; N], CliError> {
        let wrong = |words: Vec<_>| CliError::WrongCount { flag: self.flag.name, given: words.len() };
        self.words.clone().try_into().map_err(wrong)
    }

    /// The single word, if there is one and it is UTF-8.
    pub fn single(&self) -> Option<&'a str> {
        let [word] = self.exactly().ok()?;
        word.to_str()
    }

    /// Integers from `range.0` to `range.1`.
    pub fn wholes<const N: usize>(&self, range: (u32, u32)) -> Result<[u32; N], CliError> {
        let mut numbers = [0; N];
        for (number, word) in numbers.iter_mut().zip(self.exactly::<N>()?) {
            *number = self.whole(word, range)?;
        }
        Ok(numbers)
    }

    /// An integer from `min` to `max`.
    pub fn whole(&self, word: &OsStr, (min, max): (u32, u32)) -> Result<u32, CliError> {
        let text = word.to_str().unwrap_or_default();
        let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
        if digits.is_empty() || !digits.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(self.bad(word, Problem::NotWhole));
        }
        // The word consists of digits, so it fails to parse only if it is negative or too large.
        let number = text.parse().ok().filter(|n| (min..=max).contains(n));
        number.ok_or_else(|| self.bad(word, Problem::Outside { min, max }))
    }

    pub fn finite(&self, word: &OsStr) -> Result<f64, CliError> {
        let number = word.to_str().and_then(|text| text.parse::<f64>().ok());
        number.filter(|n| n.is_finite()).ok_or_else(|| self.bad(word, Problem::NotFinite))
    }

    /// A finite number from 0 on.
    pub fn not_negative(&self, word: &OsStr) -> Result<f64, CliError> {
        match self.finite(word)? {
            number if number < 0.0 => Err(self.bad(word, Problem::Negative)),
            number => Ok(number),
        }
    }

    /// The single integer, from `range.0` to `range.1`.
    pub fn number(&self, range: (u32, u32)) -> Result<u32, CliError> {
        self.wholes(range).map(|[number]| number)
    }

    /// The single number, finite and from 0 on.
    pub fn not_negative_number(&self) -> Result<f64, CliError> {
        self.exactly().and_then(|[word]| self.not_negative(word))
    }

    /// The name of a file with this ending, in upper or lower case.
    pub fn path_with(&self, ending: &str, problem: Problem) -> Result<PathBuf, CliError> {
        let [word] = self.exactly()?;
        if ends_in(word, ending) { Ok(word.into()) } else { Err(self.bad(word, problem)) }
    }

    /// The name of a file or folder.
    pub fn path(&self) -> Result<PathBuf, CliError> {
        self.exactly().map(|[word]| word.into())
    }

    /// The name of a picture to read.
    pub fn picture(&self) -> Result<PathBuf, CliError> {
        let [word] = self.exactly()?;
        match Format::of_input(Path::new(word)) {
            Some(_) => Ok(word.into()),
            None => Err(self.bad(word, Problem::NotPicture)),
        }
    }

    /// The name of a picture that has bytes and not floating-point numbers.
    pub fn byte_picture(&self, word: &OsStr) -> Result<PathBuf, CliError> {
        match Format::of(Path::new(word)) {
            Some(format) if !format.is_float() => Ok(word.into()),
            _ => Err(self.bad(word, Problem::NotBytes)),
        }
    }

    /// The name of a picture that may be a part of another.
    pub fn part(&self, word: &OsStr) -> Result<PathBuf, CliError> {
        match Format::of(Path::new(word)) {
            Some(format) if format.has_parts() => Ok(word.into()),
            _ => Err(self.bad(word, Problem::NotPart)),
        }
    }

    /// The values of a flag that writes a picture, and the word after the picture's name that tells its format, if
    /// there is one. No word may follow a name that tells it.
    pub fn of_output<const N: usize>(&self) -> Result<OutputWords<'a, N>, CliError> {
        let name = self.flag.values.iter().position(|value| value.is_output);
        let Some(name) = name.filter(|_| self.words.len() > N) else { return Ok((self.exactly()?, None)) };
        if Format::of(Path::new(self.words[name])).is_some() {
            return Err(unexpected(self.words[N], self.line));
        }
        let mut words = self.words.clone();
        let format = words.remove(name + 1);
        Ok((Values { words, ..*self }.exactly()?, Some(format)))
    }

    /// A picture to write. Its format stands in the word after the name if the name does not tell it. `-` means
    /// standard output, which on most systems is also called `/dev/stdout`. The layers are that of a picture of bytes
    /// and that of floating-point numbers.
    pub fn output(
        &self,
        name: &OsStr,
        format: Option<&OsStr>,
        layers: [Layer; 2],
    ) -> Result<Output, CliError> {
        let is_standard_output = name == "-" || name == "/dev/stdout";
        let problem = if is_standard_output { Problem::NoFormat } else { Problem::NotPicture };
        let format = match format {
            None => Format::of(Path::new(name)).ok_or_else(|| self.bad(name, problem))?,
            Some(word) => {
                let named = word.to_str().and_then(Format::named);
                named.ok_or_else(|| self.bad(word, Problem::NotFormat))?
            }
        };
        let file = if is_standard_output { "-".into() } else { name.into() };
        Ok(Output { layer: layers[usize::from(format.is_float())], file, format })
    }
}

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
