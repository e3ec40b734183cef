//! Tables of valid command lines, each with its options.

use raytracer::caster::choose::{Resolution, Structure};
use raytracer::cli::{Command, ComparisonOptions, Given, LivePage, Options, Output, ShowProgress, parse};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::Format;
use raytracer::render::adaptive::Adaptive;
use raytracer::render::{Layer, Window};
use raytracer::sampling::drand48::Drand48;
use raytracer::sampling::filter::Filter;
use raytracer::sampling::sampler::{Pattern, Sampler};
use raytracer::tools::compare::Tolerance;
use raytracer::trace::{Effects, Shadows};
use std::ffi::OsString;
#[cfg(unix)]
use std::os::unix::ffi::OsStringExt;
use std::path::{Path, PathBuf};

/// Parses a line in the course's style, without the program's name.
pub fn parse_line(line: &str) -> Result<Command, Diagnostic> {
    parse(["raytracer"].into_iter().chain(line.split_whitespace()).map(OsString::from))
}

fn none() -> Effects {
    Effects { shadows: Shadows::None, shade_back: false, bounces: 0, min_weight: 0.0 }
}

fn with_effects(effects: Effects) -> Options {
    Options { effects, ..plain() }
}

/// The options of `-input s.txt` alone.
fn plain() -> Options {
    Options {
        input: Some("s.txt".into()),
        outputs: vec![],
        size: [100, 100],
        region: None,
        edition: None,
        uv: false,
        jitter: false,
        reduced: false,
        given: Given::default(),
        effects: none(),
        sampler: Sampler::CENTER,
        filter: Filter::Box { radius: 0.5 },
        adaptive: None,
        structure: Structure::Any,
        visualize_grid: false,
        comparison: None,
        stats: false,
        repeat: None,
        strict: false,
        pixel: None,
        json: None,
        preview: false,
        page: None,
        threads: None,
        progress: ShowProgress::OnTerminal,
    }
}

/// The page of `-gui` alone.
fn page() -> LivePage {
    LivePage { port: None, browser: true, words: vec![] }
}

fn output(name: &str, layer: Layer) -> Output {
    Output { layer, file: name.into(), format: Format::of(Path::new(name)).expect("a known ending") }
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
    accepts("-input s.txt -progress", Options { progress: ShowProgress::Always, ..plain() });
    accepts("-quiet -input s.txt", Options { progress: ShowProgress::Never, ..plain() });
    let region = Some(Window { x: 90, y: 0, width: 10, height: 100 });
    accepts("-input s.txt -region 90 0 10 100", Options { region, ..plain() });
    accepts(
        "-input s.txt -normal n.tga",
        Options { outputs: vec![output("n.tga", Layer::Normals)], ..plain() },
    );
    accepts("-shade_back -input s.txt", with_effects(Effects { shade_back: true, ..none() }));
    accepts("-input s.txt -no_shadows", plain());
    accepts("-input s.txt -shadows", with_effects(Effects { shadows: Shadows::Opaque, ..none() }));
    let transparent = with_effects(Effects { shadows: Shadows::Transparent, ..none() });
    accepts("-input s.txt -transparent_shadows", transparent.clone());
    accepts("-input s.txt -transparent_shadows -shadows", transparent);
    let bounces = with_effects(Effects { bounces: 2147483647, ..none() });
    accepts(
        "-input s.txt -bounces 2147483647",
        Options { given: Given { bounces: Some(2147483647), ..Given::default() }, ..bounces },
    );
    let weight = with_effects(Effects { min_weight: 0.01, ..none() });
    let given = Given { weight: Some(0.01), ..Given::default() };
    accepts("-input s.txt -weight 0.01", Options { given, ..weight });
    accepts("-input s.txt -grid auto", Options { structure: Structure::Grid(Resolution::Auto), ..plain() });
    accepts("-input s.txt -grid none", Options { structure: Structure::List, ..plain() });
    accepts(
        "-input s.txt -grid 10 +20 5",
        Options { structure: Structure::Grid(Resolution::Cells([10, 20, 5])), ..plain() },
    );
    accepts(
        "-visualize_grid -input s.txt -grid 1 1 7",
        Options { structure: Structure::Grid(Resolution::Cells([1, 1, 7])), visualize_grid: true, ..plain() },
    );
    accepts("-input s.txt -stats", Options { stats: true, ..plain() });
    accepts("-input s.txt -size 200x150", Options { size: [200, 150], ..plain() });
    accepts("-input s.txt -repeat 10000", Options { repeat: Some(10_000), ..plain() });
    accepts("-input s.txt -strict", Options { strict: true, ..plain() });
    accepts("-input s.txt -pixel 0 99", Options { pixel: Some([0, 99]), ..plain() });
    accepts("-input s.txt -threads 2", Options { threads: Some(2), ..plain() });
    accepts("--input s.txt --stats", Options { stats: true, ..plain() });
    accepts("-input=s.txt -repeat=3 --", Options { repeat: Some(3), ..plain() });
}

#[test]
fn comparisons() {
    let file = |name: &str| Some(PathBuf::from(name));
    let mine =
        ComparisonOptions { picture: file("a.tga"), reference: None, difference: None, tolerance: None };
    accepts("-input s.txt -compare a.tga", Options { comparison: Some(mine.clone()), ..plain() });
    let both = ComparisonOptions {
        reference: file("b.PNG"),
        difference: file("d.png"),
        tolerance: Some(Tolerance { levels: 2.0, pixels: 4294967295 }),
        ..mine
    };
    accepts(
        "-tolerance 2 4294967295 -difference d.png -reference b.PNG -compare a.tga",
        Options { input: None, comparison: Some(both), ..plain() },
    );
    let theirs =
        ComparisonOptions { picture: None, reference: file("b.tga"), difference: None, tolerance: None };
    accepts("-input s.txt -reference b.tga", Options { comparison: Some(theirs), ..plain() });
}

#[test]
fn each_sampler_and_its_count() {
    let sampled = |pattern, count, rng| Options { sampler: Sampler::new(pattern, count, rng), ..plain() };
    let unseeded = Drand48::UNSEEDED;
    accepts("-input s.txt -random_samples 9", sampled(Pattern::Random, 9, unseeded));
    let uniform = |options| Options { given: Given { uniform_samples: true, ..Given::default() }, ..options };
    accepts("-uniform_samples 4 -input s.txt", uniform(sampled(Pattern::Uniform, 4, unseeded)));
    accepts("-input s.txt -jittered_samples 16", sampled(Pattern::Jittered, 16, unseeded));
    accepts("-input s.txt -sobol_samples 7", sampled(Pattern::Sobol, 7, unseeded));
    let adaptive = |most, error| Options {
        sampler: Sampler::of_adaptive(unseeded),
        adaptive: Some(Adaptive { most, error }),
        ..plain()
    };
    accepts("-input s.txt -adaptive_samples 1024 0", adaptive(1024, 0.0));
    accepts("-input s.txt -uniform_samples 1", uniform(plain()));
    accepts("-input s.txt -random_samples 65536", sampled(Pattern::Random, 65536, unseeded));
    accepts(
        "-input s.txt -jittered_samples 4 -seed 4294967295",
        sampled(Pattern::Jittered, 4, Drand48::seeded(u32::MAX)),
    );
    // The state after `srand48(0)` is not that of a program that never seeds.
    assert_ne!(Drand48::seeded(0), unseeded);
    accepts("-input s.txt -random_samples 2 -seed 0", sampled(Pattern::Random, 2, Drand48::seeded(0)));
}

#[test]
fn each_filter_and_its_size() {
    let filtered = |filter| Options { filter, ..plain() };
    accepts("-input s.txt -box_filter .5", plain());
    accepts("-gaussian_filter 0.4 -input s.txt", filtered(Filter::Gaussian { sigma: 0.4 }));
    accepts("-input s.txt -mitchell_filter 2.", filtered(Filter::Mitchell { radius: 2.0 }));
    accepts("-input s.txt -box_filter 1e-6", filtered(Filter::Box { radius: 1e-6 }));
    accepts("-input s.txt -tent_filter 1000000", filtered(Filter::Tent { radius: 1e6 }));
}

#[test]
fn the_enlarged_pictures() {
    accepts(
        "-render_filter f.tga 655 -input s.txt -render_samples s.tga 655",
        Options { outputs: vec![samples(655), output("f.tga", Layer::Filter { zoom: 655 })], ..plain() },
    );
    accepts(
        "-input s.txt -size 1 4369 -render_samples s.tga 15",
        Options { size: [1, 4369], outputs: vec![samples(15)], ..plain() },
    );
}

#[test]
fn negative_numbers_are_values() {
    accepts("-input s.txt -depth -1e3 -1e-3 d.tga", Options { outputs: vec![depth(-1e3, -1e-3)], ..plain() });
    accepts(
        "-input s.txt -depth -3. 0. d.tga -stats",
        Options { outputs: vec![depth(-3.0, 0.0)], stats: true, ..plain() },
    );
    accepts("-input s.txt -output -5.tga", Options { outputs: vec![colors("./-5.tga")], ..plain() });
}

#[test]
fn the_preview_flags_are_recorded() {
    let preview = || Options { preview: true, ..plain() };
    let shown = |page| Options { page: Some(page), ..preview() };
    accepts("-input s.txt -gui", shown(page()));
    accepts("-gouraud -input s.txt", preview());
    accepts("-input s.txt -tessellation 10 5", preview());
    accepts("-input s.txt -gui -port 8080", shown(LivePage { port: Some(8080), ..page() }));
    accepts("-no_browser -input s.txt -gui", shown(LivePage { browser: false, ..page() }));
}

#[test]
fn help_and_version_win_over_what_follows_and_over_a_missing_scene() {
    for line in ["-help", "--help", "-h", "-help -nonsense", "-size 3 3 -help"] {
        assert!(
            matches!(parse_line(line), Ok(Command::Print(text)) if text.contains("Usage: raytracer -input"))
        );
    }
    for line in ["-help size", "-help -size", "-h --size", "-input s.txt -help size -nonsense"] {
        assert!(
            matches!(parse_line(line), Ok(Command::Print(text)) if text.starts_with("  -size <w> [h]\n")),
            "{line}"
        );
    }
    let version = format!("raytracer {}\n", env!("CARGO_PKG_VERSION"));
    assert_eq!(parse_line("-version"), Ok(Command::Print(version)));
}

#[cfg(unix)]
#[test]
fn file_names_need_not_be_utf_8() {
    let name = OsString::from_vec(b"\xff\xfe.tga".to_vec());
    let words = ["raytracer", "-input", "s.txt", "-output"].map(OsString::from);
    let outputs = vec![Output { layer: Layer::Color, file: PathBuf::from(&name), format: Format::Tga }];
    let parsed = parse(words.into_iter().chain([name]));
    assert_eq!(parsed, Ok(Command::Render(Box::new(Options { outputs, ..plain() }))));
}
