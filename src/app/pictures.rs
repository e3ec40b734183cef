//! The rendering of a scene, with everything that is written and printed of it.

use crate::app::complete_files::CompleteFiles;
use crate::app::products::Products;
use crate::app::progress::{ProgressLine, rows_text};
use crate::app::signals::Signals;
use crate::app::stopping::{self, upper};
use crate::app::threads::Crew;
use crate::app::warned;
use crate::app::{self, End, failed};
use raytracer::caster::choose::{Resolution, Structure};
use raytracer::cli::{Options, Output};
use raytracer::diagnostic::Diagnostic;
use raytracer::distinct_files::WrittenFiles;
use raytracer::escape::quoted;
use raytracer::fingerprint;
use raytracer::image_io::{
    CompleteFile, Exceptional, ImageError, OutputFile, Remarks, read_remarked_picture,
};
use raytracer::memory::Bytes;
use raytracer::picture::Picture;
use raytracer::render::{Layer, Request, Stopped, Tracing};
use raytracer::renderer::{Meshes, Prepared, Renderer};
use raytracer::scene::Color;
use raytracer::scene::edition::Edition;
use raytracer::scene_io;
use raytracer::stats::{Repeats, Report, Timings};
use raytracer::tools::explain::{CostReport, ExplainError, Explainer, PixelTree, Stop};
use raytracer::tools::standard_error::{has_standard_error, standard_error};
use raytracer::tools::warnings::{lights_without_effect, nothing_visible};
use std::ffi::OsString;
use std::fmt::Display;
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// The size of a mesh's file, in bytes, from which on its parsing is work for several threads.
const LARGE_MESH: usize = 1 << 18;

/// How long the rays behind a pixel are followed. It is as much as millions of rays take.
const LONGEST_EXPLANATION: Duration = Duration::from_secs(60);

/// The number of camera rays from which on a picture is work for several threads.
const MANY_RAYS: usize = 1 << 17;

/// The number of primitives from which on their grid is work for several threads.
const MANY_PRIMITIVES: usize = 1 << 13;

/// How long one thread renders what looks like little work until others help: a few times what it takes to start them.
const PATIENCE: Duration = Duration::from_millis(3);

/// What a rendering leaves.
pub struct Rendered {
    /// The options as the scene's edition settles them.
    pub options: Options,
    pub renderer: Renderer,
    pub report: Report,
    /// The times of all renderings, if there are several.
    pub repeats: Option<Repeats>,
    /// What the pixels of a cost map have cost, if one is drawn.
    pub costs: Option<CostReport>,
    /// What is behind the pixel in question, if there is one.
    pub pixel: Option<PixelTree>,
    /// The rendered picture of a comparison, if one of its two is rendered.
    pub picture: Option<Picture>,
    /// The pictures' files.
    pub files: CompleteFiles,
}

/// Reads, prepares, renders and writes.
pub fn render(
    options: &Options,
    argv: &[OsString],
    input: &Path,
    written: &WrittenFiles,
    crew: &Crew,
    signals: &mut Signals,
    tell: &dyn Fn(&Diagnostic),
) -> Result<Rendered, End> {
    let files = options.outputs.iter().map(prepare_file);
    let files: Vec<OutputFile> = files.collect::<Result<_, _>>().map_err(failed)?;

    let mut clock = Clock(Instant::now());
    let announce = |bytes| {
        if bytes >= LARGE_MESH {
            crew.start_all()
        }
    };
    let mut loaded = scene_io::load_announcing(input, &options.hints(), &announce)?;
    written.check_loaded(&loaded)?;
    let settled = options.in_edition(loaded.choice.edition);
    let options = &settled;
    if let Some(note) = loaded.choice.note() {
        tell(&Diagnostic::note(note));
    }
    let reading = clock.lap();
    let mut warnings = warned::about_scene(&mut loaded, options);
    let places = std::mem::take(&mut loaded.places);
    let renderer = Renderer::new(loaded, meshes(options))?;
    let renderer = renderer.on_threads(crew.pool.clone());
    let (scene, effects) = (&renderer.scene, &options.effects);
    if !options.visualize_grid {
        warnings.extend(lights_without_effect(scene, renderer.world(), &places, effects));
    }
    let say = |warnings: Vec<Diagnostic>| warned::say(warnings, options, &renderer.source, tell);
    say(warnings)?;
    let mut request = options.request();
    let compared = options.comparison.as_ref().filter(|wanted| wanted.needs_scene());
    let compared = compared.and_then(|_| options.compared_layer());
    // A map of costs is drawn again when it is complete.
    let kept = compared.filter(|layer| !matches!(layer, Layer::Cost(_)));
    request.layers.extend(kept);
    if request.camera_rays() >= MANY_RAYS || renderer.world().finite_count() >= MANY_PRIMITIVES {
        crew.start_all();
    }
    let prepared = prepare(options, &renderer, &request, options.tracing())?;
    let building = clock.lap();

    let part_in = |window, layer| fingerprint::part(&prepared, &request, window, layer);
    let part = |layer| request.window.and_then(|window| part_in(window, layer));
    // No command line renders a part of these.
    let has_parts = !options.jitter && !options.reduced;
    let mut products = Products::begin(files, &request, &part)?;
    if let Some(layer) = kept {
        products.keep(request.layer_size(&layer))?;
    }
    let world = renderer.world();
    let is_empty = world.finite_count() == 0 && world.planes.is_empty();
    products.watch_for_blank(&request, &renderer.scene, is_empty);
    let mut failure = None;
    let mut take_row = |layer: usize, row: &[Color]| match products.take_row(layer, row) {
        Ok(()) => ControlFlow::Continue(()),
        Err(error) => {
            failure = Some(error);
            ControlFlow::Break(())
        }
    };
    signals.end_at_second();
    let (progress, start) = (ProgressLine::new(options.progress), Instant::now());
    let watch = |rows| {
        if start.elapsed() >= PATIENCE {
            crew.start_all();
        }
        progress.show(|passed| rows_text("rendering", rows, passed));
        if signals.received().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let rendered = prepared.render_rows(&request, &watch, &mut take_row);
    progress.end();
    if let Some(error) = failure {
        return Err(failed(error).into());
    }
    let counts = match rendered {
        Err(Stopped::Cancelled { rows }) => {
            let kept = products
                .keep_parts(&request, &|layer| part_in(upper(&request, rows), layer).filter(|_| has_parts))?;
            stopping::lines(argv, options, rows, &kept).iter().for_each(|line| app::say(line));
            return signals
                .received()
                .map_or(Err(failed("the rendering was stopped").into()), |end| Err(end.into()));
        }
        counts => counts.map_err(failed)?,
    };
    let encoding = products.encoding;
    let rendering = clock.lap() - encoding;

    let shows_nothing = products.shows_nothing() && !options.visualize_grid;
    let goes_on = |_| match signals.received() {
        Some(_) => ControlFlow::Break(()),
        None => ControlFlow::Continue(()),
    };
    let nothing = if shows_nothing { nothing_visible(&prepared, &request, &places, &goes_on) } else { None };
    say(nothing.into_iter().collect())?;
    say(not_shown(&products.exceptional()))?;
    let finished = products.finish(options.picture_size())?;
    let files = CompleteFiles::default();
    let (streams, regular): (Vec<_>, Vec<_>) = finished.files.into_iter().partition(CompleteFile::is_stream);
    regular.into_iter().try_for_each(|file| files.add(file))?;
    if !streams.is_empty() {
        files.before_waiting(signals)?;
    }
    streams.into_iter().try_for_each(|stream| files.add(stream))?;
    let mut report = Report {
        size: request.window_size(),
        bounds: renderer.bounds(),
        grid: prepared.cells(),
        counts,
        timings: Timings { reading, building, rendering, writing: encoding + clock.lap() },
        threads: crew.at_work(),
        standard_error: None,
        edition: options.edition.filter(|&edition| edition != Edition::default()).map(Edition::name),
    };
    let repeats = match options.repeat {
        Some(count) => Repeats::of(repeated(count, rendering, &prepared, &request, options, signals)?),
        None => None,
    };
    if options.stats && has_standard_error(&request) {
        files.before_waiting(signals)?;
        report.standard_error =
            standard_error(&prepared, &request, &|_| ControlFlow::Continue(())).map_err(failed)?;
    }
    let picture = match (compared, &finished.costs) {
        (Some(Layer::Cost(_)), Some(map)) => Some(map.draw().map_err(failed)?),
        _ => finished.kept,
    };
    let costs = finished.costs.map(|map| CostReport { map, cells: prepared.fullness(FULLEST) });
    if options.pixel.is_some() {
        files.before_waiting(signals)?;
    }
    let explain = |pixel| explanation(options, &renderer, prepared, pixel);
    let pixel = options.pixel.map(explain).transpose()?.flatten();
    Ok(Rendered { options: settled, renderer, report, repeats, costs, pixel, picture, files })
}

impl Rendered {
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

/// The times of `count` renderings, of which the first has taken this time. The others leave nothing behind, and a
/// signal ends them.
fn repeated(
    count: u32,
    first: Duration,
    prepared: &Prepared,
    request: &Request,
    options: &Options,
    signals: &Signals,
) -> Result<Vec<Duration>, Diagnostic> {
    let progress = ProgressLine::new(options.progress);
    let mut times = vec![first];
    for number in 2..=count {
        let doing = format!("rendering {number} of {count}");
        let watch = |rows| {
            progress.show(|passed| rows_text(&doing, rows, passed));
            if signals.received().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let start = Instant::now();
        match prepared.render_rows(request, &watch, &mut |_, _| ControlFlow::Continue(())) {
            Err(Stopped::Cancelled { .. }) => break,
            rendered => rendered.map_err(failed)?,
        };
        times.push(start.elapsed());
    }
    progress.end();
    Ok(times)
}

/// Checks that a picture can be written.
pub fn prepare_file(output: &Output) -> Result<OutputFile, ImageError> {
    match output.is_standard_output() {
        true => Ok(OutputFile::standard_output(output.format)),
        false => OutputFile::prepare_as(&output.file, output.format),
    }
}

/// Reads a picture. Notes say how many of its pixels are `done`, which is what is done with them, clamped, and whether
/// a line end follows the last one.
pub fn read_picture(path: &Path, done: &str, tell: &dyn Fn(&Diagnostic)) -> Result<Picture, Diagnostic> {
    let (picture, Remarks { clamped, has_line_end }) = read_remarked_picture(path).map_err(failed)?;
    let shown = quoted(path);
    if clamped > 0 {
        let message = format!("{clamped} pixels of {shown} are not within 0 to 1; they are {done} clamped");
        tell(&Diagnostic::note(message));
    }
    if has_line_end {
        let message = format!("a line end follows the last pixel of {shown}; it is left out");
        tell(&Diagnostic::note(message));
    }
    Ok(picture)
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
        explained => explained.map(Some).map_err(failed),
    }
}

/// How many of the fullest cells are named.
const FULLEST: usize = 5;

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
            failed(format!("{error}; the entries of its cells alone are {}", Bytes(bytes)))
        }
        _ => failed(error),
    })
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
