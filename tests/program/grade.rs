//! `-grade`: a folder of everybody's pictures against references, and the page and the table of the results.

use crate::support::{Folder, Run, finish, only_line, program, says, sphere};
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::process::Command;

const COMMANDS: &str = "# the pictures of the exercise
rt -input s.txt -size 24 18 -output some/where/o.tga
rt -input s.txt -size 24 18 -depth 8 9 d.tga
";

/// A folder with a scene, its pictures as `o.tga` and `d.tga` in `ref`, and those of anna, which are right.
fn folder() -> Folder {
    let folder = Folder::with_scene(&sphere());
    folder.write("commands.txt", COMMANDS);
    ["ref", "class", "class/anna"].iter().for_each(|name| make(&folder, name));
    folder.run("-input s.txt -size 24 18 -output ref/o.tga -depth 8 9 ref/d.tga").ok();
    ["o.tga", "d.tga"].iter().for_each(|name| hand_in(&folder, "anna", name, &picture(&folder, name)));
    folder
}

fn make(folder: &Folder, name: &str) {
    fs::create_dir_all(folder.path().join(name)).unwrap();
}

/// The bytes of a reference.
fn picture(folder: &Folder, name: &str) -> Vec<u8> {
    folder.read(&format!("ref/{name}"))
}

fn hand_in(folder: &Folder, who: &str, name: &str, bytes: &[u8]) {
    make(folder, &format!("class/{who}"));
    folder.write(&format!("class/{who}/{name}"), bytes);
}

/// The same picture with its rows in the opposite order.
fn upside_down(bytes: &[u8]) -> Vec<u8> {
    let rows = bytes[18..].chunks(24 * 3).rev();
    [&bytes[..18], &rows.collect::<Vec<_>>().concat()].concat()
}

/// The same picture with one level less in so many bytes from the middle on.
fn darkened(bytes: &[u8], count: usize) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    let middle = 18 + 9 * 24 * 3 + 24;
    changed[middle..middle + count].iter_mut().for_each(|byte| *byte -= 1);
    changed
}

/// The lines of the table, without its head.
fn table(folder: &Folder) -> Vec<String> {
    let text = String::from_utf8(folder.read("page.csv")).unwrap();
    text.lines().skip(1).map(str::to_owned).collect()
}

/// The line of one picture, from the result on.
fn result(folder: &Folder, who: &str, name: &str) -> String {
    let start = format!("\"{who}\",\"{name}\",");
    let found: Vec<String> =
        table(folder).iter().filter_map(|line| line.strip_prefix(&start).map(Into::into)).collect();
    assert_eq!(found.len(), 1, "{start}: {:?}", table(folder));
    found[0].clone()
}

fn grade(folder: &Folder) -> Run {
    folder.run("-grade class -commands commands.txt -report page.html").ok()
}

#[test]
fn the_summary_counts_what_passes() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", &darkened(&picture(&folder, "o.tga"), 4));
    let block = |passed: &str, o: &str, bela: &str| {
        format!(
            "********************************************\nGRADING\n  tolerance                  {passed}\nNAMES\n  \
             anna                       2 of 2, 100 points\n  bela                       {bela}\nPICTURES\n  \
             o.tga                      {o}\n  d.tga                      1 of 2, 50 points, 1 missing\n\
             ********************************************\n"
        )
    };
    let run = grade(&folder);
    assert_eq!(run.stderr, "");
    assert_eq!(
        run.stdout,
        block(
            "0 levels, 0 pixels\n  pictures that pass         2 of 4, 50 points, 1 failed, 1 missing",
            "1 of 2, 50 points, 1 failed",
            "0 of 2, 0 points, 1 failed, 1 missing"
        )
    );
    let run = folder.run("-grade class -commands commands.txt -tolerance 1 0");
    assert_eq!(run.status, Some(3), "one is missing");
    assert_eq!(
        run.stdout,
        block(
            "1 levels, 0 pixels\n  pictures that pass         3 of 4, 75 points, 1 missing",
            "2 of 2, 100 points",
            "1 of 2, 50 points, 1 missing"
        )
    );
}

#[test]
fn a_tolerance_makes_it_a_check() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", &darkened(&picture(&folder, "o.tga"), 9));
    hand_in(&folder, "bela", "d.tga", &picture(&folder, "d.tga"));
    for (tolerance, status) in [("", 0), ("-tolerance 0 0", 3), ("-tolerance 0 2", 3), ("-tolerance 0 3", 0)]
    {
        let run = folder.run(&format!("-grade class -reference ref {tolerance}"));
        assert_eq!(run.status, Some(status), "{tolerance}: {run:?}");
    }
}

/// With adaptive samples, a wrong picture has other samples too.
#[test]
fn mistakes_in_the_scene_are_not_tried_with_adaptive_samples() {
    let folder = folder();
    folder.write("wide.txt", sphere().replace("size 2", "size 4"));
    for (samples, cause) in [
        ("-uniform_samples 4", "with a screen of twice the size"),
        ("-adaptive_samples 16 1", "unknown (12 "),
    ] {
        let line = format!("-size 24 18 {samples} -output");
        folder.run(&format!("-input wide.txt {line} class/anna/o.tga")).ok();
        folder.write("commands.txt", format!("rt -input s.txt {line} o.tga"));
        grade(&folder);
        let found = result(&folder, "anna", "o.tga");
        assert!(found.starts_with("failed,") && found.contains(cause), "{samples}: {found}");
    }
}

#[test]
fn rounding_is_no_bug_and_a_picture_that_passes_has_no_cause() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", &darkened(&picture(&folder, "o.tga"), 9));
    grade(&folder);
    let failed = result(&folder, "bela", "o.tga");
    assert!(failed.ends_with("\"rounding of single precision, passes with -tolerance 1 0\""), "{failed}");
    let line = "-grade class -commands commands.txt -report page.html -tolerance";
    // Another picture is missing.
    assert_eq!(folder.run(&format!("{line} 1 0")).status, Some(3));
    let passed = result(&folder, "bela", "o.tga");
    assert!(passed.starts_with("passed,3,") && !passed.contains("rounding"), "{passed}");
}

#[test]
fn a_mistake_of_several_pictures_is_found_beside_another() {
    let folder = Folder::with_scene(&sphere().replace("0 0 0 radius .7", ".3 .2 0 radius .5"));
    let names = ["a", "b", "c"];
    let line = |name: &str| format!("-input s.txt -size 24 18 -output {name}.tga");
    let lines: Vec<String> = names.iter().map(|name| format!("rt {}\n", line(name))).collect();
    folder.write("commands.txt", lines.concat());
    names.iter().for_each(|name| drop(folder.run(&line(name)).ok()));
    for name in &names[..2] {
        hand_in(&folder, "over", &format!("{name}.tga"), &upside_down(&folder.read(&format!("{name}.tga"))));
    }
    folder.write(
        "reversed.txt",
        String::from_utf8(folder.read("s.txt"))
            .unwrap()
            .replace("direction 0 0 -1 color", "direction 0 0 1 color"),
    );
    folder.run("-input reversed.txt -size 24 18 -output r.tga").ok();
    hand_in(&folder, "over", "c.tga", &upside_down(&folder.read("r.tga")));
    grade(&folder);
    let found = result(&folder, "over", "c.tga");
    assert!(
        found.contains("upside down") && found.contains(" and ") && found.contains("from the other side"),
        "{found}"
    );
}

#[test]
fn a_tolerance_is_proposed_that_failed_pictures_pass() {
    let folder = Folder::with_scene(&sphere());
    for name in ["ref", "class/near", "class/far"] {
        make(&folder, name);
    }
    folder.run("-input s.txt -size 120 100 -output ref/o.tga").ok();
    let right = folder.read("ref/o.tga");
    let mut near = right.clone();
    near[18_000..18_150].fill(0);
    folder.write("class/near/o.tga", near);
    folder.write("class/far/o.tga", [&right[..18], &vec![0; right.len() - 18]].concat());
    let run = folder.run("-grade class -reference ref").ok();
    assert_eq!(run.stderr, "note: 1 of the 2 failed pictures pass with `-tolerance 1 50`\n");
    assert_eq!(folder.run("-grade class -reference ref -tolerance 1 50").stderr, "");
}

#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_is_an_error_and_no_verdict() {
    let folder = Folder::with_scene(&sphere());
    ["ref", "class/anna"].iter().for_each(|name| make(&folder, name));
    folder.run("-input s.txt -size 6000 6000 -output ref/o.png").ok();
    fs::copy(folder.path().join("ref/o.png"), folder.path().join("class/anna/o.png")).unwrap();
    let mut command = Command::new("sh");
    // Room for one of the two pictures of 108 MB.
    command.args(["-c", "ulimit -v 200000 && exec \"$@\"", "sh", env!("CARGO_BIN_EXE_raytracer")]);
    command.args(["-grade", "class", "-reference", "ref", "-threads", "1"]).current_dir(folder.path());
    let message = finish(&mut command).message(1);
    assert!(only_line(&message).starts_with("error: cannot read `"), "{message}");
    assert!(message.contains("memory"), "{message}");
}

#[test]
fn a_grading_without_any_reference_is_an_error() {
    let folder = folder();
    folder.write("commands.txt", "rt -input none.txt -output o.tga");
    let run = folder.run("-grade class -commands commands.txt -report page.html");
    let message = run.message(1);
    assert!(message.ends_with("error: there is no reference to grade by\n"), "{message}");
    assert!(!folder.names().contains(&"page.html".to_owned()));
}

#[test]
fn causes_are_found_by_the_scene_and_by_the_picture_alone() {
    let folder = Folder::with_scene(&sphere().replace("0 0 0 radius .7", ".3 .2 0 radius .5"));
    folder.write("commands.txt", COMMANDS);
    folder.run("-input s.txt -size 24 18 -output o.tga -depth 8 9 d.tga").ok();
    make(&folder, "ref");
    ["o.tga", "d.tga"].iter().for_each(|name| folder.write(&format!("ref/{name}"), folder.read(name)));
    for name in ["o.tga", "d.tga"] {
        hand_in(&folder, "over", name, &upside_down(&folder.read(name)));
    }
    folder.write(
        "reversed.txt",
        String::from_utf8(folder.read("s.txt"))
            .unwrap()
            .replace("direction 0 0 -1 color", "direction 0 0 1 color"),
    );
    make(&folder, "class/light");
    folder.run("-input reversed.txt -size 24 18 -output class/light/o.tga").ok();
    grade(&folder);
    for (who, name, end) in [
        ("over", "o.tga", "\"upside down\""),
        ("over", "d.tga", "\"upside down\""),
        ("light", "o.tga", "\"with directional lights from the other side\""),
    ] {
        assert!(result(&folder, who, name).ends_with(end), "{}", result(&folder, who, name));
    }
    folder.run("-grade class -reference ref -report page.html").ok();
    assert!(result(&folder, "over", "o.tga").ends_with("\"upside down\""));
    assert!(result(&folder, "light", "o.tga").ends_with("\"unknown (7 causes tried)\""));
}

#[test]
fn a_picture_under_another_name_is_found_and_said() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    folder.run("-input s.txt -size 24 18 -output ref/o.png").ok();
    let png = folder.read("ref/o.png");
    fs::remove_file(folder.path().join("ref/o.png")).unwrap();
    for (who, name, bytes) in [
        ("case", "O.TGA", &right),
        ("ending", "o.png", &png),
        ("deep", "sub/deeper/o.tga", &right),
        ("all", "sub/O.PNG", &png),
        // What is nearer is taken.
        ("two", "sub/o.tga", &darkened(&right, 9)),
        ("two", "o.png", &png),
        // The name itself comes first, right or wrong.
        ("own", "o.tga", &darkened(&right, 9)),
        ("own", "o.png", &png),
        ("other", "oo.tga", &right),
    ] {
        make(&folder, &format!("class/{who}/sub/deeper"));
        hand_in(&folder, who, name, bytes);
    }
    symlink(folder.path().join("ref"), folder.path().join("class/other/linked")).unwrap();
    let run = grade(&folder);
    for (who, file) in [
        ("case", "O.TGA"),
        ("ending", "o.png"),
        ("deep", "sub/deeper/o.tga"),
        ("all", "sub/O.PNG"),
        ("two", "o.png"),
    ] {
        assert_eq!(result(&folder, who, "o.tga"), format!("passed,0,0,0,0,\"found as {file}\""));
        let note = format!("note: {who}: graded {file} as o.tga\n");
        assert!(run.stderr.contains(&note), "{}", run.stderr);
    }
    assert!(result(&folder, "own", "o.tga").starts_with("failed,"));
    assert!(result(&folder, "other", "o.tga").starts_with("missing"));
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains("own: no reference for o.png") && !page.contains("ending: no reference"));
}

#[test]
fn causes_of_depths_and_normals_and_of_small_windows_are_found() {
    let folder = Folder::with_scene(&sphere().replace("0 0 0 radius .7", ".3 .2 0 radius .5"));
    let lines = "rt -input s.txt -size 90 90 -output o.tga -depth 8 9 d.tga -normals n.tga\n";
    folder.write("commands.txt", lines);
    let wide = String::from_utf8(folder.read("s.txt")).unwrap().replace("up 0 1 0", "up 0 -1 0");
    folder.write("turned.txt", wide);
    make(&folder, "class/turned");
    let turned = "-input turned.txt -size 90 90 -output class/turned/o.tga -depth 8 9 class/turned/d.tga -normals class/turned/n.tga";
    folder.run(turned).ok();
    grade(&folder);
    for name in ["o.tga", "d.tga", "n.tga"] {
        let end = "\"by a camera of the other handedness (turned by 180 degrees)\"";
        assert!(result(&folder, "turned", name).ends_with(end), "{}", result(&folder, "turned", name));
    }
}

#[test]
fn what_is_no_picture_is_a_cell() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    let huge = [&[0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 24, 32], &right[18..]].concat();
    let packed = [&[0, 0, 10, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 24, 32], &right[18..]].concat();
    let mut other_size = right.clone();
    (other_size[12], other_size[14]) = (18, 24);
    for (who, bytes) in [
        ("short", &right[..right.len() - 1]),
        ("header", &right[..10]),
        ("empty", &[]),
        ("huge", &huge),
        ("packed", &packed),
        ("other", &other_size),
        ("text", b"no picture at all, but long enough for a header"),
    ] {
        hand_in(&folder, who, "o.tga", bytes);
    }
    make(&folder, "class/nothing");
    make(&folder, "class/folder/o.tga");
    make(&folder, "class/fifo");
    assert!(Command::new("mkfifo").arg(folder.path().join("class/fifo/o.tga")).status().unwrap().success());
    make(&folder, "class/link");
    symlink("../anna/o.tga", folder.path().join("class/link/o.tga")).unwrap();
    make(&folder, "class/dangling");
    symlink("nowhere", folder.path().join("class/dangling/o.tga")).unwrap();
    assert_eq!(grade(&folder).stderr, "");
    for (who, expected) in [
        ("anna", "passed,0,0,0,0,\"\""),
        ("nothing", "missing,,,,,\"\""),
        ("short", "unusable,,,,,\"it is too short for 24 x 18 pixels\""),
        ("header", "unusable,,,,,\"it ends within its header\""),
        ("empty", "unusable,,,,,\"it ends within its header\""),
        ("huge", "unusable,,,,,\"it is too short for 65535 x 65535 pixels\""),
        ("packed", "unusable,,,,,\"it is too short for 65535 x 65535 pixels\""),
        ("other", "unusable,,,,,\"its size is 18 x 24 pixels instead of 24 x 18\""),
        ("text", "unusable,,,,,\"TGA of type 32 is not supported\""),
        ("folder", "unusable,,,,,\"it is not a regular file\""),
        ("fifo", "unusable,,,,,\"it is not a regular file\""),
        ("link", "unusable,,,,,\"it is a link\""),
        ("dangling", "unusable,,,,,\"it is a link\""),
    ] {
        assert_eq!(result(&folder, who, "o.tga"), expected, "{who}");
    }
}

#[test]
fn names_are_text_and_nothing_else() {
    let folder = folder();
    let wrong = upside_down(&darkened(&picture(&folder, "o.tga"), 4));
    for who in ["<script>alert(1)", "\"a' onclick=x", "=1+1", "a,b"] {
        hand_in(&folder, who, "o.tga", &wrong);
    }
    hand_in(&folder, "anna", "<b>.tga", b"");
    let strange = folder.path().join("class").join(OsStr::from_bytes(b"\xff\x1b[2J"));
    fs::create_dir(strange).unwrap();
    folder.write("class/notes.doc", "");
    make(&folder, "class/.git");
    let run = grade(&folder);
    assert!(
        run.stdout.contains("\n  \u{fffd}\\u{1b}[2J ") && !run.stdout.contains('\u{1b}'),
        "{}",
        run.stdout
    );
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    for text in [
        ">&lt;script&gt;alert(1)<",
        ">&quot;a&#39; onclick=x<",
        ">\u{fffd}\\u{1b}[2J<",
        "<li>notes.doc: not a folder</li>",
        "<li>anna: no reference for &lt;b&gt;.tga</li>",
    ] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains(".git") && page.matches("<script").count() == 2);
    assert!(table(&folder).iter().any(|line| line.starts_with("\"'=1+1\",\"o.tga\",failed,")));
    assert!(table(&folder).iter().any(|line| line.starts_with("\"a,b\",\"o.tga\",failed,")));
}

#[test]
fn the_page_is_one_file_and_has_a_wrong_picture_once() {
    let folder = folder();
    let wrong = upside_down(&darkened(&picture(&folder, "o.tga"), 4));
    ["b", "c", "d"].iter().for_each(|who| hand_in(&folder, who, "o.tga", &wrong));
    grade(&folder);
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';"));
    for outside in ["http:", "https:", "<link", "<img", "src=", "@import", "url(h"] {
        assert!(!page.contains(outside), "{outside}");
    }
    let (_, pictures) = page.split_once("id=\"pictures\">[").unwrap();
    let pictures = pictures.split_once(']').unwrap().0;
    assert_eq!(pictures.split(',').count(), 2, "the reference and the wrong one");
    assert_eq!(page.matches("<td class=\"failed\" data-a=\"1\" data-b=\"0\"").count(), 3);
    // One thumbnail of each reference, and one of the wrong picture.
    assert_eq!(page.matches("{background-image:").count(), 3);
}

#[test]
fn the_last_of_the_lines_that_write_a_picture_counts() {
    let folder = folder();
    folder.write(
        "commands.txt",
        "rt -input s.txt -size 9 9 -output o.tga\nrt -input s.txt -size 24 18 -output o.tga",
    );
    assert!(grade(&folder).stdout.contains("pictures that pass         1 of 1, 100 points\n"));
}

#[test]
fn a_missing_reference_is_told() {
    let folder = folder();
    folder.write("commands.txt", format!("{COMMANDS}rt -input none.txt -output n.tga"));
    let run = folder.run("-grade class -commands commands.txt -report page.html").ok();
    let start = "warning: no reference for n.tga: none.txt: error: cannot read the scene: ";
    assert!(only_line(&run.stderr).starts_with(start), "{}", run.stderr);
    assert!(run.stdout.contains("\n  n.tga                      NULL\n"), "{}", run.stdout);
    assert_eq!(result(&folder, "anna", "n.tga"), "no reference,,,,,\"\"");
    let checked = folder.run("-grade class -commands commands.txt -tolerance 0 0");
    assert_eq!(checked.status, Some(3), "not everything was checked");
    folder.write("ref/broken.png", "none");
    let run = folder.run("-grade class -reference ref").ok();
    let start = "warning: no reference for broken.png: cannot read `ref/broken.png`: ";
    assert!(only_line(&run.stderr).starts_with(start), "{}", run.stderr);
}

#[test]
fn grids_and_normals_are_graded_too() {
    let folder = folder();
    folder.write(
        "commands.txt",
        "rt -input s.txt -size 24 18 -grid 4 4 4 -visualize_grid -output g.tga -normals n.tga",
    );
    folder.run("-input s.txt -size 24 18 -grid 4 4 4 -visualize_grid -output class/anna/g.tga -normals class/anna/n.tga").ok();
    assert!(grade(&folder).stdout.contains("pictures that pass         2 of 2, 100 points\n"));
}

#[test]
fn the_results_do_not_depend_on_the_threads() {
    let folder = folder();
    for n in 0..5 {
        hand_in(&folder, &format!("n{n}"), "o.tga", &darkened(&picture(&folder, "o.tga"), 3 * n));
    }
    let mut found = Vec::new();
    for threads in [1, 3] {
        let line = format!("-grade class -commands commands.txt -report page.html -threads {threads}");
        found.push((folder.run(&line).ok().stdout, folder.read("page.html"), folder.read("page.csv")));
    }
    assert!(found[0] == found[1]);
}

#[test]
fn a_command_line_that_makes_no_sense_is_refused() {
    let folder = folder();
    for (line, message) in [
        ("-grade class", "-reference ... -commands"),
        ("-report page.html", "-grade <folder>"),
        ("-input s.txt -commands commands.txt", "-commands ... -grade"),
        ("-grade class -reference ref -report page.txt", "-report ... page.txt"),
        ("-grade class -reference ref -commands commands.txt", "-reference ... -commands"),
        ("-grade class -reference ref -input s.txt", "-grade ... -input"),
        ("-grade class -reference ref -stats", "-grade ... -stats"),
        ("-grade class -reference ref -compare o.tga", "-grade ... -compare"),
    ] {
        assert!(says(&folder.run(line).message(2), message), "{line}");
    }
}

#[test]
fn what_cannot_be_read_or_written_ends_the_run() {
    let folder = folder();
    make(&folder, "hollow");
    folder.write("bad.txt", "\nrt -input s.txt -sise 3 3");
    folder.write("idle.txt", "rt -input s.txt -stats");
    let with = |flags: &str| folder.run(flags).message(1);
    for (line, start) in [
        ("-grade none -reference ref", "error: cannot read the folder `none`: "),
        ("-grade s.txt -reference ref", "error: cannot read the folder `s.txt`: "),
        (
            "-grade hollow -reference ref",
            "error: `hollow` has no folder of pictures in it: put the pictures of each name into a folder",
        ),
        ("-grade class -reference none", "error: cannot read the folder `none`: "),
        ("-grade class -reference hollow", "error: there is no picture to grade by"),
        ("-grade class -commands ref", "error: cannot read the commands `ref`: it is not a regular file"),
        ("-grade class -commands idle.txt", "error: there is no picture to grade by"),
        ("-grade class -reference ref -report none/p.html", "error: cannot write `none/p.html`: "),
    ] {
        let message = with(line);
        assert!(only_line(&message).starts_with(start), "{line}: {message}");
    }
    let message = with("-grade class -commands bad.txt");
    assert_eq!(
        message,
        "error: `bad.txt`, line 2: unexpected argument '-sise' found\n  hint: did you mean '-size'?\n"
    );
    // The table cannot be written, so that the page is not either.
    make(&folder, "page.csv");
    with("-grade class -reference ref -report page.html");
    assert!(!folder.names().contains(&"page.html".into()));
}

#[test]
fn progress_is_for_terminals_alone() {
    let folder = folder();
    let run = finish(&mut program(folder.path(), ["-grade", "class", "-reference", "ref"])).ok();
    assert_eq!(run.stderr, "");
}
