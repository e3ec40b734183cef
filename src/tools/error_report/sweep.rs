//! Renders and measures one setting after the other.

use super::numerical::{self, Numerical};
use super::plan::{plan, with_octaves};
use super::reference::{self, Reference};
use super::setting::{Axis, Setting};
use super::{ErrorReport, MeasuredFilter, Measurement};
use crate::diagnostic::Diagnostic;
use crate::picture::{Color, FloatPicture, Picture};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Progress, Request, Stopped};
use crate::sampling::filter::Filter;
use crate::tools::compare::Comparison;
use rayon::ThreadPool;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// The threads, the clock and the watch used for measurements.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The threads that render references.
    pub many: &'a ThreadPool,
    /// The single thread whose time is measured.
    pub one: &'a ThreadPool,
    pub clock: &'a (dyn Fn() -> Duration + Sync),
    /// Receives the completed fraction, from 0 to 1, and the current activity. It may end the sweep.
    pub watch: &'a (dyn Fn(f64, &str) -> ControlFlow<()> + Sync),
}

/// A setting is repeated until it has taken this time, but at least [`FEWEST`] and at most [`MOST`] times.
const ENOUGH: Duration = Duration::from_millis(200);
const FEWEST: usize = 2;
const MOST: usize = 15;

/// The approximate number of times that a setting is rendered.
const RENDERINGS: f64 = 4.0;

/// The approximate number of samples of an adaptive setting.
const ADAPTIVE_SAMPLES: f64 = 16.0;

/// Measures the settings of a scene, or those with the filter of `own` alone. `own` is the setting of the command line.
/// The renderer must have kept the scene's meshes and must have no threads of its own. If the watch ends the sweep, the
/// report has the finished settings.
pub fn measure(
    renderer: &Renderer,
    own: &Setting,
    bench: Bench,
    all_filters: bool,
) -> Result<ErrorReport, Diagnostic> {
    let mut plan = plan(&renderer.scene, renderer.world(), own);
    plan.truncate(if all_filters { plan.len() } else { 1 });
    let mut sweep = Sweep { renderer, own, bench, done: 0.0, all: 0.0 };
    sweep.all = plan.len() as f64 * sweep.reference_work() + plan.iter().flatten().map(work).sum::<f64>();
    let planned = plan.iter().map(Vec::len).sum();
    let (mut groups, mut numerical) = (Vec::new(), None);
    let mut times = [Duration::ZERO; 3];
    for settings in plan {
        let filter = settings[0].request.filter;
        let start = Instant::now();
        let reference = sweep.reference(filter)?;
        times[0] += start.elapsed();
        let Some(reference) = reference else { break };
        let start = Instant::now();
        let measurements = sweep.measurements(&settings, &reference)?;
        times[1] += start.elapsed();
        let is_complete = measurements.len() == settings.len();
        let Reference { picture, noise, .. } = reference;
        groups.push(MeasuredFilter { filter, reference: picture, noise, measurements });
        if !is_complete {
            break;
        }
        if numerical.is_none() {
            let start = Instant::now();
            numerical = sweep.numerical()?;
            times[2] += start.elapsed();
        }
    }
    let stages = ["rendering references", "measuring settings", "numerical error"];
    let stages = stages.into_iter().zip(times).collect();
    Ok(ErrorReport { size: own.request.size, groups, numerical, planned, stages })
}

/// The measurements in progress.
struct Sweep<'a> {
    renderer: &'a Renderer,
    own: &'a Setting,
    bench: Bench<'a>,
    /// The completed and the total work, in samples per pixel.
    done: f64,
    all: f64,
}

impl Sweep<'_> {
    /// Returns the work for two halves on many threads.
    fn reference_work(&self) -> f64 {
        2.0 * f64::from(reference::SAMPLES) / self.bench.many.current_num_threads() as f64
    }

    /// Renders the reference for a filter. `None` if the watch ended the sweep.
    fn reference(&mut self, filter: Filter) -> Result<Option<Reference>, Diagnostic> {
        let own = Request { adaptive: None, filter, ..self.own.request.clone() };
        let mut halves = Vec::new();
        for sampler in reference::samplers(own.sampler.rng()) {
            let request = Request { sampler, ..own.clone() };
            let prepared = self.prepared(self.renderer, &request)?;
            let work = self.reference_work() / 2.0;
            let rendered = self.render(self.bench.many, &prepared, &request, work, "the reference")?;
            let Some((half, _)) = rendered else { return Ok(None) };
            halves.push(half);
            self.done += work;
        }
        Ok(halves.try_into().ok().map(Reference::new))
    }

    /// Measures the effect of rounding on the request's samples.
    fn numerical(&self) -> Result<Option<Numerical>, Diagnostic> {
        let request = &self.own.request;
        let prepared = self.prepared(self.renderer, request)?;
        Ok(self.bench.many.install(|| numerical::measure(self.renderer, &prepared, request))?)
    }

    fn prepared<'r>(&self, renderer: &'r Renderer, request: &Request) -> Result<Prepared<'r>, Diagnostic> {
        Ok(self.bench.many.install(|| renderer.prepare(request))?)
    }

    /// Measures the settings. Returns those that were finished.
    fn measurements(
        &mut self,
        settings: &[Setting],
        reference: &Reference,
    ) -> Result<Vec<Measurement>, Diagnostic> {
        let mut measurements: Vec<Measurement> = Vec::new();
        for setting in settings {
            let Some(mut measured) = self.measure(setting, reference)? else { break };
            if setting.axis == Axis::Structure {
                let structure = self.own.request.structure;
                let same = Request { structure, ..setting.request.clone() };
                let is_asked_for =
                    |other: &&Measurement| other.setting.request == same && other.setting.octaves.is_none();
                let asked_for = measurements.iter().find(is_asked_for);
                measured.changed =
                    asked_for.map(|other| pixels_that_differ(&other.picture, &measured.picture));
            }
            measurements.push(measured);
            self.done += work(setting);
        }
        Ok(measurements)
    }

    /// Measures a setting. `None` if the watch ended the sweep.
    fn measure(
        &mut self,
        setting: &Setting,
        reference: &Reference,
    ) -> Result<Option<Measurement>, Diagnostic> {
        let of_other_octaves = setting.octaves.map(|most| with_octaves(&self.renderer.scene, most));
        // The changed scene has the same objects, so a world can be built for it.
        let other = of_other_octaves.and_then(|scene| self.renderer.with_scene(scene).ok());
        let renderer = other.as_ref().unwrap_or(self.renderer);
        let prepared = self.prepared(renderer, &setting.request)?;
        let Some((picture, rays, times)) = self.repeat(setting, &prepared)? else { return Ok(None) };
        let bytes = picture.to_picture();
        let compared = self.bench.many.install(|| Comparison::new(&bytes, &reference.picture));
        let (flip, off) = compared.map_or((0.0, 0.0), |found| {
            let off = found.pixels_differing_by_more_than(1) as f64 / found.pixels() as f64;
            (found.mean_flip.unwrap_or_default(), off)
        });
        let error = reference.error(&picture);
        let setting = setting.clone();
        Ok(Some(Measurement { setting, times, rays, error, flip, off, changed: None, picture: bytes }))
    }

    /// Renders repeatedly on one thread. Returns the picture, the number of rays cast, and the time of each run. `None`
    /// if the watch ended the sweep.
    fn repeat(
        &self,
        setting: &Setting,
        prepared: &Prepared,
    ) -> Result<Option<(FloatPicture, u64, Vec<Duration>)>, Diagnostic> {
        let (label, mut times) = (setting.label(), Vec::new());
        loop {
            let start = (self.bench.clock)();
            let rendered = self.render(self.bench.one, prepared, &setting.request, 0.0, &label)?;
            times.push((self.bench.clock)().saturating_sub(start));
            let Some((picture, rays)) = rendered else { return Ok(None) };
            let is_enough = times.len() >= FEWEST && times.iter().sum::<Duration>() >= ENOUGH;
            if is_enough || times.len() >= MOST {
                times.sort();
                return Ok(Some((picture, rays, times)));
            }
        }
    }

    /// Renders, and reports progress from the completed work up to `work` more. Returns the picture and the number of
    /// rays cast. `None` if the watch ended the sweep.
    fn render(
        &self,
        threads: &ThreadPool,
        prepared: &Prepared,
        request: &Request,
        work: f64,
        doing: &str,
    ) -> Result<Option<(FloatPicture, u64)>, Diagnostic> {
        let mut picture = FloatPicture::with_room(request.window_size())?;
        let mut take_row = |_: usize, row: &[Color]| {
            picture.colors.extend_from_slice(row);
            ControlFlow::Continue(())
        };
        let (done, all, bench_watch) = (self.done, self.all, self.bench.watch);
        let watch = |rows: Progress| {
            let part = rows.done as f64 / rows.rows.max(1) as f64;
            bench_watch((done + part * work) / all, doing)
        };
        match threads.install(|| prepared.render_rows(request, &watch, &mut take_row)) {
            Ok(rendered) => Ok(Some((picture, rendered.counts.rays()))),
            Err(Stopped::Cancelled { .. } | Stopped::Output) => Ok(None),
            Err(stopped) => Err(stopped.into()),
        }
    }
}

/// Returns the approximate work to measure a setting, in samples per pixel.
fn work(setting: &Setting) -> f64 {
    let samples = setting.count().map_or(ADAPTIVE_SAMPLES, f64::from);
    RENDERINGS * samples
}

fn pixels_that_differ(a: &Picture, b: &Picture) -> u64 {
    let differ = |(a, b): (&[u8], &[u8])| u64::from(a != b);
    a.pixels().chunks(3).zip(b.pixels().chunks(3)).map(differ).sum()
}
