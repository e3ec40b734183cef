//! The results as a JSON document, whose form `docs/json.md` describes.

use super::{NotGraded, Rule, Table};
use serde_json::{Value, json};

/// Returns the document in one line. Infinities are null.
pub fn document(table: &Table, format: u32) -> String {
    let names = table.names.iter().enumerate().map(|(row, name)| {
        let score = table.score_of_row(row);
        json!({
            "name": name,
            "points": score.points(),
            "graded": score.graded(),
            "percent": score.percent(),
        })
    });
    let no_reference = table.columns.iter().filter_map(|column| {
        let problem = column.problem.as_ref()?;
        Some(json!({ "picture": column.picture, "reason": problem }))
    });
    let tolerance = match table.rule {
        Rule::Tolerance(tolerance) => Some(tolerance),
        Rule::Equal | Rule::Rounding => None,
    };
    let document = json!({
        "format": format,
        "version": env!("CARGO_PKG_VERSION"),
        "tolerance": tolerance,
        "explains_rounding": table.rule == Rule::Rounding,
        "passes": table.passes(),
        "names": names.collect::<Vec<_>>(),
        "pictures": table.entries().collect::<Vec<_>>(),
        "no_reference": no_reference.collect::<Vec<_>>(),
        "not_graded": table.not_graded.iter().map(not_graded).collect::<Vec<_>>(),
    });
    format!("{document}\n")
}

fn not_graded(file: &NotGraded) -> Value {
    json!({
        "name": file.name,
        "file": file.file,
        "reason": file.reason.words(),
        "meant_for": file.meant_for,
    })
}
