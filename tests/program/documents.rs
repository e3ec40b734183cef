//! The commands of all documents run in the order of each document, print what it shows and draw its pictures.
//!
//! The working directory looks like the project's folder. A block under a comment that starts with `<!-- Not run by the
//! tests:` is left out, and `NOT_RUN_BLOCKS` counts these. A block whose fence names a file becomes that file.

use crate::markdown::{Block, Command, anchor, blocks, links};
use crate::support::{Folder, finish, skip};
use raytracer::image_io::read_picture;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process;

/// How many blocks of a document are not run.
const NOT_RUN_BLOCKS: &[(&str, usize)] = &[
    ("README.md", 2),
    ("CONTRIBUTING.md", 2),
    ("docs/accuracy.md", 2),
    ("docs/guide.md", 4),
    ("docs/install.md", 7),
    ("docs/live.md", 3),
];

/// Pictures that examples draw instead of commands.
const DRAWN_BY_EXAMPLES: &[&str] = &["acne.png", "edge_map.png"];

/// A plot that `front_plot.rs` compares with its table.
const PLOT: &str = "front.svg";

/// Pictures that `tests/browser/live.py` takes of the page.
const TAKEN_IN_BROWSER: &[&str] = &["turned.png", "rays.png", "error.png", "comparison.png", "pixels.png"];

/// Programs that not every machine has. Without one, the rest of its block is skipped.
const OPTIONAL: &[&str] = &["python3"];

/// Commands that were run before this test, or are running it.
const DONE: &[&str] = &["cargo build --release", "cargo test"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The names of all documents, from the project's folder.
fn documents() -> Vec<String> {
    let mut names = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(str::to_owned).to_vec();
    let entries = fs::read_dir(root().join("docs")).expect("documents").flatten();
    let docs = entries.map(|entry| format!("docs/{}", entry.file_name().to_string_lossy()));
    names.extend(docs.filter(|name| name.ends_with(".md")));
    names.sort();
    names
}

fn read(document: &str) -> String {
    fs::read_to_string(root().join(document)).unwrap_or_else(|error| panic!("{document}: {error}"))
}

/// Whether the lines are those that are shown, where `...` stands for any lines.
fn matches(shown: &[String], lines: &[&str]) -> bool {
    match shown {
        [] => lines.is_empty(),
        [dots, rest @ ..] if dots == "..." => {
            (0..=lines.len()).any(|skipped| matches(rest, &lines[skipped..]))
        }
        [first, rest @ ..] => lines.first() == Some(&first.as_str()) && matches(rest, &lines[1..]),
    }
}

/// A folder with what a reader has: the project's scenes, documents and pictures. Other files come from the commands.
fn folder() -> Folder {
    let folder = Folder::new();
    for name in ["scenes", "docs", "reference_images"] {
        symlink(root().join(name), folder.path().join(name)).expect("a link");
    }
    folder
}

/// Runs a line of a document in a shell that finds this program.
fn run(folder: &Folder, line: &str) -> crate::support::Run {
    let line = line
        .replace("cargo run --release -- ", "raytracer ")
        .replace("target/release/raytracer ", "raytracer ");
    assert!(!line.starts_with("cargo "), "`{line}` needs a line that says why it is not run");
    let program = Path::new(env!("CARGO_BIN_EXE_raytracer")).parent().expect("a folder").as_os_str();
    let mut paths = program.to_os_string();
    paths.push(":");
    paths.push(std::env::var_os("PATH").unwrap_or_default());
    let mut shell = process::Command::new("sh");
    shell.arg("-c").arg(&line).env("PATH", paths).current_dir(folder.path()).stdin(process::Stdio::null());
    finish(&mut shell)
}

/// The warnings and notes of a run that a document does not mention, not even one of their clauses.
fn unexplained<'a>(said: &'a str, text: &str) -> Vec<&'a str> {
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let text = words(text);
    let messages = said.lines().filter_map(|line| {
        line.split_once("warning: ").or(line.split_once("note: ")).map(|(_, message)| message)
    });
    messages.filter(|message| !message.split(", ").any(|clause| text.contains(&words(clause)))).collect()
}

/// Runs the commands of a block, or writes the file that it shows.
fn follow(folder: &Folder, document: &str, text: &str, block: &Block) -> usize {
    if let Some((_, name)) = block.info.split_once(' ') {
        folder.write(name, block.lines.join("\n") + "\n");
        return 0;
    }
    let commands = block.commands();
    for Command { line, shown } in commands.iter().filter(|command| !DONE.contains(&command.line.as_str())) {
        let said = run(folder, line);
        let program = line.split(' ').next().expect("a word");
        if said.status == Some(127) && OPTIONAL.contains(&program) {
            skip(&format!("{program} is not installed"));
            break;
        }
        assert_eq!(said.status, Some(0), "{document}: {line}\n{}", said.stderr);
        assert_eq!(unexplained(&said.stderr, text), [""; 0], "{document}: {line}");
        if let Some(shown) = shown {
            let lines: Vec<&str> = said.stdout.lines().collect();
            let same = matches(shown, &lines);
            assert!(same, "{document}: {line} prints\n{}instead of\n{}", said.stdout, shown.join("\n"));
        }
    }
    commands.len()
}

/// Compares the document's pictures with those of its commands.
fn compare_pictures(folder: &Folder, document: &str, text: &str) {
    let place: PathBuf = root().join(document).parent().expect("a folder").into();
    for (link, _) in links(text).into_iter().filter(|&(_, is_picture)| is_picture) {
        let name = Path::new(link).file_name().expect("a name").to_str().expect("a text");
        let made = folder.path().join(name);
        if DRAWN_BY_EXAMPLES.contains(&name) || TAKEN_IN_BROWSER.contains(&name) || name == PLOT {
            continue;
        }
        assert!(made.exists(), "{document}: no command writes {name}");
        let [shown, made] = [place.join(link), made].map(|path| read_picture(&path).expect("a picture"));
        assert!(shown == made, "{document}: {link} is not what its command draws");
    }
}

#[test]
fn every_command_of_the_readme_does_what_it_shows() {
    assert!(follow_all(vec!["README.md".into()]) > 2);
}

#[test]
#[ignore = "slow: a minute and a half"]
fn every_command_of_every_document_does_what_it_shows() {
    let commands = follow_all(documents());
    assert!(commands > 50, "{commands}");
}

/// Follows these documents. Returns the number of their commands.
fn follow_all(documents: Vec<String>) -> usize {
    let mut commands = 0;
    for document in documents {
        let text = read(&document);
        let (left_out, run): (Vec<_>, Vec<_>) = blocks(&text).into_iter().partition(|block| block.is_not_run);
        let expected =
            NOT_RUN_BLOCKS.iter().find(|(name, _)| *name == document).map_or(0, |&(_, count)| count);
        assert_eq!(left_out.len(), expected, "{document}: blocks that are not run");
        let folder = folder();
        commands += run.iter().map(|block| follow(&folder, &document, &text, block)).sum::<usize>();
        compare_pictures(&folder, &document, &text);
    }
    commands
}

#[test]
fn no_paragraph_is_long() {
    const MOST_WORDS: usize = 80;
    for document in documents().iter().filter(|name| *name != "CHANGELOG.md") {
        let text = read(document);
        // Lines of code and tables, and headings, are no paragraphs. Each item of a list is one.
        let code: Vec<&str> =
            blocks(&text).into_iter().flat_map(|block| block.lines).map(str::trim).collect();
        let is_item = |line: &str| line.starts_with("* ") || line.starts_with(|c: char| c.is_ascii_digit());
        let mut words = 0;
        for line in text.lines() {
            let is_none = line.is_empty() || line.starts_with(['|', '#', '`']) || code.contains(&line.trim());
            words = if is_none || is_item(line) { 0 } else { words };
            words += if is_none { 0 } else { line.split_whitespace().count() };
            assert!(words <= MOST_WORDS, "{document}: the paragraph is too long at: {line}");
        }
    }
}

/// Files that a document names by their path, such as `src/scene/lexer.rs`.
fn named_files(text: &str) -> impl Iterator<Item = &str> {
    const FOLDERS: [&str; 8] =
        ["src/", "tests/", "examples/", "fuzz/", "benches/", "scenes/", "templates/", "proofs/"];
    let quoted = text.split('`').skip(1).step_by(2);
    quoted.filter(|name| FOLDERS.iter().any(|folder| name.starts_with(folder)) && !name.contains(' '))
}

#[test]
fn every_named_file_exists() {
    for document in documents().iter().filter(|name| *name != "CHANGELOG.md") {
        let text = read(document);
        let missing: Vec<_> = named_files(&text).filter(|name| !root().join(name).exists()).collect();
        assert!(missing.is_empty(), "{document}: {missing:?}");
    }
}

#[test]
fn every_link_leads_somewhere() {
    for document in documents() {
        let text = read(&document);
        let place: PathBuf = root().join(&document).parent().expect("a folder").into();
        for (link, _) in links(&text).into_iter().filter(|(link, _)| !link.starts_with("https://")) {
            let (file, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { root().join(&document) } else { place.join(file) };
            assert!(target.is_file(), "{document}: {link}");
            let headings = fs::read_to_string(&target).unwrap_or_default();
            let found = headings
                .lines()
                .any(|line| line.starts_with('#') && anchor(line.trim_start_matches('#').trim()) == heading);
            assert!(heading.is_empty() || found, "{document}: {link}");
        }
    }
}

#[test]
fn every_document_is_linked_to_from_the_readme() {
    let text = read("README.md");
    for document in documents().iter().filter(|name| *name != "README.md") {
        assert!(links(&text).iter().any(|(link, _)| link == document), "{document}");
    }
}
