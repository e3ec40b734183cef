//! Speed against error: measures the cost and the error of each setting of the renderer for a scene.
//!
//! [`measure`] renders a reference and then one setting after the other. Its [`ErrorReport`] is written as `text` for
//! a terminal, as a table (`csv`) and as a `page`.
//!
//! The converged picture of the request is the reference. Filters give different pictures, so each setting is compared
//! with the reference for its own filter. An [`Answer`] chooses among all settings of all filters.

mod csv;
mod curve;
mod numerical;
mod page;
mod plan;
mod plot;
mod reference;
mod setting;
mod sweep;
mod text;

pub use csv::csv;
pub use numerical::{Deviation, Numerical};
pub use page::page;
pub use plan::plan;
pub use setting::{Axis, SamplingKind, Setting};
pub use sweep::{Bench, measure};
pub use text::text;

use crate::picture::Picture;
use crate::sampling::filter::Filter;
use curve::{Point, Power};
use std::time::Duration;

/// An invisible error: one level, the step from one byte to the next.
pub const LEVEL: f64 = 1.0;

/// The measurements of a scene.
#[derive(Clone, Debug)]
pub struct ErrorReport {
    pub size: [usize; 2],
    /// The measurements of each filter. The request's filter comes first.
    pub groups: Vec<MeasuredFilter>,
    /// The effect of rounding, apart from sampling. `None` if it was not measured.
    pub numerical: Option<Numerical>,
    pub planned: usize,
    /// The program, the machine and the date of the measurements, as one line.
    pub origin: String,
    /// The time of all measurements.
    pub time: Duration,
}

/// The measurements of one filter.
#[derive(Clone, Debug)]
pub struct MeasuredFilter {
    pub filter: Filter,
    pub reference: Picture,
    /// The root mean square error of each half of the reference, in levels.
    pub noise: f64,
    pub measurements: Vec<Measurement>,
}

/// The cost and the error of a setting.
#[derive(Clone, Debug)]
pub struct Measurement {
    pub setting: Setting,
    /// The CPU times for rendering on one thread, one per repeat, sorted from the shortest.
    pub times: Vec<Duration>,
    /// The number of rays cast, as counted by `-stats`.
    pub rays: u64,
    /// The root mean square error of the colours in levels, without the reference's own noise.
    pub error: f64,
    /// The mean error of LDR-FLIP, comparing the bytes of the picture with the reference.
    pub flip: f64,
    /// The share of pixels with a byte that is off by more than one level.
    pub off: f64,
    /// For another structure, the number of pixels whose bytes differ from those with the requested structure. It must
    /// be zero.
    pub changed: Option<u64>,
    pub picture: Picture,
}

impl Measurement {
    pub fn least(&self) -> f64 {
        self.times.first().map_or(0.0, Duration::as_secs_f64)
    }

    pub fn median(&self) -> f64 {
        self.times.get(self.times.len() / 2).map_or(0.0, Duration::as_secs_f64)
    }

    /// Returns millions of rays per second, from the shortest time. `None` if that is less than a step of the clock.
    pub fn megarays(&self) -> Option<f64> {
        let seconds = self.least();
        (seconds > 0.0).then(|| self.rays as f64 / seconds / 1e6)
    }

    /// Returns the peak signal-to-noise ratio in dB. It is infinite without an error.
    pub fn psnr(&self) -> f64 {
        20.0 * libm::log10(255.0 / self.error)
    }

    /// Returns true if flags can express the setting and it is not a comparison of structures. Structures have the same
    /// error, and their time is not their whole cost.
    fn is_candidate(&self) -> bool {
        matches!(self.setting.axis, Axis::Samples | Axis::Secondary)
    }

    /// Returns true if it is one of these, not only equal to one.
    fn is_among(&self, others: &[&Self]) -> bool {
        others.iter().any(|other| std::ptr::eq(*other, self))
    }

    fn point(&self) -> Point {
        [self.least(), self.error]
    }
}

impl MeasuredFilter {
    /// Returns the measurements on this filter's Pareto front of time and error, fastest first. Grids are excluded, and
    /// settings that flags cannot express.
    pub fn front(&self) -> Vec<&Measurement> {
        let candidates = self.measurements.iter().filter(|one| one.is_candidate());
        curve::front(candidates.collect(), |one| one.point())
    }

    /// Returns the measurements of one kind of sampling with all requested effects.
    pub fn curve(&self, kind: SamplingKind) -> impl Iterator<Item = &Measurement> {
        let is_wanted =
            move |one: &&Measurement| one.setting.axis == Axis::Samples && one.setting.kind() == kind;
        self.measurements.iter().filter(is_wanted)
    }

    /// Fits the errors of a kind of sampling from 4 samples on.
    fn fit(&self, kind: SamplingKind) -> Option<Power> {
        const FIRST: u32 = 4;
        Power::fit(self.curve(kind).filter_map(|one| {
            let count = one.setting.count().filter(|&count| count >= FIRST)?;
            Some([f64::from(count), one.error])
        }))
    }

    /// Returns the exponent with which the error changes with the number of samples, from 4 samples on.
    pub fn slope(&self, kind: SamplingKind) -> Option<f64> {
        self.fit(kind).map(|power| power.slope)
    }

    /// Returns the CPU time in seconds with which a kind of sampling reaches an error of one level.
    pub fn seconds_to_a_level(&self, kind: SamplingKind) -> Option<f64> {
        let mut points: Vec<Point> = self.curve(kind).map(Measurement::point).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        curve::cost_of(LEVEL, &points)
    }
}

/// A measurement, as the tables show it.
pub struct Line<'r> {
    pub group: &'r MeasuredFilter,
    pub one: &'r Measurement,
    pub is_on_front: bool,
    /// True if rounding causes more than a tenth of the error.
    pub is_numerical: bool,
    /// True if rounding would, in a tracer with single precision.
    pub is_numerical_in_single: bool,
}

impl ErrorReport {
    pub fn lines<'r>(&self, group: &'r MeasuredFilter) -> Vec<Line<'r>> {
        let front = group.front();
        let line = |one: &'r Measurement| {
            let is_more = |deviation: Deviation| deviation.error > one.error / 10.0;
            Line {
                group,
                one,
                is_on_front: one.is_among(&front),
                is_numerical: self.numerical.is_some_and(|found| is_more(found.program)),
                is_numerical_in_single: self.numerical.is_some_and(|found| is_more(found.single)),
            }
        };
        group.measurements.iter().map(line).collect()
    }

    pub fn measured(&self) -> usize {
        self.groups.iter().map(|group| group.measurements.len()).sum()
    }

    /// Returns the measurements of all filters that flags can express.
    fn candidates(&self) -> impl Iterator<Item = &Measurement> {
        self.groups.iter().flat_map(|group| &group.measurements).filter(|one| one.is_candidate())
    }

    /// Returns the Pareto front of time and error over all filters, fastest first.
    pub fn front(&self) -> Vec<&Measurement> {
        curve::front(self.candidates().collect(), |one| one.point())
    }

    /// Returns the number of pixels that other structures change. It must be 0.
    pub fn pixels_changed(&self) -> u64 {
        self.groups.iter().flat_map(|group| &group.measurements).filter_map(|one| one.changed).sum()
    }
}

/// The targets answered if the user gives none, in levels.
pub const USUAL_TARGETS: [f64; 4] = [0.5, 1.0, 2.0, 4.0];

/// The setting chosen for a target.
#[derive(Clone, Debug)]
pub struct Answer<'a> {
    /// The target: the largest permitted root mean square error, in levels.
    pub target: f64,
    /// The cheapest setting that reaches the target, or the nearest one if none does.
    pub chosen: &'a Measurement,
    /// The command line of the setting.
    pub command: String,
}

impl<'a> Answer<'a> {
    /// Chooses among all settings that flags can express, with any samples and filter. `None` if nothing was measured.
    pub fn new(report: &'a ErrorReport, target: f64, command: impl Fn(&Setting) -> String) -> Option<Self> {
        let order = |[a, b]: [f64; 2], [c, d]: [f64; 2]| a.total_cmp(&c).then(b.total_cmp(&d));
        // On the front: of those as fast, or with the same error, the best.
        let fastest = |one: &&Measurement, other: &&Measurement| order(one.point(), other.point());
        let nearest = |one: &&Measurement, other: &&Measurement| {
            order([one.error, one.least()], [other.error, other.least()])
        };
        let reaching = report.candidates().filter(|one| one.error <= target).min_by(fastest);
        let chosen = reaching.or_else(|| report.candidates().min_by(nearest))?;
        Some(Self { target, chosen, command: command(&chosen.setting) })
    }

    pub fn is_reached(&self) -> bool {
        self.chosen.error <= self.target
    }
}
