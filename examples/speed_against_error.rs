//! Measures what settings cost and buy for ten scenes, and writes the results into `docs/speed-against-error.md`.
//!
//! `cargo run --release --example speed_against_error`

use rayon::ThreadPoolBuilder;
use raytracer::cli::{Command, Options, parse};
use raytracer::render::renderer::{Meshes, Renderer};
use raytracer::scene::edition::Edition;
use raytracer::scene::load::load;
use raytracer::tools::error_report::{
    self, Axis, Bench, Deviation, ErrorReport, MeasuredFilter, Numerical, SamplingKind, Setting,
};
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::ops::ControlFlow;
use std::path::Path;

/// What is in the picture, the scene, and the flags with it.
const SCENES: [[&str; 3]; 6] = [
    ["Checkerboard", "scene6_13_checkerboard.txt", "-shadows"],
    ["Glass", "scene6_14_glass_sphere.txt", "-shadows -shade_back -bounces 5 -weight 0.01"],
    ["Rabbit", "scene6_07_bunny_mesh_40k.txt", "-shadows"],
    ["Mirrors", "scene6_11_mirrored_floor.txt", "-shadows -bounces 4 -weight 0.01"],
    ["Marble", "scene6_15_marble_cubes.txt", ""],
    ["Nested boxes", "scene6_10_nested_transformations.txt", "-shadows"],
];

/// The same of scenes that were not looked at while the advice was written.
const HELD_OUT: [[&str; 3]; 4] = [
    ["Wood", "scene6_16_wood_cubes.txt", "-shadows"],
    ["Still life with glass", "show_glass.txt", "-shadows -shade_back -bounces 6 -weight 0.01"],
    ["Letters", "scene7_04_6.837_logo.txt", "-shadows"],
    ["Point lights", "scene4_12_point_light_circle_d_attenuation.txt", "-shadows"],
];

/// The kinds of samples with a fixed number in each pixel.
const FIXED: [SamplingKind; 4] =
    [SamplingKind::Random, SamplingKind::Uniform, SamplingKind::Jittered, SamplingKind::Sobol];

const SIZE: &str = "-size 60 60";

/// The lines before and behind the results.
const MARKS: [&str; 2] = ["<!-- measured -->\n", "<!-- end of measured -->\n"];

fn main() -> Result<(), Box<dyn Error>> {
    let mut text = String::new();
    for [name, scene, flags] in SCENES {
        eprintln!("{scene}");
        let line = format!("-input {scene} {SIZE} {flags}");
        let _ = writeln!(text, "### {name}\n\n`{}`\n", line.trim_end());
        add_report(&mut text, &measure(scene, flags)?);
    }
    let _ = writeln!(text, "{HELD_OUT_HEAD}");
    for [name, scene, flags] in HELD_OUT {
        eprintln!("{scene}");
        for group in &measure(scene, flags)?.groups {
            add_held_out(&mut text, &format!("{name}, `{}`", format!("{scene} {flags}").trim_end()), group);
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/speed-against-error.md");
    let page = fs::read_to_string(&path)?;
    let (before, rest) = page.split_once(MARKS[0]).ok_or("no mark before the results")?;
    let (_, after) = rest.split_once(MARKS[1]).ok_or("no mark behind the results")?;
    fs::write(path, [before, MARKS[0], "\n", &text, "\n", MARKS[1], after].concat())?;
    Ok(())
}

/// Adds a row with the numbers that the advice is about.
fn add_held_out(text: &mut String, name: &str, group: &MeasuredFilter) {
    let errors: Vec<String> =
        group.curve(SamplingKind::Adaptive).map(|one| format!("{:.2}", one.error)).collect();
    let slopes = FIXED.map(|kind| group.slope(kind).map_or("-".into(), |slope| format!("{slope:.2}")));
    let ratio = time_over_jittered(group).map_or("-".into(), |ratio| format!("{ratio:.2}"));
    let center = group.curve(SamplingKind::Uniform).next().map_or(0.0, |one| one.error);
    let changed: u64 = group.measurements.iter().filter_map(|one| one.changed).sum();
    let _ = writeln!(
        text,
        "| {name} | {center:.1} | {} | {ratio} | {} | {changed} |",
        errors.join(", "),
        slopes.join(", ")
    );
}

/// The time of adaptive samples over that of jittered ones with the same error, interpolated: the geometric mean of those
/// whose error jittered samples reach.
fn time_over_jittered(group: &MeasuredFilter) -> Option<f64> {
    let jittered: Vec<[f64; 2]> =
        group.curve(SamplingKind::Jittered).map(|one| [one.error.ln(), one.least().ln()]).collect();
    let ratios: Vec<f64> = group
        .curve(SamplingKind::Adaptive)
        .filter_map(|one| {
            let error = one.error.ln();
            let pair = jittered.windows(2).find(|pair| (pair[1][0]..=pair[0][0]).contains(&error))?;
            let [a, b] = [pair[0], pair[1]];
            Some(one.least().ln() - (a[1] + (error - a[0]) / (b[0] - a[0]) * (b[1] - a[1])))
        })
        .collect();
    (!ratios.is_empty()).then(|| (ratios.iter().sum::<f64>() / ratios.len() as f64).exp())
}

fn measure(scene: &str, flags: &str) -> Result<ErrorReport, Box<dyn Error>> {
    let words = format!("raytracer -input {scene} {SIZE} {flags}");
    let Command::Render(options) = parse(words.split_whitespace().map(Into::into))? else {
        return Err("no rendering".into());
    };
    let options: Options = *options;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let renderer = Renderer::new(load(&path)?, Meshes::Kept)?;
    let (many, one) = (ThreadPoolBuilder::new().build()?, ThreadPoolBuilder::new().num_threads(1).build()?);
    let bench = Bench { many: &many, one: &one, watch: &|_, _| ControlFlow::Continue(()) };
    let own = Setting::new(options.request(), Edition::default());
    // The own filter alone.
    let plan = &error_report::plan(&renderer.scene, renderer.world(), &own)[..1];
    Ok(error_report::measure(&renderer, &own, plan, bench, String::new())?)
}

fn add_report(text: &mut String, report: &ErrorReport) {
    for group in &report.groups {
        add_curves(text, group);
        add_front(text, group);
        add_others(text, group);
    }
    if let Some(numerical) = &report.numerical {
        add_numerical(text, numerical);
    }
}

const HELD_OUT_HEAD: &str = "\
### Held out

Four scenes that were not used for the advice, at the same size. *centre* is the error of one sample at the centre;
*adaptive* are the errors of `-adaptive_samples 256` for 8, 4, 2, 1 and 0.5; *time* is the time of adaptive samples
divided by that of jittered ones with the same error (geometric mean).

Bounces are not measured here.

| scene | centre | adaptive | time | slopes: random, uniform, jittered, sobol | pixels changed by grids |
|---|---:|---|---:|---|---:|";

/// The error and the time of each number of samples.
fn add_curves(text: &mut String, group: &MeasuredFilter) {
    let _ = writeln!(
        text,
        "| samples | 1 | 4 | 16 | 64 | 256 | slope | s to 1 level |\n|---|{}",
        "---:|".repeat(7)
    );
    let cells = |kind| -> String {
        group.curve(kind).map(|one| format!(" {:.2} in {:.4} s |", one.error, one.least())).collect()
    };
    let optional =
        |number: Option<f64>, digits| number.map_or("".into(), |number| format!("{number:.digits$}"));
    for kind in FIXED {
        let (slope, seconds) = (optional(group.slope(kind), 2), optional(group.seconds_to_a_level(kind), 4));
        let _ = writeln!(text, "| {} |{} {slope} | {seconds} |", kind.name(), cells(kind));
    }
    let _ = writeln!(
        text,
        "\n| adaptive, up to 256, error | 8 | 4 | 2 | 1 | 0.5 | s to 1 level |\n|---|{}",
        "---:|".repeat(6)
    );
    let seconds = optional(group.seconds_to_a_level(SamplingKind::Adaptive), 4);
    let _ = writeln!(text, "| |{} {seconds} |\n", cells(SamplingKind::Adaptive));
    if let Some(ratio) = time_over_jittered(group) {
        let _ = writeln!(
            text,
            "Adaptive samples take {ratio:.2} times as long as jittered ones with the same error.\n"
        );
    }
}

/// What nothing else beats, from the cheapest.
fn add_front(text: &mut String, group: &MeasuredFilter) {
    let names: Vec<String> = group.front().iter().map(|one| format!("`{}`", one.setting.label())).collect();
    let _ = writeln!(text, "Front: {}.\n", names.join(", "));
}

/// Fewer bounces, larger weights, fewer octaves and other grids, if there are any.
fn add_others(text: &mut String, group: &MeasuredFilter) {
    let _ = writeln!(text, "| setting | CPU s | RMSE | pixels changed by the grid |\n|---|---:|---:|---:|");
    for one in group.measurements.iter().filter(|one| one.setting.axis != Axis::Samples) {
        let changed = one.changed.map_or("".into(), |pixels| pixels.to_string());
        let _ = writeln!(
            text,
            "| `{}` | {:.4} | {:.3} | {changed} |",
            one.setting.label(),
            one.least(),
            one.error
        );
    }
    text.push('\n');
}

fn add_numerical(text: &mut String, numerical: &Numerical) {
    let Numerical { size: [width, height], samples, program, single } = numerical;
    let said = |Deviation { bytes, largest, error, hits }: &Deviation| {
        format!("{hits} camera rays and {bytes} bytes, by at most {largest} levels, RMSE {error:.4}")
    };
    let _ = writeln!(
        text,
        "Numerical error of {samples} samples in {width} x {height} pixels, against brute force in double precision: \
         {}; in single precision, {}.\n",
        said(program),
        said(single)
    );
}
