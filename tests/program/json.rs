//! `-json`: the document takes the text's place or stands beside it, is complete or absent, and has the checked options.

use crate::pixel_scenes::GLASS;
use crate::support::{Folder, Run, only_line, scene, sphere};
use serde_json::{Value, json};

/// The document that a run writes beside its text.
pub fn both(folder: &Folder, flags: &str) -> (Run, Value) {
    let run = folder.run(&format!("{flags} -json o.json"));
    (run, serde_json::from_slice(&folder.read("o.json")).expect("a document"))
}

/// What stands after a label, in the lines that have it.
pub fn said<'t>(text: &'t str, label: &'t str) -> impl Iterator<Item = &'t str> {
    text.lines().filter_map(move |line| line.trim_start().strip_prefix(label)).map(str::trim)
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
    let (run, found) = both(&folder, "-input s.txt -compare a.png");
    assert_eq!(said(&run.ok().stdout, "PSNR").next(), Some("inf dB"));
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
    let folder = Folder::with_scene(&scene(1, "Sphere { center 0 0 0 radius .7 }").replace("Lights", "#"));
    for (flags, count) in [("", 1), ("-gui", 2)] {
        let (run, found) = both(&folder, &format!("-input s.txt {flags}"));
        let lines: Vec<&str> = run.stderr.lines().collect();
        assert_eq!((&found["warnings"], lines.len()), (&json!(lines), count));
    }
    let (_, found) = both(&Folder::with_scene(&sphere()), "-input s.txt");
    assert_eq!(found["warnings"], json!([]));
}

#[test]
fn a_run_that_fails_writes_none() {
    let folder = Folder::with_scene(&sphere());
    folder.write("broken.txt", "Group { numObjects 1 }");
    folder.write("o.json", "what was there");
    for flags in ["-input broken.txt", "-input s.txt -compare no.png", "-input s.txt -output no/o.png"] {
        folder.run(&format!("{flags} -json o.json")).message(1);
        folder.run(&format!("{flags} -json -")).message(1);
    }
    folder.run("-input s.txt -size 0 0 -json o.json").message(2);
    assert_eq!(folder.read("o.json"), b"what was there");
    assert_eq!(folder.names(), ["broken.txt", "o.json", "s.txt"]);
}

#[test]
fn a_document_that_cannot_be_written_ends_the_run_before_it_renders() {
    let folder = Folder::with_scene(&sphere());
    std::fs::create_dir(folder.path().join("d.json")).expect("a folder");
    for (file, message) in [
        ("no/o.json", "error: cannot write `no/o.json`: "),
        ("d.json", "error: cannot write `d.json`: it is a folder"),
    ] {
        let stderr = folder.run(&format!("-input s.txt -output o.png -json {file}")).message(1);
        assert!(only_line(&stderr).starts_with(message), "{stderr}");
    }
    assert_eq!(folder.names(), ["d.json", "s.txt"]);
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
    assert_eq!(
        found["options"]["outputs"],
        json!([{ "kind": "color", "file": "a\u{fffd}\n.png", "format": "png" }])
    );
}

#[test]
fn the_options_are_the_checked_values() {
    let folder = Folder::with_scene(&sphere());
    let options = |flags: &str| {
        let run = folder.run(&format!("-input s.txt {flags} -json -")).ok();
        serde_json::from_str::<Value>(&run.stdout).expect("a document")["options"].take()
    };
    let plain = json!({
        "input": "s.txt",
        "outputs": [],
        "size": [100, 100],
        "region": null,
        "edition": "2004",
        "uv": false,
        "jitter": false,
        "reduced": false,
        "progress": "on_terminal",
        "effects": { "shadows": "none", "shade_back": false, "bounces": 0, "min_weight": 0.0 },
        "sampler": { "pattern": "uniform", "count": 1, "seed": null },
        "adaptive": null,
        "filter": { "kind": "box", "radius": 0.5 },
        "structure": "any",
        "visualize_grid": false,
        "comparison": null,
        "stats": false,
        "repeat": null,
        "strict": false,
        "json": "-",
        "pixel": null,
        "preview": false,
        "page": null,
        "threads": null,
    });
    assert_eq!(options(""), plain);
    let adaptive = options("-adaptive_samples 64 1.5");
    assert_eq!(adaptive["adaptive"], json!({ "most": 64, "error": 1.5 }));
    assert_eq!(adaptive["sampler"], json!({ "pattern": "sobol", "count": 2, "seed": null }));
    for (flags, member, value) in [
        ("-size 7 5", "size", json!([7, 5])),
        ("-progress", "progress", json!("always")),
        ("-quiet", "progress", json!("never")),
        ("-region 1 2 3 4", "region", json!({"x": 1, "y": 2, "width": 3, "height": 4})),
        ("-grid auto", "structure", json!({ "grid": "auto" })),
        ("-grid none", "structure", json!("list")),
        ("-grid 1 2 3", "structure", json!({ "grid": { "cells": [1, 2, 3] } })),
        ("-gaussian_filter .25", "filter", json!({ "kind": "gaussian", "sigma": 0.25 })),
        (
            "-random_samples 3 -seed 4294967295",
            "sampler",
            json!({ "pattern": "random", "count": 3, "seed": 4294967295_u32 }),
        ),
        ("-jittered_samples 3", "sampler", json!({ "pattern": "jittered", "count": 3, "seed": null })),
        (
            "-depth 1 2.5 d.png",
            "outputs",
            json!([{ "kind": "depth", "near": 1.0, "far": 2.5, "file": "d.png", "format": "png" }]),
        ),
        (
            "-depth 1 2.5 d.exr -normals n.pfm",
            "outputs",
            json!([
                { "kind": "distance", "file": "d.exr", "format": "exr" },
                { "kind": "signed_normals", "file": "n.pfm", "format": "pfm" },
            ]),
        ),
        (
            "-cost_map tests c.png",
            "outputs",
            json!([{ "kind": "cost", "cost": "tests", "file": "c.png", "format": "png" }]),
        ),
        (
            "-transparent_shadows -shade_back -bounces 2 -weight .125",
            "effects",
            json!({ "shadows": "transparent", "shade_back": true, "bounces": 2, "min_weight": 0.125 }),
        ),
        ("-threads 3", "threads", json!(3)),
    ] {
        let mut expected = plain.clone();
        expected[member] = value;
        assert_eq!(options(flags), expected, "{flags}");
    }
}
