//! Writes a table of results as comma-separated values (RFC 4180): one line for each picture of each name, then one for
//! each file that is not graded.

use super::{Entry, Table};
use crate::base::escape::csv_field;

const HEAD: &str = "name,picture,result,points,pixels that differ,by more than one level,not rounding,\
                    largest difference,root mean square error,unit,reason\r\n";

/// Returns the table's lines, name by name.
pub fn csv(table: &Table) -> String {
    let entries = table.entries().chain(table.not_graded.iter().map(Entry::of_file));
    std::iter::once(HEAD.to_owned()).chain(entries.map(|entry| line(&entry))).collect()
}

fn line(entry: &Entry) -> String {
    let count = |count: Option<u64>| count.map_or(String::new(), |count| count.to_string());
    let error = entry.root_mean_square_error.map_or(String::new(), |error| match error {
        0.0 => "0".to_owned(),
        error => format!("{error:.6}"),
    });
    let fields = [
        csv_field(&entry.name),
        csv_field(&entry.picture),
        entry.result.to_owned(),
        count(entry.points),
        count(entry.pixels_that_differ),
        count(entry.by_more_than_one_level),
        count(entry.not_rounding),
        entry.largest_difference.map_or(String::new(), |largest| largest.to_string()),
        error,
        entry.unit.unwrap_or_default().to_owned(),
        csv_field(entry.reason.as_deref().unwrap_or_default()),
    ];
    fields.join(",") + "\r\n"
}
