//! The list of reference commands, and how they are run.

use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::process;

/// The folder of the project's scenes. The program runs in it, so that command lines name scenes as in the
/// course.
pub fn scene_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// The folder of the reference pictures and of the list of commands.
pub fn references() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("reference_images")
}

/// The names of all scenes, in order.
pub fn scenes() -> Vec<String> {
    let entries = fs::read_dir(scene_folder()).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut scenes: Vec<_> = names.filter(|name| name.ends_with(".txt")).collect();
    scenes.sort();
    assert!(!scenes.is_empty());
    scenes
}

/// One line of `commands.txt`.
pub struct Command(String);

impl fmt::Display for Command {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Command {
    /// All lines except empty ones and headings, which start with `#`.
    pub fn all() -> Vec<Self> {
        let text = fs::read_to_string(references().join("commands.txt")).unwrap();
        let lines = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
        let commands: Vec<_> = lines.map(|line| Self(line.to_owned())).collect();
        assert!(!commands.is_empty());
        commands
    }

    /// The words after the program's name.
    fn words(&self) -> impl Iterator<Item = &str> {
        let rest = self.0.strip_prefix("raytracer ").expect("each line calls the program");
        rest.split_whitespace()
    }

    /// The pictures that it writes, which are all words that end in `.tga`.
    pub fn pictures(&self) -> impl Iterator<Item = &str> {
        self.words().filter(|word| is_picture(word))
    }

    /// Runs it, and writes its pictures to `folder`.
    pub fn run(&self, folder: &Path) {
        let moved = |word: &str| match is_picture(word) {
            true => folder.join(word).into_os_string(),
            false => word.into(),
        };
        let mut program = program();
        program.args(self.words().map(moved));
        succeed(program);
    }
}

fn is_picture(word: &str) -> bool {
    word.ends_with(".tga")
}

/// The command of the program, to be run in the folder of scenes.
pub fn program() -> process::Command {
    let mut program = process::Command::new(env!("CARGO_BIN_EXE_raytracer"));
    program.current_dir(scene_folder());
    program
}

/// Runs a command, which must succeed and print nothing on standard error, except that a scene has no lights, as
/// those of assignment 1, or that a flag that is tried on all scenes has no effect on this one.
pub fn succeed(mut program: process::Command) {
    let output = program.output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let quiet = said.lines().all(|line| line.contains("No lights") || line.contains("has no effect"));
    assert!(output.status.success() && quiet, "{program:?}: {}\n{said}", output.status);
}
