//! Reading of OpenEXR files: one part of scan lines, without compression or with RLE or ZIP, of numbers of any type.
//!
//! The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.

use super::error::ImageError;
use super::header::{EXR_FLOAT, EXR_START};
use super::reader::{Reader, Remarks, fill_row};
use crate::base::escape::{escape, quoted};
use crate::picture::{CHANNELS, Color, Picture};
use std::borrow::Cow;

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
struct Header<'a> {
    channels: Vec<Channel<'a>>,
    compression: u8,
    /// The place of the numbers.
    data: Area,
    /// The place of the picture.
    display: Area,
}

struct Channel<'a> {
    name: &'a [u8],
    kind: i32,
    /// One number for each pixel.
    is_full: bool,
}

/// A rectangle of pixels, whose places may be negative.
#[derive(Default)]
struct Area {
    left: i64,
    top: i64,
    width: i64,
    height: i64,
}

/// Reads the display window. It is black where the data window has no numbers, and what lies outside it is cut off.
pub(super) fn read(mut reader: Reader) -> Result<(Picture, Remarks), ImageError> {
    let file = reader;
    let header = header(&mut reader)?;
    let Header { data, display, .. } = &header;
    if [data.width, data.height, display.width, display.height].iter().any(|&side| side <= 0) {
        return Err(file.without_pixels());
    }
    let red_green_blue = header.colors(&file)?;
    let rows_per_block = match header.compression {
        0..=2 => 1,
        3 => 16,
        other => {
            let name = COMPRESSIONS.get(usize::from(other - 4)).unwrap_or(&"unknown");
            return Err(file.bad(format!("its compression is {name}; {CONVERT}")));
        }
    };
    let size_of = |area: &Area| [area.width as u32, area.height as u32];
    let (length, blocks) = (file.bytes.len() as u64, (data.height as u64).div_ceil(rows_per_block as u64));
    let pixels = (data.width as u64).saturating_mul(data.height as u64);
    let short = || file.short(size_of(data));
    if pixels > length.saturating_mul(MAX_INFLATION) || blocks > length / 8 {
        return Err(short());
    }
    let mut picture = file.black(size_of(display), u64::MAX)?;
    let row_bytes =
        data.width as u64 * header.channels.iter().map(|channel| channel.bytes() as u64).sum::<u64>();
    if row_bytes > LONGEST_ROW {
        return Err(file.bad("its rows are too long"));
    }
    // The places of the blocks.
    reader.take(8 * blocks as usize).ok_or_else(short)?;
    // Columns that both windows have.
    let left = data.left.max(display.left);
    let right = (data.left + data.width).min(display.left + display.width);
    let columns = |area: &Area| (left - area.left) as usize..(right - area.left) as usize;
    let (mut is_read, mut remarks) = (vec![false; blocks as usize], Remarks::default());
    for _ in 0..blocks {
        let [first, length] = reader.take_ints().ok_or_else(short)?;
        let first = i64::from(first) - data.top;
        if !(0..data.height).contains(&first) || first % rows_per_block != 0 {
            return Err(file.bad("a row lies outside its data window"));
        }
        if std::mem::replace(&mut is_read[(first / rows_per_block) as usize], true) {
            return Err(file.bad("a row occurs twice"));
        }
        let whole = rows_per_block.min(data.height - first) as usize * row_bytes as usize;
        let length = usize::try_from(length).ok().filter(|&length| length <= whole);
        let length = length.ok_or_else(|| file.bad("a row has a wrong length"))?;
        let bytes = reader.take(length).ok_or_else(short)?;
        let unpacked: Option<Cow<[u8]>> = match header.compression {
            // What would not become shorter is stored as it is.
            _ if length == whole => Some(bytes.into()),
            0 => None,
            1 => run_lengths(bytes, whole).map(|parts| undo_differences(parts).into()),
            _ => {
                let parts = fdeflate::decompress_to_vec_bounded(bytes, whole).ok();
                parts.map(|parts| undo_differences(parts).into())
            }
        };
        let unpacked = unpacked.filter(|bytes| bytes.len() == whole);
        let unpacked = unpacked.ok_or_else(|| file.bad("its compressed numbers are broken"))?;
        for (bytes, y) in unpacked.chunks_exact(row_bytes as usize).zip(data.top + first - display.top..) {
            if left < right && (0..display.height).contains(&y) {
                let colors = header.row(bytes, data.width as usize, red_green_blue);
                let row = picture.row_mut((display.height - 1 - y) as usize);
                let row = &mut row.as_chunks_mut::<CHANNELS>().0[columns(display)];
                remarks.clamped += fill_row(&colors[columns(data)], row.as_flattened_mut());
            }
        }
    }
    Ok((picture, remarks))
}

fn header<'a>(reader: &mut Reader<'a>) -> Result<Header<'a>, ImageError> {
    let broken = reader.bad("its header is broken or cut off");
    let Some(&[.., version, flags, _, _]) = reader.take(EXR_START.len()) else { return Err(broken) };
    // The flag of names of up to 255 letters makes no difference.
    let found = match flags & !4 {
        _ if version != EXR_START[4] => "another version than 2 of OpenEXR",
        0 => "",
        flags if flags & 16 != 0 => "several parts",
        flags if flags & 8 != 0 => "deep data",
        2 => "tiles",
        _ => "flags that are not known",
    };
    match found {
        "" => attributes(reader).ok_or(broken),
        found => Err(reader.bad(format!("it has {found}; {CONVERT}"))),
    }
}

fn attributes<'a>(reader: &mut Reader<'a>) -> Option<Header<'a>> {
    let mut header = Header::default();
    loop {
        let name = reader.take_text()?;
        if name.is_empty() {
            return Some(header);
        }
        reader.take_text()?;
        let length = usize::try_from(reader.take_ints::<1>()?[0]).ok()?;
        let mut value = Reader { bytes: reader.take(length)?, ..*reader };
        let mut area = || {
            let [left, top, right, bottom] = value.take_ints()?.map(i64::from);
            Some(Area { left, top, width: right - left + 1, height: bottom - top + 1 })
        };
        match name {
            b"dataWindow" => header.data = area()?,
            b"displayWindow" => header.display = area()?,
            b"compression" => header.compression = value.bytes.first().copied().unwrap_or(u8::MAX),
            b"channels" => header.channels = channels(value)?,
            _ => {}
        }
    }
}

/// Returns the channels of a list of them: for each a name, the type, and how many pixels share a number along both
/// axes.
fn channels(mut list: Reader) -> Option<Vec<Channel>> {
    let mut channels = vec![];
    loop {
        let name = list.take_text()?;
        if name.is_empty() {
            return Some(channels);
        }
        let [kind, _, x, y] = list.take_ints()?;
        channels.push(Channel { name, kind, is_full: [x, y] == [1, 1] });
    }
}

impl Header<'_> {
    /// Returns the indices of the channels of red, green and blue; three times the same for a single channel.
    fn colors(&self, file: &Reader) -> Result<[usize; 3], ImageError> {
        let channels = &self.channels;
        let find = |name: &[u8]| channels.iter().position(|channel| channel.name == name);
        let is_chroma = find(b"RY").or(find(b"BY")).is_some();
        let grey = find(b"Y").or((channels.len() == 1).then_some(0)).filter(|_| !is_chroma);
        let is_full = channels.iter().all(|channel| channel.is_full && (0..=2).contains(&channel.kind));
        match (find(b"R"), find(b"G"), find(b"B"), grey) {
            (Some(red), Some(green), Some(blue), _) if is_full => return Ok([red, green, blue]),
            (.., Some(grey)) if is_full => return Ok([grey; 3]),
            _ => {}
        }
        let names = channels.iter().map(|channel| String::from_utf8_lossy(channel.name));
        let names = quoted(names.collect::<Vec<_>>().join(", "));
        let layer = channels.iter().find_map(|channel| channel.name.strip_suffix(b".R"));
        let advice = match layer.map(String::from_utf8_lossy) {
            _ if !is_full => "not all of them with a number for each pixel".into(),
            Some(layer) => {
                let rename = escape(&format!("R={layer}.R,G={layer}.G,B={layer}.B"));
                format!("not R, G and B; `oiiotool a.exr --ch {rename} -o b.exr` takes a layer")
            }
            None => "neither R, G and B nor a single one".into(),
        };
        Err(file.bad(format!("it has the channels {names}, {advice}")))
    }

    /// Returns the colours of a row, whose numbers are those of the first channel, then those of the next.
    fn row(&self, row: &[u8], width: usize, red_green_blue: [usize; 3]) -> Vec<Color> {
        let [red, green, blue] = red_green_blue.map(|index| {
            let start: usize = self.channels[..index].iter().map(|channel| channel.bytes() * width).sum();
            let channel = &self.channels[index];
            row[start..].chunks_exact(channel.bytes()).map(|bytes| channel.number(bytes))
        });
        let colors = red.zip(green).zip(blue).take(width);
        colors.map(|((red, green), blue)| Color::new(red, green, blue)).collect()
    }
}

impl Channel<'_> {
    /// Returns the number of bytes of a half, of single precision or of a whole number.
    fn bytes(&self) -> usize {
        if self.kind == 1 { 2 } else { 4 }
    }

    fn number(&self, bytes: &[u8]) -> f64 {
        match (self.kind, bytes) {
            (1, &[a, b, ..]) => half(u16::from_le_bytes([a, b])),
            (EXR_FLOAT, &[a, b, c, d, ..]) => f64::from(f32::from_le_bytes([a, b, c, d])),
            (_, &[a, b, c, d, ..]) => f64::from(u32::from_le_bytes([a, b, c, d])),
            _ => 0.0,
        }
    }
}

/// Returns the value of a number of half precision.
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

/// Expands runs of a byte, and stretches of bytes with a negative length. `None` if they are longer than `length`.
fn run_lengths(runs: &[u8], length: usize) -> Option<Vec<u8>> {
    let (mut runs, mut bytes) = (runs, Vec::with_capacity(length));
    while let Some((&count, rest)) = runs.split_first() {
        let count = count as i8;
        if count < 0 {
            let (stretch, rest) = rest.split_at_checked(count.unsigned_abs().into())?;
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
