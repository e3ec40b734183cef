//! Compares two pictures. One of them may be rendered.

use super::log::Log;
use super::outputs::{self, Outputs};
use super::report::Report;
use super::signals::Signals;
use super::{End, Outcome, live, threads};
use crate::base::escape::quoted;
use crate::base::memory;
use crate::cli::{self, Options};
use crate::diagnostic::Diagnostic;
use crate::image_io::{Format, OutputFile, ReadNotes, Wanted, read_pixels};
use crate::picture::Pixels;
use crate::render::Request;
use crate::render::renderer::Renderer;
use crate::tools::causes::{Finding, Original, explain};
use crate::tools::compare::{Brightness, Difference, DifferencePicture, Tolerance, sizes_differ};
use std::fmt::{self, Display};
use std::path::Path;

/// Compares two pictures that need no scene.
pub fn run(options: &Options, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    threads::start(options.threads, options.size[1])?;
    outputs::check(options, vec![])?;
    let pair = Pair::open(options, log)?;
    let files = Files::open(options)?;
    let outputs = Outputs::new(vec![], signals)?;
    let comparison = pair.map(|pair| pair.compare(None, None, files.difference, &outputs)).transpose()?;
    Report { comparison, ..Report::default() }.finish(options, files.document, &outputs, log)
}

/// The result of a comparison. `Display` prints its block.
pub struct ComparisonResult {
    pub difference: Difference,
    /// The brightness of the picture of the difference, if it is drawn.
    pub drawn: Option<Brightness>,
    /// Why the picture differs, if that was asked.
    pub cause: Option<Finding>,
    pub tolerance: Option<Tolerance>,
}

impl ComparisonResult {
    /// Returns true if the difference is within the tolerance, if there is one.
    pub fn passes(&self) -> Option<bool> {
        self.tolerance.map(|tolerance| tolerance.accepts(&self.difference))
    }
}

impl Display for ComparisonResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drawn = self.drawn.filter(|drawn| matches!(drawn, Brightness::Scaled(..)));
        let drawn = drawn.map(|drawn| ("difference picture", drawn.to_string()));
        let cause = self.cause.as_ref().map(|cause| ("cause", cause.to_string()));
        f.write_str(&self.difference.block(drawn.into_iter().chain(cause)))
    }
}

/// The files to write beside the rendered pictures. They are known to be writable.
pub struct Files {
    pub difference: Option<(OutputFile, Format)>,
    pub document: Option<OutputFile>,
}

impl Files {
    pub fn open(options: &Options) -> Result<Self, Diagnostic> {
        let wanted = options.comparison.as_ref().and_then(|wanted| wanted.difference.as_deref());
        let difference = wanted.and_then(|path| Some((path, Format::of(path)?)));
        let difference =
            difference.map(|(path, format)| OutputFile::prepare(path).map(|file| (file, format)));
        let document = options.json.as_deref().map(OutputFile::prepare);
        Ok(Self { difference: difference.transpose()?, document: document.transpose()? })
    }
}

/// The pictures of a comparison.
pub struct Pair<'o> {
    options: &'o Options,
    wanted: &'o cli::ComparisonOptions,
    /// The picture in question, unless it is the rendered one.
    picture: Option<Pixels>,
    /// The picture to compare with, unless it is the rendered one.
    reference: Option<Pixels>,
}

impl<'o> Pair<'o> {
    /// Reads the pictures, if a comparison is asked for. Returns an error if one cannot be read, or if their sizes
    /// differ; `None` if the sizes differ and the live page compares the pictures.
    pub fn open(options: &'o Options, log: &Log) -> Result<Option<Self>, Diagnostic> {
        let Some(wanted) = &options.comparison else { return Ok(None) };
        let read = |path: &Option<_>| path.as_deref().map(|path| read(path, options, log)).transpose();
        let (picture, reference) = (read(&wanted.picture)?, read(&wanted.reference)?);
        let pair = Self { options, wanted, picture, reference };
        let rendered = rendered_size(options);
        let sizes =
            [&pair.picture, &pair.reference].map(|picture| picture.as_ref().map(Pixels::size).or(rendered));
        if let [Some(a), Some(b)] = sizes
            && a != b
        {
            let only_shows = wanted.tolerance.is_none() && wanted.difference.is_none();
            if !(wanted.needs_scene() && only_shows && live::is_shown(options)) {
                return Err(pair.cannot_compare([a, b]));
            }
            let note = "the picture to compare has another size: only the page compares the two";
            log.log(Diagnostic::note(note));
            return Ok(None);
        }
        Ok(Some(pair))
    }

    /// Compares, and draws the difference. `rendered` is the picture of the scene, if one of the two is rendered.
    pub fn compare(
        &self,
        scene: Option<&Renderer>,
        rendered: Option<&Pixels>,
        file: Option<(OutputFile, Format)>,
        outputs: &Outputs,
    ) -> Result<ComparisonResult, Diagnostic> {
        let (Some(a), Some(b)) = (self.picture.as_ref().or(rendered), self.reference.as_ref().or(rendered))
        else {
            return Err(Diagnostic::error("there is no picture to compare with"));
        };
        let difference = Difference::new(a, b).map_err(|_| self.cannot_compare([a, b].map(Pixels::size)))?;
        let differs = self.picture.is_some() && difference.pixels_that_differ() > 0;
        let cause = if differs { cause(self.options, scene, a, b) } else { None };
        let mut drawn = None;
        if let Some((file, format)) = file {
            let shown = DifferencePicture::new(a, b)?;
            outputs.add(file.picture(format, &shown.picture)?)?;
            drawn = Some(shown.brightness);
        }
        Ok(ComparisonResult { difference, drawn, cause, tolerance: self.wanted.tolerance })
    }

    /// The error of pictures with these widths and heights.
    fn cannot_compare(&self, sizes: [[usize; 2]; 2]) -> Diagnostic {
        let Self { options, wanted, .. } = self;
        let name = |path: &Option<_>| path.as_ref().map_or("the rendered picture".into(), quoted);
        let [one, other] = [&wanted.picture, &wanted.reference].map(name);
        let problem = sizes_differ(sizes[0], sizes[1]).message;
        let error = Diagnostic::error(format!("cannot compare {one} with {other}: {problem}"));
        let is_of_pixels = rendered_size(options) == Some(options.size);
        let [width, height] = if wanted.picture.is_some() { sizes[0] } else { sizes[1] };
        match wanted.needs_scene() && is_of_pixels {
            true => error.with_hint(format!("-size {width} {height} renders that size")),
            false => error,
        }
    }
}

/// Finds why a picture from outside differs from the reference. The scene cannot be used if its picture has another size.
/// Bytes that are equal have no cause, and for finished pictures an unknown one is not named.
fn cause(options: &Options, scene: Option<&Renderer>, a: &Pixels, b: &Pixels) -> Option<Finding> {
    /// The colours and bytes of two pictures and the bytes of several wrong ones, with something to spare.
    const BYTES_PER_PIXEL: u64 = 128;
    memory::ask(a.size().iter().product::<usize>() as u64 * BYTES_PER_PIXEL).ok()?;
    if a.bytes() == b.bytes() {
        return None;
    }
    let rendered = scene.zip(options.compared_layer()).filter(|_| rendered_size(options) == Some(a.size()));
    let original = rendered.and_then(|(renderer, layer)| {
        Original::new(renderer, &Request { layers: vec![layer], ..options.request() })
    });
    let found = explain(original.as_ref(), b, None, a)?;
    (original.is_some() || !matches!(found, Finding::Unknown { .. })).then_some(found)
}

/// Width and height of the rendered picture that is compared, in pixels.
fn rendered_size(options: &Options) -> Option<[usize; 2]> {
    let layer = options.compared_layer()?;
    Some(options.request().layer_size(&layer))
}

/// Reads a picture for a comparison.
fn read(path: &Path, options: &Options, log: &Log) -> Result<Pixels, Diagnostic> {
    let (picture, remarks) = read_pixels(path, Wanted::Numbers)?;
    let clamped = if options.compares_numbers() { 0 } else { remarks.clamped };
    log_notes(&ReadNotes { clamped, ..remarks }, path, "compared", log);
    Ok(picture)
}

/// Logs how many pixels of a picture are clamped, if its alpha is ignored, and if a line end follows the last pixel.
/// `done` is "compared" or "converted".
pub fn log_notes(notes: &ReadNotes, path: &Path, done: &str, log: &Log) {
    let ReadNotes { clamped, transparent, has_line_end } = notes;
    let shown = quoted(path);
    if *clamped > 0 {
        let message = format!("{clamped} pixels of {shown} are outside 0 to 1 and are {done} clamped");
        log.log(Diagnostic::note(message));
    }
    if *transparent > 0 {
        let message = format!("ignored the alpha of {shown}: {transparent} of its pixels are not opaque");
        log.log(Diagnostic::note(message));
    }
    if *has_line_end {
        log.log(Diagnostic::note(format!("ignored a line end after the last pixel of {shown}")));
    }
}
