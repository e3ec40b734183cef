//! Text files, which are either complete or not written at all.

use super::error::ImageError;
use super::output::Target;
use super::spool::Spool;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A text file that is known to be writable and has not been written yet. It is written like a picture, by
/// [`OutputFile`](super::OutputFile).
#[derive(Debug)]
pub struct TextFile {
    /// The path as the user gave it, for messages.
    path: PathBuf,
    target: Target,
}

impl TextFile {
    /// Checks that a file can be written to `path`: its folder and the permissions.
    pub fn prepare(path: &Path) -> Result<Self, ImageError> {
        Ok(Self { path: path.to_owned(), target: Target::prepare(path)? })
    }

    /// Writes the whole text. If this fails and the target is a regular file, nothing is written.
    pub fn write(self, text: &str) -> Result<(), ImageError> {
        let mut spool = Spool::new(self.target.folder(), text.len());
        let written = spool.write_all(text.as_bytes()).and_then(|()| self.target.fill(spool));
        written.map_err(|error| ImageError::io("write", &self.path, error))
    }
}
