//! TGA and PNG files in and out.

mod error;
mod output;
mod spool;
mod writer;

pub use error::ImageError;
pub use output::OutputFile;
pub use writer::PictureWriter;

use crate::picture::Picture;
use image::ImageReader;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// The kinds of picture file, told apart by the end of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.tga`, byte for byte as the course's program writes it.
    Tga,
    /// `.png`, 8 bits per channel, without alpha.
    Png,
}

impl Format {
    /// By the last four bytes of the name, in either case; `None` for any other.
    pub fn of(path: &Path) -> Option<Self> {
        let end = path.as_os_str().as_encoded_bytes().last_chunk::<4>()?;
        match end.to_ascii_lowercase().as_slice() {
            b".tga" => Some(Self::Tga),
            b".png" => Some(Self::Png),
            _ => None,
        }
    }

    fn of_crate(self) -> image::ImageFormat {
        match self {
            Self::Tga => image::ImageFormat::Tga,
            Self::Png => image::ImageFormat::Png,
        }
    }
}

/// Reads a picture of any TGA or PNG variant, reduced to 8-bit RGB; alpha is dropped.
///
/// Errors name the file. A picture of more than 512 MiB is an error.
pub fn read(path: &Path) -> Result<Picture, ImageError> {
    let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
    let file = File::open(path).map_err(|error| ImageError::io("open", path, error))?;
    let decoded = ImageReader::with_format(BufReader::new(file), format.of_crate()).decode();
    let rgb = decoded.map_err(|error| ImageError::coding("read", path, error))?.into_rgb8();
    let (width, height) = rgb.dimensions();
    Ok(Picture::from_rgb(width, height, rgb.into_raw()))
}
