//! Renders a scene, with everything that is written and printed of it.

use super::compare::{self, Pair};
use super::complete_files::{self, CompleteFiles};
use super::fingerprint;
use super::log::Log;
use super::products::{FinishedLayers, Products};
use super::progress::{ProgressLine, rows_text};
use super::report::Report;
use super::signals::Signals;
use super::stopped::{self, upper};
use super::{End, Outcome, refused, threads, warnings};
use raytracer::base::memory::Bytes;
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::cli::{Options, Output};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{
    CompleteFile, Exceptional, Format, OutputFile, ReadFile, Written, check_distinct, part_beside,
};
use raytracer::picture::Color;
use raytracer::render::renderer::{Meshes, Prepared, Renderer};
use raytracer::render::{Layer, Request, Stopped, Tracing};
use raytracer::scene::edition::Edition;
use raytracer::scene::load::{LoadedScene, load_with};
use raytracer::stats::{self, Counts, Repeats, Timings};
use raytracer::tools::explain::{CostReport, ExplainError, Explainer, PixelTree, Stop};
use raytracer::tools::standard_error::{has_standard_error, standard_error};
use raytracer::tools::warnings::{lights_without_effect, nothing_visible};
use std::ffi::OsString;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// How long the rays behind a pixel are followed. It is as much as millions of rays take.
const LONGEST_EXPLANATION: Duration = Duration::from_secs(60);

/// How many of the fullest cells are named.
const FULLEST: usize = 5;

/// Renders the scene in this file as the options ask for, which come from the command line `argv`.
pub fn run(
    options: &Options,
    input: &Path,
    argv: &[OsString],
    signals: &Signals,
    log: &Log,
) -> Result<Outcome, End> {
    threads::start(options.threads, options.size[1])?;

    // Load the scene.
    let mut clock = Clock(Instant::now());
    let mut loaded = load_with(input, &options.hints())?;

    // Settle the options.
    let options = &options.in_edition(loaded.choice.edition);
    check_distinct(written(options), read(input, options, &loaded)).map_err(refused)?;
    if let Some(note) = loaded.choice.note() {
        log.tell(note);
    }
    let reading = clock.lap();
    let pair = Pair::open(options, log)?;

    // Prepare.
    let mut doubts = warnings::about_scene(&mut loaded, options);
    let renderer = Renderer::new(loaded, meshes(options))?;
    if !options.visualize_grid {
        doubts.extend(lights_without_effect(&renderer.scene, renderer.world(), &options.effects));
    }
    let warn = |doubts: Vec<Diagnostic>| warnings::say(doubts, options, &renderer.source, log);
    warn(doubts)?;
    let compared = options.comparison.as_ref().filter(|wanted| wanted.needs_scene());
    let compared = compared.and_then(|_| options.compared_layer());
    // A map of costs is drawn again when it is complete.
    let kept = compared.filter(|layer| !matches!(layer, Layer::Cost(_)));
    let mut request = options.request();
    request.layers.extend(kept);
    let prepared = prepare(options, &renderer, &request, options.tracing())?;
    let building = clock.lap();

    // Open the outputs.
    let open = |output: &Output| Ok((complete_files::prepare(output)?, output.format));
    let pictures = options.outputs.iter().map(open).collect::<Result<_, Diagnostic>>()?;
    let difference = compare::open_difference(options)?;
    let document = options.json_file().map(OutputFile::prepare).transpose()?;
    let mut products = begin(pictures, kept, &prepared, &request)?;

    // Render rows.
    let run = Run { options, argv, prepared: &prepared, request: &request, signals, log };
    let counts = match run.render_rows(&mut products)? {
        Ok(counts) => counts,
        Err(rows) => return Err(run.stop(products, rows)),
    };
    let rendering = clock.lap() - products.encoding;

    // Finish.
    if products.shows_nothing() && !options.visualize_grid {
        warn(run.nothing_visible().into_iter().collect())?;
    }
    warn(not_shown(&products.exceptional()))?;
    let encoding = products.encoding;
    let FinishedLayers { files: finished, kept, costs } = products.finish(options.picture_size())?;
    let files = CompleteFiles::default();
    let (streams, regular): (Vec<_>, Vec<_>) = finished.into_iter().partition(CompleteFile::is_stream);
    regular.into_iter().try_for_each(|file| files.add(file))?;
    files.before_waiting(signals)?;
    streams.into_iter().try_for_each(|stream| files.add(stream))?;

    // Report.
    let timings = Timings { reading, building, rendering, writing: encoding + clock.lap() };
    let report = stats::Report { standard_error: run.standard_error()?, ..run.report(counts, timings) };
    let repeats = options.repeat.map(|count| run.repeated(count, rendering)).transpose()?;
    let picture = match (compared, &costs) {
        (Some(Layer::Cost(_)), Some(map)) => Some(map.draw()?),
        _ => kept,
    };
    let costs = costs.map(|map| CostReport { map, cells: prepared.fullness(FULLEST) });
    let pixel =
        options.pixel.map(|pixel| explanation(options, &renderer, prepared, pixel)).transpose()?.flatten();
    let compare = |pair: Pair| pair.compare(options, (Some(&renderer), picture.as_ref()), difference, &files);
    let compared = pair.map(compare).transpose()?;
    let rendered = Some(Rendered { renderer: &renderer, report, repeats, costs, pixel });
    Report { rendered, compared }.finish(options, document, files, signals, log)
}

/// What a rendering found out.
pub struct Rendered<'r> {
    pub renderer: &'r Renderer,
    pub report: stats::Report,
    /// The times of all renderings, if there are several.
    pub repeats: Option<Repeats>,
    /// What the pixels of a cost map have cost, if one is drawn.
    pub costs: Option<CostReport>,
    /// What is behind the pixel in question, if there is one.
    pub pixel: Option<PixelTree>,
}

impl Rendered<'_> {
    /// What there is to print.
    pub fn text(&self, options: &Options) -> String {
        let blocks: [Option<&dyn Display>; 4] = [
            options.stats.then_some(&self.report),
            self.repeats.as_ref().map(|repeats| repeats as _),
            self.costs.as_ref().map(|costs| costs as _),
            self.pixel.as_ref().map(|pixel| pixel as _),
        ];
        blocks.into_iter().flatten().map(ToString::to_string).collect()
    }
}

/// The files that a rendering writes. Of a picture there may be a part if the run is stopped.
fn written(options: &Options) -> impl Iterator<Item = Written> {
    let picture = |output: &Output| Written::Named(output.file.clone());
    let part = |output: &Output| {
        let has_parts =
            !output.is_standard_output() && !matches!(output.layer, Layer::Filter { .. } | Layer::Cost(_));
        let part = part_beside(&output.file, output.format).filter(|_| has_parts)?;
        Some(Written::PartOf { picture: output.file.clone(), part })
    };
    let pictures = options.outputs.iter().map(picture);
    pictures.chain(compare::written(options)).chain(options.outputs.iter().filter_map(part))
}

/// The files that a rendering of this scene reads.
fn read(input: &Path, options: &Options, loaded: &LoadedScene) -> impl Iterator<Item = ReadFile> {
    std::iter::once(("scene", input.to_owned())).chain(compare::read(options)).chain(loaded.files())
}

/// Starts the pictures of a request. The one that is `kept` has no file.
fn begin(
    files: Vec<(OutputFile, Format)>,
    kept: Option<Layer>,
    prepared: &Prepared,
    request: &Request,
) -> Result<Products, Diagnostic> {
    let part = |layer| fingerprint::part(prepared, request, request.window?, layer);
    let mut products = Products::begin(files, request, &part)?;
    if let Some(layer) = kept {
        products.keep(request.layer_size(&layer))?;
    }
    let renderer = prepared.renderer();
    let is_empty = renderer.world().finite_count() == 0 && renderer.world().planes.is_empty();
    products.watch_for_blank(request, &renderer.scene, is_empty);
    Ok(products)
}

/// A prepared rendering.
struct Run<'r> {
    options: &'r Options,
    argv: &'r [OsString],
    prepared: &'r Prepared<'r>,
    request: &'r Request,
    signals: &'r Signals,
    log: &'r Log,
}

impl Run<'_> {
    /// Returns what was counted, or the number of complete rows if a signal came.
    fn render_rows(&self, products: &mut Products) -> Result<Result<Counts, usize>, Diagnostic> {
        let mut failure = None;
        let mut take_row = |layer: usize, row: &[Color]| match products.take_row(layer, row) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                failure = Some(error);
                ControlFlow::Break(())
            }
        };
        let signals = self.signals;
        signals.note_first();
        let progress = ProgressLine::new(self.options.progress);
        let watch = |rows| {
            progress.show(|passed| rows_text("rendering", rows, passed));
            signals.goes_on()
        };
        let rendered = self.prepared.render_rows(self.request, &watch, &mut take_row);
        progress.end();
        match (failure, rendered) {
            (Some(error), _) => Err(error),
            (None, Err(Stopped::Cancelled { rows })) => Ok(Err(rows)),
            (None, rendered) => Ok(Ok(rendered?)),
        }
    }

    /// Keeps the complete rows of a run that a signal stopped, and tells how to make the rest.
    fn stop(&self, products: Products, rows: usize) -> End {
        // No command line renders a part of these.
        let has_parts = !self.options.jitter && !self.options.reduced;
        let window = upper(self.request, rows);
        let part =
            |layer| fingerprint::part(self.prepared, self.request, window, layer).filter(|_| has_parts);
        match products.keep_parts(self.request, &part) {
            Ok(kept) => {
                let lines = stopped::lines(self.argv, self.options, rows, &kept);
                lines.iter().for_each(|line| self.log.say(line));
                self.signals
                    .received()
                    .unwrap_or_else(|| Diagnostic::error("the rendering was stopped").into())
            }
            Err(error) => error.into(),
        }
    }

    fn nothing_visible(&self) -> Option<Diagnostic> {
        let signals = self.signals;
        nothing_visible(self.prepared, self.request, &|_| signals.goes_on())
    }

    fn report(&self, counts: Counts, timings: Timings) -> stats::Report {
        let edition = self.options.edition.filter(|&edition| edition != Edition::default());
        stats::Report {
            size: self.request.window_size(),
            bounds: self.prepared.renderer().bounds(),
            grid: self.prepared.cells(),
            counts,
            timings,
            threads: rayon::current_num_threads(),
            standard_error: None,
            edition: edition.map(Edition::name),
        }
    }

    fn standard_error(&self) -> Result<Option<f64>, Diagnostic> {
        if !self.options.stats || !has_standard_error(self.request) {
            return Ok(None);
        }
        Ok(standard_error(self.prepared, self.request, &|_| ControlFlow::Continue(()))?)
    }

    /// Returns the times of `count` renderings, of which the first took this time. The others leave nothing behind.
    fn repeated(&self, count: u32, first: Duration) -> Result<Repeats, Diagnostic> {
        let progress = ProgressLine::new(self.options.progress);
        let mut times = vec![first];
        for number in 2..=count {
            let doing = format!("rendering {number} of {count}");
            let watch = |rows| {
                progress.show(|passed| rows_text(&doing, rows, passed));
                ControlFlow::Continue(())
            };
            let start = Instant::now();
            self.prepared.render_rows(self.request, &watch, &mut |_, _| ControlFlow::Continue(()))?;
            times.push(start.elapsed());
        }
        progress.end();
        Repeats::of(times).ok_or_else(|| Diagnostic::error("nothing was rendered"))
    }
}

/// Warns about pixels that the files do not show as they are.
fn not_shown(exceptional: &Exceptional) -> Vec<Diagnostic> {
    let Exceptional { black, nan, out_of_range } = *exceptional;
    let black = match black {
        0 => None,
        1 => Some("the colour of 1 pixel is not a number; it is black".into()),
        _ => Some(format!("the colours of {black} pixels are not numbers; they are black")),
    };
    let nan = (nan > 0).then(|| format!("pixels that are not numbers, also in the file: {nan}"));
    let beyond = (out_of_range > 0)
        .then(|| format!("pixels beyond single precision, infinite or 0 in the file: {out_of_range}"));
    [black, nan, beyond].into_iter().flatten().map(Diagnostic::warning).collect()
}

/// The meshes are kept for the view of the grid's cells, for naming the objects behind a pixel, and for finding the
/// cause of a difference, which renders other scenes with the same meshes.
fn meshes(options: &Options) -> Meshes {
    let has_outside = options.comparison.as_ref().is_some_and(|wanted| wanted.picture.is_some());
    let keeps = options.visualize_grid || options.pixel.is_some() || has_outside;
    if keeps { Meshes::Kept } else { Meshes::Moved }
}

/// What is behind a pixel. It is traced and counted as by the course's program, like all that is counted.
fn explanation(
    options: &Options,
    renderer: &Renderer,
    prepared: Prepared,
    pixel: [usize; 2],
) -> Result<Option<PixelTree>, Diagnostic> {
    let request = options.request();
    let prepared = match prepared.tracing() {
        Tracing::Counted => prepared,
        Tracing::Fast => prepare(options, renderer, &request, Tracing::Counted)?,
    };
    let explainer = Explainer::new(&prepared)?;
    let stop = Stop::at(Instant::now() + LONGEST_EXPLANATION);
    match explainer.pixel(&request, pixel, &stop) {
        Err(ExplainError::Outside) => Ok(None),
        explained => Ok(Some(explained?)),
    }
}

fn prepare<'r>(
    options: &Options,
    renderer: &'r Renderer,
    request: &Request,
    tracing: Tracing,
) -> Result<Prepared<'r>, Diagnostic> {
    let prepared = match options.structure {
        Structure::Grid(grid) if options.visualize_grid => {
            renderer.prepare_cells(grid, request.camera_rays(), tracing)
        }
        structure => renderer.prepare_for(structure, request, tracing),
    };
    prepared.map_err(|error| match options.structure {
        Structure::Grid(Resolution::Cells(cells)) => {
            // Each cell has an entry, and a few lists are of the same length while the grid is built.
            let bytes = cells.iter().fold(4u64, |bytes, &n| bytes.saturating_mul(n as u64));
            Diagnostic::error(format!("{error}; the entries of its cells alone are {}", Bytes(bytes)))
        }
        _ => error.into(),
    })
}

/// Measures one stage after the other.
struct Clock(Instant);

impl Clock {
    /// Returns the time since the last lap.
    fn lap(&mut self) -> Duration {
        let now = Instant::now();
        now - std::mem::replace(&mut self.0, now)
    }
}
