//! The errors of picture files.

use crate::escape::quoted;
use crate::picture::BadSize;
use std::path::{Path, PathBuf};
use std::{fmt, io};

/// A picture that cannot be held in memory, read or written. The error is displayed as one line that names
/// the file.
#[derive(Debug)]
pub enum ImageError {
    /// The name ends in none of the endings of pictures.
    Ending {
        /// The path of the file.
        path: PathBuf,
    },
    /// An output is a folder.
    Folder {
        /// The path of the file.
        path: PathBuf,
    },
    /// An output in a folder that does not exist.
    NoFolder {
        /// The path of the file.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// The system failed to read or write a file.
    Io {
        /// The operation that failed, such as "open".
        action: &'static str,
        /// The path of the file.
        path: PathBuf,
        /// The reason.
        error: io::Error,
    },
    /// A side is too long for the format.
    Sides {
        /// The path of the file.
        path: PathBuf,
        /// The width in pixels.
        width: usize,
        /// The height in pixels.
        height: usize,
    },
    /// A picture is too large for a BMP file.
    TooLargeForBmp {
        /// The path of the file.
        path: PathBuf,
        /// The width in pixels.
        width: usize,
        /// The height in pixels.
        height: usize,
    },
    /// A file has no picture that can be read.
    Unreadable {
        /// The path of the file.
        path: PathBuf,
        /// What was found, and what to do.
        reason: String,
    },
    /// A picture that says nothing of a whole that it is a part of, or what cannot be true.
    NoPart {
        /// The path of the file.
        path: PathBuf,
    },
    /// A whole picture in place of a part.
    Whole {
        /// The path of the file.
        path: PathBuf,
        /// The width and height in pixels.
        size: [u32; 2],
    },
    /// A part without a checksum.
    NoChecksum {
        /// The path of the file.
        path: PathBuf,
    },
    /// A part that is not what was written.
    Damaged {
        /// The path of the file.
        path: PathBuf,
    },
    /// A picture of bytes is to be written as floating-point numbers.
    OnlyBytes {
        /// The path of the file.
        path: PathBuf,
    },
    /// A part whose encoding is not that of this program.
    OtherEncoding {
        /// The path of the file.
        path: PathBuf,
    },
    /// A picture to read is larger than there is memory for.
    Memory {
        /// The path of the file.
        path: PathBuf,
        /// The picture's size.
        size: BadSize,
    },
}

impl ImageError {
    pub(super) fn io(action: &'static str, path: &Path, error: io::Error) -> Self {
        Self::Io { action, path: path.to_owned(), error }
    }

    pub(super) fn unreadable(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unreadable { path: path.to_owned(), reason: reason.into() }
    }

    /// Whether nobody reads what is written.
    pub fn is_reader_gone(&self) -> bool {
        matches!(self, Self::Io { error, .. } if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

impl fmt::Display for ImageError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ending { path } => {
                write!(f, "{} ends in none of .tga, .png, .bmp, .ppm, .pfm and .exr", shown(path))
            }
            Self::Folder { path } => write!(f, "cannot write {}: it is a folder", shown(path)),
            Self::NoFolder { path, folder } => {
                write!(f, "cannot write {}: there is no folder {}", shown(path), shown(folder))
            }
            Self::Io { action, path, error } => write!(f, "cannot {action} {}: {error}", shown(path)),
            Self::Sides { path, width, height } => {
                write!(f, "cannot write {}: {width} x {height} is above 65535 pixels a side", shown(path))
            }
            Self::TooLargeForBmp { path, width, height } => {
                let path = shown(path);
                write!(
                    f,
                    "cannot write {path}: {width} x {height} pixels are above 4 GB, where a BMP file ends"
                )
            }
            Self::Unreadable { path, reason } => write!(f, "cannot read {}: {reason}", shown(path)),
            Self::NoPart { path } => {
                write!(f, "{} is no part of a picture, as `-region` makes it", shown(path))
            }
            Self::Whole { path, size: [width, height] } => {
                let path = shown(path);
                write!(
                    f,
                    "{path} is a whole picture of {width} x {height} pixels, and no part as `-region` makes it"
                )
            }
            Self::NoChecksum { path } => {
                write!(f, "{} is a part without a checksum: render it again with this program", shown(path))
            }
            Self::Damaged { path } => {
                write!(f, "{} is damaged: it is not what its checksum was made of", shown(path))
            }
            Self::OtherEncoding { path } => {
                write!(f, "{} is no part of a picture as this program encodes it", shown(path))
            }
            Self::OnlyBytes { path } => {
                write!(f, "cannot write {}: a picture of bytes has no floating-point numbers", shown(path))
            }
            Self::Memory { path, size } => write!(f, "cannot read {}: {size}", shown(path)),
        }
    }
}

impl std::error::Error for ImageError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Io { error, .. } => Some(error),
            _ => None,
        }
    }
}

fn shown(path: &Path) -> String {
    quoted(path)
}
