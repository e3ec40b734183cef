//! Writes `docs/accuracy.md` and its pictures from the records of the hard cases.
//!
//! The argument is the folder of the records: `ACCURACY_DIR` of the test run that measured them.

mod acne;
mod edge_map;
mod table;

use raytracer::image_io::OutputFile;
use raytracer::picture::Picture;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let Some(records) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: accuracy_report <folder of the records>");
        return ExitCode::FAILURE;
    };
    match write_report(&records) {
        Ok(missing) => {
            println!("docs/accuracy.md is written; {missing} cases have no record");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Writes the document, and returns how many cases have no record.
fn write_report(records: &Path) -> Result<usize, Box<dyn std::error::Error>> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    std::fs::create_dir_all(&docs)?;
    let map = edge_map::draw();
    let acne = acne::draw()?;
    for (name, picture) in [("edge_map.png", &map.picture), ("acne.png", &acne.picture)] {
        write_picture(&docs.join(name), picture)?;
    }
    let table = table::read(records)?;
    std::fs::write(docs.join("accuracy.md"), table.document(&map.caption, &acne.caption))?;
    Ok(table.missing().len())
}

fn write_picture(path: &Path, picture: &Picture) -> Result<(), Box<dyn std::error::Error>> {
    Ok(OutputFile::prepare(path)?.write(picture)?)
}

/// A picture with what was counted in it.
struct Figure {
    picture: Picture,
    caption: String,
}

/// Panels side by side, each a square of so many pixels, in rows from the top; `color` gives the
/// colour of a pixel of a panel, counted from the panel's top left.
fn panels(rows: usize, columns: usize, side: usize, color: impl Fn(usize, [usize; 2]) -> [u8; 3]) -> Picture {
    const GAP: usize = 8;
    let (width, height) = (columns * (side + GAP) - GAP, rows * (side + GAP) - GAP);
    let mut pixels = vec![255; width * height * 3];
    for (i, pixel) in pixels.chunks_exact_mut(3).enumerate() {
        let (x, y) = (i % width, i / width);
        let (column, row) = (x / (side + GAP), y / (side + GAP));
        let place = [x % (side + GAP), y % (side + GAP)];
        if place[0] < side && place[1] < side {
            pixel.copy_from_slice(&color(row * columns + column, place));
        }
    }
    Picture::from_rgb(width as u32, height as u32, pixels)
}
