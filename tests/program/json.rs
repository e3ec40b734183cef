//! `-json`: the document takes the text's place or stands beside it, is complete or absent, and has the checked options.

use crate::pixel_scenes::GLASS;
use crate::support::{Folder, Run, only_line, sphere};
use serde_json::{Value, json};

/// The document that a run writes beside its text.
fn both(folder: &Folder, flags: &str) -> (Run, Value) {
    let run = folder.run(&format!("{flags} -json o.json"));
    (run, serde_json::from_slice(&folder.read("o.json")).expect("a document"))
}

#[test]
fn nothing_is_counted_unless_it_is_asked_for() {
    let folder = Folder::with_scene(GLASS);
    let (run, found) = both(&folder, "-input s.txt -size 24 18 -shadows -output o.png");
    assert_eq!((run.ok().stdout.as_str(), &found["statistics"]), ("", &Value::Null));
    for member in ["cost_map", "pixel", "comparison"] {
        assert_eq!(found[member], Value::Null, "{member}");
    }
    let (_, mapped) = both(&folder, "-input s.txt -size 24 18 -shadows -cost_map rays c.png");
    let (_, counted) = both(&folder, "-input s.txt -size 24 18 -shadows -stats");
    assert!(mapped["statistics"].is_object());
    assert_eq!(mapped["statistics"], counted["statistics"]);
}

#[test]
fn what_json_has_no_number_for_is_null() {
    let folder = Folder::with_scene(&sphere());
    folder.run("-input s.txt -output a.png").ok();
    let (_, found) = both(&folder, "-input s.txt -compare a.png");
    assert_eq!((&found["comparison"]["psnr"], &found["comparison"]["largest"]), (&Value::Null, &Value::Null));
    // The camera is orthographic, and the light directional.
    let (_, found) = both(&folder, "-input s.txt -pixel 50 50 -shadows");
    let ray = &found["pixel"]["samples"][0]["rays"][0];
    assert_eq!((&ray["ray"]["t_min"], &ray["ray"]["t_max"]), (&Value::Null, &Value::Null));
    assert_eq!(ray["surface"]["lights"][0]["incident"]["distance"], Value::Null);
    assert!(ray["surface"]["t"].is_number());
}

#[test]
fn a_dash_puts_it_in_place_of_the_text() {
    let folder = Folder::with_scene(&sphere());
    // How many threads help depends on the time unless it is said.
    let flags = "-input s.txt -stats -pixel 50 50 -cost_map rays c.png -gui -threads 2";
    let alone = folder.run(&format!("{flags} -json -")).ok();
    let printed: Value = serde_json::from_str(only_line(&alone.stdout)).expect("a document and nothing else");
    let (run, written) = both(&folder, flags);
    assert!(run.stdout.starts_with("****") && folder.names().contains(&"o.json".into()));
    assert_eq!(alone.stderr, run.stderr);
    let timeless = |mut document: Value| {
        document["timings"].take();
        document["options"]["json"].take();
        document
    };
    assert_eq!(printed["options"]["json"], "-");
    assert_eq!(written["options"]["json"], json!({ "file": "o.json" }));
    assert_eq!(timeless(printed), timeless(written));
}

#[test]
fn it_repeats_the_lines_on_standard_error() {
    let folder = Folder::with_scene(&sphere().replace("Lights", "#"));
    let (run, found) = both(&folder, "-input s.txt -gui");
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert_eq!((&found["warnings"], lines.len()), (&json!(lines), 2));
}

#[test]
fn a_run_that_fails_writes_none() {
    let folder = Folder::with_scene(&sphere());
    folder.write("o.json", "what was there");
    for flags in ["-input none.txt", "-input s.txt -compare no.png", "-input s.txt -output no/o.png"] {
        folder.run(&format!("{flags} -json o.json")).message(1);
        folder.run(&format!("{flags} -json -")).message(1);
    }
    assert_eq!(folder.read("o.json"), b"what was there");
    assert_eq!(folder.names(), ["o.json", "s.txt"]);
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf_8_are_shown_as_well_as_json_can() {
    use crate::support::{finish, program};
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let folder = Folder::with_scene(&sphere());
    let name = OsString::from_vec(b"a\xff\n.png".to_vec());
    let words = ["-input", "s.txt", "-json", "-", "-output"].map(OsString::from);
    let run = finish(&mut program(folder.path(), words.into_iter().chain([name]))).ok();
    let found: Value = serde_json::from_str(&run.stdout).expect("a document");
    assert_eq!(found["written"], json!(["a\u{fffd}\n.png"]));
}
