//! Reading of OpenEXR files: one part of scan lines, without compression or with ZIP, of numbers of any type.
//!
//! The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.

use super::error::ImageError;
use super::exr::{FLOAT, START};
use super::input::InputFile;
use super::pfm_input::fill_row;
use crate::picture::Picture;
use crate::scene::Color;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};

/// Upper bound on the length of an attribute that is kept.
const LONGEST_ATTRIBUTE: usize = 1 << 16;
/// A byte of a deflate stream encodes at most this many.
const MAX_INFLATION: u64 = 1032;
/// Upper bound on the bytes of a row, which are in memory at once with up to 15 others.
const LONGEST_ROW: usize = 1 << 24;

/// What the attributes say of the numbers.
#[derive(Default)]
struct Header {
    channels: Vec<Channel>,
    compression: Option<u8>,
    /// The columns and the rows of the numbers, from the first to the last.
    window: Option<[i32; 4]>,
}

struct Channel {
    name: Vec<u8>,
    kind: i32,
    /// One number for each pixel.
    is_full: bool,
}

impl Channel {
    /// The number of bytes of a half, of single precision or of a whole number.
    fn bytes(&self) -> usize {
        if self.kind == 1 { 2 } else { 4 }
    }

    fn number(&self, bytes: &[u8]) -> f64 {
        match (self.kind, bytes) {
            (1, &[a, b, ..]) => half(u16::from_le_bytes([a, b])),
            (FLOAT, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (_, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }
}

/// The value of a number of half precision.
fn half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    sign * match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    }
}

impl InputFile<'_> {
    pub(super) fn read_exr(&self, mut reader: BufReader<File>) -> Result<(Picture, u64), ImageError> {
        let header = self.exr_header(&mut reader)?;
        let [left, top, right, bottom] = header.window.ok_or_else(|| self.bad("its window is missing"))?;
        let side = |from: i32, to: i32| u32::try_from(i64::from(to) - i64::from(from) + 1).unwrap_or(0);
        let (size, red) = ([side(left, right), side(top, bottom)], self.colors(&header)?);
        let rows_per_block: u32 = match header.compression {
            Some(0 | 2) => 1,
            Some(3) => 16,
            _ => return Err(self.bad("its compression is neither none nor ZIP")),
        };
        let mut picture = self.black(size, self.length.saturating_mul(MAX_INFLATION))?;
        let row = size[0] as usize * header.channels.iter().map(Channel::bytes).sum::<usize>();
        if row > LONGEST_ROW {
            return Err(self.bad("its rows are too long"));
        }
        let cut = |error| self.cut(error, size);
        let blocks = size[1].div_ceil(rows_per_block);
        io::copy(&mut reader.by_ref().take(u64::from(blocks) * 8), &mut io::sink()).map_err(cut)?;
        let mut clamped = 0;
        for _ in 0..blocks {
            let [first, length] = [self.int(&mut reader)?, self.int(&mut reader)?];
            let first =
                u32::try_from(i64::from(first) - i64::from(top)).ok().filter(|&first| first < size[1]);
            let first = first.ok_or_else(|| self.bad("a row lies outside its window"))?;
            let rows = rows_per_block.min(size[1] - first) as usize;
            let length = usize::try_from(length).ok().filter(|&length| length <= rows * row);
            let mut bytes = vec![0; length.ok_or_else(|| self.bad("a row has a wrong length"))?];
            reader.read_exact(&mut bytes).map_err(cut)?;
            let bytes = if bytes.len() == rows * row { Some(bytes) } else { unzip(&bytes, rows * row) };
            let bytes = bytes.ok_or_else(|| self.bad("its compressed numbers are broken"))?;
            for (bytes, from_top) in bytes.chunks_exact(row).zip(first..) {
                let colors = header.colors(bytes, size[0] as usize, red);
                clamped += fill_row(&colors, picture.row_mut((size[1] - 1 - from_top) as usize));
            }
        }
        Ok((picture, clamped))
    }

    fn exr_header(&self, reader: &mut BufReader<File>) -> Result<Header, ImageError> {
        let mut start = [0; START.len()];
        reader.read_exact(&mut start).map_err(|error| self.coding(error.into()))?;
        // The flag of names of up to 255 letters makes no difference.
        let [one, two, three, four, version, flags, ..] = start;
        if [one, two, three, four, version] != START[..5] {
            return Err(self.bad("it is not an OpenEXR file of version 2"));
        }
        if flags & !4 != 0 {
            return Err(self.bad("it has tiles, deep data or several parts"));
        }
        let mut header = Header::default();
        loop {
            let name = self.text(reader)?;
            if name.is_empty() {
                return Ok(header);
            }
            self.text(reader)?;
            let length = u64::try_from(self.int(reader)?).map_err(|_| self.bad("its header is broken"))?;
            let mut value = vec![];
            let kept = reader.by_ref().take(length.min(LONGEST_ATTRIBUTE as u64)).read_to_end(&mut value);
            let rest = length.saturating_sub(LONGEST_ATTRIBUTE as u64);
            let skipped = kept.and_then(|_| io::copy(&mut reader.by_ref().take(rest), &mut io::sink()));
            skipped.map_err(|error| self.coding(error.into()))?;
            match name.as_slice() {
                b"channels" => {
                    header.channels = channels(&value).ok_or_else(|| self.bad("its header is broken"))?
                }
                b"compression" => header.compression = value.first().copied(),
                b"dataWindow" => header.window = window(&value),
                _ => {}
            }
        }
    }

    /// The indices of the channels of red, green and blue; three times the same for a single channel.
    fn colors(&self, header: &Header) -> Result<[usize; 3], ImageError> {
        let channels = &header.channels;
        let find = |name: &[u8]| channels.iter().position(|channel| channel.name == name);
        if !channels.iter().all(|channel| channel.is_full && (0..=2).contains(&channel.kind)) {
            return Err(self.bad("it does not have a number for each pixel"));
        }
        match (find(b"R"), find(b"G"), find(b"B"), find(b"Y").or((channels.len() == 1).then_some(0))) {
            (Some(red), Some(green), Some(blue), _) => Ok([red, green, blue]),
            (.., Some(grey)) => Ok([grey; 3]),
            _ => Err(self.bad("it has neither the channels R, G and B nor a single one")),
        }
    }

    /// A text up to its zero.
    fn text(&self, reader: &mut BufReader<File>) -> Result<Vec<u8>, ImageError> {
        let mut text = vec![];
        let limit = u64::from(u8::MAX) + 1;
        let read = reader.by_ref().take(limit).read_until(0, &mut text);
        read.map_err(|error| self.coding(error.into()))?;
        match text.pop() {
            Some(0) => Ok(text),
            _ => Err(self.bad("its header is broken")),
        }
    }

    fn int(&self, reader: &mut BufReader<File>) -> Result<i32, ImageError> {
        let mut bytes = [0; 4];
        reader.read_exact(&mut bytes).map_err(|error| self.coding(error.into()))?;
        Ok(i32::from_le_bytes(bytes))
    }
}

impl Header {
    /// The colours of a row, whose numbers are those of the first channel, then those of the next.
    fn colors(&self, row: &[u8], width: usize, red_green_blue: [usize; 3]) -> Vec<Color> {
        let planes = red_green_blue.map(|index| {
            let start: usize = self.channels[..index].iter().map(|channel| channel.bytes() * width).sum();
            let channel = &self.channels[index];
            row[start..].chunks_exact(channel.bytes()).map(|bytes| channel.number(bytes))
        });
        let [red, green, blue] = planes;
        let colors = red.zip(green).zip(blue).take(width);
        colors.map(|((red, green), blue)| Color::new(red, green, blue)).collect()
    }
}

/// The channels of a list of them: for each a name, the type, and how many pixels share a number along both axes.
fn channels(mut list: &[u8]) -> Option<Vec<Channel>> {
    let mut channels = vec![];
    while list.first()? != &0 {
        let end = list.iter().position(|&byte| byte == 0)?;
        let ([kind, _, x, y], rest) = list[end + 1..].split_first_chunk::<16>().map(|(ints, rest)| {
            let ints = ints.as_chunks().0;
            ([0, 1, 2, 3].map(|index: usize| i32::from_le_bytes(ints[index])), rest)
        })?;
        channels.push(Channel { name: list[..end].to_vec(), kind, is_full: [x, y] == [1, 1] });
        list = rest;
    }
    Some(channels)
}

fn window(value: &[u8]) -> Option<[i32; 4]> {
    let ints = value.first_chunk::<16>()?.as_chunks().0;
    Some([0, 1, 2, 3].map(|index: usize| i32::from_le_bytes(ints[index])))
}

/// Inflates a block. Its bytes are differences to the one before, the even ones in the first half and the odd ones in
/// the second.
fn unzip(bytes: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut parts = fdeflate::decompress_to_vec_bounded(bytes, length).ok()?;
    if parts.len() != length {
        return None;
    }
    for index in 1..length {
        parts[index] = parts[index].wrapping_add(parts[index - 1]).wrapping_sub(128);
    }
    let (even, odd) = parts.split_at(length.div_ceil(2));
    Some((0..length).map(|index| if index % 2 == 0 { even[index / 2] } else { odd[index / 2] }).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves() {
        let rows = [
            (0x0000, 0.0),
            (0x0001, 2f64.powi(-24)),
            (0x03ff, 1023.0 * 2f64.powi(-24)),
            (0x0400, 2f64.powi(-14)),
            (0x3555, 0.333251953125),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0xfc00, f64::NEG_INFINITY),
        ];
        for (bits, value) in rows {
            assert_eq!(half(bits), value, "{bits:#x}");
        }
        assert!(half(0x7c01).is_nan());
    }
}
