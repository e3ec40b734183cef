//! Errors of the command line: clap's message in one line, and what may have been meant.

use super::flags::{find, meant};
use super::values::has_ending;
use super::words::single;
use crate::base::escape::escape;
use crate::image_io::Format;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::Path;

/// The longest message in characters, in which arguments of any length may be quoted.
const LONGEST: usize = 500;

/// An error in the command line. Its message is one line that names the flag or word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CliError(String);

impl CliError {
    pub(super) fn new(message: impl Into<String>) -> Self {
        let message: String = message.into();
        let shown: String = message.chars().take(LONGEST).collect();
        let ellipsis = if shown.len() < message.len() { "..." } else { "" };
        Self(escape(&shown) + ellipsis)
    }

    /// The error for a value of a flag, in clap's words.
    pub(super) fn value(flag: &str, word: impl AsRef<OsStr>, reason: &str) -> Self {
        let word = word.as_ref().to_string_lossy();
        Self::new(format!("invalid value '{word}' for '-{flag}': {reason}"))
    }

    /// The error for a word that is no value of a flag.
    pub(super) fn unexpected(word: &OsStr) -> Self {
        let word = &word.to_string_lossy();
        let hint =
            hint_for_word(word, &[]).map_or(String::new(), |meant| format!("; did you mean '{meant}'?"));
        Self::new(single(&format!("unexpected argument '{word}' found{hint}")))
    }

    /// The message of clap about these words, which have its dashes.
    pub(super) fn of(mut error: clap::Error, words: &[OsString]) -> Self {
        if let Some(ContextValue::Strings(others)) = error.get(ContextKind::PriorArg) {
            // clap lists all flags of a group.
            let given = others.iter().find(|other| is_given(other, words)).or(others.first()).cloned();
            error.insert(ContextKind::PriorArg, given.map_or(ContextValue::None, ContextValue::String));
        }
        let text = error.render().to_string();
        let message = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
        let message = message.split_whitespace().collect::<Vec<_>>().join(" ");
        // The standard library's words for a number that has a fraction or is none.
        let message = message.replace("invalid digit found in string", "not a whole number");
        Self::new(single(&(message + &hint(&error, words))))
    }
}

/// An error with this message.
pub(super) fn fail<T>(message: impl Into<String>) -> Result<T, CliError> {
    Err(CliError::new(message))
}

/// What follows clap's message.
fn hint(error: &clap::Error, words: &[OsString]) -> String {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => texts.first().cloned(),
        _ => None,
    };
    let flag = text(ContextKind::InvalidArg).unwrap_or_default();
    let similar = text(ContextKind::SuggestedArg).or(text(ContextKind::SuggestedValue));
    let name = flag.strip_prefix("--");
    let meant = match (error.kind(), name) {
        (ErrorKind::UnknownArgument, Some(name)) => {
            meant(name.split('=').next().unwrap_or(name)).and_then(find).map(|flag| flag.to_string())
        }
        (ErrorKind::UnknownArgument, None) => hint_for_word(&flag, words),
        _ => None,
    };
    match (error.kind(), meant.or(similar)) {
        (_, Some(meant)) => format!("; did you mean '{meant}'?"),
        (ErrorKind::UnknownArgument, None) if name.is_some() => " (-help lists all flags)".into(),
        (ErrorKind::MissingRequiredArgument, None) if flag.starts_with("--input") => {
            let compares = is_given("--compare", words);
            if compares { ", or --reference <picture>" } else { " (-h lists the usual flags)" }.into()
        }
        _ => String::new(),
    }
}

/// The flag that may be missing before a word, or its dash.
fn hint_for_word(word: &str, words: &[OsString]) -> Option<String> {
    let flag = match Path::new(word) {
        _ if find(word).is_some() => return Some(format!("--{word}")),
        path if has_ending(path, "txt") => "--input",
        path if Format::of(path).is_some() => "--output",
        _ => return None,
    };
    (!is_given(flag, words)).then(|| format!("{flag} {word}"))
}

/// Returns true if the flag is one of the words. `flag` may be followed by the names of its values.
fn is_given(flag: &str, words: &[OsString]) -> bool {
    words.iter().any(|word| flag.split(' ').next().is_some_and(|flag| word == flag))
}

impl fmt::Display for CliError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for CliError {}
