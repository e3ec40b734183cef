//! What the table of flags holds of each flag.

use super::section::Section;

/// A flag. Names are without the dash.
#[derive(Debug)]
pub(super) struct Flag {
    pub name: &'static str,
    /// Other spellings, which the help does not list.
    pub aliases: &'static [&'static str],
    /// The names of the values, which the help shows.
    pub values: &'static [&'static str],
    /// The names of flags that cannot be combined with this one.
    pub conflicts: &'static [&'static str],
    /// The index of the value that names a picture to write. The word after it may be the picture's format.
    pub picture: Option<usize>,
    pub section: Section,
    pub doc: &'static str,
}

impl Flag {
    pub const fn new(
        section: Section,
        name: &'static str,
        values: &'static [&'static str],
        doc: &'static str,
    ) -> Self {
        Self { name, aliases: &[], values, conflicts: &[], picture: None, section, doc }
    }

    pub const fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    pub const fn conflicts(mut self, conflicts: &'static [&'static str]) -> Self {
        self.conflicts = conflicts;
        self
    }

    pub const fn picture(mut self, index: usize) -> Self {
        self.picture = Some(index);
        self
    }

    /// The numbers of values that the flag accepts: `-grid` may also have the single value `auto` or `none`, `-merge`
    /// has any number of files, and the name of a picture may be followed by its format.
    pub fn value_counts(&self) -> std::ops::RangeInclusive<usize> {
        match self.name {
            // `-size 200x200` is one word.
            "grid" | "size" => 1..=self.values.len(),
            "merge" => 1..=usize::MAX,
            _ => self.values.len()..=self.values.len() + usize::from(self.picture.is_some()),
        }
    }

    /// Whether two flags cannot be combined.
    pub fn conflicts_with(&self, other: &Flag) -> bool {
        self.conflicts.contains(&other.name) || other.conflicts.contains(&self.name)
    }

    /// All spellings.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        [self.name].into_iter().chain(self.aliases.iter().copied())
    }

    /// The flag with the names of its values, as in `-size w h`.
    pub fn usage(&self) -> String {
        self.values.iter().fold(format!("-{}", self.name), |line, value| line + " " + value)
    }
}
