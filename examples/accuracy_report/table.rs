//! The table of the hard cases' records.

use crate::Failure;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// The sections of the table: the titles and the numbers of the cases.
const SECTIONS: [(&str, std::ops::RangeInclusive<u32>); 7] = [
    ("Triangles: watertightness and decisions", 1..=20),
    ("Grid", 21..=32),
    ("Spheres and planes", 33..=39),
    ("Secondary rays", 40..=46),
    ("Transforms and invariance of the scene", 47..=52),
    ("Shading, textures, output", 53..=64),
    ("Exact coincidences", 65..=72),
];

const HEAD: &str = "| | case | ours | textbook |\n|---:|---|---|---|\n";

const DETAILS_HEAD: &str = "| | basis | inputs | measured | target |\n|---:|---|---|---|---|\n";

/// The origin of the measurements.
pub struct Origin {
    pub commit: String,
    /// The value of `HARD_CASES`; none for the ordinary tier.
    pub tier: Option<String>,
}

/// The number of fields of a record after the number of its case.
const FIELDS: usize = 7;

/// The records by the number of their case. The fields are basis, name, inputs, measure, textbook, ours and
/// target.
pub struct Table(BTreeMap<u32, [String; FIELDS]>);

/// Reads every record in a folder.
pub fn read(folder: &Path) -> Result<Table, Failure> {
    let mut records = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let text = std::fs::read_to_string(entry?.path())?;
        let mut fields = text.trim_end().split('\t').map(String::from);
        let case = fields.next().unwrap_or_default().parse()?;
        let rest: Vec<String> = fields.collect();
        let rest = rest.try_into().map_err(|_| format!("the record of case {case} has other fields"))?;
        records.insert(case, rest);
    }
    Ok(Table(records))
}

impl Table {
    /// The sections of all cases. A case without a record is an error.
    pub fn sections(&self, origin: &Origin, edge_map: &str, acne: &str) -> Result<String, Failure> {
        let mut text = sentence(origin, self.0.len()) + "\n";
        let mut details = format!("\n### Inputs and targets\n\n{DETAILS_HEAD}");
        for (title, cases) in &SECTIONS {
            let _ = write!(text, "\n### {title}\n\n{HEAD}");
            for case in cases.clone() {
                let fields = self.0.get(&case).ok_or_else(|| format!("case {case} has no record"))?;
                // Bars would end a column.
                let [basis, name, inputs, measure, textbook, ours, target] =
                    fields.each_ref().map(|field| field.replace('|', "\\|"));
                let _ = writeln!(text, "| {case} | {name} | **{ours}** | {textbook} |");
                let _ = writeln!(details, "| {case} | {basis} | {inputs} | {measure} | {target} |");
            }
            match cases.start() {
                1 => text += &format!("\n![The decision at an edge](edge_map.png)\n\n{edge_map}\n"),
                40 => text += &format!("\n![Shadows at three scales](acne.png)\n\n{acne}\n"),
                _ => {}
            }
        }
        Ok(text + &details)
    }
}

/// The sentence about the origin of the measurements.
fn sentence(Origin { commit, tier }: &Origin, rows: usize) -> String {
    let inputs = match tier.as_deref() {
        None => "the usual number of inputs".to_owned(),
        Some("long") => "`HARD_CASES=long`".to_owned(),
        Some(limit) => format!("at most {limit} inputs per case"),
    };
    format!("All {rows} rows were measured together, with {inputs}, at commit {commit}.")
}
