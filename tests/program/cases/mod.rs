//! The table of cases: what a shell is given, the status that it ends with, and the line that says why.
//!
//! In a row, `r` is the program. It works in a folder that has the files of [`folder`], most of which are faulty in one
//! way. Whatever the row, nothing panics, and a run that fails leaves no file.
#![cfg(unix)]

mod command_lines;
mod files;
mod limits;
mod meshes;
mod scenes;

use crate::support::{CAMERA, Folder, Run, finish, scene, sphere};
use std::fmt::Write;
use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

/// What the shell is given, the status, and essential parts of standard error, between which ` ... `
/// stands. Empty where nothing may stand there.
pub type Case = (&'static str, i32, &'static str);

/// The scenes of which a row gives the name, each with one fault.
fn faulty_scenes() -> Vec<(&'static str, Vec<u8>)> {
    let group = |text: &str| format!("{CAMERA}Group {{ {text} }}").into_bytes();
    let material = "Material { } ";
    vec![
        ("empty.txt", vec![]),
        ("binary.txt", b"\x7fELF\x02\x01\x01\x00\xff\xfe\x80".to_vec()),
        ("utf16.txt", b"\xff\xfeG\0r\0o\0u\0p\0".to_vec()),
        ("latin1.txt", b"# caf\xe9\nCaf\xe9 {\n".to_vec()),
        ("nul.txt", group("numObjects 0 \0")),
        ("cut.txt", sphere().into_bytes()[..150].to_vec()),
        ("count21.txt", group("numObjects 123456789012345678901")),
        ("long-word.txt", group(&format!("numObjects 1 {}", "x".repeat(100_000)))),
        ("long-line.txt", group(&format!("{} numObjects 1 Ball", " ".repeat(100_000)))),
        ("long-name.txt", mesh_scene(&format!("{}.obj", "n".repeat(100_000))).into_bytes()),
        ("long-number.txt", group(&format!("numObjects {}", "9".repeat(100_000)))),
        ("braces.txt", b"{".repeat(100_000)),
        ("deep.txt", nested(50_000, "}").into_bytes()),
        ("deep-open.txt", nested(50_000, "").into_bytes()),
        ("escape.txt", group("numObjects 1 \x1b[31mred\x1b[0m")),
        ("bell.txt", mesh_scene("\x07\x1b]0;title\x07.obj").into_bytes()),
        ("flat.txt", group(&format!("numObjects 1 {material} Transform {{ Scale 0 1 1 {BALL} }}"))),
        (
            "grown.txt",
            group(&format!("numObjects 1 {material} Transform {{ {} {BALL} }}", "Scale 1e99 1 1 ".repeat(4))),
        ),
        ("tiny.txt", group(&format!("numObjects 1 {material} Transform {{ UniformScale 1e-99 {BALL} }}"))),
        ("dark.txt", group("numObjects 0")),
    ]
}

const BALL: &str = "Sphere { center 0 0 0 radius .01 }";

/// Transforms in transforms, as deep as this, around a sphere.
fn nested(depth: usize, close: &str) -> String {
    scene(1, &format!("{}{BALL}{}", "Transform { Translate 0 0 0 ".repeat(depth), close.repeat(depth)))
}

fn mesh_scene(name: &str) -> String {
    scene(1, &format!("TriangleMesh {{ obj_file {name} }}"))
}

/// The meshes of which a row gives the scene's name, `m-NAME.txt`.
fn odd_meshes() -> Vec<(&'static str, Vec<u8>)> {
    let three = "v -1 -1 0\nv 1 -1 0\nv 0 1 0\n";
    let after = |text: &str| format!("{three}{text}").into_bytes();
    vec![
        ("empty", vec![]),
        ("letters", after("f a b c\n")),
        ("beyond", b"v 1e200 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()),
        ("binary", b"\0\x01\x02\xff\xfe".to_vec()),
        ("continued-later", after("f 1 2 \\\n3\nf 1 2\n")),
        ("polygon", after("v -2 2 0\nf 1 2 3 4\n")),
        ("long-line", after(&format!("f {}\n", "x".repeat(100_000)))),
    ]
}

/// A folder with everything that the rows name.
fn folder() -> Folder {
    let folder = Folder::with_scene(&sphere());
    for (name, bytes) in faulty_scenes() {
        folder.write(name, bytes);
    }
    for (name, bytes) in odd_meshes() {
        folder.write(&format!("m-{name}.txt"), mesh_scene(&format!("{name}.obj")));
        folder.write(&format!("{name}.obj"), bytes);
    }
    folder.write("m-gone.txt", mesh_scene("gone.obj"));
    folder.write("m-folder.txt", mesh_scene("folder.obj"));
    for name in ["folder.txt", "folder.tga", "folder.obj", "folder.json", "class", "class/anna"] {
        fs::create_dir(folder.path().join(name)).unwrap();
    }
    folder.run("-input s.txt -size 4 4 -output b.tga").ok();
    folder.run("-input s.txt -size 4 4 -output b.png").ok();
    folder.run("-input s.txt -size 5 4 -output wide.tga").ok();
    let tga = folder.read("b.tga");
    folder.write("class/anna/b.tga", &tga);
    folder.write("header.tga", &tga[..10]);
    folder.write("swapped.png", &tga);
    folder.write("c.txt", "raytracer -input s.txt -size 4 4 -output b.tga\n");
    folder.write("c-bad.txt", "raytracer -input s.txt -shadow\n");
    symlink("loop.tga", folder.path().join("loop.tga")).unwrap();
    folder
}

/// Gives the row to a shell.
fn run(folder: &Folder, given: &str) -> Run {
    let shell = format!("r() {{ \"$PROGRAM\" \"$@\"; }}; ulimit -c 0; ulimit -t 20; {given}");
    let mut command = Command::new("sh");
    command.args(["-c", &shell]).current_dir(folder.path()).stdin(Stdio::null());
    finish(command.env("PROGRAM", env!("CARGO_BIN_EXE_raytracer")).env("RUST_BACKTRACE", "0"))
}

/// All names in the folder and its folders.
fn names(folder: &Folder) -> Vec<String> {
    let mut names = folder.names();
    for inner in ["class", "class/anna", "folder.tga", "folder.json"] {
        let entries = fs::read_dir(folder.path().join(inner)).unwrap();
        names.extend(entries.map(|entry| format!("{inner}/{:?}", entry.unwrap().file_name())));
    }
    names
}

/// What each row of a table gets wrong; nothing if all is well.
fn faults(cases: &[Case]) -> String {
    let folder = folder();
    let before = names(&folder);
    let mut wrong = String::new();
    for &(given, status, line) in cases {
        let run = run(&folder, given);
        let said = if line.is_empty() {
            run.stderr.is_empty()
        } else {
            line.split(" ... ").all(|part| run.stderr.contains(part))
        };
        if run.status != Some(status) || !said || run.stderr.contains("panicked") {
            let _ = writeln!(
                wrong,
                "{given}\n  expected {status} {line}\n  actual   {:?} {}",
                run.status, run.stderr
            );
        }
        if run.stderr.lines().any(|line| line.chars().count() > 600) {
            let _ = writeln!(wrong, "{given}\n  a line of {} bytes", run.stderr.len());
        }
        let _ = fs::remove_file(folder.path().join("o.tga"));
        if names(&folder) != before {
            let _ = writeln!(wrong, "{given}\n  left {:?}", names(&folder));
        }
    }
    wrong
}

fn check(cases: &[Case]) {
    let wrong = faults(cases);
    assert!(wrong.is_empty(), "\n{wrong}");
}

#[test]
fn every_command_line_ends_as_its_row_says() {
    check(command_lines::CASES);
}

#[test]
fn every_scene_ends_as_its_row_says() {
    check(scenes::CASES);
}

#[test]
fn every_mesh_ends_as_its_row_says() {
    check(meshes::CASES);
}

#[test]
fn every_file_ends_as_its_row_says() {
    check(files::CASES);
}

#[test]
fn every_limit_ends_as_its_row_says() {
    check(limits::CASES);
}
