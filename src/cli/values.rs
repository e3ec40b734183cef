//! Parsers of values. clap calls them for most flags, and `value` of `error.rs` where values are of several kinds.

use crate::base::stdio::is_stdio;
use crate::image_io::Format;
use clap::builder::{PathBufValueParser, TypedValueParser};
use serde::Serializer;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// The range of a picture's sides, in pixels.
pub(super) const SIDES: RangeInclusive<usize> = 1..=65535;

/// A range of numbers, and the description of a number outside it.
type Numbers = (RangeInclusive<f64>, &'static str);

pub(super) const FINITE: Numbers = (f64::MIN..=f64::MAX, "not a finite number");
pub(super) const NOT_NEGATIVE: Numbers = (0.0..=f64::MAX, "not a finite number of 0 or more");
/// The filter's weights divide by its size and the square of that, which must not underflow.
pub(super) const FILTER_SIZE: Numbers = (1e-6..=1e6, "must be from 0.000001 to 1000000 pixels");

/// One side of a picture, or both.
pub(super) type Sides = Vec<usize>;

/// Parses a side, or both in the form `200x150`.
pub(super) fn sides(word: &str) -> Result<Sides, &'static str> {
    let side = |text: &str| text.parse().ok().filter(|side| SIDES.contains(side));
    let sides: Option<Sides> = word.split(['x', 'X']).map(side).collect();
    sides.ok_or("must be a whole number from 1 to 65535")
}

pub(super) fn number((range, problem): Numbers) -> impl TypedValueParser<Value = f64> {
    move |word: &str| word.parse().ok().filter(|number| range.contains(number)).ok_or(problem)
}

/// Reads the path of a picture to read.
pub(super) fn picture() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| match Format::of_input(&path) {
        Some(_) => Ok(path),
        None if Format::is_unread_picture(&path) => {
            Err(must_end_in(Format::READ) + "; convert it to PNG first")
        }
        None => Err(must_end_in(Format::READ)),
    })
}

/// Reads a path that meets a condition.
pub(super) fn path(
    is_fit: fn(&Path) -> bool,
    problem: impl Into<String>,
) -> impl TypedValueParser<Value = PathBuf> {
    let problem = problem.into();
    PathBufValueParser::new().try_map(move |path| if is_fit(&path) { Ok(path) } else { Err(problem.clone()) })
}

/// Returns the problem of a path whose name has none of these endings.
pub(super) fn must_end_in(endings: &str) -> String {
    format!("must end in {endings}")
}

/// Returns true if the name ends in a dot and `ending`, in upper or lower case.
pub(super) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

/// Writes a path to a JSON document; what is not UTF-8 in it is replaced by U+FFFD.
pub(super) fn lossy<S: Serializer>(path: &Path, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&path.to_string_lossy())
}

/// Writes a path or null.
pub(super) fn lossy_or_null<S: Serializer>(path: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match path {
        Some(path) => lossy(path, serializer),
        None => serializer.serialize_none(),
    }
}

/// Writes the target of the JSON document: `-` as it is, and a file as an object with its name.
pub(super) fn json_target<S: Serializer>(target: &Option<PathBuf>, serializer: S) -> Result<S::Ok, S::Error> {
    match target {
        Some(file) if !is_stdio(file) => serializer.collect_map([("file", file.to_string_lossy())]),
        _ => lossy_or_null(target, serializer),
    }
}
