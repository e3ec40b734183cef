//! The error of picture files and their parts.

use crate::escape::quoted;
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// A file that cannot be read or written, or parts that make no picture. It is displayed as one line.
#[derive(Debug)]
pub enum ImageError {
    /// The system fails to read or write a file, or has too little memory for its picture.
    Io {
        /// A verb, such as "read".
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// The content or the name of a file does not allow what is to be done with it.
    File {
        /// A verb, such as "read".
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        /// What was found, and what to do.
        reason: String,
    },
    /// Parts that are no parts of one picture, or leave a gap.
    Parts(String),
}

impl ImageError {
    pub(super) fn io(action: &'static str, path: &Path, error: impl Into<io::Error>) -> Self {
        Self::Io { action, path: path.to_owned(), error: error.into() }
    }

    pub(super) fn file(action: &'static str, path: &Path, reason: impl Into<String>) -> Self {
        Self::File { action, path: path.to_owned(), reason: reason.into() }
    }

    /// The file's name ends in none of the endings of pictures.
    pub(super) fn ending(action: &'static str, path: &Path) -> Self {
        Self::file(action, path, "its name ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr")
    }

    /// True if the reader of a pipe has closed it.
    pub fn is_reader_gone(&self) -> bool {
        matches!(self, Self::Io { error, .. } if error.kind() == io::ErrorKind::BrokenPipe)
    }

    /// True if there is too little memory, which says nothing about the file.
    pub fn is_out_of_memory(&self) -> bool {
        matches!(self, Self::Io { error, .. } if error.kind() == io::ErrorKind::OutOfMemory)
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Io { action, path, error } => write!(f, "cannot {action} {}: {error}", quoted(path)),
            Self::File { action, path, reason } => write!(f, "cannot {action} {}: {reason}", quoted(path)),
            Self::Parts(problem) => f.write_str(problem),
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            Self::File { .. } | Self::Parts(_) => None,
        }
    }
}
