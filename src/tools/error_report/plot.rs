//! Plots with two logarithmic axes, as SVG within a page.

use super::curve::Point;
use super::{MeasuredFilter, SamplingKind};
use crate::escape::html;
use std::fmt::Write;

/// The size of a plot and its margins to the left and below, in pixels.
const SIZE: [f64; 2] = [620.0, 400.0];
const MARGIN: [f64; 2] = [64.0, 44.0];
/// The space above, and to the right.
const SPACE: f64 = 16.0;

/// The points of one kind of sampling, each with its name.
struct Series {
    kind: SamplingKind,
    points: Vec<(Point, String)>,
}

/// Error against the processor's time, with the front as a line.
pub fn against_time(group: &MeasuredFilter) -> String {
    let series = series(group, |one| Some(one.least()));
    let mut front: Vec<Point> = group
        .measurements
        .iter()
        .zip(group.front())
        .filter(|(one, is_on_front)| *is_on_front && one.error > 0.0)
        .map(|(one, _)| one.point())
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    draw("Error against time", "processor time, s", &series, |axes| {
        let line: String = front.iter().map(|&point| axes.place(point)).collect::<Vec<_>>().join(" ");
        let rings = front.iter().map(|&point| {
            let [x, y] = axes.at(point);
            format!("<circle class=\"front\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"8\"/>")
        });
        format!("<polyline class=\"front\" points=\"{line}\"/>\n{}\n", rings.collect::<String>())
    })
}

/// Error against the number of samples, with the fitted lines.
pub fn against_samples(group: &MeasuredFilter) -> String {
    let series = series(group, |one| one.setting.count().map(f64::from));
    draw("Error against samples", "samples in a pixel", &series, |axes| {
        let fits = series.iter().filter_map(|series| {
            let slope = group.slope(series.kind)?;
            // The fitted line runs through the mean of the logarithms, which the middle point is close to.
            let fitted: Vec<Point> =
                series.points.iter().map(|(point, _)| *point).filter(|[n, _]| *n >= 4.0).collect();
            let mean = |axis: usize| {
                fitted.iter().map(|point| libm::log(point[axis])).sum::<f64>() / fitted.len() as f64
            };
            let [first, last] = [fitted.first()?[0], fitted.last()?[0]];
            let at = |n: f64| [n, libm::exp(mean(1) + slope * (libm::log(n) - mean(0)))];
            let (start, end) = (axes.place(at(first)), axes.place(at(last)));
            let class = series.kind.name();
            Some(format!("<polyline class=\"fit {class}\" points=\"{start} {end}\"/>\n"))
        });
        fits.collect()
    })
}

/// The points of each kind that have an error, in the order of the first coordinate.
fn series(group: &MeasuredFilter, x: impl Fn(&super::Measurement) -> Option<f64>) -> Vec<Series> {
    let of = |kind: SamplingKind| {
        let points = group.curve(kind).filter_map(|one| {
            let name = format!("{}: {:.5} s, {:.3} levels", one.setting.label(), one.least(), one.error);
            (one.error > 0.0).then_some(([x(one)?, one.error], name))
        });
        let mut points: Vec<_> = points.filter(|(point, _)| point[0] > 0.0).collect();
        points.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]));
        Series { kind, points }
    };
    SamplingKind::ALL.into_iter().map(of).filter(|series| !series.points.is_empty()).collect()
}

/// The powers of ten between which both coordinates lie.
struct Axes {
    low: Point,
    high: Point,
}

impl Axes {
    fn of(series: &[Series]) -> Self {
        let all = || series.iter().flat_map(|series| &series.points).map(|(point, _)| point);
        let low = [0, 1].map(|axis| all().map(|point| libm::log10(point[axis])).fold(f64::MAX, f64::min));
        let high = [0, 1].map(|axis| all().map(|point| libm::log10(point[axis])).fold(f64::MIN, f64::max));
        // Half a decade is the least, and a little room around the points.
        let room = [0, 1].map(|axis: usize| (0.06 * (high[axis] - low[axis])).max(0.1));
        Self { low: [0, 1].map(|k: usize| low[k] - room[k]), high: [0, 1].map(|k: usize| high[k] + room[k]) }
    }

    fn at(&self, point: Point) -> Point {
        let share =
            |axis: usize| (libm::log10(point[axis]) - self.low[axis]) / (self.high[axis] - self.low[axis]);
        let [width, height] = [SIZE[0] - MARGIN[0] - SPACE, SIZE[1] - MARGIN[1] - SPACE];
        [MARGIN[0] + share(0) * width, SPACE + (1.0 - share(1)) * height]
    }

    fn place(&self, point: Point) -> String {
        let [x, y] = self.at(point);
        format!("{x:.1},{y:.1}")
    }

    /// The numbers 1, 2 and 5 times a power of ten that lie on an axis.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let powers = self.low[axis].floor() as i32..=self.high[axis].ceil() as i32;
        let numbers = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
        numbers.filter(|&n| (self.low[axis]..=self.high[axis]).contains(&libm::log10(n))).collect()
    }
}

fn draw(title: &str, across: &str, series: &[Series], lines: impl FnOnce(&Axes) -> String) -> String {
    if series.is_empty() {
        return String::new();
    }
    let axes = Axes::of(series);
    let [width, height] = SIZE;
    let mut svg = format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{title}\">\n<title>{title}</title>\n"
    );
    add_ticks(&mut svg, &axes);
    let (middle, below) = ((MARGIN[0] + width - SPACE) / 2.0, height - 6.0);
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "<text class=\"axis\" x=\"{middle}\" y=\"{below}\">{across}</text>");
    let up = (SPACE + height - MARGIN[1]) / 2.0;
    let _ = writeln!(
        svg,
        "<text class=\"axis\" transform=\"translate(14 {up}) rotate(-90)\">root mean square error, levels</text>"
    );
    svg += &lines(&axes);
    series.iter().for_each(|series| add_series(&mut svg, &axes, series));
    svg + "</svg>\n"
}

fn add_ticks(svg: &mut String, axes: &Axes) {
    let [right, bottom] = [SIZE[0] - SPACE, SIZE[1] - MARGIN[1]];
    for n in axes.ticks(0) {
        let [x, _] = axes.at([n, 1.0]);
        let _ = writeln!(
            svg,
            "<path class=\"grid\" d=\"M{x:.1} {SPACE}V{bottom}\"/><text class=\"x\" x=\"{x:.1}\" y=\"{}\">{n}</text>",
            bottom + 16.0
        );
    }
    for n in axes.ticks(1) {
        let ([_, y], left) = (axes.at([1.0, n]), MARGIN[0]);
        let class = if n == super::LEVEL { "level" } else { "grid" };
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" d=\"M{left} {y:.1}H{right}\"/><text class=\"y\" x=\"{}\" y=\"{:.1}\">{n}</text>",
            left - 6.0,
            y + 4.0
        );
    }
}

fn add_series(svg: &mut String, axes: &Axes, series: &Series) {
    let class = series.kind.name();
    let places: Vec<String> = series.points.iter().map(|(point, _)| axes.place(*point)).collect();
    let _ = writeln!(svg, "<polyline class=\"{class}\" points=\"{}\"/>", places.join(" "));
    for (point, name) in &series.points {
        let [x, y] = axes.at(*point);
        let _ = writeln!(
            svg,
            "<path class=\"{class}\" transform=\"translate({x:.1} {y:.1})\" d=\"{}\"><title>{}</title></path>",
            marker(series.kind),
            html(name)
        );
    }
}

/// The shape that stands for a kind of sampling, so that nobody needs to tell colours apart.
pub fn marker(kind: SamplingKind) -> &'static str {
    match kind {
        SamplingKind::Random => "M-4 -4L4 4M-4 4L4 -4",
        SamplingKind::Uniform => "M-4 -4H4V4H-4Z",
        SamplingKind::Jittered => "M0 -5L5 4H-5Z",
        SamplingKind::Adaptive => "M0 -6L6 0L0 6L-6 0Z",
    }
}
