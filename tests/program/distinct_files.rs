//! Files that are written twice or also read, by whatever names; files that are written together or not at all.

#[cfg(target_os = "linux")]
use crate::support::skip;
use crate::support::{Folder, Run, finish, only_line, scene, sphere, sphere_in_perspective};
use std::fs::{File, create_dir, create_dir_all, hard_link};
use std::io::Read;
use std::os::unix::fs::{MetadataExt, symlink};
use std::process::{Command, Stdio};

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
        let message = folder.run(&format!("-input s.txt -output {one} -normals {other}")).message(2);
        assert_eq!(only_line(&message), format!("error: `{one}` and `{other}` are the same file"));
    }
    for [one, other] in [
        ["-output a.tga", "-normals a.tga"],
        ["-output d/a.tga", "-depth 1 2 d/./a.tga"],
        ["-render_samples a.tga 4", "-render_filter a.tga 4"],
        ["-output d.tga", "-compare o.tga -difference d.tga"],
    ] {
        create_dir_all(path("d")).unwrap();
        let message = folder.run(&format!("-input s.txt {one} {other}")).message(2);
        assert!(only_line(&message).ends_with(".tga` would be written twice"), "{message}");
    }
    std::fs::remove_dir(path("d")).unwrap();
    for flags in ["-compare o.tga -difference link.tga", "-json document.json"] {
        let message = folder.run(&format!("-input s.txt -output o.tga {flags}")).message(2);
        assert!(only_line(&message).ends_with("` are the same file"), "{message}");
    }
    assert_eq!(folder.read("o.tga"), b"an earlier picture");
    assert_eq!(folder.names(), before);
}

#[test]
fn devices_pipes_and_distant_files_are_no_matter() {
    let folder = folder();
    symlink("/dev/null", folder.path().join("a.tga")).unwrap();
    symlink("/dev/null", folder.path().join("b.tga")).unwrap();
    folder.run("-input s.txt -output a.tga -normals b.tga -depth 1 2 folder/o.tga").ok();
}

/// A folder with all that a run reads: a scene and its mesh, two pictures, two parts, a list of command lines, and a
/// folder of pictures for each of two names.
fn everything_that_is_read() -> Folder {
    let folder = folder();
    folder.run("-input s.txt -size 4 4 -output a.tga").ok();
    folder.run("-input s.txt -size 4 4 -output b.png").ok();
    folder.run("-input s.txt -size 4 4 -region 0 0 4 2 -output top.tga").ok();
    folder.run("-input s.txt -size 4 4 -region 0 2 4 2 -output rest.png").ok();
    folder.write("c.csv", "raytracer -input s.txt -size 4 4 -output a.tga\n");
    for (name, picture) in [("ann", "a.tga"), ("bob", "a.tga")] {
        create_dir_all(folder.path().join("class").join(name)).unwrap();
        folder.write(&format!("class/{name}/a.tga"), folder.read(picture));
    }
    create_dir(folder.path().join("ref")).unwrap();
    folder.write("ref/a.tga", folder.read("a.tga"));
    folder
}

/// A run, the file that it would write over under a name that begins with `NEW`, and what the run reads it as.
const OVERWRITING: &[(&str, &str, &str)] = &[
    ("-input s.txt -output NEW.tga -compare a.tga", "a.tga", "picture"),
    ("-input s.txt -output NEW.tga -reference a.tga", "a.tga", "picture"),
    ("-input s.txt -normals NEW.png -compare b.png", "b.png", "picture"),
    ("-compare a.tga -reference b.png -difference NEW.tga", "a.tga", "picture"),
    ("-compare a.tga -reference b.png -difference NEW.tga", "b.png", "picture"),
    ("-compare a.tga -reference b.png -json NEW.json", "b.png", "picture"),
    ("-input s.txt -size 4 4 -compare a.tga -difference NEW.png", "s.txt", "scene"),
    ("-input s.txt -size 4 4 -compare a.tga -difference NEW.png", "m.obj", "mesh"),
    ("-input s.txt -output o.tga -depth 1 2 NEW.pfm", "m.obj", "mesh"),
    ("-input s.txt -cost_map rays NEW.png", "s.txt", "scene"),
    ("-input s.txt -render_samples NEW.tga 2", "m.obj", "mesh"),
    ("-input s.txt -render_filter NEW.tga 2", "s.txt", "scene"),
    ("-merge top.tga rest.png -output NEW.tga", "top.tga", "part"),
    ("-merge top.tga rest.png -output NEW.png", "rest.png", "part"),
    ("-grade class -commands c.csv -report NEW.html", "c.csv", "list of commands"),
    ("-grade class -commands c.csv -report NEW.html", "s.txt", "scene"),
    ("-grade class -commands c.csv -report NEW.html", "m.obj", "mesh"),
    ("-grade class -commands c.csv -report NEW.html", "class/bob/a.tga", "picture"),
    ("-grade class -reference ref -report NEW.html", "ref/a.tga", "picture"),
    ("-grade class -reference ref -report NEW.html", "class/ann/a.tga", "picture"),
];

/// What the run would write over must be as before, and nothing else be there.
fn refuse(folder: &Folder, line: &str, read: &str, expected: &str) {
    let (before, names) = (folder.read(read), folder.names());
    let message = folder.run(line).message(2);
    assert_eq!(only_line(&message), format!("error: {expected}"), "{line}");
    assert!(folder.read(read) == before && folder.names() == names, "{line}");
}

#[test]
fn what_a_run_reads_it_never_writes() {
    let folder = everything_that_is_read();
    let path = |name: &str| folder.path().join(name);
    for &(line, read, kind) in OVERWRITING {
        let name = line.split_whitespace().find(|word| word.starts_with("NEW")).unwrap();
        let message = format!("`{name}` would overwrite the {kind} `{read}`");
        for is_symbolic in [true, false] {
            match is_symbolic {
                true => symlink(path(read), path(name)).unwrap(),
                false => hard_link(path(read), path(name)).unwrap(),
            }
            refuse(&folder, line, read, &message);
            std::fs::remove_file(path(name)).unwrap();
        }
    }
    // By its own name.
    for (line, read, message) in [
        ("-input s.txt -output a.tga -compare a.tga", "a.tga", "`a.tga` would overwrite the picture `a.tga`"),
        (
            "-input s.txt -output ./folder/../a.tga -reference a.tga",
            "a.tga",
            "`./folder/../a.tga` would overwrite the picture `a.tga`",
        ),
        (
            "-compare a.tga -reference b.png -difference a.tga",
            "a.tga",
            "`a.tga` would overwrite the picture `a.tga`",
        ),
        (
            "-merge top.tga rest.png -output top.tga",
            "top.tga",
            "`top.tga` would overwrite the part `top.tga`",
        ),
        (
            "-grade class -commands c.csv -report c.html",
            "c.csv",
            "`c.csv` would overwrite the list of commands `c.csv`",
        ),
    ] {
        refuse(&folder, line, read, message);
    }
}

#[test]
fn what_a_report_writes_is_no_scene_and_no_mesh_and_differs() {
    let folder = everything_that_is_read();
    let path = |name: &str| folder.path().join(name);
    create_dir(path("er")).unwrap();
    for (file, read, message) in [
        ("er/report.html", "s.txt", "`er/report.html` would overwrite the scene `s.txt`"),
        ("er/report.csv", "s.txt", "`er/report.csv` would overwrite the scene `s.txt`"),
        ("er/report.html", "m.obj", "`er/report.html` would overwrite the mesh `m.obj`"),
    ] {
        symlink(path(read), path(file)).unwrap();
        refuse(&folder, "-input s.txt -size 4 4 -error_report er", read, message);
        std::fs::remove_file(path(file)).unwrap();
    }
    folder.write("t.ppm", "P3 1 1 255 9 9 9");
    folder.write(
        "textured.txt",
        "PerspectiveCamera { center 0 0 5 direction 0 0 -1 up 0 1 0 angle 30 }
        Lights { numLights 1 DirectionalLight { direction 0 0 -1 color 1 1 1 } }
        Background { color 0 0 0 ambientLight 0 0 0 }
        Materials { numMaterials 1 Material { diffuseColor 1 1 1 texture t.ppm } }
        Group { numObjects 1 MaterialIndex 0 TriangleMesh { obj_file m.obj } }",
    );
    symlink(path("t.ppm"), path("er/report.csv")).unwrap();
    let line = "-edition 2012a4 -input textured.txt -size 4 4 -error_report er";
    refuse(&folder, line, "t.ppm", "`er/report.csv` would overwrite the texture `t.ppm`");
    std::fs::remove_file(path("er/report.csv")).unwrap();
    symlink("report.html", path("er/report.csv")).unwrap();
    let message = folder.run("-input s.txt -size 4 4 -error_report er").message(2);
    assert_eq!(only_line(&message), "error: `er/report.html` and `er/report.csv` are the same file");
    symlink("p.html", path("p.csv")).unwrap();
    let message = folder.run("-grade class -reference ref -report p.html").message(2);
    assert_eq!(only_line(&message), "error: `p.html` and `p.csv` are the same file");
}

#[test]
fn the_part_of_a_stopped_run_is_no_other_file() {
    let folder = everything_that_is_read();
    folder.write("o.partial.tga", folder.read("a.tga"));
    let part = "`o.partial.tga`, where a stopped run keeps rows of `o.tga`,";
    let line = "-input s.txt -output o.tga -compare o.partial.tga";
    refuse(&folder, line, "o.partial.tga", &format!("{part} would overwrite the picture `o.partial.tga`"));
    let line = "-input s.txt -output o.tga -normals o.partial.tga";
    refuse(&folder, line, "o.partial.tga", &format!("{part} is also `o.partial.tga`"));
    // An earlier one is replaced.
    folder.run("-input s.txt -output o.tga -depth 1 2 d.tga").ok();
    // A stopped run keeps no rows of pictures whose pixels are displaced or reduced.
    let folder = Folder::with_scene(&sphere_in_perspective());
    for flags in ["-jitter", "-filter", "-jitter -filter"] {
        folder.run(&format!("-input s.txt -size 6 6 {flags} -output o.tga -normals o.partial.tga")).ok();
    }
}

#[test]
fn standard_streams_that_are_files_count() {
    let folder = everything_that_is_read();
    let opened = |name: &str| File::options().append(true).open(folder.path().join(name)).unwrap();
    for (line, output, message) in [
        ("-input s.txt -stats", "s.txt", "standard output would overwrite the scene `s.txt`"),
        ("-compare a.tga -reference b.png", "a.tga", "standard output would overwrite the picture `a.tga`"),
        ("-input s.txt -stats -output b.png", "b.png", "`b.png` and standard output are the same file"),
        (
            "-input s.txt -output - png -normals b.png",
            "b.png",
            "standard output and `b.png` are the same file",
        ),
        (
            "-merge top.tga rest.png -output - tga",
            "top.tga",
            "standard output would overwrite the part `top.tga`",
        ),
        (
            "-grade class -commands c.csv",
            "c.csv",
            "standard output would overwrite the list of commands `c.csv`",
        ),
        ("-input s.txt -error_report er", "s.txt", "standard output would overwrite the scene `s.txt`"),
    ] {
        let before = folder.read(output);
        let run = finish(folder.command(line).stdout(opened(output)));
        assert_eq!(only_line(&run.message(2)), format!("error: {message}"), "{line}");
        assert!(folder.read(output) == before, "{line}");
    }
    let input = || File::open(folder.path().join("s.txt")).unwrap();
    let run = finish(folder.command("-input - -output s.txt tga").stdin(input()));
    let expected = "error: `s.txt` would overwrite the scene standard input";
    assert_eq!(only_line(&run.message(2)), expected);
}

#[test]
fn files_are_written_together_or_not_at_all() {
    let folder = everything_that_is_read();
    folder.write("old.tga", "an earlier picture");
    symlink("/dev/full", folder.path().join("full.json")).unwrap();
    symlink("/dev/full", folder.path().join("full.png")).unwrap();
    let names = folder.names();
    // The one that fails comes last in the order of the flags, or first.
    for line in [
        "-input s.txt -output old.tga -normals new.tga -cost_map rays full.png",
        "-input s.txt -output full.png -normals old.tga -depth 1 2 new.tga",
        "-input s.txt -output old.tga -normals new.png -json full.json",
        "-input s.txt -size 4 4 -output old.tga -compare a.tga -difference full.png",
    ] {
        let message = folder.run(line).message(1);
        assert!(only_line(&message).contains("No space left on device"), "{line}: {message}");
        assert!(folder.read("old.tga") == b"an earlier picture" && folder.names() == names, "{message}");
    }
    // Half a kilobyte each: there is no room for the last one.
    let line = "-input s.txt -size 20 20 -output old.tga -normals new.tga -depth 1 2 large.exr";
    let message = with_limit(&folder, 4, line).message(1);
    assert_eq!(only_line(&message), "error: cannot write `large.exr`: File too large (os error 27)");
    assert!(folder.read("old.tga") == b"an earlier picture" && folder.names() == names, "{message}");
    folder.run("-input s.txt -size 20 20 -output old.tga -normals new.tga -depth 1 2 large.exr").ok();
    assert!(folder.read("old.tga").len() == 18 + 1200 && folder.names().contains(&"new.tga".into()));
}

#[test]
fn files_that_were_in_place_are_put_back_if_a_later_one_fails() {
    let folder = everything_that_is_read();
    folder.write("old.tga", "an earlier picture");
    let old = folder.path().join("old.tga").metadata().unwrap().ino();
    for pipe in ["first.tga", "second.json"] {
        let made = Command::new("mkfifo").arg(folder.path().join(pipe)).status();
        assert!(made.is_ok_and(|status| status.success()));
    }
    let names = folder.names();
    let pictures = "-output old.tga -depth 1 2 new.png -normals last.tga -render_filter first.tga 4";
    let line = format!("-input s.txt {pictures} -json second.json");
    let mut command = folder.command(&line);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // The pictures have been checked when the program opens the first pipe. It waits for a reader of the second.
    let mut first = File::open(folder.path().join("first.tga")).unwrap();
    create_dir(folder.path().join("last.tga")).unwrap();
    let mut second = File::open(folder.path().join("second.json")).unwrap();
    first.read_to_end(&mut vec![]).unwrap();
    second.read_to_end(&mut vec![]).unwrap();
    let output = child.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(only_line(&message), "error: cannot write `last.tga`: it is a folder");
    assert_eq!(output.status.code(), Some(1));
    assert!(folder.read("old.tga") == b"an earlier picture");
    assert_eq!(folder.path().join("old.tga").metadata().unwrap().ino(), old);
    std::fs::remove_dir(folder.path().join("last.tga")).unwrap();
    assert_eq!(folder.names(), names);
}

/// As `docker run -v file:file` does it. Needs the rights to mount.
#[cfg(target_os = "linux")]
#[test]
fn a_file_that_is_mounted_alone_is_an_error_before_rendering() {
    let folder = everything_that_is_read();
    folder.write("mounted.png", "");
    folder.write("old.tga", "an earlier picture");
    let mut shell = Command::new("unshare");
    shell.args(["--mount", "sh", "-c", "mount --bind a.tga mounted.png || exit 99; exec \"$@\"", "sh"]);
    // Rendering would take hours.
    let line = "-input s.txt -size 60000 60000 -random_samples 4096 -output old.tga -normals mounted.png";
    shell.arg(env!("CARGO_BIN_EXE_raytracer")).args(line.split_whitespace());
    let output = match shell.current_dir(folder.path()).output() {
        Ok(output) if output.status.code() != Some(99) && !output.stderr.starts_with(b"unshare: ") => output,
        _ => return skip("nothing can be mounted here"),
    };
    let message = String::from_utf8(output.stderr).unwrap();
    let expected = "error: cannot write `mounted.png`: it is mounted alone, so no other file can take its place\n  \
                    hint: mount its folder, or write elsewhere and copy\n";
    assert_eq!((output.status.code(), message.as_str()), (Some(1), expected));
    assert_eq!(folder.read("old.tga"), b"an earlier picture");
}

#[test]
fn files_that_a_scene_names_are_not_written_even_if_they_are_not_read() {
    let folder = Folder::new();
    let materials =
        |fields: &str| sphere_in_perspective().replace("Material { }", &format!("Material {{ {fields} }}"));
    folder.write("bump.txt", materials("diffuseColor 1 1 1 bump b.png"));
    folder.write("aalto.txt", materials("diffuseColor 1 1 1 texture b.png"));
    folder.write("mesh.txt", scene(1, "TriangleMesh { obj_file m.obj }"));
    let twice = sphere() + "Group { numObjects 0 }\n";
    folder.write(
        "replaced.txt",
        twice.replace("Sphere { center 0 0 0 radius .7 }", "TriangleMesh { obj_file m.obj }"),
    );
    folder.write(
        "m.obj",
        "mtllib m.mtl other.mtl\ncall called.obj 1 2\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n",
    );
    folder.write("m.mtl", "newmtl a\nmap_Kd -s 2 2 2 map.png\nbump wood grain.png\n");
    for name in ["b.png", "map.png", "wood grain.png", "called.obj", "other.mtl"] {
        folder.write(name, "an earlier file");
    }
    create_dir_all(folder.path().join("class/ann")).unwrap();
    folder.write("class/ann/o.tga", "");
    for (line, name, kind) in [
        ("-edition 2019 -input bump.txt -output b.png", "b.png", "texture"),
        ("-edition 2012a5 -input bump.txt -output o.tga -normals ./b.png", "b.png", "texture"),
        ("-edition aalto -input aalto.txt -output b.png", "b.png", "texture"),
        ("-input mesh.txt -output map.png", "map.png", "texture"),
        ("-input mesh.txt -output m.mtl tga", "m.mtl", "material library"),
        ("-input mesh.txt -output other.mtl tga", "other.mtl", "material library"),
        ("-input mesh.txt -output called.obj tga", "called.obj", "mesh"),
        ("-input replaced.txt -output m.obj tga", "m.obj", "mesh"),
    ] {
        let before = folder.read(name);
        let written = line.split_whitespace().rfind(|word| word.ends_with(name)).unwrap();
        let message = folder.run(line).message(2);
        assert_eq!(
            only_line(&message),
            format!("error: `{written}` would overwrite the {kind} `{name}`"),
            "{line}"
        );
        assert!(folder.read(name) == before && !folder.names().contains(&"o.tga".into()), "{line}");
    }
    let blank = folder.command("-input mesh.txt -output").arg("wood grain.png").output().unwrap();
    assert_eq!(blank.status.code(), Some(2));
    for (scene, name) in [("-edition 2019 -input bump.txt", "b.png"), ("-input mesh.txt", "map.png")] {
        folder.write("commands.txt", format!("raytracer {scene} -output o.tga\n"));
        symlink(name, folder.path().join("r.html")).unwrap();
        let message = format!("`r.html` would overwrite the texture `{name}`");
        refuse(&folder, "-grade class -commands commands.txt -report r.html", name, &message);
        std::fs::remove_file(folder.path().join("r.html")).unwrap();
    }
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
