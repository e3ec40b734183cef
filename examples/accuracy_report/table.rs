//! The records of the hard cases as a document.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::io;
use std::path::Path;

/// The sections of the hard cases: what they are about and the numbers of their cases.
const SECTIONS: [(&str, std::ops::RangeInclusive<u32>); 6] = [
    ("Triangles: watertightness and decisions", 1..=20),
    ("Grid", 21..=32),
    ("Spheres and planes", 33..=39),
    ("Secondary rays", 40..=46),
    ("Transforms and invariance of the scene", 47..=52),
    ("Shading, textures, output", 53..=64),
];

const INTRO: &str = "\
# Accuracy

A ray tracer decides, millions of times a picture, whether a ray meets a surface, on which side of an \
edge it passes, and what stands in the way of the light. Where rounding decides wrongly, the picture shows \
it: holes between triangles, speckles in the shade, shadows that vanish, textures that flicker. Such errors \
hide in ordinary scenes and come out in small, large or far-away ones.

So the hard cases are tested one by one, against an oracle that does not round: exact rational arithmetic, \
arithmetic with twice the digits, closed forms, brute force, or a second render that must be identical. \
Beside the program, the textbook's method runs on the same input. It must fail there; a case in which it \
does not would test nothing.

The numbers below are measured, not claimed. This file and its pictures are written by a program:

```
mkdir -p target/accuracy
ACCURACY_DIR=target/accuracy cargo test --test hard_cases
cargo run --release --example accuracy_report -- target/accuracy
```

`HARD_CASES=long` before the second command takes a hundred times as many inputs. A rounding is 2^-53 of the \
number's size; an ulp32 is the distance of neighbouring 32-bit floats. The sources of the cases are in \
`tests/hard_cases`.
";

const HEAD: &str = "| | case | measured | textbook | ours | target |\n|---|---|---|---|---|---|\n";

/// The fields of each record by the number of its case: name, inputs, measure, textbook, ours, target.
pub struct Table(BTreeMap<u32, Vec<String>>);

/// Reads every record in a folder.
pub fn read(folder: &Path) -> io::Result<Table> {
    let mut records = BTreeMap::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|e| e == "tsv") {
            for line in std::fs::read_to_string(path)?.lines() {
                let mut fields = line.split('\t').map(String::from);
                let number = fields.next().and_then(|n| n.parse().ok());
                records.extend(number.map(|n| (n, fields.collect())));
            }
        }
    }
    Ok(Table(records))
}

impl Table {
    /// The numbers of the cases without a record.
    pub fn missing(&self) -> Vec<u32> {
        SECTIONS.iter().flat_map(|(_, cases)| cases.clone()).filter(|n| !self.0.contains_key(n)).collect()
    }

    pub fn document(&self, edge_map: &str, acne: &str) -> String {
        let mut text = INTRO.to_string();
        for (title, cases) in &SECTIONS {
            let _ = writeln!(text, "\n## {title}\n");
            let rows: String = cases.clone().filter_map(|n| Some(row(n, self.0.get(&n)?))).collect();
            text += if rows.is_empty() { "Not measured.\n" } else { HEAD };
            text += &rows;
            self.picture_of(title, edge_map, acne, &mut text);
        }
        let missing: Vec<String> = self.missing().iter().map(u32::to_string).collect();
        if !missing.is_empty() {
            let _ = writeln!(text, "\n## Missing\n\nNo record of the cases {}.", missing.join(", "));
        }
        text
    }

    fn picture_of(&self, title: &str, edge_map: &str, acne: &str, text: &mut String) {
        let figure = match title {
            _ if title.starts_with("Triangles") => {
                Some(("edge_map.png", "The decision at an edge", edge_map))
            }
            _ if title.starts_with("Secondary") => Some(("acne.png", "Shadows at three scales", acne)),
            _ => None,
        };
        if let Some((file, name, caption)) = figure {
            let _ = write!(text, "\n![{name}]({file})\n\n{caption}\n");
        }
    }
}

/// A row of the table. Bars would end a column.
fn row(number: u32, fields: &[String]) -> String {
    let field = |i: usize| fields.get(i).map_or(String::new(), |f| f.replace('|', "\\|"));
    let case = format!("{}: {}", field(0), field(1));
    format!("| {number} | {case} | {} | {} | **{}** | {} |\n", field(2), field(3), field(4), field(5))
}
