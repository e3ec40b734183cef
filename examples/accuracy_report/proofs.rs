//! The section on the machine-checked proofs.

use crate::Failure;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

const INTRO: &str = "
## Proofs

The error bounds that the decisions rest on are proved by a program, Gappa, which checks bounds of floating-point \
formulas. `proofs/run` checks them all, and a test compares the constants in the proofs with those in the source.

";

/// What each script proves, by its first line, and what Gappa says of it on this machine.
pub fn section() -> Result<String, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("proofs");
    let files = std::fs::read_dir(&folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut scripts: Vec<PathBuf> = files.collect::<Result<_, _>>()?;
    scripts.retain(|path| path.extension().is_some_and(|end| end == "g"));
    scripts.sort();
    let mut text = format!("{INTRO}| proof | of | checked |\n|---|---|---|\n");
    for script in scripts {
        let source = std::fs::read_to_string(&script)?;
        let claim =
            source.lines().next().unwrap_or_default().trim_start_matches('#').trim().replace('|', "\\|");
        let name = script.file_stem().unwrap_or_default().to_string_lossy();
        let _ = writeln!(text, "| `{name}` | {claim} | {} |", verdict(&script));
    }
    Ok(text)
}

fn verdict(script: &Path) -> &'static str {
    match Command::new("gappa").arg(script).output() {
        Ok(output) if output.status.success() => "proved",
        Ok(_) => "NOT PROVED",
        Err(_) => "not here: gappa is not installed",
    }
}
