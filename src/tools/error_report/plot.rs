//! Plots with two logarithmic axes, as SVG within a page. Their text is in `templates/plot.html`.

use super::curve::Point;
use super::{LEVEL, MeasuredFilter, SamplingKind};
use askama::Template;

/// The size of a plot, in pixels.
const SIZE: [f64; 2] = [620.0, 400.0];
/// The space above the axes, and to the right of them.
const SPACE: f64 = 16.0;
/// The ends of the axes.
const LEFT: f64 = 64.0;
const RIGHT: f64 = SIZE[0] - SPACE;
const BOTTOM: f64 = SIZE[1] - 44.0;

/// The points of one kind of sampling, each with its name.
struct Series {
    kind: SamplingKind,
    points: Vec<(Point, String)>,
}

impl Series {
    fn points(&self) -> impl Iterator<Item = &Point> {
        self.points.iter().map(|(point, _)| point)
    }
}

/// A line drawn behind the points.
struct Line {
    class: String,
    points: Vec<Point>,
}

#[derive(Template)]
#[template(path = "plot.html")]
struct Plot {
    title: &'static str,
    /// The name of the horizontal axis.
    across: &'static str,
    axes: Axes,
    series: Vec<Series>,
    lines: Vec<Line>,
    rings: Vec<Point>,
}

impl Plot {
    fn points<'p>(&self, points: impl Iterator<Item = &'p Point>) -> String {
        let place = |point: &Point| {
            let [x, y] = self.axes.at(point);
            format!("{x:.1},{y:.1}")
        };
        points.map(place).collect::<Vec<_>>().join(" ")
    }
}

/// Plots the error against the processor's time, with the front as a line. Returns nothing if there is no error.
pub fn against_time(group: &MeasuredFilter) -> String {
    let series = series(group, |one| Some(one.least()));
    let Some(axes) = Axes::of(&series) else { return String::new() };
    let mut front: Vec<Point> = group
        .measurements
        .iter()
        .zip(group.front())
        .filter(|(one, is_on_front)| *is_on_front && one.error > 0.0)
        .map(|(one, _)| one.point())
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let lines = vec![Line { class: "front".into(), points: front.clone() }];
    let (title, across) = ("Error against time", "processor time, s");
    Plot { title, across, axes, series, lines, rings: front }.to_string()
}

/// Plots the error against the number of samples, with the fitted lines. Returns nothing if there is no error.
pub fn against_samples(group: &MeasuredFilter) -> String {
    let series = series(group, |one| one.setting.count().map(f64::from));
    let Some(axes) = Axes::of(&series) else { return String::new() };
    let fit = |series: &Series| {
        let slope = group.slope(series.kind)?;
        // The fitted line passes through the mean of the logarithms, which the middle point approximates.
        let fitted: Vec<Point> = series.points().copied().filter(|[n, _]| *n >= 4.0).collect();
        let mean = |axis: usize| {
            fitted.iter().map(|point| libm::log(point[axis])).sum::<f64>() / fitted.len() as f64
        };
        let at = |n: f64| [n, libm::exp(mean(1) + slope * (libm::log(n) - mean(0)))];
        let points = vec![at(fitted.first()?[0]), at(fitted.last()?[0])];
        Some(Line { class: format!("fit {}", series.kind.name()), points })
    };
    let lines = series.iter().filter_map(fit).collect();
    let (title, across) = ("Error against samples", "samples in a pixel");
    Plot { title, across, axes, series, lines, rings: vec![] }.to_string()
}

/// Returns the points of each kind that have an error, in the order of the first coordinate.
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

/// The ranges of the two axes, as powers of ten.
struct Axes {
    low: Point,
    high: Point,
}

impl Axes {
    /// Returns the axes of these points, or `None` if there is no point.
    fn of(series: &[Series]) -> Option<Self> {
        let all = || series.iter().flat_map(Series::points);
        all().next()?;
        let low = [0, 1].map(|axis| all().map(|point| libm::log10(point[axis])).fold(f64::MAX, f64::min));
        let high = [0, 1].map(|axis| all().map(|point| libm::log10(point[axis])).fold(f64::MIN, f64::max));
        // The range is extended by a little room around the points.
        let room = [0, 1].map(|axis: usize| (0.06 * (high[axis] - low[axis])).max(0.1));
        let (low, high) = ([0, 1].map(|k: usize| low[k] - room[k]), [0, 1].map(|k: usize| high[k] + room[k]));
        Some(Self { low, high })
    }

    /// Returns the position of a point in the plot.
    fn at(&self, point: &Point) -> Point {
        let share =
            |axis: usize| (libm::log10(point[axis]) - self.low[axis]) / (self.high[axis] - self.low[axis]);
        [LEFT + share(0) * (RIGHT - LEFT), SPACE + (1.0 - share(1)) * (BOTTOM - SPACE)]
    }

    /// Returns the numbers 1, 2 and 5 times a power of ten on an axis.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let powers = self.low[axis].floor() as i32..=self.high[axis].ceil() as i32;
        let numbers = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
        numbers.filter(|&n| (self.low[axis]..=self.high[axis]).contains(&libm::log10(n))).collect()
    }
}

/// Returns the shape that marks a kind of sampling, so that kinds can be distinguished without colour.
pub fn marker(kind: SamplingKind) -> &'static str {
    match kind {
        SamplingKind::Random => "M-4 -4L4 4M-4 4L4 -4",
        SamplingKind::Uniform => "M-4 -4H4V4H-4Z",
        SamplingKind::Jittered => "M0 -5L5 4H-5Z",
        SamplingKind::Adaptive => "M0 -6L6 0L0 6L-6 0Z",
    }
}
