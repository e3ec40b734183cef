//! The page of a report: a single self-contained file. Its text is in `templates/error_report.html`.

use super::plot::{against_samples, against_time, marker};
use super::{Answer, ErrorReport, Line, SamplingKind};
use crate::picture::Picture;
use crate::tools::compare::{colors, largest_channel_difference};
use crate::tools::embedded::file;
use crate::tools::explain::cubehelix;
use crate::tools::table::{Column, optional};
use askama::Template;

/// The difference, in levels, shown as white in the maps.
const BRIGHTEST: u8 = 64;

/// Returns the page. `command` is the measured command line.
pub fn page(report: &ErrorReport, command: &str, answers: &[Answer<'_>]) -> String {
    Page { report, command, answers }.to_string()
}

#[derive(Template)]
#[template(path = "error_report.html")]
struct Page<'p> {
    report: &'p ErrorReport,
    command: &'p str,
    answers: &'p [Answer<'p>],
}

/// The columns of a filter's table after the setting.
fn columns<'r>() -> [Column<Line<'r>>; 10] {
    [
        ("CPU s", |line| format!("{:.5}", line.one.least())),
        ("median", |line| format!("{:.5}", line.one.median())),
        ("repeats", |line| line.one.times.len().to_string()),
        ("Mrays/s", |line| optional(line.one.megarays(), 2)),
        ("RMSE", |line| format!("{:.3}", line.one.error)),
        ("PSNR", |line| format!("{:.2}", line.one.psnr())),
        ("FLIP", |line| format!("{:.4}", line.one.flip)),
        ("off by more than 1", |line| format!("{:.2}%", 100.0 * line.one.off)),
        ("changed by the grid", |line| {
            line.one.changed.map_or(String::new(), |pixels| format!("{pixels} pixels"))
        }),
        ("roundings", |line| match (line.is_numerical, line.is_numerical_in_single) {
            (true, _) => "numerical".into(),
            (false, true) => "f32".into(),
            (false, false) => String::new(),
        }),
    ]
}

fn cells(line: &Line) -> Vec<String> {
    columns().iter().map(|(_, cell)| cell(line)).collect()
}

fn data(picture: &Picture) -> String {
    format!("data:image/png;base64,{}", file(picture))
}

/// Returns a map of the differences of two pictures of the same size.
fn error_data(picture: &Picture, reference: &Picture) -> String {
    let differences =
        colors(picture).iter().zip(colors(reference)).map(|(a, b)| largest_channel_difference(*a, *b));
    let shown = differences.flat_map(|levels| cubehelix(f64::from(levels) / f64::from(BRIGHTEST)));
    data(&Picture::from_rgb(picture.width(), picture.height(), shown.collect()))
}
