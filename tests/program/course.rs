//! The course's own scenes and pictures, which are not part of this project: `COURSE_DIR` names a folder that
//! has them in `scenes/` and `pictures/`. Without it these tests print that they are skipped.

use crate::support::{Folder, course, finish, program, skip};
use raytracer::scene::load::load;
use std::path::{Path, PathBuf};
use std::process::Command;

fn scenes(course: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(course.join("scenes")).expect("COURSE_DIR has scenes");
    let paths = entries.map(|entry| entry.expect("a readable folder").path());
    let mut scenes: Vec<_> = paths.filter(|path| path.extension().is_some_and(|end| end == "txt")).collect();
    scenes.sort();
    assert!(!scenes.is_empty());
    scenes
}

#[test]
fn every_scene_of_the_course_loads() {
    let Some(course) = course() else { return };
    for path in scenes(&course) {
        let loaded = load(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.meshes.len(), loaded.scene.meshes.len());
        for mesh in &loaded.meshes {
            assert!(
                mesh.triangles.as_flattened().iter().all(|&index| (index as usize) < mesh.vertices.len())
            );
        }
    }
}

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

/// A small picture of a scene and its depths, with all effects.
fn rendered(scene: &Path, grid: &[&str]) -> [Vec<u8>; 2] {
    let folder = Folder::new();
    let [color, depth] = ["c.tga", "d.tga"].map(|name| folder.path().join(name).into_os_string());
    let working = scene.parent().expect("the scenes lie in a folder");
    let mut command = program(working, ["-input".as_ref(), scene.as_os_str()]);
    command.args(["-size", "15", "20", "-shadows", "-shade_back", "-bounces", "3", "-weight", "0.01"]);
    command.arg("-output").arg(color).args(["-depth", "0", "30"]).arg(depth).args(grid);
    finish(&mut command).ok();
    ["c.tga", "d.tga"].map(|name| folder.read(name))
}

#[test]
fn the_course_s_scenes_are_the_same_bytes_with_any_grid() {
    let Some(course) = course() else { return };
    for scene in scenes(&course) {
        let plain = rendered(&scene, &[]);
        for grid in [["-grid", "1", "1", "1"], ["-grid", "20", "17", "13"], ["-grid", "3", "60", "7"]] {
            assert!(rendered(&scene, &grid) == plain, "{}: {}", scene.display(), grid.join(" "));
        }
    }
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
fn the_course_s_command_lines_render_the_own_scenes() {
    let Some(course) = course() else { return };
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut lines = command_lines(&course);
    // The first line of each scene: the others differ in their flags.
    lines.dedup_by_key(|words| words[1].clone());
    let folder = Folder::new();
    for words in lines {
        let moved = |word: &String| match word.ends_with(".tga") {
            true => folder.path().join(word).into_os_string(),
            false => word.into(),
        };
        finish(&mut program(&own, words.iter().map(moved))).ok();
    }
}
