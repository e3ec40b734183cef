//! Reading and writing of TGA and PNG files, parts of pictures, pictures embedded in pages, and writing of text files.

pub(crate) mod embedded;
mod error;
mod input;
mod merge;
mod mosaic;
mod output;
mod part;
mod part_file;
mod spool;
mod text;
mod writer;

pub use error::ImageError;
pub use input::{read_picture, read_picture_of_size};
pub use merge::{Difference, Merge, MergeError};
pub use output::OutputFile;
pub use part::{NotPart, Part};
pub use part_file::{PartFile, Rows};
pub use text::TextFile;
pub use writer::PictureWriter;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The format of a picture file, which is determined by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.tga`, byte for byte as the course's program writes it.
    Tga,
    /// `.png`, 8 bits per channel, without alpha.
    Png,
}

impl Format {
    /// The format by the last four bytes of the name, in upper or lower case; none if they are not known.
    pub fn of(path: &Path) -> Option<Self> {
        let end = path.as_os_str().as_encoded_bytes().last_chunk::<4>()?;
        match end.to_ascii_lowercase().as_slice() {
            b".tga" => Some(Self::Tga),
            b".png" => Some(Self::Png),
            _ => None,
        }
    }
}

/// The name of a file beside another: `o.rest.tga` beside `o.tga` for the word `rest`.
pub fn beside(path: &Path, word: &str) -> PathBuf {
    let mut name = OsString::from(path.file_stem().unwrap_or_default());
    name.extend([".".as_ref(), word.as_ref(), ".".as_ref(), path.extension().unwrap_or_default()]);
    path.with_file_name(name)
}
