//! Errors of the command line: clap's message in one line, and a suggestion.

use super::flags::{find, meant};
use super::values::has_ending;
use super::words::single;
use crate::base::escape::escape;
use crate::diagnostic::Diagnostic;
use crate::image_io::Format;
use clap::builder::TypedValueParser;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// The longest message in characters, in which arguments of any length may be quoted.
const LONGEST: usize = 500;

/// Fails with this message, which names the flag or word.
pub(super) fn fail<T>(message: impl AsRef<str>) -> Result<T, Diagnostic> {
    Err(Diagnostic::error(one_line(message.as_ref())))
}

/// Fails for a value of a flag, in clap's words.
pub(super) fn invalid<T>(flag: &str, word: impl AsRef<OsStr>, reason: &str) -> Result<T, Diagnostic> {
    fail(format!("invalid value '{}' for '-{flag}': {reason}", word.as_ref().to_string_lossy()))
}

/// Fails for a word that is no value of a flag.
pub(super) fn unexpected<T>(word: &OsStr) -> Result<T, Diagnostic> {
    let word = word.to_string_lossy();
    let hint = flag_before(&word, &[]).map(did_you_mean);
    fail(single(&format!("unexpected argument '{word}' found")))
        .map_err(|error: Diagnostic| Diagnostic { hint, ..error })
}

/// Parses one value of a flag that has values of several kinds.
pub(super) fn value<P: TypedValueParser>(
    flag: &str,
    word: &OsStr,
    parser: P,
) -> Result<P::Value, Diagnostic> {
    parser.parse_ref(&clap::Command::new(""), None, word).map_err(|mut error| {
        error.insert(ContextKind::InvalidArg, ContextValue::String(format!("-{flag}")));
        of_clap(error, &[])
    })
}

/// Converts clap's error about these words, which have its dashes.
pub(super) fn of_clap(mut error: clap::Error, words: &[OsString]) -> Diagnostic {
    if let Some(ContextValue::Strings(others)) = error.get(ContextKind::PriorArg) {
        // clap lists all flags of a group.
        let given = others.iter().find(|other| is_given(other, words)).or(others.first()).cloned();
        error.insert(ContextKind::PriorArg, given.map_or(ContextValue::None, ContextValue::String));
    }
    let text = error.render().to_string();
    let message = text.trim_start_matches("error: ").split("\n\n").next().unwrap_or_default();
    let mut message = message.split_whitespace().collect::<Vec<_>>().join(" ");
    if error.kind() == ErrorKind::MissingRequiredArgument {
        // "... not provided: --a <x> <--b <y>|--c <z>>" becomes "missing --a <x> and --b <y> or --c <z>".
        message = message.replace("the following required arguments were not provided:", "missing");
        message = message.replace("missing <--", "missing --").replace(" <--", " and --");
        message = message.replace("|--", " or --").replace(">>", ">");
    }
    // The standard library's words for a number that has a fraction or is none.
    let (given, reason) = message.split_at(message.rfind("': ").unwrap_or(message.len()));
    let reason = reason.replace("invalid digit found in string", "not a whole number");
    // "0 is not in 1..=9" becomes "0 is not from 1 to 9".
    let message = format!("{given}{}", reason.replace(" is not in ", " is not from ").replace("..=", " to "));
    Diagnostic { hint: hint(&error, words), ..Diagnostic::error(one_line(&single(&message))) }
}

/// Returns advice on an error of clap.
fn hint(error: &clap::Error, words: &[OsString]) -> Option<String> {
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
        (ErrorKind::UnknownArgument, None) => flag_before(&flag, words),
        _ => None,
    };
    match (error.kind(), meant.or(similar)) {
        (_, Some(meant)) => Some(did_you_mean(meant)),
        (ErrorKind::UnknownArgument, None) if name.is_some() => Some("-help lists all flags".into()),
        (ErrorKind::MissingRequiredArgument, None) if flag.starts_with("--input") => {
            let compares = is_given("--compare", words);
            let advice = if compares { "or give -reference <picture>" } else { "-h lists the usual flags" };
            Some(advice.into())
        }
        _ => None,
    }
}

/// Returns the flag that may be missing before a word, with the word, or the word with its dash.
fn flag_before(word: &str, words: &[OsString]) -> Option<String> {
    let flag = match Path::new(word) {
        _ if find(word).is_some() => return Some(format!("--{word}")),
        path if has_ending(path, "txt") => "--input",
        path if Format::of(path).is_some() => "--output",
        _ => return None,
    };
    (!is_given(flag, words)).then(|| format!("{flag} {word}"))
}

fn did_you_mean(meant: String) -> String {
    one_line(&single(&format!("did you mean '{meant}'?")))
}

/// Escapes a text, so that it is one line, and cuts it if it is too long.
fn one_line(text: &str) -> String {
    let shown: String = text.chars().take(LONGEST).collect();
    let ellipsis = if shown.len() < text.len() { "..." } else { "" };
    escape(&shown) + ellipsis
}

/// Returns true if the flag is one of the words. `flag` may be followed by the names of its values.
fn is_given(flag: &str, words: &[OsString]) -> bool {
    words.iter().any(|word| flag.split(' ').next().is_some_and(|flag| word == flag))
}
