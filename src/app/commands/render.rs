//! One run of the program: a scene is rendered, and pictures are compared, as the options ask for.

use crate::app::complete_files::CompleteFiles;
use crate::app::json::{ComparisonResult, Document};
use crate::app::page;
use crate::app::pictures::{Rendered, read_picture, render};
use crate::app::signals::Signals;
use crate::app::streams;
use crate::app::threads::{Crew, useful};
use crate::app::{End, Outcome, failed, told_files};
use raytracer::cli::{self, Options};
use raytracer::diagnostic::Diagnostic;
use raytracer::distinct_files::WrittenFiles;
use raytracer::escape::quoted;
use raytracer::image_io::{OutputFile, TextFile};
use raytracer::memory;
use raytracer::picture::Picture;
use raytracer::render::{Layer, Request};
use raytracer::renderer::Renderer;
use raytracer::scene::model::Shows;
use raytracer::tools::causes::{Finding, FinishedPicture, Original};
use raytracer::tools::compare::{Comparison, DifferencePicture, sizes_differ};
use std::cell::RefCell;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Does what the options ask for, which come from the command line `argv`. Notes and warnings go to `tell`.
pub fn run(
    options: &Options,
    argv: &[OsString],
    signals: &mut Signals,
    tell: &dyn Fn(&Diagnostic),
) -> Result<Outcome, End> {
    let crew = Crew::new(useful(options.threads, options.size[1]))?;
    let told = RefCell::new(vec![]);
    let tell = |found: &Diagnostic| {
        told.borrow_mut().push(found.to_string());
        tell(found);
    };
    if let Some(note) = page::note(options) {
        tell(&Diagnostic::note(note));
    }
    if options.needs_standard_output() {
        streams::check_output()?;
    }
    streams::check_input(options)?;
    let written = WrittenFiles::of_rendering(options)?;
    // A picture that cannot be read, or a file that cannot be written, is no reason to wait for the rendering.
    let compared = options.comparison.as_ref().map(|wanted| Compared::open(wanted, options, &tell));
    let compared = compared.transpose()?.flatten();
    let file = options.json_file().map(TextFile::prepare).transpose().map_err(failed)?;
    let mut from = |input: &PathBuf| render(options, argv, input, &written, &crew, signals, &tell);
    let mut rendered = options.input.as_ref().map(&mut from).transpose()?;
    let files = rendered.as_mut().map(|rendered| std::mem::take(&mut rendered.files)).unwrap_or_default();
    if compared.is_some() || file.as_ref().is_some_and(TextFile::is_stream) {
        files.before_waiting(signals)?;
    }
    let settled = rendered.as_ref().map_or_else(|| options.clone(), |rendered| rendered.options.clone());
    let options = &settled;
    let finish = |compared: Compared| compared.finish(options, rendered.as_ref(), &crew, &files);
    let verdict = compared.map(finish).transpose()?.flatten();

    let passes = verdict.as_ref().is_none_or(|verdict| verdict.passes != Some(false));
    let (warnings, count) = (told.into_inner(), crew.at_work());
    let json = || {
        let document = Document::new(options, &warnings, count, rendered.as_ref(), verdict.as_ref());
        document.to_json().map_err(failed)
    };
    if let Some(file) = file {
        files.add(file.complete(&json()?).map_err(failed)?)?;
    }
    let text = match options.prints_json() {
        true => json()?,
        false => text(options, rendered.as_ref(), verdict.as_ref()),
    };
    files.finish(signals)?;
    signals.end_at_once()?;
    let written = told_files(options.progress, options.written().map(Path::to_owned));
    Ok(Outcome { text, written, passes })
}

/// What there is to print: the blocks of the rendering, then that of the comparison.
fn text(options: &Options, rendered: Option<&Rendered>, verdict: Option<&ComparisonResult>) -> String {
    let rendered = rendered.map(|rendered| rendered.text(options));
    rendered.into_iter().chain(verdict.map(ComparisonResult::text)).collect()
}

/// The pictures and files of a comparison.
struct Compared<'o> {
    wanted: &'o cli::Comparison,
    /// The picture in question, unless it is the rendered one.
    picture: Option<Picture>,
    /// The picture to compare with, unless it is the rendered one.
    reference: Option<Picture>,
    difference: Option<OutputFile>,
}

impl<'o> Compared<'o> {
    /// Reads the pictures. An error if one cannot be read, or if their sizes differ; `None` if the live page is left to
    /// compare at the other size.
    fn open(
        wanted: &'o cli::Comparison,
        options: &Options,
        tell: &dyn Fn(&Diagnostic),
    ) -> Result<Option<Self>, Diagnostic> {
        let read =
            |path: &Option<_>| path.as_deref().map(|path| read_picture(path, "compared", tell)).transpose();
        let (picture, reference) = (read(&wanted.picture)?, read(&wanted.reference)?);
        let difference: Option<&Path> = wanted.difference.as_deref();
        let difference = difference.map(OutputFile::prepare).transpose().map_err(failed)?;
        let rendered = rendered_size(options);
        let size = |picture: &Option<Picture>| {
            picture.as_ref().map_or(rendered, |picture| Some([picture.width(), picture.height()]))
        };
        match (size(&picture), size(&reference)) {
            (Some(a), Some(b)) if a != b => {
                let only_shows = wanted.tolerance.is_none() && wanted.difference.is_none();
                if !(wanted.needs_scene() && only_shows && page::is_shown(options)) {
                    return Err(cannot_compare(wanted, options, [a, b]));
                }
                let note = "the picture to compare with has another size, which only the page takes";
                tell(&Diagnostic::note(note));
                Ok(None)
            }
            _ => Ok(Some(Self { wanted, picture, reference, difference })),
        }
    }

    /// Compares, and draws the difference.
    fn finish(
        self,
        options: &Options,
        rendered: Option<&Rendered>,
        crew: &Crew,
        files: &CompleteFiles,
    ) -> Result<Option<ComparisonResult>, End> {
        let own = rendered.and_then(|rendered| rendered.picture.as_ref());
        let (Some(a), Some(b)) = (self.picture.as_ref().or(own), self.reference.as_ref().or(own)) else {
            return Ok(None);
        };
        crew.start_all();
        let comparison = crew.pool.install(|| Comparison::new(a, b));
        let comparison = comparison.map_err(|_| {
            let sizes = [a, b].map(|picture| [picture.width(), picture.height()]);
            cannot_compare(self.wanted, options, sizes)
        })?;
        let differs = self.picture.is_some() && comparison.pixels_that_differ() > 0;
        let cause = rendered.filter(|_| differs).and_then(|from| cause(options, &from.renderer, a, b));
        let cause = cause.or_else(|| if differs { cause_of_pictures(a, b) } else { None });
        if let Some(file) = self.difference {
            let shown = DifferencePicture::new(a, b)?;
            files.add(file.complete(&shown.picture).map_err(failed)?)?;
        }
        let passes = self.wanted.tolerance.map(|tolerance| tolerance.accepts(&comparison));
        Ok(Some(ComparisonResult { comparison, cause, passes }))
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
    failed(format!("cannot compare {one} with {other}: {}{hint}", sizes_differ(a, b).message))
}
