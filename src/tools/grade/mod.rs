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
    pub tolerance: Tolerance,
    /// One for each row.
    pub names: Vec<String>,
    /// One for each picture.
    pub columns: Vec<Column>,
    /// Notes about files that are not graded, one line each.
    pub notes: Vec<String>,
}

/// The number of pictures with each verdict, in the order of [`CellWord::COUNTED`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score([usize; CellWord::COUNTED.len()]);

impl Score {
    pub fn of<'c>(cells: impl IntoIterator<Item = &'c Cell>) -> Self {
        let verdicts: Vec<CellWord> = cells.into_iter().map(Cell::verdict).collect();
        Self(CellWord::COUNTED.map(|word| verdicts.iter().filter(|&&other| other == word).count()))
    }

    /// Returns the number of pictures that pass.
    pub fn passed(&self) -> usize {
        self.count(CellWord::Passed)
    }

    /// Returns the number of pictures with this verdict.
    fn count(&self, word: CellWord) -> usize {
        self.0.iter().zip(CellWord::COUNTED).find(|(_, other)| *other == word).map_or(0, |(count, _)| *count)
    }

    /// Returns the number of pictures that have a reference.
    pub fn graded(&self) -> usize {
        self.0.iter().sum()
    }

    /// Returns the percentage of pictures that pass, rounded down. 0 if no picture has a reference.
    pub fn points(&self) -> usize {
        100 * self.passed() / self.graded().max(1)
    }
}

impl fmt::Display for Score {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} of {}, {} points", self.passed(), self.graded(), self.points())?;
        let mut rest = self.0.iter().zip(CellWord::COUNTED).skip(1).filter(|(count, _)| **count > 0);
        rest.try_for_each(|(count, word)| write!(f, ", {count} {}", word.word()))
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
        let failed = self.score().count(CellWord::Failed);
        let passing = cells().filter(passes).count();
        let Tolerance { levels, pixels } = USUAL_TOLERANCE;
        (passing > 0).then(|| {
            format!("{passing} of the {failed} failed pictures pass with `-tolerance {levels} {pixels}`")
        })
    }

    /// Returns true if all pictures have a reference and pass.
    pub fn passes(&self) -> bool {
        self.score().passed() == self.names.len() * self.columns.len()
    }
}
