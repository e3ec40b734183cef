//! The results of a table as entries, one for each picture of each name, which all documents have in common.

use super::{Cell, CellWord, Column, NotGraded, Table};
use crate::tools::compare::Difference;
use serde::Serialize;

/// The result of a picture of a name, or a file that is not graded.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Entry {
    pub name: String,
    pub picture: String,
    pub result: &'static str,
    /// 1 if it passes, 0 if not; `None` without a reference.
    pub points: Option<u64>,
    pub pixels_that_differ: Option<u64>,
    /// Only of levels.
    pub by_more_than_one_level: Option<u64>,
    /// The number of pixels that rounding does not explain, if it can.
    pub not_rounding: Option<u64>,
    pub largest_difference: Option<f64>,
    pub root_mean_square_error: Option<f64>,
    /// `levels`, or `numbers` if floating-point pictures are compared.
    pub unit: Option<&'static str>,
    pub reason: Option<String>,
}

impl Table {
    /// Returns the results, name by name.
    pub fn entries(&self) -> impl Iterator<Item = Entry> {
        let rows = self.names.iter().enumerate();
        rows.flat_map(|(row, name)| self.columns.iter().map(move |column| Entry::new(name, column, row)))
    }
}

impl Entry {
    fn new(name: &str, column: &Column, row: usize) -> Self {
        let cell = &column.cells[row];
        let word = cell.verdict();
        let entry = Self {
            name: name.to_owned(),
            picture: column.picture.clone(),
            result: word.word(),
            points: (word != CellWord::Ungraded).then_some((word == CellWord::Passed).into()),
            reason: column.reason(row),
            ..Self::default()
        };
        match cell {
            Cell::Equal => Self {
                pixels_that_differ: Some(0),
                by_more_than_one_level: (!column.has_numbers).then_some(0),
                largest_difference: Some(0.0),
                root_mean_square_error: Some(0.0),
                unit: Some(if column.has_numbers { "numbers" } else { "levels" }),
                ..entry
            },
            Cell::Different { difference, verdict, .. } => {
                let is_of_levels = matches!(difference, Difference::Levels(_));
                let by_more_than_one = difference.pixels_differing_by_more_than(1.0);
                Self {
                    pixels_that_differ: Some(difference.pixels_that_differ()),
                    by_more_than_one_level: is_of_levels.then_some(by_more_than_one),
                    not_rounding: verdict.unexplained,
                    largest_difference: Some(difference.largest()),
                    root_mean_square_error: Some(difference.root_mean_square_error()),
                    unit: Some(if is_of_levels { "levels" } else { "numbers" }),
                    ..entry
                }
            }
            Cell::Missing | Cell::Unusable(_) | Cell::Ungraded => entry,
        }
    }

    /// The entry of a file that is not graded.
    pub fn of_file(file: &NotGraded) -> Self {
        Self {
            name: file.name.clone().unwrap_or_default(),
            picture: file.file.clone(),
            result: "not graded",
            reason: Some(file.words()),
            ..Self::default()
        }
    }
}
