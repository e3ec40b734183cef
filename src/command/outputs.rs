//! The files of a run: told apart at its start, and named together at its end or before a signal ends it.

use super::log::Log;
use super::signals::Signals;
use super::{End, refused};
use raytracer::cli::{Options, Output};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{
    CompleteFile, OutputFile, ReadFile, Written, check_distinct, part_beside, put_in_place,
};
use raytracer::render::Layer;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Checks that a file can be written; `-` is standard output.
pub fn prepare(path: &Path) -> Result<OutputFile, Diagnostic> {
    if path == Path::new("-") { Ok(OutputFile::standard_output()) } else { OutputFile::prepare(path) }
}

/// Checks that a page and the table beside it can be written.
pub fn prepare_report(files: [PathBuf; 2]) -> Result<[OutputFile; 2], Diagnostic> {
    let [page, table] = files.map(|file| prepare(&file));
    Ok([page?, table?])
}

/// Refuses a run that renders or compares if it would write a file twice, or one that it reads. `scene` lists the
/// scene's files.
pub fn check(options: &Options, scene: impl IntoIterator<Item = ReadFile>) -> Result<(), End> {
    let standard_output = Path::new("-");
    let prints = options.has_text() && !options.written().any(|file| file == standard_output);
    let named = options.written().chain(prints.then_some(standard_output));
    let named = named.map(|file| Written::Named(file.to_owned()));
    // Of a picture there may be a part if the run is stopped.
    let part = |output: &Output| {
        let has_parts =
            !output.is_standard_output() && !matches!(output.layer, Layer::Filter { .. } | Layer::Cost(_));
        let part = part_beside(&output.file, output.format).filter(|_| has_parts)?;
        Some(Written::PartOf { picture: output.file.clone(), part })
    };
    let written = named.chain(options.outputs.iter().filter_map(part));
    let compared = options.comparison.iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
    let compared = compared.flatten().map(|picture| ("picture", picture.clone()));
    check_distinct(written, scene.into_iter().chain(compared)).map_err(refused)
}

/// Regular files that are complete and have no names yet.
#[derive(Default)]
pub struct Outputs(Arc<Mutex<Vec<CompleteFile>>>);

impl Outputs {
    /// The files of a run, of which those that are pipes, devices or standard output have been written. That may wait
    /// for ever: from now on a signal ends the program, after the others have got their names.
    pub fn new(files: Vec<CompleteFile>, signals: &Signals) -> Result<Self, End> {
        let (streams, regular) = files.into_iter().partition(CompleteFile::is_stream);
        let all = Self(Arc::new(Mutex::new(regular)));
        let own = Self(all.0.clone());
        signals.before_end(move || {
            if let Err(error) = own.name_all() {
                Log::default().tell(error);
            }
        });
        if let Err(end) = signals.end_at_once() {
            all.name_all()?;
            return Err(end);
        }
        Vec::into_iter(streams).try_for_each(|stream| all.add(stream))?;
        Ok(all)
    }

    /// Adds a file. A pipe, a device or standard output is written at once, which may wait for a reader.
    pub fn add(&self, file: CompleteFile) -> Result<(), Diagnostic> {
        let regular = file.write_stream()?;
        self.files().extend(regular);
        Ok(())
    }

    /// Gives the files their names, or none of them if that fails for one.
    pub fn name_all(&self) -> Result<(), Diagnostic> {
        // Where two threads do so, one waits until the other is done.
        let mut files = self.files();
        put_in_place(std::mem::take(&mut files))
    }

    fn files(&self) -> MutexGuard<'_, Vec<CompleteFile>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
