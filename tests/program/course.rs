//! The course's own scenes and pictures, which are not part of this project: `COURSE_DIR` names a folder that
//! has them in `scenes/` and `pictures/`. Without it these tests print that they are skipped.

use crate::support::{course, finish, skip};
use std::path::Path;
use std::process::Command;

/// The course's script compares the picture of each command line, and prints those that differ too much.
#[test]
fn the_course_s_pictures() {
    let Some(course) = course() else { return };
    if Command::new("python3").arg("--version").output().is_err() {
        return skip("python3 is not installed");
    }
    let mut check = Command::new("python3");
    check.arg(course.join("check")).arg(env!("CARGO_BIN_EXE_raytracer")).arg("--quiet");
    let run = finish(&mut check);
    assert_eq!(run.status, Some(0), "{}{}", run.stdout, run.stderr);
}

/// The words of the course's command lines, without the program's name and the flags of the preview.
pub fn command_lines(course: &Path) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(course.join("commands.txt")).expect("the course's command lines");
    let lines: Vec<_> =
        text.lines().filter_map(|line| line.strip_prefix("raytracer ")).map(without_preview).collect();
    assert!(lines.len() > 100);
    lines
}

fn without_preview(line: &str) -> Vec<String> {
    let mut words = line.split_whitespace();
    let mut kept = vec![];
    while let Some(word) = words.next() {
        match word {
            "-gui" | "-gouraud" => {}
            "-tessellation" => drop((words.next(), words.next())),
            _ => kept.push(word.to_owned()),
        }
    }
    kept
}

/// The project's own scenes have the names of the course's, so that its command lines render them too, although
/// other things.
#[test]
fn the_course_s_command_lines_name_own_scenes() {
    let Some(course) = course() else { return };
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for words in command_lines(&course) {
        assert!(own.join(&words[1]).is_file(), "{words:?}");
    }
}
