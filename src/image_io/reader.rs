//! Reading of picture files, which may come from any program and need not be valid.

use super::error::ImageError;
use super::format::{Format, identify};
use super::header::TGA_HEADER;
use super::{exr, netpbm};
use crate::base::escape::escape;
use crate::base::memory::{Bytes, with_room};
use crate::picture::{CHANNELS, Color, Picture, RED_FIRST, truncate_to_bytes};
use image::codecs::bmp::BmpDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder, Limits};
use std::fs::{self, File};
use std::io::{self, Cursor, Read};
use std::path::Path;

/// Upper bound on the length of a file, in bytes: that of the largest picture in single precision, with alpha.
const LONGEST_FILE: u64 = 1 << 32;
/// Upper bound on the size of a decoded picture, in bytes.
const MAX_BYTES: u64 = 1 << 29;
/// Upper bound on the bytes for a row of a PNG file and for its metadata, such as a compressed colour
/// profile.
const MAX_PNG_EXTRA_BYTES: u64 = 1 << 26;
/// Upper bound on the pixels per byte of a PNG file: a byte of a deflate stream encodes at most 1032 bytes,
/// and each of these at most eight pixels.
const MAX_PNG_PIXELS_PER_BYTE: u64 = 1032 * 8;
/// Upper bound on the pixels in a packet of TGA's run-length encoding.
const MAX_PIXELS_PER_PACKET: u64 = 128;
/// Upper bound on the pixels per byte of a BMP file: two bytes of its run-length encoding stand for 255 pixels.
const MAX_BMP_PIXELS_PER_BYTE: u64 = 128;

/// What a user should know about a picture that was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remarks {
    /// The number of pixels that a byte does not show, because they are below 0, above 1 or not numbers.
    pub clamped: u64,
    /// A line end follows the last pixel.
    pub has_line_end: bool,
}

/// Reads a picture of any common variant of TGA, PNG, BMP, PPM and its relatives, PFM or OpenEXR. The first bytes
/// decide the format. An error names it if the file's name has the ending of another one.
///
/// The result is 8-bit RGB. Alpha is ignored: a transparent pixel keeps its colour and is not blended with a
/// background. Grey becomes three equal channels. Samples of other than eight bits are rounded to the nearest level.
///
/// Numbers of PFM and OpenEXR files become bytes as the colours of a rendering do: 255 times each, cut to whole numbers
/// and clamped. OpenEXR files are read if they have one part of scan lines, without compression or with RLE or ZIP.
///
/// Only regular files are read, because a pipe could block the program. The size in a header is checked
/// against the file's length before memory is allocated for it, and a picture of more than 512 MiB is an
/// error.
pub fn read_picture(path: &Path) -> Result<Picture, ImageError> {
    read_remarked_picture(path).map(|(picture, _)| picture)
}

/// Reads a picture like [`read_picture`], with remarks.
pub fn read_remarked_picture(path: &Path) -> Result<(Picture, Remarks), ImageError> {
    read(path, &file(path)?)
}

/// Reads a picture like [`read_picture`] from the bytes of a file with this name.
pub fn read_picture_from(name: &Path, bytes: &[u8]) -> Result<Picture, ImageError> {
    read(name, bytes).map(|(picture, _)| picture)
}

/// Opens a regular file. A pipe could block the program.
pub(super) fn open_regular(path: &Path) -> Result<File, ImageError> {
    let failed = |error| ImageError::io("read", path, error);
    match fs::metadata(path).map_err(failed)?.is_file() {
        true => File::open(path).map_err(failed),
        false => Err(ImageError::new("read", path, "it is not a regular file")),
    }
}

/// Returns the bytes of a file.
fn file(path: &Path) -> Result<Vec<u8>, ImageError> {
    let file = open_regular(path)?;
    let read = || {
        let length = file.metadata()?.len();
        if length > LONGEST_FILE {
            return Err(io::Error::other(format!("it is longer than {}", Bytes(LONGEST_FILE))));
        }
        let mut bytes = with_room(length as usize)?;
        file.take(length).read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|error| ImageError::io("read", path, error))
}

fn read(path: &Path, bytes: &[u8]) -> Result<(Picture, Remarks), ImageError> {
    let format = identify(path, bytes)?;
    let (reader, length) = (Reader { path, bytes }, bytes.len() as u64);
    if has_no_pixels(format, bytes) {
        return Err(reader.without_pixels());
    }
    let picture = match format {
        Format::Tga => reader.tga(),
        Format::Png => {
            let mut limits = Limits::no_limits();
            limits.max_alloc = Some(MAX_PNG_EXTRA_BYTES);
            reader
                .decode(PngDecoder::with_limits(Cursor::new(bytes), limits), length * MAX_PNG_PIXELS_PER_BYTE)
        }
        Format::Bmp => reader.decode(BmpDecoder::new(Cursor::new(bytes)), length * MAX_BMP_PIXELS_PER_BYTE),
        Format::Ppm | Format::Pfm => return netpbm::read(reader),
        Format::Exr => return exr::read(reader),
    };
    picture.map(|picture| (picture, Remarks::default()))
}

/// Returns true if a header of a format that the image crate reads has a width or height of 0, which the crate would
/// refuse in its own words.
fn has_no_pixels(format: Format, bytes: &[u8]) -> bool {
    let sides = match format {
        Format::Tga => [12..14, 14..16],
        Format::Png => [16..20, 20..24],
        // The oldest headers have 12 bytes.
        Format::Bmp if bytes.get(14) == Some(&12) => [18..20, 20..22],
        Format::Bmp => [18..22, 22..26],
        Format::Ppm | Format::Pfm | Format::Exr => return false,
    };
    sides.into_iter().any(|side| bytes.get(side).is_some_and(|side| side.iter().all(|&byte| byte == 0)))
}

/// The bytes of a file that have not been read yet.
#[derive(Clone, Copy)]
pub(super) struct Reader<'a> {
    /// For messages.
    pub path: &'a Path,
    pub bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Takes the next bytes. `None` if there are not as many.
    pub fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    /// Takes bytes up to a zero, which is left out.
    pub fn take_text(&mut self) -> Option<&'a [u8]> {
        let length = self.bytes.iter().position(|&byte| byte == 0)?;
        self.take(length + 1).map(|text| &text[..length])
    }

    /// Takes whole numbers of four bytes each, of which the lowest comes first.
    pub fn take_ints<const N: usize>(&mut self) -> Option<[i32; N]> {
        let bytes = self.take(4 * N)?.as_chunks().0;
        Some(std::array::from_fn(|index| i32::from_le_bytes(bytes[index])))
    }

    fn tga(&self) -> Result<Picture, ImageError> {
        let Some((&header, rest)) = self.bytes.split_first_chunk::<TGA_HEADER>() else {
            return Err(self.bad("it ends within its header"));
        };
        let (kind, bits, length) = (header[2], header[16], rest.len() as u64);
        let pixel = u64::from(bits).div_ceil(8).max(1);
        // The image crate decodes all other types as grey.
        let max_pixels = match kind {
            1..=3 => length / pixel,
            9..=11 => (length / (1 + pixel)).saturating_mul(MAX_PIXELS_PER_PACKET),
            _ => return Err(self.bad(format!("TGA of type {kind} is not supported"))),
        };
        // The crate expects the number of alpha bits that belongs to the size of a pixel. Many programs store another
        // one, such as 8 for pixels of 24 bits, which is harmless, because alpha is ignored.
        let mut header = header;
        header[17] = header[17] & 0xf0 | if matches!((kind, bits), (3 | 11, 16)) { 8 } else { 0 };
        self.decode(TgaDecoder::new(Cursor::new(header).chain(rest)), max_pixels)
    }

    /// Decodes a picture of at most `max_pixels` pixels, which is what the file's length allows.
    fn decode<D: ImageDecoder>(
        &self,
        decoder: image::ImageResult<D>,
        max_pixels: u64,
    ) -> Result<Picture, ImageError> {
        let decoder = decoder.map_err(|error| self.undecoded(error, "it ends within its header"))?;
        let ((width, height), color_type, length) =
            (decoder.dimensions(), decoder.color_type(), decoder.total_bytes());
        let size = [width, height];
        self.check_size(size, max_pixels, length)?;
        let mut samples = with_room(length as usize).map_err(|error| self.io(error))?;
        samples.resize(length as usize, 0);
        decoder.read_image(&mut samples).map_err(|error| self.undecoded(error, &too_short(size)))?;
        if color_type == ColorType::Rgb8 {
            return Ok(Picture::from_rgb(width, height, samples));
        }
        let mut picture = self.black(size, max_pixels)?;
        to_rgb(color_type, &samples, picture.pixels_mut());
        Ok(picture)
    }

    /// Checks the size of a picture that takes this number of bytes when it is decoded.
    fn check_size(
        &self,
        size @ [width, height]: [u32; 2],
        max_pixels: u64,
        bytes: u64,
    ) -> Result<(), ImageError> {
        let [shown, limit] = [bytes, MAX_BYTES].map(Bytes);
        match u64::from(width) * u64::from(height) {
            0 => Err(self.without_pixels()),
            pixels if pixels > max_pixels => Err(self.short(size)),
            _ if bytes > MAX_BYTES => {
                Err(self
                    .bad(format!("its {width} x {height} pixels take {shown}, above the limit of {limit}")))
            }
            _ => Ok(()),
        }
    }

    /// Returns a black picture, to be filled from the file, which has at most `max_pixels` pixels.
    pub fn black(&self, size @ [width, height]: [u32; 2], max_pixels: u64) -> Result<Picture, ImageError> {
        let pixels = u64::from(width) * u64::from(height);
        self.check_size(size, max_pixels, pixels.saturating_mul(CHANNELS as u64))?;
        Picture::new(width, height).map_err(|size| self.io(io::Error::new(io::ErrorKind::OutOfMemory, size)))
    }

    pub fn bad(&self, reason: impl Into<String>) -> ImageError {
        ImageError::new("read", self.path, reason)
    }

    pub fn without_pixels(&self) -> ImageError {
        self.bad("the picture has no pixels")
    }

    pub fn short(&self, size: [u32; 2]) -> ImageError {
        self.bad(too_short(size))
    }

    fn io(&self, error: impl Into<io::Error>) -> ImageError {
        ImageError::io("read", self.path, error)
    }

    /// Returns the error of a decoder, with other words for a file that ends too early.
    fn undecoded(&self, error: image::ImageError, short: &str) -> ImageError {
        match error {
            image::ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                self.bad(short)
            }
            image::ImageError::IoError(error) => self.io(error),
            error => self.bad(escape(&error.to_string())),
        }
    }
}

pub(super) fn too_short([width, height]: [u32; 2]) -> String {
    format!("it is too short for {width} x {height} pixels")
}

/// Converts decoded samples to bytes of red, green and blue.
fn to_rgb(color_type: ColorType, samples: &[u8], rgb: &mut [u8]) {
    let [green, blue] = if color_type.has_color() { [1, 2] } else { [0, 0] };
    let pixel_bytes = usize::from(color_type.bytes_per_pixel());
    let is_wide = pixel_bytes == 2 * usize::from(color_type.channel_count());
    for (pixel, samples) in rgb.as_chunks_mut().0.iter_mut().zip(samples.chunks_exact(pixel_bytes)) {
        *pixel = [0, green, blue].map(|channel| match is_wide {
            true => level(u16::from_ne_bytes([samples[2 * channel], samples[2 * channel + 1]]).into(), 65535),
            false => samples[channel],
        });
    }
}

/// Returns the level nearest to a sample between 0 and `white`.
pub(super) fn level(sample: u32, white: u32) -> u8 {
    ((sample * 255 + white / 2) / white) as u8
}

/// Sets a row of bytes to these colours. Returns the number of those that are beyond bytes.
pub(super) fn fill_row(colors: &[Color], row: &mut [u8]) -> u64 {
    truncate_to_bytes::<RED_FIRST>(colors, row);
    let is_shown = |channel: f64| (0.0..=1.0).contains(&channel);
    colors.iter().filter(|color| !color.to_array().into_iter().all(is_shown)).count() as u64
}

#[cfg(test)]
mod test_files;
#[cfg(test)]
mod tests;
