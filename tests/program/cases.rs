//! Tables of shell commands, each with the status that it ends with and the parts of its message.
//!
//! In a row, `r` is the program. It works in a folder that has the files of [`folder`]. Whatever the row, nothing
//! panics, and a run that fails leaves no file.
#![cfg(unix)]

use crate::support::{CAMERA, Folder, finish, scene, sphere};
use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

/// A shell command, its status, and parts of standard error, between which ` ... ` stands. Without parts, standard
/// error is empty.
type Case = (&'static str, i32, &'static str);

const COMMAND_LINES: &[Case] = &[
    ("r -input s.txt '-stats\n'", 2, "-stats"),
    ("r \"-$(head -c 100000 /dev/zero | tr '\\0' x)\"", 2, "-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx"),
    ("r -version", 0, ""),
    ("r -input s.txt -output ./o.tga -size 9 9", 0, ""),
    ("r -input \"$(head -c 100000 /dev/zero | tr '\\0' x).txt\"", 1, "File name too long"),
];

const SCENES: &[Case] = &[
    ("r -input binary.txt -output o.tga", 1, "binary.txt:1:9: error:"),
    ("r -input utf16.txt -output o.tga", 1, "utf16.txt:1:1: error:"),
    ("r -input latin1.txt -output o.tga", 1, "latin1.txt:2:4: error:"),
    ("r -input escape.txt -output o.tga", 1, "escape.txt:2:22: error: ... \\u{1b}[31mred\\u{1b}[0m"),
    ("r -input bell.txt -output o.tga", 1, "bell.txt:5:25: error: ... \\u{7}\\u{1b}]0;title\\u{7}.obj"),
    ("r -input long-name.txt -output o.tga", 1, "long-name.txt:5:25: error:"),
    ("r -input flat.txt -output o.tga", 1, "flat.txt:2:35: error:"),
    ("r -input tiny.txt -output o.tga", 1, "tiny.txt:2:35: error:"),
    ("r -input binary-mesh.txt -output o.tga", 1, "binary-mesh.txt:5:25: error:"),
    ("r -input s.txt/s.txt -output o.tga", 1, "s.txt/s.txt: error:"),
];

const FILES: &[Case] = &[
    ("r -input s.txt -output s.txt/o.tga", 1, "cannot write `s.txt/o.tga` ... Not a directory"),
    ("r -input s.txt -output loop.tga", 1, "cannot write `loop.tga` ... symbolic links"),
    ("r -input s.txt -json folder.json", 1, "cannot write `folder.json` ... it is a folder"),
    ("r -input s.txt -output \"$(head -c 300 /dev/zero | tr '\\0' x).tga\"", 1, "cannot write `xxxxxxxxxx"),
    ("r -compare gone.tga -reference b.tga", 1, "cannot read `gone.tga` ... No such file"),
    ("r -compare wide.tga -reference b.tga", 1, "`wide.tga` ... `b.tga` ... 5 x 4 pixels against 4 x 4"),
    ("r -input s.txt -size 4 4 -compare wide.tga", 1, "5 x 4 pixels against 4 x 4\n  hint: -size 5 4 "),
    ("r -grade gone -reference class", 1, "cannot read the folder `gone` ... No such file"),
    ("r -grade class -reference s.txt", 1, "cannot read the folder `s.txt` ... Not a directory"),
    ("r -grade class -commands gone.txt", 1, "cannot read the commands `gone.txt` ... No such file"),
    ("r -grade class -commands c.txt -report gone/p.html", 1, "`gone/p.html` ... there is no folder `gone`"),
    ("r -grade class -commands c.txt -tolerance 0 0 >/dev/null", 0, ""),
    ("echo kept > o.tga; r -input gone.txt -output o.tga; grep -q kept o.tga", 0, "gone.txt: error: "),
];

/// Little memory, small stacks, closed and full descriptors, and the environment.
const LIMITS: &[Case] = &[
    ("r -input s.txt -size 65535 65535 -cost_map rays o.tga", 1, "error: not enough memory"),
    ("(ulimit -v 400000; r -input s.txt -size 65535 65535 -compare b.tga)", 1, "against 65535 x 65535"),
    ("(ulimit -v 400000; r -input s.txt -size 65535 65535 -compare o.tga)", 1, "cannot read `o.tga`"),
    ("(ulimit -v 400000; r -input s.txt -grid 1290 1290 1290 -output o.tga)", 1, "the grid does not fit"),
    (
        "(ulimit -v 400000; r -input s.txt -grid 1000 1000 1000 -visualize_grid -output o.tga)",
        1,
        "the grid does not fit",
    ),
    (
        "(ulimit -v 400000; r -input s.txt -size 1 5000 -threads 4096 -output o.tga)",
        1,
        "`-threads` ... start",
    ),
    ("(ulimit -v 400000; r -threads 4096 -grade class -commands c.txt)", 0, ""),
    (
        "(ulimit -v 400000; r -input s.txt -size 65535 65535 -gaussian_filter 1000 -jittered_samples 2 -threads 2 \
          -output o.tga)",
        1,
        "error: not enough memory",
    ),
    ("(ulimit -v 400000; r -input deep.txt -size 3 3 -output o.tga)", 0, ""),
    ("(ulimit -s 256; r -input deep.txt -size 3 3 -output o.tga)", 0, ""),
    ("(ulimit -s 256; r -input deep-open.txt -size 3 3 -output o.tga)", 1, "deep-open.txt:6:2: error:"),
    ("(ulimit -n 7; r -input s.txt -size 3 3 -output o.tga)", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga <&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga >&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga 2>&-", 0, ""),
    ("r -input s.txt -size 3 3 -output o.tga <&- >&- 2>&-", 0, ""),
    ("r -nonsense 2>&-", 2, ""),
    ("r -input gone.txt <&- >&-", 1, "gone.txt: error:"),
    ("r -input s.txt -size 3 3 -output o.tga 2>/dev/full", 0, ""),
    ("r -input gone.txt 2>/dev/full", 1, ""),
    ("TMPDIR=/gone r -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("env -i \"$PROGRAM\" -input s.txt -size 3 3 -output o.tga", 0, ""),
    ("RUST_MIN_STACK=1 r -input s.txt -size 3 3 -threads 3 -output o.tga", 0, ""),
];

const BALL: &str = "Sphere { center 0 0 0 radius .01 }";

/// Nested transforms around a sphere.
fn nested(depth: usize, close: &str) -> String {
    scene(1, &format!("{}{BALL}{}", "Transform { Translate 0 0 0 ".repeat(depth), close.repeat(depth)))
}

/// Returns a folder with everything that the rows name.
fn folder() -> Folder {
    let folder = Folder::with_scene(&sphere());
    let group = |text: &str| format!("{CAMERA}Group {{ {text} }}").into_bytes();
    let mesh = |name: &str| scene(1, &format!("TriangleMesh {{ obj_file {name}.obj }}")).into_bytes();
    let in_transform =
        |scale: &str| group(&format!("numObjects 1 Material {{ }} Transform {{ {scale} {BALL} }}"));
    for (name, bytes) in [
        ("binary.txt", b"\x7fELF\x02\x01\x01\x00\xff\xfe\x80".to_vec()),
        ("utf16.txt", b"\xff\xfeG\0r\0o\0u\0p\0".to_vec()),
        ("latin1.txt", b"# caf\xe9\nCaf\xe9 {\n".to_vec()),
        ("long-name.txt", mesh(&"n".repeat(100_000))),
        ("deep.txt", nested(50_000, "}").into_bytes()),
        ("deep-open.txt", nested(50_000, "").into_bytes()),
        ("escape.txt", group("numObjects 1 \x1b[31mred\x1b[0m")),
        ("bell.txt", mesh("\x07\x1b]0;title\x07")),
        ("flat.txt", in_transform("Scale 0 1 1")),
        ("tiny.txt", in_transform("UniformScale 1e-99")),
        ("binary-mesh.txt", mesh("binary")),
        ("binary.obj", b"\0\x01\x02\xff\xfe".to_vec()),
        ("c.txt", b"raytracer -input s.txt -size 4 4 -output b.tga\n".to_vec()),
    ] {
        folder.write(name, bytes);
    }
    for name in ["folder.json", "class/anna"] {
        fs::create_dir_all(folder.path().join(name)).unwrap();
    }
    folder.run("-input s.txt -size 4 4 -output b.tga").ok();
    folder.run("-input s.txt -size 5 4 -output wide.tga").ok();
    folder.write("class/anna/b.tga", folder.read("b.tga"));
    symlink("loop.tga", folder.path().join("loop.tga")).unwrap();
    folder
}

/// Gives each row to a shell.
fn check(cases: &[Case]) {
    let folder = folder();
    let before = folder.names();
    for &(given, status, expected) in cases {
        let shell = format!("r() {{ \"$PROGRAM\" \"$@\"; }}; ulimit -c 0; ulimit -t 20; {given}");
        let mut command = Command::new("sh");
        command.args(["-c", &shell]).current_dir(folder.path()).stdin(Stdio::null());
        let run = finish(command.env("PROGRAM", env!("CARGO_BIN_EXE_raytracer")));
        let is_said = if expected.is_empty() {
            run.stderr.is_empty()
        } else {
            expected.split(" ... ").all(|part| run.stderr.contains(part))
        };
        let is_short = run.stderr.lines().all(|line| line.chars().count() <= 600);
        let is_well = run.status == Some(status) && is_said && is_short && !run.stderr.contains("panicked");
        assert!(
            is_well,
            "{given}\n  expected {status} {expected}\n  actual   {:?} {}",
            run.status, run.stderr
        );
        let _ = fs::remove_file(folder.path().join("o.tga"));
        assert_eq!(folder.names(), before, "{given}");
    }
}

#[test]
fn every_command_line_ends_as_its_row_says() {
    check(COMMAND_LINES);
}

#[test]
fn every_scene_ends_as_its_row_says() {
    check(SCENES);
}

#[test]
fn every_file_ends_as_its_row_says() {
    check(FILES);
}

#[test]
fn every_limit_ends_as_its_row_says() {
    check(LIMITS);
}
