//! The first stage of the command line: clap groups the words to flags with the right number of values.
//!
//! clap supports long flags only with two dashes, and its notion of negative numbers differs from the
//! course's (`-.5` is none for it). So it is given a rewritten command line, in which flags have two dashes
//! and every other word is replaced by its index. Then clap never sees the text of a value.

use super::error::CliError;
use super::flags::{self, FLAGS, Flag};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::{OsStr, OsString};

/// Flags with their values as words. Only the number of values has been checked.
pub(super) struct Raw {
    matches: ArgMatches,
    words: Vec<OsString>,
}

/// The reason why parsing ends without flags.
pub(super) enum Stop {
    Help,
    Version,
    Error(CliError),
}

impl From<CliError> for Stop {
    fn from(error: CliError) -> Self {
        Self::Error(error)
    }
}

impl Raw {
    /// Parses `words`, which do not include the program's name.
    pub fn parse(words: Vec<OsString>) -> Result<Self, Stop> {
        let line =
            words.iter().enumerate().map(|(i, word)| rewrite(i, word)).collect::<Result<Vec<_>, _>>()?;
        match command().try_get_matches_from(line) {
            Ok(matches) => Ok(Self { matches, words }),
            Err(error) => Err(translate(&error, &words)),
        }
    }

    /// Whether the flag is given.
    pub fn given(&self, flag: &Flag) -> bool {
        self.matches.value_source(flag.name) == Some(ValueSource::CommandLine)
    }

    /// An error if a flag is given that is not among those that `flag` understands.
    pub fn refuse_others(&self, flag: &Flag, understood: &[&Flag]) -> Result<(), CliError> {
        let is_foreign =
            |other: &&&Flag| self.given(other) && !understood.iter().any(|known| known.name == other.name);
        match FLAGS.iter().find(is_foreign) {
            Some(other) => Err(CliError::Conflict { flag: flag.name.into(), other: other.name.into() }),
            None => Ok(()),
        }
    }

    /// The value of a flag that is given exactly one.
    pub fn single(&self, flag: &Flag) -> Option<&OsStr> {
        self.values::<1>(flag).ok().flatten().map(|[word]| word)
    }

    /// All values of a flag; `None` if it is not given.
    pub fn all_values(&self, flag: &Flag) -> Option<Vec<&OsStr>> {
        let indices = self.matches.try_get_raw(flag.name).ok()??;
        Some(indices.filter_map(|index| word_at(&self.words, index.to_str()?)).collect())
    }

    /// The values of a flag that takes `N` of them; `None` if the flag is not given.
    pub fn values<const N: usize>(&self, flag: &Flag) -> Result<Option<[&OsStr; N]>, CliError> {
        let Some(words) = self.all_values(flag) else { return Ok(None) };
        let given = words.len();
        match words.try_into() {
            Ok(array) => Ok(Some(array)),
            Err(_) => Err(CliError::WrongCount { flag: flag.name.into(), expected: N, given }),
        }
    }
}

/// Whether a word is a flag: one or two dashes and a letter. Everything else is a value.
pub(super) fn is_flag(word: &[u8]) -> bool {
    matches!(word, [b'-', letter, ..] | [b'-', b'-', letter, ..] if letter.is_ascii_alphabetic())
}

fn rewrite(index: usize, word: &OsStr) -> Result<OsString, CliError> {
    let bytes = word.as_encoded_bytes();
    if !is_flag(bytes) {
        return Ok(index.to_string().into());
    }
    reject_equals(word)?;
    let mut long = OsString::from(if bytes.starts_with(b"--") { "" } else { "-" });
    long.push(word);
    Ok(long)
}

/// An error for the form `-size=3`, which clap accepts but the course does not have.
fn reject_equals(word: &OsStr) -> Result<(), CliError> {
    let text = word.to_string_lossy();
    match text.trim_start_matches('-').split_once('=') {
        Some((name, _)) if flags::find(name).is_some() => Err(CliError::EqualsForm { flag: name.into() }),
        _ => Ok(()),
    }
}

fn command() -> clap::Command {
    clap::Command::new("raytracer")
        .version(env!("CARGO_PKG_VERSION"))
        .no_binary_name(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .args(FLAGS.iter().map(|flag| arg(flag)))
}

fn arg(flag: &Flag) -> Arg {
    let arg = Arg::new(flag.name).long(flag.name).aliases(flag.aliases).conflicts_with_all(flag.conflicts);
    match flag.name {
        "help" => arg.action(ArgAction::Help),
        "version" => arg.action(ArgAction::Version),
        _ if flag.values.is_empty() => arg.action(ArgAction::SetTrue),
        _ => arg.num_args(flag.value_counts()).value_parser(clap::value_parser!(OsString)),
    }
}

fn word_at<'a>(words: &'a [OsString], index: &str) -> Option<&'a OsStr> {
    words.get(index.parse::<usize>().ok()?).map(OsString::as_os_str)
}

/// Converts an error of clap. Kinds that cannot occur for this command become `Unreadable`.
fn translate(error: &clap::Error, words: &[OsString]) -> Stop {
    let flag = flag_name(error, ContextKind::InvalidArg).unwrap_or_default();
    match error.kind() {
        ErrorKind::DisplayHelp => Stop::Help,
        ErrorKind::DisplayVersion => Stop::Version,
        ErrorKind::UnknownArgument => unknown(error, words).into(),
        ErrorKind::ArgumentConflict => conflict(flag, flag_name(error, ContextKind::PriorArg)).into(),
        ErrorKind::InvalidValue
        | ErrorKind::WrongNumberOfValues
        | ErrorKind::TooFewValues
        | ErrorKind::TooManyValues => wrong_count(flag, error).into(),
        kind => CliError::Unreadable { reason: kind.as_str().unwrap_or("unknown reason").into() }.into(),
    }
}

fn unknown(error: &clap::Error, words: &[OsString]) -> CliError {
    let shown = text(error, ContextKind::InvalidArg).unwrap_or_default();
    match shown.strip_prefix("--") {
        Some(name) => {
            CliError::UnknownFlag { flag: name.into(), nearest: flag_name(error, ContextKind::SuggestedArg) }
        }
        None => CliError::UnexpectedWord { word: word_at(words, shown).unwrap_or_default().into() },
    }
}

fn conflict(flag: String, other: Option<String>) -> CliError {
    match other {
        Some(other) if other != flag => CliError::Conflict { flag, other },
        _ => CliError::GivenTwice { flag },
    }
}

fn wrong_count(flag: String, error: &clap::Error) -> CliError {
    let expected = flags::find(&flag).map_or(1, |found| found.values.len());
    let given = match error.get(ContextKind::ActualNumValues) {
        Some(ContextValue::Number(n)) => usize::try_from(*n).unwrap_or(0),
        _ => 0,
    };
    CliError::WrongCount { flag, expected, given }
}

/// The name of the flag in the context of a clap error: `size` for `--size <w> <h>`.
fn flag_name(error: &clap::Error, kind: ContextKind) -> Option<String> {
    Some(text(error, kind)?.split_whitespace().next()?.trim_start_matches('-').to_owned())
}

fn text(error: &clap::Error, kind: ContextKind) -> Option<&str> {
    match error.get(kind)? {
        ContextValue::String(text) => Some(text),
        ContextValue::Strings(texts) => texts.first().map(String::as_str),
        _ => None,
    }
}
