//! Text files, which are either complete or not written at all.

use super::complete_file::CompleteFile;
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

    /// Whether it is a pipe or a device.
    pub fn is_stream(&self) -> bool {
        !matches!(self.target, Target::Replace { .. })
    }

    /// The file of a text.
    pub fn complete(self, text: &str) -> Result<CompleteFile, ImageError> {
        let mut spool = Spool::new(self.target.folder(), text.len());
        let written = spool.write_all(text.as_bytes());
        written.map_err(|error| ImageError::io("write", &self.path, error))?;
        CompleteFile::new(self.path, self.target, spool)
    }
}
