//! Writes a table of results as comma-separated values (RFC 4180): one line for each picture of each name, then one for
//! each file that is not graded.

use super::{Cell, CellWord, Column, NotGraded, Table, Values};
use crate::base::escape::csv_field;

const HEAD: &str = "name,picture,result,points,pixels that differ,by more than one level,not rounding,\
                    largest difference,root mean square error,unit,reason\r\n";

/// Returns the table's lines, name by name.
pub fn csv(table: &Table) -> String {
    let rows = table.names.iter().enumerate();
    let lines = rows.flat_map(|(row, name)| table.columns.iter().map(move |column| line(name, column, row)));
    let not_graded = table.not_graded.iter().map(not_graded);
    std::iter::once(HEAD.to_owned()).chain(lines).chain(not_graded).collect()
}

fn line(name: &str, column: &Column, row: usize) -> String {
    let cell = &column.cells[row];
    let (name, picture) = (csv_field(name), csv_field(&column.picture));
    let reason = csv_field(&column.reason(row).unwrap_or_default());
    let (word, points) = (cell.verdict().word(), points(cell).map_or("", |point| ["0", "1"][point]));
    format!("{name},{picture},{word},{points},{},{reason}\r\n", numbers(column.values(row)))
}

/// Returns the point of a picture that has a reference: 1 if it passes.
pub(super) fn points(cell: &Cell) -> Option<usize> {
    let word = cell.verdict();
    (word != CellWord::Ungraded).then_some(usize::from(word == CellWord::Passed))
}

fn numbers(values: Option<Values>) -> String {
    let Some(values) = values else { return ",".repeat(5) };
    let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
    let error = match values.root_mean_square_error {
        0.0 => "0".to_owned(),
        error => format!("{error:.6}"),
    };
    [
        values.pixels_that_differ.to_string(),
        count(values.by_more_than_one_level),
        count(values.not_rounding),
        values.largest_difference.to_string(),
        error,
        values.unit.to_owned(),
    ]
    .join(",")
}

fn not_graded(file: &NotGraded) -> String {
    let name = csv_field(file.name.as_deref().unwrap_or_default());
    let (path, words) = (csv_field(&file.file), csv_field(&file.words()));
    format!("{name},{path},not graded,,{},{words}\r\n", numbers(None))
}
