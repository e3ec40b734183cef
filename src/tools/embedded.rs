//! Embeds pictures in a page as base64-encoded PNG files. Equal pictures are embedded once.

use crate::picture::Picture;
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::imageops::thumbnail;
use image::{ExtendedColorType, ImageBuffer, ImageEncoder, Rgb};
use std::collections::HashMap;

/// The longer side of a thumbnail, in pixels.
const THUMBNAIL: u32 = 64;

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
    if written.is_ok() { BASE64_STANDARD.encode(&file) } else { String::new() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::GenericImageView;

    #[test]
    fn a_thumbnail_keeps_the_picture_s_shape() {
        for (size, expected) in [([640, 64], (64, 6)), ([1, 900], (1, 64)), ([20, 64], (20, 64))] {
            let picture = Picture::from_rgb(size[0], size[1], vec![77; (size[0] * size[1] * 3) as usize]);
            let bytes = BASE64_STANDARD.decode(thumbnail_file(&picture)).unwrap();
            let found = image::load_from_memory(&bytes).unwrap();
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
