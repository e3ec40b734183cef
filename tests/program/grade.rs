//! `-grade`: a folder of everybody's pictures against references, and the page and the table of the results.

use crate::support::{Folder, Run, finish, only_line, sphere};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;

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

/// A scene that looks different upside down.
fn off_centre() -> String {
    sphere().replace("0 0 0 radius .7", ".3 .2 0 radius .5")
}

/// Returns the picture with a level less in each of `count` bytes from the middle on.
fn darkened(bytes: &[u8], count: usize) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    let middle = 18 + 9 * 24 * 3 + 24;
    changed[middle..middle + count].iter_mut().for_each(|byte| *byte -= 1);
    changed
}

/// A black picture of the same size.
fn black(bytes: &[u8]) -> Vec<u8> {
    [&bytes[..18], &vec![0; bytes.len() - 18]].concat()
}

/// Returns the picture with a level more in one pixel of the middle, and a level less in another.
fn nudged(bytes: &[u8]) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    let middle = 18 + 3 * (9 * 24 + 10);
    changed[middle..middle + 3].iter_mut().for_each(|byte| *byte -= 1);
    changed[middle + 6..middle + 9].iter_mut().for_each(|byte| *byte += 1);
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
    hand_in(&folder, "Bela", "o.tga", &darkened(&picture(&folder, "o.tga"), 4));
    for (tolerance, status, expected) in [
        (
            "",
            0,
            ["none", "2 of 4, 50 percent, 1 failed, 1 missing", "0 of 2", "1 of 2, 50 percent, 1 failed"],
        ),
        ("-tolerance 1 0", 3, ["1 levels, 0 pixels", "3 of 4, 75 percent, 1 missing", "1 of 2", "2 of 2"]),
        ("-tolerance 0.5 2", 3, ["0.5 levels, 2 pixels", "3 of 4", "1 of 2", "2 of 2"]),
    ] {
        let run = folder.run(&format!("-grade class -reference ref {tolerance}"));
        assert_eq!((run.status, run.stderr.as_str()), (Some(status), ""));
        for (label, value) in ["tolerance ", "pictures that pass", "Bela", "o.tga"].iter().zip(expected) {
            let mut lines = run.stdout.lines().filter_map(|line| line.trim_start().strip_prefix(label));
            assert!(lines.any(|line| line.trim().starts_with(value)), "{label} {value}: {}", run.stdout);
        }
    }
}

/// With adaptive samples, a wrong picture has other samples too.
#[test]
fn mistakes_in_the_scene_are_not_tried_with_adaptive_samples() {
    let folder = folder();
    folder.write("wide.txt", sphere().replace("size 2", "size 4"));
    for (samples, cause) in
        [("-uniform_samples 4", "with a screen of twice the size"), ("-adaptive_samples 16 1", "unknown (")]
    {
        let line = format!("-size 24 18 {samples} -output");
        folder.run(&format!("-input wide.txt {line} class/anna/o.tga")).ok();
        folder.write("commands.txt", format!("rt -input s.txt {line} o.tga"));
        grade(&folder);
        let found = result(&folder, "anna", "o.tga");
        assert!(found.starts_with("failed,") && found.contains(cause), "{samples}: {found}");
    }
}

#[test]
fn rounding_passes_where_the_scene_is_known_and_is_said() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", &nudged(&picture(&folder, "o.tga")));
    let run = grade(&folder);
    let result = |name: &str| result(&folder, "bela", name);
    assert_eq!(result("o.tga"), "passed,1,2,0,0,1,0.068041,levels,\"rounding, 2 pixels\"");
    assert!(run.stdout.contains("2 of 2, 100 percent, 1 by rounding\n"), "{}", run.stdout);
    assert!(run.stdout.contains("ROUNDING\n  bela                       o.tga 2 pixels\n"), "{}", run.stdout);
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains("<small>rounding, 2 pixels</small>"));
    // With another rule, rounding does not pass.
    for flags in ["-reference ref", "-commands commands.txt -tolerance 0 0"] {
        folder.run(&format!("-grade class {flags} -report page.html"));
        assert!(result("o.tga").starts_with("failed,0,2,0,,1,"), "{flags}: {}", result("o.tga"));
    }
}

#[test]
fn two_pixels_need_no_explanation_and_three_do() {
    let folder = folder();
    for (who, pixels, expected) in [("two", 2, "passed,1,"), ("three", 3, "failed,0,")] {
        let mut changed = picture(&folder, "o.tga");
        // In the middle of the sphere, where no moved view is black.
        let middle = 18 + 3 * (9 * 24 + 10);
        changed[middle..middle + 3 * pixels].fill(0);
        hand_in(&folder, who, "o.tga", &changed);
        grade(&folder);
        let found = result(&folder, who, "o.tga");
        assert!(found.starts_with(&format!("{expected}{pixels},{pixels},{pixels},")), "{found}");
    }
    let two = result(&folder, "two", "o.tga");
    assert!(two.ends_with("\"rounding, 0 pixels, and 2 that it does not explain\""), "{two}");
}

#[test]
fn a_verdict_does_not_depend_on_other_names() {
    let folder = Folder::with_scene(&off_centre());
    folder
        .write("commands.txt", "rt -input s.txt -size 24 18 -output a.tga\nrt -input s.txt -output b.tga\n");
    for (who, from, to) in
        [("light", "direction 0 0 -1 color", "direction 0 0 1 color"), ("turned", "up 0 1 0", "up 0 -1 0")]
    {
        folder.write("wrong.txt", off_centre().replace(from, to));
        for (name, flags) in [("a.tga", "-size 24 18"), ("b.tga", "")] {
            folder.run(&format!("-input wrong.txt {flags} -output o.tga")).ok();
            hand_in(&folder, who, name, &folder.read("o.tga"));
        }
    }
    grade(&folder);
    let together = table(&folder);
    for who in ["light", "turned"] {
        folder.run(&format!("-grade class -commands commands.txt -student {who} -report page.html")).ok();
        let alone = table(&folder);
        assert_eq!(alone.len(), 2);
        assert!(alone.iter().all(|line| together.contains(line)), "{alone:?} {together:?}");
    }
}

#[test]
fn what_is_not_graded_is_listed_with_its_reason() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    folder.write("class/loose.tga", "");
    for name in ["o (1).tga", "d.jpg", "d.tga.bak", "tracer.cpp"] {
        hand_in(&folder, "bela", name, &right);
    }
    symlink("o.tga", folder.path().join("class/anna/linked.tga")).unwrap();
    let run = folder.run("-grade class -commands commands.txt -report page.html -json page.json").ok();
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    let document: Value = serde_json::from_slice(&folder.read("page.json")).unwrap();
    let listed = document["not_graded"].as_array().unwrap();
    assert_eq!(listed.len(), 6);
    for (path, words) in [
        ("loose.tga", "not in the folder of a name"),
        ("anna/linked.tga", "it is a link"),
        ("bela/d.jpg", "its format is not read; probably d.tga"),
        ("bela/o (1).tga", "no reference; probably o.tga"),
    ] {
        let (who, file) = path.split_once('/').unwrap_or(("", path));
        assert!(run.stdout.contains(&format!("\n  {path:<26} {words}\n")), "{path}: {}", run.stdout);
        assert!(page.contains(&format!("<li>{path}: {words}</li>")), "{path}");
        let line = format!("\"{who}\",\"{file}\",not graded,,,,,,,,\"{words}\"");
        assert!(table(&folder).contains(&line), "{line}: {:?}", table(&folder));
        assert!(listed.iter().any(|one| one["file"] == file), "{listed:?}");
    }
    assert!(run.stdout.contains("not a picture: tracer.cpp\n"), "{}", run.stdout);
    let remark = "perhaps d.jpg, d.tga.bak: its format is not read";
    assert_eq!(result(&folder, "bela", "d.tga"), format!("missing,0,,,,,,,\"{remark}\""));
    assert!(page.contains(&format!("<small>{remark}</small>")), "{remark}");
}

#[test]
fn the_document_has_the_values_of_the_table() {
    let folder = folder();
    hand_in(&folder, "bela", "d.tga", &nudged(&picture(&folder, "d.tga")));
    hand_in(&folder, "bela", "o.tga", &black(&picture(&folder, "o.tga")));
    let line = "-grade class -commands commands.txt -report page.html";
    folder.run(&format!("{line} -json page.json")).ok();
    let printed = folder.run(&format!("{line} -json -")).ok().stdout;
    assert_eq!(printed.as_bytes(), folder.read("page.json"));
    let document: Value = serde_json::from_str(&printed).unwrap();
    let pictures = document["pictures"].as_array().unwrap();
    assert_eq!(pictures.len(), table(&folder).len());
    for (one, line) in pictures.iter().zip(table(&folder)) {
        let text = |field: &str| one[field].as_str().unwrap_or_default();
        let fields = ["points", "pixels_that_differ", "by_more_than_one_level", "not_rounding"];
        let numbers =
            fields.map(|field| one[field].as_f64().map_or(String::new(), |number| number.to_string()));
        let start =
            format!("{:?},{:?},{},{},", text("name"), text("picture"), text("result"), numbers.join(","));
        let end = format!(",{},{:?}", text("unit"), text("reason"));
        assert!(line.starts_with(&start) && line.ends_with(&end), "{line}: {start} {end}");
    }
    let bela = &document["names"][1];
    assert_eq!((&bela["points"], &bela["graded"], &bela["percent"]), (&1.into(), &2.into(), &50.into()));
}

#[test]
fn one_student_is_graded_alone() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", b"");
    folder.write("class/loose.tga", "");
    let run = folder.run("-grade class -reference ref -student bela").ok();
    assert!(!run.stdout.contains("anna") && !run.stdout.contains("loose"), "{}", run.stdout);
    assert!(run.stdout.contains(" 0 of 2, 0 percent, 1 missing, 1 unusable\n"), "{}", run.stdout);
    assert!(folder.run("-grade class -reference ref -student carl").message(1).contains("`carl`"));
}

#[test]
fn numbers_are_graded_as_numbers() {
    let folder = folder();
    folder.write("commands.txt", "rt -input s.txt -size 24 18 -depth 8 9 d.pfm\n");
    for (who, z) in [("right", "9"), ("moved", "9.001")] {
        make(&folder, &format!("class/{who}"));
        folder.write("t.txt", sphere().replace("center 0 0 9", &format!("center 0 0 {z}")));
        folder.run(&format!("-input t.txt -size 24 18 -depth 8 9 class/{who}/d.pfm")).ok();
    }
    // A picture of bytes is compared with the bytes of the reference.
    make(&folder, "class/bytes");
    folder.run("-convert class/right/d.pfm -output class/bytes/d.png").ok();
    for (flags, moved) in
        [("", "failed,0"), ("-tolerance 0.01 0", "passed,1"), ("-tolerance 0.0001 0", "failed,0")]
    {
        folder.run(&format!("-grade class -commands commands.txt -report page.html {flags}"));
        let [right, found, bytes] = ["right", "moved", "bytes"].map(|who| result(&folder, who, "d.pfm"));
        assert!(right.starts_with("passed,1,0,,,0,0,numbers,"), "{right}");
        assert!(found.starts_with(moved) && found.contains(",numbers,"), "{found}");
        assert!(bytes.starts_with("passed,1,0,") && bytes.ends_with("found as d.png\""), "{bytes}");
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: two pictures of 108 MB"]
fn too_little_memory_is_an_error_and_no_verdict() {
    let folder = Folder::with_scene(&sphere());
    ["ref", "class/anna"].iter().for_each(|name| make(&folder, name));
    folder.run("-input s.txt -size 6000 6000 -output ref/o.png").ok();
    fs::copy(folder.path().join("ref/o.png"), folder.path().join("class/anna/o.png")).unwrap();
    // Room for one of the two pictures of 108 MB.
    let mut command = folder.command_within("-v 200000", "-grade class -reference ref -threads 1");
    let message = finish(&mut command).message(1);
    assert!(
        only_line(&message).starts_with("error: cannot read `") && message.contains("memory"),
        "{message}"
    );
}

#[test]
fn causes_are_found_by_the_scene_and_by_the_picture_alone() {
    let folder = Folder::with_scene(&off_centre());
    let line = "-size 90 90 -output o.tga -depth 8 9 d.tga -normals n.tga";
    folder.write("commands.txt", format!("rt -input s.txt {line}\n"));
    let reversed = off_centre().replace("direction 0 0 -1 color", "direction 0 0 1 color");
    let turned = off_centre().replace("up 0 1 0", "up 0 -1 0");
    for (place, scene) in [("ref", off_centre()), ("class/light", reversed), ("class/turned", turned)] {
        make(&folder, place);
        folder.write("t.txt", scene);
        folder.run(&format!("-input t.txt {line}")).ok();
        for name in ["o.tga", "d.tga", "n.tga"] {
            folder.write(&format!("{place}/{name}"), folder.read(name));
        }
    }
    grade(&folder);
    for (who, name, cause) in [
        ("light", "o.tga", "with directional lights from the other side"),
        ("turned", "o.tga", "(turned by 180 degrees)\""),
        ("turned", "d.tga", "(turned by 180 degrees)\""),
        ("turned", "n.tga", "(turned by 180 degrees)\""),
    ] {
        assert!(result(&folder, who, name).contains(cause), "{}", result(&folder, who, name));
    }
    folder.run("-grade class -reference ref -report page.html").ok();
    assert!(result(&folder, "turned", "o.tga").ends_with("\"turned by 180 degrees\""));
    assert!(result(&folder, "light", "o.tga").contains("unknown ("));
}

#[test]
fn a_picture_under_another_name_is_found_and_said() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    folder.run("-convert ref/o.tga -output o.png").ok();
    let png = folder.read("o.png");
    for (who, name, bytes) in [
        ("case", "O.TGA", &right),
        ("all", "sub/O.PNG", &png),
        // The nearest file counts.
        ("two", "sub/o.tga", &black(&right)),
        ("two", "o.png", &png),
        // The name itself comes first, right or wrong.
        ("own", "o.tga", &black(&right)),
        ("own", "o.png", &png),
        ("other", "oo.tga", &right),
    ] {
        make(&folder, &format!("class/{who}/sub"));
        hand_in(&folder, who, name, bytes);
    }
    symlink(folder.path().join("ref"), folder.path().join("class/other/linked")).unwrap();
    let run = grade(&folder);
    for (who, file) in [("case", "O.TGA"), ("all", "sub/O.PNG"), ("two", "o.png")] {
        assert_eq!(result(&folder, who, "o.tga"), format!("passed,1,0,0,,0,0,levels,\"found as {file}\""));
        let note = format!("note: {who}: graded {file} as o.tga\n");
        assert!(run.stderr.contains(&note), "{}", run.stderr);
    }
    assert!(result(&folder, "own", "o.tga").starts_with("failed,"));
    assert!(result(&folder, "other", "o.tga").starts_with("missing"));
    assert!(run.stdout.contains("another file is graded as o.tga\n"), "{}", run.stdout);
}

#[test]
fn what_is_no_picture_is_a_cell() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    let mut other_size = right.clone();
    (other_size[12], other_size[14]) = (18, 24);
    for (who, bytes) in [("short", &right[..right.len() - 1]), ("empty", &[]), ("other", &other_size)] {
        hand_in(&folder, who, "o.tga", bytes);
    }
    for name in ["nothing", "folder/o.tga", "fifo", "link", "dangling"] {
        make(&folder, &format!("class/{name}"));
    }
    folder.make_pipe("class/fifo/o.tga");
    symlink("../anna/o.tga", folder.path().join("class/link/o.tga")).unwrap();
    symlink("nowhere", folder.path().join("class/dangling/o.tga")).unwrap();
    assert_eq!(grade(&folder).stderr, "");
    assert_eq!(result(&folder, "anna", "o.tga"), "passed,1,0,0,,0,0,levels,\"\"");
    for (who, result_word, reason) in [
        ("nothing", "missing", ""),
        ("short", "unusable", "it is too short for 24 x 18 pixels"),
        ("empty", "unusable", "it ends within its header"),
        ("other", "unusable", "its size is 18 x 24 pixels instead of 24 x 18: it is transposed"),
        ("folder", "unusable", "it is not a regular file"),
        ("fifo", "unusable", "it is not a regular file"),
        ("link", "unusable", "it is a link"),
        ("dangling", "unusable", "it is a link"),
    ] {
        let found = result(&folder, who, "o.tga");
        assert!(found.starts_with(&format!("{result_word},0,,,,,,,\"{reason}")), "{who}: {found}");
    }
}

#[test]
fn names_are_text_and_nothing_else() {
    let folder = folder();
    let wrong = black(&picture(&folder, "o.tga"));
    for who in ["<script>alert(1)", "\"a' onclick=x", "=1+1"] {
        hand_in(&folder, who, "o.tga", &wrong);
    }
    hand_in(&folder, "anna", "<b>.tga", b"");
    let strange = folder.path().join("class").join(OsStr::from_bytes(b"\xff\x1b[2J"));
    fs::create_dir(strange).unwrap();
    make(&folder, "class/.git");
    let run = grade(&folder);
    assert!(run.stdout.contains("\n  \u{fffd}\\u{1b}[2J ") && !run.stdout.contains('\u{1b}'));
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    for text in [
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none';",
        ">&lt;script&gt;alert(1)<",
        ">&quot;a&#39; onclick=x<",
        ">\u{fffd}\\u{1b}[2J<",
        "<li>anna/&lt;b&gt;.tga: no reference</li>",
    ] {
        assert!(page.contains(text), "{text}");
    }
    for outside in [".git", "<link", "<img", "src=", "@import", "url(h"] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert_eq!(page.matches("<script").count(), 2);
    assert!(table(&folder).iter().any(|line| line.starts_with("\"'=1+1\",\"o.tga\",failed,")));
}

#[test]
fn a_missing_reference_is_told() {
    let folder = folder();
    folder.write("commands.txt", format!("{COMMANDS}rt -input none.txt -output n.tga"));
    let run = grade(&folder);
    assert!(only_line(&run.stderr).starts_with("warning: no reference for n.tga: none.txt: error: "));
    assert_eq!(result(&folder, "anna", "n.tga"), "no reference,,,,,,,,\"\"");
    let checked = folder.run("-grade class -commands commands.txt -tolerance 0 0");
    assert_eq!(checked.status, Some(3), "not everything was checked");
    folder.write("ref/broken.png", "none");
    let run = folder.run("-grade class -reference ref").ok();
    assert!(only_line(&run.stderr).starts_with("warning: no reference for broken.png: cannot read "));
}

#[test]
fn grids_and_normals_are_graded_too_and_the_last_line_of_a_picture_counts() {
    let folder = folder();
    let line = "-input s.txt -size 24 18 -grid 4 4 4 -visualize_grid";
    let lines = format!("rt -input s.txt -size 9 9 -output g.tga\nrt {line} -output g.tga -normals n.tga\n");
    folder.write("commands.txt", lines);
    folder.run(&format!("{line} -output class/anna/g.tga -normals class/anna/n.tga")).ok();
    assert!(grade(&folder).stdout.contains("pictures that pass         2 of 2, 100 percent\n"));
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
fn what_cannot_be_read_or_written_ends_the_run() {
    let folder = folder();
    make(&folder, "hollow");
    folder.write("idle.txt", "rt -input s.txt -stats");
    folder.write("none.txt", "rt -input none.txt -output o.tga");
    for (flags, error) in [
        ("-grade hollow -reference ref", "error: `hollow` has no folder of pictures in it"),
        ("-grade class -reference hollow", "error: there is no picture to grade by"),
        ("-grade class -commands ref", "error: cannot read the commands `ref`: it is not a regular file"),
        ("-grade class -commands idle.txt", "error: there is no picture to grade by"),
        ("-grade class -commands none.txt", "error: there is no reference to grade by"),
    ] {
        let message = folder.run(&format!("{flags} -report page.html")).message(1);
        assert!(message.lines().last().is_some_and(|line| line.starts_with(error)), "{flags}: {message}");
    }
    // The table cannot be written, so that the page is not either.
    make(&folder, "page.csv");
    folder.run("-grade class -reference ref -report page.html").message(1);
    assert!(!folder.names().contains(&"page.html".into()));
}
