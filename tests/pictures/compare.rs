//! Compares picture files and shows where they differ.

use raytracer::image_io::{self, Format, OutputFile};
use raytracer::tools::compare::{Comparison, DifferencePicture};
use std::fs;
use std::path::{Path, PathBuf};

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
    let explain = || {
        let [expected, actual] = [image_io::read_picture(expected)?, image_io::read_picture(actual)?];
        let pixels = Comparison::new(&expected, &actual)?.pixels_that_differ();
        let (shown, _) = DifferencePicture::of_bytes(&expected, &actual)?;
        let path = failure_folder().join(Path::new(name).with_extension("png"));
        let _ = fs::create_dir_all(failure_folder());
        OutputFile::prepare(&path)?.picture(Format::Png, &shown)?.put_in_place()?;
        Ok(format!("{pixels} pixels differ; see {}", path.display()))
    };
    let found = explain().unwrap_or_else(|error: raytracer::diagnostic::Diagnostic| error.to_string());
    Err(format!("{name}: {found} (BLESS=1 replaces it)"))
}

#[test]
fn files_must_agree_in_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    for (name, byte) in [("a.ppm", b'd'), ("b.ppm", b'd'), ("c.ppm", b'e')] {
        fs::write(path(name), [b"P6\n1 1\n255\nab", &[byte][..]].concat()).unwrap();
    }
    assert_eq!(files(&path("a.ppm"), &path("b.ppm"), "self_test.tga"), Ok(()));
    let why = files(&path("a.ppm"), &path("c.ppm"), "self_test.tga").unwrap_err();
    assert!(why.starts_with("self_test.tga: 1 pixels differ"), "{why}");
    fs::remove_file(failure_folder().join("self_test.png")).unwrap();
    assert!(files(&path("none.ppm"), &path("a.ppm"), "none").unwrap_err().contains("BLESS=1"));
    assert!(files(&path("a.ppm"), &path("none.ppm"), "none").unwrap_err().contains("not written"));
}
