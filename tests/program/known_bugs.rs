//! The table of known bugs in `docs/check-your-own.md` has every cause that `-compare` tries.

use raytracer::tools::causes::Mistake;
use std::fmt::Write;
use std::path::Path;

const START: &str = "<!-- known bugs: written by `BLESS=1 cargo test --test program known_bugs` -->\n";
const END: &str = "<!-- end of the known bugs -->\n";

/// Returns a row for each name in the JSON document, with the texts of its variants.
fn table() -> String {
    let mut rows: Vec<([String; 2], Vec<String>)> = vec![];
    for mistake in Mistake::all() {
        let json = serde_json::to_value(&mistake).expect("a value");
        let name = [mistake.kind(), json["name"].as_str().expect("a text")].map(str::to_owned);
        let text = mistake.to_string().trim_start().to_owned();
        match rows.iter_mut().find(|(other, _)| *other == name) {
            Some((_, texts)) => texts.push(text),
            None => rows.push((name, vec![text])),
        }
    }
    let mut table = "\n| Kind | Name | This program's picture |\n|---|---|---|\n".to_owned();
    for ([kind, name], texts) in rows {
        let others = if texts.len() > 1 { format!("; {} more", texts.len() - 1) } else { String::new() };
        let _ = writeln!(table, "| {kind} | `{name}` | {}{others} |", texts[0]);
    }
    table + "\n"
}

#[test]
fn the_known_bugs_are_listed() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/check-your-own.md");
    let page = std::fs::read_to_string(&path).expect("the page");
    let (before, rest) = page.split_once(START).expect("a mark before the table");
    let (shown, after) = rest.split_once(END).expect("a mark behind the table");
    let table = table();
    if std::env::var_os("BLESS").is_some_and(|value| value == "1") {
        return std::fs::write(&path, [before, START, &table, END, after].concat())
            .expect("the page is written");
    }
    assert!(shown == table, "the page should list\n{table}");
}
