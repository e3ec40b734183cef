//! The results as a JSON document, whose form `docs/json.md` describes.

use super::{Rule, Table};
use serde_json::json;

/// Returns the document in one line. Infinities are null.
pub fn document(table: &Table, format: u32) -> String {
    let names = table.names.iter().enumerate().map(|(row, name)| {
        let score = table.score_of_row(row);
        json!({
            "name": name,
            "points": score.points,
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
        "not_graded": table.not_graded,
    });
    format!("{document}\n")
}
