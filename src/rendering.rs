//! The rendering of a scene, with everything that is written and printed of it.

use crate::failed;
use crate::products::Products;
use rayon::ThreadPool;
use raytracer::cli::{Comparison, Options};
use raytracer::explain::{CostReport, Explainer, PixelTree};
use raytracer::grid::options::{Resolution, Structure};
use raytracer::image_io::OutputFile;
use raytracer::memory::{Bytes, Text};
use raytracer::mode::{Course, Mode};
use raytracer::picture::Picture;
use raytracer::render::{Layer, Request};
use raytracer::renderer::{Meshes, Prepared, Renderer};
use raytracer::scene::Color;
use raytracer::scene_io;
use raytracer::stats::{Report, Timings};
use raytracer::trace::Observer;
use std::fmt::Display;
use std::io::{self, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What a rendering leaves.
pub struct Rendered {
    pub renderer: Renderer,
    pub report: Report,
    /// What the pixels of a cost map have cost, if one is drawn.
    pub costs: Option<CostReport>,
    /// What is behind the pixel in question, if there is one.
    pub pixel: Option<PixelTree>,
    /// The colour picture, if it is one of two to compare.
    pub picture: Option<Picture>,
}

/// Reads, prepares, renders and writes.
pub fn render<M: Mode, P: Observer>(
    options: &Options,
    input: &Path,
    threads: &Arc<ThreadPool>,
    tell: &dyn Fn(&str),
) -> Result<Rendered, String> {
    let files = options.outputs.iter().map(|output| OutputFile::prepare(&output.file));
    let files: Vec<OutputFile> = files.collect::<Result<_, _>>().map_err(failed)?;

    let mut clock = Clock(Instant::now());
    let loaded = scene_io::load(input).map_err(|error| error.to_string())?;
    if loaded.scene.lights.is_empty() {
        tell("WARNING:  No lights specified");
    }
    let reading = clock.lap();
    let renderer = Renderer::new(loaded, meshes(options)).map_err(|error| error.to_string())?;
    let renderer = renderer.on_threads(threads.clone());
    let mut request = options.request();
    let keeps = options.comparison.as_ref().is_some_and(Comparison::needs_scene);
    if keeps {
        request.layers.push(Layer::Color);
    }
    let prepared = prepare::<M>(options, &renderer, &request)?;
    let building = clock.lap();

    let mut products = Products::begin(files, &request)?;
    if keeps {
        products.keep(options.size)?;
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
    let costs = finished.costs.map(|map| CostReport { map, cells: prepared.fullness(FULLEST) });
    let explain = |pixel| explanation(options, &renderer, prepared, pixel);
    let pixel = options.pixel.map(explain).transpose()?.flatten();
    Ok(Rendered { renderer, report, costs, pixel, picture: finished.kept })
}

impl Rendered {
    /// What there is to print.
    pub fn text(&self, options: &Options) -> io::Result<String> {
        let blocks: [Option<&dyn Display>; 3] = [
            options.stats.then_some(&self.report),
            self.costs.as_ref().map(|costs| costs as _),
            self.pixel.as_ref().map(|pixel| pixel as _),
        ];
        let mut text = Text::default();
        blocks.into_iter().flatten().try_for_each(|block| write!(text, "{block}"))?;
        text.into_string()
    }
}

/// The meshes are kept for the view of the grid's cells, for naming the objects behind a pixel, and for finding the
/// cause of a difference, which renders other scenes with the same meshes.
fn meshes(options: &Options) -> Meshes {
    let has_outside = options.comparison.as_ref().is_some_and(|wanted| wanted.picture.is_some());
    let keeps = options.visualize_grid || options.pixel.is_some() || has_outside;
    if keeps { Meshes::Kept } else { Meshes::Moved }
}

/// What is behind a pixel. It is traced and counted as by the course's program, like all that is counted.
fn explanation<M: Mode>(
    options: &Options,
    renderer: &Renderer,
    prepared: Prepared<M>,
    pixel: [usize; 2],
) -> Result<Option<PixelTree>, String> {
    let request = options.request();
    let anew = || prepare::<Course>(options, renderer, &request);
    let prepared = prepared.into_course().map_or_else(anew, Ok)?;
    let explainer = Explainer::new(&prepared).map_err(failed)?;
    Ok(explainer.pixel(&request, pixel))
}

/// How many of the fullest cells are named.
const FULLEST: usize = 5;

fn prepare<'r, M: Mode>(
    options: &Options,
    renderer: &'r Renderer,
    request: &Request,
) -> Result<Prepared<'r, M>, String> {
    let prepared = match options.structure {
        Structure::Grid(grid) if options.visualize_grid => {
            renderer.prepare_cells(grid, request.camera_rays())
        }
        structure => renderer.prepare_for(structure, request),
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
