//! Writes a table of results as comma-separated values (RFC 4180), one line for each picture of each name.

use super::{Cell, Column, Table};
use crate::base::escape::csv_field;

const HEAD: &str = "name,picture,result,pixels that differ,by more than one level,largest difference,\
                    root mean square error,reason\r\n";

/// Returns the table's lines, name by name.
pub fn csv(table: &Table) -> String {
    let rows = table.names.iter().enumerate();
    let lines = rows.flat_map(|(row, name)| table.columns.iter().map(move |column| line(name, column, row)));
    std::iter::once(HEAD.to_owned()).chain(lines).collect()
}

fn line(name: &str, column: &Column, row: usize) -> String {
    let cell = &column.cells[row];
    let numbers = match cell {
        Cell::Equal => ["0", "0", "0", "0"].map(str::to_owned),
        Cell::Different { comparison, .. } => [
            comparison.pixels_that_differ().to_string(),
            comparison.pixels_differing_by_more_than(1).to_string(),
            comparison.largest.map_or(0, |largest| largest.levels).to_string(),
            format!("{:.6}", comparison.root_mean_square_error),
        ],
        Cell::Missing | Cell::Unusable(_) | Cell::Ungraded => Default::default(),
    };
    let reason = column.reason(row).unwrap_or_default();
    let (name, picture) = (csv_field(name), csv_field(&column.picture));
    format!("{name},{picture},{},{},{}\r\n", cell.verdict().word(), numbers.join(","), csv_field(&reason))
}
