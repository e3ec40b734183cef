//! The headers of the files that are written, but for PNG's.

use super::format::{Content, Format};
use super::part::Part;
use crate::diagnostic::Diagnostic;

/// The length of the headers of a BMP file, the file's own and BITMAPINFOHEADER, in bytes.
const BMP_HEADER: usize = 14 + BMP_INFO_HEADER;
const BMP_INFO_HEADER: usize = 40;
/// The first bytes of an OpenEXR file: the second version of the format, without any of the flags for tiles, long
/// names, deep data and several parts.
pub(super) const EXR_START: [u8; 8] = [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0];
/// OpenEXR's number for the type of single precision.
pub(super) const EXR_FLOAT: i32 = 2;

/// Returns what precedes the rows of a picture, but for PNG, or why the format cannot hold it.
pub(super) fn header(
    format: Format,
    size @ [width, height]: [usize; 2],
    content: Content,
    part: Option<&Part>,
) -> Result<Vec<u8>, Diagnostic> {
    let whole = part.map_or(size, |part| part.whole);
    let has_short_sides = matches!(format, Format::Tga | Format::Pfm | Format::Exr);
    if let (true, [width, height]) = (has_short_sides, whole)
        && width.max(height) > u16::MAX.into()
    {
        return Err(Diagnostic::error(format!("{width} x {height} is above 65535 pixels a side")));
    }
    let is_grey = content == Content::Distances;
    Ok(match format {
        Format::Tga => tga(size, part),
        Format::Png => vec![],
        Format::Bmp => bmp(size).ok_or_else(|| {
            let limit = "pixels are above 4 GB, where a BMP file ends";
            Diagnostic::error(format!("{width} x {height} {limit}"))
        })?,
        Format::Ppm => format!("P6\n{width} {height}\n255\n").into_bytes(),
        // The negative number says that the lowest byte comes first.
        Format::Pfm => format!("P{}\n{width} {height}\n-1.0\n", if is_grey { 'f' } else { 'F' }).into_bytes(),
        Format::Exr => {
            let at = part.map_or([0; 2], |part| part.at);
            exr(size, whole, at, if is_grey { &["Z"] } else { &["B", "G", "R"] })
        }
    })
}

/// Returns the header of a TGA file as the course's program writes it: uncompressed true colour of 24 bits, with rows
/// from the top. No side may be above 65535 pixels, of the whole either if the picture is a part. The header of a part
/// has an origin, the offset of its lower left corner from the whole picture's, and an image ID.
fn tga([width, height]: [usize; 2], part: Option<&Part>) -> Vec<u8> {
    let origin = part.map_or([0; 2], |part| {
        let below = part.whole[1].saturating_sub(part.at[1]).saturating_sub(height);
        [part.at[0], below]
    });
    let [[x0, x1], [y0, y1]] = origin.map(|side| (side as u16).to_le_bytes());
    let [[w0, w1], [h0, h1]] = [width, height].map(|side| (side as u16).to_le_bytes());
    let id = part.map_or(String::new(), Part::to_string);
    let header = [id.len() as u8, 0, 2, 0, 0, 0, 0, 0, x0, x1, y0, y1, w0, w1, h0, h1, 24, 32];
    [&header, id.as_bytes()].concat()
}

/// Returns the length of a row of a BMP file in bytes: a pixel has three, and a row is filled up to a multiple of four.
pub(super) fn bmp_row(width: usize) -> usize {
    (width * 3).next_multiple_of(4)
}

/// Returns the header of an uncompressed BMP file of 24 bits per pixel, whose rows follow from the bottom. `None` if
/// its fields cannot hold the size of the picture or of the file.
fn bmp([width, height]: [usize; 2]) -> Option<Vec<u8>> {
    let rows = bmp_row(width).checked_mul(height)?;
    let file = u32::try_from(rows.checked_add(BMP_HEADER)?).ok()?;
    let planes_and_bits = 1 | 24 << 16;
    let [start, info, width, height] = [BMP_HEADER, BMP_INFO_HEADER, width, height].map(|n| n as u32);
    // No compression, no resolution, no table of colours.
    let words = [file, 0, start, info, width, height, planes_and_bits, 0, rows as u32, 0, 0, 0, 0];
    Some([b"BM".as_slice(), words.map(u32::to_le_bytes).as_flattened()].concat())
}

/// Returns what precedes the rows of an OpenEXR file of single precision without compression: the attributes, and
/// where each row lies. `whole` has the width and height of the display window, in which the picture's first pixel is
/// `at`. The channels have to be in alphabetical order.
///
/// The format is described in "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>.
fn exr(size: [usize; 2], whole: [usize; 2], at: [usize; 2], channels: &[&str]) -> Vec<u8> {
    let ints = |ints: &[i32]| ints.iter().flat_map(|int| int.to_le_bytes()).collect::<Vec<u8>>();
    let window = |[x, y]: [usize; 2], [width, height]: [usize; 2]| {
        ints(&[x, y, x + width - 1, y + height - 1].map(|n| n as i32))
    };
    let mut bytes = EXR_START.to_vec();
    let mut attribute = |name: &str, kind: &str, value: &[u8]| {
        bytes.extend([name.as_bytes(), b"\0", kind.as_bytes(), b"\0"].concat());
        bytes.extend((value.len() as i32).to_le_bytes());
        bytes.extend(value);
    };
    // The type, four bytes without a meaning here, and a sample for each pixel along both axes.
    let channel = |name: &&str| [name.as_bytes(), b"\0", &ints(&[EXR_FLOAT, 0, 1, 1])].concat();
    let mut list: Vec<u8> = channels.iter().flat_map(channel).collect();
    list.push(0);
    attribute("channels", "chlist", &list);
    attribute("compression", "compression", &[0]);
    attribute("dataWindow", "box2i", &window(at, size));
    attribute("displayWindow", "box2i", &window([0, 0], whole));
    // From the top.
    attribute("lineOrder", "lineOrder", &[0]);
    attribute("pixelAspectRatio", "float", &1f32.to_le_bytes());
    attribute("screenWindowCenter", "v2f", &[0; 8]);
    attribute("screenWindowWidth", "float", &1f32.to_le_bytes());
    bytes.push(0);
    let [width, height] = size;
    let row = exr_row(0, 0).len() + width * channels.len() * size_of::<f32>();
    let first = bytes.len() + height * size_of::<u64>();
    bytes.extend((0..height).flat_map(|y| ((first + y * row) as u64).to_le_bytes()));
    bytes
}

/// Returns what precedes the numbers of a row of an OpenEXR file, which is counted from the top of the whole: its index
/// and its length in bytes. The numbers of the first channel come first, then the next channel's.
pub(super) fn exr_row(row: usize, numbers: usize) -> [u8; 8] {
    let length = numbers * size_of::<f32>();
    (row as u64 | (length as u64) << 32).to_le_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bmp_file_of_more_than_four_gigabytes_has_no_header() {
        assert_eq!([1, 2, 3, 4].map(bmp_row), [4, 8, 12, 12]);
        assert!(bmp([65535, 21845]).is_some() && bmp([65535, 21846]).is_none());
    }
}
