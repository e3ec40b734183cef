//! Reading of OpenEXR files: one part of scan lines, without compression or with RLE or ZIP, of numbers of any type.
//!
//! The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.

use super::error::ImageError;
use super::exr::{FLOAT, START};
use super::input::{InputFile, Remarks, fill_row};
use super::part_file::RowSource;
use crate::escape::{escape, quoted};
use crate::picture::{CHANNELS, Picture};
use crate::scene::Color;
use std::io::{self, BufRead, Read};

/// Upper bound on the length of an attribute that is kept.
const LONGEST_ATTRIBUTE: usize = 1 << 16;
/// A byte of a deflate stream encodes at most this many.
const MAX_INFLATION: u64 = 1032;
/// Upper bound on the bytes of a row, which are in memory at once with up to 15 others.
const LONGEST_ROW: u64 = 1 << 24;
/// The compressions that are not read, from the fifth on.
const COMPRESSIONS: [&str; 8] = ["PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K256", "HTJ2K32"];
/// What to do with a file that is not read.
const CONVERT: &str = "convert it, as with `oiiotool a.exr --scanline --compression zip -o b.exr`";

/// What the attributes say of the numbers.
#[derive(Default)]
struct Header {
    channels: Vec<Channel>,
    compression: u8,
    /// The columns and rows of the numbers: the first column and row, and the last ones.
    data: Option<[i32; 4]>,
    /// The columns and rows of the picture.
    display: Option<[i32; 4]>,
}

/// A rectangle of pixels.
struct Window {
    left: i64,
    top: i64,
    width: u64,
    height: u64,
}

struct Channel {
    name: Vec<u8>,
    kind: i32,
    /// One number for each pixel.
    is_full: bool,
}

impl Channel {
    /// The number of bytes of a half, of single precision or of a whole number.
    fn bytes(&self) -> u64 {
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

impl<'a> InputFile<'a> {
    /// Reads the display window. It is black where the data window has no numbers, and what lies outside it is cut off.
    pub(super) fn read_exr(
        &self,
        mut source: Box<dyn RowSource + 'a>,
    ) -> Result<(Picture, Remarks), ImageError> {
        let header = self.exr_header(&mut *source)?;
        let (data, display) = (self.window(header.data, "data")?, self.window(header.display, "display")?);
        let red_green_blue = self.colors(&header)?;
        let rows_per_block = match header.compression {
            0..=2 => 1,
            3 => 16,
            other => {
                let name = COMPRESSIONS.get(usize::from(other - 4)).unwrap_or(&"unknown");
                return Err(self.bad(format!("its compression is {name}; {CONVERT}")));
            }
        };
        let blocks = data.height.div_ceil(rows_per_block);
        let pixels = data.width.saturating_mul(data.height);
        if pixels > self.length.saturating_mul(MAX_INFLATION) || blocks > self.length / 8 {
            return Err(self.short([data.width as u32, data.height as u32]));
        }
        let size = [display.width, display.height].map(|side| side as u32);
        let mut picture = self.black(size, u64::MAX)?;
        let row = data.width * header.channels.iter().map(Channel::bytes).sum::<u64>();
        if row > LONGEST_ROW {
            return Err(self.bad("its rows are too long"));
        }
        let cut = |error| self.cut(error, [data.width, data.height].map(|side| side as u32));
        io::copy(&mut source.by_ref().take(blocks * 8), &mut io::sink()).map_err(cut)?;
        // Columns that both windows have.
        let left = data.left.max(display.left);
        let right = (data.left + data.width as i64).min(display.left + display.width as i64);
        let in_window = |from: i64| (left - from) as usize..(right - from) as usize;
        let (mut is_read, mut remarks) = (vec![false; blocks as usize], Remarks::default());
        for _ in 0..blocks {
            let [first, length] = [self.int(&mut *source)?, self.int(&mut *source)?];
            let first = u64::try_from(i64::from(first) - data.top).ok().filter(|&first| first < data.height);
            let first = first.filter(|first| first % rows_per_block == 0);
            let first = first.ok_or_else(|| self.bad("a row lies outside its data window"))?;
            if std::mem::replace(&mut is_read[(first / rows_per_block) as usize], true) {
                return Err(self.bad("a row occurs twice"));
            }
            let whole = (rows_per_block.min(data.height - first) * row) as usize;
            let length = usize::try_from(length).ok().filter(|&length| length <= whole);
            let length = length.ok_or_else(|| self.bad("a row has a wrong length"))?;
            let mut bytes = self.zeros(length as u64, size)?;
            source.read_exact(&mut bytes).map_err(cut)?;
            let bytes = match header.compression {
                _ if bytes.len() == whole => Some(bytes),
                0 => None,
                1 => run_lengths(&bytes, whole).map(undo_differences),
                _ => fdeflate::decompress_to_vec_bounded(&bytes, whole).ok().map(undo_differences),
            };
            let bytes = bytes.filter(|bytes| bytes.len() == whole);
            let bytes = bytes.ok_or_else(|| self.bad("its compressed numbers are broken"))?;
            for (bytes, y) in bytes.chunks_exact(row as usize).zip(data.top + first as i64..) {
                if left < right && (display.top..display.top + display.height as i64).contains(&y) {
                    let colors = header.colors(bytes, data.width as usize, red_green_blue);
                    let row = picture.row_mut((display.top + display.height as i64 - 1 - y) as usize);
                    let row = &mut row.as_chunks_mut::<CHANNELS>().0[in_window(display.left)];
                    remarks.clamped += fill_row(&colors[in_window(data.left)], row.as_flattened_mut());
                }
            }
        }
        Ok((picture, remarks))
    }

    /// A window that has pixels.
    fn window(&self, corners: Option<[i32; 4]>, name: &str) -> Result<Window, ImageError> {
        let corners = corners.ok_or_else(|| self.bad(format!("its {name} window is missing")))?;
        let [left, top, right, bottom] = corners.map(i64::from);
        match (u64::try_from(right - left + 1), u64::try_from(bottom - top + 1)) {
            (Ok(width @ 1..), Ok(height @ 1..)) => Ok(Window { left, top, width, height }),
            _ => Err(self.without_pixels()),
        }
    }

    fn exr_header(&self, source: &mut dyn RowSource) -> Result<Header, ImageError> {
        let mut start = [0; START.len()];
        source.read_exact(&mut start).map_err(|error| self.coding(error.into()))?;
        // The flag of names of up to 255 letters makes no difference.
        let [.., version, flags, _, _] = start;
        let found = match flags & !4 {
            _ if version != START[4] => "another version than 2 of OpenEXR",
            0 => "",
            flags if flags & 16 != 0 => "several parts",
            flags if flags & 8 != 0 => "deep data",
            2 => "tiles",
            _ => "flags that are not known",
        };
        if !found.is_empty() {
            return Err(self.bad(format!("it has {found}; {CONVERT}")));
        }
        let mut header = Header::default();
        loop {
            let name = self.text(source)?;
            if name.is_empty() {
                return Ok(header);
            }
            self.text(source)?;
            let length = u64::try_from(self.int(source)?).map_err(|_| self.bad("its header is broken"))?;
            let mut value = vec![];
            let kept = source.take(length.min(LONGEST_ATTRIBUTE as u64)).read_to_end(&mut value);
            let rest = length.saturating_sub(LONGEST_ATTRIBUTE as u64);
            let skipped = kept.and_then(|_| io::copy(&mut source.take(rest), &mut io::sink()));
            skipped.map_err(|error| self.coding(error.into()))?;
            match name.as_slice() {
                b"channels" => {
                    header.channels = channels(&value).ok_or_else(|| self.bad("its header is broken"))?
                }
                b"compression" => header.compression = value.first().copied().unwrap_or(u8::MAX),
                b"dataWindow" => header.data = window(&value),
                b"displayWindow" => header.display = window(&value),
                _ => {}
            }
        }
    }

    /// The indices of the channels of red, green and blue; three times the same for a single channel.
    fn colors(&self, header: &Header) -> Result<[usize; 3], ImageError> {
        let channels = &header.channels;
        let find = |name: &[u8]| channels.iter().position(|channel| channel.name == name);
        let is_chroma = find(b"RY").or(find(b"BY")).is_some();
        let grey = find(b"Y").or((channels.len() == 1).then_some(0)).filter(|_| !is_chroma);
        let is_full = channels.iter().all(|channel| channel.is_full && (0..=2).contains(&channel.kind));
        match (find(b"R"), find(b"G"), find(b"B"), grey) {
            (Some(red), Some(green), Some(blue), _) if is_full => Ok([red, green, blue]),
            (.., Some(grey)) if is_full => Ok([grey; 3]),
            _ => {
                let names = channels.iter().map(|channel| String::from_utf8_lossy(&channel.name));
                let names = quoted(names.collect::<Vec<_>>().join(", "));
                let layer = channels.iter().find_map(|channel| channel.name.strip_suffix(b".R"));
                let advice = match layer.map(String::from_utf8_lossy) {
                    _ if !is_full => "not all of them with a number for each pixel".into(),
                    Some(layer) => {
                        let rename = format!("R={layer}.R,G={layer}.G,B={layer}.B");
                        format!(
                            "not R, G and B; `oiiotool a.exr --ch {} -o b.exr` takes a layer",
                            escape(&rename)
                        )
                    }
                    None => "neither R, G and B nor a single one".into(),
                };
                Err(self.bad(format!("it has the channels {names}, {advice}")))
            }
        }
    }

    /// A text up to its zero.
    fn text(&self, source: &mut dyn RowSource) -> Result<Vec<u8>, ImageError> {
        let mut text = vec![];
        let limit = u64::from(u8::MAX) + 1;
        let read = source.take(limit).read_until(0, &mut text);
        read.map_err(|error| self.coding(error.into()))?;
        match text.pop() {
            Some(0) => Ok(text),
            _ => Err(self.bad("its header is broken")),
        }
    }

    fn int(&self, source: &mut dyn RowSource) -> Result<i32, ImageError> {
        let mut bytes = [0; 4];
        source.read_exact(&mut bytes).map_err(|error| self.coding(error.into()))?;
        Ok(i32::from_le_bytes(bytes))
    }
}

impl Header {
    /// The colours of a row, whose numbers are those of the first channel, then those of the next.
    fn colors(&self, row: &[u8], width: usize, red_green_blue: [usize; 3]) -> Vec<Color> {
        let planes = red_green_blue.map(|index| {
            let start: u64 =
                self.channels[..index].iter().map(|channel| channel.bytes() * width as u64).sum();
            let channel = &self.channels[index];
            row[start as usize..].chunks_exact(channel.bytes() as usize).map(|bytes| channel.number(bytes))
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

/// Expands runs of a byte, and stretches of bytes with a negative length.
fn run_lengths(mut runs: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length);
    while let Some((&count, rest)) = runs.split_first() {
        let count = i32::from(count as i8);
        if count < 0 {
            let (stretch, rest) = rest.split_at_checked(count.unsigned_abs() as usize)?;
            bytes.extend_from_slice(stretch);
            runs = rest;
        } else {
            let (&byte, rest) = rest.split_first()?;
            bytes.resize(bytes.len() + count as usize + 1, byte);
            runs = rest;
        }
        if bytes.len() > length {
            return None;
        }
    }
    Some(bytes)
}

/// Returns the bytes of a block. Each is stored as its difference to the one before, the even ones in the first half
/// and the odd ones in the second.
fn undo_differences(mut parts: Vec<u8>) -> Vec<u8> {
    for index in 1..parts.len() {
        parts[index] = parts[index].wrapping_add(parts[index - 1]).wrapping_sub(128);
    }
    let (even, odd) = parts.split_at(parts.len().div_ceil(2));
    (0..parts.len()).map(|index| if index % 2 == 0 { even[index / 2] } else { odd[index / 2] }).collect()
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
