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
use std::fmt;

/// The difference that a correct tracer in single precision may show: its silhouettes are up to a pixel off in a few
/// places, and its colours by a level.
const USUAL_TOLERANCE: Tolerance = Tolerance { levels: 1, pixels: 50 };

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

/// How many of some pictures pass, and what became of the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Those that pass.
    pub passed: usize,
    /// Those that are wrong.
    pub failed: usize,
    /// Those that nobody has handed in.
    pub missing: usize,
    /// Those that cannot be read or compared.
    pub unusable: usize,
}

impl Score {
    /// The score of these cells.
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

    /// Those that have a reference.
    pub fn graded(&self) -> usize {
        self.passed + self.failed + self.missing + self.unusable
    }

    /// The share of those that pass, in hundredths, cut to a whole number; 0 where nothing has a reference.
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
    /// The score of the name in this row.
    pub fn score_of_row(&self, row: usize) -> Score {
        Score::of(self.columns.iter().map(|column| &column.cells[row]))
    }

    /// The score of all names.
    pub fn score(&self) -> Score {
        Score::of(self.columns.iter().flat_map(|column| &column.cells))
    }

    /// Says how many of the failed pictures pass with the usual tolerance of one level and 50 pixels, if any does.
    pub fn tolerance_hint(&self) -> Option<String> {
        let cells = || self.columns.iter().flat_map(|column| &column.cells);
        let passes = |cell: &&Cell| match cell {
            // In a tiny picture 50 pixels may be all that it shows.
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

    /// Whether all pictures have a reference and pass.
    pub fn passes(&self) -> bool {
        self.score().passed == self.names.len() * self.columns.len()
    }
}
