//! Compares picture files and shows where they differ.

use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{self, Format, OutputFile};
use raytracer::picture::Picture;
use std::fs;
use std::path::{Path, PathBuf};

/// The colour between pictures side by side, and around a smaller one.
const BACKDROP: [u8; 3] = [90, 90, 90];
/// The number of pixels between the pictures.
const GAP: u32 = 4;

/// The folder for pictures of failures: `target/picture-failures`, wherever `target` is.
fn failure_folder() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("picture-failures")
}

/// Checks that two files have equal bytes. The error describes how the pictures differ, and they are written
/// side by side.
pub fn files(expected: &Path, actual: &Path, name: &str) -> Result<(), String> {
    let made = fs::read(actual).map_err(|error| format!("{name}: not written: {error}"))?;
    if fs::read(expected).is_ok_and(|wanted| wanted == made) {
        return Ok(());
    }
    let read =
        |path| image_io::read_picture(path).map_err(|error| format!("{name}: {error} (BLESS=1 writes it)"));
    let (expected, actual) = (read(expected)?, read(actual)?);
    let shown = failure_folder().join(Path::new(name).with_extension("png"));
    show(&side_by_side(&expected, &actual), &shown)?;
    Err(format!("{name}: {}; see {}", describe(&expected, &actual), shown.display()))
}

fn show(picture: &Picture, path: &Path) -> Result<(), String> {
    fs::create_dir_all(failure_folder()).map_err(|error| error.to_string())?;
    write(path, picture).map_err(|error| error.to_string())
}

fn write(path: &Path, picture: &Picture) -> Result<(), Diagnostic> {
    let format = Format::of(path).expect("the name of a picture");
    OutputFile::prepare(path)?.picture(format, picture)?.put_in_place()
}

/// The difference of two pictures of the same size.
#[derive(Debug, PartialEq, Eq)]
struct Difference {
    /// The number of pixels that differ.
    pixels: usize,
    /// The largest difference of a channel.
    worst: u8,
    /// The pixel of that difference: its column and row from the top left, as in picture viewers.
    at: (usize, usize),
}

fn difference(expected: &Picture, actual: &Picture) -> Option<Difference> {
    let worst_of = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let pairs = expected.pixels().chunks_exact(3).zip(actual.pixels().chunks_exact(3));
    let worsts: Vec<u8> = pairs.map(worst_of).collect();
    let worst = worsts.iter().copied().max().filter(|&worst| worst > 0)?;
    let first = worsts.iter().position(|&found| found == worst)?;
    let width = expected.width() as usize;
    let pixels = worsts.iter().filter(|&&found| found > 0).count();
    Some(Difference { pixels, worst, at: (first % width, first / width) })
}

fn describe(expected: &Picture, actual: &Picture) -> String {
    let size = |picture: &Picture| (picture.width(), picture.height());
    if size(expected) != size(actual) {
        return format!("sizes differ: {:?} expected, {:?} made", size(expected), size(actual));
    }
    match difference(expected, actual) {
        Some(Difference { pixels, worst, at: (column, row) }) => format!(
            "{pixels} pixels differ, at worst by {worst}, at column {column}, row {row} from the top left"
        ),
        None => "the pixels are equal, the files are not".to_owned(),
    }
}

/// The expected picture, the actual one and the difference from left to right, aligned at the bottom left.
fn side_by_side(expected: &Picture, actual: &Picture) -> Picture {
    let width = expected.width().max(actual.width());
    let height = expected.height().max(actual.height());
    let step = width + GAP;
    let mut sheet = Picture::new(2 * step + width, height).unwrap();
    for j in 0..height {
        for (x, pixel) in sheet.row_mut(j as usize).chunks_exact_mut(3).enumerate() {
            let (panel, i) = (x as u32 / step, x as u32 % step);
            let (wanted, made) = (expected.get(i, j), actual.get(i, j));
            let color = match panel {
                0 => wanted,
                1 => made,
                _ => wanted.zip(made).map(|(a, b)| std::array::from_fn(|c| amplified(a[c], b[c]))),
            };
            pixel.copy_from_slice(&color.unwrap_or(BACKDROP));
        }
    }
    sheet
}

/// The brightness of a difference, which is visible even for a difference of one.
fn amplified(a: u8, b: u8) -> u8 {
    match a.abs_diff(b) {
        0 => 0,
        difference => difference.saturating_mul(16).saturating_add(64),
    }
}

mod tests {
    use super::*;

    /// A grey picture of 4 by 3 pixels, except for the pixel `at`, counted from the top left.
    fn grey_but(at: (usize, usize), color: [u8; 3]) -> Picture {
        let mut pixels = vec![100; 4 * 3 * 3];
        pixels[(at.1 * 4 + at.0) * 3..][..3].copy_from_slice(&color);
        Picture::from_rgb(4, 3, pixels)
    }

    #[test]
    fn difference_counts_pixels_and_finds_the_worst() {
        let one = grey_but((1, 2), [100, 97, 100]);
        let other = grey_but((3, 0), [100, 101, 110]);
        assert_eq!(difference(&one, &one), None);
        assert_eq!(difference(&one, &other), Some(Difference { pixels: 2, worst: 10, at: (3, 0) }));
    }

    #[test]
    fn side_by_side_shows_both_and_a_visible_difference() {
        let one = grey_but((0, 2), [100, 100, 101]);
        let sheet = side_by_side(&one, &grey_but((0, 0), [0; 3]));
        assert_eq!((sheet.width(), sheet.height()), (4 + 4 + 4 + 4 + 4, 3));
        assert_eq!(sheet.get(0, 0), Some([100, 100, 101]));
        assert_eq!(sheet.get(4, 0), Some(BACKDROP));
        assert_eq!(sheet.get(8, 2), Some([0; 3]));
        assert_eq!(sheet.get(16, 0), Some([0, 0, 80]));
        assert_eq!(sheet.get(16, 2), Some([255; 3]));
        assert_eq!(sheet.get(17, 1), Some([0; 3]));
    }

    #[test]
    fn files_must_agree_in_every_byte() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let save = |name: &str, picture: &Picture| {
            write(&path(name), picture).unwrap();
        };
        let picture = grey_but((0, 0), [1, 2, 3]);
        save("a.tga", &picture);
        save("b.tga", &picture);
        save("c.tga", &grey_but((2, 1), [100, 100, 99]));
        assert_eq!(files(&path("a.tga"), &path("b.tga"), "self_test.tga"), Ok(()));
        let why = files(&path("a.tga"), &path("c.tga"), "self_test.tga").unwrap_err();
        let expected = "self_test.tga: 2 pixels differ, at worst by 99, at column 0, row 0 from the top left";
        assert!(why.starts_with(expected), "{why}");
        let shown = failure_folder().join("self_test.png");
        assert_eq!(image_io::read_picture(&shown).unwrap().width(), 20);
        fs::remove_file(shown).unwrap();
        assert!(files(&path("none.tga"), &path("a.tga"), "none.tga").unwrap_err().contains("BLESS=1"));
        assert!(files(&path("a.tga"), &path("none.tga"), "none.tga").unwrap_err().contains("not written"));
    }
}
