//! The application: what each command does, and what it says. Nothing else prints or exits.
//!
//! A module uses only those before it in this list.

mod start;
mod terminal;
mod allocator;
mod signals;
mod streams;
mod threads;
mod progress;
mod complete_files;
mod warned;
mod products;
mod stopping;
mod pictures;
mod page;
mod json;
pub mod commands;

pub use page::{show as show_page, worker as page_worker};
pub use signals::{Interrupted, Signals};
pub use streams::print;

use raytracer::cli::ShowProgress;
use raytracer::diagnostic::Diagnostic;
use raytracer::distinct_files::SameFile;
use std::fmt::Display;
use std::io::Write;
use std::path::PathBuf;
use std::time::Duration;

/// Why a run ends before it is complete.
pub enum End {
    /// Something has failed. Of several errors all are shown.
    Failed(Vec<Diagnostic>),
    /// The command line asks for something that is not done.
    Refused(Diagnostic),
    /// A signal has come.
    Interrupted(Interrupted),
}

impl From<Diagnostic> for End {
    fn from(error: Diagnostic) -> Self {
        Self::Failed(vec![error])
    }
}

impl From<SameFile> for End {
    fn from(error: SameFile) -> Self {
        Self::Refused(failed(error))
    }
}

impl From<Interrupted> for End {
    fn from(interrupted: Interrupted) -> Self {
        Self::Interrupted(interrupted)
    }
}

/// What a run has to say.
pub struct Outcome {
    /// What goes to standard output, or to standard error if a picture goes there.
    pub text: String,
    /// The files that it wrote, which are no streams, unless nobody is to be told.
    pub written: Vec<PathBuf>,
    /// Whether the pictures that were compared differ by no more than the tolerance.
    pub passes: bool,
}

/// Prints an error, a warning or a note to standard error.
pub fn tell(found: &Diagnostic) {
    say(&terminal::shown(found));
}

/// Prints a line to standard error. Where nobody reads it there is nobody to tell, and `eprintln!` would panic.
pub fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Tells a person at a terminal what a run wrote in this time, if it wrote anything.
pub fn tell_written(written: &[PathBuf], took: Duration) {
    if terminal::has_reader() && !written.is_empty() {
        say(&terminal::finished(written, took));
    }
}

/// The files of which a finished run tells.
pub fn told_files(wish: ShowProgress, files: impl IntoIterator<Item = PathBuf>) -> Vec<PathBuf> {
    let files = files.into_iter().filter(|file| file.as_os_str() != "-");
    if wish == ShowProgress::Never { vec![] } else { files.collect() }
}

/// Makes an error without a place.
pub fn failed(error: impl Display) -> Diagnostic {
    Diagnostic::error(error.to_string())
}
