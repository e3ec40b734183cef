//! Writes a report for a terminal: the answer first, then the Pareto front.

use super::{Answer, Deviation, ErrorReport, Measurement, Numerical};
use crate::stats::RULE;

/// The largest number of rows of the front, beside its last one and those of the answers.
const MOST_ROWS: usize = 9;

/// Returns the answers and the front of all filters. One answer is written as a command to paste, several as rows. The
/// page and the table have everything else.
pub fn text(report: &ErrorReport, answers: &[Answer<'_>]) -> String {
    let mut lines = vec![RULE.to_owned(), "SPEED AGAINST ERROR".to_owned()];
    match answers {
        [] => lines.push("  nothing was measured".into()),
        // Shells have no common syntax for a command that goes on in the next line.
        [answer] => lines.extend([in_words(answer), answer.command.clone()]),
        several => {
            lines.push("  for an RMSE of     CPU s     RMSE  choose".into());
            for answer in several {
                let reached = if answer.is_reached() { " " } else { "*" };
                lines.push(row(&format!("  {:>13}{reached}", answer.target), answer.chosen));
            }
            if !several.iter().all(Answer::is_reached) {
                lines.push("  * nothing measured reaches it; this comes nearest".into());
            }
        }
    }
    // The front, thinned evenly if it has too many rows. The answers are on it and stay.
    let front = report.front();
    let step = front.len().div_ceil(MOST_ROWS).max(1);
    let chosen: Vec<&Measurement> = answers.iter().map(|answer| answer.chosen).collect();
    let is_shown = |k: usize| k.is_multiple_of(step) || k + 1 == front.len() || front[k].is_among(&chosen);
    let rows = (0..front.len()).filter(|&k| is_shown(k));
    let rows: Vec<String> = rows.map(|k| row(&" ".repeat(16), front[k])).collect();
    let title = match front.len() {
        all if all > rows.len() => format!("front, {} of {all}", rows.len()),
        _ => "the front".into(),
    };
    if !rows.is_empty() {
        lines.push(format!("  {title:<16}   CPU s     RMSE  setting"));
    }
    lines.extend(rows);
    lines.extend(report.numerical.iter().flat_map(numerical));
    lines.push(note(report));
    lines.push(report.origin.clone());
    lines.push(
        "each against its own filter's converged picture; report.html and report.csv have everything".into(),
    );
    lines.push(RULE.to_owned());
    lines.into_iter().map(|line| line + "\n").collect()
}

fn in_words(answer: &Answer<'_>) -> String {
    let Answer { target, chosen, .. } = answer;
    let (seconds, error) = (chosen.least(), chosen.error);
    if answer.is_reached() {
        return format!(
            "  the fastest setting with an RMSE of at most {target} has {error:.3} in {seconds:.4} s:"
        );
    }
    format!("  nothing measured reaches an RMSE of {target}; the nearest is {error:.3} in {seconds:.4} s:")
}

fn row(start: &str, one: &Measurement) -> String {
    let (setting, filter) = (one.setting.label(), one.setting.request.filter.flag());
    format!("{start} {:>9.5} {:>8.3}  {setting} {filter}", one.least(), one.error)
}

/// Describes the effect of rounding.
fn numerical(numerical: &Numerical) -> [String; 3] {
    let Numerical { size: [width, height], samples, program, single } = numerical;
    let line = |name: &str, found: &Deviation| {
        let Deviation { bytes, largest, error, hits } = found;
        format!(
            "  {name:<26} {hits} hits and {bytes} bytes differ, by at most {largest} levels, RMSE {error:.4}"
        )
    };
    [
        format!("against brute force in double precision, {samples} samples, {width}x{height} pixels"),
        line("this program", program),
        line("single precision", single),
    ]
}

/// Describes how much was measured.
fn note(report: &ErrorReport) -> String {
    let ErrorReport { size: [width, height], planned, time, .. } = report;
    let (measured, filters) = (report.measured(), report.groups.len());
    let all = if measured == *planned { "all".into() } else { format!("{measured} of") };
    let changed = match report.pixels_changed() {
        0 => String::new(),
        changed => format!("; OTHER GRIDS CHANGE {changed} PIXELS"),
    };
    format!(
        "{all} {planned} settings of {filters} filters, adaptive samples among them, at {width}x{height}: \
         {:.0} s{changed}",
        time.as_secs_f64()
    )
}
