//! The page of a report: one file, without anything from elsewhere. Its one script copies commands.

use super::plot::{against_samples, against_time, marker};
use super::{
    Answer, Departure, ErrorReport, MeasuredFilter, Measurement, Numerical, SamplingKind, filter_flag,
};
use crate::escape::html;
use crate::image_io::embedded::file;
use crate::picture::Picture;
use crate::tools::compare::{colors, largest_channel_difference};
use crate::tools::explain::color_scale::cubehelix;

const STYLE: &str = include_str!("page.css");

const SCRIPT: &str = include_str!("page.js");

/// Only what stands in the page itself is shown and run.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'";

/// A difference of so many levels is white in the maps.
const BRIGHTEST: u8 = 64;

/// The page. `command` is the command line that was measured.
pub fn page(report: &ErrorReport, command: &str, answers: &[Answer<'_>]) -> String {
    let head = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>Speed against error</title>\n\
         <style>\n{STYLE}</style>\n</head>\n"
    );
    let groups: String = report.groups.iter().map(|one| group(report, one)).collect();
    let numerical = report.numerical.as_ref().map(numerical).unwrap_or_default();
    let pictures = report.groups.first().map(pictures).unwrap_or_default();
    let (summary, answers, stages) = (summary(report, command), recommendations(answers), stages(report));
    format!(
        "{head}<body>\n{summary}{answers}{groups}{pictures}{numerical}{stages}<script>\n{SCRIPT}</script>\n</body>\n</html>\n"
    )
}

fn summary(report: &ErrorReport, command: &str) -> String {
    let [width, height] = report.size;
    let (measured, planned) = (report.measured(), report.planned);
    let came = match measured == planned {
        true => format!("All {planned} settings were measured."),
        false => {
            format!("<strong>The run was ended: {measured} of {planned} settings were measured.</strong>")
        }
    };
    format!(
        "<h1>Speed against error</h1>\n<p><code>{}</code></p>\n<p>{came} Pictures of {width} x {height} pixels. \
         What the command line asks for with endlessly many samples is right. The reference has 2 x 1024 jittered samples \
         in each pixel, and its own noise cancels: MSE = mean((I - R1)(I - R2)) over the clamped colours. Errors are in \
         levels, the steps from one byte to the next. The time is the processor's time for rendering alone, on one \
         thread, without reading the scene and building a grid; the shortest and the median of the repeats.</p>\n",
        html(command)
    )
}

/// Each answer as a command to copy.
fn recommendations(answers: &[Answer<'_>]) -> String {
    let rows: String = answers.iter().map(recommendation).collect();
    format!(
        "<h2>What to choose</h2>\n<p>The cheapest of everything that was measured, adaptive samples and all filters \
         included. Another filter makes another picture, and is measured against its own.</p>\n\
         <div class=\"answers\">\n{rows}</div>\n"
    )
}

fn recommendation(answer: &Answer<'_>) -> String {
    let Answer { target, chosen, command } = answer;
    let found = format!("{:.4} s, RMSE {:.3}", chosen.least(), chosen.error);
    let said = match answer.is_reached() {
        true => format!("RMSE of at most {target}: {found}"),
        false => format!(
            "RMSE of at most {target}: <em>not reached by anything measured; the nearest</em> {found}"
        ),
    };
    format!(
        "<p>{said}</p>\n<div><code>{}</code><button type=\"button\">Copy</button></div>\n",
        html(&command.join(" "))
    )
}

/// What roundings do, apart from sampling.
fn numerical(numerical: &Numerical) -> String {
    let Numerical { size: [width, height], samples, program, single } = numerical;
    let row = |name: &str, found: &Departure| {
        let Departure { bytes, largest, error, hits } = found;
        format!(
            "<tr><td class=\"name\">{name}</td><td>{hits}</td><td>{bytes}</td><td>{largest}</td><td>{error:.6}</td></tr>\n"
        )
    };
    let rows = row("this program", program) + &row("a textbook's tracer in single precision", single);
    format!(
        "<h2>Numerical error, apart from that of sampling</h2>\n<p>The same {samples} jittered samples in each of {width} x \
         {height} pixels, traced by brute force in double precision with exact decisions. Rows above are marked \
         \u{201c}numerical\u{201d} where this program's roundings are more than a tenth of their error, and \
         \u{201c}f32\u{201d} where those of single precision would be.</p>\n<table><thead><tr><th class=\"name\">Against \
         brute force</th><th>camera rays with another hit</th><th>bytes that differ</th><th>by at most, levels</th>\
         <th>RMSE, levels</th></tr></thead><tbody>\n{rows}</tbody></table>\n"
    )
}

fn group(report: &ErrorReport, group: &MeasuredFilter) -> String {
    let key: String = SamplingKind::ALL.into_iter().map(|kind| key(group, kind)).collect();
    let rows: String = group
        .measurements
        .iter()
        .zip(group.front())
        .map(|(one, is_on_front)| row(report, one, is_on_front))
        .collect();
    let head = [
        "",
        "Setting",
        "CPU s",
        "median",
        "repeats",
        "Mrays/s",
        "RMSE",
        "PSNR",
        "FLIP",
        "off by more than 1",
        "changed by the grid",
        "roundings",
    ]
    .map(|name| format!("<th{}>{name}</th>", if name == "Setting" { " class=\"name\"" } else { "" }))
    .concat();
    format!(
        "<h2>{}</h2>\n<p>Noise of each half of the reference: {:.3} levels. A star, and a ring in the plot, marks the \
         front: nothing else is as fast and better, or as good and faster.</p>\n<div class=\"key\">{key}</div>\n\
         <div class=\"plots\"><figure>{}</figure><figure>{}</figure></div>\n\
         <div class=\"scroll\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        html(&filter_flag(group.filter)),
        group.noise,
        against_time(group),
        against_samples(group),
    )
}

/// The mark of a kind of sampling, the slope of its curve, and its time to one level.
fn key(group: &MeasuredFilter, kind: SamplingKind) -> String {
    let name = kind.name();
    let slope = group.slope(kind).map_or(String::new(), |slope| format!(", slope {slope:.2}"));
    let time = group.seconds_to_a_level(kind);
    let time = time.map_or("not reached".into(), |seconds| format!("{seconds:.3} s"));
    format!(
        "<span><svg viewBox=\"-8 -8 16 16\"><path class=\"{name}\" d=\"{}\"/></svg>{name}{slope}; to 1 level: {time}</span>\n",
        marker(kind)
    )
}

fn row(report: &ErrorReport, one: &Measurement, is_on_front: bool) -> String {
    let [is_numerical, is_in_single] = report.is_numerical(one);
    let note = if is_numerical {
        "numerical"
    } else if is_in_single {
        "f32"
    } else {
        ""
    };
    let class = match one.changed {
        _ if is_numerical => " class=\"wrong\"",
        Some(1..) => " class=\"wrong\"",
        _ if is_on_front => " class=\"on\"",
        _ => "",
    };
    let star = if is_on_front { "\u{2605}" } else { "" };
    let changed = one.changed.map_or(String::new(), |pixels| format!("{pixels} pixels"));
    let numbers = [
        format!("{:.5}", one.least()),
        format!("{:.5}", one.median()),
        one.times.len().to_string(),
        format!("{:.2}", one.megarays()),
        format!("{:.3}", one.error),
        format!("{:.2}", one.psnr()),
        format!("{:.4}", one.flip),
        format!("{:.2}%", 100.0 * one.off),
        changed,
        note.into(),
    ];
    let numbers = numbers.map(|number| format!("<td>{number}</td>")).concat();
    let name = html(&one.setting.label());
    format!("<tr{class}><td>{star}</td><td class=\"name\"><code>{name}</code></td>{numbers}</tr>\n")
}

/// The reference, and the pictures of the front from the cheapest on, each beside a map of its error.
fn pictures(group: &MeasuredFilter) -> String {
    let mut shown: Vec<&Measurement> = group
        .measurements
        .iter()
        .zip(group.front())
        .filter(|(_, is_on_front)| *is_on_front)
        .map(|(one, _)| one)
        .collect();
    shown.sort_by(|a, b| a.least().total_cmp(&b.least()));
    let figures: String = shown.into_iter().map(|one| figure(one, &group.reference)).collect();
    format!(
        "<h2>Pictures of the front, and where they err</h2>\n<p>The maps show the largest difference of a channel from \
         the reference, black for none and white for {BRIGHTEST} levels or more.</p>\n<div class=\"pictures\">\n\
         <figure><div><img alt=\"the reference\" src=\"{}\"></div><figcaption>The reference</figcaption></figure>\n\
         {figures}</div>\n",
        data(&group.reference)
    )
}

fn figure(one: &Measurement, reference: &Picture) -> String {
    format!(
        "<figure><div><img alt=\"the picture\" src=\"{}\"><img alt=\"its error\" src=\"{}\"></div>\
         <figcaption><code>{}</code><br>{:.4} s, RMSE {:.3}</figcaption></figure>\n",
        data(&one.picture),
        data(&error_map(&one.picture, reference)),
        html(&one.setting.label()),
        one.least(),
        one.error
    )
}

fn data(picture: &Picture) -> String {
    format!("data:image/png;base64,{}", file(picture))
}

/// The pictures must be of one size.
fn error_map(picture: &Picture, reference: &Picture) -> Picture {
    let differences =
        colors(picture).iter().zip(colors(reference)).map(|(a, b)| largest_channel_difference(*a, *b));
    let shown = differences.flat_map(|levels| cubehelix(f64::from(levels) / f64::from(BRIGHTEST)));
    Picture::from_rgb(picture.width(), picture.height(), shown.collect())
}

fn stages(report: &ErrorReport) -> String {
    let rows = report.stages.iter().map(|(stage, time)| {
        format!("<tr><td class=\"name\">{stage}</td><td>{:.3} s</td></tr>\n", time.as_secs_f64())
    });
    let rows: String = rows.collect();
    format!("<h2>Time of this report by stage</h2>\n<table><tbody>\n{rows}</tbody></table>\n")
}
