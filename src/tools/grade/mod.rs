//! Grading: compares the pictures of many people with their references, in one table.
//!
//! A [`Table`] has a row for every name and a [`Column`] for every picture. Columns are made one at a time, so only one
//! column's pictures are in memory. Each picture is judged alone. The pictures in the [`Page`] are kept as compressed
//! bytes. `Pairing` says which file of a name is which picture.

mod column;
mod csv;
mod document;
mod entry;
mod listing;
mod page;
mod reference;
mod summary;

pub use column::{Cell, CellWord, Column, ColumnGrader, Remark, Submission};
pub use csv::csv;
pub use document::document;
pub use entry::Entry;
pub use listing::{Kind, Listed, Other, Pairing, Reason};
pub use page::Page;
pub use reference::{Reference, Rule};
pub use summary::summary;

use std::fmt;

/// The results of a grading.
#[derive(Clone, Debug)]
pub struct Table {
    pub rule: Rule,
    /// One for each row.
    pub names: Vec<String>,
    /// One for each picture.
    pub columns: Vec<Column>,
    pub not_graded: Vec<NotGraded>,
}

#[derive(Clone, Debug)]
pub struct NotGraded {
    /// The name in whose folder it is, if it is in one.
    pub name: Option<String>,
    /// Its path in that folder.
    pub file: String,
    pub reason: Reason,
    /// The picture that it is probably meant for.
    pub meant_for: Option<String>,
}

impl NotGraded {
    /// Returns the reason and the picture that it is probably meant for.
    pub fn words(&self) -> String {
        let reason = self.reason.words();
        match &self.meant_for {
            Some(picture) if self.reason == Reason::OtherIsGraded => format!("{reason} as {picture}"),
            Some(picture) => format!("{reason}; probably {picture}"),
            None => reason.to_owned(),
        }
    }

    /// Returns its path from the folder of all names.
    pub fn path(&self) -> String {
        let folder = self.name.as_ref().map_or(String::new(), |name| format!("{name}/"));
        folder + &self.file
    }
}

/// The number of pictures with each verdict, in the order of [`CellWord::COUNTED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    counts: [usize; CellWord::COUNTED.len()],
    /// The number of pictures that pass since rounding explains their differences.
    by_rounding: usize,
}

impl Score {
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        let mut score = Self::default();
        for cell in cells {
            score.by_rounding += usize::from(cell.rounded().is_some());
            let at = CellWord::COUNTED.iter().position(|&word| word == cell.verdict());
            at.into_iter().for_each(|at| score.counts[at] += 1);
        }
        score
    }

    /// Returns the number of pictures that pass: the points.
    pub fn points(&self) -> usize {
        self.counts[0]
    }

    /// Returns the number of pictures that have a reference.
    pub fn graded(&self) -> usize {
        self.counts.iter().sum()
    }

    /// Returns the percentage of pictures that pass, rounded down. 0 if no picture has a reference.
    pub fn percent(&self) -> usize {
        100 * self.points() / self.graded().max(1)
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}, {} percent", self.points(), self.graded(), self.percent())?;
        let rest = self.counts.iter().zip(CellWord::COUNTED.map(CellWord::word)).skip(1);
        let mut rest = [(&self.by_rounding, "by rounding")].into_iter().chain(rest);
        rest.try_for_each(|(count, word)| if *count > 0 { write!(f, ", {count} {word}") } else { Ok(()) })
    }
}

impl Table {
    /// Returns the score of the name in this row.
    pub fn score_of_row(&self, row: usize) -> Score {
        Score::of(self.columns.iter().map(|column| &column.cells[row]))
    }

    /// Returns the score of all names.
    pub fn score(&self) -> Score {
        Score::of(self.columns.iter().flat_map(|column| &column.cells))
    }

    /// Returns true if all pictures have a reference and pass.
    pub fn passes(&self) -> bool {
        self.score().points() == self.names.len() * self.columns.len()
    }
}
