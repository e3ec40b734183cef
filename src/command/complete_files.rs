//! The complete files of a run. They get their names together at its end, or before a signal ends it.

use super::End;
use super::log::Log;
use super::signals::Signals;
use raytracer::cli::Output;
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{CompleteFile, OutputFile, put_in_place};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Regular files that are complete and have no names yet.
#[derive(Default)]
pub struct CompleteFiles(Arc<Mutex<Vec<CompleteFile>>>);

impl CompleteFiles {
    /// Adds a file. A pipe, a device or standard output is written at once, which may wait for a reader.
    pub fn add(&self, file: CompleteFile) -> Result<(), Diagnostic> {
        let regular = file.write_stream()?;
        self.files().extend(regular);
        Ok(())
    }

    /// What follows may take long or wait for ever: a signal ends the program, after these files have got their names.
    pub fn before_waiting(&self, signals: &Signals) -> Result<(), End> {
        let own = Self(self.0.clone());
        signals.before_end(move || {
            if let Err(error) = own.name_all() {
                Log::default().tell(error);
            }
        });
        let Err(end) = signals.end_at_once() else { return Ok(()) };
        self.name_all()?;
        Err(end)
    }

    /// Gives the files their names, or none of them if that fails for one. An error if a signal was noted.
    pub fn finish(self, signals: &Signals) -> Result<(), End> {
        self.name_all()?;
        signals.end_at_once()
    }

    /// Where two threads do so, one waits until the other is done.
    fn name_all(&self) -> Result<(), Diagnostic> {
        let mut files = self.files();
        put_in_place(std::mem::take(&mut files))
    }

    fn files(&self) -> MutexGuard<'_, Vec<CompleteFile>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Checks that a picture can be written.
pub fn prepare(output: &Output) -> Result<OutputFile, Diagnostic> {
    match output.is_standard_output() {
        true => Ok(OutputFile::standard_output()),
        false => Ok(OutputFile::prepare(&output.file)?),
    }
}
