//! The JSON document of a run: everything that it reports, in the form that `docs/json.md` describes.

use super::compare::ComparisonResult;
use super::render::Rendered;
use raytracer::cli::Options;
use raytracer::render::{Cost, Tracing};
use raytracer::stats::{Counts, Repeats, Timings};
use raytracer::tools::causes::Finding;
use raytracer::tools::compare::{LargestDifference, Tolerance};
use raytracer::tools::explain::{CostReport, PixelTree};
use serde::Serialize;

mod scene;

use scene::SceneSummary;

/// The version of the form. It changes when a member is removed, renamed, or gets another meaning, and stays when one
/// is added.
const FORMAT: u32 = 1;

#[derive(Serialize)]
pub struct Document<'a> {
    format: u32,
    version: &'static str,
    options: &'a Options,
    threads: usize,
    /// The pictures that are written.
    written: Vec<String>,
    /// The lines on standard error.
    warnings: &'a [String],
    /// This and the next four are null without a scene.
    scene: Option<SceneSummary>,
    grid: Option<Grid>,
    timings: Option<Timings>,
    /// Null also without `-repeat`.
    repeats: Option<Repeats>,
    /// Null also where nothing is counted.
    statistics: Option<Counts>,
    /// Null also without samples whose mean is taken.
    standard_error: Option<f64>,
    cost_map: Option<CostSummary>,
    pixel: Option<Pixel<'a>>,
    comparison: Option<Compared>,
}

#[derive(Serialize)]
struct Grid {
    cells: [usize; 3],
}

#[derive(Serialize)]
struct CostSummary {
    #[serde(flatten)]
    cost: Cost,
    total: u64,
    most_expensive: ExpensivePixel,
    cells: Option<Cells>,
}

#[derive(Serialize)]
struct ExpensivePixel {
    pixel: [usize; 2],
    count: u64,
}

/// How full the cells of the grid are.
#[derive(Serialize)]
struct Cells {
    all: usize,
    empty: usize,
    fullest: Vec<FullCell>,
}

#[derive(Serialize)]
struct FullCell {
    cell: [usize; 3],
    primitives: usize,
}

#[derive(Serialize)]
struct Pixel<'a> {
    #[serde(flatten)]
    tree: &'a PixelTree,
    counts: Counts,
    /// The channels whose byte a few roundings could change.
    close_channels: Vec<&'static str>,
}

#[derive(Serialize)]
struct Compared {
    size: [u32; 2],
    pixels: u64,
    pixels_that_differ: u64,
    by_more_than_one_level: u64,
    largest: Option<LargestDifference>,
    root_mean_square_error: f64,
    /// In dB; null, for infinity, if the pictures are equal.
    psnr: f64,
    mean_flip: Option<f64>,
    differing_beside_an_edge: u64,
    tolerance: Option<Check>,
    cause: Option<CauseFound>,
}

/// A tolerance, and what it says.
#[derive(Serialize)]
struct Check {
    #[serde(flatten)]
    tolerance: Tolerance,
    pixels_above: u64,
    passes: bool,
}

#[derive(Serialize)]
struct CauseFound {
    #[serde(flatten)]
    finding: Finding,
    text: String,
}

impl<'a> Document<'a> {
    pub fn new(
        options: &'a Options,
        warnings: &'a [String],
        rendered: Option<&'a Rendered<'a>>,
        verdict: Option<&ComparisonResult>,
    ) -> Self {
        let tolerance = options.comparison.as_ref().and_then(|comparison| comparison.tolerance);
        Self {
            format: FORMAT,
            version: env!("CARGO_PKG_VERSION"),
            options,
            threads: rayon::current_num_threads(),
            written: written(options),
            warnings,
            scene: rendered.map(|rendered| SceneSummary::of(rendered.renderer)),
            grid: rendered.and_then(|rendered| rendered.report.grid).map(|cells| Grid { cells }),
            timings: rendered.map(|rendered| rendered.report.timings),
            repeats: rendered.and_then(|rendered| rendered.repeats),
            statistics: rendered
                .filter(|_| options.tracing() == Tracing::Counted)
                .map(|rendered| rendered.report.counts),
            standard_error: rendered.and_then(|rendered| rendered.report.standard_error),
            cost_map: rendered.and_then(|rendered| rendered.costs.as_ref()).map(CostSummary::of),
            pixel: rendered.and_then(|rendered| rendered.pixel.as_ref()).map(Pixel::of),
            comparison: verdict.map(|verdict| Compared::of(verdict, tolerance)),
        }
    }

    /// The document in one line. Numbers have all their digits; those that JSON does not have are null.
    pub fn to_json(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)? + "\n")
    }
}

fn written(options: &Options) -> Vec<String> {
    let pictures = options.outputs.iter().map(|output| &output.file);
    let difference = options.comparison.as_ref().and_then(|comparison| comparison.difference.as_ref());
    pictures.chain(difference).map(|file| file.to_string_lossy().into_owned()).collect()
}

impl CostSummary {
    fn of(CostReport { map, cells }: &CostReport) -> Self {
        let (pixel, count) = map.most_expensive();
        let full_cell = |&(cell, primitives): &_| FullCell { cell, primitives };
        let cells = cells.as_ref().map(|cells| Cells {
            all: cells.cells,
            empty: cells.empty,
            fullest: cells.fullest.iter().map(full_cell).collect(),
        });
        Self { cost: map.cost, total: map.total(), most_expensive: ExpensivePixel { pixel, count }, cells }
    }
}

impl<'a> Pixel<'a> {
    fn of(tree: &'a PixelTree) -> Self {
        Self { tree, counts: tree.counts(), close_channels: tree.close_channels().collect() }
    }
}

impl Compared {
    fn of(
        ComparisonResult { comparison, cause, passes }: &ComparisonResult,
        tolerance: Option<Tolerance>,
    ) -> Self {
        let above = |levels| comparison.pixels_differing_by_more_than(levels);
        let check = |(tolerance, passes): (Tolerance, bool)| Check {
            tolerance,
            pixels_above: above(tolerance.levels),
            passes,
        };
        Self {
            size: comparison.size,
            pixels: comparison.pixels(),
            pixels_that_differ: comparison.pixels_that_differ(),
            by_more_than_one_level: above(1),
            largest: comparison.largest,
            root_mean_square_error: comparison.root_mean_square_error,
            psnr: comparison.psnr(),
            mean_flip: comparison.mean_flip,
            differing_beside_an_edge: comparison.differing_near_edges,
            tolerance: tolerance.zip(*passes).map(check),
            cause: cause.map(|finding| CauseFound { finding, text: finding.to_string() }),
        }
    }
}
