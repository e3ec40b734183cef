//! The flags. Each field is a flag: its documentation is its help, and its attributes say what clap reads and checks.
//!
//! The first paragraph is in every help, the others in the help about the flag alone. Flags are in the order of the
//! help. The name of a value tells what completions offer for it (`completions.rs`). The command line has one dash
//! where clap has two (`words.rs`).

use super::values::{
    FILTER_SIZE, NOT_NEGATIVE, Sides, has_ending, must_end_in, number, path, picture, sides,
};
use crate::base::stdio::is_stdio;
use crate::image_io::Format;
use crate::scene::edition::Edition;
use clap::builder::{PossibleValuesParser, RangedU64ValueParser, TypedValueParser};
use clap::{Arg, ArgAction, ArgGroup, CommandFactory, Parser, value_parser};
use std::ffi::OsString;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// The largest value of the course's `int`.
pub(super) const MAX_INT: i64 = i32::MAX as i64;
/// Far above the cores of any machine, and far below the number of threads that cannot be started.
const MAX_THREADS: u64 = 4096;
const SAMPLES: RangeInclusive<i64> = 1..=65536;

/// The headings in the help, and the first flag below each. A heading is also the group of its flags.
const HEADINGS: [(&str, &str); 10] = [
    ("input", "Scene and pictures"),
    ("shade_back", "Shading"),
    ("random_samples", "Sampling"),
    ("grid", "Grid"),
    ("compare", "Comparison"),
    ("grade", "Grading"),
    ("error_report", "Speed against error"),
    ("stats", "Statistics"),
    ("gui", "Live page"),
    ("json", "Other"),
];
/// The flags and groups that shape the colour picture.
const SHAPING: [&str; 6] = ["size", "edition", "uv", "Shading", "Sampling", "Grid"];
/// The other flags and groups that need a scene.
const RENDERING: [&str; 6] = ["layers", "compare", "difference", "Statistics", "Live page", "strict"];
/// The flags that have no meaning for a part of a picture.
pub(super) const NOT_OF_PARTS: [&str; 8] =
    ["render_filter", "cost_map", "compare", "reference", "difference", "tolerance", "jitter", "filter"];

/// Renders the scenes of MIT's 6.837 ray tracing assignments.
#[derive(Debug, Parser)]
#[command(name = "raytracer", version, rename_all = "snake_case", no_binary_name = true)]
#[command(disable_help_flag = true, disable_version_flag = true)]
#[command(override_usage = "raytracer -input scene.txt [flags, in any order]")]
#[command(group = ArgGroup::new("usual").multiple(true))]
#[command(group = ArgGroup::new("layers").multiple(true))]
#[command(group = ArgGroup::new("compared").multiple(true))]
#[command(group = ArgGroup::new("without_scene").conflicts_with_all(RENDERING)
    .conflicts_with_all(SHAPING).conflicts_with_all(["input", "error_report"]))]
pub(super) struct Flags {
    /// The scene; - reads it from standard input. Required, except to compare two pictures and with -grade, -merge and
    /// -convert.
    ///
    /// Mesh files named in the scene are searched in the working directory, then beside the scene.
    #[arg(long, group = "usual", value_name = "scene", required_unless_present_all = ["compare", "reference"])]
    #[arg(required_unless_present = "without_scene")]
    pub input: Option<PathBuf>,

    /// Writes the picture as .tga, .png, .bmp, .ppm, .pfm or .exr. The last two are in floating point. -output - png
    /// writes a PNG to standard output.
    ///
    /// The file appears under its name when it is complete.
    #[arg(long, group = "usual", num_args = 1..=2, value_names = ["picture", "format"])]
    pub output: Option<Vec<OsString>>,

    /// Writes a picture of distances: white at t0 and nearer, black at t1 and beyond. As .pfm or .exr, it has the
    /// distances themselves.
    ///
    /// The edition 2019 has black at t0 and white at t1.
    ///
    /// Example: raytracer -input scene.txt -depth 8 20 depth.png
    #[arg(long, group = "layers", num_args = 3..=4, value_names = ["t0", "t1", "picture", "format"])]
    pub depth: Option<Vec<OsString>>,

    /// Writes a picture of surface normals: |x|, |y|, |z| as red, green, blue. As .pfm or .exr, it has x, y, z
    /// themselves.
    ///
    /// The edition 2019 has (x + 1) / 2 and so on, and grey where nothing is hit.
    #[arg(long, group = "layers", visible_alias = "normal", num_args = 1..=2, value_names = ["picture", "format"])]
    pub normals: Option<Vec<OsString>>,

    /// Writes a picture of the sample positions, with each pixel enlarged.
    ///
    /// Example: raytracer -input scene.txt -size 9 9 -jittered_samples 9 -render_samples samples.png 10
    #[arg(long, group = "layers", num_args = 2..=3, value_names = ["picture", "zoom"])]
    pub render_samples: Option<Vec<OsString>>,

    /// Writes a picture of the filter's weights, with each pixel enlarged.
    ///
    /// Example: raytracer -input scene.txt -size 9 9 -tent_filter 2 -render_filter filter.png 10
    #[arg(long, group = "layers", num_args = 2..=3, value_names = ["picture", "zoom"])]
    pub render_filter: Option<Vec<OsString>>,

    /// Renders only this part of every picture, w by h pixels from column x and row y, with the same bytes as in the
    /// whole. The top left pixel is 0 0.
    ///
    /// Example: raytracer -input scene.txt -output top.png -region 0 0 100 50
    #[arg(long, num_args = 4, value_names = ["x", "y", "w", "h"], value_parser = value_parser!(u16))]
    #[arg(conflicts_with_all = NOT_OF_PARTS)]
    pub region: Option<Vec<u16>>,

    /// Joins parts written by -region into -output, in any order.
    ///
    /// Example: raytracer -merge top.png bottom.png -output whole.png
    #[arg(long, num_args = 1.., value_names = ["parts"], group = "without_scene", requires = "output")]
    #[arg(conflicts_with_all = ["reference", "tolerance", "threads", "json"])]
    #[arg(value_parser = path(
        |file| Format::of(file).is_some_and(Format::has_parts),
        "must end in .tga or .png, as parts do",
    ))]
    pub merge: Option<Vec<PathBuf>>,

    /// Converts the picture to the 8-bit format given by -output. Needs no scene.
    ///
    /// Bytes stay the same. Floating-point colours are clamped and cut to bytes as in a rendered picture. A note counts
    /// the clamped pixels.
    ///
    /// Example: raytracer -convert mine.tga -output mine.png
    #[arg(long, value_name = "picture", value_parser = picture(), group = "without_scene", requires = "output")]
    #[arg(conflicts_with_all = ["reference", "tolerance", "threads", "region", "progress", "json"])]
    pub convert: Option<PathBuf>,

    /// Width and height of every picture in pixels, 1 to 65535.
    ///
    /// The longer side spans the camera's view; the shorter side crops it around the middle. 200x200 is accepted too.
    ///
    /// Example: raytracer -input scene.txt -output picture.png -size 200 200
    #[arg(long, group = "usual", num_args = 1..=2, value_names = ["w", "h"])]
    #[arg(value_parser = sides, default_values = ["100", "100"])]
    pub size: Vec<Sides>,

    /// Reads scene and flags as in this edition of the course. Default: 2004 if it has all words of the scene,
    /// otherwise the edition that has them.
    ///
    /// 2012a4 and 2012a5 are assignments 4 and 5 of 2012, 2019 is 2016 to 2019, and aalto is Aalto University's. They
    /// differ in scene words, camera, highlights, normals, bounces, and the colours of depths and normals.
    #[arg(long, value_name = "name")]
    #[arg(value_parser = PossibleValuesParser::new(Edition::NAMES).try_map(|name| Edition::named(&name).ok_or("")))]
    pub edition: Option<Edition>,

    /// Draws a UV gradient instead of the scene: red = x, green = y, blue = 1. Implies -edition aalto.
    ///
    /// In that edition a scene without a group shows the gradient even without the flag.
    #[arg(long, conflicts_with_all = ["pixel", "visualize_grid"])]
    pub uv: bool,

    /// Lights surfaces seen from behind; without it they are black.
    ///
    /// Scenes with glass need it, because a ray inside the glass sees its surface from behind. In the editions of 2012
    /// and 2019 surfaces look the same from both sides anyway.
    #[arg(long, group = "usual")]
    pub shade_back: bool,

    /// Casts shadows.
    ///
    /// Transparent objects cast them too.
    #[arg(long, group = "usual")]
    pub shadows: bool,

    /// Casts no shadows, which is the default. Accepted for the command lines of 2003.
    #[arg(long, conflicts_with_all = ["shadows", "transparent_shadows"])]
    pub no_shadows: bool,

    /// Casts shadows that transparent objects tint. Implies -shadows.
    ///
    /// The light is multiplied by the transparent colour to the power of the distance inside the object.
    #[arg(long)]
    pub transparent_shadows: bool,

    /// Follows reflected and refracted rays up to n times. Default: 0; in the edition 2012a5, 4.
    ///
    /// Where a material both reflects and transmits, each bounce can double the number of rays; -weight ends those that
    /// contribute little.
    #[arg(long, group = "usual", value_name = "n", value_parser = value_parser!(u32).range(0..=MAX_INT))]
    pub bounces: Option<u32>,

    /// Drops reflected and refracted rays whose weight is w or less. Default: 0; in Aalto's edition, 0.1.
    ///
    /// A ray's weight is the product of the lengths of the reflective and transparent colours along its path.
    #[arg(long, value_name = "w", value_parser = number(NOT_NEGATIVE))]
    pub weight: Option<f64>,

    /// Takes n random samples per pixel, 1 to 65536. Default: one, at the centre.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(SAMPLES), group = "samples")]
    pub random_samples: Option<u32>,

    /// Takes n samples per pixel at the centres of a grid's cells.
    ///
    /// The grid is as nearly square as n allows: 4 by 2 for 8. In Aalto's edition this flag takes random samples, and
    /// -regular_samples takes these.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(SAMPLES), group = "samples")]
    pub uniform_samples: Option<u32>,

    /// Takes a regular grid of n samples. Implies -edition aalto, where -uniform_samples means random.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(SAMPLES), group = "samples")]
    pub regular_samples: Option<u32>,

    /// Takes n samples per pixel, which smooths edges. Each lies at random in a cell of the grid of -uniform_samples.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(SAMPLES), groups = ["usual", "samples"])]
    pub jittered_samples: Option<u32>,

    /// Takes n samples per pixel, the first points of a scrambled Sobol' sequence. They usually leave less error than
    /// jittered ones.
    ///
    /// Any n will do; powers of two are best.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(SAMPLES), group = "samples")]
    pub sobol_samples: Option<u32>,

    /// Adaptive sampling: takes at most n samples per pixel, 4 to 1024, until the estimated error of the picture is
    /// this many levels (1/255).
    ///
    /// Flat pixels get few, edges many. The numbers are powers of two.
    ///
    /// Example: raytracer -input scene.txt -output picture.png -adaptive_samples 256 2
    #[arg(long, num_args = 2, value_names = ["n", "error"], group = "samples")]
    pub adaptive_samples: Option<Vec<OsString>>,

    /// Renders three times the width and height, with one random sample in each pixel. Implies -edition 2012a5.
    ///
    /// It takes the samples of the course's program, with the random numbers of C's rand. Usually given with -filter.
    #[arg(long, group = "samples", conflicts_with = "seed")]
    pub jitter: bool,

    /// Blurs the picture and reduces its width and height to a third. Implies -edition 2012a5.
    ///
    /// With -jitter the picture has the width and height of -size.
    #[arg(long, conflicts_with = "pixel")]
    pub filter: bool,

    /// Seeds the random numbers as srand48(n) does. Default: the course's sequence, which is not seeded.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32))]
    pub seed: Option<u32>,

    /// Averages the samples within r pixels along both axes.
    #[arg(long, value_name = "r", value_parser = number(FILTER_SIZE), default_value = "0.5", group = "one_filter")]
    pub box_filter: f64,

    /// Weights samples linearly, down to 0 at the radius r.
    #[arg(long, value_name = "r", value_parser = number(FILTER_SIZE), group = "one_filter")]
    pub tent_filter: Option<f64>,

    /// Weights samples by a Gaussian of standard deviation s.
    #[arg(long, value_name = "s", value_parser = number(FILTER_SIZE), group = "one_filter")]
    pub gaussian_filter: Option<f64>,

    /// Weights samples by Mitchell and Netravali's cubic, scaled to end at r; 2 is usual.
    #[arg(long, value_name = "r", value_parser = number(FILTER_SIZE), group = "one_filter")]
    pub mitchell_filter: Option<f64>,

    /// Traces rays through a grid of nx by ny by nz cells. -grid auto chooses the cells; -grid none uses no grid. The
    /// picture stays the same.
    ///
    /// auto makes about one cubic cell per primitive. By default rays are traced through a tree of boxes, or a list of
    /// few primitives; -stats, -cost_map and -pixel then count tests of all primitives, as in the course.
    ///
    /// Example: raytracer -input scene.txt -output picture.png -grid 20 20 20
    #[arg(long, num_args = 1..=3, value_names = ["nx", "ny", "nz"])]
    pub grid: Option<Vec<OsString>>,

    /// Draws the grid's occupied cells instead of the scene. Needs -grid.
    ///
    /// The colours show the number of primitives in each cell: white for 1, red for 17 or more. The flag of 2003,
    /// -visualize_grid_count, does the same.
    #[arg(long, visible_alias = "visualize_grid_count", requires = "grid")]
    pub visualize_grid: bool,

    /// Compares this picture with the reference. Without -reference, that is the rendered picture.
    ///
    /// The formats may differ. Two floating-point pictures are compared by their numbers, others by their bytes. With a
    /// scene, the program also searches for the likely cause of a difference.
    ///
    /// Example: raytracer -compare mine.tga -reference theirs.png
    #[arg(long, value_name = "picture", value_parser = picture(), groups = ["usual", "compared"])]
    pub compare: Option<PathBuf>,

    /// The picture to compare with, or the folder of pictures for -grade. Without -compare, the rendered picture is
    /// compared.
    #[arg(long, value_name = "picture", groups = ["compared", "references"])]
    pub reference: Option<PathBuf>,

    /// Draws the picture, the reference and their amplified difference side by side.
    #[arg(long, value_name = "picture", requires = "compared")]
    #[arg(value_parser = path(
        |file| Format::of(file).is_some_and(|format| !format.is_float()),
        must_end_in(Format::BYTES),
    ))]
    pub difference: Option<PathBuf>,

    /// Ends with status 3 if more than n pixels differ by more than this many levels (1/255).
    ///
    /// Two floating-point pictures may differ by more than this number, such as 0.001, in n pixels.
    ///
    /// Example: raytracer -compare mine.tga -reference theirs.png -tolerance 1 20
    #[arg(long, num_args = 2, value_names = ["levels", "n"], requires = "compared")]
    pub tolerance: Option<Vec<OsString>>,

    /// Grades a class: compares the pictures in each subfolder with the references that -reference or -commands names.
    ///
    /// Without -tolerance, a picture passes if it equals its reference. If -commands tells its scene, it passes if at most
    /// 2 of its pixels differ by more than rounding in single precision explains.
    ///
    /// Example: raytracer -grade class -commands commands.txt -report page.html
    #[arg(long, value_name = "folder", group = "without_scene", requires = "references")]
    #[arg(conflicts_with_all = ["output", "region"])]
    pub grade: Option<PathBuf>,

    /// Renders the references for -grade with the command lines in this file.
    ///
    /// Empty lines and lines that start with # are skipped.
    #[arg(long, value_name = "commands", groups = ["compared", "references"], requires = "grade")]
    pub commands: Option<PathBuf>,

    /// Grades only this subfolder of -grade.
    ///
    /// Example: raytracer -grade class -commands commands.txt -student anna
    #[arg(long, value_name = "name", requires = "grade")]
    pub student: Option<OsString>,

    /// Writes the result of -grade as a page, .html, and beside it as a table, .csv.
    #[arg(long, value_name = "page", requires = "grade")]
    #[arg(value_parser = path(|path| has_ending(path, "html"), "must end in .html"))]
    pub report: Option<PathBuf>,

    /// Measures time and error with other samples, filters, bounces and grids. Writes report.html and report.csv.
    ///
    /// Example: raytracer -input scene.txt -size 60 60 -shadows -error_report folder
    #[arg(long, value_name = "folder", conflicts_with_all = RENDERING)]
    #[arg(conflicts_with_all = ["output", "region", "jitter", "filter", "visualize_grid", "reference", "tolerance"])]
    #[arg(conflicts_with = "json")]
    pub error_report: Option<PathBuf>,

    /// Prints the fastest measured setting with a root mean square error of at most this, in levels (1/255). Ends with
    /// status 3 if there is none.
    #[arg(long, value_name = "rmse", value_parser = number(NOT_NEGATIVE), requires = "error_report")]
    pub target: Option<f64>,

    /// Prints counters and times after rendering.
    ///
    /// With this flag all rays of the course's program are traced, and its tests and steps are counted.
    #[arg(long, group = "usual")]
    pub stats: bool,

    /// Renders n times, 1 to 10000, and prints the least time, the median and the spread (maximum minus minimum).
    ///
    /// With -stats the time includes the rays that only the course's program casts, and the counting. Pictures are
    /// written once.
    #[arg(long, value_name = "n", value_parser = value_parser!(u32).range(1..=10_000))]
    pub repeat: Option<u32>,

    /// Draws the cost of each pixel as a heat map. The kind is rays, tests or cells, as -stats counts them.
    ///
    /// Example: raytracer -input scene.txt -grid 20 20 20 -cost_map tests cost.png
    #[arg(long, num_args = 2..=3, value_names = ["kind", "picture", "format"])]
    pub cost_map: Option<Vec<OsString>>,

    /// Prints the rays behind one pixel, and what each of them hits. The top left pixel is 0 0.
    ///
    /// Example: raytracer -input scene.txt -size 200 200 -shadows -pixel 100 160
    #[arg(long, num_args = 2, value_names = ["x", "y"], value_parser = value_parser!(u16))]
    #[arg(conflicts_with = "visualize_grid", requires = "input")]
    pub pixel: Option<Vec<u16>>,

    /// Renders, then shows the scene as a live page in the browser. Needs a terminal, or -port.
    #[arg(long, group = "usual")]
    pub gui: bool,

    /// Serves the page of -gui at this port of 127.0.0.1, also without a terminal. 0 is any free port.
    #[arg(long, value_name = "n", value_parser = value_parser!(u16), requires = "gui")]
    pub port: Option<u16>,

    /// Prints the page's address and opens no browser.
    #[arg(long, requires = "gui")]
    pub no_browser: bool,

    /// Accepted from the course; changes nothing.
    #[arg(long, num_args = 2, value_names = ["a", "b"], value_parser = value_parser!(u32).range(1..=MAX_INT))]
    pub tessellation: Option<Vec<u32>>,

    /// Accepted from the course; changes nothing.
    #[arg(long)]
    pub gouraud: bool,

    /// Accepted from Aalto's edition, whose program ignores it; changes nothing.
    #[arg(long)]
    pub specular_fix: bool,

    /// Writes everything that the run reports to a .json file; - writes it to standard output instead of the text.
    #[arg(long, value_name = "document")]
    #[arg(value_parser = path(|path| is_stdio(path) || has_ending(path, "json"), "must be - or end in .json"))]
    pub json: Option<PathBuf>,

    /// Renders with n threads, 1 to 4096. Default: one per core. The picture stays the same.
    ///
    /// By default, short work starts on one thread, and the others join if it lasts.
    #[arg(long, value_name = "n", value_parser = RangedU64ValueParser::<usize>::new().range(1..=MAX_THREADS))]
    pub threads: Option<usize>,

    /// Prints the progress every ten seconds if standard error is not a terminal. A terminal shows it anyway, after one
    /// second.
    #[arg(long, alias = "show_progress", conflicts_with = "quiet")]
    pub progress: bool,

    /// Prints neither the progress nor, on a terminal, the names of the files written.
    #[arg(long)]
    pub quiet: bool,

    /// Treats warnings as errors: the run ends with status 1 and writes no picture.
    #[arg(long)]
    pub strict: bool,

    /// Prints the ten most common flags.
    #[arg(long)]
    h: bool,

    /// Lists all flags. -help size explains a flag, and -help shadow lists the flags with this word.
    #[arg(long)]
    help: bool,

    /// Prints the version.
    #[arg(long, action = ArgAction::Version)]
    version: Option<bool>,
}

/// Names in other programs. They are not accepted: the error names the flag.
const ELSEWHERE: [(&str, &[&str]); 11] = [
    ("input", &["i", "f", "in", "file", "scene"]),
    ("output", &["o", "out", "outfile", "image", "format"]),
    ("size", &["w", "width", "height", "s", "res", "resolution", "dimensions"]),
    ("shade_back", &["two_sided", "double_sided"]),
    ("bounces", &["b", "d", "reflections", "max_depth", "max_bounces", "recursion"]),
    (
        "jittered_samples",
        &["aa", "antialias", "antialiasing", "supersample", "supersampling", "msaa", "samples", "spp", "n"],
    ),
    ("compare", &["diff"]),
    ("stats", &["v", "verbose", "time", "timing", "benchmark"]),
    ("threads", &["j", "t", "jobs", "cores", "nthreads"]),
    ("quiet", &["q", "silent"]),
    ("gui", &["preview", "window", "interactive", "live"]),
];

/// Returns the flag that another program calls `name`.
pub(super) fn meant(name: &str) -> Option<&'static str> {
    let name = name.to_lowercase();
    ELSEWHERE.iter().find(|(_, names)| names.contains(&name.as_str())).map(|(flag, _)| *flag)
}

/// Returns all flags, as clap knows them. Each may be given once, and a value may be a negative number.
pub fn command() -> clap::Command {
    let groups = HEADINGS.map(|(_, heading)| ArgGroup::new(heading).multiple(true));
    let mut heading = "";
    Flags::command().groups(groups).mut_args(|flag| {
        if let Some((_, next)) = HEADINGS.iter().find(|(first, _)| flag.get_id() == first) {
            heading = next;
        }
        let flag = flag.help_heading(heading).group(heading);
        match flag.get_action() {
            ArgAction::Set | ArgAction::Append => flag.action(ArgAction::Set).allow_negative_numbers(true),
            _ => flag,
        }
    })
}

/// Returns true if the flag shapes the colour picture.
pub(super) fn shapes(flag: &Arg) -> bool {
    let names = [Some(flag.get_id().as_str()), flag.get_help_heading()];
    names.into_iter().flatten().any(|name| SHAPING.contains(&name))
}

/// Returns the flag called `name`, by any of its spellings.
pub(super) fn find(name: &str) -> Option<Arg> {
    let mut command = command();
    command.build();
    let is_alias = |flag: &Arg| flag.get_all_aliases().is_some_and(|names| names.contains(&name));
    command.get_arguments().find(|flag| flag.get_id() == name || is_alias(flag)).cloned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clap_finds_no_fault() {
        command().debug_assert();
    }

    #[test]
    fn every_example_is_a_command_line_with_its_flag() {
        let mut examples = 0;
        for flag in command().get_arguments() {
            let help = flag.get_long_help().map(ToString::to_string).unwrap_or_default();
            for line in help.lines().filter_map(|line| line.strip_prefix("Example: ")) {
                let parsed = crate::cli::parse(line.split(' ').map(Into::into));
                assert!(
                    parsed.is_ok() && line.contains(&format!(" -{} ", flag.get_id())),
                    "{line}: {parsed:?}"
                );
                examples += 1;
            }
        }
        assert!(examples > 10);
    }

    #[test]
    fn no_flag_has_a_name_that_another_program_gives_to_another_one() {
        let others: Vec<&str> = ELSEWHERE.iter().flat_map(|(_, names)| *names).copied().collect();
        for (index, name) in others.iter().enumerate() {
            assert!(find(name).is_none() && !others[..index].contains(name), "{name}");
        }
        ELSEWHERE.iter().for_each(|(flag, _)| assert!(find(flag).is_some(), "{flag}"));
    }
}
