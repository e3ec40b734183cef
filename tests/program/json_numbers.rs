//! `-json`: the numbers of the document are those of the text.

use crate::causes;
use crate::json::{both, said};
use crate::pixel_scenes::{BOARD, GLASS, MARBLE, MESH, OBJ, numbers};
use crate::support::Folder;
use serde_json::{Value, json};

/// Demands lines with these labels and these words.
fn check_lines(text: &str, lines: &[(&str, String)]) {
    for (label, words) in lines {
        assert_eq!(said(text, label).next(), Some(words.as_str()), "{label} in {text}");
    }
}

fn list(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|n| n.as_f64().expect("a number")).collect()
}

/// The sum of the colours of a sample's rays, added in the tracer's order: of the rays that wait, the last is the next.
fn colors_added(rays: &Value) -> [f64; 3] {
    let (mut sum, mut waiting) = ([0.0; 3], vec![0]);
    while let Some(place) = waiting.pop() {
        let ray = &rays[place];
        let (filter, color) = (list(&ray["filter"]), list(&ray["color"]));
        (0..3).for_each(|channel| sum[channel] += filter[channel] * color[channel]);
        waiting.extend(list(&ray["children"]).into_iter().map(|child| child as usize));
    }
    sum
}

fn triple(value: &Value) -> String {
    let numbers: Vec<String> = list(value).iter().map(f64::to_string).collect();
    format!("({})", numbers.join(", "))
}

#[test]
fn the_statistics_are_those_of_the_text() {
    let folder = Folder::with_scene(GLASS);
    for (flags, cells) in [("", "NULL"), ("-grid 3 4 5", "60 (3x4x5)")] {
        let flags = format!("-input s.txt -size 24 18 -shadows -bounces 3 -stats -threads 2 {flags}");
        let (run, found) = both(&folder, &flags);
        let text = run.ok().stdout;
        let corner = |name: &str| {
            let corner = found["scene"]["bounds"][name].as_array().expect("a corner").iter();
            corner.map(|x| format!("{:.6}", x.as_f64().unwrap())).collect::<Vec<_>>().join(" ")
        };
        let time = |stage: &'static str| {
            let seconds = found["timings"][stage].as_f64().expect("a time");
            (stage, format!("{:.3} ms", seconds * 1e3))
        };
        let count = |name: &str| found["statistics"][name].to_string();
        check_lines(
            &text,
            &[
                ("scene bounds", format!("{}  -> {}", corner("min"), corner("max"))),
                ("num grid cells", cells.to_owned()),
                ("num non-shadow rays", count("non_shadow_rays")),
                ("num shadow rays", count("shadow_rays")),
                ("total intersections", count("intersections")),
                ("total cells traversed", count("cells_traversed")),
                ("threads", found["threads"].to_string()),
            ],
        );
        check_lines(&text, &["reading", "building", "rendering", "writing"].map(time));
        assert_eq!(found["grid"], if cells == "NULL" { Value::Null } else { json!({ "cells": [3, 4, 5] }) });
        assert_ne!(count("shadow_rays"), "0");
    }
}

#[test]
fn the_cost_map_is_that_of_the_text() {
    let folder = Folder::with_scene(GLASS);
    for kind in ["rays", "tests", "cells"] {
        let flags = format!("-input s.txt -size 24 18 -shadows -grid 3 4 5 -cost_map {kind} c.png");
        let (run, found) = both(&folder, &flags);
        let (map, text) = (&found["cost_map"], run.ok().stdout);
        let most = &map["most_expensive"];
        let [all, empty] = ["all", "empty"].map(|name| map["cells"][name].as_f64().expect("a count"));
        check_lines(
            &text,
            &[
                ("cost", kind.to_owned()),
                ("total", map["total"].to_string()),
                ("most expensive pixel", format!("{} at {}", most["count"], triple(&most["pixel"]))),
                ("empty cells", format!("{:.1}%", 100.0 * empty / all)),
            ],
        );
        assert_eq!((map["cost"].as_str(), all), (Some(kind), 60.0));
        let fullest = map["cells"]["fullest"].as_array().expect("cells");
        let shown =
            fullest.iter().map(|c| format!("{} primitives at {}", c["primitives"], triple(&c["cell"])));
        assert_eq!(said(&text, "full cell").collect::<Vec<_>>(), shown.collect::<Vec<_>>());
        assert_eq!(fullest.len(), 5);
    }
}

/// All numbers of the text are rounded, except those of the sum.
#[test]
fn the_sums_of_pixels_are_those_of_the_text_to_the_last_bit() {
    for (text, flags) in [
        (GLASS, "-transparent_shadows -bounces 5 -weight .2 -shade_back -grid 3 4 5"),
        (BOARD, "-shadows -jittered_samples 3 -gaussian_filter .6"),
        (MESH, "-shadows"),
        (MARBLE, "-uniform_samples 4"),
        (BOARD, "-shadows -adaptive_samples 20 3"),
    ] {
        let folder = Folder::with_scene(text);
        folder.write("m.obj", OBJ);
        for (x, y) in [(3, 4), (9, 8), (11, 9), (14, 12), (20, 15)] {
            let (run, found) = both(&folder, &format!("-input s.txt -size 24 18 {flags} -pixel {x} {y}"));
            let (pixel, text) = (&found["pixel"], run.ok().stdout);
            assert_eq!(list(&pixel["color"]), numbers(&text, "sum"), "{flags}");
            assert_eq!(list(&pixel["bytes"]), numbers(&text, "bytes"));
            assert_eq!(list(&pixel["pixel"]), [x, y].map(f64::from));
            let samples = pixel["samples"].as_array().expect("samples");
            let rays = || samples.iter().flat_map(|sample| sample["rays"].as_array().expect("rays"));
            assert_eq!(said(&text, "samples  ").next(), Some(samples.len().to_string().as_str()));
            let counted = said(&text, "counted  ").next().expect("counts");
            assert!(
                counted.starts_with(&format!("intersection tests {}", pixel["counts"]["intersections"])),
                "{counted}"
            );
            assert_eq!(text.matches(" ray, bounce ").count() + samples.len(), rays().count());
            for ray in rays() {
                let (object, t) = (&ray["surface"]["object"], &ray["surface"]["t"]);
                assert!(
                    object.is_null() || text.contains(&format!(" in line {} at t ", object["line"])),
                    "{t}"
                );
            }
            for sample in samples {
                assert_eq!(list(&sample["color"]), colors_added(&sample["rays"]));
            }
        }
    }
}

#[test]
fn the_comparison_is_that_of_the_text() {
    let folder = causes::folder();
    folder.run(&format!("-input s.txt {} -output a.png", causes::FLAGS)).ok();
    let flags = "-input s.txt -size 48 36 -bounces 2 -compare a.png -tolerance 60 40";
    let (run, found) = both(&folder, flags);
    assert_eq!(run.status, Some(3));
    let (text, compared) = (run.stdout, &found["comparison"]);
    let [all, differing, visibly, edges] =
        ["pixels", "pixels_that_differ", "by_more_than_one_level", "differing_beside_an_edge"]
            .map(|name| compared[name].as_f64().expect("a count"));
    let [error, psnr, flip] = ["root_mean_square_error", "psnr", "mean_flip"]
        .map(|name| compared[name].as_f64().expect("a number"));
    let largest = &compared["largest"];
    let [at, a, b] = ["at", "a", "b"].map(|name| triple(&largest[name]));
    check_lines(
        &text,
        &[
            ("size", "48x36".to_owned()),
            ("pixels that differ", format!("{differing} ({:.4}%)", 100.0 * differing / all)),
            ("by more than one level", format!("{visibly} ({:.4}%)", 100.0 * visibly / all)),
            ("largest difference", format!("{} at {at}: {a} against {b}", largest["levels"])),
            ("root mean square error", format!("{error:.6} levels")),
            ("PSNR", format!("{psnr:.2} dB")),
            ("mean FLIP", format!("{flip:.6}")),
            ("differing beside an edge", format!("{:.4}%", 100.0 * edges / differing)),
            ("cause", "equals this program's picture with -shadows (0 pixels differ)".to_owned()),
        ],
    );
    let cause = json!({
        "finding": "equal",
        "mistake": { "kind": "request", "name": "shadows" },
        "pixels": 0,
        "unexplained": 0,
        "first": null,
        "epsilon": null,
        "by_one_level": true,
        "text": "equals this program's picture with -shadows (0 pixels differ)",
    });
    assert_eq!((&compared["size"], &compared["cause"]), (&json!([48, 36]), &cause));
    let above = compared["tolerance"]["pixels_above"].as_u64().expect("a count");
    assert!(above > 40 && above < differing as u64, "{above}");
    let check = json!({ "levels": 60.0, "pixels": 40, "pixels_above": above, "passes": false });
    assert_eq!(compared["tolerance"], check);
    // The number above is the last that does not pass.
    let passes =
        |pixels| folder.run(&format!("{flags} -json -").replace(" 40 ", &format!(" {pixels} "))).status;
    assert_eq!([passes(above - 1), passes(above)], [Some(3), Some(0)]);
}
