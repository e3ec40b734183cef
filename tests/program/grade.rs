//! `-grade`: a folder of everybody's pictures against references, and the page and the table of the results.

use crate::support::{Folder, Run, finish, only_line, sphere};
use serde_json::Value;
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
    let block = |passed: &str, o: &str, bela: &str| {
        format!(
            "********************************************\nGRADING\n  tolerance                  {passed}\nNAMES\n  \
             anna                       2 of 2, 100 percent\n  Bela                       {bela}\nPICTURES\n  \
             d.tga                      1 of 2, 50 percent, 1 missing\n  o.tga                      {o}\n\
             ********************************************\n"
        )
    };
    let run = folder.run("-grade class -reference ref").ok();
    assert_eq!(run.stderr, "");
    assert_eq!(
        run.stdout,
        block(
            "none\n  pictures that pass         2 of 4, 50 percent, 1 failed, 1 missing",
            "1 of 2, 50 percent, 1 failed",
            "0 of 2, 0 percent, 1 failed, 1 missing"
        )
    );
    for (tolerance, shown) in [("1 0", "1 levels, 0 pixels"), ("0.5 2", "0.5 levels, 2 pixels")] {
        let run = folder.run(&format!("-grade class -reference ref -tolerance {tolerance}"));
        assert_eq!(run.status, Some(3), "one is missing");
        let passed = format!("{shown}\n  pictures that pass         3 of 4, 75 percent, 1 missing");
        assert_eq!(run.stdout, block(&passed, "2 of 2, 100 percent", "1 of 2, 50 percent, 1 missing"));
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
    for text in [
        "tolerance                  rounding of single precision, and 2 pixels\n",
        "bela                       1 of 2, 50 percent, 1 by rounding, 1 missing\n",
        "o.tga                      2 of 2, 100 percent, 1 by rounding\n",
        "ROUNDING\n  bela                       o.tga 2 pixels\n",
    ] {
        assert!(run.stdout.contains(text), "{text}: {}", run.stdout);
    }
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains("<small>rounding, 2 pixels</small>"));
    // With another rule, it is not asked.
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
    let folder = Folder::with_scene(&sphere().replace("0 0 0 radius .7", ".3 .2 0 radius .5"));
    let names = ["a", "b", "c"];
    let line = |name: &str| format!("-input s.txt -size 24 18 -output {name}.tga");
    let lines: Vec<String> = names.iter().map(|name| format!("rt {}\n", line(name))).collect();
    folder.write("commands.txt", lines.concat());
    let scene = String::from_utf8(folder.read("s.txt")).unwrap();
    folder.write("reversed.txt", scene.replace("direction 0 0 -1 color", "direction 0 0 1 color"));
    for (who, scene) in [("light", "reversed"), ("over", "s")] {
        make(&folder, &format!("class/{who}"));
        for name in names {
            folder.run(&format!("-input {scene}.txt -size 24 18 -output o.tga")).ok();
            hand_in(&folder, who, &format!("{name}.tga"), &upside_down(&folder.read("o.tga")));
        }
    }
    grade(&folder);
    let together = table(&folder);
    for who in ["light", "over"] {
        folder.run(&format!("-grade class -commands commands.txt -student {who} -report page.html")).ok();
        let alone = table(&folder);
        assert!(
            alone.len() == 3 && alone.iter().all(|line| together.contains(line)),
            "{alone:?} {together:?}"
        );
    }
}

#[test]
fn what_is_not_graded_is_listed_with_its_reason() {
    let folder = folder();
    let right = picture(&folder, "o.tga");
    folder.write("class/loose.tga", "");
    for name in ["o (1).tga", "d.jpg", "d.tga.bak", "tracer.cpp", "other.png"] {
        hand_in(&folder, "bela", name, &right);
    }
    make(&folder, "class/anna/old");
    hand_in(&folder, "anna", "old/o.tga", &right);
    symlink("o.tga", folder.path().join("class/anna/linked.tga")).unwrap();
    let run = folder.run("-grade class -commands commands.txt -report page.html -json page.json").ok();
    let files = [
        ("", "loose.tga", "not in the folder of a name"),
        ("anna", "linked.tga", "it is a link"),
        ("anna", "old/o.tga", "another file is graded as o.tga"),
        ("bela", "d.jpg", "its format is not read; probably d.tga"),
        ("bela", "d.tga.bak", "its format is not read; probably d.tga"),
        ("bela", "o (1).tga", "no reference; probably o.tga"),
        ("bela", "other.png", "no reference"),
        ("bela", "tracer.cpp", "not a picture"),
    ];
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    let document: Value = serde_json::from_slice(&folder.read("page.json")).unwrap();
    for (who, file, words) in files {
        let path = if who.is_empty() { file.into() } else { format!("{who}/{file}") };
        let line = if file == "tracer.cpp" {
            format!("  {who:<26} {words}: {file}\n")
        } else {
            format!("  {path:<26} {words}\n")
        };
        assert!(run.stdout.contains(&line), "{line}: {}", run.stdout);
        assert!(page.contains(&format!("<li>{path}: {words}</li>")), "{path}");
        let line = format!("\"{who}\",\"{file}\",not graded,,,,,,,,\"{words}\"");
        assert!(table(&folder).contains(&line), "{line}: {:?}", table(&folder));
        let listed = document["not_graded"].as_array().unwrap();
        assert!(listed.iter().any(|one| one["file"] == file), "{listed:?}");
    }
    assert_eq!(document["not_graded"].as_array().map(Vec::len), Some(files.len()));
    for (name, remark) in [
        ("o.tga", "perhaps o (1).tga: no reference"),
        ("d.tga", "perhaps d.jpg, d.tga.bak: its format is not read"),
    ] {
        assert_eq!(result(&folder, "bela", name), format!("missing,0,,,,,,,\"{remark}\""));
        assert!(page.contains(&format!("<small>{remark}</small>")), "{remark}");
    }
    assert!(result(&folder, "anna", "o.tga").ends_with("\"\""), "a picture that passes needs no other");
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
    let text = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        other => other.as_f64().unwrap().to_string(),
    };
    for (one, line) in pictures.iter().zip(table(&folder)) {
        let error = match &one["root_mean_square_error"] {
            Value::Null => String::new(),
            error if error.as_f64() == Some(0.0) => "0".into(),
            error => format!("{:.6}", error.as_f64().unwrap()),
        };
        let fields = ["pixels_that_differ", "by_more_than_one_level", "not_rounding", "largest_difference"];
        let numbers = fields.map(|field| text(&one[field])).join(",");
        let [name, picture, reason] =
            ["name", "picture", "reason"].map(|field| format!("{:?}", text(&one[field])));
        let [result, points, unit] = [&one["result"], &one["points"], &one["unit"]].map(text);
        assert_eq!(line, format!("{name},{picture},{result},{points},{numbers},{error},{unit},{reason}"));
    }
    let bela = &document["names"][1];
    assert_eq!((&bela["points"], &bela["graded"], &bela["percent"]), (&1.into(), &2.into(), &50.into()));
    let message = folder.run("-grade class -reference ref -json page.txt").message(2);
    assert!(message.contains("-json"), "{message}");
}

#[test]
fn one_student_is_graded_alone() {
    let folder = folder();
    hand_in(&folder, "bela", "o.tga", b"");
    folder.write("class/loose.tga", "");
    let run = folder.run("-grade class -reference ref -student bela").ok();
    assert!(!run.stdout.contains("anna") && !run.stdout.contains("loose"), "{}", run.stdout);
    assert!(run.stdout.contains("pictures that pass         0 of 2, 0 percent, 1 missing, 1 unusable\n"));
    let message = folder.run("-grade class -reference ref -student carl").message(1);
    assert!(only_line(&message).contains("`carl`"), "{message}");
    let message = folder.run("-input s.txt -student anna").message(2);
    assert!(message.contains("-grade <folder>"), "{message}");
}

#[test]
fn numbers_are_graded_as_numbers() {
    let folder = folder();
    folder.write("commands.txt", "rt -input s.txt -size 24 18 -depth 8 9 d.pfm\n");
    for (who, scene) in [("right", sphere()), ("moved", sphere().replace("center 0 0 9", "center 0 0 9.001"))]
    {
        assert!(who == "right" || scene != sphere(), "{scene}");
        make(&folder, &format!("class/{who}"));
        folder.write("t.txt", scene);
        folder.run(&format!("-input t.txt -size 24 18 -depth 8 9 class/{who}/d.pfm")).ok();
    }
    for (flags, moved) in
        [("", "failed,0"), ("-tolerance 0.01 0", "passed,1"), ("-tolerance 0.0001 0", "failed,0")]
    {
        folder.run(&format!("-grade class -commands commands.txt -report page.html {flags}"));
        assert!(result(&folder, "right", "d.pfm").starts_with("passed,1,0,,,0,0,numbers,"));
        let found = result(&folder, "moved", "d.pfm");
        assert!(
            found.starts_with(moved) && found.contains(",numbers,") && found.contains(",0.00"),
            "{found}"
        );
    }
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(page.contains(" Shown from 8.3") && page.contains(" in black to "), "the scale is named");
    // A picture of bytes is compared with the bytes of the reference.
    make(&folder, "class/bytes");
    folder.run("-convert class/right/d.pfm -output class/bytes/d.png").ok();
    folder.run("-grade class -commands commands.txt -report page.html").ok();
    let found = result(&folder, "bytes", "d.pfm");
    assert!(found.starts_with("passed,1,0,") && found.ends_with(",\"found as d.png\""), "{found}");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow: two pictures of 108 MB"]
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
    for (who, name, end) in [("over", "o.tga", "\"upside down\""), ("over", "d.tga", "\"upside down\"")] {
        assert!(result(&folder, who, name).ends_with(end), "{}", result(&folder, who, name));
    }
    let found = result(&folder, "light", "o.tga");
    assert!(found.contains("with directional lights from the other side"), "{found}");
    folder.run("-grade class -reference ref -report page.html").ok();
    assert!(result(&folder, "over", "o.tga").ends_with("\"upside down\""));
    assert!(result(&folder, "light", "o.tga").contains("unknown ("));
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
        ("two", "sub/o.tga", &black(&right)),
        ("two", "o.png", &png),
        // The name itself comes first, right or wrong.
        ("own", "o.tga", &black(&right)),
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
        assert_eq!(result(&folder, who, "o.tga"), format!("passed,1,0,0,,0,0,levels,\"found as {file}\""));
        let note = format!("note: {who}: graded {file} as o.tga\n");
        assert!(run.stderr.contains(&note), "{}", run.stderr);
    }
    assert!(result(&folder, "own", "o.tga").starts_with("failed,"));
    assert!(result(&folder, "other", "o.tga").starts_with("missing"));
    let page = String::from_utf8(folder.read("page.html")).unwrap();
    assert!(
        page.contains("<li>own/o.png: another file is graded as o.tga</li>") && !page.contains("<li>ending/")
    );
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
        ("anna", "passed,1,0,0,,0,0,levels,\"\""),
        ("nothing", "missing,0,,,,,,,\"\""),
        ("short", "unusable,0,,,,,,,\"it is too short for 24 x 18 pixels\""),
        ("header", "unusable,0,,,,,,,\"it ends within its header\""),
        ("empty", "unusable,0,,,,,,,\"it ends within its header\""),
        ("huge", "unusable,0,,,,,,,\"it is too short for 65535 x 65535 pixels\""),
        ("packed", "unusable,0,,,,,,,\"it is too short for 65535 x 65535 pixels\""),
        (
            "other",
            "unusable,0,,,,,,,\"its size is 18 x 24 pixels instead of 24 x 18: it is transposed: its width and height are swapped\"",
        ),
        ("text", "unusable,0,,,,,,,\"TGA of type 32 is not supported; save it as PNG, or as TGA of type 2\""),
        ("folder", "unusable,0,,,,,,,\"it is not a regular file\""),
        ("fifo", "unusable,0,,,,,,,\"it is not a regular file\""),
        ("link", "unusable,0,,,,,,,\"it is a link\""),
        ("dangling", "unusable,0,,,,,,,\"it is a link\""),
    ] {
        assert_eq!(result(&folder, who, "o.tga"), expected, "{who}");
    }
}

#[test]
fn names_are_text_and_nothing_else() {
    let folder = folder();
    let wrong = black(&picture(&folder, "o.tga"));
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
        "<li>notes.doc: not in the folder of a name</li>",
        "<li>anna/&lt;b&gt;.tga: no reference</li>",
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
    let wrong = black(&picture(&folder, "o.tga"));
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
    assert!(grade(&folder).stdout.contains("pictures that pass         1 of 1, 100 percent\n"));
}

#[test]
fn a_missing_reference_is_told() {
    let folder = folder();
    folder.write("commands.txt", format!("{COMMANDS}rt -input none.txt -output n.tga"));
    let run = folder.run("-grade class -commands commands.txt -report page.html").ok();
    let start = "warning: no reference for n.tga: none.txt: error: cannot read the scene: ";
    assert!(only_line(&run.stderr).starts_with(start), "{}", run.stderr);
    assert!(run.stdout.contains("\n  n.tga                      NULL\n"), "{}", run.stdout);
    assert_eq!(result(&folder, "anna", "n.tga"), "no reference,,,,,,,,\"\"");
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
    let with = |flags: &str| folder.run(flags).message(1);
    for (line, start) in [
        ("-grade hollow -reference ref", "error: `hollow` has no folder of pictures in it"),
        ("-grade class -reference hollow", "error: there is no picture to grade by"),
        ("-grade class -commands ref", "error: cannot read the commands `ref`: it is not a regular file"),
        ("-grade class -commands idle.txt", "error: there is no picture to grade by"),
    ] {
        let message = with(line);
        assert!(only_line(&message).starts_with(start), "{line}: {message}");
    }
    // The table cannot be written, so that the page is not either.
    make(&folder, "page.csv");
    with("-grade class -reference ref -report page.html");
    assert!(!folder.names().contains(&"page.html".into()));
}
