//! The scripts for many machines, as far as one machine can try them; `farm/test` tries them with schedulers.
#![cfg(unix)]

use crate::support::{Folder, Run, finish, sphere};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

fn script(folder: &Folder, name: &str, line: &str) -> Run {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("farm").join(name);
    let mut command = Command::new("bash");
    command.arg(path).args(line.split_whitespace()).current_dir(folder.path());
    finish(command.env("RAYTRACER", env!("CARGO_BIN_EXE_raytracer")).env("THREADS", "1"))
}

/// When a file was written.
fn time(folder: &Folder, name: &str) -> SystemTime {
    fs::metadata(folder.path().join(name)).and_then(|found| found.modified()).expect("a time")
}

#[test]
fn parts_become_a_picture_when_the_last_of_them_is_there() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -size 9 11 -shadows -output whole.tga").ok();
    let part = |k: usize| script(&folder, "part", &format!("{k} 4 s.txt 9 11 o.tga -shadows"));
    for k in [2, 0, 3] {
        part(k).ok();
        assert_eq!(folder.names(), ["o.tga.parts", "s.txt", "whole.tga"]);
    }
    part(1).ok();
    assert!(folder.read("o.tga") == folder.read("whole.tga"));

    // A part that is there is not rendered again; one that is missing is, and what an earlier attempt has left goes.
    fs::remove_file(folder.path().join("o.tga")).unwrap();
    fs::remove_file(folder.path().join("o.tga.parts/2.tga")).unwrap();
    folder.write("o.tga.parts/2.partial.tga", "left");
    let before = time(&folder, "o.tga.parts/1.tga");
    part(1).ok();
    assert_eq!(folder.names(), ["o.tga.parts", "s.txt", "whole.tga"]);
    part(2).ok();
    assert_eq!(time(&folder, "o.tga.parts/1.tga"), before);
    assert!(folder.read("o.tga") == folder.read("whole.tga"));
    let parts: Vec<_> = fs::read_dir(folder.path().join("o.tga.parts")).unwrap().collect();
    assert_eq!(parts.len(), 4);

    // A finished picture needs nothing, not even its parts.
    fs::remove_dir_all(folder.path().join("o.tga.parts")).unwrap();
    part(0).ok();
    assert_eq!(folder.names(), ["o.tga", "s.txt", "whole.tga"]);
}

#[test]
fn more_parts_than_rows_and_failing_parts() {
    let folder = Folder::with_scene(&sphere());
    for k in 0..5 {
        script(&folder, "part", &format!("{k} 5 s.txt 4 3 o.tga")).ok();
    }
    folder.run("-input s.txt -size 4 3 -output whole.tga").ok();
    assert!(folder.read("o.tga") == folder.read("whole.tga"));
    assert_eq!(script(&folder, "part", "0 2 no.txt 4 3 p.tga").status, Some(1));
    assert_eq!(script(&folder, "part", "0 2 s.txt 4 3 p.tga -shadow").status, Some(2));
    assert_eq!(script(&folder, "part", "0 2 s.txt").status, Some(2));
    assert!(!folder.names().contains(&"p.tga".to_owned()));
}

#[test]
fn a_frame_is_rendered_once() {
    let folder = Folder::with_scene(&sphere());
    let frame = || script(&folder, "frame", "s.txt frames -size 6 5").ok();
    frame();
    folder.run("-input s.txt -size 6 5 -output s.png").ok();
    assert!(folder.read("frames/s.png") == folder.read("s.png"));
    folder.write("frames/s.png", "there");
    frame();
    assert_eq!(folder.read("frames/s.png"), b"there");
}
