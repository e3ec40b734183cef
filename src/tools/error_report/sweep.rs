//! Renders and measures one setting after the other.

use super::numerical::{self, Numerical};
use super::plan::with_octaves;
use super::reference::{self, Reference};
use super::setting::{Axis, Setting};
use super::{ErrorReport, MeasuredFilter, Measurement};
use crate::base::patience::Patience;
use crate::base::processor_time::processor_time;
use crate::caster::NotBuilt;
use crate::diagnostic::Diagnostic;
use crate::picture::FloatPicture;
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Progress, Request, Stopped};
use crate::sampling::filter::Filter;
use crate::tools::compare::{Comparison, colors};
use rayon::ThreadPool;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// The threads and the watch used for measurements.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The threads that render references.
    pub many: &'a ThreadPool,
    /// The single thread whose time is measured.
    pub one: &'a ThreadPool,
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

/// Measures the settings of a [`plan`](super::plan()), whose lists have a filter each and are not empty. `own` is the
/// setting of the command line, and `origin` names the program, the machine and the date. The renderer must have kept
/// the scene's meshes and must have no threads of its own. If the watch ends the sweep, the report has the finished
/// settings.
pub fn measure(
    renderer: &Renderer,
    own: &Setting,
    plan: &[Vec<Setting>],
    bench: Bench,
    origin: String,
) -> Result<ErrorReport, Diagnostic> {
    let start = Instant::now();
    let report = ErrorReport {
        size: own.request.size,
        groups: vec![],
        numerical: None,
        planned: plan.iter().map(Vec::len).sum(),
        origin,
        time: Duration::ZERO,
    };
    let half = f64::from(reference::SAMPLES) / bench.many.current_num_threads() as f64;
    let all = plan.len() as f64 * 2.0 * half + plan.iter().flatten().map(work).sum::<f64>();
    let mut sweep = Sweep { renderer, own, bench, report, done: 0.0, all, half };
    match plan.iter().try_for_each(|settings| sweep.measure_filter(settings)) {
        Err(Some(error)) => Err(error),
        Ok(()) | Err(None) => Ok(ErrorReport { time: start.elapsed(), ..sweep.report }),
    }
}

/// The patience of a bench's watch, at this fraction of the work.
struct Watched<'a>(Bench<'a>, f64);

impl Patience for Watched<'_> {
    fn is_over(&self) -> bool {
        (self.0.watch)(self.1, "comparing").is_break()
    }
}

/// The reason why a sweep ended: an error, or `None` for the watch.
type Ended = Option<Diagnostic>;

/// The measurements in progress.
struct Sweep<'a> {
    renderer: &'a Renderer,
    own: &'a Setting,
    bench: Bench<'a>,
    report: ErrorReport,
    /// The completed work, the total, and that for half a reference on many threads, in samples per pixel.
    done: f64,
    all: f64,
    half: f64,
}

impl Sweep<'_> {
    /// Measures settings with the same filter.
    fn measure_filter(&mut self, settings: &[Setting]) -> Result<(), Ended> {
        let filter = settings[0].request.filter;
        let reference = self.reference(filter)?;
        let (picture, noise) = (reference.picture.clone(), reference.noise);
        self.report.groups.push(MeasuredFilter { filter, reference: picture, noise, measurements: vec![] });
        settings.iter().try_for_each(|setting| self.measure(setting, &reference))?;
        if self.report.numerical.is_none() {
            self.report.numerical = self.numerical()?;
        }
        Ok(())
    }

    fn reference(&mut self, filter: Filter) -> Result<Reference, Ended> {
        let own = Request { adaptive: None, filter, ..self.own.request.clone() };
        let [first, second] = reference::samplers(own.sampler.rng());
        let mut half = |sampler| {
            let request = Request { sampler, ..own.clone() };
            let prepared = self.prepared(self.renderer, &request)?;
            let (half, _) = self.render(self.bench.many, &prepared, &request, self.half, "the reference")?;
            self.done += self.half;
            Ok::<_, Ended>(half)
        };
        Ok(Reference::new([half(first)?, half(second)?]))
    }

    /// Measures the effect of rounding on the request's samples.
    fn numerical(&self) -> Result<Option<Numerical>, Ended> {
        let (request, patience) = (&self.own.request, self.patience());
        let prepared = self.prepared(self.renderer, request)?;
        let measure = || numerical::measure(self.renderer, &prepared, request, &patience);
        let measured = self.bench.many.install(measure);
        self.unless_over(measured)
    }

    fn prepared<'r>(&self, renderer: &'r Renderer, request: &Request) -> Result<Prepared<'r>, Ended> {
        let patience = self.patience();
        let prepare = || {
            let prepared = renderer.prepare_within(request, &patience)?;
            // Rendering is timed without building.
            prepared.caster(&patience)?;
            Ok::<_, NotBuilt>(prepared)
        };
        let prepared = self.bench.many.install(prepare);
        self.unless_over(prepared)
    }

    fn patience(&self) -> Watched<'_> {
        Watched(self.bench, self.done / self.all)
    }

    /// Returns the result of work, unless the watch has ended it.
    fn unless_over<T, E: Into<Diagnostic>>(&self, result: Result<T, E>) -> Result<T, Ended> {
        self.patience().check().map_err(|_| None)?;
        result.map_err(|error| Some(error.into()))
    }

    /// Measures a setting, and adds it to the last filter.
    fn measure(&mut self, setting: &Setting, reference: &Reference) -> Result<(), Ended> {
        // The changed scene has the same objects, so a world can be built for it.
        let patience = self.patience();
        let limited = match setting.axis {
            Axis::Octaves(most) => {
                let scene = with_octaves(&self.renderer.scene, most);
                Some(self.unless_over(self.renderer.with_scene(scene, &patience))?)
            }
            Axis::Samples | Axis::Secondary | Axis::Structure => None,
        };
        let renderer = limited.as_ref().unwrap_or(self.renderer);
        let prepared = self.prepared(renderer, &setting.request)?;
        let Repeated { colors: rendered, rays, times } = self.repeat(setting, &prepared)?;
        let picture = rendered.to_picture();
        let compare = || Comparison::within(&picture, &reference.picture, &patience);
        let compared = self.unless_over(self.bench.many.install(compare))?;
        let flip = compared.mean_flip.unwrap_or_default();
        let off = compared.pixels_differing_by_more_than(1) as f64 / compared.pixels() as f64;
        let error = reference.error(&rendered);
        let Some(MeasuredFilter { measurements, .. }) = self.report.groups.last_mut() else { return Ok(()) };
        let same = Request { structure: self.own.request.structure, ..setting.request.clone() };
        let mut others = measurements.iter().filter(|_| setting.axis == Axis::Structure);
        let asked_for = others.find(|other| other.setting.request == same);
        let pairs = asked_for.map(|other| colors(&other.picture).iter().zip(colors(&picture)));
        let changed = pairs.map(|pairs| pairs.filter(|(a, b)| a != b).count() as u64);
        let setting = setting.clone();
        self.done += work(&setting);
        measurements.push(Measurement { setting, times, rays, error, flip, off, changed, picture });
        Ok(())
    }

    /// Renders repeatedly on one thread.
    fn repeat(&self, setting: &Setting, prepared: &Prepared) -> Result<Repeated, Ended> {
        let (label, mut times) = (setting.label(), Vec::new());
        loop {
            let start = processor_time();
            let (colors, rays) = self.render(self.bench.one, prepared, &setting.request, 0.0, &label)?;
            times.push(processor_time().saturating_sub(start));
            let is_enough = times.len() >= FEWEST && times.iter().sum::<Duration>() >= ENOUGH;
            if is_enough || times.len() >= MOST {
                times.sort();
                return Ok(Repeated { colors, rays, times });
            }
        }
    }

    /// Renders, and reports progress from the completed work up to `work` more. Returns the picture and the number of
    /// rays cast.
    fn render(
        &self,
        threads: &ThreadPool,
        prepared: &Prepared,
        request: &Request,
        work: f64,
        doing: &str,
    ) -> Result<(FloatPicture, u64), Ended> {
        let (done, all, bench_watch) = (self.done, self.all, self.bench.watch);
        let watch = |rows: Progress| {
            let part = rows.done as f64 / rows.rows.max(1) as f64;
            bench_watch((done + part * work) / all, doing)
        };
        match threads.install(|| prepared.render_watched(request, &watch)) {
            Ok((mut pictures, counts)) => Ok((pictures.remove(0), counts.rays())),
            Err(Stopped::Cancelled { .. }) => Err(None),
            Err(stopped) => Err(Some(stopped.into())),
        }
    }
}

/// A picture that was rendered several times.
struct Repeated {
    colors: FloatPicture,
    /// The number of rays cast in a run.
    rays: u64,
    /// The time of each run, in ascending order.
    times: Vec<Duration>,
}

/// Returns the approximate work to measure a setting, in samples per pixel.
fn work(setting: &Setting) -> f64 {
    let samples = setting.count().map_or(ADAPTIVE_SAMPLES, f64::from);
    RENDERINGS * samples
}
