//! The tables.

use crate::measure::{KINDS, Median, Outcome};
use std::fmt::Write;

/// The results for one mesh, by contestant.
pub struct Row {
    pub faces: usize,
    pub build: Vec<Median>,
    pub results: Vec<Outcome>,
}

/// One line per contestant, as soon as its mesh is done.
pub fn plain(names: &[&str], row: &Row) -> String {
    let mut text = format!("{} faces\n", row.faces);
    for ((name, build), result) in names.iter().zip(&row.build).zip(&row.results) {
        let _ = write!(text, "  {name:<10} build {:8.2} ms", build.value);
        for (kind, name) in KINDS.iter().enumerate() {
            let Median { value, spread } = result.speed[kind];
            let (hits, differing) = (result.hits[kind], result.differing[kind]);
            let _ = write!(
                text,
                "; {name} {value:5.2} ±{:.0}% ({hits} hits, {differing} differ)",
                100.0 * spread
            );
        }
        text.push('\n');
    }
    text
}

/// Markdown: a table for each kind of ray, one of the builds and one of the hits.
pub fn markdown(names: &[&str], rows: &[Row]) -> String {
    let mut text = String::new();
    for (kind, name) in KINDS.iter().enumerate() {
        let _ = writeln!(text, "Millions of {name} rays per second:\n");
        table(&mut text, names, rows, |row, i| {
            let Median { value, spread } = row.results[i].speed[kind];
            format!("{value:.1} ±{:.0}%", 100.0 * spread)
        });
    }
    text.push_str("Milliseconds to build:\n\n");
    table(&mut text, names, rows, |row, i| format!("{:.2}", row.build[i].value));
    // The column of this program comes first.
    let kinds = |counts: [usize; KINDS.len()]| counts.map(|count| count.to_string()).join(" / ");
    text.push_str("Rays that hit according to this program, camera / shadow / incoherent:\n\n");
    table(&mut text, &["rays that hit"], rows, |row, _| kinds(row.results[0].hits));
    text.push_str(
        "Rays for which a peer's result differs from this program's, camera / shadow / incoherent:\n\n",
    );
    table(&mut text, &names[1..], rows, |row, i| kinds(row.results[i + 1].differing));
    text.trim_end().to_string()
}

fn table(text: &mut String, names: &[&str], rows: &[Row], cell: impl Fn(&Row, usize) -> String) {
    let _ = writeln!(text, "| Faces | {} |", names.join(" | "));
    let _ = writeln!(text, "|---:|{}", "---:|".repeat(names.len()));
    for row in rows {
        let cells: Vec<_> = (0..names.len()).map(|i| cell(row, i)).collect();
        let _ = writeln!(text, "| {} | {} |", row.faces, cells.join(" | "));
    }
    text.push('\n');
}
