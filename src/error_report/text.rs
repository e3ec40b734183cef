//! The measurements as a block like that of the statistics.

use super::{ErrorReport, Group, Kind, Measurement, filter_flag};
use crate::stats::RULE;
use std::fmt::Write;

/// The table of each filter. A star marks the front: nothing else with this filter is as fast and better, or as good and
/// faster.
pub fn text(report: &ErrorReport) -> String {
    let [width, height] = report.size;
    let mut text = format!("{RULE}\nSPEED AGAINST ERROR\n");
    // Writing to a string cannot fail.
    let _ = writeln!(text, "  size                       {width}x{height}");
    let _ = writeln!(text, "  settings measured          {} of {}", report.measured(), report.planned);
    for (stage, time) in &report.stages {
        let _ = writeln!(text, "  {stage:<26} {:.3} s", time.as_secs_f64());
    }
    report.groups.iter().for_each(|group| add_group(&mut text, group));
    text + RULE + "\n"
}

fn add_group(text: &mut String, group: &Group) {
    let _ = writeln!(text, "{}, noise of the reference {:.3} levels", filter_flag(group.filter), group.noise);
    let head = ["CPU s", "median", "Mrays/s", "RMSE", "PSNR", "FLIP", "> 1 level", "slope", "s to 1"];
    let head: String = head.map(|word| format!(" {word:>9}")).concat();
    let _ = writeln!(text, "    {:<45}{head}", "setting");
    for (measurement, is_on_front) in group.measurements.iter().zip(group.front()) {
        let star = if is_on_front { '*' } else { ' ' };
        let _ = writeln!(text, "  {star} {:<45}{}", measurement.setting.label(), numbers(group, measurement));
    }
}

/// The measures of a setting, and behind the last setting of a kind those of the whole curve.
fn numbers(group: &Group, one: &Measurement) -> String {
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
fn curve(group: &Group, kind: Kind) -> [String; 2] {
    let optional = |number: Option<f64>| number.map_or("-".into(), |number| format!("{number:.3}"));
    [optional(group.slope(kind)), optional(group.seconds_to_a_level(kind))]
}
