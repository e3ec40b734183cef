//! Writes the results as a block in the form of the statistics.

use super::{NotGraded, Reason, Score, Table};
use crate::base::escape::escape;
use crate::stats::RULE;
use std::fmt::Write;

/// The number of files without a picture that are named for each name.
const NAMED: usize = 10;

/// Returns how many pictures pass: in total, for each name, and for each picture. Names the pictures that pass by rounding
/// and the files that are not graded.
pub fn summary(table: &Table) -> String {
    let mut text = format!("{RULE}\nGRADING\n");
    add(&mut text, "tolerance", &table.rule.to_string());
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
    add_section(&mut text, "ROUNDING", rounding(table));
    add_section(&mut text, "NOT GRADED", not_graded(&table.not_graded));
    text + RULE + "\n"
}

/// Returns for each name the pictures that pass by rounding.
fn rounding(table: &Table) -> Vec<(String, String)> {
    let mut lines = vec![];
    for (row, name) in table.names.iter().enumerate() {
        let rounded = table.columns.iter().filter_map(|column| {
            let pixels = column.cells[row].rounded()?;
            Some(format!("{} {pixels} pixels", escape(&column.picture)))
        });
        let rounded: Vec<String> = rounded.collect();
        if !rounded.is_empty() {
            lines.push((escape(name), rounded.join(", ")));
        }
    }
    lines
}

/// Returns a line for each file, but one for all files of a name that are not pictures.
fn not_graded(all: &[NotGraded]) -> Vec<(String, String)> {
    let (others, pictures): (Vec<_>, Vec<_>) = all.iter().partition(|file| file.reason == Reason::NoPicture);
    let mut lines: Vec<(String, String)> =
        pictures.iter().map(|file| (escape(&file.path()), escape(&file.words()))).collect();
    for of_name in others.chunk_by(|a, b| a.name == b.name) {
        let named: Vec<String> = of_name.iter().take(NAMED).map(|file| escape(&file.file)).collect();
        let more = of_name.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let name = escape(of_name[0].name.as_deref().unwrap_or_default());
        lines.push((name, format!("{}: {}{more}", Reason::NoPicture.words(), named.join(", "))));
    }
    lines
}

fn add_section(text: &mut String, title: &str, lines: Vec<(String, String)>) {
    if !lines.is_empty() {
        *text += &format!("{title}\n");
        lines.iter().for_each(|(label, value)| add(text, label, value));
    }
}

fn add(text: &mut String, label: &str, value: &str) {
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  {label:<26} {value}");
}
