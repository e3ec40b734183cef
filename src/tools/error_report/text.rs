//! Writes a report for a terminal of 100 columns: the answer first, then the Pareto front.

use super::{Answer, Departure, ErrorReport, Measurement, Numerical};
use crate::base::shell::Shell;
use crate::stats::RULE;
use std::fmt::Write;

/// The largest number of rows of the front.
const MOST_ROWS: usize = 12;

/// The largest number of columns in a line.
const COLUMNS: usize = 100;

/// Returns the answers and the front of all filters. One answer is written as a command for `shell`, several as rows.
/// The page and the table have everything else.
pub fn text(report: &ErrorReport, answers: &[Answer<'_>], shell: Shell) -> String {
    let mut lines = vec![RULE.to_owned(), "SPEED AGAINST ERROR".to_owned()];
    match answers {
        [] => lines.push("  nothing was measured".into()),
        [answer] => add_answer(&mut lines, answer, shell),
        several => add_answers(&mut lines, several),
    }
    add_front(&mut lines, report);
    lines.extend(report.numerical.iter().flat_map(numerical));
    add_notes(&mut lines, report);
    lines.push(RULE.to_owned());
    lines.into_iter().map(|line| line + "\n").collect()
}

fn add_answer(lines: &mut Vec<String>, answer: &Answer<'_>, shell: Shell) {
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
    lines.extend(to_paste(command, shell));
}

/// Returns the lines of a command in the syntax of `shell`.
fn to_paste(command: &[String], shell: Shell) -> Vec<String> {
    match shell {
        Shell::Posix => wrapped(command, "    ", "      ", " \\"),
        // cmd.exe and PowerShell have no common syntax for continued lines.
        Shell::Windows => vec![command.join(" ")],
    }
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
    lines.extend(wrapped(&flags, &start, &" ".repeat(start.len()), ""));
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

/// Wraps words into lines. `first` and `next` are the indentation of the first and the other lines. `end` is appended
/// to each continued line.
fn wrapped(words: &[String], first: &str, next: &str, end: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = first.to_owned();
    for (index, word) in words.iter().enumerate() {
        let is_last = index + 1 == words.len();
        let room = COLUMNS - if is_last { 0 } else { end.len() };
        let is_full = line.chars().count() + 1 + word.chars().count() > room;
        if index > 0 && is_full {
            lines.push(std::mem::replace(&mut line, next.to_owned()) + end);
        } else if index > 0 {
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
    fn a_command_goes_on_in_the_next_line_where_the_shells_have_a_sign_for_it() {
        let command: Vec<String> = (0..30).map(|n| format!("-flag{n} {n}")).collect();
        assert_eq!(to_paste(&command, Shell::Windows), [command.join(" ")]);
        let lines = to_paste(&command, Shell::Posix);
        let (last, others) = lines.split_last().unwrap();
        assert!(others.len() > 1 && others.iter().all(|line| line.ends_with(" \\")) && !last.ends_with('\\'));
    }

    #[test]
    fn lines_end_before_the_last_column() {
        let words: Vec<String> = (0..30).map(|n| format!("-flag{n} {n}")).collect();
        let lines = wrapped(&words, "  ", "    ", " \\");
        assert!(lines.len() > 2 && lines.iter().all(|line| line.len() <= COLUMNS));
        let (last, others) = lines.split_last().unwrap();
        assert!(others.iter().all(|line| line.ends_with(" \\")) && !last.ends_with('\\'));
        let joined: String = lines.join(" ").replace(" \\", "");
        assert_eq!(joined.split_whitespace().collect::<Vec<_>>().join(" "), words.join(" "));
    }
}
