//! The README says what the program does.

use crate::support::Folder;
use raytracer::cli::{self, Command};
use raytracer::grid::resolution::Resolution;
use std::ffi::OsString;
use std::path::Path;

const README: &str = include_str!("../../README.md");

/// The lines of the README that are commands.
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
fn the_first_command_is_accepted_and_its_scene_exists() {
    let line =
        commands().find_map(|line| line.strip_prefix("run --release -- ")).expect("a command to render");
    let words = ["raytracer"].into_iter().chain(line.split_whitespace()).map(OsString::from);
    let Ok(Command::Render(options)) = cli::parse(words) else { panic!("{line}") };
    assert!(Path::new(env!("CARGO_MANIFEST_DIR")).join(&options.input).is_file(), "{line}");
    assert!(options.stats && options.grid == Some(Resolution::Cells([10; 3])));
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
