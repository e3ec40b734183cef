//! The second stage of the command line: the values are parsed and checked, each by itself and then together.

use super::comparison::Comparison;
use super::error::CliError;
use super::flag::Flag;
use super::flags;
use super::live_page::LivePage;
use super::outputs::{Output, distinct, outputs};
use super::raw::Raw;
use super::values::{lossy, lossy_or_null};
use crate::caster::choose::Structure;
use crate::render::{Layer, Request, Tracing, Window};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::blur::{REDUCTION, reduced};
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::edition::Edition;
use crate::scene_io::Hints;
use crate::trace::{Effects, Shadows};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The checked options of a run. Every number is in the range that its field states.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// The scene file, or `-` for standard input.
    ///
    /// It is none only if two pictures are compared that need no scene.
    #[serde(serialize_with = "lossy_or_null")]
    pub input: Option<PathBuf>,
    /// The pictures to write, in the order of the help. No two name the same file.
    pub outputs: Vec<Output>,
    /// Width and height in pixels, 1 to 65535 each.
    pub size: [usize; 2],
    /// The part of every picture that is rendered; none for the whole. It lies in the picture.
    pub region: Option<Window>,
    /// The edition of the course; none until the scene's words have been read.
    pub edition: Option<Edition>,
    /// Whether the places of pixels are shown in place of the scene.
    pub uv: bool,
    /// Whether the picture is rendered with three times the width and height.
    pub jitter: bool,
    /// Whether it is blurred and reduced to a third.
    pub reduced: bool,
    /// What is modelled.
    pub effects: Effects,
    /// Whether the number of bounces is the default of the edition.
    #[serde(skip)]
    pub has_default_bounces: bool,
    /// Whether `-bounces 0` is given, which is the default: whoever says it means it.
    #[serde(skip)]
    pub says_no_bounces: bool,
    /// The positions of the samples in a pixel.
    pub sampler: Sampler,
    /// Whether a pixel gets more samples where its first four disagree.
    pub adaptive: Option<Adaptive>,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The acceleration structure. A grid has at least one cell along each axis, and less than 2^31 cells in all.
    pub structure: Structure,
    /// Whether the grid's cells are drawn instead of the scene. There is a grid if so.
    pub visualize_grid: bool,
    /// The comparison of two pictures.
    pub comparison: Option<Comparison>,
    /// Whether statistics are printed.
    pub stats: bool,
    /// How often the scene is rendered, 1 to 10000, if the times are to be compared.
    pub repeat: Option<u32>,
    /// Whether a warning is an error.
    pub strict: bool,
    /// Where everything that is reported goes as a JSON document, if anywhere.
    pub json: Option<JsonTarget>,
    /// The pixel to explain, by column and row from the top left. It lies in the picture.
    pub pixel: Option<[usize; 2]>,
    /// Whether one of the flags of the course's preview is given.
    pub preview: bool,
    /// The live page, if `-gui` asks for it.
    pub page: Option<LivePage>,
    /// The number of threads, 1 to 4096; `None` for all cores.
    pub threads: Option<usize>,
    /// Where progress is shown.
    pub progress: ShowProgress,
}

/// Where a JSON document goes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JsonTarget {
    /// Standard output, in place of the text.
    #[serde(rename = "-")]
    StandardOutput,
    /// A file whose name ends in `.json`.
    #[serde(serialize_with = "lossy")]
    File(PathBuf),
}

/// Where it is shown how far a run has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ShowProgress {
    /// On standard error if that is a terminal.
    OnTerminal,
    /// On standard error.
    Always,
    /// Nowhere.
    Never,
}

impl ShowProgress {
    /// What the flags ask for.
    pub(super) fn from_raw(raw: &Raw) -> Self {
        match (raw.given(&flags::PROGRESS), raw.given(&flags::QUIET)) {
            (_, true) => Self::Never,
            (true, false) => Self::Always,
            (false, false) => Self::OnTerminal,
        }
    }
}

impl Options {
    /// Checks each flag in the order of the help, then the combination of the flags.
    pub(super) fn from_raw(raw: &Raw) -> Result<Self, CliError> {
        let options = Self {
            input: raw.read(&flags::INPUT)?,
            outputs: outputs(raw)?,
            size: raw.read_or_default(&flags::SIZE)?,
            region: raw.read(&flags::REGION)?,
            edition: edition(raw)?,
            uv: raw.given(&flags::UV),
            jitter: three_sizes(raw, &flags::JITTER),
            reduced: three_sizes(raw, &flags::FILTER),
            effects: Effects {
                shadows: shadows(raw),
                shade_back: raw.given(&flags::SHADE_BACK),
                bounces: raw.read_or_default(&flags::BOUNCES)?,
                min_weight: weight(raw)?,
            },
            has_default_bounces: !raw.given(&flags::BOUNCES),
            says_no_bounces: raw.read(&flags::BOUNCES)? == Some(0),
            sampler: sampler(raw)?,
            adaptive: raw.read(&flags::ADAPTIVE_SAMPLES)?,
            filter: filter(raw)?,
            structure: raw.read(&flags::GRID)?.unwrap_or(Structure::Any),
            visualize_grid: raw.given(&flags::VISUALIZE_GRID),
            comparison: Comparison::from_raw(raw)?,
            stats: raw.given(&flags::STATS),
            repeat: raw.read(&flags::REPEAT)?,
            strict: raw.given(&flags::STRICT),
            json: raw.read(&flags::JSON)?,
            pixel: raw.read(&flags::PIXEL)?,
            preview: preview(raw)?,
            page: LivePage::from_raw(raw)?,
            threads: raw.read(&flags::THREADS)?,
            progress: ShowProgress::from_raw(raw),
        };
        options.check_together()?;
        Ok(match options.edition {
            Some(edition) => options.in_edition(edition),
            None => options,
        })
    }

    /// The same options for a scene of this edition, on which some defaults depend.
    #[must_use]
    pub fn in_edition(&self, edition: Edition) -> Self {
        let mut options = self.clone();
        options.edition = Some(edition);
        if self.has_default_bounces {
            options.effects.bounces = edition.default_bounces();
        }
        // In later editions every material with a highlight mirrors if it is asked to, and is not doubtful without; in
        // Aalto's the weight has a default.
        options.says_no_bounces |= edition != Edition::Y2004;
        options
    }

    /// What the flags tell of the scene.
    pub fn hints(&self) -> Hints {
        let ending = |output: &Output| Some(output.file.extension()?.to_string_lossy().into_owned());
        let endings = self.outputs.iter().filter_map(ending).collect();
        Hints { edition: self.edition, endings, shows_places: self.uv }
    }

    fn check_together(&self) -> Result<(), CliError> {
        let needs_scene =
            self.pixel.is_some() || self.comparison.as_ref().is_none_or(Comparison::needs_scene);
        if self.input.is_none() && needs_scene {
            return Err(CliError::InputNeeded);
        }
        if self.picture_size().contains(&0) {
            return Err(CliError::ReducedToNothing);
        }
        let [width, height] = self.picture_size();
        let is_outside =
            |region: Window| region.x + region.width > width || region.y + region.height > height;
        if self.region.is_some_and(is_outside) {
            return Err(CliError::RegionOutside { size: self.size });
        }
        if self.pixel.is_some_and(|[x, y]| x >= width || y >= height) {
            return Err(CliError::PixelOutside { last: [width - 1, height - 1] });
        }
        if self.visualize_grid && !matches!(self.structure, Structure::Grid(_)) {
            return Err(CliError::GridNeeded);
        }
        for output in &self.outputs {
            let [width, height] = output.layer.size(self.size);
            if width.max(height) > flags::SIDE.1 as usize {
                return Err(CliError::EnlargedTooMuch { flag: output.flag().name });
            }
        }
        match (self.outputs.iter().find(|output| output.is_standard_output()), &self.json) {
            (Some(output), Some(JsonTarget::StandardOutput)) => {
                Err(CliError::SameStream { flag: output.flag().name, other: flags::JSON.name })
            }
            _ => distinct(&self.files()),
        }
    }

    /// Whether a picture goes to standard output, so that text has to go elsewhere.
    pub fn has_standard_output(&self) -> bool {
        self.outputs.iter().any(Output::is_standard_output)
    }

    /// The pictures to write, each with the flag that names its file.
    fn files(&self) -> Vec<(&'static Flag, &Path)> {
        let pictures = self.outputs.iter().map(|output| (output.flag(), output.file.as_path()));
        let difference = self.comparison.as_ref().and_then(|comparison| comparison.difference.as_deref());
        pictures.chain(difference.map(|file| (&flags::DIFFERENCE.flag, file))).collect()
    }

    /// The names of all files to write, where `-` is standard output.
    pub fn written(&self) -> impl Iterator<Item = &Path> {
        let json = match &self.json {
            Some(JsonTarget::File(file)) => Some(file.as_path()),
            Some(JsonTarget::StandardOutput) | None => None,
        };
        self.files().into_iter().map(|(_, file)| file).chain(json)
    }

    /// Whether anything is written to standard output.
    pub fn needs_standard_output(&self) -> bool {
        let counts = self.tracing() == Tracing::Counted;
        let prints = counts || self.repeat.is_some() || self.pixel.is_some() || self.comparison.is_some();
        prints || self.json == Some(JsonTarget::StandardOutput) || self.has_standard_output()
    }

    /// How the picture is traced: counted where counts are shown.
    pub fn tracing(&self) -> Tracing {
        let counts = self.stats || self.outputs.iter().any(|output| matches!(output.layer, Layer::Cost(_)));
        if counts { Tracing::Counted } else { Tracing::Fast }
    }

    /// Width and height of the colour picture.
    pub fn picture_size(&self) -> [usize; 2] {
        match (self.jitter, self.reduced) {
            (true, false) => self.size.map(|n| n * REDUCTION),
            (false, true) => reduced(self.size),
            _ => self.size,
        }
    }

    /// What the renderer is asked for.
    pub fn request(&self) -> Request {
        Request {
            size: if self.jitter { self.size.map(|n| n * REDUCTION) } else { self.size },
            window: self.region,
            camera: None,
            effects: self.effects,
            sampler: self.sampler,
            adaptive: self.adaptive,
            has_floats: self
                .outputs
                .iter()
                .any(|output| output.layer == Layer::Color && output.format.is_float()),
            filter: self.filter,
            is_reduced: self.reduced,
            layers: self.outputs.iter().map(|output| output.layer).collect(),
        }
    }
}

/// The edition that is named, or the one that has a flag.
fn edition(raw: &Raw) -> Result<Option<Edition>, CliError> {
    let named = raw.read(&flags::EDITION)?;
    let flags = [
        (&flags::JITTER.flag, Edition::Y2012A5),
        (&flags::FILTER.flag, Edition::Y2012A5),
        (&flags::REGULAR_SAMPLES.flag, Edition::Aalto),
        (&flags::UV.flag, Edition::Aalto),
    ];
    for (flag, has_it) in flags.into_iter().filter(|(flag, _)| raw.given(flag)) {
        match named {
            None => return Ok(Some(has_it)),
            // The program of 2019 accepts both and does nothing.
            Some(named) if named != has_it && named != Edition::Y2019 => {
                return Err(CliError::OtherEdition { flag: flag.name, has_it, named });
            }
            Some(_) => {}
        }
    }
    Ok(named)
}

/// Whether a flag is given that changes the size, in an edition in which it does.
fn three_sizes(raw: &Raw, flag: &Flag) -> bool {
    raw.given(flag) && !matches!(raw.read(&flags::EDITION), Ok(Some(Edition::Y2019)))
}

fn shadows(raw: &Raw) -> Shadows {
    match (raw.given(&flags::TRANSPARENT_SHADOWS), raw.given(&flags::SHADOWS)) {
        (true, _) => Shadows::Transparent,
        (false, true) => Shadows::Opaque,
        (false, false) => Shadows::None,
    }
}

/// The least weight of a ray that is traced.
fn weight(raw: &Raw) -> Result<f64, CliError> {
    match (raw.given(&flags::WEIGHT), edition(raw)?) {
        (false, Some(edition)) => Ok(edition.default_weight()),
        _ => raw.read_or_default(&flags::WEIGHT),
    }
}

fn sampler(raw: &Raw) -> Result<Sampler, CliError> {
    let rng = raw.read(&flags::SEED)?.unwrap_or(Drand48::UNSEEDED);
    let samples =
        [&flags::RANDOM_SAMPLES, &flags::UNIFORM_SAMPLES, &flags::REGULAR_SAMPLES, &flags::JITTERED_SAMPLES];
    let are_random = edition(raw)? == Some(Edition::Aalto) && raw.given(&flags::UNIFORM_SAMPLES);
    Ok(match raw.read_first(&samples)? {
        Some((_, count)) if are_random => Sampler::new(Pattern::Random, count, rng),
        Some((pattern, count)) => Sampler::new(pattern, count, rng),
        None if three_sizes(raw, &flags::JITTER) => Sampler::DISPLACED,
        None if raw.given(&flags::ADAPTIVE_SAMPLES) => Sampler::of_adaptive(rng),
        None => Sampler::new(Pattern::Uniform, 1, rng),
    })
}

fn filter(raw: &Raw) -> Result<Filter, CliError> {
    let others = [&flags::TENT_FILTER, &flags::GAUSSIAN_FILTER, &flags::MITCHELL_FILTER];
    raw.read_first(&others)?.map_or_else(|| raw.read_or_default(&flags::BOX_FILTER), Ok)
}

fn preview(raw: &Raw) -> Result<bool, CliError> {
    let tessellation = raw.read(&flags::TESSELLATION)?;
    let others = [&flags::GUI.flag, &flags::GOURAUD.flag, &flags::SPECULAR_FIX.flag];
    Ok(tessellation.is_some() || others.into_iter().any(|flag| raw.given(flag)))
}
