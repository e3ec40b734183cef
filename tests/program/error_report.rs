//! `-error_report`: the numbers are those of the pictures, and the page shows them.

use crate::support::{Folder, only_line, scene};
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
fn only_what_costs_more_may_be_better_on_the_front() {
    let table = table(&REPORT.0, "r/report.csv");
    let of =
        |line: &[String], name: &str| line[table[0].iter().position(|other| other == name).unwrap()].clone();
    let mut stars = 0;
    for filter in ["box_filter 0.5", "tent_filter 1", "gaussian_filter 0.5", "mitchell_filter 2"] {
        let lines: Vec<_> = table
            .iter()
            .filter(|line| line[0] == filter && line[1] != "grid" && !line[3].is_empty())
            .collect();
        let numbers = |line: &[String]| {
            ["CPU seconds least", "RMSE in levels"].map(|name| of(line, name).parse::<f64>().unwrap())
        };
        let best = lines.iter().map(|line| numbers(line)[1]).fold(f64::MAX, f64::min);
        for line in &lines {
            let [time, error] = numbers(line);
            let is_beaten = lines.iter().any(|other| numbers(other)[0] < time && numbers(other)[1] < error);
            let is_on_front = of(line, "on the front") == "yes";
            assert!(!(is_beaten && is_on_front), "{line:?}");
            stars += usize::from(is_on_front && error == best);
        }
    }
    assert!(stars >= 4, "the best of each filter is on its front");
}

#[test]
fn what_the_scene_shows_is_measured_and_no_grid_changes_it() {
    let table = table(&REPORT.0, "r/report.csv");
    let kinds = |kind: &str| table.iter().filter(|line| line[1] == kind).count();
    assert_eq!(["samples", "secondary rays", "octaves", "grid"].map(kinds), [100, 6, 2, 4]);
    let changed: Vec<&str> =
        table.iter().filter(|line| line[1] == "grid").map(|line| line[line.len() - 3].as_str()).collect();
    assert_eq!(changed, ["0"; 4]);
    let [own, single] =
        [2, 1].map(|back| table[1..].iter().map(|line| line[line.len() - back].as_str()).collect::<Vec<_>>());
    assert!(own.iter().all(|flagged| *flagged == "no") && single.contains(&"no"));
    assert!(REPORT.1.contains(
        "  this program               0 hits and 0 bytes differ, by at most 0 levels, RMSE 0.0000"
    ));
    assert!(number("box_filter 0.5", "jittered_samples 64", "RMSE in levels") > 0.0);
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
    assert_eq!(lines[1], "SPEED AGAINST ERROR");
    assert!(lines[2].starts_with("  the fastest setting with an RMSE of at most 12 has "), "{}", lines[2]);
    let (seconds, error) = (number_after(lines[2], " in "), number_after(lines[2], " has "));
    let command = lines[3];
    let table = table(folder, "r/report.csv");
    let column = |name: &str| table[0].iter().position(|other| other == name).unwrap();
    let [flags, time, rmse] = ["flags", "CPU seconds least", "RMSE in levels"].map(column);
    let candidates: Vec<(f64, f64, String)> = table[1..]
        .iter()
        .filter(|line| !line[flags].is_empty() && line[1] != "grid")
        .map(|line| {
            // A quote keeps a spreadsheet from taking the flags for a formula.
            let flags = line[flags].trim_start_matches('\'').to_owned();
            (line[time].parse().unwrap(), line[rmse].parse().unwrap(), flags)
        })
        .collect();
    let good = || candidates.iter().filter(|(_, error, _)| *error <= 12.0);
    let least = good().map(|(time, ..)| *time).fold(f64::INFINITY, f64::min);
    let start = format!("raytracer -input {} -size 16 12 ", Shell::OF_SYSTEM.word(NAME));
    // Several may be as fast as the digits of the table tell.
    let chosen = good().find(|(.., flags)| command == format!("{start}{flags} -output picture.png")).unwrap();
    assert!(chosen.0 - least < 1e-5, "{chosen:?} {least}");
    assert!((seconds - chosen.0).abs() < 1e-4 && (error - chosen.1).abs() < 1e-3, "{}", lines[2]);
    folder.run(&command.replace(['\'', '"'], "").replace("raytracer ", "")).ok();
    assert!(folder.names().contains(&"picture.png".to_owned()));
}

#[test]
fn a_target_that_nothing_reaches_is_answered_with_the_nearest_and_status_3() {
    let folder = Folder::with_scene(&mirror());
    let run = folder.run("-input s.txt -size 6 5 -error_report r -target 0");
    assert_eq!(run.status, Some(3), "{}", run.stderr);
    let line = run.stdout.lines().nth(2).unwrap();
    assert!(line.starts_with("  nothing measured reaches an RMSE of 0; the nearest is "), "{line}");
    let table = table(&folder, "r/report.csv");
    let rmse = table[0].iter().position(|name| name == "RMSE in levels").unwrap();
    let least =
        table[1..].iter().filter(|line| line[1] == "samples").map(|line| line[rmse].parse::<f64>().unwrap());
    let least = least.fold(f64::MAX, f64::min);
    assert!((number_after(line, "nearest is") - least).abs() < 1e-3, "{line} {least}");
    let page = String::from_utf8(folder.read("r/report.html")).unwrap();
    assert!(page.contains("<em>not reached by anything measured; the nearest</em>"));
}

#[test]
fn the_page_is_one_file() {
    let page = String::from_utf8(REPORT.0.read("r/report.html")).unwrap();
    assert!(page.contains(
        "content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'\""
    ));
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
        if cfg!(windows) { "-input &quot;&amp;b;.txt&quot;" } else { "-input &#39;&lt;b&gt;.txt&#39;" },
        "All 112 settings were measured.",
        "slope -0.",
        "this program</td><td>0</td><td>0</td><td>0</td>",
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
    for (name, start) in [
        ("s.txt", "error: cannot make the folder `s.txt`: "),
        ("s.txt/r", "error: cannot make the folder `s.txt/r`: "),
    ] {
        let message = folder.run(&format!("-input s.txt -size 4000 4000 -error_report {name}")).message(1);
        assert!(only_line(&message).starts_with(start), "{message}");
    }
    fs::create_dir_all(folder.path().join("r/report.csv")).unwrap();
    folder.run("-input s.txt -size 4000 4000 -error_report r").message(1);
    assert!(!folder.path().join("r/report.html").exists());
    let message = folder.run("-input none.txt -error_report q").message(1);
    assert!(message.contains("none.txt"), "{message}");
}
