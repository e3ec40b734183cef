//! Compares two pictures, of which one may be the rendering.

use super::complete_files::CompleteFiles;
use super::log::Log;
use super::report::Report;
use super::signals::Signals;
use super::{End, Outcome, live, refused, threads};
use raytracer::base::escape::quoted;
use raytracer::base::memory;
use raytracer::cli::{self, Options};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{
    Format, OutputFile, ReadFile, Remarks, Written, check_distinct, read_remarked_picture,
};
use raytracer::picture::Picture;
use raytracer::render::renderer::Renderer;
use raytracer::render::{Layer, Request};
use raytracer::scene::model::Shows;
use raytracer::tools::causes::{Finding, FinishedPicture, Original};
use raytracer::tools::compare::{Comparison, DifferencePicture, sizes_differ};
use std::fmt::Display;
use std::path::Path;

/// Compares two pictures that need no scene.
pub fn run(options: &Options, signals: &Signals, log: &Log) -> Result<Outcome, End> {
    threads::start(options.threads, options.size[1])?;
    check_distinct(written(options), read(options)).map_err(refused)?;
    let pair = Pair::open(options, log)?;
    let difference = open_difference(options)?;
    let document = options.json_file().map(OutputFile::prepare).transpose()?;
    let files = CompleteFiles::default();
    files.before_waiting(signals)?;
    let compared = pair.map(|pair| pair.compare(options, (None, None), difference, &files)).transpose()?;
    Report { rendered: None, compared }.finish(options, document, files, signals, log)
}

/// The result of a comparison.
pub struct ComparisonResult {
    pub comparison: Comparison,
    /// Why the picture differs, if that was asked.
    pub cause: Option<Finding>,
    /// Whether the difference is within the tolerance, if there is one.
    pub passes: Option<bool>,
}

impl ComparisonResult {
    pub fn text(&self) -> String {
        self.comparison.block(self.cause.as_ref().map(|cause| cause as &dyn Display))
    }
}

/// The files that a comparison writes beside the picture, and standard output.
pub fn written(options: &Options) -> impl Iterator<Item = Written> {
    let difference = options.comparison.as_ref().and_then(|wanted| wanted.difference.clone());
    let standard_output = options.needs_standard_output() && !options.has_standard_output();
    let document = options.json_file().map(Path::to_owned);
    difference.into_iter().chain(document).chain(standard_output.then(|| "-".into())).map(Written::Named)
}

/// The pictures that a comparison reads.
pub fn read(options: &Options) -> impl Iterator<Item = ReadFile> {
    let pictures = options.comparison.iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
    pictures.flatten().map(|picture| ("picture", picture.clone()))
}

/// Checks that the picture of the difference can be written, if one is asked for.
pub fn open_difference(options: &Options) -> Result<Option<(OutputFile, Format)>, Diagnostic> {
    let path = options.comparison.as_ref().and_then(|wanted| wanted.difference.as_deref());
    let Some((path, format)) = path.and_then(|path| Some((path, Format::of(path)?))) else { return Ok(None) };
    Ok(Some((OutputFile::prepare(path)?, format)))
}

/// The pictures of a comparison.
pub struct Pair<'o> {
    wanted: &'o cli::Comparison,
    /// The picture in question, unless it is the rendered one.
    picture: Option<Picture>,
    /// The picture to compare with, unless it is the rendered one.
    reference: Option<Picture>,
}

impl<'o> Pair<'o> {
    /// Reads the pictures, if a comparison is asked for. Returns an error if one cannot be read, or if their sizes
    /// differ; `None` if the live page is left to compare at the other size.
    pub fn open(options: &'o Options, log: &Log) -> Result<Option<Self>, Diagnostic> {
        let Some(wanted) = &options.comparison else { return Ok(None) };
        let read =
            |path: &Option<_>| path.as_deref().map(|path| read_picture(path, "compared", log)).transpose();
        let (picture, reference) = (read(&wanted.picture)?, read(&wanted.reference)?);
        let rendered = rendered_size(options);
        let size = |picture: &Option<Picture>| {
            picture.as_ref().map_or(rendered, |picture| Some([picture.width(), picture.height()]))
        };
        if let (Some(a), Some(b)) = (size(&picture), size(&reference))
            && a != b
        {
            let only_shows = wanted.tolerance.is_none() && wanted.difference.is_none();
            if !(wanted.needs_scene() && only_shows && live::is_shown(options)) {
                return Err(cannot_compare(wanted, options, [a, b]));
            }
            let note = "the picture to compare with has another size, which only the page takes";
            log.tell(Diagnostic::note(note));
            return Ok(None);
        }
        Ok(Some(Self { wanted, picture, reference }))
    }

    /// Compares, and draws the difference. `scene` is the scene, if there is one, and `own` its picture, if one of the
    /// two is rendered.
    pub fn compare(
        &self,
        options: &Options,
        (scene, own): (Option<&Renderer>, Option<&Picture>),
        difference: Option<(OutputFile, Format)>,
        files: &CompleteFiles,
    ) -> Result<ComparisonResult, Diagnostic> {
        let (Some(a), Some(b)) = (self.picture.as_ref().or(own), self.reference.as_ref().or(own)) else {
            return Err(Diagnostic::error("there is no picture to compare with"));
        };
        let comparison = Comparison::new(a, b);
        let comparison = comparison.map_err(|_| {
            let sizes = [a, b].map(|picture| [picture.width(), picture.height()]);
            cannot_compare(self.wanted, options, sizes)
        })?;
        let differs = self.picture.is_some() && comparison.pixels_that_differ() > 0;
        let of_scene = || scene.and_then(|renderer| cause(options, renderer, a, b));
        let cause = if differs { of_scene().or_else(|| cause_of_pictures(a, b)) } else { None };
        if let Some((file, format)) = difference {
            let shown = DifferencePicture::new(a, b)?;
            files.add(file.picture(format, &shown.picture)?)?;
        }
        let passes = self.wanted.tolerance.map(|tolerance| tolerance.accepts(&comparison));
        Ok(ComparisonResult { comparison, cause, passes })
    }
}

/// What finding a cause takes for each pixel, in bytes: the colours of two pictures, their bytes and those of several
/// wrong ones, with something to spare.
const BYTES_PER_PIXEL_TO_EXPLAIN: u64 = 128;

/// Why a picture from outside differs. Nothing is tried where something else is drawn in place of the scene, with
/// adaptive samples, where the scene's picture has another size, or where there is no memory for it.
fn cause(options: &Options, renderer: &Renderer, a: &Picture, b: &Picture) -> Option<Finding> {
    let layer = options.compared_layer()?;
    let fits = rendered_size(options) == Some([a.width(), a.height()]);
    // Where samples depend on what they show, a wrong picture differs by its samples too.
    let is_settled = layer != Layer::Color || options.adaptive.is_none();
    let shows_scene = !options.visualize_grid && renderer.scene.model.shows == Shows::Scene;
    if !layer.is_of_scene() || !shows_scene || !is_settled || !fits {
        return None;
    }
    let pixels = options.size.iter().map(|&n| n as u64).product::<u64>();
    memory::ask(pixels * BYTES_PER_PIXEL_TO_EXPLAIN).ok()?;
    let request = Request { layers: vec![layer], ..options.request() };
    Some(Original::new(renderer, options.structure, &request)?.explain(a, b))
}

/// Why a picture differs from another of which no scene can be rendered, if that is known. Only what became of the
/// finished picture is tried.
fn cause_of_pictures(a: &Picture, b: &Picture) -> Option<Finding> {
    let pixels = u64::from(a.width()) * u64::from(a.height());
    memory::ask(pixels * BYTES_PER_PIXEL_TO_EXPLAIN).ok()?;
    let found = FinishedPicture::of_picture(b).explain(std::slice::from_ref(a)).pop()?;
    (!matches!(found, Finding::Unknown { .. })).then_some(found)
}

/// Width and height of the rendered picture that is compared, in pixels; `None` if they depend on what it shows.
fn rendered_size(options: &Options) -> Option<[u32; 2]> {
    let layer = options.compared_layer().filter(|layer| !matches!(layer, Layer::Cost(_)))?;
    Some(options.request().layer_size(&layer).map(|n| n as u32))
}

/// The error of a comparison of pictures with these widths and heights.
fn cannot_compare(wanted: &cli::Comparison, options: &Options, [a, b]: [[u32; 2]; 2]) -> Diagnostic {
    let name = |path: &Option<_>| path.as_ref().map_or("the rendered picture".into(), quoted);
    let [one, other] = [&wanted.picture, &wanted.reference].map(name);
    let is_of_pixels = rendered_size(options) == Some(options.size.map(|n| n as u32));
    let hint = match (&wanted.picture, &wanted.reference) {
        (Some(_), None) if is_of_pixels => format!("; -size {} {} renders that size", a[0], a[1]),
        (None, Some(_)) if is_of_pixels => format!("; -size {} {} renders that size", b[0], b[1]),
        _ => String::new(),
    };
    Diagnostic::error(format!("cannot compare {one} with {other}: {}{hint}", sizes_differ(a, b).message))
}

/// Reads a picture. Notes say how many of its pixels are `done`, as in "compared", clamped, and whether a line end
/// follows the last one.
pub fn read_picture(path: &Path, done: &str, log: &Log) -> Result<Picture, Diagnostic> {
    let (picture, Remarks { clamped, has_line_end }) = read_remarked_picture(path)?;
    let shown = quoted(path);
    if clamped > 0 {
        let message = format!("{clamped} pixels of {shown} are not within 0 to 1; they are {done} clamped");
        log.tell(Diagnostic::note(message));
    }
    if has_line_end {
        log.tell(Diagnostic::note(format!("a line end follows the last pixel of {shown}; it is left out")));
    }
    Ok(picture)
}
