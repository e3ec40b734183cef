//! Writes the measurements as comma-separated values (RFC 4180), one line each.

use super::{ErrorReport, MeasuredFilter, Measurement};
use crate::base::escape::csv_field;

const HEAD: &str = "filter,shows,setting,flags,CPU seconds least,CPU seconds median,repeats,rays,Mrays/s,\
                    RMSE in levels,PSNR in dB,mean FLIP,share of pixels off by more than a level,on the front,\
                    slope of the sampling,CPU seconds of the sampling to one level,pixels changed by the grid,\
                    numerical error above a tenth,above a tenth in single precision\r\n";

/// Returns the table's lines, filter by filter. Missing numbers are left empty.
pub fn csv(report: &ErrorReport) -> String {
    let lines = report.groups.iter().flat_map(|group| {
        let front = group.front();
        group.measurements.iter().map(move |one| line(report, group, one, one.is_among(&front)))
    });
    std::iter::once(HEAD.to_owned()).chain(lines).collect()
}

fn line(report: &ErrorReport, group: &MeasuredFilter, one: &Measurement, is_on_front: bool) -> String {
    let setting = &one.setting;
    let words = [group.filter.flag(), setting.axis.name().into(), setting.label()];
    let flags = csv_field(&setting.flags().join(" "));
    let words = words.map(|word| csv_field(word.trim_start_matches('-'))).join(",");
    let numbers = [
        format!("{:.6}", one.least()),
        format!("{:.6}", one.median()),
        one.times.len().to_string(),
        one.rays.to_string(),
        format!("{:.3}", one.megarays()),
        format!("{:.6}", one.error),
        format!("{:.3}", one.psnr()),
        format!("{:.6}", one.flip),
        format!("{:.6}", one.off),
        yes(is_on_front).into(),
        optional(group.slope(setting.kind()), 3),
        optional(group.seconds_to_a_level(setting.kind()), 6),
        one.changed.map_or(String::new(), |pixels| pixels.to_string()),
    ];
    let numerical = report.is_numerical(one).map(yes).join(",");
    format!("{words},{flags},{},{numerical}\r\n", numbers.join(","))
}

fn yes(is: bool) -> &'static str {
    if is { "yes" } else { "no" }
}

fn optional(number: Option<f64>, digits: usize) -> String {
    number.map_or(String::new(), |number| format!("{number:.digits$}"))
}
