//! Writes a table of results as comma-separated values: one line for each picture of each name, then one for each file
//! that is not graded.

use super::{Entry, Table};
use crate::base::escape::csv_field;
use crate::tools::table::{self, Column, count};

const COLUMNS: [Column<Entry>; 11] = [
    ("name", |entry| csv_field(&entry.name)),
    ("picture", |entry| csv_field(&entry.picture)),
    ("result", |entry| entry.result.to_owned()),
    ("points", |entry| count(entry.points)),
    ("pixels that differ", |entry| count(entry.pixels_that_differ)),
    ("by more than one level", |entry| count(entry.by_more_than_one_level)),
    ("not rounding", |entry| count(entry.not_rounding)),
    ("largest difference", |entry| {
        entry.largest_difference.map_or(String::new(), |largest| largest.to_string())
    }),
    ("root mean square error", |entry| match entry.root_mean_square_error {
        None => String::new(),
        Some(0.0) => "0".to_owned(),
        Some(error) => format!("{error:.6}"),
    }),
    ("unit", |entry| entry.unit.unwrap_or_default().to_owned()),
    ("reason", |entry| csv_field(entry.reason.as_deref().unwrap_or_default())),
];

/// Returns the table's lines, name by name.
pub fn csv(table: &Table) -> String {
    table::csv(&COLUMNS, table.entries().chain(table.not_graded.iter().map(Entry::of_file)))
}
