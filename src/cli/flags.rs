//! The table of flags: for each its values, the flags that it excludes, and its line of help.
//!
//! A new flag needs one constant here, one entry in [`FLAGS`], and the code in `options.rs` that interprets
//! it. The parser and the help text are generated from the table.

pub(super) use super::flag::Flag;
use super::section::Section;

/// The flag called `name`, by any of its spellings.
pub(super) fn find(name: &str) -> Option<&'static Flag> {
    FLAGS.iter().copied().find(|flag| flag.name == name || flag.aliases.contains(&name))
}

/// All flags. Those of one section are in the order of the help.
pub(super) const FLAGS: &[&Flag] = &[
    &INPUT,
    &OUTPUT,
    &SIZE,
    &REGION,
    &MERGE,
    &DEPTH,
    &NORMALS,
    &SHADE_BACK,
    &SHADOWS,
    &NO_SHADOWS,
    &TRANSPARENT_SHADOWS,
    &BOUNCES,
    &WEIGHT,
    &RANDOM_SAMPLES,
    &UNIFORM_SAMPLES,
    &JITTERED_SAMPLES,
    &ADAPTIVE_SAMPLES,
    &SEED,
    &BOX_FILTER,
    &TENT_FILTER,
    &GAUSSIAN_FILTER,
    &MITCHELL_FILTER,
    &RENDER_SAMPLES,
    &RENDER_FILTER,
    &GRID,
    &VISUALIZE_GRID,
    &COMPARE,
    &REFERENCE,
    &DIFFERENCE,
    &TOLERANCE,
    &GRADE,
    &COMMANDS,
    &REPORT,
    &ERROR_REPORT,
    &TARGET,
    &STATS,
    &COST_MAP,
    &PIXEL,
    &JSON,
    &THREADS,
    &PROGRESS,
    &QUIET,
    &STRICT,
    &GUI,
    &PORT,
    &NO_BROWSER,
    &TESSELLATION,
    &GOURAUD,
    &HELP,
    &VERSION,
];

pub(super) const INPUT: Flag = Flag::new(
    Section::Pictures,
    "input",
    &["file"],
    "The scene; - reads it from standard input. Required, unless two pictures are compared.",
);
pub(super) const OUTPUT: Flag = Flag::new(
    Section::Pictures,
    "output",
    &["file"],
    "Writes the picture as .tga, .png or, in floating point, .pfm or .exr; - png writes it to standard output.",
)
.picture(0);
pub(super) const SIZE: Flag = Flag::new(
    Section::Pictures,
    "size",
    &["w", "h"],
    "Width and height of every picture in pixels, 1 to 65535.",
);
pub(super) const REGION: Flag = Flag::new(
    Section::Pictures,
    "region",
    &["x", "y", "w", "h"],
    "Renders only this part of every picture, whose bytes are those of the whole. The top left pixel is 0 0.",
)
.conflicts(&["render_filter", "cost_map", "compare", "reference"]);
pub(super) const MERGE: Flag = Flag::new(
    Section::Pictures,
    "merge",
    &["files..."],
    "Puts these parts of a picture together in -output. They come from -region, in any order.",
);
pub(super) const DEPTH: Flag = Flag::new(
    Section::Pictures,
    "depth",
    &["t0", "t1", "file"],
    "Writes a picture of distances: white at t0 and nearer, black at t1 and beyond. t0 < t1. As .pfm or .exr, the distances themselves.",
)
.picture(2);
pub(super) const NORMALS: Flag = Flag::new(
    Section::Pictures,
    "normals",
    &["file"],
    "Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue; as .pfm or .exr, x, y, z themselves. Also -normal.",
)
.picture(0)
.aliases(&["normal"]);

pub(super) const SHADE_BACK: Flag = Flag::new(
    Section::Shading,
    "shade_back",
    &[],
    "Lights surfaces seen from behind; without it they are black.",
);
pub(super) const SHADOWS: Flag = Flag::new(Section::Shading, "shadows", &[], "Casts shadows.");
pub(super) const NO_SHADOWS: Flag = Flag::new(
    Section::Shading,
    "no_shadows",
    &[],
    "Casts no shadows. This is the default; the flag is accepted for the command lines of 2003.",
)
.conflicts(&["shadows", "transparent_shadows"]);
pub(super) const TRANSPARENT_SHADOWS: Flag = Flag::new(
    Section::Shading,
    "transparent_shadows",
    &[],
    "Casts shadows that transparent objects tint. Implies -shadows.",
);
pub(super) const BOUNCES: Flag =
    Flag::new(Section::Shading, "bounces", &["n"], "Traces reflected and refracted rays to this depth.");
pub(super) const WEIGHT: Flag =
    Flag::new(Section::Shading, "weight", &["w"], "Traces no ray whose weight is w or less.");

pub(super) const RANDOM_SAMPLES: Flag =
    Flag::new(Section::Sampling, "random_samples", &["n"], "Takes n random samples per pixel, 1 to 65536.")
        .conflicts(&["uniform_samples", "jittered_samples"]);
pub(super) const UNIFORM_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "uniform_samples",
    &["n"],
    "Takes n samples per pixel at the centres of a grid's cells; the grid is as nearly square as n allows: 4 by 2 for 8.",
)
.conflicts(&["jittered_samples"]);
pub(super) const JITTERED_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "jittered_samples",
    &["n"],
    "Takes a random sample in each cell of that grid.",
);
pub(super) const ADAPTIVE_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "adaptive_samples",
    &["most", "error"],
    "Takes 4 jittered samples per pixel and, where they disagree, up to most, 4 to 1024, until the error of the pixel is about this many levels.",
)
.conflicts(&["random_samples", "uniform_samples", "jittered_samples"]);
pub(super) const SEED: Flag =
    Flag::new(Section::Sampling, "seed", &["n"], "Seeds the random numbers as srand48(n) does.");
pub(super) const BOX_FILTER: Flag = Flag::new(
    Section::Sampling,
    "box_filter",
    &["r"],
    "Averages the samples within r pixels along both axes.",
)
.conflicts(&["tent_filter", "gaussian_filter", "mitchell_filter"]);
pub(super) const TENT_FILTER: Flag = Flag::new(
    Section::Sampling,
    "tent_filter",
    &["r"],
    "Weights samples linearly, down to 0 at the radius r.",
)
.conflicts(&["gaussian_filter", "mitchell_filter"]);
pub(super) const GAUSSIAN_FILTER: Flag = Flag::new(
    Section::Sampling,
    "gaussian_filter",
    &["s"],
    "Weights samples by a Gaussian of standard deviation s.",
)
.conflicts(&["mitchell_filter"]);
pub(super) const MITCHELL_FILTER: Flag = Flag::new(
    Section::Sampling,
    "mitchell_filter",
    &["r"],
    "Weights samples by Mitchell and Netravali's cubic, scaled to end at r; 2 is usual.",
);
pub(super) const RENDER_SAMPLES: Flag = Flag::new(
    Section::Sampling,
    "render_samples",
    &["file", "zoom"],
    "Writes a picture of the sample positions, with each pixel enlarged.",
)
.picture(0);
pub(super) const RENDER_FILTER: Flag = Flag::new(
    Section::Sampling,
    "render_filter",
    &["file", "zoom"],
    "Writes a picture of the filter's weights, with each pixel enlarged.",
)
.picture(0);

pub(super) const GRID: Flag = Flag::new(
    Section::Grid,
    "grid",
    &["nx", "ny", "nz"],
    "Uses a uniform grid of nx by ny by nz cells, of a suitable number with -grid auto, or none with -grid none. The picture stays the same.",
);
pub(super) const VISUALIZE_GRID: Flag = Flag::new(
    Section::Grid,
    "visualize_grid",
    &[],
    "Draws the grid's occupied cells instead of the scene. Needs -grid.",
);

pub(super) const COMPARE: Flag = Flag::new(
    Section::Comparison,
    "compare",
    &["file"],
    "Compares this picture, .tga, .png, .pfm or .exr, with the reference.",
);
pub(super) const REFERENCE: Flag = Flag::new(
    Section::Comparison,
    "reference",
    &["file"],
    "The picture to compare with, or the folder of pictures for -grade.",
);
pub(super) const DIFFERENCE: Flag = Flag::new(
    Section::Comparison,
    "difference",
    &["file"],
    "Draws the picture, the reference and their amplified difference side by side.",
);
pub(super) const TOLERANCE: Flag = Flag::new(
    Section::Comparison,
    "tolerance",
    &["levels", "n"],
    "Ends with status 3 if more than n pixels differ by more than this many levels.",
);

pub(super) const GRADE: Flag = Flag::new(
    Section::Grading,
    "grade",
    &["folder"],
    "Compares the pictures in every folder of this folder with those of -reference or -commands.",
);
pub(super) const COMMANDS: Flag = Flag::new(
    Section::Grading,
    "commands",
    &["file"],
    "The pictures to grade by are those that the command lines in this file render.",
)
.conflicts(&["reference"]);
pub(super) const REPORT: Flag = Flag::new(
    Section::Grading,
    "report",
    &["file"],
    "Writes what -grade finds as a page, .html, and as a table beside it, .csv.",
);

pub(super) const ERROR_REPORT: Flag = Flag::new(
    Section::ErrorReport,
    "error_report",
    &["folder"],
    "Measures what samples, filters, bounces and grids cost and buy for the scene and the other flags; writes report.html and report.csv.",
);
pub(super) const TARGET: Flag = Flag::new(
    Section::ErrorReport,
    "target",
    &["rmse"],
    "Prints the cheapest setting with at most this root mean square error, in levels.",
);

pub(super) const STATS: Flag =
    Flag::new(Section::Statistics, "stats", &[], "Prints counters and times after rendering.");

pub(super) const GUI: Flag = Flag::new(
    Section::Preview,
    "gui",
    &[],
    "Renders what the line asks for, then shows the scene as a live page in the browser. Needs a terminal, or -port.",
);
pub(super) const PORT: Flag = Flag::new(
    Section::Preview,
    "port",
    &["n"],
    "Serves the page of -gui at this port of 127.0.0.1, also without a terminal; 0 is any free port.",
);
pub(super) const NO_BROWSER: Flag =
    Flag::new(Section::Preview, "no_browser", &[], "Prints the page's address and opens no browser.");
pub(super) const TESSELLATION: Flag =
    Flag::new(Section::Preview, "tessellation", &["a", "b"], "Accepted from the course; changes nothing.");
pub(super) const GOURAUD: Flag =
    Flag::new(Section::Preview, "gouraud", &[], "Accepted from the course; changes nothing.");

pub(super) const COST_MAP: Flag = Flag::new(
    Section::Statistics,
    "cost_map",
    &["kind", "file"],
    "Draws what each pixel costs in false colours; kind is rays, tests or cells, as -stats counts them.",
)
.picture(1);

pub(super) const PIXEL: Flag = Flag::new(
    Section::Statistics,
    "pixel",
    &["x", "y"],
    "Prints the rays behind one pixel, and what each of them meets. The top left pixel is 0 0.",
)
.conflicts(&["visualize_grid"]);

pub(super) const JSON: Flag = Flag::new(
    Section::Statistics,
    "json",
    &["file"],
    "Writes everything that is reported as .json; - writes it to standard output in place of the text.",
);

pub(super) const THREADS: Flag = Flag::new(
    Section::Other,
    "threads",
    &["n"],
    "Renders with n threads, 1 to 4096. The picture stays the same.",
);
pub(super) const PROGRESS: Flag = Flag::new(
    Section::Other,
    "progress",
    &[],
    "Tells how far the run has come every ten seconds where standard error is no terminal. A terminal shows it after one second.",
)
.conflicts(&["quiet"]);
pub(super) const QUIET: Flag =
    Flag::new(Section::Other, "quiet", &[], "Does not tell how far the run has come.");
pub(super) const STRICT: Flag = Flag::new(
    Section::Other,
    "strict",
    &[],
    "Takes warnings as errors: the run ends with status 1 and writes no picture.",
);
pub(super) const HELP: Flag =
    Flag::new(Section::Other, "help", &["flag"], "Prints this text, or all about one flag.").aliases(&["h"]);
pub(super) const VERSION: Flag = Flag::new(Section::Other, "version", &[], "Prints the version.");
