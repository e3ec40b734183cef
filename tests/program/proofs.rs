//! The proofs in `proofs/` use the same constants as the source.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// The names and texts of the proofs.
fn scripts() -> Vec<(String, String)> {
    let entries =
        fs::read_dir(root().join("proofs")).expect("the proofs").map(|entry| entry.expect("a file"));
    let scripts = entries.filter(|entry| entry.path().extension().is_some_and(|end| end == "g"));
    let read = |path: PathBuf| fs::read_to_string(path).expect("a readable proof");
    scripts.map(|entry| (entry.file_name().to_string_lossy().into_owned(), read(entry.path()))).collect()
}

/// The value of a constant, as it is written in a Rust source.
fn constant_in<'t>(source: &'t str, name: &str) -> Option<&'t str> {
    let (_, rest) = source.split_once(&format!("const {name}: "))?;
    Some(rest.split_once(';')?.0.split_once("= ")?.1)
}

#[test]
fn every_constant_of_a_proof_is_the_one_of_the_source() {
    let scripts = scripts();
    assert!(!scripts.is_empty());
    for (name, text) in scripts {
        let ties: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("#@ ")).collect();
        assert!(!ties.is_empty(), "{name} names no constant of the source");
        for tie in ties {
            let (path, definition) = tie.split_once(' ').expect("a file and a definition");
            let (constant, value) = definition.split_once(" = ").expect("a name and a value");
            let source = fs::read_to_string(root().join(path)).expect("the source that a proof names");
            assert_eq!(constant_in(&source, constant), Some(value), "{name}: {tie}");
            assert!(text.contains(&format!("\n{constant} = {value};")), "{name} does not use {constant}");
        }
    }
}
