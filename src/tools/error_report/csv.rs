//! Writes the measurements as comma-separated values, one line each.

use super::{ErrorReport, Line};
use crate::base::escape::csv_field;
use crate::tools::table::{self, Column, count, optional};

/// Returns the table's lines, filter by filter.
pub fn csv(report: &ErrorReport) -> String {
    table::csv(&columns(), report.groups.iter().flat_map(|group| report.lines(group)))
}

fn columns<'r>() -> [Column<Line<'r>>; 19] {
    [
        ("filter", |line| word(&line.group.filter.flag())),
        ("shows", |line| word(line.one.setting.axis.name())),
        ("setting", |line| word(&line.one.setting.label())),
        ("flags", |line| csv_field(&line.one.setting.flags().join(" "))),
        ("CPU seconds least", |line| format!("{:.6}", line.one.least())),
        ("CPU seconds median", |line| format!("{:.6}", line.one.median())),
        ("repeats", |line| line.one.times.len().to_string()),
        ("rays", |line| line.one.rays.to_string()),
        ("Mrays/s", |line| optional(line.one.megarays(), 3)),
        ("RMSE in levels", |line| format!("{:.6}", line.one.error)),
        ("PSNR in dB", |line| format!("{:.3}", line.one.psnr())),
        ("mean FLIP", |line| format!("{:.6}", line.one.flip)),
        ("share of pixels off by more than a level", |line| format!("{:.6}", line.one.off)),
        ("on the front", |line| yes(line.is_on_front)),
        ("slope of the sampling", |line| optional(line.group.slope(line.one.setting.kind()), 3)),
        ("CPU seconds of the sampling to one level", |line| {
            optional(line.group.seconds_to_a_level(line.one.setting.kind()), 6)
        }),
        ("pixels changed by the grid", |line| count(line.one.changed)),
        ("numerical error above a tenth", |line| yes(line.is_numerical)),
        ("above a tenth in single precision", |line| yes(line.is_numerical_in_single)),
    ]
}

fn word(text: &str) -> String {
    csv_field(text.trim_start_matches('-'))
}

fn yes(is: bool) -> String {
    if is { "yes".into() } else { "no".into() }
}
