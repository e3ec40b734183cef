//! Tables of command lines: what each means, or the exact line that says why it means nothing.

use raytracer::cli::{CliError, Command, Comparison, Options, Output, parse};
use raytracer::compare::Tolerance;
use raytracer::grid::options::Resolution;
use raytracer::render::Layer;
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::trace::{Effects, Shadows};
use std::ffi::OsString;
use std::path::PathBuf;

fn words(line: &str) -> Vec<OsString> {
    line.split_whitespace().map(OsString::from).collect()
}

fn parse_line(line: &str) -> Result<Command, CliError> {
    parse(words(&format!("raytracer {line}")))
}

fn none() -> Effects {
    Effects { shadows: Shadows::None, shade_back: false, bounces: 0, min_weight: 0.0 }
}

fn with_effects(effects: Effects) -> Options {
    Options { effects, ..plain() }
}

fn with_shadows(shadows: Shadows) -> Options {
    with_effects(Effects { shadows, ..none() })
}

/// The options of `-input s.txt` alone.
fn plain() -> Options {
    Options {
        input: Some("s.txt".into()),
        outputs: vec![],
        size: [100, 100],
        effects: none(),
        sampler: Sampler::CENTER,
        filter: Filter::Box { radius: 0.5 },
        grid: None,
        visualize_grid: false,
        comparison: None,
        stats: false,
        preview: false,
        threads: None,
    }
}

fn output(name: &str, layer: Layer) -> Output {
    Output { layer, file: name.into() }
}

fn colors(name: &str) -> Output {
    output(name, Layer::Color)
}

fn depth(near: f64, far: f64) -> Output {
    output("d.tga", Layer::Depth { near, far })
}

fn samples(zoom: usize) -> Output {
    output("s.tga", Layer::Samples { zoom })
}

fn accepts(line: &str, expected: Options) {
    assert_eq!(parse_line(line), Ok(Command::Render(Box::new(expected))), "{line}");
}

#[test]
fn each_flag_sets_its_option() {
    accepts("-input s.txt", plain());
    accepts("-input s.txt -output a.tga", Options { outputs: vec![colors("a.tga")], ..plain() });
    accepts("-output a.PNG -input s.txt", Options { outputs: vec![colors("a.PNG")], ..plain() });
    accepts("-input s.txt -size 3 65535", Options { size: [3, 65535], ..plain() });
    accepts(
        "-input s.txt -normals n.png",
        Options { outputs: vec![output("n.png", Layer::Normals)], ..plain() },
    );
    accepts(
        "-input s.txt -normal n.tga",
        Options { outputs: vec![output("n.tga", Layer::Normals)], ..plain() },
    );
    accepts("-shade_back -input s.txt", with_effects(Effects { shade_back: true, ..none() }));
    accepts("-input s.txt -shadows", with_shadows(Shadows::Opaque));
    accepts("-input s.txt -no_shadows", plain());
    accepts("-input s.txt -transparent_shadows", with_shadows(Shadows::Transparent));
    accepts("-input s.txt -transparent_shadows -shadows", with_shadows(Shadows::Transparent));
    accepts("-input s.txt -bounces 2147483647", with_effects(Effects { bounces: 2147483647, ..none() }));
    accepts("-input s.txt -weight 0.01", with_effects(Effects { min_weight: 0.01, ..none() }));
    accepts("-input s.txt -grid auto", Options { grid: Some(Resolution::Auto), ..plain() });
    accepts("-input s.txt -grid 10 +20 5", Options { grid: Some(Resolution::Cells([10, 20, 5])), ..plain() });
    accepts(
        "-input s.txt -grid 1 2147483647 1",
        Options { grid: Some(Resolution::Cells([1, 2147483647, 1])), ..plain() },
    );
    accepts(
        "-visualize_grid -input s.txt -grid 1 1 7",
        Options { grid: Some(Resolution::Cells([1, 1, 7])), visualize_grid: true, ..plain() },
    );
    accepts("-input s.txt -stats", Options { stats: true, ..plain() });
    accepts("-input s.txt -threads 2", Options { threads: Some(2), ..plain() });
    accepts("--input s.txt --stats", Options { stats: true, ..plain() });
}

#[test]
fn comparisons() {
    let file = |name: &str| Some(PathBuf::from(name));
    let mine = Comparison { picture: file("a.tga"), reference: None, difference: None, tolerance: None };
    accepts("-input s.txt -compare a.tga", Options { comparison: Some(mine.clone()), ..plain() });
    let both = Comparison {
        reference: file("b.PNG"),
        difference: file("d.png"),
        tolerance: Some(Tolerance { levels: 2, pixels: 4294967295 }),
        ..mine
    };
    accepts(
        "-tolerance 2 4294967295 -difference d.png -reference b.PNG -compare a.tga",
        Options { input: None, comparison: Some(both), ..plain() },
    );
    let theirs = Comparison { picture: None, reference: file("b.tga"), difference: None, tolerance: None };
    accepts("-input s.txt -reference b.tga", Options { comparison: Some(theirs), ..plain() });
}

#[test]
fn each_sampler_and_its_count() {
    let sampled = |pattern, count, rng| Options { sampler: Sampler::new(pattern, count, rng), ..plain() };
    let unseeded = Drand48::UNSEEDED;
    accepts("-input s.txt -random_samples 9", sampled(Pattern::Random, 9, unseeded));
    accepts("-uniform_samples 4 -input s.txt", sampled(Pattern::Uniform, 4, unseeded));
    accepts("-input s.txt -jittered_samples 16", sampled(Pattern::Jittered, 16, unseeded));
    accepts("-input s.txt -uniform_samples 7", sampled(Pattern::Uniform, 7, unseeded));
    accepts("-input s.txt -uniform_samples 1", plain());
    accepts("-input s.txt -random_samples 1", sampled(Pattern::Random, 1, unseeded));
    accepts("-input s.txt -random_samples 65536", sampled(Pattern::Random, 65536, unseeded));
    accepts("-seed 7 -input s.txt -random_samples 2", sampled(Pattern::Random, 2, Drand48::seeded(7)));
    accepts(
        "-input s.txt -jittered_samples 4 -seed 4294967295",
        sampled(Pattern::Jittered, 4, Drand48::seeded(u32::MAX)),
    );
    // `srand48(0)` is not the state of a program that never seeds.
    assert_ne!(Drand48::seeded(0), unseeded);
    accepts("-input s.txt -random_samples 2 -seed 0", sampled(Pattern::Random, 2, Drand48::seeded(0)));
}

#[test]
fn each_filter_and_its_size() {
    let filtered = |filter| Options { filter, ..plain() };
    accepts("-input s.txt -box_filter .5", plain());
    accepts("-input s.txt -box_filter 1.7", filtered(Filter::Box { radius: 1.7 }));
    accepts("-input s.txt -tent_filter 2", filtered(Filter::Tent { radius: 2.0 }));
    accepts("-gaussian_filter 0.4 -input s.txt", filtered(Filter::Gaussian { sigma: 0.4 }));
    accepts("-input s.txt -mitchell_filter 2.", filtered(Filter::Mitchell { radius: 2.0 }));
    accepts("-input s.txt -box_filter 1e-6", filtered(Filter::Box { radius: 1e-6 }));
    accepts("-input s.txt -tent_filter 1000000", filtered(Filter::Tent { radius: 1e6 }));
    accepts(
        "-tent_filter 1 -jittered_samples 9 -input s.txt",
        Options {
            filter: Filter::Tent { radius: 1.0 },
            sampler: Sampler::new(Pattern::Jittered, 9, Drand48::UNSEEDED),
            ..plain()
        },
    );
}

#[test]
fn the_enlarged_pictures() {
    accepts("-input s.txt -render_samples s.tga 10", Options { outputs: vec![samples(10)], ..plain() });
    accepts(
        "-input s.txt -render_filter f.png 1",
        Options { outputs: vec![output("f.png", Layer::Filter { zoom: 1 })], ..plain() },
    );
    accepts(
        "-render_filter f.tga 655 -input s.txt -render_samples s.tga 655",
        Options { outputs: vec![samples(655), output("f.tga", Layer::Filter { zoom: 655 })], ..plain() },
    );
    accepts(
        "-input s.txt -size 1 4369 -render_samples s.tga 15",
        Options { size: [1, 4369], outputs: vec![samples(15)], ..plain() },
    );
    accepts(
        "-input s.txt -size 9 9 -render_samples s.tga 15 -random_samples 36",
        Options {
            size: [9, 9],
            outputs: vec![samples(15)],
            sampler: Sampler::new(Pattern::Random, 36, Drand48::UNSEEDED),
            ..plain()
        },
    );
}

#[test]
fn negative_numbers_are_values() {
    accepts("-input s.txt -depth -2 2 d.tga", Options { outputs: vec![depth(-2.0, 2.0)], ..plain() });
    accepts("-depth -.5 .5 d.tga -input s.txt", Options { outputs: vec![depth(-0.5, 0.5)], ..plain() });
    accepts("-input s.txt -depth -1e3 -1e-3 d.tga", Options { outputs: vec![depth(-1e3, -1e-3)], ..plain() });
    accepts(
        "-input s.txt -depth -3. 0. d.tga -stats",
        Options { outputs: vec![depth(-3.0, 0.0)], stats: true, ..plain() },
    );
    accepts("-input s.txt -output -5.tga", Options { outputs: vec![colors("-5.tga")], ..plain() });
}

#[test]
fn the_preview_flags_are_recorded() {
    let preview = || Options { preview: true, ..plain() };
    accepts("-input s.txt -gui", preview());
    accepts("-gouraud -input s.txt", preview());
    accepts("-input s.txt -tessellation 10 5", preview());
    accepts("-input s.txt -gui -tessellation 100 50 -gouraud", preview());
}

#[test]
fn lines_in_the_style_of_the_course() {
    let sized = || Options { size: [200, 200], outputs: vec![colors("o.tga")], ..plain() };
    accepts(
        "-input s.txt -size 200 200 -output o.tga -depth 14.5 19.5 d.tga",
        Options { outputs: vec![colors("o.tga"), depth(14.5, 19.5)], ..sized() },
    );
    accepts(
        "-input s.txt -size 200 200 -output o.tga -depth 9 11 d.tga -normals n.tga -shade_back",
        Options {
            outputs: vec![colors("o.tga"), depth(9.0, 11.0), output("n.tga", Layer::Normals)],
            effects: Effects { shade_back: true, ..none() },
            ..sized()
        },
    );
    accepts(
        "-input s.txt -size 200 200 -output o.tga -gui -tessellation 20 10 -gouraud",
        Options { preview: true, ..sized() },
    );
    accepts(
        "-input s.txt -size 200 200 -output o.tga -shadows -bounces 5 -weight 0.01 -shade_back -gui -tessellation 30 15",
        Options {
            effects: Effects { shadows: Shadows::Opaque, bounces: 5, min_weight: 0.01, shade_back: true },
            preview: true,
            ..sized()
        },
    );
    accepts(
        "-input s.txt -size 200 200 -gui -grid 15 15 15 -visualize_grid -tessellation 10 5",
        Options {
            size: [200, 200],
            grid: Some(Resolution::Cells([15, 15, 15])),
            visualize_grid: true,
            preview: true,
            ..plain()
        },
    );
    accepts(
        "-size 200 200 -input s.txt -output o.tga -grid 20 20 20 -stats",
        Options { grid: Some(Resolution::Cells([20, 20, 20])), stats: true, ..sized() },
    );
}

/// Each line lacks `-input s.txt` only where that is the point.
const FAULTS: &[(&str, &str)] = &[
    ("", "no scene: `-input file` is required (`-help` lists every flag)"),
    ("-output a.tga", "no scene: `-input file` is required (`-help` lists every flag)"),
    ("-input", "`-input` needs a value"),
    ("-input s.tga", "`-input`: `s.tga` does not end in .txt"),
    ("-input txt", "`-input`: `txt` does not end in .txt"),
    ("-input s.txt -shadow", "unknown flag `-shadow`; did you mean `-shadows`?"),
    ("-input s.txt -visualise_grid", "unknown flag `-visualise_grid`; did you mean `-visualize_grid`?"),
    ("-input s.txt --sise 3 3", "unknown flag `-sise`; did you mean `-size`?"),
    ("-input s.txt -Size 3 3", "unknown flag `-Size`; did you mean `-size`?"),
    ("-imput s.txt", "unknown flag `-imput`; did you mean `-input`?"),
    ("-input s.txt -qqq", "unknown flag `-qqq` (`-help` lists every flag)"),
    ("-input s.txt -qqq=3", "unknown flag `-qqq` (`-help` lists every flag)"),
    ("-input=s.txt", "`-input` takes its values as separate words, without `=`"),
    ("-input s.txt -shadows=yes", "`-shadows` takes its values as separate words, without `=`"),
    ("-input s.txt foo", "unexpected word `foo` (not the value of any flag)"),
    ("s.txt", "unexpected word `s.txt` (not the value of any flag)"),
    ("-input s.txt shadows", "unexpected word `shadows`; did you mean `-shadows`?"),
    ("-input s.txt -stats 3", "unexpected word `3` (not the value of any flag)"),
    ("-input s.txt -size 3 4 -5.5", "unexpected word `-5.5` (not the value of any flag)"),
    ("-input s.txt --", "unexpected word `--` (not the value of any flag)"),
    ("-input s.txt -", "unexpected word `-` (not the value of any flag)"),
    ("-input s.txt -output", "`-output` needs a value"),
    ("-input s.txt -output -size 3 3", "`-output` needs a value"),
    ("-input s.txt -output a.jpg", "`-output`: `a.jpg` ends in neither .tga nor .png"),
    ("-input s.txt -output --", "`-output`: `--` ends in neither .tga nor .png"),
    ("-input s.txt -normals tga", "`-normals`: `tga` ends in neither .tga nor .png"),
    ("-input s.txt -size", "`-size` takes 2 values, 0 given"),
    ("-input s.txt -size 3", "`-size` takes 2 values, 1 given"),
    ("-input s.txt -size 3 -stats", "`-size` takes 2 values, 1 given"),
    ("-input s.txt -size abc 3", "`-size`: `abc` is not a whole number"),
    ("-input s.txt -size 3 3.0", "`-size`: `3.0` is not a whole number"),
    ("-input s.txt -size 3 +", "`-size`: `+` is not a whole number"),
    ("-input s.txt -size 0 3", "`-size`: `0` is not between 1 and 65535"),
    ("-input s.txt -size 3 65536", "`-size`: `65536` is not between 1 and 65535"),
    ("-input s.txt -size -3 3", "`-size`: `-3` is not between 1 and 65535"),
    ("-input s.txt -depth 1 2", "`-depth` takes 3 values, 2 given"),
    ("-input s.txt -depth d.tga 1 2", "`-depth`: `d.tga` is not a finite number"),
    ("-input s.txt -depth 1 nan d.tga", "`-depth`: `nan` is not a finite number"),
    ("-input s.txt -depth 1 1e999 d.tga", "`-depth`: `1e999` is not a finite number"),
    ("-input s.txt -depth 2 2 d.tga", "`-depth`: t0 must be less than t1, but 2 >= 2"),
    ("-input s.txt -depth 2 -2 d.tga", "`-depth`: t0 must be less than t1, but 2 >= -2"),
    ("-input s.txt -depth -1e308 1e308 d.tga", "`-depth`: t1 - t0 is too large for a number"),
    ("-input s.txt -depth 1 2 3", "`-depth`: `3` ends in neither .tga nor .png"),
    ("-input s.txt -depth 1 2 a.tga -depth 1 2 b.tga", "`-depth` given twice"),
    ("-input s.txt -input s.txt", "`-input` given twice"),
    ("-input s.txt -stats -stats", "`-stats` given twice"),
    ("-input s.txt -normals a.tga -normal b.tga", "`-normals` given twice"),
    ("-input s.txt -bounces x", "`-bounces`: `x` is not a whole number"),
    ("-input s.txt -bounces -1", "`-bounces`: `-1` is not between 0 and 2147483647"),
    ("-input s.txt -bounces 2147483648", "`-bounces`: `2147483648` is not between 0 and 2147483647"),
    ("-input s.txt -weight -0.1", "`-weight`: `-0.1` is negative"),
    ("-input s.txt -weight infinity", "`-weight`: `infinity` is not a finite number"),
    ("-input s.txt -grid 10", "`-grid` takes 3 values, 1 given"),
    ("-input s.txt -grid 10 10", "`-grid` takes 3 values, 2 given"),
    ("-input s.txt -grid", "`-grid` takes 3 values, 0 given"),
    ("-input s.txt -grid auto 3 3", "`-grid`: `auto` is not a whole number"),
    ("-input s.txt -grid 10 0 10", "`-grid`: `0` is not between 1 and 2147483647"),
    (
        "-input s.txt -grid 2048 1024 1024",
        "`-grid`: 2048 x 1024 x 1024 cells are too many, 2147483647 is the most",
    ),
    (
        "-input s.txt -grid 2147483647 2147483647 2147483647",
        "`-grid`: 2147483647 x 2147483647 x 2147483647 cells are too many, 2147483647 is the most",
    ),
    ("-input s.txt -visualize_grid", "`-visualize_grid` needs `-grid nx ny nz`"),
    ("-input s.txt -shadows -no_shadows", "`-shadows` cannot be combined with `-no_shadows`"),
    ("-input s.txt -no_shadows -shadows", "`-no_shadows` cannot be combined with `-shadows`"),
    (
        "-input s.txt -no_shadows -transparent_shadows",
        "`-no_shadows` cannot be combined with `-transparent_shadows`",
    ),
    (
        "-input s.txt -no_shadows -shadows -transparent_shadows",
        "`-no_shadows` cannot be combined with `-shadows`",
    ),
    ("-input s.txt -random_samples", "`-random_samples` needs a value"),
    ("-input s.txt -random_samples 0", "`-random_samples`: `0` is not between 1 and 65536"),
    ("-input s.txt -random_samples -4", "`-random_samples`: `-4` is not between 1 and 65536"),
    ("-input s.txt -uniform_samples 65537", "`-uniform_samples`: `65537` is not between 1 and 65536"),
    ("-input s.txt -jittered_samples 4.0", "`-jittered_samples`: `4.0` is not a whole number"),
    ("-input s.txt -jittered_samples 4 -jittered_samples 4", "`-jittered_samples` given twice"),
    (
        "-input s.txt -random_samples 4 -uniform_samples 4",
        "`-random_samples` cannot be combined with `-uniform_samples`",
    ),
    (
        "-input s.txt -jittered_samples 4 -random_samples 4",
        "`-jittered_samples` cannot be combined with `-random_samples`",
    ),
    (
        "-input s.txt -uniform_samples 4 -jittered_samples 4",
        "`-uniform_samples` cannot be combined with `-jittered_samples`",
    ),
    ("-input s.txt -uniform_sample 4", "unknown flag `-uniform_sample`; did you mean `-uniform_samples`?"),
    ("-input s.txt -seed", "`-seed` needs a value"),
    ("-input s.txt -seed -1", "`-seed`: `-1` is not between 0 and 4294967295"),
    ("-input s.txt -seed 4294967296", "`-seed`: `4294967296` is not between 0 and 4294967295"),
    ("-input s.txt -seed now", "`-seed`: `now` is not a whole number"),
    ("-input s.txt -box_filter", "`-box_filter` needs a value"),
    ("-input s.txt -box_filter 0", "`-box_filter`: `0` is not between 0.000001 and 1000000 pixels"),
    ("-input s.txt -box_filter -1", "`-box_filter`: `-1` is not between 0.000001 and 1000000 pixels"),
    ("-input s.txt -tent_filter 1e7", "`-tent_filter`: `1e7` is not between 0.000001 and 1000000 pixels"),
    (
        "-input s.txt -gaussian_filter 1e-7",
        "`-gaussian_filter`: `1e-7` is not between 0.000001 and 1000000 pixels",
    ),
    ("-input s.txt -mitchell_filter nan", "`-mitchell_filter`: `nan` is not a finite number"),
    ("-input s.txt -gaussian_filter wide", "`-gaussian_filter`: `wide` is not a finite number"),
    ("-input s.txt -box_filter 1 -tent_filter 1", "`-box_filter` cannot be combined with `-tent_filter`"),
    (
        "-input s.txt -gaussian_filter 1 -tent_filter 1",
        "`-gaussian_filter` cannot be combined with `-tent_filter`",
    ),
    (
        "-input s.txt -gaussian_filter 1 -mitchell_filter 1",
        "`-gaussian_filter` cannot be combined with `-mitchell_filter`",
    ),
    (
        "-input s.txt -mitchell_filter 1 -box_filter 1",
        "`-mitchell_filter` cannot be combined with `-box_filter`",
    ),
    ("-input s.txt -render_samples s.tga", "`-render_samples` takes 2 values, 1 given"),
    ("-input s.txt -render_samples 4 s.tga", "`-render_samples`: `s.tga` is not a whole number"),
    ("-input s.txt -render_samples s.jpg 4", "`-render_samples`: `s.jpg` ends in neither .tga nor .png"),
    ("-input s.txt -render_filter f.tga 0", "`-render_filter`: `0` is not between 1 and 65535"),
    (
        "-input s.txt -render_samples s.tga 656",
        "`-render_samples`: the enlarged picture would be above 65535 pixels a side",
    ),
    (
        "-input s.txt -size 1 4369 -render_filter f.tga 15",
        "`-render_filter`: the enlarged picture would be above 65535 pixels a side",
    ),
    (
        "-input s.txt -render_samples a.tga 4 -output a.tga",
        "`-output` and `-render_samples` both write `a.tga`",
    ),
    (
        "-input s.txt -render_samples a.tga 4 -render_filter ./a.tga 4",
        "`-render_samples` and `-render_filter` both write `a.tga`",
    ),
    ("-compare a.tga", "no scene: `-input file` is required (`-help` lists every flag)"),
    ("-compare a.jpg -reference b.tga", "`-compare`: `a.jpg` ends in neither .tga nor .png"),
    ("-input s.txt -compare", "`-compare` needs a value"),
    ("-input s.txt -difference d.png", "`-difference` needs a picture: `-compare file` or `-reference file`"),
    ("-input s.txt -tolerance 1 2", "`-tolerance` needs a picture: `-compare file` or `-reference file`"),
    ("-compare a.tga -reference b.tga -tolerance 1", "`-tolerance` takes 2 values, 1 given"),
    ("-compare a.tga -reference b.tga -tolerance 256 0", "`-tolerance`: `256` is not between 0 and 255"),
    ("-compare a.tga -reference b.tga -tolerance 0 -1", "`-tolerance`: `-1` is not between 0 and 4294967295"),
    (
        "-input s.txt -output d.tga -compare a.tga -difference ./d.tga",
        "`-output` and `-difference` both write `d.tga`",
    ),
    ("-input s.txt -threads 0", "`-threads`: `0` is not between 1 and 4096"),
    ("-input s.txt -threads all", "`-threads`: `all` is not a whole number"),
    ("-input s.txt -tessellation 10", "`-tessellation` takes 2 values, 1 given"),
    ("-input s.txt -tessellation 10 x", "`-tessellation`: `x` is not a whole number"),
    ("-input s.txt -output a.tga -normals a.tga", "`-output` and `-normals` both write `a.tga`"),
    ("-input s.txt -output ./a.tga -depth 1 2 a.tga", "`-output` and `-depth` both write `./a.tga`"),
    ("-input s.txt -depth 1 2 d/a.tga -normals d/./a.tga", "`-depth` and `-normals` both write `d/a.tga`"),
];

#[test]
fn each_fault_has_its_line() {
    let mut wrong = String::new();
    for (line, expected) in FAULTS {
        let shown = parse_line(line).map_err(|error| error.to_string());
        if shown != Err(expected.to_string()) {
            wrong += &format!("{line}\n  expected {expected}\n  actual   {shown:?}\n");
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The course's lines in `$COURSE_DIR/commands.txt`.
#[test]
fn the_course_s_lines_are_accepted() {
    let Some(course) = std::env::var_os("COURSE_DIR") else {
        return println!("skipped: COURSE_DIR is not set");
    };
    let text = std::fs::read_to_string(PathBuf::from(course).join("commands.txt")).unwrap();
    let lines: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("raytracer ")).collect();
    assert_eq!(lines.len(), 197);
    for line in lines {
        assert!(matches!(parse_line(line), Ok(Command::Render(_))), "{line}: {:?}", parse_line(line));
    }
}

#[test]
fn help_and_version_win_over_what_follows_and_over_a_missing_scene() {
    for line in ["-help", "--help", "-h", "-help -nonsense", "-size 3 3 -help"] {
        assert!(
            matches!(parse_line(line), Ok(Command::Help(text)) if text.contains("Usage: raytracer -input"))
        );
    }
    let version = format!("raytracer {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(parse_line("-version"), Ok(Command::Version(version)));
}

#[test]
fn an_empty_argv_and_empty_words_are_no_accident() {
    let empty: [OsString; 0] = [];
    assert_eq!(parse(empty), Err(CliError::InputNeeded));
    let shown = parse(["raytracer", "-input", ""].map(OsString::from)).map_err(|error| error.to_string());
    assert_eq!(shown, Err("`-input`: `` does not end in .txt".into()));
}

#[test]
fn a_fault_is_one_line_whatever_the_word_holds() {
    for word in ["-a\nb\x1b[1m", "a\nb\r", "shadows\n"] {
        let argv = ["raytracer", "-input", "s.txt", word].map(OsString::from);
        let shown = parse(argv).map_err(|error| error.to_string());
        assert!(shown.as_ref().is_err_and(|line| !line.contains(char::is_control)), "{shown:?}");
    }
}

#[cfg(unix)]
mod not_utf8 {
    use super::*;
    use std::os::unix::ffi::OsStringExt;

    fn parse_bytes(bytes: &[&[u8]]) -> Result<Command, CliError> {
        parse(bytes.iter().map(|word| OsString::from_vec(word.to_vec())))
    }

    #[test]
    fn names_need_not_be_text() {
        let name = b"\xff\xfe.tga";
        let parsed = parse_bytes(&[b"raytracer", b"-input", b"s.txt", b"-output", name]);
        let file = PathBuf::from(OsString::from_vec(name.to_vec()));
        let outputs = vec![Output { layer: Layer::Color, file }];
        assert_eq!(parsed, Ok(Command::Render(Box::new(Options { outputs, ..plain() }))));
    }

    #[test]
    fn flags_and_numbers_must_be() {
        let flag = parse_bytes(&[b"raytracer", b"-z\xff"]);
        let shown = flag.map_err(|error| error.to_string());
        assert_eq!(shown, Err("unknown flag `-z\u{fffd}` (`-help` lists every flag)".into()));
        let size = parse_bytes(&[b"raytracer", b"-input", b"s.txt", b"-size", b"\xff", b"1"]);
        let shown = size.map_err(|error| error.to_string());
        assert_eq!(shown, Err("`-size`: `\u{fffd}` is not a whole number".into()));
    }
}
