//! The page `docs/check-your-own.md`: its commands run in the order of the page, and print what it shows.

use crate::support::{Folder, finish, program};
use raytracer::image_io::read_picture;
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/check-your-own.md");

/// A command of the page, and the lines that it is said to print.
struct Step {
    /// The program's words, or those of `mkdir`.
    line: &'static str,
    shown: Vec<&'static str>,
}

fn steps() -> Vec<Step> {
    let blocks = PAGE.split("```console\n").skip(1).filter_map(|rest| rest.split("```").next());
    let mut steps: Vec<Step> = vec![];
    for line in blocks.flat_map(str::lines) {
        match (line.strip_prefix("$ "), steps.last_mut()) {
            (Some(line), _) => steps.push(Step { line, shown: vec![] }),
            (None, Some(step)) => step.shown.push(line),
            (None, None) => panic!("`{line}` stands before every command"),
        }
    }
    steps
}

/// Whether the lines are those that are shown, where `...` stands for any lines.
fn matches(shown: &[&str], lines: &[&str]) -> bool {
    match shown {
        [] => lines.is_empty(),
        ["...", rest @ ..] => (0..=lines.len()).any(|skipped| matches(rest, &lines[skipped..])),
        [first, rest @ ..] => lines.first() == Some(first) && matches(rest, &lines[1..]),
    }
}

/// A folder with the files of the page where its commands look for them.
fn folder() -> Folder {
    let folder = Folder::new();
    let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/check-your-own");
    fs::create_dir_all(folder.path().join("docs/check-your-own")).expect("a folder");
    for entry in fs::read_dir(&files).expect("the page's files") {
        let name = entry.expect("a file").file_name();
        let copy: PathBuf = folder.path().join("docs/check-your-own").join(&name);
        fs::copy(files.join(&name), copy).expect("a copy");
    }
    folder
}

/// What `mkdir -p` does.
fn make_folders(place: &Path, line: &str) {
    let names =
        line.strip_prefix("mkdir -p ").unwrap_or_else(|| panic!("`{line}` is no command of the page"));
    names.split_whitespace().for_each(|name| fs::create_dir_all(place.join(name)).expect("a folder"));
}

#[test]
fn every_command_prints_what_the_page_shows() {
    let (folder, steps) = (folder(), steps());
    assert!(steps.len() >= 8, "{}", steps.len());
    for Step { line, shown } in &steps {
        let Some(words) = line.strip_prefix("raytracer ") else {
            make_folders(folder.path(), line);
            continue;
        };
        let said = finish(&mut program(folder.path(), words.split_whitespace())).ok().stdout;
        let lines: Vec<&str> = said.lines().collect();
        assert!(matches(shown, &lines), "{line} prints\n{said}\ninstead of\n{}", shown.join("\n"));
        if let Some((_, name)) = line.split_once("-difference ") {
            let [shown, made] = ["docs/check-your-own", ""]
                .map(|place| read_picture(&folder.path().join(place).join(name)).expect("a picture"));
            assert!(shown == made, "{name} is not what {line} draws");
        }
    }
}

#[test]
fn the_line_that_the_page_ends_at_explains_the_difference() {
    let line = |text: &'static str, number: usize| text.lines().nth(number - 1).expect("a line");
    let (scene, misread) = (
        include_str!("../../docs/check-your-own/scene.txt"),
        include_str!("../../docs/check-your-own/misread.txt"),
    );
    let (_, after) = PAGE.split_once("`material 0 in line ").expect("a line is named");
    let named: usize = after.split('`').next().and_then(|number| number.parse().ok()).expect("a number");
    assert!(line(scene, named).contains("PhongMaterial"));
    let differing: Vec<usize> =
        (1..=scene.lines().count()).filter(|&n| line(scene, n) != line(misread, n)).collect();
    let [exponent] = differing[..] else { panic!("{differing:?}") };
    assert!((named..named + 5).contains(&exponent));
    assert_eq!([scene, misread].map(|text| line(text, exponent).trim()), ["exponent 40", "exponent 10"]);
}
