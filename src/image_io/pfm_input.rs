//! Reading of PFM files: three lines of text, and rows of numbers from the bottom.

use super::error::ImageError;
use super::input::InputFile;
use crate::picture::{Picture, RED_FIRST, truncate_to_bytes};
use crate::scene::Color;
use std::fs::File;
use std::io::{BufReader, Read};

/// Upper bound on the length of a word in the header.
const LONGEST_WORD: usize = 40;

impl InputFile<'_> {
    pub(super) fn read_pfm(&self, mut reader: BufReader<File>) -> Result<(Picture, u64), ImageError> {
        let channels = match self.word(&mut reader)?.as_str() {
            "PF" => 3,
            "Pf" => 1,
            _ => return Err(self.bad("it is not a PFM file")),
        };
        let bad_size = || self.bad("its width and height are not whole numbers");
        let mut side = || self.word(&mut reader)?.parse::<u32>().map_err(|_| bad_size());
        let (width, height) = (side()?, side()?);
        let scale =
            self.word(&mut reader)?.parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0);
        let is_little = scale.ok_or_else(|| self.bad("its scale is not a number"))? < 0.0;

        let bytes_per_pixel = channels * size_of::<f32>();
        let mut picture = self.black([width, height], self.length / bytes_per_pixel as u64)?;
        let mut bytes = vec![0; width as usize * bytes_per_pixel];
        let (mut colors, mut clamped) = (Vec::with_capacity(width as usize), 0);
        for row in 0..height as usize {
            reader.read_exact(&mut bytes).map_err(|error| self.cut(error, [width, height]))?;
            let numbers = bytes.as_chunks().0.iter();
            let numbers: Vec<f32> = match is_little {
                true => numbers.map(|&bytes| f32::from_le_bytes(bytes)).collect(),
                false => numbers.map(|&bytes| f32::from_be_bytes(bytes)).collect(),
            };
            colors.clear();
            let pixels = numbers.chunks_exact(channels);
            colors.extend(pixels.map(|pixel| {
                // A grey pixel has one number.
                Color::from_array([0, 1, 2].map(|channel| f64::from(pixel[channel.min(channels - 1)])))
            }));
            clamped += fill_row(&colors, picture.row_mut(row));
        }
        Ok((picture, clamped))
    }

    /// The next word of the header, and the white space that ends it.
    fn word(&self, reader: &mut impl Read) -> Result<String, ImageError> {
        let mut word = String::new();
        let mut byte = [0];
        loop {
            reader.read_exact(&mut byte).map_err(|error| self.coding(error.into()))?;
            match char::from(byte[0]) {
                space if space.is_ascii_whitespace() && !word.is_empty() => return Ok(word),
                space if space.is_ascii_whitespace() => {}
                letter if word.len() < LONGEST_WORD => word.push(letter),
                _ => return Err(self.bad("it is not a PFM file")),
            }
        }
    }

    /// The error of a file that ends too early or cannot be read.
    pub(super) fn cut(&self, error: std::io::Error, [width, height]: [u32; 2]) -> ImageError {
        match error.kind() {
            std::io::ErrorKind::UnexpectedEof => self.short(width, height),
            _ => ImageError::io("read", self.path, error),
        }
    }
}

/// Sets a row of bytes to these colours, and counts those that are beyond bytes.
pub(super) fn fill_row(colors: &[Color], row: &mut [u8]) -> u64 {
    truncate_to_bytes::<RED_FIRST>(colors, row);
    let is_shown = |channel: f64| (0.0..=1.0).contains(&channel);
    colors.iter().filter(|color| !color.to_array().into_iter().all(is_shown)).count() as u64
}
