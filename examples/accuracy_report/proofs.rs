//! The table of the machine-checked proofs.

use crate::Failure;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The table of the scripts: what each of them proves, which is its first line, and whether Gappa confirms it
/// on this machine.
pub fn table() -> Result<String, Failure> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("proofs");
    let files = std::fs::read_dir(&folder)?.map(|entry| entry.map(|entry| entry.path()));
    let mut scripts: Vec<PathBuf> = files.collect::<Result<_, _>>()?;
    scripts.retain(|path| path.extension().is_some_and(|end| end == "g"));
    scripts.sort();
    let mut text = "| proof | of | checked |\n|---|---|---|\n".to_owned();
    for script in scripts {
        let source = std::fs::read_to_string(&script)?;
        let claim =
            source.lines().next().unwrap_or_default().trim_start_matches('#').trim().replace('|', "\\|");
        let name = script.file_stem().unwrap_or_default().to_string_lossy();
        let _ = writeln!(text, "| `{name}` | {claim} | {} |", verdict(&source)?);
    }
    Ok(text)
}

/// Whether Gappa confirms a script. It would interpret the lines that tie constants to the source as options,
/// so that their mark is removed, as in `proofs/run`.
fn verdict(source: &str) -> Result<&'static str, Failure> {
    let gappa =
        Command::new("gappa").stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let Ok(mut gappa) = gappa else { return Ok("not here: gappa is not installed") };
    if let Some(mut input) = gappa.stdin.take() {
        input.write_all(source.replace("\n#@", "\n#").as_bytes())?;
    }
    Ok(if gappa.wait()?.success() { "proved" } else { "NOT PROVED" })
}
