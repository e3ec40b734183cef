//! Speed against error: what each setting of the renderer costs for a scene, and what it buys.
//!
//! A [`Sweep`] renders a reference and then one setting after the other. Its [`ErrorReport`] is shown as [`text`] for a
//! terminal, as a table ([`csv`]) and as a [`page`].
//!
//! What the request asks for, with endlessly many samples, is right. Each filter makes pictures of its own, so that a
//! setting is measured by the reference of its filter. An [`Answer`] chooses among all settings of all filters.

mod answer;
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

pub use answer::{Answer, USUAL_TARGETS};
pub use csv::csv;
pub use numerical::{Departure, Numerical};
pub use page::page;
pub use setting::{Axis, Samples, SamplingKind, Setting, filter_flag, separate};
pub use sweep::{Bench, Sweep, SweepProgress};
pub use text::text;

use crate::picture::Picture;
use crate::sampling::filter::Filter;
use curve::Point;
use std::time::Duration;

/// An error that nobody sees: one level, the step from one byte to the next.
pub const LEVEL: f64 = 1.0;

/// What was measured of a scene.
#[derive(Clone, Debug)]
pub struct ErrorReport {
    /// Width and height of the pictures in pixels.
    pub size: [usize; 2],
    /// One for each filter, the one that was asked for first.
    pub groups: Vec<MeasuredFilter>,
    /// What roundings do, apart from sampling; none if it was not measured.
    pub numerical: Option<Numerical>,
    /// The number of settings that were to be measured.
    pub planned: usize,
    /// The stages and the time that each took.
    pub stages: Vec<(&'static str, Duration)>,
}

/// The measurements of one filter.
#[derive(Clone, Debug)]
pub struct MeasuredFilter {
    /// The filter.
    pub filter: Filter,
    /// What the pictures are measured by.
    pub reference: Picture,
    /// The root mean square error of each half of the reference, in levels.
    pub noise: f64,
    /// In the order in which they were made.
    pub measurements: Vec<Measurement>,
}

/// What a setting costs and buys.
#[derive(Clone, Debug)]
pub struct Measurement {
    /// The setting.
    pub setting: Setting,
    /// The processor's time for rendering on one thread, of each repeat, from the shortest.
    pub times: Vec<Duration>,
    /// The rays that are cast, as `-stats` counts them.
    pub rays: u64,
    /// The root mean square error of the colours in levels, without that of the reference.
    pub error: f64,
    /// The mean error of LDR-FLIP of the picture's bytes against those of the reference.
    pub flip: f64,
    /// The share of pixels of which a byte is off by more than a level.
    pub off: f64,
    /// For another structure, the number of pixels whose bytes differ from those with the structure asked for. It must
    /// be zero.
    pub changed: Option<u64>,
    /// The picture itself.
    pub picture: Picture,
}

impl Measurement {
    /// The shortest time in seconds.
    pub fn least(&self) -> f64 {
        self.times.first().map_or(0.0, Duration::as_secs_f64)
    }

    /// The median time in seconds.
    pub fn median(&self) -> f64 {
        self.times.get(self.times.len() / 2).map_or(0.0, Duration::as_secs_f64)
    }

    /// Millions of rays in a second of the shortest time.
    pub fn megarays(&self) -> f64 {
        self.rays as f64 / self.least() / 1e6
    }

    /// The peak signal-to-noise ratio in dB, infinite without an error.
    pub fn psnr(&self) -> f64 {
        20.0 * libm::log10(255.0 / self.error)
    }

    /// Whether flags can ask for it, and it is there for its own sake. Structures are compared with each other: their
    /// error is the same, and their time is not all that they cost.
    fn is_candidate(&self) -> bool {
        self.setting.flags().is_some() && self.setting.axis != Axis::Structure
    }

    /// The time and the error.
    fn point(&self) -> Point {
        [self.least(), self.error]
    }
}

impl MeasuredFilter {
    /// Which measurements are on the front of this filter: none is as fast and better, or as good and faster. Grids are
    /// not compared, nor what no flags can ask for.
    pub fn front(&self) -> Vec<bool> {
        let is_on = front_of(self.measurements.iter().filter(|one| one.is_candidate()));
        self.measurements.iter().map(|one| is_on.iter().any(|other| std::ptr::eq(*other, one))).collect()
    }

    /// The measurements of one kind of sampling with all that was asked for.
    pub fn curve(&self, kind: SamplingKind) -> impl Iterator<Item = &Measurement> {
        let is_wanted =
            move |one: &&Measurement| one.setting.axis == Axis::Samples && one.setting.kind() == kind;
        self.measurements.iter().filter(is_wanted)
    }

    /// The exponent with which the error changes with the number of samples, from 4 samples on.
    pub fn slope(&self, kind: SamplingKind) -> Option<f64> {
        const FIRST: u32 = 4;
        let points = self.curve(kind).filter_map(|one| {
            let count = one.setting.count().filter(|&count| count >= FIRST)?;
            Some([f64::from(count), one.error])
        });
        curve::slope(&points.collect::<Vec<_>>())
    }

    /// The processor's time in seconds with which a kind of sampling reaches an error of one level.
    pub fn seconds_to_a_level(&self, kind: SamplingKind) -> Option<f64> {
        let mut points: Vec<Point> = self.curve(kind).map(Measurement::point).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        curve::cost_of(LEVEL, &points)
    }
}

/// Those that nothing else beats, in the order given.
fn front_of<'a>(measurements: impl Iterator<Item = &'a Measurement>) -> Vec<&'a Measurement> {
    let all: Vec<&Measurement> = measurements.collect();
    let points: Vec<Point> = all.iter().map(|one| one.point()).collect();
    let is_on = curve::front(&points);
    all.into_iter().zip(is_on).filter(|(_, is_on)| *is_on).map(|(one, _)| one).collect()
}

impl ErrorReport {
    /// Whether roundings are more than a tenth of a setting's error: those of this program, and those of a tracer in
    /// single precision.
    pub fn is_numerical(&self, one: &Measurement) -> [bool; 2] {
        let is_more = |departure: Departure| departure.error > one.error / 10.0;
        self.numerical.map_or([false; 2], |found| [found.program, found.single].map(is_more))
    }

    /// The number of settings that were measured.
    pub fn measured(&self) -> usize {
        self.groups.iter().map(|group| group.measurements.len()).sum()
    }

    /// What flags can ask for, of all filters.
    fn candidates(&self) -> impl Iterator<Item = &Measurement> {
        self.groups.iter().flat_map(|group| &group.measurements).filter(|one| one.is_candidate())
    }

    /// What nothing else beats, of all filters: none is as fast and better, or as good and faster. The fastest first.
    pub fn front(&self) -> Vec<&Measurement> {
        let mut front = front_of(self.candidates());
        front.sort_by(|a, b| a.least().total_cmp(&b.least()));
        front
    }

    /// The pixels that other structures change, of which there must be none.
    pub fn pixels_changed(&self) -> u64 {
        self.groups.iter().flat_map(|group| &group.measurements).filter_map(|one| one.changed).sum()
    }
}
