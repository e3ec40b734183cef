//! The project's own scenes and their pictures.
//!
//! `reference_images/commands.txt` lists command lines in the course's style. The program is run on each of
//! them, and its pictures must be equal to those in `reference_images/`, byte for byte. If they differ, the
//! expected picture, the actual one and the difference are written side by side to
//! `target/picture-failures/`.
//!
//! If pictures are meant to change, `BLESS=1 cargo test --test pictures` overwrites the references; look at
//! them before committing.

mod adaptive;
mod standard_error;
mod commands;
mod compare;
mod invariance;
mod renderer;

use commands::{Command, references, scenes};
use raytracer::image_io;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use tempfile::tempdir;

/// Whether references are overwritten instead of compared.
fn blessing() -> bool {
    std::env::var_os("BLESS").is_some_and(|value| value == "1")
}

/// Compares a picture of a command with its reference. With `BLESS=1` the first picture of a name becomes the
/// reference, and another command with that name must still give the same picture.
fn check(made: &Path, name: &str, blessed: &mut BTreeSet<String>) -> Result<(), String> {
    let reference = references().join(name);
    if blessing() && blessed.insert(name.to_owned()) {
        fs::copy(made, &reference).map_err(|error| format!("{name}: {error}"))?;
        return Ok(());
    }
    compare::files(&reference, made, name)
}

#[test]
fn every_command_makes_its_reference_pictures() {
    let mut blessed = BTreeSet::new();
    let mut failures = Vec::new();
    for command in Command::all() {
        let folder = tempdir().unwrap();
        command.run(folder.path());
        for name in command.pictures() {
            if let Err(why) = check(&folder.path().join(name), name, &mut blessed) {
                failures.push(format!("{command}\n    {why}"));
            }
        }
    }
    assert!(failures.is_empty(), "{} pictures differ:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn every_reference_has_a_command_and_every_picture_a_reference() {
    if blessing() {
        return;
    }
    let commands = Command::all();
    let named: BTreeSet<_> = commands.iter().flat_map(Command::pictures).map(str::to_owned).collect();
    let entries = fs::read_dir(references()).unwrap();
    let mut found: BTreeSet<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    assert!(found.remove("commands.txt"));
    let unmatched: Vec<_> = found.symmetric_difference(&named).collect();
    assert!(unmatched.is_empty(), "only in the list or only in the folder: {unmatched:?}");
}

/// A picture of a single colour shows nothing: the camera misses the scene, or everything is black.
#[test]
fn no_reference_is_of_one_colour() {
    if blessing() {
        return;
    }
    let commands = Command::all();
    for name in commands.iter().flat_map(Command::pictures) {
        let picture = image_io::read_picture(&references().join(name)).unwrap();
        let mut pixels = picture.pixels().chunks_exact(3);
        let first = pixels.next();
        assert!(pixels.any(|pixel| Some(pixel) != first), "{name}");
    }
}

/// The scenes without a reference picture have a small one here, which must not be of one colour either.
#[test]
fn every_scene_shows_something() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("small.png");
    for scene in scenes() {
        let mut program = commands::program();
        program
            .args([
                "-input", &scene, "-edition", "2004", "-size", "24", "24", "-shadows", "-bounces", "0",
                "-output",
            ])
            .arg(&path);
        commands::succeed(program);
        let picture = image_io::read_picture(&path).unwrap();
        let colors: BTreeSet<_> = picture.pixels().chunks_exact(3).collect();
        assert!(colors.len() > 1, "{scene}");
    }
}

/// The course's program supports no comments and needs spaces around braces. The scenes comply with that, so
/// that they can be rendered with it for comparison.
#[test]
fn scenes_keep_to_the_course_s_strict_form() {
    for scene in scenes() {
        let text = fs::read_to_string(commands::scene_folder().join(&scene)).unwrap();
        for word in text.split_whitespace() {
            let joined_brace = word.len() > 1 && word.contains(['{', '}']);
            let comment = word.contains('#') || word.starts_with("//");
            assert!(!joined_brace && !comment && word.len() < 100, "{scene}: {word}");
        }
    }
}
