//! The lists of the course's pictures in `docs/accuracy.md`. `BLESS=1`, with `--ignored`, writes them.

use crate::course::command_lines;
use crate::support::{Folder, course, finish, program};
use raytracer::image_io::read_picture;
use raytracer::tools::compare::Comparison;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

const PAGE: &str = "docs/accuracy.md";
const START: &str = "<!-- lists -->\n";
const END: &str = "<!-- end of the lists -->\n";

/// The sections of the page that say why pictures differ by more than a level. A name ends with `*` if it is the
/// start of several.
const REASONS: &[(&str, &[&str])] = &[
    ("An epsilon", &["output4_03", "output4_06b", "output4_06c", "output4_14*", "output7_04a"]),
    ("A weight", &["output4_06e", "output4_06f", "output4_07", "output4_08"]),
    ("Shadows on themselves", &["output6_02c", "output6_03c", "output6_13"]),
    ("Rays that leak", &["output6_07"]),
    ("Far away", &["output6_17a", "output7_03*"]),
    ("Edges", &["output7_01", "output7_02*", "samples7_02*"]),
    ("Ties", &["filter7_01d", "output5_06", "output5_09"]),
    ("Not comparable", &["output4_05", "output5_03", "output7_05b", "output7_05c", "output7_06b"]),
];

/// The section that says why a picture differs.
fn reason(name: &str) -> Option<&'static str> {
    let is_meant = |pattern: &&str| match pattern.strip_suffix('*') {
        Some(start) => name.starts_with(start),
        None => name == *pattern,
    };
    REASONS.iter().find(|(_, names)| names.iter().any(is_meant)).map(|(section, _)| *section)
}

/// Every picture of the course that there is, compared with what its command line renders, in the order of the
/// command lines.
fn compared(course: &Path) -> Vec<(String, Comparison)> {
    let folder = Folder::new();
    let mut all: Vec<(String, Comparison)> = vec![];
    for words in command_lines(course) {
        let has_picture = |word: &String| course.join("pictures").join(word).is_file();
        let is_new =
            |word: &String| !all.iter().any(|(name, _)| Some(name.as_str()) == word.strip_suffix(".tga"));
        let pictures: Vec<_> =
            words.iter().filter(|word| has_picture(word) && is_new(word)).cloned().collect();
        if pictures.is_empty() {
            continue;
        }
        let moved = |word: &String| match word.ends_with(".tga") {
            true => folder.path().join(word).into_os_string(),
            false => word.into(),
        };
        finish(&mut program(&course.join("scenes"), words.iter().map(moved))).ok();
        for name in pictures {
            let [ours, theirs] = [folder.path().to_path_buf(), course.join("pictures")]
                .map(|place| read_picture(&place.join(&name)).expect("a picture"));
            let comparison = Comparison::new(&ours, &theirs).expect("of one size");
            all.push((name.trim_end_matches(".tga").to_owned(), comparison));
        }
    }
    all
}

/// The three lists.
fn lists(compared: &[(String, Comparison)]) -> String {
    let mut text = String::new();
    let heading = |title: &str, count: usize| format!("\n### {title}: {count}\n\n");
    let identical: Vec<_> = compared.iter().filter(|(_, c)| c.pixels_that_differ() == 0).collect();
    text += &heading("Identical", identical.len());
    let mut by_assignment: BTreeMap<char, Vec<String>> = BTreeMap::new();
    for (name, _) in &identical {
        let digit = name.chars().find(char::is_ascii_digit).expect("the number of the assignment");
        by_assignment.entry(digit).or_default().push(format!("`{name}`"));
    }
    for (assignment, names) in by_assignment {
        let _ = writeln!(text, "* Assignment {assignment}: {}.", names.join(", "));
    }
    let beyond = |c: &Comparison| c.pixels_differing_by_more_than(1) > 0;
    let within: Vec<_> = compared.iter().filter(|(_, c)| c.pixels_that_differ() > 0 && !beyond(c)).collect();
    text += &heading("Within one level", within.len());
    text +=
        "The reason is [rounding](#rounding).\n\n| Picture | Pixels that differ | of |\n|---|---:|---:|\n";
    for (name, c) in &within {
        let _ = writeln!(text, "| `{name}` | {} | {} |", c.pixels_that_differ(), c.pixels());
    }
    let beyond: Vec<_> = compared.iter().filter(|(_, c)| beyond(c)).collect();
    text += &heading("Beyond one level", beyond.len());
    text += "| Picture | Pixels that differ | by more than a level | of | Why |\n|---|---:|---:|---:|---|\n";
    for (name, c) in &beyond {
        let section = reason(name).unwrap_or_else(|| panic!("{name} differs, and the page does not say why"));
        let link = format!("[{}](#{})", section.to_lowercase(), crate::markdown::anchor(section));
        let more = c.pixels_differing_by_more_than(1);
        let _ =
            writeln!(text, "| `{name}` | {} | {more} | {} | {link} |", c.pixels_that_differ(), c.pixels());
    }
    text + "\n"
}

#[test]
#[ignore = "slow: ten seconds"]
fn the_course_page_s_lists_are_true() {
    let Some(course) = course() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
    let page = std::fs::read_to_string(&path).expect("the page");
    let (before, rest) = page.split_once(START).expect("a mark before the lists");
    let (present, after) = rest.split_once(END).expect("a mark behind the lists");
    let lists = lists(&compared(&course));
    if std::env::var_os("BLESS").is_some_and(|value| value == "1") {
        return std::fs::write(&path, [before, START, &lists, END, after].concat())
            .expect("the page is written");
    }
    assert!(present == lists, "{PAGE} should say\n{lists}");
}
