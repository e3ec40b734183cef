//! The error of picture files and their parts.

use crate::base::escape::quoted;
use std::path::{Path, PathBuf};
use std::{error, fmt, io};

/// A file that cannot be read or written, or parts that make no picture. It is displayed as one line.
#[derive(Debug)]
pub enum ImageError {
    /// What is to be done with a file is not possible.
    File {
        /// A verb, such as "read".
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        /// The system's error, or what was found and what to do.
        error: io::Error,
    },
    /// Parts that are no parts of one picture, or leave a gap.
    Parts(String),
}

impl ImageError {
    pub(super) fn io(action: &'static str, path: &Path, error: impl Into<io::Error>) -> Self {
        Self::File { action, path: path.to_owned(), error: error.into() }
    }

    pub(super) fn new(action: &'static str, path: &Path, reason: impl Into<String>) -> Self {
        Self::io(action, path, io::Error::other(reason.into()))
    }

    /// The file's name ends in none of the endings of pictures.
    pub(super) fn ending(action: &'static str, path: &Path) -> Self {
        Self::new(action, path, "its name ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr")
    }

    /// Returns the kind of the system's error, such as [`OutOfMemory`](io::ErrorKind::OutOfMemory).
    pub fn kind(&self) -> io::ErrorKind {
        match self {
            Self::File { error, .. } => error.kind(),
            Self::Parts(_) => io::ErrorKind::Other,
        }
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { action, path, error } => write!(f, "cannot {action} {}: {error}", quoted(path)),
            Self::Parts(problem) => f.write_str(problem),
        }
    }
}

impl error::Error for ImageError {}
