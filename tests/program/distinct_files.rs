//! Files that are written twice or also read, by whatever names, and files that grow too large.

use crate::support::{Folder, Run, finish, only_line, scene, sphere};
use std::fs::{create_dir, hard_link};
use std::os::unix::fs::symlink;
use std::process::Command;

/// A folder with a scene `s.txt`, its mesh `m.obj`, a picture `o.tga` and a folder.
fn folder() -> Folder {
    let folder = Folder::with_scene(&scene(1, "TriangleMesh { obj_file m.obj }"));
    folder.write("m.obj", "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("o.tga", "an earlier picture");
    create_dir(folder.path().join("folder")).unwrap();
    folder
}

#[test]
fn two_names_of_one_file_are_refused() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    symlink("o.tga", path("link.tga")).unwrap();
    hard_link(path("o.tga"), path("hard.tga")).unwrap();
    symlink("new.tga", path("one.tga")).unwrap();
    symlink("folder/../new.tga", path("two.tga")).unwrap();
    symlink(folder.path(), path("folder/back")).unwrap();
    symlink("o.tga", path("document.json")).unwrap();
    let before = folder.names();
    let absolute = path("o.tga").display().to_string();
    for (one, other) in [
        ("o.tga", "folder/../o.tga"),
        ("o.tga", "folder/back/o.tga"),
        ("new.tga", "folder/back/new.tga"),
        ("o.tga", "link.tga"),
        ("o.tga", "hard.tga"),
        ("link.tga", "hard.tga"),
        ("one.tga", "two.tga"),
        ("one.tga", "new.tga"),
        ("link.tga", absolute.as_str()),
    ] {
        let message = folder.run(&format!("-input s.txt -output {one} -normals {other}")).message(1);
        assert_eq!(only_line(&message), format!("error: `{one}` and `{other}` are the same file"));
    }
    for flags in ["-compare o.tga -difference link.tga", "-json document.json"] {
        let message = folder.run(&format!("-input s.txt -output o.tga {flags}")).message(1);
        assert!(only_line(&message).ends_with("` are the same file"), "{message}");
    }
    assert_eq!(folder.read("o.tga"), b"an earlier picture");
    assert_eq!(folder.names(), before);
}

#[test]
fn a_file_that_is_read_is_not_replaced() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    symlink("s.txt", path("scene.tga")).unwrap();
    hard_link(path("s.txt"), path("scene.png")).unwrap();
    symlink("m.obj", path("mesh.tga")).unwrap();
    symlink("m.obj", path("mesh.json")).unwrap();
    let (scene, mesh) = (folder.read("s.txt"), folder.read("m.obj"));
    for (flags, expected) in [
        ("-output scene.tga", "error: `scene.tga` is the scene `s.txt`, which would be lost"),
        ("-normals scene.png", "error: `scene.png` is the scene `s.txt`, which would be lost"),
        ("-output s.txt tga", "error: `s.txt` is the scene `s.txt`, which would be lost"),
        ("-output mesh.tga", "error: `mesh.tga` is the mesh `m.obj`, which would be lost"),
        ("-stats -json mesh.json", "error: `mesh.json` is the mesh `m.obj`, which would be lost"),
    ] {
        assert_eq!(only_line(&folder.run(&format!("-input s.txt {flags}")).message(1)), expected);
    }
    assert!(folder.read("s.txt") == scene && folder.read("m.obj") == mesh);
}

#[test]
fn devices_and_distant_files_are_no_matter() {
    let folder = folder();
    symlink("/dev/null", folder.path().join("a.tga")).unwrap();
    symlink("/dev/null", folder.path().join("b.tga")).unwrap();
    folder.run("-input s.txt -output a.tga -normals b.tga -depth 1 2 folder/o.tga").ok();
    // A picture may take the place of the one that it was compared with.
    folder.run("-input s.txt -output o.tga").ok();
    folder.run("-input s.txt -output o.tga -compare o.tga -tolerance 0 0").ok();
}

#[test]
fn a_file_above_the_limit_is_an_error_and_leaves_nothing() {
    let folder = Folder::with_scene(&sphere());
    folder.write("o.tga", "an earlier picture");
    // Half a kilobyte each; the second picture is above what is kept in memory.
    for (blocks, size, name) in
        [(8, "100 100", "o.tga"), (8, "1700 1700", "o.tga"), (16, "100 100", "new.exr")]
    {
        let run = with_limit(&folder, blocks, &format!("-input s.txt -size {size} -output {name}"));
        let expected = format!("error: cannot write `{name}`: File too large (os error 27)");
        assert_eq!(only_line(&run.message(1)), expected);
        assert_eq!(folder.names(), ["o.tga", "s.txt"]);
    }
    assert_eq!(folder.read("o.tga"), b"an earlier picture");
}

/// A run with a limit on the length of files, in blocks of 512 bytes.
fn with_limit(folder: &Folder, blocks: usize, line: &str) -> Run {
    let mut shell = Command::new("sh");
    let script = format!("ulimit -f {blocks} && exec \"$@\"");
    shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_raytracer")]).args(line.split_whitespace());
    finish(shell.current_dir(folder.path()))
}
