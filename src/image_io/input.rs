//! Reading of picture files, which may come from any program and need not be valid.

use super::Format;
use super::error::ImageError;
use super::netpbm_input::Text;
use super::part_file::{RowSource, source};
use super::signature::{has_no_pixels, identify};
use super::writer::TGA_HEADER;
use crate::escape::escape;
use crate::memory::{Bytes, with_room};
use crate::picture::{BadSize, CHANNELS, Picture, RED_FIRST, truncate_to_bytes};
use crate::scene::Color;
use image::codecs::bmp::BmpDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder, Limits};
use std::io::{self, Cursor, Read, SeekFrom};
use std::path::Path;

/// Upper bound on the size of a decoded picture, in bytes.
const MAX_BYTES: u64 = 1 << 29;
/// Upper bound on the bytes for a row of a PNG file and for its metadata, such as a compressed colour
/// profile.
const MAX_PNG_EXTRA_BYTES: u64 = 1 << 26;
/// Upper bound on the pixels per byte of a PNG file: a byte of a deflate stream encodes at most 1032 bytes,
/// and each of these at most eight pixels.
const MAX_PNG_PIXELS_PER_BYTE: u64 = 1032 * 8;
/// Upper bound on the pixels in a packet of run-length encoding.
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
    read(path, source(path)?, None).map(|(picture, _)| picture)
}

/// Reads a picture like [`read_picture`], with remarks.
pub fn read_remarked_picture(path: &Path) -> Result<(Picture, Remarks), ImageError> {
    read(path, source(path)?, None)
}

/// Reads a picture like [`read_picture`], of this width and height in pixels. One of another size is an error, for
/// which no memory is allocated.
pub fn read_picture_of_size(path: &Path, size: [u32; 2]) -> Result<Picture, ImageError> {
    read(path, source(path)?, Some(size)).map(|(picture, _)| picture)
}

/// Reads a picture like [`read_picture`] from the bytes of a file with this name.
pub fn read_picture_from(name: &Path, bytes: &[u8]) -> Result<Picture, ImageError> {
    read(name, Box::new(Cursor::new(bytes)), None).map(|(picture, _)| picture)
}

fn read<'a>(
    path: &'a Path,
    mut source: Box<dyn RowSource + 'a>,
    expected: Option<[u32; 2]>,
) -> Result<(Picture, Remarks), ImageError> {
    let length = source.seek(SeekFrom::End(0)).and_then(|length| source.rewind().map(|()| length));
    let length = length.map_err(|error| ImageError::io("read", path, error))?;
    let file = InputFile { path, length, expected };
    let (format, start) = identify(path, &mut *source)?;
    if has_no_pixels(format, &start) {
        return Err(file.without_pixels());
    }
    let picture = match format {
        Format::Tga => file.read_tga(source),
        Format::Png => file.read_png(source),
        Format::Bmp => file.read_bmp(source),
        Format::Ppm | Format::Pfm => return Text::new(file, source).picture(),
        Format::Exr => return file.read_exr(source),
    };
    picture.map(|picture| (picture, Remarks::default()))
}

/// A file that is to be read.
#[derive(Clone, Copy)]
pub(super) struct InputFile<'a> {
    /// For messages.
    pub path: &'a Path,
    /// In bytes.
    pub length: u64,
    /// The only size that is accepted, if not all are.
    expected: Option<[u32; 2]>,
}

impl<'a> InputFile<'a> {
    fn read_png(&self, source: Box<dyn RowSource + 'a>) -> Result<Picture, ImageError> {
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_PNG_EXTRA_BYTES);
        let decoder = PngDecoder::with_limits(source, limits).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MAX_PNG_PIXELS_PER_BYTE))
    }

    fn read_tga(&self, mut source: Box<dyn RowSource + 'a>) -> Result<Picture, ImageError> {
        let mut header = [0; TGA_HEADER];
        source.read_exact(&mut header).map_err(|error| self.coding(error.into()))?;
        let header = TgaHeader(header);
        if !header.has_known_type() {
            return Err(self.bad(format!("TGA of type {} is not supported", header.image_type())));
        }
        let max_pixels = header.max_pixels(self.length);
        let decoder = TgaDecoder::new(header.with_standard_alpha().chain(source));
        self.decode(decoder.map_err(|error| self.coding(error))?, max_pixels)
    }

    fn read_bmp(&self, source: Box<dyn RowSource + 'a>) -> Result<Picture, ImageError> {
        let decoder = BmpDecoder::new(source).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MAX_BMP_PIXELS_PER_BYTE))
    }

    /// Decodes a picture of at most `max_pixels` pixels, which is what the file's length allows.
    fn decode(&self, decoder: impl ImageDecoder, max_pixels: u64) -> Result<Picture, ImageError> {
        let ((width, height), color_type) = (decoder.dimensions(), decoder.color_type());
        let size = [width, height];
        self.check_size(size, max_pixels)?;
        self.check_bytes(size, decoder.total_bytes())?;
        let mut samples = self.zeros(decoder.total_bytes(), size)?;
        decoder.read_image(&mut samples).map_err(|error| match is_end_of_file(&error) {
            true => self.short(size),
            false => self.coding(error),
        })?;
        if color_type == ColorType::Rgb8 {
            return Ok(Picture::from_rgb(width, height, samples));
        }
        let mut rgb = self.zeros(u64::from(width) * u64::from(height) * CHANNELS as u64, size)?;
        to_rgb(color_type, &samples, &mut rgb);
        Ok(Picture::from_rgb(width, height, rgb))
    }

    /// The one check of a picture's size, which every format comes through: no pixels, more than the file is long
    /// enough for, or another size than expected.
    fn check_size(&self, size: [u32; 2], max_pixels: u64) -> Result<(), ImageError> {
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        match self.expected {
            _ if pixels == 0 => Err(self.without_pixels()),
            _ if pixels > max_pixels => Err(self.short(size)),
            Some([width, height]) if [width, height] != size => Err(self
                .bad(format!("its size is {} x {} pixels instead of {width} x {height}", size[0], size[1]))),
            _ => Ok(()),
        }
    }

    fn check_bytes(&self, [width, height]: [u32; 2], bytes: u64) -> Result<(), ImageError> {
        match bytes <= MAX_BYTES {
            true => Ok(()),
            false => Err(self.bad(format!(
                "its {width} x {height} pixels take {}, above the limit of {}",
                Bytes(bytes),
                Bytes(MAX_BYTES)
            ))),
        }
    }

    /// A black picture of this width and height, to be filled from the file.
    pub fn black(&self, size: [u32; 2], max_pixels: u64) -> Result<Picture, ImageError> {
        let [width, height] = size;
        self.check_size(size, max_pixels)?;
        self.check_bytes(size, u64::from(width) * u64::from(height) * CHANNELS as u64)?;
        Picture::new(width, height).map_err(|size| ImageError::Memory { path: self.path.to_owned(), size })
    }

    /// Zeros, to be filled from a file with a picture of this size.
    pub fn zeros(&self, length: u64, [width, height]: [u32; 2]) -> Result<Vec<u8>, ImageError> {
        let size = BadSize { width: width as usize, height: height as usize };
        let room = usize::try_from(length).ok().and_then(|length| with_room(length).ok());
        let mut bytes = room.ok_or_else(|| ImageError::Memory { path: self.path.to_owned(), size })?;
        bytes.resize(length as usize, 0);
        Ok(bytes)
    }

    pub fn bad(&self, reason: impl Into<String>) -> ImageError {
        ImageError::unreadable(self.path, reason)
    }

    pub fn without_pixels(&self) -> ImageError {
        self.bad("the picture has no pixels")
    }

    pub fn short(&self, [width, height]: [u32; 2]) -> ImageError {
        self.bad(format!("it is too short for {width} x {height} pixels"))
    }

    /// The error of a file that ends too early or cannot be read.
    pub fn cut(&self, error: io::Error, size: [u32; 2]) -> ImageError {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => self.short(size),
            _ => ImageError::io("read", self.path, error),
        }
    }

    pub fn coding(&self, error: image::ImageError) -> ImageError {
        match error {
            error if is_end_of_file(&error) => self.bad("it ends within its header"),
            image::ImageError::IoError(error) => ImageError::io("read", self.path, error),
            error => self.bad(escape(&error.to_string())),
        }
    }
}

fn is_end_of_file(error: &image::ImageError) -> bool {
    matches!(error, image::ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof)
}

/// The bytes of the header of a TGA file.
#[derive(Clone, Copy)]
struct TgaHeader([u8; TGA_HEADER]);

impl TgaHeader {
    /// The type: 1 to 3 for colour-mapped, true-colour and grey pictures, and 9 to 11 for the same with
    /// run-length encoding.
    fn image_type(&self) -> u8 {
        self.0[2]
    }

    /// Whether the type is known. The image crate would decode all other types as grey.
    fn has_known_type(&self) -> bool {
        matches!(self.image_type(), 1..=3 | 9..=11)
    }

    /// Upper bound on the number of pixels in a file of this length.
    fn max_pixels(&self, file_length: u64) -> u64 {
        let data = file_length.saturating_sub(TGA_HEADER as u64);
        let bytes_per_pixel = u64::from(self.0[16]).div_ceil(8).max(1);
        match self.image_type() {
            9..=11 => (data / (1 + bytes_per_pixel)).saturating_mul(MAX_PIXELS_PER_PACKET),
            _ => data / bytes_per_pixel,
        }
    }

    /// The header with the number of alpha bits that the image crate expects for the size of a pixel. Many
    /// programs store another number, such as 8 for pixels of 24 bits. This is harmless, because alpha is
    /// ignored.
    fn with_standard_alpha(mut self) -> impl Read {
        let is_grey_with_alpha = matches!((self.image_type(), self.0[16]), (3 | 11, 16));
        self.0[17] = self.0[17] & 0xF0 | if is_grey_with_alpha { 8 } else { 0 };
        Cursor::new(self.0)
    }
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

/// The level nearest to a sample between 0 and `white`.
pub(super) fn level(sample: u32, white: u32) -> u8 {
    ((sample * 255 + white / 2) / white) as u8
}

/// Sets a row of bytes to these colours, and counts those that are beyond bytes.
pub(super) fn fill_row(colors: &[Color], row: &mut [u8]) -> u64 {
    truncate_to_bytes::<RED_FIRST>(colors, row);
    let is_shown = |channel: f64| (0.0..=1.0).contains(&channel);
    colors.iter().filter(|color| !color.to_array().into_iter().all(is_shown)).count() as u64
}

#[cfg(test)]
mod test_files;
#[cfg(test)]
mod tests;
