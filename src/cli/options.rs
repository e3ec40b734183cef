//! The options of a run that renders or compares: the flags, checked together.

use super::error::{fail, value};
use super::flags::{Flags, MAX_INT};
use super::outputs::{Output, outputs};
use super::values::{NOT_NEGATIVE, Sides, json_target, lossy_or_null, number, picture};
use crate::base::memory::Bytes;
use crate::caster::choose::{Resolution, Structure};
use crate::diagnostic::Diagnostic;
use crate::image_io::{Format, ReadFile};
use crate::render::adaptive::Adaptive;
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Request, Tracing, Window};
use crate::sampling::blur::{REDUCTION, reduced};
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::edition::Edition;
use crate::scene::load::{Hints, LoadedScene, load_with};
use crate::tools::compare::Tolerance;
use crate::trace::{Effects, Shadows};
use clap::value_parser;
use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The number of cells stays below this, so that the index of a cell fits into 32 bits.
const CELL_LIMIT: u128 = 1 << 31;

/// The checked options of a run that renders or compares.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// The scene file, or `-` for standard input. None only if two pictures are compared that need no scene.
    #[serde(serialize_with = "lossy_or_null")]
    pub input: Option<PathBuf>,
    /// The pictures to write, in the order of the help.
    pub outputs: Vec<Output>,
    /// Width and height in pixels, 1 to 65535 each.
    pub size: [usize; 2],
    /// The part of every picture that is rendered; none for the whole. It lies in the picture.
    pub region: Option<Window>,
    /// The edition of the course; none until the scene's words have been read.
    pub edition: Option<Edition>,
    /// Shows the places of pixels in place of the scene.
    pub uv: bool,
    /// Renders three times the width and height.
    pub jitter: bool,
    /// Blurs the picture and reduces it to a third.
    pub reduced: bool,
    pub effects: Effects,
    /// The flags whose meaning or default depends on the edition.
    #[serde(skip)]
    pub given: Given,
    pub sampler: Sampler,
    /// Takes more samples in a pixel where its first four disagree.
    pub adaptive: Option<Adaptive>,
    pub filter: Filter,
    /// A grid has at least one cell along each axis, and less than 2^31 cells in all.
    pub structure: Structure,
    /// Draws the grid's cells in place of the scene. There is a grid if so.
    pub visualize_grid: bool,
    pub comparison: Option<ComparisonOptions>,
    pub stats: bool,
    /// The number of renderings, 1 to 10000, if their times are to be compared.
    pub repeat: Option<u32>,
    /// Treats warnings as errors.
    pub strict: bool,
    /// The file for a JSON document of everything that is reported; `-` prints it in place of the text.
    #[serde(serialize_with = "json_target")]
    pub json: Option<PathBuf>,
    /// The pixel to explain, by column and row from the top left. It lies in the picture.
    pub pixel: Option<[usize; 2]>,
    /// True if one of the flags of the course's preview is given.
    pub preview: bool,
    /// The live page, if `-gui` asks for it.
    pub page: Option<LivePage>,
    /// The number of threads, 1 to 4096; `None` for all cores.
    pub threads: Option<usize>,
    pub progress: ShowProgress,
}

/// Flags as they are given, before the edition is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    pub bounces: Option<u32>,
    pub weight: Option<f64>,
    pub uniform_samples: bool,
}

/// The live page that `-gui` asks for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LivePage {
    /// The port to serve it at, where 0 is any free one; `None` for any free port, and only on a terminal.
    pub port: Option<u16>,
    /// Opens a browser.
    pub browser: bool,
    /// The flags of the command line that shape the colour picture, with their values. No word is the name of a file.
    #[serde(skip)]
    pub words: Vec<String>,
}

/// A comparison of two pictures. A picture without a file is rendered; at least one has a file.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparisonOptions {
    /// The picture in question.
    #[serde(serialize_with = "lossy_or_null")]
    pub picture: Option<PathBuf>,
    #[serde(serialize_with = "lossy_or_null")]
    pub reference: Option<PathBuf>,
    /// The file of the picture that shows the difference.
    #[serde(serialize_with = "lossy_or_null")]
    pub difference: Option<PathBuf>,
    /// The difference that still passes; none if any passes.
    pub tolerance: Option<Tolerance>,
}

impl ComparisonOptions {
    fn new(flags: &Flags) -> Result<Option<Self>, Diagnostic> {
        if flags.compare.is_none() && flags.reference.is_none() {
            return Ok(None);
        }
        // clap does not check this value, since it is a folder for `-grade`.
        let reference = flags.reference.as_ref();
        let reference = reference.map(|path| value("reference", path.as_os_str(), picture())).transpose()?;
        let (picture, difference) = (flags.compare.clone(), flags.difference.clone());
        let tolerance = tolerance(flags)?;
        let comparison = Self { picture, reference, difference, tolerance };
        match tolerance {
            Some(Tolerance { levels, .. }) if levels > 255.0 && !comparison.has_only_numbers() => {
                fail(format!("-tolerance: {levels} is above 255 levels"))
            }
            _ => Ok(Some(comparison)),
        }
    }

    /// Returns true if all pictures with a file are of floating-point numbers.
    fn has_only_numbers(&self) -> bool {
        let is_float = |file: &PathBuf| Format::of_input(file).is_some_and(Format::is_float);
        self.picture.iter().chain(&self.reference).all(is_float)
    }

    /// Returns true if one of the pictures is to be rendered.
    pub fn needs_scene(&self) -> bool {
        self.picture.is_none() || self.reference.is_none()
    }
}

/// When progress is shown on standard error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShowProgress {
    OnTerminal,
    Always,
    Never,
}

impl ShowProgress {
    pub(super) fn new(flags: &Flags) -> Self {
        match (flags.progress, flags.quiet) {
            (_, true) => Self::Never,
            (true, false) => Self::Always,
            (false, false) => Self::OnTerminal,
        }
    }
}

impl Options {
    /// Checks the flags together. `words` are the flags that the live page begins with.
    pub(super) fn new(flags: Flags, words: Vec<String>) -> Result<Self, Diagnostic> {
        let triples = flags.edition != Some(Edition::Y2019);
        let size = size(&flags.size)?;
        let options = Self {
            outputs: outputs(&flags, size)?,
            size,
            region: flags.region.as_deref().map(region).transpose()?,
            edition: edition(&flags)?,
            uv: flags.uv,
            // The program of 2019 accepts both flags and does nothing.
            jitter: flags.jitter && triples,
            reduced: flags.filter && triples,
            effects: Effects {
                shadows: match (flags.transparent_shadows, flags.shadows) {
                    (true, _) => Shadows::Transparent,
                    (false, true) => Shadows::Opaque,
                    (false, false) => Shadows::None,
                },
                shade_back: flags.shade_back,
                bounces: flags.bounces.unwrap_or(0),
                min_weight: flags.weight.unwrap_or(0.0),
            },
            given: Given {
                bounces: flags.bounces,
                weight: flags.weight,
                uniform_samples: flags.uniform_samples.is_some(),
            },
            sampler: sampler(&flags, triples),
            adaptive: adaptive(&flags)?,
            filter: filter(&flags),
            structure: flags.grid.as_deref().map_or(Ok(Structure::Any), structure)?,
            visualize_grid: flags.visualize_grid,
            comparison: ComparisonOptions::new(&flags)?,
            stats: flags.stats,
            repeat: flags.repeat,
            strict: flags.strict,
            pixel: flags.pixel.as_deref().map(|place| [0, 1].map(|axis| place[axis].into())),
            preview: flags.gui || flags.tessellation.is_some() || flags.gouraud,
            page: flags.gui.then_some(LivePage { port: flags.port, browser: !flags.no_browser, words }),
            threads: flags.threads,
            progress: ShowProgress::new(&flags),
            json: flags.json,
            input: flags.input,
        };
        options.check_together()?;
        Ok(options)
    }

    /// Settles the options that depend on the edition, which is known once the scene is read.
    #[must_use]
    pub fn in_edition(&self, edition: Edition) -> Self {
        let mut options = self.clone();
        options.edition = Some(edition);
        options.effects.bounces = self.given.bounces.unwrap_or(edition.default_bounces());
        options.effects.min_weight = self.given.weight.unwrap_or(edition.default_weight());
        if self.given.uniform_samples && edition == Edition::Aalto {
            options.sampler = Sampler::new(Pattern::Random, self.sampler.count(), self.sampler.rng());
        }
        options
    }

    /// Reads the scene with the files that it names.
    pub fn load_scene(&self) -> Result<LoadedScene, Diagnostic> {
        load_with(self.input.as_deref().unwrap_or(Path::new("")), &self.hints())
    }

    /// Returns what the flags say about the scene.
    pub fn hints(&self) -> Hints {
        Hints { edition: self.edition, shows_places: self.uv }
    }

    fn check_together(&self) -> Result<(), Diagnostic> {
        let [width, height] = self.picture_size();
        if width == 0 || height == 0 {
            return fail("-filter needs at least 3 x 3 pixels: use a larger -size");
        }
        if self.region.is_some_and(|part| part.x + part.width > width || part.y + part.height > height) {
            return fail(format!("-region reaches beyond the picture of {width} x {height} pixels"));
        }
        if self.pixel.is_some_and(|[x, y]| x >= width || y >= height) {
            let [last_column, last_row] = [width - 1, height - 1];
            return fail(format!(
                "-pixel: outside the picture, whose columns are 0 to {last_column} and rows 0 to {last_row}"
            ));
        }
        if self.visualize_grid && !matches!(self.structure, Structure::Grid(_)) {
            return fail("-visualize_grid needs a grid, as in '-grid 20 20 20'");
        }
        let needs_scene = self.comparison.as_ref().is_some_and(ComparisonOptions::needs_scene);
        match self.compared_layer() {
            None if needs_scene => {
                return fail(
                    "-compare and -reference compare one picture, and several are written: give -output too, which is \
                     compared then, or write only one of them",
                );
            }
            Some(Layer::Cost(_)) if needs_scene => {
                return fail(
                    "-compare and -reference do not compare a cost map, which shows work in false colours beside a \
                     scale: give -output too, which is compared then, or leave out -cost_map",
                );
            }
            _ => {}
        }
        if self.written().filter(|file| *file == Path::new("-")).count() > 1 {
            return fail("only one of the pictures and -json can go to standard output");
        }
        Ok(())
    }

    /// The scene and the compared pictures, without the files that the scene names.
    pub fn files(&self) -> impl Iterator<Item = ReadFile> {
        let compared = self.comparison.iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        let pictures = compared.flatten().map(|picture| ("picture", picture.clone()));
        self.input.iter().map(|input| ("scene", input.clone())).chain(pictures)
    }

    /// The names of the pictures to write, where `-` is standard output.
    pub fn pictures(&self) -> impl Iterator<Item = &Path> {
        let difference = self.comparison.as_ref().and_then(|comparison| comparison.difference.as_deref());
        self.outputs.iter().map(|output| output.file.as_path()).chain(difference)
    }

    /// The names of all files to write.
    pub fn written(&self) -> impl Iterator<Item = &Path> {
        self.pictures().chain(self.json.as_deref())
    }

    /// Returns true if the JSON document is printed in place of the text.
    pub fn prints_json(&self) -> bool {
        self.json.as_deref() == Some(Path::new("-"))
    }

    /// Returns true if there is a text to print.
    pub fn has_text(&self) -> bool {
        let counts = self.tracing() == Tracing::Counted;
        counts || self.repeat.is_some() || self.pixel.is_some() || self.comparison.is_some()
    }

    /// Returns how the picture is traced: counted if counts are shown.
    pub fn tracing(&self) -> Tracing {
        let counts = self.stats || self.outputs.iter().any(|output| matches!(output.layer, Layer::Cost(_)));
        if counts { Tracing::Counted } else { Tracing::Fast }
    }

    pub fn prepare<'r>(&self, renderer: &'r Renderer, request: &Request) -> Result<Prepared<'r>, Diagnostic> {
        renderer.prepare(request).map_err(|error| match request.structure {
            Structure::Grid(Resolution::Cells(cells)) => {
                // Each cell has an entry, and a few lists are of the same length while the grid is built.
                let bytes = cells.iter().fold(4u64, |bytes, &n| bytes.saturating_mul(n as u64));
                Diagnostic::error(format!("{error}; the entries of its cells alone are {}", Bytes(bytes)))
            }
            _ => error.into(),
        })
    }

    /// Returns the rendered layer that is compared: the layer of the only picture that is written, or else the colours
    /// if they are written or nothing is.
    pub fn compared_layer(&self) -> Option<Layer> {
        match self.compared_output() {
            None => self.outputs.is_empty().then_some(Layer::Color),
            Some(output) => Some(output.layer),
        }
    }

    fn compared_output(&self) -> Option<&Output> {
        match self.outputs.as_slice() {
            [only] => Some(only),
            several => several.iter().find(|output| output.layer == Layer::Color),
        }
    }

    /// Returns true if numbers are compared: all files have them, and a rendered picture is not written in bytes.
    pub fn compares_numbers(&self) -> bool {
        let is_float = || self.compared_output().is_none_or(|output| output.format.is_float());
        let wanted = self.comparison.as_ref().filter(|wanted| wanted.has_only_numbers());
        wanted.is_some_and(|wanted| !wanted.needs_scene() || is_float())
    }

    /// Width and height of the colour picture.
    pub fn picture_size(&self) -> [usize; 2] {
        match (self.jitter, self.reduced) {
            (true, false) => self.size.map(|n| n * REDUCTION),
            (false, true) => reduced(self.size),
            _ => self.size,
        }
    }

    pub fn request(&self) -> Request {
        let has_float_colors = |output: &Output| output.layer == Layer::Color && output.format.is_float();
        Request {
            size: if self.jitter { self.size.map(|n| n * REDUCTION) } else { self.size },
            window: self.region,
            camera: None,
            effects: self.effects,
            sampler: self.sampler,
            adaptive: self.adaptive,
            has_floats: self.outputs.iter().any(has_float_colors)
                || self.comparison.as_ref().is_some_and(ComparisonOptions::needs_scene)
                    && self.compares_numbers()
                    && self.compared_layer() == Some(Layer::Color),
            filter: self.filter,
            is_reduced: self.reduced,
            layers: self.outputs.iter().map(|output| output.layer).collect(),
            structure: self.structure,
            tracing: self.tracing(),
            draws_cells: self.visualize_grid,
        }
    }
}

/// Returns the edition of `-edition`, or the one that another flag implies.
fn edition(flags: &Flags) -> Result<Option<Edition>, Diagnostic> {
    let flags_of_editions = [
        ("jitter", flags.jitter, Edition::Y2012A5),
        ("filter", flags.filter, Edition::Y2012A5),
        ("regular_samples", flags.regular_samples.is_some(), Edition::Aalto),
        ("uv", flags.uv, Edition::Aalto),
    ];
    let mut named = flags.edition;
    for (flag, is_given, edition) in flags_of_editions {
        // The program of 2019 accepts all of them and does nothing.
        if is_given && named != Some(Edition::Y2019) {
            let named = *named.get_or_insert(edition);
            if named != edition {
                return fail(format!("-{flag} is a flag of the edition {edition}, not of {named}"));
            }
        }
    }
    Ok(named)
}

fn size(values: &[Sides]) -> Result<[usize; 2], Diagnostic> {
    match values.concat()[..] {
        [width, height] => Ok([width, height]),
        ref sides => fail(format!("-size takes 2 values, as in '-size 200 200'; {} given", sides.len())),
    }
}

pub(super) fn region(values: &[u16]) -> Result<Window, Diagnostic> {
    match *values {
        [x, y, width, height] if width > 0 && height > 0 => {
            let [x, y, width, height] = [x, y, width, height].map(usize::from);
            Ok(Window { x, y, width, height })
        }
        _ => fail("-region: width and height must be at least 1"),
    }
}

fn sampler(flags: &Flags, triples: bool) -> Sampler {
    let rng = flags.seed.map_or(Drand48::UNSEEDED, Drand48::seeded);
    let given = [
        (Pattern::Random, flags.random_samples),
        (Pattern::Uniform, flags.uniform_samples.or(flags.regular_samples)),
        (Pattern::Jittered, flags.jittered_samples),
        (Pattern::Sobol, flags.sobol_samples),
    ];
    match given.into_iter().find_map(|(pattern, count)| Some((pattern, count?))) {
        Some((pattern, count)) => Sampler::new(pattern, count, rng),
        None if flags.jitter && triples => Sampler::DISPLACED,
        None if flags.adaptive_samples.is_some() => Sampler::of_adaptive(rng),
        None => Sampler::new(Pattern::Uniform, 1, rng),
    }
}

pub(super) fn tolerance(flags: &Flags) -> Result<Option<Tolerance>, Diagnostic> {
    let Some([levels, pixels]) = flags.tolerance.as_deref() else { return Ok(None) };
    Ok(Some(Tolerance {
        levels: value("tolerance", levels, number(NOT_NEGATIVE))?,
        pixels: value("tolerance", pixels, value_parser!(u32))?.into(),
    }))
}

fn adaptive(flags: &Flags) -> Result<Option<Adaptive>, Diagnostic> {
    let Some([most, error]) = flags.adaptive_samples.as_deref() else { return Ok(None) };
    let counts = i64::from(Adaptive::BASE)..=i64::from(Adaptive::LIMIT);
    Ok(Some(Adaptive {
        most: value("adaptive_samples", most, value_parser!(u32).range(counts))?,
        error: value("adaptive_samples", error, number(NOT_NEGATIVE))?,
    }))
}

fn filter(flags: &Flags) -> Filter {
    let tent = flags.tent_filter.map(|radius| Filter::Tent { radius });
    let gaussian = flags.gaussian_filter.map(|sigma| Filter::Gaussian { sigma });
    let mitchell = flags.mitchell_filter.map(|radius| Filter::Mitchell { radius });
    tent.or(gaussian).or(mitchell).unwrap_or(Filter::Box { radius: flags.box_filter })
}

fn structure(values: &[OsString]) -> Result<Structure, Diagnostic> {
    let [x, y, z] = match values {
        [word] if word == "auto" => return Ok(Structure::Grid(Resolution::Auto)),
        [word] if word == "none" => return Ok(Structure::List),
        [x, y, z] => [x, y, z].map(|word| value("grid", word, value_parser!(u32).range(1..=MAX_INT))),
        _ => return fail("-grid takes 3 values, as in '-grid 20 20 20', or 'auto' or 'none'"),
    };
    let [x, y, z] = [x?, y?, z?];
    if [x, y, z].map(u128::from).iter().product::<u128>() >= CELL_LIMIT {
        return fail(format!("-grid: {x} x {y} x {z} cells are more than 2147483647"));
    }
    Ok(Structure::Grid(Resolution::Cells([x, y, z].map(|n| n as usize))))
}
