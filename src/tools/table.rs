//! Tables: columns with headings, and rows. They are written as comma-separated values, and shown on pages.

/// A column: its heading, and the text of its cell in a row.
pub type Column<R> = (&'static str, fn(&R) -> String);

/// Writes a table as comma-separated values (RFC 4180). Cells are written as they are.
pub fn csv<R>(columns: &[Column<R>], rows: impl Iterator<Item = R>) -> String {
    let headings = columns.iter().map(|(heading, _)| *heading).collect::<Vec<_>>().join(",");
    let lines = rows.map(|row| columns.iter().map(|(_, cell)| cell(&row)).collect::<Vec<_>>().join(","));
    std::iter::once(headings).chain(lines).map(|line| line + "\r\n").collect()
}

/// Formats a number with this number of digits after the point. A missing number is empty.
pub fn optional(number: Option<f64>, digits: usize) -> String {
    number.map_or(String::new(), |number| format!("{number:.digits$}"))
}

/// Formats a count. A missing count is empty.
pub fn count(count: Option<u64>) -> String {
    count.map_or(String::new(), |count| count.to_string())
}
