//! One run of the program: a scene is rendered, written and compared as the options ask for.

use crate::failed;
use crate::products::Products;
use rayon::ThreadPool;
use raytracer::cli::{self, Options};
use raytracer::compare::{CompareError, Comparison, DifferencePicture};
use raytracer::escape::quoted;
use raytracer::explain::CostReport;
use raytracer::image_io::{OutputFile, read_picture};
use raytracer::mode::{Course, Fast, Mode};
use raytracer::picture::Picture;
use raytracer::render::Layer;
use raytracer::renderer::{Meshes, Prepared, Renderer};
use raytracer::scene::Color;
use raytracer::scene_io;
use raytracer::stats::{Counts, Probe, Quiet, Report, Timings};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a run has to say.
pub struct Outcome {
    /// What goes to standard output.
    pub text: String,
    /// Whether the pictures that were compared differ by no more than the tolerance.
    pub passes: bool,
}

/// Does what the options ask for. Notes and warnings go to `tell`; an error is the message that ends the program.
pub fn run(options: &Options, tell: &dyn Fn(&str)) -> Result<Outcome, String> {
    // This thread is among them: for one thread none is started, and calls from here neither wake another nor wait.
    let threads =
        rayon::ThreadPoolBuilder::new().num_threads(options.threads.unwrap_or(0)).use_current_thread();
    let threads = Arc::new(threads.build().map_err(failed)?);
    if options.preview {
        tell("note: this build has no preview; the picture is rendered directly");
    }
    // A picture that cannot be read, or a file that cannot be written, is no reason to wait for the rendering.
    let wanted = options.comparison.as_ref();
    let read = |path: Option<&Path>| path.map(read_picture).transpose().map_err(failed);
    let picture = read(wanted.and_then(|wanted| wanted.picture.as_deref()))?;
    let reference = read(wanted.and_then(|wanted| wanted.reference.as_deref()))?;
    let difference = wanted.and_then(|wanted| wanted.difference.as_deref());
    let difference = difference.map(OutputFile::prepare).transpose().map_err(failed)?;

    let size = |picture: &Option<Picture>| {
        picture.as_ref().map_or(options.size.map(|n| n as u32), |picture| [picture.width(), picture.height()])
    };
    let (a, b) = (size(&picture), size(&reference));
    if let Some(wanted) = wanted.filter(|_| a != b) {
        return Err(cannot_compare(wanted, CompareError::Sizes { a, b }));
    }

    let mut outcome = Outcome { text: String::new(), passes: true };
    let mut rendered = None;
    if let Some(input) = &options.input {
        let keeps = wanted.is_some_and(cli::Comparison::needs_scene);
        let render = if options.counts() { render::<Course, Counts> } else { render::<Fast, Quiet> };
        (outcome.text, rendered) = render(options, input, &threads, keeps, tell)?;
    }
    let Some(wanted) = wanted else { return Ok(outcome) };
    let (Some(a), Some(b)) =
        (picture.as_ref().or(rendered.as_ref()), reference.as_ref().or(rendered.as_ref()))
    else {
        return Ok(outcome);
    };
    let compared = threads.install(|| Comparison::new(a, b));
    let comparison = compared.map_err(|error| cannot_compare(wanted, error))?;
    outcome.text += &comparison.to_string();
    outcome.passes = wanted.tolerance.is_none_or(|tolerance| tolerance.accepts(&comparison));
    if let Some(file) = difference {
        let shown = DifferencePicture::new(a, b).map_err(failed)?;
        file.write(&shown.picture).map_err(failed)?;
    }
    Ok(outcome)
}

fn cannot_compare(wanted: &cli::Comparison, error: CompareError) -> String {
    let name = |path: &Option<_>| path.as_ref().map_or("the rendered picture".into(), quoted);
    failed(format!("cannot compare {} with {}: {error}", name(&wanted.picture), name(&wanted.reference)))
}

/// Reads, prepares, renders and writes. Returns what there is to print, and the colour picture if `keeps` is true.
fn render<M: Mode, P: Probe>(
    options: &Options,
    input: &Path,
    threads: &Arc<ThreadPool>,
    keeps: bool,
    tell: &dyn Fn(&str),
) -> Result<(String, Option<Picture>), String> {
    let files = options.outputs.iter().map(|output| OutputFile::prepare(&output.file));
    let files: Vec<OutputFile> = files.collect::<Result<_, _>>().map_err(failed)?;

    let mut clock = Clock(Instant::now());
    let loaded = scene_io::load(input).map_err(|error| error.to_string())?;
    if loaded.scene.lights.is_empty() {
        tell("WARNING:  No lights specified");
    }
    let reading = clock.lap();
    let meshes = if options.visualize_grid { Meshes::Kept } else { Meshes::Moved };
    let renderer = Renderer::new(loaded, meshes).map_err(|error| error.to_string())?;
    let renderer = renderer.on_threads(threads.clone());
    let prepared = prepare::<M>(options, &renderer)?;
    let building = clock.lap();

    let mut request = options.request();
    let mut products = Products::begin(files, &request)?;
    if keeps {
        request.layers.push(Layer::Color);
        products.keep();
    }
    let mut take_row = |layer: usize, row: &[Color]| products.take_row(layer, row);
    let goes_on = |_| ControlFlow::Continue(());
    let probe: P = prepared.render_rows(&request, &goes_on, &mut take_row).map_err(failed)?;
    let encoding = products.encoding;
    let rendering = clock.lap() - encoding;

    let finished = products.finish(options.size)?;
    if finished.nans > 0 {
        tell(&format!("warning: the colours of {} pixels are not numbers; they are black", finished.nans));
    }
    let report = Report {
        size: options.size,
        bounds: renderer.bounds(),
        grid: prepared.cells(),
        counts: probe.counts(),
        timings: Timings { reading, building, rendering, writing: encoding + clock.lap() },
        threads: threads.current_num_threads(),
    };
    let mut text = if options.stats { report.to_string() } else { String::new() };
    if let Some(costs) = finished.costs {
        text += &CostReport { map: &costs, cells: prepared.fullness(FULLEST) }.to_string();
    }
    Ok((text, finished.kept))
}

/// How many of the fullest cells are named.
const FULLEST: usize = 5;

fn prepare<'r, M: Mode>(options: &Options, renderer: &'r Renderer) -> Result<Prepared<'r, M>, String> {
    let rays = options.size[0] * options.size[1] * options.sampler.count() as usize;
    let prepared = match options.grid {
        Some(grid) if options.visualize_grid => renderer.prepare_cells(grid, rays),
        grid => renderer.prepare(grid, rays),
    };
    prepared.map_err(failed)
}

/// Measures one stage after the other.
struct Clock(Instant);

impl Clock {
    /// The time since the last lap.
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.0, now)
    }
}
