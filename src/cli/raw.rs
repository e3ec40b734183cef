//! The first stage of the command line: the words are grouped to flags with the right number of values.

use super::error::CliError;
use super::flag::{Definition, Flag, Run};
use super::flags::{self, FLAGS};
use super::values::{Values, ends_in};
use crate::image_io::Format;
use std::ffi::{OsStr, OsString};
use std::ops::Range;
use std::path::Path;

/// Flags with their values as words. Their number has been checked, and that the flags can be combined.
pub(super) struct Raw {
    line: Vec<OsString>,
    /// The flags of the line in its order.
    given: Vec<Given>,
}

/// A flag of the line.
struct Given {
    flag: &'static Flag,
    /// Where its values stand.
    values: Range<usize>,
}

/// The reason why parsing ends without flags.
pub(super) enum Stop {
    /// The help, or that for this word.
    Help(Option<OsString>),
    /// The help about the usual flags.
    Usual,
    Version,
    Error(CliError),
}

impl From<CliError> for Stop {
    fn from(error: CliError) -> Self {
        Self::Error(error)
    }
}

impl Raw {
    /// Parses `line`, which does not include the program's name.
    pub fn parse(line: Vec<OsString>) -> Result<Self, Stop> {
        if let Some(flag) = line.iter().find_map(with_equals) {
            return Err(CliError::EqualsForm { flag }.into());
        }
        let mut raw = Self { line, given: vec![] };
        let mut last: Option<Given> = None;
        for (index, word) in raw.line.iter().enumerate() {
            if !is_flag(word.as_encoded_bytes()) {
                let given = last.as_mut().filter(|given| given.takes_more());
                given.ok_or_else(|| unexpected(word, &raw.line))?.values.end = index + 1;
                continue;
            }
            let flag = named(word).ok_or_else(|| unknown(word))?;
            add(&mut raw.given, last.take())?;
            let given = Given { flag, values: index + 1..index + 1 };
            if flag.name == flags::HELP.name {
                return Err(Stop::Help(topic(raw.line.get(index + 1))));
            }
            if flag.name == flags::USUAL.name {
                return Err(match topic(raw.line.get(index + 1)) {
                    None => Stop::Usual,
                    word => Stop::Help(word),
                });
            }
            if flag.name == flags::VERSION.name {
                return Err(Stop::Version);
            }
            // What follows may be a mistake too, which comes after that of giving the flag twice if it has no values.
            match flag.values.is_empty() {
                true => add(&mut raw.given, Some(given))?,
                false => last = Some(given),
            }
        }
        add(&mut raw.given, last)?;
        match raw.conflict() {
            Some(error) => Err(error.into()),
            None => Ok(raw),
        }
    }

    fn conflict(&self) -> Option<CliError> {
        self.given.iter().find_map(|Given { flag, .. }| {
            let other = self.given.iter().find(|other| flag.conflicts(other.flag))?;
            Some(CliError::Conflict { flag: flag.name, other: other.flag.name })
        })
    }

    /// Whether the flag is given.
    pub fn given(&self, flag: &Flag) -> bool {
        self.values(flag).is_some()
    }

    /// The values of a flag; none if it is not given.
    pub fn values(&self, flag: &Flag) -> Option<Values<'_>> {
        let Given { flag, values } = self.given.iter().find(|given| given.flag.name == flag.name)?;
        let words = self.line[values.clone()].iter().map(OsString::as_os_str).collect();
        Some(Values { flag, words, line: &self.line })
    }

    /// What a flag is given; none if it is not given.
    pub fn read<T>(&self, flag: &Definition<T>) -> Result<Option<T>, CliError> {
        self.values(flag).map(|values| (flag.read)(&values)).transpose()
    }

    /// What a flag is given, or the default that its definition names.
    pub fn read_or_default<T>(&self, flag: &'static Definition<T>) -> Result<T, CliError> {
        let default = || Values {
            flag: &flag.flag,
            words: flag.default.split(' ').map(OsStr::new).collect(),
            line: &self.line,
        };
        (flag.read)(&self.values(flag).unwrap_or_else(default))
    }

    /// What the first of these flags is given that is given at all.
    pub fn read_first<T>(&self, flags: &[&Definition<T>]) -> Result<Option<T>, CliError> {
        let given = flags.iter().find(|flag| self.given(flag));
        given.map_or(Ok(None), |flag| self.read(flag))
    }

    /// An error if a flag is given that a run does not understand, which `flag` asks for.
    pub fn refuse_others(&self, flag: &Flag, run: Run) -> Result<(), CliError> {
        let is_foreign = |other: &&&Flag| self.given(other) && !other.runs.contains(&run);
        match FLAGS.iter().find(is_foreign) {
            Some(other) => Err(CliError::Conflict { flag: flag.name, other: other.name }),
            None => Ok(()),
        }
    }

    /// An error if a flag is given that needs `flag`, which is not given.
    pub fn refuse_without(&self, flag: &Flag) -> Result<(), CliError> {
        let needs_it =
            |other: &&&Flag| self.given(other) && other.needs.is_some_and(|needed| needed.name == flag.name);
        match FLAGS.iter().find(needs_it) {
            Some(other) => Err(CliError::Needed { flag: other.name, needed: flag.usage() }),
            None => Ok(()),
        }
    }

    /// The given flags among those that a run understands, with their values, in the order of the help.
    pub fn words_for(&self, run: Run) -> Vec<String> {
        let values =
            FLAGS.iter().filter(|flag| flag.runs.contains(&run)).filter_map(|flag| self.values(flag));
        let words = |values: Values| {
            let words = values.words.into_iter().map(|word| word.to_string_lossy().into_owned());
            std::iter::once(format!("-{}", values.flag.name)).chain(words).collect::<Vec<_>>()
        };
        values.flat_map(words).collect()
    }
}

impl Given {
    fn takes_more(&self) -> bool {
        self.values.len() < *self.flag.value_counts().end()
    }
}

/// Adds a flag that has all its values.
fn add(all: &mut Vec<Given>, given: Option<Given>) -> Result<(), CliError> {
    let Some(given) = given else { return Ok(()) };
    let name = given.flag.name;
    if given.values.len() < *given.flag.value_counts().start() {
        return Err(CliError::WrongCount { flag: name, given: given.values.len() });
    }
    if all.iter().any(|other| other.flag.name == name) {
        return Err(CliError::GivenTwice { flag: name });
    }
    all.push(given);
    Ok(())
}

/// Whether a word is a flag: one or two dashes and a letter. Everything else is a value.
pub(super) fn is_flag(word: &[u8]) -> bool {
    matches!(word, [b'-', letter, ..] | [b'-', b'-', letter, ..] if letter.is_ascii_alphabetic())
}

/// The flag that a word names.
pub(super) fn named(word: &OsStr) -> Option<&'static Flag> {
    let name = word.to_str().filter(|_| is_flag(word.as_encoded_bytes()))?;
    flags::find(name.trim_start_matches('-'))
}

/// The flag in the form `-size=3`, which many programs have and the course does not.
fn with_equals(word: &OsString) -> Option<String> {
    let text = word.to_string_lossy();
    let (name, _) = text.trim_start_matches('-').split_once('=')?;
    flags::find(name).filter(|_| is_flag(word.as_encoded_bytes())).map(|_| name.to_owned())
}

/// What help is asked about: the word after the flag for help, unless it is a flag that no program has.
fn topic(word: Option<&OsString>) -> Option<OsString> {
    let is_known = |word: &OsString| named(word).is_some() || flags::meant(&name_of(word)).is_some();
    word.filter(|word| !is_flag(word.as_encoded_bytes()) || is_known(word)).cloned()
}

/// The name in a word that is a flag, known or not.
fn name_of(word: &OsStr) -> String {
    let text = word.to_string_lossy();
    text.trim_start_matches('-').split('=').next().unwrap_or_default().to_owned()
}

fn unknown(word: &OsStr) -> CliError {
    const SIMILAR: f64 = 0.7;
    let name = name_of(word);
    let nearest = flags::meant(&name.to_lowercase()).map(|flag| flag.name).or_else(|| {
        let names = FLAGS.iter().flat_map(|flag| flag.names());
        let similar = names
            .map(|known| (strsim::jaro(&name, known), known))
            .filter(|(likeness, _)| *likeness > SIMILAR);
        similar.max_by(|(one, _), (other, _)| one.total_cmp(other)).map(|(_, known)| known)
    });
    CliError::UnknownFlag { flag: name, nearest: nearest.map(str::to_owned) }
}

/// The error for a word that is not the value of any flag. Its ending may tell the flag that is missing before it.
pub(super) fn unexpected(word: &OsStr, line: &[OsString]) -> CliError {
    let flag = match () {
        () if ends_in(word, ".txt") => Some(flags::INPUT.name),
        () if Format::of(Path::new(word)).is_some() => Some(flags::OUTPUT.name),
        () => None,
    };
    let is_given = |name: &&str| {
        line.iter().any(|word| word.to_str().is_some_and(|word| word.trim_start_matches('-') == *name))
    };
    CliError::UnexpectedWord { word: word.into(), meant: flag.filter(|name| !is_given(name)) }
}
