//! Measures the hard cases and writes their tables and pictures into `docs/accuracy.md`.
//!
//! `cargo run --release --example accuracy_report` runs the ordinary tier. `HARD_CASES=long`, or a number
//! such as `HARD_CASES=1000000`, selects another tier for all rows.

mod acne;
mod edge_map;
mod proofs;
mod table;

use raytracer::image_io::{Format, OutputFile};
use raytracer::picture::Picture;
use std::path::Path;
use std::process::{Command, ExitCode};

type Failure = Box<dyn std::error::Error>;

fn main() -> ExitCode {
    match write_report() {
        Ok(()) => {
            println!("docs/accuracy.md is written");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn write_report() -> Result<(), Failure> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    let records = measured()?;
    let map = edge_map::draw();
    let acne = acne::draw()?;
    for (name, picture) in [("edge_map.png", &map.picture), ("acne.png", &acne.picture)] {
        OutputFile::prepare(&docs.join(name))?.picture(Format::Png, picture)?.put_in_place()?;
    }
    let table = table::read(records.path())?;
    let origin = table::Origin { commit: commit()?, tier: std::env::var("HARD_CASES").ok() };
    let page = docs.join("accuracy.md");
    let text = std::fs::read_to_string(&page)?;
    let text = replaced(&text, "cases", &table.sections(&origin, &map.caption, &acne.caption)?)?;
    std::fs::write(page, replaced(&text, "proofs", &proofs::table()?)?)?;
    Ok(())
}

/// The page with another text between its marks of this name.
fn replaced(page: &str, name: &str, text: &str) -> Result<String, Failure> {
    let (start, end) = (format!("<!-- {name} -->\n"), format!("<!-- end of {name} -->\n"));
    let parts = page.split_once(&start).zip(page.split_once(&end));
    let ((before, _), (_, after)) = parts.ok_or_else(|| format!("the page lacks the marks of {name}"))?;
    Ok([before, &start, "\n", text, "\n", &end, after].concat())
}

/// Runs every hard case once, and returns the folder of their records.
fn measured() -> Result<tempfile::TempDir, Failure> {
    let folder = tempfile::tempdir()?;
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(["test", "--test", "hard_cases"]).env("ACCURACY_DIR", folder.path());
    let status = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).status()?;
    if status.success() {
        Ok(folder)
    } else {
        Err("a hard case failed, so that there is nothing to report".into())
    }
}

/// The commit that is measured, and whether there are uncommitted changes.
fn commit() -> Result<String, Failure> {
    let git = |words: &[&str]| -> Result<String, Failure> {
        let output = Command::new("git").args(words).current_dir(env!("CARGO_MANIFEST_DIR")).output()?;
        Ok(String::from_utf8(output.stdout)?.trim().to_owned())
    };
    let sources = ["status", "--porcelain", "--untracked-files=no", "src", "tests", "proofs", "Cargo.toml"];
    let changed = if git(&sources)?.is_empty() { "" } else { ", with changes that are not committed" };
    Ok(format!("{}{changed}", git(&["rev-parse", "--short", "HEAD"])?))
}

/// A picture with its caption.
struct Figure {
    picture: Picture,
    caption: String,
}

/// A picture of square panels in rows from the top. `color` returns the colour of a pixel of a panel, counted
/// from the panel's top left corner.
fn panels(rows: usize, columns: usize, side: usize, color: impl Fn(usize, [usize; 2]) -> [u8; 3]) -> Picture {
    const GAP: usize = 8;
    let (width, height) = (columns * (side + GAP) - GAP, rows * (side + GAP) - GAP);
    let mut pixels = vec![255; width * height * 3];
    for (i, pixel) in pixels.chunks_exact_mut(3).enumerate() {
        let (x, y) = (i % width, i / width);
        let (column, row) = (x / (side + GAP), y / (side + GAP));
        let pixel_of_panel = [x % (side + GAP), y % (side + GAP)];
        if pixel_of_panel[0] < side && pixel_of_panel[1] < side {
            pixel.copy_from_slice(&color(row * columns + column, pixel_of_panel));
        }
    }
    Picture::from_rgb(width as u32, height as u32, pixels)
}
