//! Embeds pictures in a page as base64-encoded PNG files. Equal pictures are embedded once.

use crate::picture::Picture;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::thumbnail;
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, Rgb};
use std::collections::HashMap;

/// The longer side of a thumbnail, in pixels.
const THUMBNAIL: u32 = 64;
/// The digits of base64.
const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// A set of pictures, identified by index.
#[derive(Debug, Default)]
pub struct Embedded {
    indices: HashMap<String, usize>,
}

impl Embedded {
    /// Adds a file unless it is already present. Returns its index.
    pub fn add(&mut self, file: String) -> usize {
        let next = self.indices.len();
        *self.indices.entry(file).or_insert(next)
    }

    /// Returns the base64-encoded files in the order of their indices.
    pub fn files(&self) -> Vec<&str> {
        let mut files = vec![""; self.indices.len()];
        self.indices.iter().for_each(|(file, &index)| files[index] = file);
        files
    }
}

/// Returns a base64-encoded PNG file of the picture.
pub fn file(picture: &Picture) -> String {
    encoded(picture.width(), picture.height(), picture.pixels())
}

/// Returns a base64-encoded PNG file of the picture, scaled so that no side is longer than [`THUMBNAIL`].
pub fn thumbnail_file(picture: &Picture) -> String {
    let [width, height] = [picture.width(), picture.height()];
    let Some(whole) = ImageBuffer::<Rgb<u8>, &[u8]>::from_raw(width, height, picture.pixels()) else {
        return String::new();
    };
    let longer = width.max(height);
    if longer <= THUMBNAIL {
        return file(picture);
    }
    let side = |side: u32| (u64::from(side) * u64::from(THUMBNAIL) / u64::from(longer)).max(1) as u32;
    let small = thumbnail(&whole, side(width), side(height));
    encoded(small.width(), small.height(), &small)
}

/// Encodes pixels as PNG in base64. Returns an empty string if the picture is too large for a PNG file.
fn encoded(width: u32, height: u32, rgb: &[u8]) -> String {
    let mut file = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Fast, FilterType::Adaptive);
    let written = encoder.write_image(rgb, width, height, ExtendedColorType::Rgb8);
    if written.is_ok() { base64(&file) } else { String::new() }
}

/// Encodes bytes in base64, as in section 4 of RFC 4648.
fn base64(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(4 * bytes.len().div_ceil(3));
    for group in bytes.chunks(3) {
        let mut padded = [0; 4];
        padded[1..=group.len()].copy_from_slice(group);
        let bits = u32::from_be_bytes(padded);
        let digits = [18, 12, 6, 0].map(|shift| char::from(DIGITS[(bits >> shift & 63) as usize]));
        text.extend(&digits[..=group.len()]);
        text += &"=="[group.len() - 1..];
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::GenericImageView;

    /// Decodes base64, with a zero for each digit that pads it.
    fn decoded(text: &str) -> Vec<u8> {
        let value = |digit: &u8| DIGITS.iter().position(|known| known == digit).unwrap_or(0) as u32;
        let groups = text.as_bytes().chunks(4);
        let bits = groups.map(|group| group.iter().fold(0, |bits, digit| bits << 6 | value(digit)));
        bits.flat_map(|bits| bits.to_be_bytes().into_iter().skip(1)).collect()
    }

    #[test]
    fn base64_is_that_of_rfc_4648() {
        for (bytes, encoded) in [
            // The vectors of section 10.
            (&b""[..], ""),
            (b"f", "Zg=="),
            (b"fo", "Zm8="),
            (b"foo", "Zm9v"),
            (b"foob", "Zm9vYg=="),
            (b"fooba", "Zm9vYmE="),
            (b"foobar", "Zm9vYmFy"),
            // The last digits, and the start of a PNG file.
            (b"\xfb\xff\xbf", "+/+/"),
            (b"\x89PNG\r\n\x1a\n", "iVBORw0KGgo="),
        ] {
            assert_eq!(base64(bytes), encoded);
        }
    }

    #[test]
    fn a_thumbnail_keeps_the_picture_s_shape() {
        for (size, expected) in [([640, 64], (64, 6)), ([1, 900], (1, 64)), ([20, 64], (20, 64))] {
            let picture = Picture::from_rgb(size[0], size[1], vec![77; (size[0] * size[1] * 3) as usize]);
            let found = image::load_from_memory(&decoded(&thumbnail_file(&picture))).unwrap();
            assert_eq!((found.dimensions(), found.get_pixel(0, 0).0), (expected, [77, 77, 77, 255]));
        }
    }

    #[test]
    fn equal_files_are_embedded_once() {
        let mut embedded = Embedded::default();
        assert_eq!(["b", "a", "b"].map(|file| embedded.add(file.into())), [0, 1, 0]);
        assert_eq!(embedded.files(), ["b", "a"]);
    }
}
