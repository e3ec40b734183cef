//! Picture files that anybody may have written, and what becomes of them.

use super::Format;
use super::error::ImageError;
use crate::picture::{BadSize, Picture};
use image::codecs::png::PngDecoder;
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder, Limits};
use std::fs::{self, File};
use std::io::{self, BufReader, Read};
use std::path::Path;

/// The most bytes that a decoded picture may take.
const MOST_BYTES: u64 = 1 << 29;
/// The most bytes for a row of a PNG file and what else it holds, such as a colour profile, which may
/// be deflated.
const MOST_PNG_EXTRA_BYTES: u64 = 1 << 26;
/// A byte of a deflated stream stands for no more than 1032 bytes, and a byte of these for no more
/// than eight pixels.
const MOST_PNG_PIXELS_PER_BYTE: u64 = 1032 * 8;
/// A packet of run-length encoding stands for no more pixels than this.
const MOST_PIXELS_PER_PACKET: u64 = 128;
/// The bytes before the data of a TGA file.
const TGA_HEADER: usize = 18;

/// Reads a picture of any common variant of TGA or PNG, told apart by the file's ending.
///
/// The result has 8-bit RGB. Alpha is ignored: a transparent pixel has its colour, not that of
/// something behind it. Grey becomes three equal channels. Of 16-bit channels the high byte is kept;
/// 5-bit channels are scaled by 255/31 and rounded, as most viewers do.
///
/// Only regular files are read, so that a pipe cannot make the program wait. The sizes that a header
/// claims are checked against the file's length before there is memory for them, and a picture of
/// more than 512 MiB is an error. Errors name the file and are one line.
pub fn read_picture(path: &Path) -> Result<Picture, ImageError> {
    let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
    let failed = |error| ImageError::io("read", path, error);
    let found = fs::metadata(path).map_err(failed)?;
    if !found.is_file() {
        return Err(ImageError::NotAFile { path: path.to_owned() });
    }
    let file = InputFile { path, length: found.len() };
    let reader = BufReader::new(File::open(path).map_err(failed)?);
    match format {
        Format::Tga => file.read_tga(reader),
        Format::Png => file.read_png(reader),
    }
}

/// What messages and checks need.
struct InputFile<'a> {
    path: &'a Path,
    length: u64,
}

impl InputFile<'_> {
    fn read_png(&self, reader: BufReader<File>) -> Result<Picture, ImageError> {
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MOST_PNG_EXTRA_BYTES);
        let decoder = PngDecoder::with_limits(reader, limits).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MOST_PNG_PIXELS_PER_BYTE))
    }

    fn read_tga(&self, mut reader: BufReader<File>) -> Result<Picture, ImageError> {
        let mut header = [0; TGA_HEADER];
        reader.read_exact(&mut header).map_err(|error| self.coding(error.into()))?;
        let header = TgaHeader(header);
        if !header.has_known_type() {
            return Err(ImageError::TgaType { path: self.path.to_owned(), image_type: header.image_type() });
        }
        let most_pixels = header.most_pixels(self.length);
        let decoder = TgaDecoder::new(header.with_standard_alpha().chain(reader));
        self.decode(decoder.map_err(|error| self.coding(error))?, most_pixels)
    }

    /// `most_pixels` is how many the file's length allows.
    fn decode(&self, decoder: impl ImageDecoder, most_pixels: u64) -> Result<Picture, ImageError> {
        let ((width, height), color_type) = (decoder.dimensions(), decoder.color_type());
        if u64::from(width) * u64::from(height) > most_pixels {
            return Err(self.short(width, height));
        }
        let bytes = Some(decoder.total_bytes()).filter(|&bytes| bytes <= MOST_BYTES);
        let too_large = || ImageError::Memory {
            path: self.path.to_owned(),
            size: BadSize { width: width as usize, height: height as usize },
        };
        let mut samples = bytes.and_then(zeros).ok_or_else(too_large)?;
        decoder.read_image(&mut samples).map_err(|error| match is_end_of_file(&error) {
            true => self.short(width, height),
            false => self.coding(error),
        })?;
        let pixels = to_rgb(color_type, samples).ok_or_else(too_large)?;
        Ok(Picture::from_rgb(width, height, pixels))
    }

    fn short(&self, width: u32, height: u32) -> ImageError {
        ImageError::Short { path: self.path.to_owned(), width, height }
    }

    fn coding(&self, error: image::ImageError) -> ImageError {
        match is_end_of_file(&error) {
            true => ImageError::NoHeader { path: self.path.to_owned() },
            false => ImageError::coding("read", self.path, error),
        }
    }
}

fn is_end_of_file(error: &image::ImageError) -> bool {
    matches!(error, image::ImageError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof)
}

/// The header of a TGA file as it is stored.
#[derive(Clone, Copy)]
struct TgaHeader([u8; TGA_HEADER]);

impl TgaHeader {
    /// 1 to 3 for colour-mapped, true-colour and grey pictures, 8 more with run-length encoding.
    fn image_type(&self) -> u8 {
        self.0[2]
    }

    /// The image crate takes every other type for grey.
    fn has_known_type(&self) -> bool {
        matches!(self.image_type(), 1..=3 | 9..=11)
    }

    /// In a file of this length.
    fn most_pixels(&self, file_length: u64) -> u64 {
        let data = file_length.saturating_sub(TGA_HEADER as u64);
        let bytes_per_pixel = u64::from(self.0[16]).div_ceil(8).max(1);
        match self.image_type() {
            9..=11 => (data / (1 + bytes_per_pixel)).saturating_mul(MOST_PIXELS_PER_PACKET),
            _ => data / bytes_per_pixel,
        }
    }

    /// The header with the number of alpha bits that the image crate expects of the pixel's size. Many
    /// programs store another one, such as 8 for 24 bits, and alpha is ignored anyway.
    fn with_standard_alpha(mut self) -> impl Read {
        let is_grey_with_alpha = matches!((self.image_type(), self.0[16]), (3 | 11, 16));
        self.0[17] = self.0[17] & 0xF0 | if is_grey_with_alpha { 8 } else { 0 };
        io::Cursor::new(self.0)
    }
}

/// None if there is no memory.
fn zeros(length: u64) -> Option<Vec<u8>> {
    let length = usize::try_from(length).ok()?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length).ok()?;
    bytes.resize(length, 0);
    Some(bytes)
}

/// The decoded samples as bytes of red, green and blue. None if there is no memory.
fn to_rgb(color_type: ColorType, samples: Vec<u8>) -> Option<Vec<u8>> {
    if color_type == ColorType::Rgb8 {
        return Some(samples);
    }
    let channel_bytes = usize::from(color_type.bytes_per_pixel() / color_type.channel_count());
    // Samples are in the processor's order of bytes.
    let high = if cfg!(target_endian = "little") { channel_bytes - 1 } else { 0 };
    let [green, blue] = if color_type.has_color() { [1, 2] } else { [0, 0] };
    let pixels = samples.chunks_exact(usize::from(color_type.bytes_per_pixel()));
    let mut rgb = zeros(pixels.len() as u64 * 3)?;
    for (pixel, sample) in rgb.as_chunks_mut().0.iter_mut().zip(pixels) {
        *pixel = [0, green, blue].map(|channel| sample[channel * channel_bytes + high]);
    }
    Some(rgb)
}

#[cfg(test)]
mod test_files;
#[cfg(test)]
mod tests;
