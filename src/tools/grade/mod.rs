//! Grading: the pictures of many people, each compared with its reference, in one table.
//!
//! A [`Table`] has a row for every name and a [`Column`] for every picture. A column is made at a time, so that only
//! the pictures of one column are in memory; what the [`Page`] shows of them is kept as compressed bytes.

mod column;
mod csv;
mod page;
mod summary;

pub use column::{Cell, CellWord, Column, Submission};
pub use csv::csv;
pub use page::Page;
pub use summary::summary;

use crate::tools::compare::Tolerance;

/// The results of a grading.
#[derive(Clone, Debug)]
pub struct Table {
    /// The difference that passes.
    pub tolerance: Tolerance,
    /// Whose pictures they are, from the first row.
    pub names: Vec<String>,
    /// One for each picture.
    pub columns: Vec<Column>,
    /// What was found that is not graded, a line each.
    pub notes: Vec<String>,
}

/// How many of some pictures pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Those that pass.
    pub passed: usize,
    /// Those that have a reference.
    pub graded: usize,
}

impl Score {
    /// The score of these cells.
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        cells.into_iter().fold(Self::default(), |score, cell| match cell.verdict() {
            CellWord::Passed => Self { passed: score.passed + 1, graded: score.graded + 1 },
            CellWord::Ungraded => score,
            _ => Self { graded: score.graded + 1, ..score },
        })
    }
}

impl Table {
    /// The score of the name in this row.
    pub fn score_of_row(&self, row: usize) -> Score {
        Score::of(self.columns.iter().map(|column| &column.cells[row]))
    }

    /// The score of all names.
    pub fn score(&self) -> Score {
        Score::of(self.columns.iter().flat_map(|column| &column.cells))
    }

    /// Whether all pictures have a reference and pass.
    pub fn passes(&self) -> bool {
        let Score { passed, .. } = self.score();
        passed == self.names.len() * self.columns.len()
    }
}
