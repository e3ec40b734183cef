//! Reading of picture files, which may come from any program and need not be valid.
//!
//! The message of an error is the reason alone, to which [`read_picture`] adds the file.

use super::cannot;
use super::common_to_readers::{
    ReadNotes, Wanted, check_bytes, level, no_pixels, open_regular, refused, too_short, undecoded, zeros,
};
use super::format::{CUT_HEADER, Format, TGA_HEADER, identify};
use super::{exr, netpbm};
use crate::base::memory::{Bytes, with_room};
use crate::diagnostic::Diagnostic;
use crate::picture::{Picture, Pixels};
use image::codecs::bmp::BmpDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::tga::TgaDecoder;
use image::{ColorType, ImageDecoder, Limits};
use std::io::{Cursor, Read};
use std::path::Path;

/// Upper bound on the length of a file, in bytes.
const LONGEST_FILE: u64 = 1 << 32;
/// Upper bound on the size of a decoded picture from a file, in bytes.
const MAX_BYTES: u64 = 1 << 29;
/// Upper bound on the bytes for a row of a PNG file and for its metadata, such as a compressed colour
/// profile.
const MAX_PNG_EXTRA_BYTES: u64 = 1 << 26;
/// Upper bound on the pixels per byte of a file. In PNG files, which are the densest, a byte of a deflate stream
/// encodes at most 1032 bytes, and each of these at most eight pixels.
const MAX_PIXELS_PER_BYTE: u64 = 1032 * 8;

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
pub fn read_picture(path: &Path) -> Result<Picture, Diagnostic> {
    read_pixels(path, Wanted::Bytes).map(|(picture, _)| picture.into_bytes())
}

/// Reads a picture like [`read_picture`], with notes.
pub fn read_pixels(path: &Path, wanted: Wanted) -> Result<(Pixels, ReadNotes), Diagnostic> {
    load_pixels(path, wanted).map_err(|reason| cannot("read", path, reason))
}

/// Reads a picture like [`read_picture`] from the bytes of a file with this name. One that takes more than `limit`
/// bytes when it is decoded is an error.
pub fn read_picture_from(name: &Path, bytes: &[u8], limit: u64) -> Result<Picture, Diagnostic> {
    let decoded = decode(name, bytes, limit, Wanted::Bytes).map_err(|reason| cannot("read", name, reason))?;
    Ok(decoded.0.into_bytes())
}

/// Reads a picture like [`read_pixels`]. The message of an error does not name the file.
pub fn load_pixels(path: &Path, wanted: Wanted) -> Result<(Pixels, ReadNotes), Diagnostic> {
    let file = open_regular(path)?;
    let length = file.metadata()?.len();
    if length > LONGEST_FILE {
        return Err(Diagnostic::error(format!("it is longer than {}", Bytes(LONGEST_FILE))));
    }
    let mut bytes = with_room(length as usize)?;
    file.take(length).read_to_end(&mut bytes)?;
    decode(path, &bytes, MAX_BYTES, wanted)
}

fn decode(name: &Path, bytes: &[u8], limit: u64, wanted: Wanted) -> Result<(Pixels, ReadNotes), Diagnostic> {
    let format = identify(name, bytes)?;
    let max_pixels = MAX_PIXELS_PER_BYTE * bytes.len() as u64;
    check_stated_size(format, bytes, max_pixels, limit)?;
    let (picture, transparent) = match format {
        Format::Tga => decoded(TgaDecoder::new(tga(bytes)?), max_pixels, limit)?,
        Format::Png => {
            let mut limits = Limits::no_limits();
            limits.max_alloc = Some(MAX_PNG_EXTRA_BYTES);
            decoded(PngDecoder::with_limits(Cursor::new(bytes), limits), max_pixels, limit)?
        }
        Format::Bmp => decoded(BmpDecoder::new(Cursor::new(bytes)), max_pixels, limit)?,
        Format::Ppm | Format::Pfm => return netpbm::read(bytes, limit, wanted),
        Format::Exr => return exr::read(bytes, limit, wanted),
    };
    // A TGA file without bits of alpha may have anything in the fourth byte of a pixel.
    let has_alpha = format != Format::Tga || bytes[TGA_HEADER - 1] & 0xf != 0;
    let notes = ReadNotes { transparent: if has_alpha { transparent } else { 0 }, ..ReadNotes::default() };
    Ok((Pixels::Bytes(picture), notes))
}

/// Refuses a file whose header states a size that the image crate would refuse in its own words: without pixels, or, in
/// a PNG file, with more than the file or the limit allows, and so with long rows.
fn check_stated_size(format: Format, bytes: &[u8], max_pixels: u64, limit: u64) -> Result<(), Diagnostic> {
    let sides = match format {
        Format::Tga => [12..14, 14..16],
        Format::Png if bytes.get(12..16) == Some(b"IHDR") => [16..20, 20..24],
        // The oldest headers have 12 bytes.
        Format::Bmp if bytes.get(14) == Some(&12) => [18..20, 20..22],
        Format::Bmp => [18..22, 22..26],
        Format::Png | Format::Ppm | Format::Pfm | Format::Exr => return Ok(()),
    };
    // The highest byte comes first in PNG files alone, and only their sizes are used.
    let number = |bytes: &[u8]| bytes.iter().fold(0, |number, &byte| number << 8 | u32::from(byte));
    let size = sides.map(|side| bytes.get(side).map(number));
    if size.contains(&Some(0)) {
        return Err(no_pixels());
    }
    let (Format::Png, [Some(width), Some(height)]) = (format, size) else { return Ok(()) };
    match u64::from(width) * u64::from(height) {
        pixels if pixels > max_pixels => Err(too_short([width, height])),
        pixels => check_bytes([width, height], pixels, limit),
    }
}

/// Returns a TGA file for the image crate, which decodes all unknown types as grey, and expects the number of alpha
/// bits that belongs to the size of a pixel. Many programs store another one, such as 8 for pixels of 24 bits, which is
/// harmless, because alpha is ignored.
fn tga(bytes: &[u8]) -> Result<impl Read, Diagnostic> {
    let (stored, rest) =
        bytes.split_first_chunk::<TGA_HEADER>().ok_or_else(|| Diagnostic::error(CUT_HEADER))?;
    let (mut header, kind, bits) = (*stored, stored[2], stored[16]);
    if !matches!(kind, 1..=3 | 9..=11) {
        let problem = format!("TGA of type {kind} is not supported");
        return Err(Diagnostic::error(problem).with_hint("save it as PNG, or as TGA of type 2"));
    }
    header[17] = header[17] & 0xf0 | if matches!((kind, bits), (3 | 11, 16)) { 8 } else { 0 };
    Ok(Cursor::new(header).chain(rest))
}

/// Decodes a picture of at most `max_pixels` pixels, which is what the file's length allows. Returns also how many of
/// them are not opaque.
fn decoded<D: ImageDecoder>(
    decoder: image::ImageResult<D>,
    max_pixels: u64,
    limit: u64,
) -> Result<(Picture, u64), Diagnostic> {
    let decoder = decoder.map_err(|error| refused_by_image(error, Diagnostic::error(CUT_HEADER)))?;
    let (width, height) = decoder.dimensions();
    let (size, color_type, length) = ([width, height], decoder.color_type(), decoder.total_bytes());
    // For TGA and BMP. The size of a PNG file has been checked before.
    match u64::from(width) * u64::from(height) {
        0 => return Err(no_pixels()),
        pixels if pixels > max_pixels => return Err(too_short(size)),
        _ => check_bytes(size, length, limit)?,
    }
    let mut samples = with_room(length as usize)?;
    samples.resize(length as usize, 0);
    decoder.read_image(&mut samples).map_err(|error| refused_by_image(error, too_short(size)))?;
    if color_type == ColorType::Rgb8 {
        return Ok((Picture::from_rgb(width, height, samples), 0));
    }
    let mut picture = zeros(size, limit, Wanted::Bytes)?.into_bytes();
    to_rgb(color_type, &samples, picture.pixels_mut());
    Ok((picture, transparent(color_type, &samples)))
}

/// Counts the pixels that are not opaque. Alpha is the last channel.
fn transparent(color_type: ColorType, samples: &[u8]) -> u64 {
    if !color_type.has_alpha() {
        return 0;
    }
    let pixel_bytes = usize::from(color_type.bytes_per_pixel());
    let alpha = pixel_bytes - pixel_bytes / usize::from(color_type.channel_count());
    let pixels = samples.chunks_exact(pixel_bytes);
    pixels.filter(|pixel| pixel[alpha..].iter().any(|&byte| byte != u8::MAX)).count() as u64
}

/// Returns the error of a file that the image crate refuses, like [`undecoded`].
fn refused_by_image(error: image::ImageError, too_early: Diagnostic) -> Diagnostic {
    match error {
        image::ImageError::IoError(error) => undecoded(error, too_early),
        image::ImageError::Limits(_) => {
            let most = Bytes(MAX_PNG_EXTRA_BYTES);
            let problem = format!("a row of its pixels or its metadata take more than {most}");
            Diagnostic::error(problem).with_hint("save it again without metadata, or in another format")
        }
        error => refused(&error),
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

#[cfg(test)]
mod test_files;
#[cfg(test)]
mod tests;
