//! The second stage of the command line: the values are parsed and checked, each by itself and then together.

use super::comparison::Comparison;
use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::parts::region;
use super::raw::Raw;
use super::values::{bad, ends_in, finite, lossy, lossy_or_null, picture_name, whole, wholes};
use crate::grid::options::{Resolution, Structure};
use crate::render::{Cost, Layer, Request, Window};
use crate::sampling::adaptive::Adaptive;
use crate::sampling::drand48::Drand48;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::trace::{Effects, Shadows};
use serde::Serialize;
use std::ffi::OsStr;
use std::path::{Path, PathBuf, absolute};

/// The checked options of a run. Every number is in the range that its field states.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// The scene file, whose name ends in `.txt`.
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
    /// Whether the command line requests the course's preview, which this program does not have.
    pub preview: bool,
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

/// A picture to write.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// What it shows. Depths and their difference are finite, and the sides of an enlarged picture are below 65536.
    #[serde(flatten)]
    pub layer: Layer,
    /// The picture's file; ends in `.tga` or `.png`.
    #[serde(serialize_with = "lossy")]
    pub file: PathBuf,
}

impl Output {
    /// The flag that asks for it.
    fn flag(&self) -> &'static Flag {
        match self.layer {
            Layer::Color => &flags::OUTPUT,
            Layer::Depth { .. } => &flags::DEPTH,
            Layer::Normals => &flags::NORMALS,
            Layer::Samples { .. } => &flags::RENDER_SAMPLES,
            Layer::Cost(_) => &flags::COST_MAP,
            Layer::Filter { .. } => &flags::RENDER_FILTER,
        }
    }
}

pub(super) const SIZE_RANGE: (u32, u32) = (1, 65535);
const SAMPLE_RANGE: (u32, u32) = (1, 65536);
/// The range of the largest number of adaptive samples. A pixel is not divided into more strata.
const ADAPTIVE_RANGE: (u32, u32) = (Adaptive::BASE, Adaptive::LIMIT);
/// The range of filter sizes, in pixels.
const MIN_FILTER: f64 = 1e-6;
const MAX_FILTER: f64 = 1e6;
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
            input: scene(raw)?,
            outputs: outputs(raw)?,
            size: wholes(raw, &flags::SIZE, SIZE_RANGE)?.unwrap_or([100, 100]).map(|n| n as usize),
            region: region(raw)?,
            effects: Effects {
                shadows: shadows(raw),
                shade_back: raw.given(&flags::SHADE_BACK),
                bounces: wholes(raw, &flags::BOUNCES, (0, MAX_INT))?.map_or(0, |[n]| n),
                min_weight: weight(raw)?,
            },
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
        distinct(&self.files())
    }

    /// The pictures to write, each with the flag that names its file.
    fn files(&self) -> Vec<(&'static Flag, &Path)> {
        let pictures = self.outputs.iter().map(|output| (output.flag(), output.file.as_path()));
        let difference = self.comparison.as_ref().and_then(|comparison| comparison.difference.as_deref());
        pictures.chain(difference.map(|file| (&flags::DIFFERENCE, file))).collect()
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

/// Compares full paths, not the file system: links that lead to one file pass.
fn distinct(files: &[(&'static Flag, &Path)]) -> Result<(), CliError> {
    let full = |path: &Path| absolute(path).unwrap_or_else(|_| path.to_owned());
    for (i, &(flag, file)) in files.iter().enumerate() {
        if let Some((other, _)) = files[i + 1..].iter().find(|(_, later)| full(later) == full(file)) {
            return Err(CliError::SameFile { flag: flag.name, other: other.name, file: file.to_owned() });
        }
    }
    Ok(())
}

fn scene(raw: &Raw) -> Result<Option<PathBuf>, CliError> {
    match raw.values(&flags::INPUT)? {
        None => Ok(None),
        Some([word]) if ends_in(word, ".txt") => Ok(Some(word.into())),
        Some([word]) => Err(bad(&flags::INPUT, word, Problem::NotScene)),
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

fn outputs(raw: &Raw) -> Result<Vec<Output>, CliError> {
    let outputs = [
        picture(raw, &flags::OUTPUT, Layer::Color)?,
        depth(raw)?,
        picture(raw, &flags::NORMALS, Layer::Normals)?,
        enlarged(raw, &flags::RENDER_SAMPLES, |zoom| Layer::Samples { zoom })?,
        enlarged(raw, &flags::RENDER_FILTER, |zoom| Layer::Filter { zoom })?,
        cost_map(raw)?,
    ];
    Ok(outputs.into_iter().flatten().collect())
}

fn picture(raw: &Raw, flag: &Flag, layer: Layer) -> Result<Option<Output>, CliError> {
    let output = |[word]: [_; 1]| Ok(Output { layer, file: picture_name(flag, word)? });
    raw.values(flag)?.map(output).transpose()
}

fn depth(raw: &Raw) -> Result<Option<Output>, CliError> {
    let Some([from, to, file]) = raw.values(&flags::DEPTH)? else { return Ok(None) };
    let (near, far) = (finite(&flags::DEPTH, from)?, finite(&flags::DEPTH, to)?);
    if near >= far {
        return Err(CliError::DepthOrder { t0: near, t1: far });
    }
    // The greys divide by the difference.
    if !(far - near).is_finite() {
        return Err(CliError::DepthRange);
    }
    Ok(Some(Output { layer: Layer::Depth { near, far }, file: picture_name(&flags::DEPTH, file)? }))
}

fn cost_map(raw: &Raw) -> Result<Option<Output>, CliError> {
    let Some([kind, file]) = raw.values(&flags::COST_MAP)? else { return Ok(None) };
    let cost = match kind.to_str() {
        Some("rays") => Cost::Rays,
        Some("tests") => Cost::Tests,
        Some("cells") => Cost::Cells,
        _ => return Err(bad(&flags::COST_MAP, kind, Problem::NotCost)),
    };
    Ok(Some(Output { layer: Layer::Cost(cost), file: picture_name(&flags::COST_MAP, file)? }))
}

fn shadows(raw: &Raw) -> Shadows {
    match (raw.given(&flags::TRANSPARENT_SHADOWS), raw.given(&flags::SHADOWS)) {
        (true, _) => Shadows::Transparent,
        (false, true) => Shadows::Opaque,
        (false, false) => Shadows::None,
    }
}

fn weight(raw: &Raw) -> Result<f64, CliError> {
    let Some([word]) = raw.values(&flags::WEIGHT)? else { return Ok(0.0) };
    match finite(&flags::WEIGHT, word)? {
        weight if weight < 0.0 => Err(bad(&flags::WEIGHT, word, Problem::Negative)),
        weight => Ok(weight),
    }
}

fn structure(raw: &Raw) -> Result<Structure, CliError> {
    match raw.single(&flags::GRID).and_then(OsStr::to_str) {
        Some("auto") => return Ok(Structure::Grid(Resolution::Auto)),
        Some("none") => return Ok(Structure::List),
        _ => {}
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

fn enlarged(raw: &Raw, flag: &Flag, layer: fn(usize) -> Layer) -> Result<Option<Output>, CliError> {
    let Some([file, zoom]) = raw.values(flag)? else { return Ok(None) };
    let zoom = whole(zoom, (1, SIZE_RANGE.1)).map_err(|problem| bad(flag, zoom, problem))? as usize;
    Ok(Some(Output { layer: layer(zoom), file: picture_name(flag, file)? }))
}

fn sampler(raw: &Raw) -> Result<Sampler, CliError> {
    let seed = raw
        .values(&flags::SEED)?
        .map(|[word]| whole(word, (0, u32::MAX)).map_err(|problem| bad(&flags::SEED, word, problem)));
    let rng = seed.transpose()?.map_or(Drand48::UNSEEDED, Drand48::seeded);
    for (flag, pattern) in [
        (&flags::RANDOM_SAMPLES, Pattern::Random),
        (&flags::UNIFORM_SAMPLES, Pattern::Uniform),
        (&flags::JITTERED_SAMPLES, Pattern::Jittered),
    ] {
        if let Some([count]) = wholes(raw, flag, SAMPLE_RANGE)? {
            return Ok(Sampler::new(pattern, count, rng));
        }
    }
    // The first samples of each pixel.
    Ok(if raw.given(&flags::ADAPTIVE_SAMPLES) { Sampler::first_of_adaptive(rng) } else { Sampler::CENTER })
}

fn adaptive(raw: &Raw) -> Result<Option<Adaptive>, CliError> {
    let flag = &flags::ADAPTIVE_SAMPLES;
    let Some([most, error]) = raw.values(flag)? else { return Ok(None) };
    let most = whole(most, ADAPTIVE_RANGE).map_err(|problem| bad(flag, most, problem))?;
    match finite(flag, error)? {
        level if level < 0.0 => Err(bad(flag, error, Problem::Negative)),
        error => Ok(Some(Adaptive { most, error })),
    }
}

fn filter(raw: &Raw) -> Result<Filter, CliError> {
    for (flag, filter) in [
        (&flags::BOX_FILTER, (|radius| Filter::Box { radius }) as fn(f64) -> Filter),
        (&flags::TENT_FILTER, |radius| Filter::Tent { radius }),
        (&flags::GAUSSIAN_FILTER, |sigma| Filter::Gaussian { sigma }),
        (&flags::MITCHELL_FILTER, |radius| Filter::Mitchell { radius }),
    ] {
        let Some([word]) = raw.values(flag)? else { continue };
        let size = finite(flag, word)?;
        // The weights are computed with divisions by the size and its square, which must not underflow.
        let is_usable = (MIN_FILTER..=MAX_FILTER).contains(&size);
        return if is_usable { Ok(filter(size)) } else { Err(bad(flag, word, Problem::NotFilterSize)) };
    }
    Ok(Filter::PIXEL)
}

fn preview(raw: &Raw) -> Result<bool, CliError> {
    let tessellation = wholes::<2>(raw, &flags::TESSELLATION, (1, MAX_INT))?;
    Ok(tessellation.is_some() || raw.given(&flags::GUI) || raw.given(&flags::GOURAUD))
}
