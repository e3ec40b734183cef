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
pub use listing::{Kind, Listed, NotGraded, Pairing, Reason};
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

/// The number of pictures with each verdict. Pictures without a reference are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// The number of pictures that pass.
    pub points: usize,
    /// The number of pictures that pass since rounding explains their differences.
    by_rounding: usize,
    failed: usize,
    missing: usize,
    unusable: usize,
}

impl Score {
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        let mut score = Self::default();
        for cell in cells {
            score.by_rounding += usize::from(cell.rounded().is_some());
            match cell.verdict() {
                CellWord::Passed => score.points += 1,
                CellWord::Failed => score.failed += 1,
                CellWord::Missing => score.missing += 1,
                CellWord::Unusable => score.unusable += 1,
                CellWord::Ungraded => {}
            }
        }
        score
    }

    /// Returns the number of pictures that have a reference.
    pub fn graded(&self) -> usize {
        self.points + self.failed + self.missing + self.unusable
    }

    /// Returns the percentage of pictures that pass, rounded down. 0 if no picture has a reference.
    pub fn percent(&self) -> usize {
        100 * self.points / self.graded().max(1)
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}, {} percent", self.points, self.graded(), self.percent())?;
        let Self { by_rounding, failed, missing, unusable, .. } = *self;
        let rest =
            [(by_rounding, "by rounding"), (failed, "failed"), (missing, "missing"), (unusable, "unusable")];
        rest.iter()
            .filter(|(count, _)| *count > 0)
            .try_for_each(|(count, word)| write!(f, ", {count} {word}"))
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
        self.score().points == self.names.len() * self.columns.len()
    }
}
