//! The first stage of the command line: clap groups the words to flags with the right number of values.
//!
//! clap supports long flags only with two dashes, and its notion of negative numbers differs from the
//! course's (`-.5` is none for it). So it is given a rewritten command line, in which flags have two dashes
//! and every other word is replaced by its index. Then clap never sees the text of a value.

use super::error::CliError;
use super::flags::{self, FLAGS, Flag};
use super::values::ends_in;
use crate::image_io::Format;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, ArgMatches};
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Flags with their values as words. Only the number of values has been checked.
pub(super) struct Raw {
    matches: ArgMatches,
    words: Vec<OsString>,
}

/// The reason why parsing ends without flags.
pub(super) enum Stop {
    /// The help, or that of the flag with this name.
    Help(Option<OsString>),
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
        match command(&flags_for(&words)).try_get_matches_from(line) {
            Ok(matches) => Ok(Self { matches, words }),
            Err(error) => Err(translate(&error, &words)),
        }
    }

    /// Whether the flag is given.
    pub fn given(&self, flag: &Flag) -> bool {
        matches!(self.matches.try_contains_id(flag.name), Ok(true))
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

    /// A flag with its values as they were given; nothing if it is not given.
    pub fn words_of(&self, flag: &Flag) -> Vec<String> {
        if !self.given(flag) {
            return vec![];
        }
        let indices = self.matches.try_get_raw(flag.name).ok().flatten().filter(|_| !flag.values.is_empty());
        let values = indices.into_iter().flatten().filter_map(|index| word_at(&self.words, index.to_str()?));
        let values = values.map(|word| word.to_string_lossy().into_owned());
        std::iter::once(format!("-{}", flag.name)).chain(values).collect()
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
        self.all_values(flag).map(|words| exactly(flag, words)).transpose()
    }

    /// The values of a flag that writes a picture, and the word after the picture's name that tells its format, if
    /// there is one. No word may follow a name that tells it.
    pub fn picture_values<const N: usize>(&self, flag: &Flag) -> Result<Option<Picture<'_, N>>, CliError> {
        let Some(mut words) = self.all_values(flag) else { return Ok(None) };
        let Some(place) = flag.picture.filter(|_| words.len() > N) else {
            return exactly(flag, words).map(|words| Some((words, None)));
        };
        if Format::of(Path::new(words[place])).is_some() {
            let meant = meant(words[N], &self.words);
            return Err(CliError::UnexpectedWord { word: words[N].into(), meant });
        }
        let format = words.remove(place + 1);
        exactly(flag, words).map(|words| Some((words, Some(format))))
    }
}

/// The values of a flag that writes a picture, and the name of the format where it stands by itself.
pub(super) type Picture<'a, const N: usize> = ([&'a OsStr; N], Option<&'a OsStr>);

fn exactly<'a, const N: usize>(flag: &Flag, words: Vec<&'a OsStr>) -> Result<[&'a OsStr; N], CliError> {
    let given = words.len();
    let wrong = |_| CliError::WrongCount { flag: flag.name.into(), expected: N, given };
    words.try_into().map_err(wrong)
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

/// The flags that clap has to know: those among the words, or, if one of them does not exist, all, to suggest another.
/// Setting up all of them would take longer than the rest of the parsing.
fn flags_for(words: &[OsString]) -> Vec<&'static Flag> {
    let find = |word: &OsString| flags::find(word.to_str()?.trim_start_matches('-'));
    let words = words.iter().filter(|word| is_flag(word.as_encoded_bytes()));
    let given: Option<Vec<_>> = words.map(find).collect();
    let is_given =
        |flag: &&Flag| given.as_ref().is_none_or(|given| given.iter().any(|g| g.name == flag.name));
    FLAGS.iter().copied().filter(is_given).collect()
}

fn command(known: &[&'static Flag]) -> clap::Command {
    clap::Command::new("raytracer")
        .version(env!("CARGO_PKG_VERSION"))
        .no_binary_name(true)
        .disable_help_flag(true)
        .disable_version_flag(true)
        .args(known.iter().map(|flag| arg(flag, known)))
}

fn arg(flag: &Flag, known: &[&Flag]) -> Arg {
    let is_known = |name: &&&str| known.iter().any(|flag| flag.name == **name);
    let arg = Arg::new(flag.name).long(flag.name).aliases(flag.aliases);
    let arg = arg.conflicts_with_all(flag.conflicts.iter().filter(is_known));
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
        ErrorKind::DisplayHelp => Stop::Help(help_topic(words)),
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

/// The word after the flag for help, unless it is a flag that does not exist.
fn help_topic(words: &[OsString]) -> Option<OsString> {
    fn named(word: &OsString) -> Option<&'static Flag> {
        let name = word.to_str().filter(|_| is_flag(word.as_encoded_bytes()))?;
        flags::find(name.trim_start_matches('-'))
    }
    let is_help = |word: &OsString| named(word).is_some_and(|flag| flag.name == flags::HELP.name);
    let topic = words.get(words.iter().position(is_help)? + 1)?;
    let is_topic = !is_flag(topic.as_encoded_bytes()) || named(topic).is_some();
    is_topic.then(|| topic.clone())
}

fn unknown(error: &clap::Error, words: &[OsString]) -> CliError {
    let shown = text(error, ContextKind::InvalidArg).unwrap_or_default();
    match shown.strip_prefix("--") {
        Some(name) => {
            CliError::UnknownFlag { flag: name.into(), nearest: flag_name(error, ContextKind::SuggestedArg) }
        }
        None => {
            let word = word_at(words, shown).unwrap_or_default();
            CliError::UnexpectedWord { word: word.into(), meant: meant(word, words) }
        }
    }
}

/// The flag that is missing before a word, as its ending tells.
fn meant(word: &OsStr, words: &[OsString]) -> Option<&'static str> {
    let flag = if ends_in(word, ".txt") {
        &flags::INPUT
    } else if Format::of(Path::new(word)).is_some() {
        &flags::OUTPUT
    } else {
        return None;
    };
    let is_it = |word: &OsString| word.to_str().is_some_and(|word| word.trim_start_matches('-') == flag.name);
    (!words.iter().any(is_it)).then_some(flag.name)
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
