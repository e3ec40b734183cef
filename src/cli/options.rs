//! The options of a run that renders or compares, and what follows from them.

use super::outputs::Output;
use super::values::{json_target, lossy_or_null};
use crate::base::memory::Bytes;
use crate::base::stdio::is_stdio;
use crate::caster::choose::{Resolution, Structure};
use crate::diagnostic::Diagnostic;
use crate::image_io::{Format, ReadFile};
use crate::render::adaptive::Adaptive;
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Request, Tracing, Window};
use crate::sampling::blur::{REDUCTION, reduced};
use crate::sampling::filter::Filter;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene::edition::Edition;
use crate::scene::load::{Hints, LoadedScene, load_with};
use crate::tools::compare::Tolerance;
use crate::trace::Effects;
use serde::Serialize;
use std::path::{Path, PathBuf};

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
    /// Returns true if all pictures with a file are of floating-point numbers.
    pub(super) fn has_only_numbers(&self) -> bool {
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

impl Options {
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

    /// Returns the scene and the compared pictures, without the files that the scene names.
    pub fn files(&self) -> impl Iterator<Item = ReadFile> {
        let compared = self.comparison.iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        let pictures = compared.flatten().map(|picture| ("picture", picture.clone()));
        self.input.iter().map(|input| ("scene", input.clone())).chain(pictures)
    }

    /// Returns the names of the pictures to write, where `-` is standard output.
    pub fn pictures(&self) -> impl Iterator<Item = &Path> {
        let difference = self.comparison.as_ref().and_then(|comparison| comparison.difference.as_deref());
        self.outputs.iter().map(|output| output.file.as_path()).chain(difference)
    }

    /// Returns the names of all files to write.
    pub fn written(&self) -> impl Iterator<Item = &Path> {
        self.pictures().chain(self.json.as_deref())
    }

    /// Returns true if the JSON document is printed in place of the text.
    pub fn prints_json(&self) -> bool {
        self.json.as_deref().is_some_and(is_stdio)
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

    /// Returns the width and height of the colour picture.
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
