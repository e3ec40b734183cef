//! The table of flags and the README agree with the program.

use crate::support::Folder;

const TABLE: &str = include_str!("../../docs/flags.md");
const README: &str = include_str!("../../README.md");

#[test]
fn every_flag_of_the_help_stands_in_the_table() {
    let help = Folder::new().run("-help").ok().stdout;
    let flags: Vec<&str> =
        help.lines().filter_map(|line| line.strip_prefix("  -")?.split_whitespace().next()).collect();
    assert!(flags.len() > 20, "{flags:?}");
    let has_row = |flag: &str| {
        TABLE.lines().any(|line| line.starts_with("| `-") && line[4..].split(['`', ' ']).next() == Some(flag))
    };
    let lacking: Vec<_> = flags.iter().filter(|flag| !has_row(flag)).collect();
    assert!(lacking.is_empty(), "{lacking:?}");
    let rows = TABLE.lines().filter(|line| line.starts_with("| `-")).count();
    assert_eq!(rows, flags.len(), "a flag that is none, or twice");
}

#[test]
fn the_test_command_is_the_one_that_ci_runs() {
    let ci = include_str!("../../.ci/run");
    let mut commands = README.lines().filter_map(|line| line.strip_prefix("    cargo "));
    let test = commands.find(|line| line.starts_with("test")).expect("a command to test");
    assert!(ci.lines().any(|line| line.strip_prefix("step tests cargo ") == Some(test)), "{test}");
}
