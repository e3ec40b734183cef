//! `-error_report`: the numbers are those of the pictures, and the page shows them.

use crate::support::{Folder, only_line, scene, sphere};
use raytracer::base::shell::Shell;
use raytracer::render::Request;
use raytracer::render::renderer::Renderer;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use std::fs;
use std::sync::LazyLock;

/// A name that means something to HTML and to a shell. Windows allows no angle brackets in it.
const NAME: &str = if cfg!(windows) { "&b;.txt" } else { "<b>.txt" };

/// A report on a scene of this name with a mirror, noise and many edges.
static REPORT: LazyLock<(Folder, String)> = LazyLock::new(|| {
    let folder = Folder::new();
    folder.write(NAME, mirror());
    let run = folder.run(&format!("-input {NAME} -size 16 12 -bounces 2 -error_report r -target 12")).ok();
    assert_eq!(run.stderr, "", "progress is for terminals");
    (folder, run.stdout)
});

fn mirror() -> String {
    let objects = "Sphere { center -.5 0 0 radius .4 } MaterialIndex 1 Sphere { center .3 .2 0 radius .6 }
                   MaterialIndex 2 Sphere { center .4 -.6 .5 radius .3 }";
    scene(3, objects).replace(
        "numMaterials 1 Material { }",
        "numMaterials 3 Material { } Material { diffuseColor 1 0 0 reflectiveColor 1 1 1 }
         Noise { materialIndex 0 materialIndex 1 octaves 3 }",
    )
}

/// The lines of the table, each as its fields without quotes, the head first. No field of it has a comma in it.
fn table(folder: &Folder, name: &str) -> Vec<Vec<String>> {
    let text = String::from_utf8(folder.read(name)).unwrap();
    text.lines()
        .map(|line| line.split(',').map(|field| field.trim_matches('"').to_owned()).collect())
        .collect()
}

/// The field in this column of the line with this filter and setting.
fn field(filter: &str, setting: &str, column: &str) -> String {
    let table = table(&REPORT.0, "r/report.csv");
    let column = table[0].iter().position(|name| name == column).unwrap();
    let line = table.iter().find(|line| line[0] == filter && line[2] == setting && line[1] != "grid");
    line.unwrap_or_else(|| panic!("{filter} {setting}"))[column].clone()
}

fn number(filter: &str, setting: &str, column: &str) -> f64 {
    field(filter, setting, column).parse().unwrap()
}

#[test]
fn the_error_is_that_of_the_pictures() {
    let renderer = Renderer::open(&REPORT.0.path().join(NAME)).unwrap();
    let base = Request::new([16, 12]);
    let base = Request { effects: raytracer::trace::Effects { bounces: 2, ..base.effects }, ..base };
    let colors = |filter, pattern, count, rng| {
        let request = Request { sampler: Sampler::new(pattern, count, rng), filter, ..base.clone() };
        let prepared = renderer.prepare(&request).unwrap();
        let picture = prepared.render(&request).unwrap().remove(0);
        picture
            .colors
            .iter()
            .flat_map(|color| color.to_array())
            .map(|c| c.clamp(0.0, 1.0))
            .collect::<Vec<_>>()
    };
    for (filter, flag) in
        [(Filter::PIXEL, "box_filter 0.5"), (Filter::Mitchell { radius: 2.0 }, "mitchell_filter 2")]
    {
        let [a, b] = [1, 2].map(|seed| colors(filter, Pattern::Jittered, 1024, Drand48::seeded(seed)));
        for (pattern, count, setting) in [
            (Pattern::Random, 4, "random_samples 4"),
            (Pattern::Uniform, 1, "uniform_samples 1"),
            (Pattern::Jittered, 64, "jittered_samples 64"),
        ] {
            let picture = colors(filter, pattern, count, Drand48::UNSEEDED);
            let products = (0..picture.len()).map(|k| (picture[k] - a[k]) * (picture[k] - b[k]));
            let expected = 255.0 * (products.sum::<f64>() / picture.len() as f64).sqrt();
            let found = number(flag, setting, "RMSE in levels");
            assert!((found - expected).abs() < 1e-5, "{flag} {setting}: {found} {expected}");
            let psnr = number(flag, setting, "PSNR in dB");
            assert!((psnr - 20.0 * (255.0 / expected).log10()).abs() < 1e-3, "{flag} {setting}: {psnr}");
        }
    }
}

#[test]
fn errors_fall_as_theory_says() {
    let slope = |setting: &str| number("box_filter 0.5", setting, "slope of the sampling");
    // Independent samples: the root of their number. With strata only those count that an edge runs through.
    let (random, jittered) = (slope("random_samples 4"), slope("jittered_samples 4"));
    assert!((-0.6..-0.4).contains(&random), "{random}");
    assert!((-0.85..-0.55).contains(&jittered) && jittered < random, "{jittered} {random}");
}

#[test]
fn what_the_scene_shows_is_measured_and_no_grid_changes_it() {
    let table = table(&REPORT.0, "r/report.csv");
    let kinds = |kind: &str| table.iter().filter(|line| line[1] == kind).count();
    assert_eq!(["samples", "secondary rays", "octaves", "grid"].map(kinds), [100, 6, 2, 4]);
    let mut single_precision_agrees = false;
    for line in &table[1..] {
        let [.., changed_bytes, own, single] = &line[..] else { panic!("{line:?}") };
        assert!(own == "no" && (line[1] != "grid" || changed_bytes == "0"), "{line:?}");
        single_precision_agrees |= single == "no";
    }
    assert!(single_precision_agrees);
    assert!(REPORT.1.contains("0 hits and 0 bytes differ, by at most 0 levels, RMSE 0.0000"), "{}", REPORT.1);
}

/// The number behind a word in a line.
fn number_after(line: &str, word: &str) -> f64 {
    let rest = line.split_once(word).unwrap_or_else(|| panic!("{word} in {line}")).1;
    rest.trim_start().split([' ', ',', ':']).next().unwrap().parse().unwrap()
}

#[test]
fn the_target_is_answered_first_by_a_command_line_to_copy() {
    let (folder, said) = &*REPORT;
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[2].starts_with("  the fastest setting with an RMSE of at most 12 has "), "{}", lines[2]);
    let (seconds, error) = (number_after(lines[2], " in "), number_after(lines[2], " has "));
    let table = table(folder, "r/report.csv");
    let [flags, time, rmse] = ["flags", "CPU seconds least", "RMSE in levels"]
        .map(|name| table[0].iter().position(|other| other == name).unwrap());
    let start = format!("raytracer -input {} -size 16 12 ", Shell::OF_SYSTEM.word(NAME));
    let (mut least, mut chosen) = (f64::INFINITY, None);
    for line in table[1..].iter().filter(|line| !line[flags].is_empty() && line[1] != "grid") {
        let [time, rmse]: [f64; 2] = [time, rmse].map(|column| line[column].parse().unwrap());
        least = if rmse <= 12.0 { least.min(time) } else { least };
        // A quote keeps a spreadsheet from taking the flags for a formula.
        if lines[3] == format!("{start}{} -output picture.png", line[flags].trim_start_matches('\'')) {
            chosen = Some([time, rmse]);
        }
    }
    let [time, rmse] = chosen.expect("the command line is one of the table");
    // The table has fewer digits than were compared.
    assert!(rmse <= 12.0 && time - least < 1e-5, "{time} {least}");
    assert!((seconds - time).abs() < 1e-4 && (error - rmse).abs() < 1e-3, "{}", lines[2]);
    folder.run(&lines[3].replace(['\'', '"'], "").replace("raytracer ", "")).ok();
    assert!(folder.names().contains(&"picture.png".to_owned()));
}

#[test]
fn a_target_that_nothing_reaches_is_answered_with_the_nearest_and_status_3() {
    let folder = Folder::with_scene(&sphere());
    let run = folder.run("-edition aalto -input s.txt -size 4 3 -error_report r -target 0");
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let line = run.stdout.lines().nth(2).unwrap();
    let table = table(&folder, "r/report.csv");
    let [flags, rmse] =
        ["flags", "RMSE in levels"].map(|name| table[0].iter().position(|other| other == name).unwrap());
    let errors = table[1..].iter().filter(|line| line[1] == "samples");
    let least = errors.map(|line| line[rmse].parse::<f64>().unwrap()).fold(f64::MAX, f64::min);
    assert!((number_after(line, "nearest is") - least).abs() < 1e-3, "{line} {least}");
    assert!(table.iter().any(|line| line[flags].starts_with("'-regular_samples")), "flags of the edition");
    let page = String::from_utf8(folder.read("r/report.html")).unwrap();
    assert!(page.contains("<em>not reached by anything measured; the nearest</em>"));
}

#[test]
fn the_page_is_one_file() {
    let page = String::from_utf8(REPORT.0.read("r/report.html")).unwrap();
    for outside in ["http:", "https:", "<link", "src=\"h", "@import", "url(", "<b>"] {
        assert!(!page.contains(outside), "{outside}");
    }
    // Windows counts processor time in steps that are longer than such pictures take, and a time of 0 is not compared.
    if !cfg!(windows) {
        assert_eq!(page.matches("role=\"img\"").count(), 8, "two plots of each filter");
        let pictures = page.matches("data:image/png;base64,").count();
        assert!(pictures >= 5, "the reference and at least two pairs");
    }
    for text in [
        "content=\"default-src 'none'; img-src data:; ",
        if cfg!(windows) { "-input &quot;&amp;b;.txt&quot;" } else { "-input &#39;&lt;b&gt;.txt&#39;" },
        "All 112 settings were measured.",
    ] {
        assert!(page.contains(text), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_done() {
    use crate::support::send;
    use std::process::Stdio;
    use std::thread::sleep;
    use std::time::Duration;
    let folder = Folder::with_scene(&mirror());
    let line = "-input s.txt -size 4000 4000 -error_report r";
    let child = folder.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // From here on the program knows what to do.
    while !folder.path().join("r").exists() {
        sleep(Duration::from_millis(5));
    }
    send(nix::sys::signal::Signal::SIGINT, &child);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(said, "note: stopped: the report has the measurements made so far\n");
    let page = String::from_utf8(folder.read("r/report.html")).unwrap();
    assert!(page.contains("<strong>The run was stopped: 0 of 106 settings were measured.</strong>"));
    assert_eq!(table(&folder, "r/report.csv").len(), 1);
}

#[test]
fn a_folder_that_cannot_be_written_ends_the_run_before_it_starts() {
    let folder = Folder::with_scene(&mirror());
    fs::create_dir_all(folder.path().join("r/report.csv")).unwrap();
    for (name, start) in
        [("s.txt", "error: cannot make the folder `s.txt`: "), ("r", "error: cannot write `r/report.csv`: ")]
    {
        let message = folder.run(&format!("-input s.txt -size 4000 4000 -error_report {name}")).message(1);
        assert!(only_line(&message).starts_with(start), "{message}");
    }
    assert!(!folder.path().join("r/report.html").exists());
    assert!(folder.run("-input none.txt -error_report q").message(1).contains("none.txt"));
}
