//! Grading: compares the pictures of many people with their references, in one table.
//!
//! A [`Table`] has a row for every name and a [`Column`] for every picture. Columns are made one at a time, so only one
//! column's pictures are in memory. The pictures in the [`Page`] are kept as compressed bytes.

mod column;
mod csv;
mod page;
mod summary;

pub use column::{Cell, CellWord, Column, Submission};
pub use csv::csv;
pub use page::Page;
pub use summary::summary;

use crate::tools::compare::Tolerance;
use std::fmt;

/// The usual difference of a correct tracer in single precision: silhouettes off by up to a pixel in a few places, and
/// colours by one level.
const USUAL_TOLERANCE: Tolerance = Tolerance { levels: 1, pixels: 50 };

/// The results of a grading.
#[derive(Clone, Debug)]
pub struct Table {
    /// The tolerance for passing.
    pub tolerance: Tolerance,
    /// The names of the rows.
    pub names: Vec<String>,
    /// The columns, one for each picture.
    pub columns: Vec<Column>,
    /// Notes about files that are not graded, one line each.
    pub notes: Vec<String>,
}

/// The number of pictures that pass, and the numbers of the others by verdict.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Pictures that pass.
    pub passed: usize,
    /// Pictures that are wrong.
    pub failed: usize,
    /// Pictures that were not submitted.
    pub missing: usize,
    /// Pictures that cannot be read or compared.
    pub unusable: usize,
}

impl Score {
    /// Returns the score of these cells.
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        let mut score = Self::default();
        for cell in cells {
            match cell.verdict() {
                CellWord::Passed => score.passed += 1,
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
        self.passed + self.failed + self.missing + self.unusable
    }

    /// Returns the percentage of pictures that pass, rounded down. 0 if no picture has a reference.
    pub fn points(&self) -> usize {
        100 * self.passed / self.graded().max(1)
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}, {} points", self.passed, self.graded(), self.points())?;
        let rest = [(self.failed, "failed"), (self.missing, "missing"), (self.unusable, "unusable")];
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

    /// Returns how many of the failed pictures pass with the usual tolerance of one level and 50 pixels, if any does.
    pub fn tolerance_hint(&self) -> Option<String> {
        let cells = || self.columns.iter().flat_map(|column| &column.cells);
        let passes = |cell: &&Cell| match cell {
            // In a tiny picture, 50 pixels may be all that it shows.
            Cell::Different { comparison, passes: false, .. } => {
                USUAL_TOLERANCE.accepts(comparison) && comparison.pixels() >= 200 * USUAL_TOLERANCE.pixels
            }
            _ => false,
        };
        let (passing, failed) = (cells().filter(passes).count(), self.score().failed);
        let Tolerance { levels, pixels } = USUAL_TOLERANCE;
        (passing > 0).then(|| {
            format!("{passing} of the {failed} failed pictures pass with `-tolerance {levels} {pixels}`")
        })
    }

    /// Returns true if all pictures have a reference and pass.
    pub fn passes(&self) -> bool {
        self.score().passed == self.names.len() * self.columns.len()
    }
}
