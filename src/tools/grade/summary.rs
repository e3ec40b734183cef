//! Writes the results as a block in the form of the statistics.

use super::{Score, Table};
use crate::base::escape::escape;
use crate::stats::RULE;
use std::fmt::Write;

/// Returns how many pictures pass: in total, for each name, and for each picture.
pub fn summary(table: &Table) -> String {
    let mut text = format!("{RULE}\nGRADING\n");
    let tolerance = table.tolerance;
    add(&mut text, "tolerance", &format!("{} levels, {} pixels", tolerance.levels, tolerance.pixels));
    add(&mut text, "pictures that pass", &table.score().to_string());
    text += "NAMES\n";
    for (row, name) in table.names.iter().enumerate() {
        add(&mut text, &escape(name), &table.score_of_row(row).to_string());
    }
    text += "PICTURES\n";
    for column in &table.columns {
        let result =
            column.problem.as_ref().map_or_else(|| Score::of(&column.cells).to_string(), |_| "NULL".into());
        add(&mut text, &escape(&column.picture), &result);
    }
    text + RULE + "\n"
}

fn add(text: &mut String, label: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  {label:<26} {value}");
}
