//! The second stage of the command line: the values are parsed and checked, each by itself and then together.

use super::comparison::Comparison;
use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::live_page::LivePage;
use super::outputs::{Output, distinct, outputs};
use super::parts::region;
use super::raw::Raw;
use super::sampling::{adaptive, filter, sampler};
use super::values::{bad, ends_in, finite, lossy, lossy_or_null, whole, wholes};
use crate::grid::options::{Resolution, Structure};
use crate::render::{Layer, Request, Window};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::trace::{Effects, Shadows};
use serde::Serialize;
use std::ffi::OsStr;
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
    /// What is modelled.
    pub effects: Effects,
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

pub(super) const SIZE_RANGE: (u32, u32) = (1, 65535);
/// The largest value of the course's `int`.
const MAX_INT: u32 = i32::MAX as u32;
/// The upper limit is far above the cores of any machine, and far below the number of threads that cannot be
/// started.
pub(super) const THREAD_RANGE: (u32, u32) = (1, 4096);
/// The number of cells stays below this, so that the index of a cell fits into 32 bits.
const CELL_LIMIT: u64 = 1 << 31;

impl Options {
    /// Checks each flag in the order of the help, then the combination of the flags.
    pub(super) fn from_raw(raw: &Raw) -> Result<Self, CliError> {
        let options = Self {
            input: raw.values(&flags::INPUT)?.map(|[word]| word.into()),
            outputs: outputs(raw)?,
            size: size(raw)?.unwrap_or([100, 100]).map(|n| n as usize),
            region: region(raw)?,
            effects: Effects {
                shadows: shadows(raw),
                shade_back: raw.given(&flags::SHADE_BACK),
                bounces: bounces(raw)?.unwrap_or(0),
                min_weight: weight(raw)?,
            },
            says_no_bounces: bounces(raw)? == Some(0),
            sampler: sampler(raw)?,
            adaptive: adaptive(raw)?,
            filter: filter(raw)?,
            structure: structure(raw)?,
            visualize_grid: raw.given(&flags::VISUALIZE_GRID),
            comparison: Comparison::from_raw(raw)?,
            stats: raw.given(&flags::STATS),
            strict: raw.given(&flags::STRICT),
            json: json(raw)?,
            pixel: wholes(raw, &flags::PIXEL, (0, SIZE_RANGE.1 - 1))?.map(|pixel| pixel.map(|n| n as usize)),
            preview: preview(raw)?,
            page: LivePage::from_raw(raw)?,
            threads: wholes(raw, &flags::THREADS, THREAD_RANGE)?.map(|[n]| n as usize),
            progress: ShowProgress::from_raw(raw),
        };
        options.check_together()?;
        Ok(options)
    }

    fn check_together(&self) -> Result<(), CliError> {
        let needs_scene =
            self.pixel.is_some() || self.comparison.as_ref().is_none_or(Comparison::needs_scene);
        if self.input.is_none() && needs_scene {
            return Err(CliError::InputNeeded);
        }
        let [width, height] = self.size;
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
            if width.max(height) > SIZE_RANGE.1 as usize {
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
        pictures.chain(difference.map(|file| (&flags::DIFFERENCE, file))).collect()
    }

    /// Whether anything is written to standard output.
    pub fn needs_standard_output(&self) -> bool {
        let prints = self.counts() || self.pixel.is_some() || self.comparison.is_some();
        prints || self.json == Some(JsonTarget::StandardOutput) || self.has_standard_output()
    }

    /// Whether counters are needed.
    pub fn counts(&self) -> bool {
        self.stats || self.outputs.iter().any(|output| matches!(output.layer, Layer::Cost(_)))
    }

    /// What the renderer is asked for.
    pub fn request(&self) -> Request {
        Request {
            size: self.size,
            window: self.region,
            camera: None,
            effects: self.effects,
            sampler: self.sampler,
            adaptive: self.adaptive,
            filter: self.filter,
            layers: self.outputs.iter().map(|output| output.layer).collect(),
        }
    }
}

fn json(raw: &Raw) -> Result<Option<JsonTarget>, CliError> {
    match raw.values(&flags::JSON)? {
        None => Ok(None),
        Some([word]) if word == "-" => Ok(Some(JsonTarget::StandardOutput)),
        Some([word]) if ends_in(word, ".json") => Ok(Some(JsonTarget::File(word.into()))),
        Some([word]) => Err(bad(&flags::JSON, word, Problem::NotJson)),
    }
}

fn shadows(raw: &Raw) -> Shadows {
    match (raw.given(&flags::TRANSPARENT_SHADOWS), raw.given(&flags::SHADOWS)) {
        (true, _) => Shadows::Transparent,
        (false, true) => Shadows::Opaque,
        (false, false) => Shadows::None,
    }
}

fn bounces(raw: &Raw) -> Result<Option<u32>, CliError> {
    Ok(wholes(raw, &flags::BOUNCES, (0, MAX_INT))?.map(|[n]| n))
}

fn weight(raw: &Raw) -> Result<f64, CliError> {
    let Some([word]) = raw.values(&flags::WEIGHT)? else { return Ok(0.0) };
    match finite(&flags::WEIGHT, word)? {
        weight if weight < 0.0 => Err(bad(&flags::WEIGHT, word, Problem::Negative)),
        weight => Ok(weight),
    }
}

/// The size as two words, or as one with an `x` between the numbers.
fn size(raw: &Raw) -> Result<Option<[u32; 2]>, CliError> {
    let flag = &flags::SIZE;
    let joined = raw.single(flag).and_then(OsStr::to_str).and_then(|word| word.split_once(['x', 'X']));
    let Some((width, height)) = joined else { return wholes(raw, flag, SIZE_RANGE) };
    let side = |word: &str| {
        whole(OsStr::new(word), SIZE_RANGE).map_err(|problem| bad(flag, OsStr::new(word), problem))
    };
    Ok(Some([side(width)?, side(height)?]))
}

fn structure(raw: &Raw) -> Result<Structure, CliError> {
    match raw.single(&flags::GRID).and_then(OsStr::to_str) {
        Some("auto") => return Ok(Structure::Grid(Resolution::Auto)),
        Some("none") => return Ok(Structure::List),
        _ => {}
    }
    let is_name = |word: &&OsStr| *word == "auto" || *word == "none";
    if let Some(name) = raw.all_values(&flags::GRID).into_iter().flatten().find(is_name) {
        return Err(bad(&flags::GRID, name, Problem::NotAlone));
    }
    let Some(cells) = wholes::<3>(raw, &flags::GRID, (1, MAX_INT))? else { return Ok(Structure::Any) };
    let product = cells.iter().try_fold(1u64, |product, &n| product.checked_mul(n.into()));
    match product {
        Some(product) if product < CELL_LIMIT => {
            Ok(Structure::Grid(Resolution::Cells(cells.map(|n| n as usize))))
        }
        _ => Err(CliError::TooManyCells { cells }),
    }
}

fn preview(raw: &Raw) -> Result<bool, CliError> {
    let tessellation = wholes::<2>(raw, &flags::TESSELLATION, (1, MAX_INT))?;
    Ok(tessellation.is_some() || raw.given(&flags::GUI) || raw.given(&flags::GOURAUD))
}
