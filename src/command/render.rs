//! Renders a scene: reads it, writes its pictures, and reports.

use super::compare::{Files, Pair};
use super::log::Log;
use super::outputs::{self, Outputs};
use super::parts;
use super::products::{Finished, Products};
use super::progress::{ProgressLine, rows_text};
use super::report::Report;
use super::signals::Signals;
use super::{End, Outcome, threads};
use crate::cli::{ComparisonOptions, Options, Output};
use crate::diagnostic::Diagnostic;
use crate::image_io::{Exceptional, OutputFile};
use crate::render::renderer::{Meshes, Prepared, Renderer};
use crate::render::{Layer, Rendered, Request, Stop, Stopped, Tracing};
use crate::sampling::filter::Filter;
use crate::scene::edition::Edition;
use crate::scene::load::LoadedScene;
use crate::scene::model::Shows;
use crate::stats::{self, Repeats, Timings};
use crate::tools::explain::{Explainer, PixelTree};
use crate::tools::standard_error::standard_error;
use crate::tools::warnings;
use crate::trace::Effects;
use std::ffi::OsString;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// The limit for following the rays behind a pixel. Millions of rays take this long.
const LONGEST_EXPLANATION: Duration = Duration::from_secs(60);

/// Renders a scene with the options of the command line `argv`.
pub fn run(options: &Options, argv: &[OsString], signals: &Signals, log: &Log) -> Result<Outcome, End> {
    threads::start(options.threads, options.size[1])?;

    // Load the scene.
    let mut last = Instant::now();
    let mut lap = || {
        let now = Instant::now();
        now - std::mem::replace(&mut last, now)
    };
    let mut loaded = options.load_scene()?;

    // Settle the options.
    let options = &options.in_edition(loaded.choice.edition);
    outputs::check(options, loaded.files())?;
    let reading = lap();
    let pair = Pair::open(options, log)?;

    // Prepare.
    let mut found = warnings_about(&mut loaded, options);
    let renderer = Renderer::new(loaded, meshes(options))?;
    if !options.visualize_grid {
        found.extend(warnings::lights_without_effect(&renderer.scene, renderer.world(), &options.effects));
    }
    let warn = |found: Vec<Diagnostic>| log.warn(found, options.strict, &renderer.source);
    warn(found)?;
    let request = request(options);
    let prepared = options.prepare(&renderer, &request)?;
    let building = lap();

    // Open the outputs.
    let open = |output: &Output| Ok((OutputFile::prepare(&output.file)?, output.format));
    let pictures = options.outputs.iter().map(open).collect::<Result<_, Diagnostic>>()?;
    let files = Files::open(options)?;
    let mut products = Products::begin(pictures, &prepared, &request, options.compares_numbers())?;

    // Render rows.
    let mut rendered = match render_rows(options, &prepared, &request, &mut products, signals) {
        Err(Stopped::Cancelled { rows }) => {
            let kept = products.keep_parts(rows)?;
            parts::lines(argv, options, rows, &kept).iter().for_each(|line| log.say(line));
            return Err(signals.received().unwrap_or_else(|| End::from(Stopped::Cancelled { rows })));
        }
        rendered => rendered?,
    };
    let rendering = lap() - products.encoding;

    // Finish.
    if products.is_blank && !options.visualize_grid && renderer.scene.shows == Shows::Scene {
        let watch = |_| signals.goes_on();
        warn(warnings::nothing_visible(&prepared, &request, &watch).into_iter().collect())?;
    }
    warn(not_shown(&products.exceptional()))?;
    let encoding = products.encoding;
    let Finished { files: pictures, costs, picture } =
        products.finish(std::mem::take(&mut rendered.costs))?;
    let outputs = Outputs::new(pictures, signals)?;
    let timings = Timings { reading, building, rendering, writing: encoding + lap() };

    // Report.
    let statistics = statistics(options, &prepared, &request, &rendered, timings)?;
    let repeats =
        options.repeat.map(|count| repeated(options, &prepared, &request, count, rendering)).transpose()?;
    let pixel = options.pixel.map(|pixel| explanation(options, &renderer, prepared, pixel)).transpose()?;
    let compare = |pair: Pair| pair.compare(Some(&renderer), picture.as_ref(), files.difference, &outputs);
    let comparison = pair.map(compare).transpose()?;
    let renderer = Some(&renderer);
    let report = Report { renderer, statistics: Some(statistics), repeats, costs, pixel, comparison };
    report.finish(options, files.document, &outputs, log)
}

/// Returns the request for the layers that are written or compared.
fn request(options: &Options) -> Request {
    let mut request = options.request();
    if options.comparison.as_ref().is_some_and(|wanted| wanted.needs_scene()) {
        request.layers.extend(options.compared_layer());
    }
    request
}

/// Renders until a signal comes.
fn render_rows(
    options: &Options,
    prepared: &Prepared,
    request: &Request,
    products: &mut Products,
    signals: &Signals,
) -> Result<Rendered, Stopped> {
    signals.note_first();
    let progress = ProgressLine::new(options.progress);
    let watch = |rows| {
        progress.show(|passed| rows_text("rendering", rows, passed));
        signals.goes_on()
    };
    prepared.render_rows(request, &watch, &mut |layer, row| products.take_row(layer, row))
}

fn statistics(
    options: &Options,
    prepared: &Prepared,
    request: &Request,
    rendered: &Rendered,
    timings: Timings,
) -> Result<stats::Report, Diagnostic> {
    // Adaptive samples are taken until this error is small enough.
    let is_known = request.adaptive.is_some()
        && request.filter == Filter::PIXEL
        && !request.is_reduced
        && request.layers.contains(&Layer::Color);
    let pixels = request.window_size().iter().product::<usize>();
    let standard_error = match options.stats {
        false => None,
        true if is_known => Some(255.0 * (rendered.squared_error / pixels.max(1) as f64).sqrt()),
        true => standard_error(prepared, request)?,
    };
    let edition = options.edition.filter(|&edition| edition != Edition::default());
    Ok(stats::Report {
        size: request.window_size(),
        bounds: prepared.renderer().bounds(),
        grid: prepared.cells(),
        counts: rendered.counts,
        timings,
        threads: rayon::current_num_threads(),
        standard_error,
        edition: edition.map(Edition::name),
    })
}

/// Renders until there are `count` renderings, whose first took the time `first`. Returns their times.
fn repeated(
    options: &Options,
    prepared: &Prepared,
    request: &Request,
    count: u32,
    first: Duration,
) -> Result<Repeats, Diagnostic> {
    let progress = ProgressLine::new(options.progress);
    let mut others = vec![];
    for number in 2..=count {
        let doing = format!("rendering {number} of {count}");
        let watch = |rows| {
            progress.show(|passed| rows_text(&doing, rows, passed));
            ControlFlow::Continue(())
        };
        let start = Instant::now();
        prepared.render_rows(request, &watch, &mut |_, _| Ok(()))?;
        others.push(start.elapsed());
    }
    Ok(Repeats::of(first, others))
}

/// Warns about pixels that the files do not show as they are.
fn not_shown(exceptional: &Exceptional) -> Vec<Diagnostic> {
    let Exceptional { black, nan, out_of_range } = *exceptional;
    let black = match black {
        0 => None,
        1 => Some("the colour of 1 pixel is not a number; it is black".into()),
        _ => Some(format!("the colours of {black} pixels are not numbers; they are black")),
    };
    let nan = (nan > 0).then(|| format!("pixels that are NaN in the file: {nan}"));
    let beyond = (out_of_range > 0)
        .then(|| format!("pixels beyond single precision, infinite or 0 in the file: {out_of_range}"));
    [black, nan, beyond].into_iter().flatten().map(Diagnostic::warning).collect()
}

/// Keeps the meshes to draw the grid's cells, to name the objects behind a pixel, and to find the cause of a
/// difference, which renders other scenes with the same meshes.
fn meshes(options: &Options) -> Meshes {
    let has_outside = options.comparison.as_ref().is_some_and(|wanted| wanted.picture.is_some());
    let keeps = options.visualize_grid || options.pixel.is_some() || has_outside;
    if keeps { Meshes::Kept } else { Meshes::Moved }
}

/// Returns the rays behind a pixel, traced and counted as by the course's program.
fn explanation(
    options: &Options,
    renderer: &Renderer,
    prepared: Prepared,
    pixel: [usize; 2],
) -> Result<PixelTree, Diagnostic> {
    let request = Request { tracing: Tracing::Counted, ..options.request() };
    let prepared = match options.tracing() {
        Tracing::Counted => prepared,
        Tracing::Fast => options.prepare(renderer, &request)?,
    };
    let explainer = Explainer::new(&prepared)?;
    let stop = Stop::at(Instant::now() + LONGEST_EXPLANATION);
    explainer.pixel(&request, pixel, &stop)
}

/// Returns the notes and warnings about a scene and the flags that it is rendered with.
fn warnings_about(loaded: &mut LoadedScene, options: &Options) -> Vec<Diagnostic> {
    let scene = &loaded.scene;
    let mut found = std::mem::take(&mut loaded.warnings);
    found.extend(loaded.choice.remark());
    found.extend(warnings::no_lights(scene));
    if options.written().next().is_none() && !options.has_text() && !options.preview {
        found.push(Diagnostic::warning("nothing is written: add `-output file.tga`"));
    }
    found.extend(warnings::triangles_without_area(scene, &loaded.meshes));
    // The user has not asked for the bounces of an edition.
    let effects = Effects { bounces: options.given.bounces.unwrap_or(0), ..options.effects };
    let request = Request { effects, ..options.request() };
    if !shows_colors(options) {
        found.extend(warnings::colors_not_asked_for(&request, options.edition.unwrap_or_default()));
        return found;
    }
    // `-bounces 0` is meant. In later editions every material with a highlight can mirror, so not to bounce is no
    // mistake.
    let is_meant = options.given.bounces == Some(0) || options.edition.unwrap_or_default() != Edition::Y2004;
    found.extend(warnings::about_colors(scene, &request, is_meant));
    found
}

/// Returns true if the run computes the colours of pixels for its pictures, its text or its page.
fn shows_colors(options: &Options) -> bool {
    let has_layer = |layer: &Layer| matches!(layer, Layer::Color | Layer::Samples { .. } | Layer::Cost(_));
    options.outputs.iter().any(|output| has_layer(&output.layer))
        || options.comparison.as_ref().is_some_and(ComparisonOptions::needs_scene)
        || options.stats
        || options.pixel.is_some()
        || options.page.is_some()
        || options.outputs.is_empty()
}
