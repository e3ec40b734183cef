//! Plots with two logarithmic axes, as SVG within a page. Their text is in `templates/plot.html`.

use super::curve::Point;
use super::{LEVEL, MeasuredFilter, Measurement, SamplingKind};
use askama::Template;

/// The size of a plot, in pixels.
const SIZE: [f64; 2] = [620.0, 400.0];
/// The space above the axes, and to the right of them.
const SPACE: f64 = 16.0;
/// The ends of the axes.
const LEFT: f64 = 64.0;
const RIGHT: f64 = SIZE[0] - SPACE;
const BOTTOM: f64 = SIZE[1] - 44.0;

/// The points of one kind of sampling, and their names.
type Series = (SamplingKind, Vec<Point>, Vec<String>);

#[derive(Template)]
#[template(path = "plot.html")]
struct Plot {
    title: &'static str,
    /// The name of the horizontal axis.
    across: &'static str,
    series: Vec<Series>,
    /// The lines drawn behind the points, each with its class. The points of the front have rings.
    lines: Vec<(String, Vec<Point>)>,
    /// The ends of the two axes, as powers of ten.
    low: Point,
    high: Point,
}

/// Plots the error against the processor's time, with the front as a line. Returns nothing if there is no error.
pub fn against_time(group: &MeasuredFilter) -> String {
    let front = group.front().into_iter().map(Measurement::point).filter(is_drawn);
    let lines = vec![("front".into(), front.collect())];
    plot(["Error against time", "processor time, s"], series(group, |one| Some(one.least())), lines)
}

/// Plots the error against the number of samples, with the fitted lines. Returns nothing if there is no error.
pub fn against_samples(group: &MeasuredFilter) -> String {
    let series = series(group, |one| one.setting.count().map(f64::from));
    let fit = |(kind, ..): &Series| Some((format!("fit {}", kind.name()), group.fit(*kind)?.ends.to_vec()));
    let lines = series.iter().filter_map(fit).collect();
    plot(["Error against samples", "samples in a pixel"], series, lines)
}

/// Returns true if a point has a place on the axes. A time of less than a step of the clock is 0.
fn is_drawn(point: &Point) -> bool {
    point.iter().all(|&coordinate| coordinate > 0.0)
}

/// Draws a plot whose axes are just long enough for its points. Returns nothing if there is no point.
fn plot([title, across]: [&'static str; 2], series: Vec<Series>, lines: Vec<(String, Vec<Point>)>) -> String {
    let points = || series.iter().flat_map(|(_, points, _)| points);
    if points().next().is_none() {
        return String::new();
    }
    let ends = |axis: usize| {
        let logarithms = || points().map(|point| libm::log10(point[axis]));
        let (low, high) = (logarithms().fold(f64::MAX, f64::min), logarithms().fold(f64::MIN, f64::max));
        // A little room around the points.
        let room = (0.06 * (high - low)).max(0.1);
        [low - room, high + room]
    };
    let [[left, right], [bottom, top]] = [ends(0), ends(1)];
    Plot { title, across, series, lines, low: [left, bottom], high: [right, top] }.to_string()
}

impl Plot {
    /// Returns the position of a point in the plot.
    fn at(&self, point: &Point) -> Point {
        let share =
            |axis: usize| (libm::log10(point[axis]) - self.low[axis]) / (self.high[axis] - self.low[axis]);
        [LEFT + share(0) * (RIGHT - LEFT), SPACE + (1.0 - share(1)) * (BOTTOM - SPACE)]
    }

    /// Returns the positions of points, as a polyline takes them.
    fn points(&self, points: &[Point]) -> String {
        let place = |point: &Point| {
            let [x, y] = self.at(point);
            format!("{x:.1},{y:.1}")
        };
        points.iter().map(place).collect::<Vec<_>>().join(" ")
    }

    /// Returns the numbers 1, 2 and 5 times a power of ten on an axis.
    fn ticks(&self, axis: usize) -> Vec<f64> {
        let powers = self.low[axis].floor() as i32..=self.high[axis].ceil() as i32;
        let numbers = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10f64.powi(power)));
        numbers.filter(|&n| (self.low[axis]..=self.high[axis]).contains(&libm::log10(n))).collect()
    }
}

/// Returns the points of each kind that are drawn, in the order of the first coordinate.
fn series(group: &MeasuredFilter, x: impl Fn(&Measurement) -> Option<f64>) -> Vec<Series> {
    let of = |kind: SamplingKind| {
        let points = group.curve(kind).filter_map(|one| {
            let name = format!("{}: {:.5} s, {:.3} levels", one.setting.label(), one.least(), one.error);
            Some(([x(one)?, one.error], name))
        });
        let mut points: Vec<_> = points.filter(|(point, _)| is_drawn(point)).collect();
        points.sort_by(|(a, _), (b, _)| a[0].total_cmp(&b[0]));
        let (points, names): (Vec<_>, _) = points.into_iter().unzip();
        (kind, points, names)
    };
    SamplingKind::ALL.into_iter().map(of).filter(|(_, points, _)| !points.is_empty()).collect()
}

/// Returns the shape that marks a kind of sampling, so that kinds can be distinguished without colour.
pub fn marker(kind: SamplingKind) -> &'static str {
    match kind {
        SamplingKind::Random => "M-4 -4L4 4M-4 4L4 -4",
        SamplingKind::Uniform => "M-4 -4H4V4H-4Z",
        SamplingKind::Jittered => "M0 -5L5 4H-5Z",
        SamplingKind::Sobol => "M0 -5L5 -1L3 5H-3L-5 -1Z",
        SamplingKind::Adaptive => "M0 -6L6 0L0 6L-6 0Z",
    }
}
