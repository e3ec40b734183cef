//! Measures the time and the error of settings, and writes a page and a table.

use super::log::Log;
use super::outputs::prepare_report;
use super::progress::ProgressLine;
use super::signals::Signals;
use super::{End, Outcome, refused, threads};
use crate::base::escape::quoted;
use crate::base::shell::Shell;
use crate::base::stdio::STDIO;
use crate::cli::{ErrorReporting, Options};
use crate::diagnostic::Diagnostic;
use crate::image_io::{check_distinct, put_in_place};
use crate::render::renderer::{Meshes, Renderer};
use crate::scene::edition::Edition;
use crate::tools::error_report::{Answer, Bench, Setting, USUAL_TARGETS, csv, measure, page, plan, text};
use crate::tools::warnings::no_lights;
use std::fs;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// Measures and writes.
pub fn run(reporting: &ErrorReporting, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    let ErrorReporting { options, folder, target } = reporting;
    let many = threads::pool(options.threads, options.size[1])?;
    let one = threads::pool(Some(1), 1)?;

    // Load the scene and settle the options.
    let loaded = many.install(|| options.load_scene())?;
    let files = ["report.html", "report.csv"].map(|name| folder.join(name));
    let written = files.clone().into_iter().chain([STDIO.into()]);
    check_distinct(written, options.files().chain(loaded.files())).map_err(refused)?;
    let remarks = [no_lights(&loaded.scene), loaded.choice.remark()];
    remarks.into_iter().flatten().for_each(|found| log.log(found));
    let options = &options.in_edition(loaded.choice.edition);

    // Prepare. Other octaves are other scenes with the same meshes.
    let renderer = many.install(|| Renderer::new(loaded, Meshes::Kept))?;
    // A file that cannot be written is no reason to wait for the measurements.
    let unwritable = |error| Diagnostic::error(format!("cannot make the folder {}: {error}", quoted(folder)));
    fs::create_dir_all(folder).map_err(unwritable)?;
    let [page_file, csv_file] = prepare_report(&files)?;

    // Measure.
    signals.note_first();
    let line = ProgressLine::new(options.progress);
    let watch = |share: f64, doing: &str| {
        line.show(|passed| told(share, doing, passed));
        signals.goes_on()
    };
    let bench = Bench { many: &many, one: &one, watch: &watch };
    let own = Setting::new(options.request(), options.edition.unwrap_or_default());
    let plan = plan(&renderer.scene, renderer.world(), &own);
    let report = measure(&renderer, &own, &plan, bench, origin())?;
    drop(line);

    // Report.
    let targets = target.as_ref().map_or(&USUAL_TARGETS[..], std::slice::from_ref);
    let writing = |setting: &Setting| command(options, setting) + " -output picture.png";
    let answers: Vec<Answer> =
        targets.iter().filter_map(|&target| Answer::new(&report, target, writing)).collect();
    let page = page_file.text(&page(&report, &command(options, &own), &answers))?;
    let complete = vec![page, csv_file.text(&csv(&report))?];
    // The signal that has ended the measurements does not end this, but another one does.
    let _ = signals.end_at_once();
    put_in_place(complete)?;
    if report.measured() < report.planned {
        log.log(Diagnostic::note("stopped: the report has the measurements made so far"));
    }
    let passes = target.is_none() || answers.iter().all(Answer::is_reached) && !answers.is_empty();
    let text = text(&report, &answers);
    Ok(Outcome { passes, ..Outcome::new(text, files, options.progress) })
}

/// Formats the progress of a sweep after this time, and how long the rest takes at this speed.
fn told(share: f64, doing: &str, elapsed: Duration) -> String {
    let left = elapsed.as_secs_f64() * (1.0 - share) / share;
    let left = if share > 0.0 { format!(", {left:.0} s left") } else { String::new() };
    format!("{:.0}%{left}: {doing}", (100.0 * share).floor())
}

/// Returns the command line of a setting.
fn command(options: &Options, setting: &Setting) -> String {
    let input = options.input.as_deref().unwrap_or(Path::new(""));
    let [width, height] = options.size;
    let mut words = vec![
        "raytracer".into(),
        format!("-input {}", Shell::OF_SYSTEM.word(input)),
        format!("-size {width} {height}"),
    ];
    if setting.edition != Edition::default() {
        words.push(format!("-edition {}", setting.edition));
    }
    words.extend(setting.flags());
    words.extend(options.sampler.rng().seed().map(|seed| format!("-seed {seed}")));
    words.join(" ")
}

/// Returns the program, the day, the processor and the system.
fn origin() -> String {
    let seconds = SystemTime::UNIX_EPOCH.elapsed().map_or(0, |time| time.as_secs());
    let program = format!("raytracer {}, {}", env!("CARGO_PKG_VERSION"), date(seconds / 86_400));
    let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
    let words: Vec<String> = [Some(program), processor(), Some(system)].into_iter().flatten().collect();
    words.join(", ")
}

/// Returns the processor's name, where the system tells it in a file or, on Windows, in a variable.
fn processor() -> Option<String> {
    let lines = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let named = lines.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    named.map(|(_, name)| name.to_owned()).or_else(|| std::env::var("PROCESSOR_IDENTIFIER").ok())
}

/// Returns the date of a day, counted from the first of 1970. Source: H. Hinnant, "chrono-Compatible Low-Level Date
/// Algorithms", `civil_from_days`.
fn date(day: u64) -> String {
    // Years start in March, so that the day of a leap year comes last.
    let day = day + 719_468;
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = (400 * era + year + month / 10, (month + 2) % 12 + 1);
    format!("{year}-{month:02}-{day:02}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        let days = [0, 58, 59, 11_016, 11_017, 20_785, 47_540, 47_541].map(date);
        let dates = ["1970-01-01", "1970-02-28", "1970-03-01", "2000-02-29", "2000-03-01", "2026-11-28"];
        assert_eq!(days[..6], dates);
        assert_eq!(days[6..], ["2100-02-28", "2100-03-01"]);
    }

    #[test]
    fn the_time_left_is_that_of_the_rest() {
        let after = |share, seconds| told(share, "x", Duration::from_secs(seconds));
        assert_eq!([after(0.25, 10), after(0.999, 10)], ["25%, 30 s left: x", "99%, 0 s left: x"]);
        assert_eq!(after(0.0, 10), "0%: x");
    }
}
