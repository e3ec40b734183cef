//! The flags: each is one definition, from which parsing, help, manual page, completions and the table in
//! `docs/command-line.md` come.

use super::error::{CliError, Problem};
use super::flag::{Definition, Flag, Run, file, flag_name, folder, number, output, word};
use super::options::JsonTarget;
use super::outputs::Output;
use super::section::Section;
use super::values::Values;
use crate::caster::choose::{Resolution, Structure};
use crate::render::{Cost, Layer, Window};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Pattern;
use crate::scene::edition::Edition;
use crate::tools::compare::Tolerance;
use std::ffi::OsStr;
use std::path::PathBuf;

/// The flag called `name`, by any of its spellings.
pub(super) fn find(name: &str) -> Option<&'static Flag> {
    FLAGS.iter().copied().find(|flag| flag.names().any(|known| known == name))
}

/// The flag that another program calls `name`.
pub(super) fn meant(name: &str) -> Option<&'static Flag> {
    FLAGS.iter().copied().find(|flag| flag.elsewhere.contains(&name))
}

/// Defines flags, and lists them.
macro_rules! flags {
    ($($name:ident: $value:ty = $definition:expr;)*) => {
        $(pub(super) static $name: Definition<$value> = $definition;)*
        /// All flags. Those of one section are in the order of the help.
        pub(super) static FLAGS: &[&Flag] = &[$(&$name.flag),*];
    };
}

/// The endings of pictures that may be parts, of pictures of bytes, of all pictures to write, and of those to read.
const PARTS: &[&str] = &["tga", "png"];
const BYTES: &[&str] = &["tga", "png", "bmp", "ppm"];
const PICTURES: &[&str] = &["tga", "png", "bmp", "ppm", "pfm", "exr"];
const READ: &[&str] = &["tga", "png", "bmp", "ppm", "pgm", "pbm", "pnm", "pam", "pfm", "exr"];

/// The runs for which a flag is that shapes the colour picture.
const SHAPING: &[Run] = &[Run::ErrorReport, Run::Page];

/// The range of a picture's sides, in pixels.
pub(super) const SIDE: (u32, u32) = (1, 65535);
/// The range of columns and rows.
const PLACE: (u32, u32) = (0, SIDE.1 - 1);
/// The largest value of the course's `int`.
const MAX_INT: u32 = i32::MAX as u32;
/// The upper limit is far above the cores of any machine, and far below the number of threads that cannot be
/// started.
const THREADS_RANGE: (u32, u32) = (1, 4096);
const SAMPLES: (u32, u32) = (1, 65536);
const REPEATS: (u32, u32) = (1, 10_000);
/// The range of the largest number of adaptive samples. A pixel is not divided into more strata.
const ADAPTIVE_MOST: (u32, u32) = (Adaptive::BASE, Adaptive::LIMIT);
/// The range of filter sizes, in pixels.
const FILTER_SIZES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
/// The number of cells stays below this, so that the index of a cell fits into 32 bits.
const CELL_LIMIT: u64 = 1 << 31;

flags! {
    INPUT: PathBuf = Flag::new(Section::Pictures, "input")
        .values(&[file("file", &["txt"])])
        .usual()
        .elsewhere(&["i", "f", "in", "file", "scene"])
        .help("The scene; - reads it from standard input. Required, unless two pictures are compared.")
        .details("Mesh files that the scene names are looked for in the working directory and then beside the scene.")
        .example("-input scene.txt")
        .before("-output picture.png")
        .runs(&[Run::ErrorReport])
        .read(|values| values.path());

    OUTPUT: Output = Flag::new(Section::Pictures, "output")
        .values(&[output(PICTURES)])
        .usual()
        .elsewhere(&["o", "out", "outfile", "image", "format"])
        .default("none")
        .help("Writes the picture as .tga, .png, .bmp, .ppm or, in floating point, .pfm or .exr. Here - png writes it to standard output.")
        .details("The file appears under its name when it is complete.")
        .example("-output picture.png")
        .after("-input scene.txt")
        .runs(&[Run::Merge, Run::Convert])
        .read(|values| picture(values, [Layer::Color; 2]));

    SIZE: [usize; 2] = Flag::new(Section::Pictures, "size")
        .values(&[number("w"), number("h")])
        .fewest(1)
        .usual()
        .elsewhere(&["w", "width", "height", "s", "res", "resolution", "dimensions"])
        .default("100 100")
        .help("Width and height of every picture in pixels, 1 to 65535.")
        .details("The longer side spans the camera's view, which the shorter side crops around the middle. The form 200x200 is understood too.")
        .example("-size 200 200")
        .runs(SHAPING)
        .read(size);

    EDITION: Edition = Flag::new(Section::Pictures, "edition")
        .values(&[word("name", &Edition::NAMES)])
        .default("what the scene's words tell, else 2004")
        .help("Takes scene and flags as that edition of the course does: 2004, 2012a4 or 2012a5 (assignments 4 and 5 of 2012), 2019 (2016 to 2023) or aalto.")
        .details("They differ in the words of scenes, the camera, highlights, normals, recursion and the colours of depths and normals.")
        .example("-edition 2019")
        .runs(SHAPING)
        .read(edition);

    UV: () = Flag::new(Section::Pictures, "uv")
        .help("Shows the places of pixels in place of the scene: red grows to the right, green downwards, and blue is full; as in Aalto's edition, which it implies.")
        .details("So does a scene without a group there.")
        .excludes(&[&PIXEL.flag, &VISUALIZE_GRID.flag])
        .switch();

    REGION: Window = Flag::new(Section::Pictures, "region")
        .values(&[number("x"), number("y"), number("w"), number("h")])
        .default("the whole picture")
        .help("Renders only this part of every picture, whose bytes are those of the whole. The top left pixel is 0 0.")
        .example("-region 0 0 100 50")
        .excludes(&[&RENDER_FILTER.flag, &COST_MAP.flag, &COMPARE.flag, &REFERENCE.flag])
        .runs(&[Run::Merge])
        .read(region);

    MERGE: Vec<PathBuf> = Flag::new(Section::Pictures, "merge")
        .values(&[file("files...", PARTS)])
        .help("Puts these parts of a picture together in -output. They come from -region, in any order.")
        .example("-merge top.png bottom.png")
        .after("-output whole.png")
        .runs(&[Run::Merge])
        .read(|values| values.words.iter().map(|word| values.part(word)).collect());

    CONVERT: PathBuf = Flag::new(Section::Pictures, "convert")
        .values(&[file("file", READ)])
        .help("Writes this picture in the format of -output, which is one of bytes. No scene is needed.")
        .details("Its pixels stay the same. Numbers of .pfm and .exr become bytes as colours of a scene do; a line says how many are clamped.")
        .example("-convert mine.tga")
        .before("-output mine.png")
        .excludes(&[&MERGE.flag])
        .runs(&[Run::Convert])
        .read(|values| values.picture());

    DEPTH: Output = Flag::new(Section::Pictures, "depth")
        .values(&[number("t0"), number("t1"), output(PICTURES)])
        .default("none")
        .help("Writes a picture of distances: white at t0 and nearer, black at t1 and beyond. t0 < t1. As .pfm or .exr, the distances themselves.")
        .details("In the edition 2019 it is the other way round: black at t0, white at t1.")
        .example("-depth 8 20 depth.png")
        .after("-input scene.txt")
        .read(depth);

    NORMALS: Output = Flag::new(Section::Pictures, "normals")
        .values(&[output(PICTURES)])
        .aliases(&["normal"])
        .default("none")
        .help("Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue; as .pfm or .exr, x, y, z themselves. Also -normal.")
        .details("In the edition 2019 the bytes are (x + 1) / 2 and so on, and grey where nothing is hit.")
        .example("-normals normals.png")
        .after("-input scene.txt")
        .read(|values| picture(values, [Layer::Normals, Layer::SignedNormals]));

    SHADE_BACK: () = Flag::new(Section::Shading, "shade_back")
        .usual()
        .elsewhere(&["two_sided", "double_sided"])
        .help("Lights surfaces seen from behind; without it they are black.")
        .details("Scenes with glass need it, because a ray inside the glass sees its surface from behind. In the editions of 2012 and 2019 surfaces look the same from both sides anyway.")
        .runs(SHAPING)
        .switch();

    SHADOWS: () = Flag::new(Section::Shading, "shadows")
        .usual()
        .help("Casts shadows.")
        .details("Transparent objects cast them too.")
        .runs(SHAPING)
        .switch();

    NO_SHADOWS: () = Flag::new(Section::Shading, "no_shadows")
        .help("Casts no shadows. This is the default; the flag is accepted for the command lines of 2003.")
        .excludes(&[&SHADOWS.flag, &TRANSPARENT_SHADOWS.flag])
        .runs(SHAPING)
        .read(|_| Ok(()));

    TRANSPARENT_SHADOWS: () = Flag::new(Section::Shading, "transparent_shadows")
        .help("Casts shadows that transparent objects tint. Implies -shadows.")
        .details("The light is multiplied by the transparent colour to the power of the distance inside the object.")
        .runs(SHAPING)
        .switch();

    BOUNCES: u32 = Flag::new(Section::Shading, "bounces")
        .values(&[number("n")])
        .usual()
        .elsewhere(&["b", "d", "reflections", "max_depth", "max_bounces", "recursion"])
        .default("0")
        .help("Traces reflected and refracted rays to this depth.")
        .details("In the edition 2012a5 the default is 4. Where a material both reflects and transmits, each bounce can double the number of rays; -weight ends those that hardly count.")
        .example("-bounces 5")
        .runs(SHAPING)
        .read(|values| values.number((0, MAX_INT)));

    WEIGHT: f64 = Flag::new(Section::Shading, "weight")
        .values(&[number("w")])
        .default("0")
        .help("Traces no ray whose weight is w or less.")
        .details("In Aalto's edition the default is 0.1. A ray's weight is the product of the lengths of the reflective and transparent colours along its path.")
        .example("-weight 0.01")
        .after("-input scene.txt -output picture.png -bounces 5")
        .runs(SHAPING)
        .read(|values| values.not_negative_number());

    RANDOM_SAMPLES: (Pattern, u32) = Flag::new(Section::Sampling, "random_samples")
        .values(&[number("n")])
        .default("1, the centre")
        .help("Takes n random samples per pixel, 1 to 65536.")
        .example("-random_samples 16")
        .excludes(&[&UNIFORM_SAMPLES.flag, &JITTERED_SAMPLES.flag])
        .runs(SHAPING)
        .read(|values| samples(values, Pattern::Random));

    UNIFORM_SAMPLES: (Pattern, u32) = Flag::new(Section::Sampling, "uniform_samples")
        .values(&[number("n")])
        .default("1, the centre")
        .help("Takes n samples per pixel at the centres of a grid's cells; the grid is as nearly square as n allows: 4 by 2 for 8.")
        .details("In Aalto's edition they are random, and -regular_samples are these.")
        .example("-uniform_samples 9")
        .excludes(&[&JITTERED_SAMPLES.flag])
        .runs(SHAPING)
        .read(|values| samples(values, Pattern::Uniform));

    REGULAR_SAMPLES: (Pattern, u32) = Flag::new(Section::Sampling, "regular_samples")
        .values(&[number("n")])
        .default("1, the centre")
        .help("What -uniform_samples is in the editions of the course but Aalto's, which this flag implies: there -uniform_samples are random.")
        .example("-regular_samples 9")
        .excludes(&[&RANDOM_SAMPLES.flag, &UNIFORM_SAMPLES.flag, &JITTERED_SAMPLES.flag, &ADAPTIVE_SAMPLES.flag, &JITTER.flag])
        .runs(SHAPING)
        .read(|values| samples(values, Pattern::Uniform));

    JITTERED_SAMPLES: (Pattern, u32) = Flag::new(Section::Sampling, "jittered_samples")
        .values(&[number("n")])
        .usual()
        .elsewhere(&["aa", "antialias", "antialiasing", "supersample", "supersampling", "msaa", "samples", "spp", "n"])
        .default("1, the centre")
        .help("Takes n samples per pixel, which smooths edges. Each lies at random in a cell of the grid of -uniform_samples.")
        .example("-jittered_samples 16")
        .runs(SHAPING)
        .read(|values| samples(values, Pattern::Jittered));

    ADAPTIVE_SAMPLES: Adaptive = Flag::new(Section::Sampling, "adaptive_samples")
        .values(&[number("most"), number("error")])
        .default("off")
        .help("Takes so many samples in each pixel, up to most, 4 to 1024, that the error of the picture is about this many levels.")
        .details("Flat pixels get one or few, and edges many. A level is one of 255 steps of a byte.")
        .example("-adaptive_samples 256 2")
        .excludes(&[&RANDOM_SAMPLES.flag, &UNIFORM_SAMPLES.flag, &JITTERED_SAMPLES.flag])
        .runs(SHAPING)
        .read(adaptive);

    JITTER: () = Flag::new(Section::Sampling, "jitter")
        .help("Takes a picture of three times the width and height, with one sample anywhere in each pixel; as in assignment 5 of 2012, which it implies.")
        .details("The random numbers are those of the C library's rand, so that the samples are those of the course's program. Its command lines have -filter too.")
        .excludes(&[&RANDOM_SAMPLES.flag, &UNIFORM_SAMPLES.flag, &JITTERED_SAMPLES.flag, &ADAPTIVE_SAMPLES.flag, &SEED.flag, &REGION.flag])
        .runs(&[Run::Page])
        .switch();

    FILTER: () = Flag::new(Section::Sampling, "filter")
        .help("Blurs the picture and reduces its width and height to a third; as in assignment 5 of 2012, which it implies.")
        .details("The width and height of -size come out with -jitter.")
        .after("-input scene.txt -output picture.png -jitter")
        .excludes(&[&REGION.flag, &PIXEL.flag])
        .runs(&[Run::Page])
        .switch();

    SEED: Drand48 = Flag::new(Section::Sampling, "seed")
        .values(&[number("n")])
        .default("the course's sequence")
        .help("Seeds the random numbers as srand48(n) does.")
        .example("-seed 7")
        .after("-input scene.txt -output picture.png -random_samples 16")
        .runs(SHAPING)
        .read(|values| values.number((0, u32::MAX)).map(Drand48::seeded));

    BOX_FILTER: Filter = Flag::new(Section::Sampling, "box_filter")
        .values(&[number("r")])
        .default("0.5")
        .help("Averages the samples within r pixels along both axes.")
        .example("-box_filter 1")
        .after("-input scene.txt -output picture.png -jittered_samples 16")
        .excludes(&[&TENT_FILTER.flag, &GAUSSIAN_FILTER.flag, &MITCHELL_FILTER.flag])
        .runs(SHAPING)
        .read(|values| filter_size(values).map(|radius| Filter::Box { radius }));

    TENT_FILTER: Filter = Flag::new(Section::Sampling, "tent_filter")
        .values(&[number("r")])
        .default("off")
        .help("Weights samples linearly, down to 0 at the radius r.")
        .example("-tent_filter 1")
        .after("-input scene.txt -output picture.png -jittered_samples 16")
        .excludes(&[&GAUSSIAN_FILTER.flag, &MITCHELL_FILTER.flag])
        .runs(SHAPING)
        .read(|values| filter_size(values).map(|radius| Filter::Tent { radius }));

    GAUSSIAN_FILTER: Filter = Flag::new(Section::Sampling, "gaussian_filter")
        .values(&[number("s")])
        .default("off")
        .help("Weights samples by a Gaussian of standard deviation s.")
        .example("-gaussian_filter 0.4")
        .after("-input scene.txt -output picture.png -jittered_samples 16")
        .excludes(&[&MITCHELL_FILTER.flag])
        .runs(SHAPING)
        .read(|values| filter_size(values).map(|sigma| Filter::Gaussian { sigma }));

    MITCHELL_FILTER: Filter = Flag::new(Section::Sampling, "mitchell_filter")
        .values(&[number("r")])
        .default("off")
        .help("Weights samples by Mitchell and Netravali's cubic, scaled to end at r; 2 is usual.")
        .example("-mitchell_filter 2")
        .after("-input scene.txt -output picture.png -jittered_samples 16")
        .runs(SHAPING)
        .read(|values| filter_size(values).map(|radius| Filter::Mitchell { radius }));

    RENDER_SAMPLES: Output = Flag::new(Section::Sampling, "render_samples")
        .values(&[output(PICTURES), number("zoom")])
        .default("none")
        .help("Writes a picture of the sample positions, with each pixel enlarged.")
        .example("-render_samples samples.png 10")
        .after("-input scene.txt -size 9 9 -jittered_samples 9")
        .read(|values| enlarged(values, |zoom| Layer::Samples { zoom }));

    RENDER_FILTER: Output = Flag::new(Section::Sampling, "render_filter")
        .values(&[output(PICTURES), number("zoom")])
        .default("none")
        .help("Writes a picture of the filter's weights, with each pixel enlarged.")
        .example("-render_filter filter.png 10")
        .after("-input scene.txt -size 9 9 -tent_filter 2")
        .read(|values| enlarged(values, |zoom| Layer::Filter { zoom }));

    GRID: Structure = Flag::new(Section::Grid, "grid")
        .values(&[word("nx", &["auto", "none"]), number("ny"), number("nz")])
        .fewest(1)
        .default("what is fastest")
        .help("Uses a uniform grid of nx by ny by nz cells, of a suitable number with -grid auto, or none with -grid none. The picture stays the same.")
        .details("With -stats, -cost_map or -pixel the default is none, as in the course. auto chooses about one cubic cell per primitive. Without the flag a list, such a grid or a tree of boxes is chosen.")
        .example("-grid 20 20 20")
        .runs(SHAPING)
        .read(structure);

    VISUALIZE_GRID: () = Flag::new(Section::Grid, "visualize_grid")
        .aliases(&["visualize_grid_count"])
        .help("Draws the grid's occupied cells instead of the scene. Needs -grid.")
        .details("The colours tell the number of primitives in each cell: white for 1, red for 17 or more. In 2003 a flag of its own, -visualize_grid_count, asked for them.")
        .after("-input scene.txt -output cells.png -grid 20 20 20")
        .runs(&[Run::Page])
        .switch();

    COMPARE: PathBuf = Flag::new(Section::Comparison, "compare")
        .values(&[file("file", READ)])
        .usual()
        .elsewhere(&["diff"])
        .default("the rendered picture")
        .help("Compares this picture with the reference, whatever the formats of both.")
        .details("With a scene too, the likely cause of a difference is looked for.")
        .example("-compare mine.tga")
        .before("-reference theirs.png")
        .read(|values| values.picture());

    REFERENCE: PathBuf = Flag::new(Section::Comparison, "reference")
        .values(&[file("file", READ)])
        .default("the rendered picture")
        .help("The picture to compare with, or the folder of pictures for -grade.")
        .example("-reference theirs.png")
        .after("-compare mine.tga")
        .runs(&[Run::Grade])
        .read(|values| values.picture());

    DIFFERENCE: PathBuf = Flag::new(Section::Comparison, "difference")
        .values(&[file("file", BYTES)])
        .default("none")
        .help("Draws the picture, the reference and their amplified difference side by side.")
        .example("-difference difference.png")
        .after("-compare mine.tga -reference theirs.png")
        .read(|values| values.byte_picture(values.exactly::<1>()?[0]));

    TOLERANCE: Tolerance = Flag::new(Section::Comparison, "tolerance")
        .values(&[number("levels"), number("n")])
        .default("none")
        .help("Ends with status 3 if more than n pixels differ by more than this many levels.")
        .example("-tolerance 1 20")
        .after("-compare mine.tga -reference theirs.png")
        .runs(&[Run::Grade])
        .read(tolerance);

    GRADE: PathBuf = Flag::new(Section::Grading, "grade")
        .values(&[folder("folder")])
        .help("Compares the pictures in every folder of this folder with those of -reference or -commands.")
        .example("-grade class")
        .before("-commands commands.txt -report page.html")
        .runs(&[Run::Grade])
        .read(|values| values.path());

    COMMANDS: PathBuf = Flag::new(Section::Grading, "commands")
        .values(&[file("file", &["txt"])])
        .default("none")
        .help("The pictures to grade by are those that the command lines in this file render.")
        .details("The file has a command line on every line; empty lines and those that start with # are skipped.")
        .example("-commands commands.txt")
        .after("-grade class")
        .excludes(&[&REFERENCE.flag])
        .needs(&GRADE.flag)
        .runs(&[Run::Grade])
        .read(|values| values.path());

    REPORT: PathBuf = Flag::new(Section::Grading, "report")
        .values(&[file("file", &["html"])])
        .default("none")
        .help("Writes what -grade finds as a page, .html, and as a table beside it, .csv.")
        .example("-report page.html")
        .after("-grade class -commands commands.txt")
        .needs(&GRADE.flag)
        .runs(&[Run::Grade])
        .read(|values| values.path_with(".html", Problem::NotPage));

    ERROR_REPORT: PathBuf = Flag::new(Section::ErrorReport, "error_report")
        .values(&[folder("folder")])
        .help("Measures what samples, filters, bounces and grids cost and buy for the scene and the other flags; writes report.html and report.csv.")
        .example("-error_report folder")
        .after("-input scene.txt -size 60 60 -shadows")
        .runs(&[Run::ErrorReport])
        .read(|values| values.path());

    TARGET: f64 = Flag::new(Section::ErrorReport, "target")
        .values(&[number("rmse")])
        .default("none")
        .help("Answers with the cheapest of all settings measured whose root mean square error is at most this, in levels; status 3 if there is none.")
        .example("-target 2")
        .after("-input scene.txt -size 60 60 -error_report folder")
        .needs(&ERROR_REPORT.flag)
        .runs(&[Run::ErrorReport])
        .read(|values| values.not_negative_number());

    STATS: () = Flag::new(Section::Statistics, "stats")
        .usual()
        .elsewhere(&["v", "verbose", "time", "timing", "benchmark"])
        .help("Prints counters and times after rendering.")
        .details("The program then does and counts what the course's program does, so that the counters compare.")
        .after("-input scene.txt")
        .switch();

    REPEAT: u32 = Flag::new(Section::Statistics, "repeat")
        .values(&[number("n")])
        .default("1")
        .help("Renders n times, 1 to 10000, and prints the least and the median time and the spread, which is the most less the least.")
        .details("With -stats these are times of a run that counts, without it of one that does not. Pictures are written once.")
        .example("-repeat 5")
        .after("-input scene.txt -stats")
        .read(|values| values.number(REPEATS));

    COST_MAP: Output = Flag::new(Section::Statistics, "cost_map")
        .values(&[word("kind", &["rays", "tests", "cells"]), output(BYTES)])
        .default("none")
        .help("Draws what each pixel costs in false colours; kind is rays, tests or cells, as -stats counts them.")
        .example("-cost_map tests cost.png")
        .after("-input scene.txt -grid 20 20 20")
        .read(cost_map);

    PIXEL: [usize; 2] = Flag::new(Section::Statistics, "pixel")
        .values(&[number("x"), number("y")])
        .default("none")
        .help("Prints the rays behind one pixel, and what each of them meets. The top left pixel is 0 0.")
        .example("-pixel 100 160")
        .after("-input scene.txt -size 200 200 -shadows")
        .excludes(&[&VISUALIZE_GRID.flag])
        .read(|values| Ok(values.wholes(PLACE)?.map(|n| n as usize)));

    JSON: JsonTarget = Flag::new(Section::Statistics, "json")
        .values(&[file("file", &["json"])])
        .default("none")
        .help("Writes everything that is reported as .json; - writes it to standard output in place of the text.")
        .example("-json run.json")
        .after("-input scene.txt -stats")
        .read(json);

    THREADS: usize = Flag::new(Section::Other, "threads")
        .values(&[number("n")])
        .elsewhere(&["j", "t", "jobs", "cores", "nthreads"])
        .default("all cores")
        .help("Renders with n threads, 1 to 4096. The picture stays the same.")
        .details("Without it, one thread begins what looks like little work, and the others start if it lasts.")
        .example("-threads 4")
        .runs(&[Run::Grade, Run::ErrorReport])
        .read(|values| Ok(values.number(THREADS_RANGE)? as usize));

    PROGRESS: () = Flag::new(Section::Other, "progress")
        .aliases(&["show_progress"])
        .help("Tells how far the run has come every ten seconds where standard error is no terminal. A terminal shows it after one second.")
        .excludes(&[&QUIET.flag])
        .runs(&[Run::Merge, Run::Grade, Run::ErrorReport])
        .switch();

    QUIET: () = Flag::new(Section::Other, "quiet")
        .elsewhere(&["q", "silent"])
        .help("Tells neither how far the run has come nor, on a terminal, what it wrote.")
        .runs(&[Run::Merge, Run::Convert, Run::Grade, Run::ErrorReport])
        .switch();

    STRICT: () = Flag::new(Section::Other, "strict")
        .help("Takes warnings as errors: the run ends with status 1 and writes no picture.")
        .switch();

    GUI: () = Flag::new(Section::Preview, "gui")
        .usual()
        .elsewhere(&["preview", "window", "interactive", "live"])
        .help("Renders what the line asks for, then shows the scene as a live page in the browser. Needs a terminal, or -port.")
        .switch();

    PORT: u16 = Flag::new(Section::Preview, "port")
        .values(&[number("n")])
        .default("any free port")
        .help("Serves the page of -gui at this port of 127.0.0.1, also without a terminal; 0 is any free port.")
        .example("-port 8080")
        .after("-input scene.txt -gui")
        .needs(&GUI.flag)
        .read(|values| Ok(values.number((0, u16::MAX.into()))? as u16));

    NO_BROWSER: () = Flag::new(Section::Preview, "no_browser")
        .help("Prints the page's address and opens no browser.")
        .after("-input scene.txt -gui")
        .needs(&GUI.flag)
        .switch();

    TESSELLATION: () = Flag::new(Section::Preview, "tessellation")
        .values(&[number("a"), number("b")])
        .help("Accepted from the course; changes nothing.")
        .example("-tessellation 10 5")
        .read(|values| values.wholes::<2>((1, MAX_INT)).map(drop));

    GOURAUD: () = Flag::new(Section::Preview, "gouraud")
        .help("Accepted from the course; changes nothing.")
        .read(|_| Ok(()));

    SPECULAR_FIX: () = Flag::new(Section::Preview, "specular_fix")
        .help("Accepted from Aalto's edition, where nothing reads it; changes nothing.")
        .read(|_| Ok(()));

    USUAL: () = Flag::new(Section::Other, "h")
        .help("Prints the ten flags that people use.")
        .after("")
        .read(|_| Ok(()));

    HELP: () = Flag::new(Section::Other, "help")
        .values(&[flag_name("word")])
        .fewest(0)
        .help("Prints this text, all about a flag, or the flags whose names or descriptions have a word in them.")
        .example("-help size")
        .after("")
        .read(|_| Ok(()));

    VERSION: () = Flag::new(Section::Other, "version")
        .help("Prints the version.")
        .after("")
        .read(|_| Ok(()));
}

/// The layers are that of a picture of bytes and that of floating-point numbers.
fn picture(values: &Values, layers: [Layer; 2]) -> Result<Output, CliError> {
    let ([file], format) = values.of_output()?;
    values.output(file, format, layers)
}

fn depth(values: &Values) -> Result<Output, CliError> {
    let ([near, far, file], format) = values.of_output()?;
    let (near, far) = (values.finite(near)?, values.finite(far)?);
    if near >= far {
        return Err(CliError::DepthOrder { t0: near, t1: far });
    }
    // The greys divide by the difference.
    if !(far - near).is_finite() {
        return Err(CliError::DepthRange);
    }
    values.output(file, format, [Layer::Depth { near, far }, Layer::Distance])
}

fn edition(values: &Values) -> Result<Edition, CliError> {
    let [word] = values.exactly()?;
    word.to_str().and_then(Edition::named).ok_or_else(|| values.bad(word, Problem::NotEdition))
}

fn enlarged(values: &Values, layer: fn(usize) -> Layer) -> Result<Output, CliError> {
    let ([file, zoom], format) = values.of_output()?;
    let zoom = values.whole(zoom, SIDE)? as usize;
    values.output(file, format, [layer(zoom); 2])
}

fn cost_map(values: &Values) -> Result<Output, CliError> {
    let ([kind, file], format) = values.of_output()?;
    let cost = match kind.to_str() {
        Some("rays") => Cost::Rays,
        Some("tests") => Cost::Tests,
        Some("cells") => Cost::Cells,
        _ => return Err(values.bad(kind, Problem::NotCost)),
    };
    let map = values.output(file, format, [Layer::Cost(cost); 2])?;
    // A picture in false colours has nothing beyond bytes.
    if map.format.is_float() { Err(values.bad(format.unwrap_or(file), Problem::NotBytes)) } else { Ok(map) }
}

/// The size as two words, or as one with an `x` between the numbers.
fn size(values: &Values) -> Result<[usize; 2], CliError> {
    let joined = values.single().and_then(|word| word.split_once(['x', 'X']));
    let Some((width, height)) = joined else { return Ok(values.wholes(SIDE)?.map(|n| n as usize)) };
    let side = |word: &str| values.whole(OsStr::new(word), SIDE).map(|n| n as usize);
    Ok([side(width)?, side(height)?])
}

fn region(values: &Values) -> Result<Window, CliError> {
    let [x, y, width, height] = values.exactly()?;
    let number = |word, range| values.whole(word, range).map(|n| n as usize);
    let [x, y] = [number(x, PLACE)?, number(y, PLACE)?];
    Ok(Window { x, y, width: number(width, SIDE)?, height: number(height, SIDE)? })
}

fn samples(values: &Values, pattern: Pattern) -> Result<(Pattern, u32), CliError> {
    Ok((pattern, values.number(SAMPLES)?))
}

fn adaptive(values: &Values) -> Result<Adaptive, CliError> {
    let [most, error] = values.exactly()?;
    Ok(Adaptive { most: values.whole(most, ADAPTIVE_MOST)?, error: values.not_negative(error)? })
}

fn filter_size(values: &Values) -> Result<f64, CliError> {
    let [word] = values.exactly()?;
    let size = values.finite(word)?;
    // The weights are computed with divisions by the size and its square, which must not underflow.
    if FILTER_SIZES.contains(&size) { Ok(size) } else { Err(values.bad(word, Problem::NotFilterSize)) }
}

fn structure(values: &Values) -> Result<Structure, CliError> {
    match values.single() {
        Some("auto") => return Ok(Structure::Grid(Resolution::Auto)),
        Some("none") => return Ok(Structure::List),
        _ => {}
    }
    if let Some(name) = values.words.iter().find(|word| **word == "auto" || **word == "none") {
        return Err(values.bad(name, Problem::NotAlone));
    }
    let cells = values.wholes::<3>((1, MAX_INT))?;
    let product = cells.iter().try_fold(1u64, |product, &n| product.checked_mul(n.into()));
    match product {
        Some(product) if product < CELL_LIMIT => {
            Ok(Structure::Grid(Resolution::Cells(cells.map(|n| n as usize))))
        }
        _ => Err(CliError::TooManyCells { cells }),
    }
}

fn tolerance(values: &Values) -> Result<Tolerance, CliError> {
    let [levels, pixels] = values.exactly()?;
    let levels = values.whole(levels, (0, u8::MAX.into()))? as u8;
    Ok(Tolerance { levels, pixels: values.whole(pixels, (0, u32::MAX))?.into() })
}

fn json(values: &Values) -> Result<JsonTarget, CliError> {
    match values.exactly()? {
        [word] if word == "-" => Ok(JsonTarget::StandardOutput),
        _ => values.path_with(".json", Problem::NotJson).map(JsonTarget::File),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::Command;

    #[test]
    fn every_flag_has_an_example_with_its_values() {
        for flag in FLAGS {
            if flag.values.is_empty() {
                assert_eq!(flag.example, "", "-{}", flag.name);
            } else {
                let mut words = flag.example.split(' ');
                assert_eq!(words.next(), Some(format!("-{}", flag.name).as_str()));
                assert!(flag.value_counts().contains(&words.count()), "{}", flag.example);
            }
        }
    }

    #[test]
    fn every_example_is_a_command_line() {
        for flag in FLAGS {
            let words = flag.command();
            let parsed = crate::cli::parse(words.split(' ').map(Into::into));
            assert!(parsed.is_ok(), "{words}: {parsed:?}");
        }
    }

    #[test]
    fn every_flag_of_a_run_is_in_its_document() {
        let document = |words: &str| match crate::cli::parse(words.split_whitespace().map(Into::into)) {
            Ok(Command::Render(options)) => serde_json::to_string(&options).ok(),
            _ => None,
        };
        for flag in FLAGS {
            let line = flag.command();
            let without = document(&line.replacen(&flag.example_or_usage(), "", 1));
            let Some(with) = document(&line) else { continue };
            assert_eq!(without != Some(with), flag.name != NO_SHADOWS.name, "{line}");
        }
    }
}
