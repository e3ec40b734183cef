//! The files of a run. They get their names together at its end, or before a signal ends it.

use super::End;
use super::log::Log;
use super::signals::Signals;
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{CompleteFile, ImageError, OutputFile, put_in_place};
use std::io::ErrorKind;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Checks that a file can be written; `-` is standard output.
pub fn prepare(path: &Path) -> Result<OutputFile, ImageError> {
    if path == Path::new("-") { Ok(OutputFile::standard_output()) } else { OutputFile::prepare(path) }
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
                Log::default().tell(error.into());
            }
        });
        if let Err(end) = signals.end_at_once() {
            all.name_all()?;
            return Err(end);
        }
        Vec::into_iter(streams).try_for_each(|stream| all.add(stream))?;
        Ok(all)
    }

    /// Adds a file. A pipe, a device or standard output is written at once, which may wait for a reader; one that has
    /// gone away has seen enough.
    pub fn add(&self, file: CompleteFile) -> Result<(), Diagnostic> {
        match file.write_stream() {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {}
            written => self.files().extend(written?),
        }
        Ok(())
    }

    /// Gives the files their names, or none of them if that fails for one.
    pub fn name_all(&self) -> Result<(), ImageError> {
        // Where two threads do so, one waits until the other is done.
        let mut files = self.files();
        put_in_place(std::mem::take(&mut files))
    }

    fn files(&self) -> MutexGuard<'_, Vec<CompleteFile>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
