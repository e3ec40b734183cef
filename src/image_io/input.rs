//! Reading of picture files, which may come from any program and need not be valid.

use super::Format;
use super::error::ImageError;
use super::writer::TGA_HEADER;
use crate::memory::with_room;
use crate::picture::{BadSize, CHANNELS, Picture};
use image::codecs::bmp::BmpDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::pnm::PnmDecoder;
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder, Limits};
use std::fs::{self, File};
use std::io::{self, BufReader, Read};
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
/// Upper bound on the pixels per byte of a file in one of the formats of Netpbm, which may have one bit per pixel.
const MAX_PNM_PIXELS_PER_BYTE: u64 = 8;

/// Reads a picture of any common variant of TGA, PNG, BMP or PPM, or of floating-point numbers. The format is determined by the
/// end of the name.
///
/// The result is 8-bit RGB. Alpha is ignored: a transparent pixel keeps its colour and is not blended with a
/// background. Grey becomes three equal channels. 16-bit channels are reduced to their high byte, and 5-bit
/// channels are scaled by 255/31 and rounded, as in most viewers.
///
/// Numbers of PFM and OpenEXR files become bytes as the colours of a rendering do: 255 times each, cut to whole numbers
/// and clamped. OpenEXR files are read if they have one part of scan lines, without compression or with ZIP.
///
/// Only regular files are read, because a pipe could block the program. The size in a header is checked
/// against the file's length before memory is allocated for it, and a picture of more than 512 MiB is an
/// error.
pub fn read_picture(path: &Path) -> Result<Picture, ImageError> {
    read(path, None).map(|(picture, _)| picture)
}

/// Reads a picture like [`read_picture`], and counts the pixels whose numbers a byte does not show, because they are
/// below 0, above 1 or not numbers.
pub fn read_clamped_picture(path: &Path) -> Result<(Picture, u64), ImageError> {
    read(path, None)
}

/// Reads a picture like [`read_picture`], of this width and height in pixels. One of another size is an error, for
/// which no memory is allocated.
pub fn read_picture_of_size(path: &Path, size: [u32; 2]) -> Result<Picture, ImageError> {
    read(path, Some(size)).map(|(picture, _)| picture)
}

fn read(path: &Path, expected: Option<[u32; 2]>) -> Result<(Picture, u64), ImageError> {
    let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
    let failed = |error| ImageError::io("read", path, error);
    let found = fs::metadata(path).map_err(failed)?;
    if !found.is_file() {
        return Err(ImageError::NotAFile { path: path.to_owned() });
    }
    let file = InputFile { path, length: found.len(), expected };
    let reader = BufReader::new(File::open(path).map_err(failed)?);
    match format {
        Format::Tga => file.read_tga(reader).map(|picture| (picture, 0)),
        Format::Png => file.read_png(reader).map(|picture| (picture, 0)),
        Format::Bmp => file.read_bmp(reader).map(|picture| (picture, 0)),
        Format::Ppm => file.read_ppm(reader).map(|picture| (picture, 0)),
        Format::Pfm => file.read_pfm(reader),
        Format::Exr => file.read_exr(reader),
    }
}

/// A file that is to be read.
pub(super) struct InputFile<'a> {
    /// For messages.
    pub path: &'a Path,
    /// In bytes.
    pub length: u64,
    /// The only size that is accepted, if not all are.
    expected: Option<[u32; 2]>,
}

impl InputFile<'_> {
    fn read_png(&self, reader: BufReader<File>) -> Result<Picture, ImageError> {
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(MAX_PNG_EXTRA_BYTES);
        let decoder = PngDecoder::with_limits(reader, limits).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MAX_PNG_PIXELS_PER_BYTE))
    }

    fn read_tga(&self, mut reader: BufReader<File>) -> Result<Picture, ImageError> {
        let mut header = [0; TGA_HEADER];
        reader.read_exact(&mut header).map_err(|error| self.coding(error.into()))?;
        let header = TgaHeader(header);
        if !header.has_known_type() {
            return Err(ImageError::TgaType { path: self.path.to_owned(), image_type: header.image_type() });
        }
        let max_pixels = header.max_pixels(self.length);
        let decoder = TgaDecoder::new(header.with_standard_alpha().chain(reader));
        self.decode(decoder.map_err(|error| self.coding(error))?, max_pixels)
    }

    fn read_bmp(&self, reader: BufReader<File>) -> Result<Picture, ImageError> {
        let decoder = BmpDecoder::new(reader).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MAX_BMP_PIXELS_PER_BYTE))
    }

    fn read_ppm(&self, reader: BufReader<File>) -> Result<Picture, ImageError> {
        let decoder = PnmDecoder::new(reader).map_err(|error| self.coding(error))?;
        self.decode(decoder, self.length.saturating_mul(MAX_PNM_PIXELS_PER_BYTE))
    }

    /// Decodes a picture of at most `max_pixels` pixels, which is what the file's length allows.
    fn decode(&self, decoder: impl ImageDecoder, max_pixels: u64) -> Result<Picture, ImageError> {
        let ((width, height), color_type) = (decoder.dimensions(), decoder.color_type());
        self.check_size([width, height], max_pixels)?;
        let bytes = Some(decoder.total_bytes()).filter(|&bytes| bytes <= MAX_BYTES);
        let too_large = || self.too_large([width, height]);
        let mut samples = bytes.and_then(zeros).ok_or_else(too_large)?;
        decoder.read_image(&mut samples).map_err(|error| match is_end_of_file(&error) {
            true => self.short(width, height),
            false => self.coding(error),
        })?;
        let pixels = to_rgb(color_type, samples).ok_or_else(too_large)?;
        Ok(Picture::from_rgb(width, height, pixels))
    }

    /// An error if the file is too short for this width and height, or if another size is expected.
    fn check_size(&self, size: [u32; 2], max_pixels: u64) -> Result<(), ImageError> {
        let [width, height] = size;
        if u64::from(width) * u64::from(height) > max_pixels {
            return Err(self.short(width, height));
        }
        match self.expected {
            Some(expected) if expected != size => {
                Err(ImageError::OtherSize { path: self.path.to_owned(), size, expected })
            }
            _ => Ok(()),
        }
    }

    /// A black picture of this width and height, to be filled from the file.
    pub fn black(&self, size: [u32; 2], max_pixels: u64) -> Result<Picture, ImageError> {
        self.check_size(size, max_pixels)?;
        let [width, height] = size;
        let fits = u64::from(width) * u64::from(height) * CHANNELS as u64 <= MAX_BYTES;
        let picture = fits.then(|| Picture::new(width, height).ok()).flatten();
        picture.ok_or_else(|| self.too_large(size))
    }

    fn too_large(&self, size: [u32; 2]) -> ImageError {
        let [width, height] = size.map(|n| n as usize);
        ImageError::Memory { path: self.path.to_owned(), size: BadSize { width, height } }
    }

    /// The error of a file of floating-point numbers that cannot be read for this reason.
    pub fn bad(&self, reason: &'static str) -> ImageError {
        ImageError::BadFloats { path: self.path.to_owned(), reason }
    }

    pub fn short(&self, width: u32, height: u32) -> ImageError {
        ImageError::Short { path: self.path.to_owned(), width, height }
    }

    pub fn coding(&self, error: image::ImageError) -> ImageError {
        match is_end_of_file(&error) {
            true => ImageError::NoHeader { path: self.path.to_owned() },
            false => ImageError::coding("read", self.path, error),
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
        io::Cursor::new(self.0)
    }
}

/// A list of zeros; none if there is not enough memory.
fn zeros(length: u64) -> Option<Vec<u8>> {
    let length = usize::try_from(length).ok()?;
    let mut bytes = with_room(length).ok()?;
    bytes.resize(length, 0);
    Some(bytes)
}

/// Converts decoded samples to bytes of red, green and blue. None if there is not enough memory.
fn to_rgb(color_type: ColorType, samples: Vec<u8>) -> Option<Vec<u8>> {
    if color_type == ColorType::Rgb8 {
        return Some(samples);
    }
    let channel_bytes = usize::from(color_type.bytes_per_pixel() / color_type.channel_count());
    // Samples are in the native byte order.
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
