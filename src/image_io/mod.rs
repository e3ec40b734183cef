//! Reading and writing of TGA, PNG, BMP, PPM, PFM and OpenEXR files, parts of pictures, pictures embedded in pages, and writing
//! of text files.

mod bmp;
mod checksum;
mod complete_file;
pub(crate) mod embedded;
mod error;
mod exr;
mod exr_input;
mod file_id;
mod float_rows;
mod input;
mod merge;
mod mosaic;
mod netpbm_input;
mod output;
mod part;
mod part_file;
mod signature;
mod spool;
mod text;
mod writer;

pub use complete_file::{CompleteFile, put_in_place};
pub use error::ImageError;
pub use file_id::FileId;
pub use float_rows::{Content, Exceptional};
pub use input::{Remarks, read_picture, read_picture_from, read_picture_of_size, read_remarked_picture};
pub use merge::{Difference, Merge, MergeError};
pub use output::OutputFile;
pub use part::{NotPart, Part};
pub use part_file::{PartFile, Rows};
pub use text::TextFile;
pub use writer::{PictureWriter, part_beside};

use serde::Serialize;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// The format of a picture file, which is determined by the end of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// `.tga`, byte for byte as the course's program writes it.
    Tga,
    /// `.png`, 8 bits per channel, without alpha.
    Png,
    /// `.bmp`, 24 bits per pixel, with rows from the bottom.
    Bmp,
    /// `.ppm`, 8 bits per channel.
    Ppm,
    /// `.pfm`, single precision, without clamping.
    Pfm,
    /// `.exr`, OpenEXR in single precision, without clamping.
    Exr,
}

impl Format {
    /// The format of a file to write, by the last four bytes of its name, in upper or lower case; none if they are not
    /// known.
    pub fn of(path: &Path) -> Option<Self> {
        let end = path.as_os_str().as_encoded_bytes().last_chunk::<4>()?;
        match end.to_ascii_lowercase().as_slice() {
            b".tga" => Some(Self::Tga),
            b".png" => Some(Self::Png),
            b".bmp" => Some(Self::Bmp),
            b".ppm" => Some(Self::Ppm),
            b".pfm" => Some(Self::Pfm),
            b".exr" => Some(Self::Exr),
            _ => None,
        }
    }

    /// The format of a file to read. It may also have the ending of a relative of PPM.
    pub fn of_input(path: &Path) -> Option<Self> {
        let end = path.as_os_str().as_encoded_bytes().last_chunk::<4>()?.to_ascii_lowercase();
        let is_relative = [b".pbm", b".pgm", b".pnm", b".pam"].iter().any(|ending| **ending == *end);
        if is_relative { Some(Self::Ppm) } else { Self::of(path) }
    }

    /// The format with this name, as in an ending without the dot.
    pub fn named(name: &str) -> Option<Self> {
        Self::of(Path::new(&format!(".{name}"))).filter(|_| name.len() == 3)
    }

    /// Whether its files can say which part of a larger picture they are.
    pub fn has_parts(self) -> bool {
        matches!(self, Self::Tga | Self::Png)
    }

    /// Whether it holds numbers as they were rendered, and not bytes.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Pfm | Self::Exr)
    }
}

/// The name of a file beside another: `o.rest.tga` beside `o.tga` for the word `rest`.
pub fn beside(path: &Path, word: &str) -> PathBuf {
    let mut name = OsString::from(path.file_stem().unwrap_or_default());
    name.push(".");
    name.push(word);
    if let Some(extension) = path.extension() {
        name.extend([".".as_ref(), extension]);
    }
    path.with_file_name(name)
}
