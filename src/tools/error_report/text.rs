//! The measurements as a block like that of the statistics.

use super::{Departure, ErrorReport, MeasuredFilter, Measurement, Numerical, SamplingKind, filter_flag};
use crate::stats::RULE;
use std::fmt::Write;

/// The table of each filter. A star marks the front: nothing else with this filter is as fast and better, or as good
/// and faster. A row ends with `numerical` if the program's roundings are more than a tenth of its error, and with
/// `f32` if those of single precision would be.
pub fn text(report: &ErrorReport) -> String {
    let [width, height] = report.size;
    let mut text = format!("{RULE}\nSPEED AGAINST ERROR\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  size                       {width}x{height}");
    let _ = writeln!(text, "  settings measured          {} of {}", report.measured(), report.planned);
    for (stage, time) in &report.stages {
        let _ = writeln!(text, "  {stage:<26} {:.3} s", time.as_secs_f64());
    }
    if let Some(numerical) = &report.numerical {
        add_numerical(&mut text, numerical);
    }
    report.groups.iter().for_each(|group| add_group(&mut text, report, group));
    text + RULE + "\n"
}

/// What roundings do.
fn add_numerical(text: &mut String, numerical: &Numerical) {
    let Numerical { size: [width, height], samples, program, single } = numerical;
    let _ =
        writeln!(text, "against brute force in double precision, {samples} samples, {width}x{height} pixels");
    for (name, found) in [("this program", program), ("single precision", single)] {
        let Departure { bytes, largest, error, hits } = found;
        let _ = writeln!(
            text,
            "  {name:<26} {hits} hits and {bytes} bytes differ, by at most {largest} levels, RMSE {error:.6}"
        );
    }
}

fn add_group(text: &mut String, report: &ErrorReport, group: &MeasuredFilter) {
    let _ = writeln!(text, "{}, noise of the reference {:.3} levels", filter_flag(group.filter), group.noise);
    let head = ["CPU s", "median", "Mrays/s", "RMSE", "PSNR", "FLIP", "> 1 level", "slope", "s to 1"];
    let head: String = head.map(|word| format!(" {word:>9}")).concat();
    let _ = writeln!(text, "    {:<45}{head}", "setting");
    for (measurement, is_on_front) in group.measurements.iter().zip(group.front()) {
        let star = if is_on_front { '*' } else { ' ' };
        let numerical = match report.is_numerical(measurement) {
            [true, _] => " numerical",
            [false, true] => " f32",
            [false, false] => "",
        };
        let (label, numbers) = (measurement.setting.label(), numbers(group, measurement));
        let _ = writeln!(text, "  {star} {label:<45}{numbers}{numerical}");
    }
}

/// The measures of a setting, and behind the last setting of a kind those of the whole curve.
fn numbers(group: &MeasuredFilter, one: &Measurement) -> String {
    let kind = one.setting.kind();
    let is_last = group.curve(kind).last().is_some_and(|last| std::ptr::eq(last, one));
    let curve = if is_last { curve(group, kind) } else { Default::default() };
    let changed = one.changed.map_or(String::new(), |pixels| format!(" {pixels} pixels changed"));
    let numbers = [
        format!("{:.5}", one.least()),
        format!("{:.5}", one.median()),
        format!("{:.2}", one.megarays()),
        format!("{:.3}", one.error),
        format!("{:.2}", one.psnr()),
        format!("{:.4}", one.flip),
        format!("{:.2}%", 100.0 * one.off),
    ];
    let numbers: String = numbers.into_iter().chain(curve).map(|number| format!(" {number:>9}")).collect();
    format!("{numbers}{changed}").trim_end().to_owned()
}

/// The slope and the time to an error of one level.
fn curve(group: &MeasuredFilter, kind: SamplingKind) -> [String; 2] {
    let optional = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.3}"));
    [optional(group.slope(kind)), optional(group.seconds_to_a_level(kind))]
}
