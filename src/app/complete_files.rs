//! The complete files of a run. They get their names together at its end, or before a signal ends it.

use crate::app::signals::{Interrupted, Signals};
use crate::app::{End, failed, tell};
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{CompleteFile, ImageError, put_in_place};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Regular files that are complete and have no names yet.
#[derive(Default)]
pub struct CompleteFiles(Arc<Mutex<Vec<CompleteFile>>>);

impl CompleteFiles {
    /// Adds a file. A pipe, a device or standard output is written at once, which may wait for a reader; one that has
    /// gone away has seen enough.
    pub fn add(&self, file: CompleteFile) -> Result<(), Diagnostic> {
        match file.write_stream() {
            Err(error) if error.is_reader_gone() => {}
            written => self.files().extend(written.map_err(failed)?),
        }
        Ok(())
    }

    /// What follows may take long or wait for ever: a signal ends the program, after these files have got their names.
    pub fn before_waiting(&self, signals: &mut Signals) -> Result<(), End> {
        if self.files().is_empty() {
            return Ok(signals.end_at_once()?);
        }
        let own = Self(self.0.clone());
        let keep = move || {
            if let Err(error) = own.name_all() {
                tell(&failed(error));
            }
        };
        signals.end_after(keep).or_else(|end| self.end(Some(end)))
    }

    /// Gives the files their names, or none of them if that fails for one. An error if a signal was noted.
    pub fn finish(self, signals: &Signals) -> Result<(), End> {
        self.end(signals.received())
    }

    fn end(&self, interrupted: Option<Interrupted>) -> Result<(), End> {
        self.name_all().map_err(failed)?;
        interrupted.map_or(Ok(()), |end| Err(end.into()))
    }

    /// Where two threads do so, one waits until the other is done.
    fn name_all(&self) -> Result<(), ImageError> {
        let mut files = self.files();
        put_in_place(std::mem::take(&mut files))
    }

    fn files(&self) -> MutexGuard<'_, Vec<CompleteFile>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
