//! Reading of OpenEXR files: one part of scan lines, without compression or with RLE or ZIP, of numbers of any type.
//!
//! The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.

use super::common_to_readers::{ReadNotes, Wanted, beyond_bytes, no_pixels, too_short, zeros};
use super::written_headers::{EXR_FLOAT, EXR_START};
use crate::base::escape::{escape, quoted};
use crate::base::memory;
use crate::diagnostic::Diagnostic;
use crate::picture::{Color, Pixels};
use std::borrow::Cow;
use std::ops::Range;

/// A byte of a deflate stream encodes at most this many.
const MAX_INFLATION: u64 = 1032;
/// Upper bound on the bytes of a row, which are in memory at once with up to 15 others.
const LONGEST_ROW: u64 = 1 << 24;
/// The compressions that are not read, from the fifth on.
const COMPRESSIONS: [&str; 8] = ["PIZ", "PXR24", "B44", "B44A", "DWAA", "DWAB", "HTJ2K256", "HTJ2K32"];
/// Advice for a file that is not supported.
const CONVERT: &str = "convert it, as with `oiiotool a.exr --scanline --compression zip -o b.exr`";

/// The attributes that are used.
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
    /// True if each pixel has a number.
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

/// Reads the display window. It is zero where the data window has no numbers, and what lies outside it is cut off.
pub(super) fn read(file: &[u8], limit: u64, wanted: Wanted) -> Result<(Pixels, ReadNotes), Diagnostic> {
    let bad = |problem: &str| Err(Diagnostic::error(problem));
    let mut rest = file;
    let header = header(&mut rest)?;
    let Header { data, display, .. } = &header;
    if [data.width, data.height, display.width, display.height].iter().any(|&side| side <= 0) {
        return Err(no_pixels());
    }
    let red_green_blue = header.colors()?;
    let rows_per_block = match header.compression {
        0..=2 => 1,
        3 => 16,
        other => {
            let name = COMPRESSIONS.get(usize::from(other - 4)).unwrap_or(&"unknown");
            return Err(Diagnostic::error(format!("its compression is {name}")).with_hint(CONVERT));
        }
    };
    let size_of = |area: &Area| [area.width as u32, area.height as u32];
    let (length, blocks) = (file.len() as u64, (data.height as u64).div_ceil(rows_per_block as u64));
    let pixels = (data.width as u64).saturating_mul(data.height as u64);
    let short = || too_short(size_of(data));
    if pixels > length.saturating_mul(MAX_INFLATION) || blocks > length / 8 {
        return Err(short());
    }
    let mut picture = zeros(size_of(display), limit, wanted)?;
    let row_bytes =
        data.width as u64 * header.channels.iter().map(|channel| channel.bytes() as u64).sum::<u64>();
    if row_bytes > LONGEST_ROW {
        return bad("its rows are too long");
    }
    // The places of the blocks.
    rest.split_off(..8 * blocks as usize).ok_or_else(short)?;
    let (shared, alpha, width) = (header.shared_columns(), header.alpha(), data.width as usize);
    let (mut is_read, mut notes) = (vec![false; blocks as usize], ReadNotes::default());
    for _ in 0..blocks {
        let [first, length] = take_ints(&mut rest).ok_or_else(short)?;
        let first = i64::from(first) - data.top;
        if !(0..data.height).contains(&first) || first % rows_per_block != 0 {
            return bad("a row lies outside its data window");
        }
        if std::mem::replace(&mut is_read[(first / rows_per_block) as usize], true) {
            return bad("a row occurs twice");
        }
        let whole = rows_per_block.min(data.height - first) as usize * row_bytes as usize;
        let Some(length) = usize::try_from(length).ok().filter(|&length| length <= whole) else {
            return bad("a row has a wrong length");
        };
        let bytes = rest.split_off(..length).ok_or_else(short)?;
        // The bytes of the block, and their differences.
        memory::ask(2 * whole as u64)?;
        let Some(unpacked) = unpacked(header.compression, bytes, whole) else {
            return bad("its compressed numbers are broken");
        };
        let Some((columns, x)) = &shared else { continue };
        for (bytes, y) in unpacked.chunks_exact(row_bytes as usize).zip(data.top + first - display.top..) {
            if (0..display.height).contains(&y) {
                let colors = header.row(bytes, width, red_green_blue);
                let shown = &colors[columns.clone()];
                picture.set([*x, y as usize], shown);
                notes.clamped += beyond_bytes(shown);
                if let Some(alpha) = alpha {
                    let alphas = header.numbers(bytes, width, alpha).skip(columns.start).take(columns.len());
                    notes.transparent += alphas.filter(|alpha| *alpha < 1.0).count() as u64;
                }
            }
        }
    }
    Ok((picture, notes))
}

/// Takes bytes up to a zero, which is left out.
fn take_text<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = bytes.iter().position(|&byte| byte == 0)?;
    bytes.split_off(..=length).map(|text| &text[..length])
}

/// Takes whole numbers of four bytes each, of which the lowest comes first.
fn take_ints<const N: usize>(bytes: &mut &[u8]) -> Option<[i32; N]> {
    let taken = bytes.split_off(..4 * N)?.as_chunks().0;
    Some(std::array::from_fn(|index| i32::from_le_bytes(taken[index])))
}

fn header<'a>(rest: &mut &'a [u8]) -> Result<Header<'a>, Diagnostic> {
    let broken = Diagnostic::error("its header is broken or cut off");
    let Some(&[.., version, flags, _, _]) = rest.split_off(..EXR_START.len()) else { return Err(broken) };
    // The flag of names of up to 255 letters makes no difference.
    let found = match flags & !4 {
        _ if version != EXR_START[4] => "another version than 2 of OpenEXR",
        0 => return attributes(rest).ok_or(broken),
        flags if flags & 16 != 0 => "several parts",
        flags if flags & 8 != 0 => "deep data",
        2 => "tiles",
        _ => "flags that are not known",
    };
    Err(Diagnostic::error(format!("it has {found}")).with_hint(CONVERT))
}

fn attributes<'a>(rest: &mut &'a [u8]) -> Option<Header<'a>> {
    let mut header = Header::default();
    loop {
        let name = take_text(rest)?;
        if name.is_empty() {
            return Some(header);
        }
        take_text(rest)?;
        let length = usize::try_from(take_ints::<1>(rest)?[0]).ok()?;
        let mut value = rest.split_off(..length)?;
        let mut area = || {
            let [left, top, right, bottom] = take_ints(&mut value)?.map(i64::from);
            Some(Area { left, top, width: right - left + 1, height: bottom - top + 1 })
        };
        match name {
            b"dataWindow" => header.data = area()?,
            b"displayWindow" => header.display = area()?,
            b"compression" => header.compression = value.first().copied().unwrap_or(u8::MAX),
            b"channels" => header.channels = channels(value)?,
            _ => {}
        }
    }
}

/// Returns the channels of a list of them: for each a name, the type, and how many pixels share a number along both
/// axes.
fn channels(mut list: &[u8]) -> Option<Vec<Channel<'_>>> {
    let mut channels = vec![];
    loop {
        let name = take_text(&mut list)?;
        if name.is_empty() {
            return Some(channels);
        }
        let [kind, _, x, y] = take_ints(&mut list)?;
        channels.push(Channel { name, kind, is_full: [x, y] == [1, 1] });
    }
}

impl Header<'_> {
    /// Returns the columns of the data window that the display window has too, and the first of them there.
    fn shared_columns(&self) -> Option<(Range<usize>, usize)> {
        let Self { data, display, .. } = self;
        let left = data.left.max(display.left);
        let right = (data.left + data.width).min(display.left + display.width);
        let columns = || (left - data.left) as usize..(right - data.left) as usize;
        (left < right).then(|| (columns(), (left - display.left) as usize))
    }

    /// Returns the indices of the channels of red, green and blue; three times the same for a single channel.
    fn colors(&self) -> Result<[usize; 3], Diagnostic> {
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
        let (problem, hint) = match layer.map(String::from_utf8_lossy) {
            _ if !is_full => ("not all of them with a number for each pixel", None),
            Some(layer) => {
                let rename = escape(&format!("R={layer}.R,G={layer}.G,B={layer}.B"));
                ("not R, G and B", Some(format!("`oiiotool a.exr --ch {rename} -o b.exr` takes a layer")))
            }
            None => ("neither R, G and B nor a single one", None),
        };
        let problem = format!("it has the channels {names}, {problem}");
        Err(Diagnostic { hint, ..Diagnostic::error(problem) })
    }

    /// Returns the colours of a row, which has the numbers of the first channel, then the next channel's.
    fn row(&self, row: &[u8], width: usize, red_green_blue: [usize; 3]) -> Vec<Color> {
        let [red, green, blue] = red_green_blue.map(|index| self.numbers(row, width, index));
        let colors = red.zip(green).zip(blue);
        colors.map(|((red, green), blue)| Color::new(red, green, blue)).collect()
    }

    /// Returns the index of the channel of alpha.
    fn alpha(&self) -> Option<usize> {
        self.channels.iter().position(|channel| channel.name == b"A")
    }

    /// Returns the numbers of a channel in a row.
    fn numbers<'r>(&'r self, row: &'r [u8], width: usize, index: usize) -> impl Iterator<Item = f64> {
        let start: usize = self.channels[..index].iter().map(|channel| channel.bytes() * width).sum();
        let channel = &self.channels[index];
        row[start..].chunks_exact(channel.bytes()).take(width).map(|bytes| channel.number(bytes))
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

/// Returns the numbers of a block, which take `length` bytes. `None` if they are broken.
fn unpacked(compression: u8, bytes: &[u8], length: usize) -> Option<Cow<'_, [u8]>> {
    let differences = match compression {
        // A block that compression does not shorten is stored as it is.
        _ if bytes.len() == length => return Some(bytes.into()),
        0 => return None,
        1 => run_lengths(bytes, length)?,
        _ => fdeflate::decompress_to_vec_bounded(bytes, length).ok()?,
    };
    (differences.len() == length).then(|| undo_differences(differences).into())
}

/// Expands runs of a byte, and stretches of bytes with a negative length. `None` if they are longer than `length`.
fn run_lengths(mut runs: &[u8], length: usize) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(length);
    while let Some(&count) = runs.split_off_first() {
        match count as i8 {
            count @ ..0 => bytes.extend_from_slice(runs.split_off(..count.unsigned_abs().into())?),
            count => bytes.resize(bytes.len() + count as usize + 1, *runs.split_off_first()?),
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
