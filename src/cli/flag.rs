//! What a flag is. The flags themselves are defined in `flags.rs`.

use super::error::CliError;
use super::flags::FLAGS;
use super::section::Section;
use super::values::Values;
use std::ops::{Deref, RangeInclusive};

/// What parsing, help, manual page, completions and documents have to know of a flag. Names are without the dash.
#[derive(Debug)]
pub(super) struct Flag {
    pub section: Section,
    pub name: &'static str,
    /// Other spellings, which the help does not list.
    pub aliases: &'static [&'static str],
    /// What other programs call it. These are no spellings: who gives one is told the name.
    pub elsewhere: &'static [&'static str],
    /// Whether it is one of the few that people use, which the short help lists.
    pub is_usual: bool,
    pub values: &'static [Value],
    /// The smallest number of values, where fewer than all are understood.
    pub fewest: usize,
    /// What happens without the flag; empty if the flag is only there for its effect. A default that is a value is
    /// written as on the command line, and read from here.
    pub default: &'static str,
    /// The sentences that every help has.
    pub help: &'static str,
    /// More sentences, for the help about this flag alone.
    pub details: &'static str,
    /// The flag with values; empty if it takes none.
    pub example: &'static str,
    /// What stands before and after the example in a whole command line on which the flag makes sense.
    pub around: [&'static str; 2],
    /// The flags that cannot be combined with this one. One of two that exclude each other names the other.
    pub excludes: &'static [&'static Flag],
    /// The flag that has to be given too.
    pub needs: Option<&'static Flag>,
    /// The runs that understand the flag, beside those that render.
    pub runs: &'static [Run],
}

/// What a command line can ask for beside pictures of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Run {
    Merge,
    Convert,
    Grade,
    ErrorReport,
    /// The live page, whose pictures the flag shapes.
    Page,
}

/// A value of a flag.
#[derive(Debug)]
pub(super) struct Value {
    /// The name that the help shows. One that ends in `...` stands for any number of values.
    pub name: &'static str,
    pub offer: Offer,
    /// Whether it names a picture to write, whose format may be the word after it.
    pub is_output: bool,
}

/// What completions offer for a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Offer {
    /// Files whose names end like this after the dot, and folders on the way to them.
    Files(&'static [&'static str]),
    Folders,
    /// One of these words.
    Words(&'static [&'static str]),
    /// The name of a flag.
    Flags,
    Nothing,
}

/// A number, or another word that nobody can guess.
pub(super) const fn number(name: &'static str) -> Value {
    Value { name, offer: Offer::Nothing, is_output: false }
}

/// A number, or one of these words.
pub(super) const fn word(name: &'static str, words: &'static [&'static str]) -> Value {
    Value { name, offer: Offer::Words(words), is_output: false }
}

/// A file whose name ends in one of these after the dot.
pub(super) const fn file(name: &'static str, endings: &'static [&'static str]) -> Value {
    Value { name, offer: Offer::Files(endings), is_output: false }
}

/// A picture to write.
pub(super) const fn output(endings: &'static [&'static str]) -> Value {
    Value { name: "file", offer: Offer::Files(endings), is_output: true }
}

pub(super) const fn folder(name: &'static str) -> Value {
    Value { name, offer: Offer::Folders, is_output: false }
}

pub(super) const fn flag_name(name: &'static str) -> Value {
    Value { name, offer: Offer::Flags, is_output: false }
}

/// A flag and what it means.
pub(super) struct Definition<T: 'static> {
    pub flag: Flag,
    /// Parses and checks the values.
    pub read: fn(&Values) -> Result<T, CliError>,
}

impl<T> Deref for Definition<T> {
    type Target = Flag;

    fn deref(&self) -> &Flag {
        &self.flag
    }
}

impl Flag {
    pub const fn new(section: Section, name: &'static str) -> Self {
        Self {
            section,
            name,
            aliases: &[],
            elsewhere: &[],
            is_usual: false,
            values: &[],
            fewest: 0,
            default: "",
            help: "",
            details: "",
            example: "",
            around: ["-input scene.txt -output picture.png", ""],
            excludes: &[],
            needs: None,
            runs: &[],
        }
    }

    pub const fn values(self, values: &'static [Value]) -> Self {
        Self { values, fewest: values.len(), ..self }
    }

    pub const fn aliases(self, aliases: &'static [&'static str]) -> Self {
        Self { aliases, ..self }
    }

    pub const fn elsewhere(self, elsewhere: &'static [&'static str]) -> Self {
        Self { elsewhere, ..self }
    }

    pub const fn usual(self) -> Self {
        Self { is_usual: true, ..self }
    }

    pub const fn fewest(self, fewest: usize) -> Self {
        Self { fewest, ..self }
    }

    pub const fn default(self, default: &'static str) -> Self {
        Self { default, ..self }
    }

    pub const fn help(self, help: &'static str) -> Self {
        Self { help, ..self }
    }

    pub const fn details(self, details: &'static str) -> Self {
        Self { details, ..self }
    }

    pub const fn example(self, example: &'static str) -> Self {
        Self { example, ..self }
    }

    /// What stands before the example in a command line.
    pub const fn after(self, before: &'static str) -> Self {
        Self { around: [before, ""], ..self }
    }

    /// What stands after the example in a command line.
    pub const fn before(self, after: &'static str) -> Self {
        Self { around: ["", after], ..self }
    }

    pub const fn excludes(self, excludes: &'static [&'static Flag]) -> Self {
        Self { excludes, ..self }
    }

    pub const fn needs(self, flag: &'static Flag) -> Self {
        Self { needs: Some(flag), ..self }
    }

    pub const fn runs(self, runs: &'static [Run]) -> Self {
        Self { runs, ..self }
    }

    /// The definition of a flag with values.
    pub const fn read<T>(self, read: fn(&Values) -> Result<T, CliError>) -> Definition<T> {
        Definition { flag: self, read }
    }

    /// The definition of a flag without values that turns something on.
    pub const fn switch(self) -> Definition<()> {
        Self { default: "off", ..self }.read(|_| Ok(()))
    }

    /// The numbers of values that are understood. Whether they fit together is for the definition to check.
    pub fn value_counts(&self) -> RangeInclusive<usize> {
        let most = self.values.len() + usize::from(self.values.iter().any(|value| value.is_output));
        self.fewest..=if self.takes_any_number() { usize::MAX } else { most }
    }

    /// Whether the last value stands for any number of values.
    pub fn takes_any_number(&self) -> bool {
        self.values.last().is_some_and(|value| value.name.ends_with("..."))
    }

    /// The first sentence of what it does, without its full stop.
    pub fn summary(&self) -> &'static str {
        let end = self.help.find(". ").unwrap_or(self.help.len());
        self.help[..end].trim_end_matches('.')
    }

    /// All spellings.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        std::iter::once(self.name).chain(self.aliases.iter().copied())
    }

    /// The flag with the names of its values, as in `-size w h`.
    pub fn usage(&self) -> String {
        self.values.iter().fold(format!("-{}", self.name), |line, value| line + " " + value.name)
    }

    /// The flag with values, as in `-size 200 200`.
    pub fn example_or_usage(&self) -> String {
        if self.example.is_empty() { self.usage() } else { self.example.to_owned() }
    }

    /// A whole command line with this flag.
    pub fn command(&self) -> String {
        let [before, after] = self.around;
        let parts = ["raytracer", before, &self.example_or_usage(), after];
        parts.into_iter().filter(|words| !words.is_empty()).collect::<Vec<_>>().join(" ")
    }

    /// Whether two flags cannot be combined.
    pub fn conflicts(&self, other: &Flag) -> bool {
        let names = |one: &Flag, other: &Flag| one.excludes.iter().any(|flag| flag.name == other.name);
        names(self, other) || names(other, self)
    }

    /// The flags that this one cannot be combined with.
    pub fn excluded(&self) -> impl Iterator<Item = &'static Flag> {
        FLAGS.iter().copied().filter(|other| self.conflicts(other))
    }
}
