//! Writes a report for a terminal of 100 columns: the answer first, then the Pareto front.

use super::{Answer, Departure, ErrorReport, Measurement, Numerical};
use crate::stats::RULE;
use std::fmt::Write;

/// The largest number of rows of the front.
const MOST_ROWS: usize = 12;

/// The largest number of columns in a line.
const COLUMNS: usize = 100;

/// Returns the answers and the front of all filters. One answer is written as a command to paste, several as rows. The
/// page and the table have everything else.
pub fn text(report: &ErrorReport, answers: &[Answer<'_>]) -> String {
    let mut lines = vec![RULE.to_owned(), "SPEED AGAINST ERROR".to_owned()];
    match answers {
        [] => lines.push("  nothing was measured".into()),
        [answer] => add_answer(&mut lines, answer),
        several => add_answers(&mut lines, several),
    }
    add_front(&mut lines, report);
    lines.extend(report.numerical.iter().flat_map(numerical));
    add_notes(&mut lines, report);
    lines.push(RULE.to_owned());
    lines.into_iter().map(|line| line + "\n").collect()
}

fn add_answer(lines: &mut Vec<String>, answer: &Answer<'_>) {
    let Answer { target, chosen, command } = answer;
    let (seconds, error) = (chosen.least(), chosen.error);
    lines.push(match answer.is_reached() {
        true => format!("  an RMSE of {target} is reached in {seconds:.4} s, with {error:.3}:"),
        false => {
            format!(
                "  nothing measured reaches an RMSE of {target}; the nearest is {error:.3} in {seconds:.4} s:"
            )
        }
    });
    // Shells have no common syntax for a command that goes on in the next line.
    lines.push(command.clone());
}

fn add_answers(lines: &mut Vec<String>, answers: &[Answer<'_>]) {
    lines.push("  for an RMSE of     CPU s     RMSE  choose".into());
    for answer in answers {
        let reached = if answer.is_reached() { " " } else { "*" };
        add_row(lines, &format!("  {:>13}{reached}", answer.target), answer.chosen);
    }
    if answers.iter().any(|answer| !answer.is_reached()) {
        lines.push("  * nothing measured reaches it; this comes nearest".into());
    }
}

/// Adds the front, thinned evenly if it has too many rows.
fn add_front(lines: &mut Vec<String>, report: &ErrorReport) {
    let front = report.front();
    if front.is_empty() {
        return;
    }
    lines.push("  the front          CPU s     RMSE  setting".into());
    let shown = front.len().min(MOST_ROWS);
    let last = (shown - 1).max(1);
    for row in 0..shown {
        add_row(lines, &" ".repeat(16), front[row * (front.len() - 1) / last]);
    }
}

fn add_row(lines: &mut Vec<String>, start: &str, one: &Measurement) {
    let start = format!("{start} {:>9.5} {:>8.3}  ", one.least(), one.error);
    let mut flags = one.setting.label_parts();
    flags.insert(1, one.setting.request.filter.flag());
    lines.extend(wrapped(&flags, start));
}

/// Describes the effect of rounding.
fn numerical(numerical: &Numerical) -> [String; 3] {
    let Numerical { size: [width, height], samples, program, single } = numerical;
    let line = |name: &str, found: &Departure| {
        let Departure { bytes, largest, error, hits } = found;
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

fn add_notes(lines: &mut Vec<String>, report: &ErrorReport) {
    let (measured, planned, filters) = (report.measured(), report.planned, report.groups.len());
    let seconds: f64 = report.stages.iter().map(|(_, time)| time.as_secs_f64()).sum();
    let [width, height] = report.size;
    let all = if measured == planned { "all".into() } else { format!("{measured} of") };
    let mut note = format!(
        "{all} {planned} settings of {filters} filters, adaptive samples among them, at {width}x{height}: {seconds:.0} s"
    );
    let changed = report.pixels_changed();
    if changed > 0 {
        // Writing to a string cannot fail.
        let _ = write!(note, "; OTHER GRIDS CHANGE {changed} PIXELS");
    }
    lines.push(note);
    lines.push(
        "each against its own filter's converged picture; report.html and report.csv have everything".into(),
    );
}

/// Wraps words into lines. The first begins with `start`, the others with spaces of this width.
fn wrapped(words: &[String], start: String) -> Vec<String> {
    let indent = start.len();
    let mut lines = vec![];
    let mut line = start;
    for word in words {
        if line.len() > indent && line.len() + 1 + word.len() > COLUMNS {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
        } else if line.len() > indent {
            line.push(' ');
        }
        line += word;
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_before_the_last_column() {
        let words: Vec<String> = (0..30).map(|n| format!("-flag{n} {n}")).collect();
        let lines = wrapped(&words, "  ".into());
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= COLUMNS && line.starts_with("  -")));
        assert_eq!(lines.join(" ").split_whitespace().collect::<Vec<_>>().join(" "), words.join(" "));
    }
}
