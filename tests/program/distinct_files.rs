//! Files that are written twice or also read, by whatever names; files that are written together or not at all.

#[cfg(target_os = "linux")]
use crate::support::skip;
use crate::support::{Folder, Run, finish, only_line, scene, sphere, sphere_in_perspective};
use std::fs::{File, create_dir, create_dir_all};
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
    symlink("o.tga", folder.path().join("link.tga")).unwrap();
    symlink("new.tga", folder.path().join("one.tga")).unwrap();
    symlink("o.tga", folder.path().join("document.json")).unwrap();
    let before = folder.names();
    for (flags, message) in [
        ("-output o.tga -normals link.tga", "`o.tga` and `link.tga` are the same file"),
        ("-output one.tga -normals folder/../new.tga", "`one.tga` and `folder/../new.tga` are the same file"),
        ("-output o.tga -compare b.tga -difference link.tga", "`o.tga` and `link.tga` are the same file"),
        ("-output o.tga -json document.json", "`o.tga` and `document.json` are the same file"),
        ("-output folder/a.tga -depth 1 2 folder/./a.tga", "`folder/a.tga` would be written twice"),
        ("-render_samples a.tga 4 -render_filter a.tga 4", "`a.tga` would be written twice"),
    ] {
        assert_eq!(folder.run(&format!("-input s.txt {flags}")).message(2), format!("error: {message}\n"));
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
    ("-input s.txt -normals NEW.png -reference b.png", "b.png", "picture"),
    ("-compare a.tga -reference b.png -difference NEW.tga", "b.png", "picture"),
    ("-compare a.tga -reference b.png -json NEW.json", "a.tga", "picture"),
    ("-input s.txt -size 4 4 -compare a.tga -difference NEW.png", "s.txt", "scene"),
    ("-input s.txt -output o.tga -depth 1 2 NEW.pfm", "m.obj", "mesh"),
    ("-input s.txt -cost_map rays NEW.png", "s.txt", "scene"),
    ("-input s.txt -render_samples NEW.tga 2", "m.obj", "mesh"),
    ("-input s.txt -render_filter NEW.tga 2", "s.txt", "scene"),
    ("-input s.txt -size 4 4 -error_report er", "s.txt", "scene"),
    ("-merge top.tga rest.png -output NEW.png", "rest.png", "part"),
    ("-grade class -commands c.csv -report NEW.html", "c.csv", "list of commands"),
    ("-grade class -commands c.csv -report NEW.html", "m.obj", "mesh"),
    ("-grade class -commands c.csv -report NEW.html", "class/bob/a.tga", "picture"),
    ("-grade class -reference ref -report NEW.html", "ref/a.tga", "picture"),
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
    create_dir(folder.path().join("er")).unwrap();
    for &(line, read, kind) in OVERWRITING {
        let name = line.split_whitespace().find(|word| word.starts_with("NEW")).unwrap_or("er/report.csv");
        symlink(folder.path().join(read), folder.path().join(name)).unwrap();
        refuse(&folder, line, read, &format!("`{name}` would overwrite the {kind} `{read}`"));
        std::fs::remove_file(folder.path().join(name)).unwrap();
    }
    // The table of a page has its name with another ending.
    let line = "-grade class -commands c.csv -report c.html";
    refuse(&folder, line, "c.csv", "`c.csv` would overwrite the list of commands `c.csv`");
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
    for (line, output, message) in [
        ("-input s.txt -stats", "s.txt", "standard output would overwrite the scene `s.txt`"),
        ("-compare a.tga -reference b.png", "a.tga", "standard output would overwrite the picture `a.tga`"),
        ("-input s.txt -stats -output b.png", "b.png", "`b.png` and standard output are the same file"),
        ("-merge top.tga -output - tga", "top.tga", "standard output would overwrite the part `top.tga`"),
        (
            "-grade class -commands c.csv",
            "c.csv",
            "standard output would overwrite the list of commands `c.csv`",
        ),
        ("-input s.txt -error_report er", "s.txt", "standard output would overwrite the scene `s.txt`"),
    ] {
        let before = folder.read(output);
        let opened = File::options().append(true).open(folder.path().join(output)).unwrap();
        let run = finish(folder.command(line).stdout(opened));
        assert_eq!(only_line(&run.message(2)), format!("error: {message}"), "{line}");
        assert!(folder.read(output) == before, "{line}");
    }
    let input = File::open(folder.path().join("s.txt")).unwrap();
    let message = finish(folder.command("-input - -output s.txt tga").stdin(input)).message(2);
    assert_eq!(only_line(&message), "error: `s.txt` would overwrite the scene standard input");
}

#[test]
fn files_are_written_together_or_not_at_all() {
    let folder = everything_that_is_read();
    folder.write("old.tga", "an earlier picture");
    symlink("/dev/full", folder.path().join("full.json")).unwrap();
    symlink("/dev/full", folder.path().join("full.png")).unwrap();
    let names = folder.names();
    let refuse = |run: Run, expected: &str| {
        let message = run.message(1);
        assert!(only_line(&message).contains(expected), "{message}");
        assert!(folder.read("old.tga") == b"an earlier picture" && folder.names() == names, "{message}");
    };
    // The one that fails comes last in the order of the flags, or first.
    for line in [
        "-input s.txt -output old.tga -normals new.tga -cost_map rays full.png",
        "-input s.txt -output full.png -normals old.tga -depth 1 2 new.tga",
        "-input s.txt -output old.tga -normals new.png -json full.json",
        "-input s.txt -size 4 4 -output old.tga -compare a.tga -difference full.png",
    ] {
        refuse(folder.run(line), "No space left on device");
    }
    // Two kilobytes each: there is no room for the last one, or for one that is not kept in memory.
    let line = "-input s.txt -size 20 20 -output old.tga -normals new.tga -depth 1 2 large.exr";
    for (line, name) in [(line, "large.exr"), ("-input s.txt -size 1700 1700 -output old.tga", "old.tga")] {
        refuse(
            finish(&mut folder.command_within("-f 4", line)),
            &format!("error: cannot write `{name}`: File too large"),
        );
    }
    folder.run(line).ok();
    assert!(folder.read("old.tga").len() == 18 + 1200 && folder.names().contains(&"new.tga".into()));
}

#[test]
fn files_that_were_in_place_are_put_back_if_a_later_one_fails() {
    let folder = everything_that_is_read();
    folder.write("old.tga", "an earlier picture");
    let old = folder.path().join("old.tga").metadata().unwrap().ino();
    for pipe in ["first.tga", "second.json"] {
        folder.make_pipe(pipe);
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
    assert_eq!(output.status.code(), Some(1));
    assert!(message.starts_with("error: cannot write `mounted.png`: it is mounted alone"), "{message}");
    assert!(message.contains("\n  hint: mount its folder"), "{message}");
    assert_eq!(folder.read("old.tga"), b"an earlier picture");
}

#[test]
fn files_that_a_scene_names_are_not_written_even_if_they_are_not_read() {
    let folder = Folder::new();
    let material = |fields: &str| {
        sphere_in_perspective()
            .replace("Material { }", &format!("Material {{ diffuseColor 1 1 1 {fields} }}"))
    };
    folder.write("bump.txt", material("bump b.png"));
    folder.write("aalto.txt", material("texture b.png"));
    folder.write("mesh.txt", scene(1, "TriangleMesh { obj_file m.obj }"));
    let replaced = sphere().replace("Sphere { center 0 0 0 radius .7 }", "TriangleMesh { obj_file m.obj }");
    folder.write("replaced.txt", replaced + "Group { numObjects 0 }\n");
    folder.write("m.obj", "mtllib m.mtl\ncall called.obj 1 2\nv -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n");
    folder.write("m.mtl", "newmtl a\nmap_Kd -s 2 2 2 map.png\nbump wood grain.png\n");
    for name in ["b.png", "map.png", "wood grain.png", "called.obj"] {
        folder.write(name, "an earlier file");
    }
    create_dir_all(folder.path().join("class/ann")).unwrap();
    folder.write("class/ann/o.tga", "");
    for (scene, name, kind) in [
        ("-edition 2019 -input bump.txt", "b.png", "texture"),
        ("-edition aalto -input aalto.txt", "b.png", "texture"),
        ("-input mesh.txt", "map.png", "texture"),
        ("-input mesh.txt", "m.mtl", "material library"),
        ("-input mesh.txt", "called.obj", "mesh"),
        ("-input replaced.txt", "m.obj", "mesh"),
    ] {
        let message = format!("`{name}` would overwrite the {kind} `{name}`");
        let format = if name.ends_with("png") { "" } else { "png" };
        refuse(&folder, &format!("{scene} -output {name} {format}"), name, &message);
        folder.write("commands.txt", format!("raytracer {scene} -output o.tga\n"));
        symlink(name, folder.path().join("r.html")).unwrap();
        let message = format!("`r.html` would overwrite the {kind} `{name}`");
        refuse(&folder, "-grade class -commands commands.txt -report r.html", name, &message);
        std::fs::remove_file(folder.path().join("r.html")).unwrap();
    }
    let blank = folder.command("-input mesh.txt -output").arg("wood grain.png").output().unwrap();
    assert_eq!(blank.status.code(), Some(2));
}

#[test]
fn the_files_of_a_report_differ() {
    let folder = everything_that_is_read();
    create_dir(folder.path().join("er")).unwrap();
    symlink("report.html", folder.path().join("er/report.csv")).unwrap();
    let message = folder.run("-input s.txt -size 4 4 -error_report er").message(2);
    assert_eq!(only_line(&message), "error: `er/report.html` and `er/report.csv` are the same file");
    symlink("p.html", folder.path().join("p.csv")).unwrap();
    let message = folder.run("-grade class -reference ref -report p.html").message(2);
    assert_eq!(only_line(&message), "error: `p.html` and `p.csv` are the same file");
}
