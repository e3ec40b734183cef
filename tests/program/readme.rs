//! The README agrees with the program.

use crate::support::{Folder, finish, program};
use raytracer::image_io;
use std::ffi::OsString;
use std::path::Path;

const README: &str = include_str!("../../README.md");

/// The lines of the README that call the program.
fn commands() -> impl Iterator<Item = &'static str> {
    README.lines().filter_map(|line| line.strip_prefix("    cargo "))
}

#[test]
fn every_flag_of_the_help_stands_in_the_table() {
    let help = Folder::new().run("-help").ok().stdout;
    let flags: Vec<&str> =
        help.lines().filter_map(|line| line.strip_prefix("  -")?.split_whitespace().next()).collect();
    assert!(flags.len() > 20, "{flags:?}");
    let lacking: Vec<_> =
        flags.iter().filter(|flag| !README.contains(&format!("\n| `-{flag}` | "))).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    let rows = README.lines().filter(|line| line.starts_with("| `-")).count();
    assert_eq!(rows, flags.len(), "a flag that is none, or twice");
}

#[test]
fn the_first_command_renders_the_front_picture() {
    let line =
        commands().find_map(|line| line.strip_prefix("run --release -- ")).expect("a command to render");
    let (_, after) = README.split_once("![").expect("a front picture");
    let front = after.split_once("](").and_then(|(_, link)| link.split_once(')')).expect("a link to it").0;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let folder = Folder::new();
    // The scene's path is relative to the project's folder, and the picture is written to the working
    // directory.
    let full =
        |word: &str| if word.starts_with("scenes/") { root.join(word).into() } else { OsString::from(word) };
    finish(&mut program(folder.path(), line.split_whitespace().map(full))).ok();
    let made = line.split_whitespace().find(|word| word.ends_with(".png")).expect("a picture");
    let [expected, actual] = [root.join(front), folder.path().join(made)]
        .map(|path| image_io::read_picture(&path).expect("a picture"));
    assert!(expected == actual, "{front} is not what `{line}` renders");
}

#[test]
fn the_pixel_is_explained_as_it_says() {
    let (_, after) = README.split_once("    raytracer -input scenes/").expect("a command");
    let (line, after) = after.split_once('\n').expect("more lines");
    let words = line.split_whitespace().skip(1).map(OsString::from);
    let scene =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(line.split(' ').next().expect("a name"));
    let folder = Folder::new();
    let all = ["-input".into(), scene.into_os_string()].into_iter().chain(words);
    let said = finish(&mut program(folder.path(), all)).ok().stdout;
    let shown: Vec<&str> = after.lines().skip(1).map_while(|line| line.strip_prefix("    ")).collect();
    assert_eq!(said.lines().collect::<Vec<_>>(), shown);
}

#[test]
fn the_test_command_is_the_one_that_ci_runs() {
    let ci = include_str!("../../.ci/run");
    let test = commands().find(|line| line.starts_with("test")).expect("a command to test");
    assert!(ci.lines().any(|line| line.strip_prefix("cargo ") == Some(test)), "{test}");
}

#[test]
fn every_file_that_it_links_to_exists() {
    let links = README.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let lacking: Vec<_> =
        links.filter(|link| !Path::new(env!("CARGO_MANIFEST_DIR")).join(link).is_file()).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
}
