//! The format of a picture file by its first bytes, against which its name is checked.

use super::Format;
use super::error::ImageError;
use super::part_file::RowSource;
use super::writer::TGA_HEADER;
use crate::escape::quoted;
use std::io::Read;
use std::path::Path;

/// The mark at the start of a text in UTF-8.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Lines of other text before a picture are looked for in this number of bytes.
const LONGEST_START: u64 = 4096;
/// How many bytes of an unknown file are shown.
const SHOWN: usize = 24;

/// Starts of files that are not read, and what to do with them.
const FOREIGN: [(&[u8], &str, &str); 13] = [
    (b"\xff\xd8\xff", "a JPEG file", CONVERT),
    (b"GIF8", "a GIF file", CONVERT),
    (b"II*\0", "a TIFF file", CONVERT),
    (b"MM\0*", "a TIFF file", CONVERT),
    (b"RIFF", "a WebP file", CONVERT),
    (b"#?R", "a Radiance file", "convert it to PFM"),
    (b"<", "a page or a file in XML", "save the picture in it as PNG"),
    (b"PK\x03\x04", "a ZIP archive", "unpack it"),
    (b"\x1f\x8b", "compressed with gzip", "unpack it"),
    (b"version https://git-lfs", "a pointer of Git LFS", "`git lfs pull` fetches the picture"),
    (b"\xff\xfe", WIDE, BYTES),
    (b"\xfe\xff", WIDE, BYTES),
    (b"P\x003\0", WIDE, BYTES),
];
const CONVERT: &str = "convert it to PNG";
const WIDE: &str = "text in UTF-16, as `>` in PowerShell writes it";
const BYTES: &str = "`>` in cmd.exe leaves the bytes as they are, and an editor can save it as UTF-8";

/// Returns the format of a file and its first bytes, if its name fits. The source stands at the start before and after.
pub(super) fn identify(path: &Path, source: &mut dyn RowSource) -> Result<(Format, Vec<u8>), ImageError> {
    let mut start = vec![];
    let read = source.take(LONGEST_START).read_to_end(&mut start).and_then(|_| source.rewind());
    read.map_err(|error| ImageError::io("read", path, error))?;
    let bad = |reason| Err(ImageError::unreadable(path, reason));
    match (known(&start), Format::of_input(path)) {
        (Some((format, _)), Some(named)) if format == named => Ok((format, start)),
        (Some((_, ending)), _) => {
            let right = path.with_extension(ending);
            let right = quoted(right.file_name().unwrap_or_default());
            bad(format!("it is {}; name it {right}", named_file(ending)))
        }
        (None, named) => match (FOREIGN.iter().find(|(mark, ..)| start.starts_with(mark)), named) {
            (Some((_, name, advice)), _) => bad(format!("it is {name}; {advice}")),
            (None, None) => Err(ImageError::Ending { path: path.to_owned() }),
            (None, Some(Format::Tga)) => Ok((Format::Tga, start)),
            (None, Some(named)) => bad(unknown(&start, named)),
        },
    }
}

/// A format, and the ending of its files' names.
fn known(start: &[u8]) -> Option<(Format, &'static str)> {
    match start {
        [0x89, b'P', b'N', b'G', ..] => Some((Format::Png, "png")),
        [b'B', b'M', ..] => Some((Format::Bmp, "bmp")),
        [0x76, 0x2f, 0x31, 0x01, ..] => Some((Format::Exr, "exr")),
        _ => netpbm(start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start))
            .or_else(|| is_tga(start).then_some((Format::Tga, "tga"))),
    }
}

fn netpbm(text: &[u8]) -> Option<(Format, &'static str)> {
    let (&[b'P', kind], rest) = text.split_first_chunk()? else { return None };
    if rest.first().is_some_and(|&byte| byte != b'#' && !byte.is_ascii_whitespace()) {
        return None;
    }
    match kind {
        b'1' | b'4' => Some((Format::Ppm, "pbm")),
        b'2' | b'5' => Some((Format::Ppm, "pgm")),
        b'3' | b'6' => Some((Format::Ppm, "ppm")),
        b'7' => Some((Format::Ppm, "pam")),
        b'F' | b'f' => Some((Format::Pfm, "pfm")),
        _ => None,
    }
}

/// True if the bytes can be a header of a TGA file, which has no mark.
fn is_tga(start: &[u8]) -> bool {
    let Some(header) = start.first_chunk::<TGA_HEADER>() else { return false };
    let has_map = header[1] == 1;
    header[1] <= 1
        && matches!((header[2], has_map), (1 | 9, true) | (2 | 3 | 10 | 11, _))
        && matches!(header[7], 0 | 15 | 16 | 24 | 32)
        && matches!(header[16], 8 | 15 | 16 | 24 | 32)
        && header[17] & 0xc0 == 0
}

/// Returns true if a header of a format that the image crate reads has a width or height of 0. The crate would refuse
/// it in its own words.
pub(super) fn has_no_pixels(format: Format, start: &[u8]) -> bool {
    let is_zero = |from: usize, length: usize| {
        start.get(from..from + length).is_some_and(|bytes| bytes.iter().all(|&byte| byte == 0))
    };
    match format {
        Format::Tga => is_zero(12, 2) || is_zero(14, 2),
        Format::Png => is_zero(16, 4) || is_zero(20, 4),
        // The oldest headers have 12 bytes.
        Format::Bmp if start.get(14) == Some(&12) => is_zero(18, 2) || is_zero(20, 2),
        Format::Bmp => is_zero(18, 4) || is_zero(22, 4),
        Format::Ppm | Format::Pfm | Format::Exr => false,
    }
}

/// Such as "a PNG file".
fn named_file(ending: &str) -> String {
    let article = if ending.eq_ignore_ascii_case("exr") { "an" } else { "a" };
    format!("{article} {} file", ending.to_uppercase())
}

/// Why a file that is in no known format cannot be read.
fn unknown(start: &[u8], named: Format) -> String {
    let line = start.split(|&byte| byte == b'\n').next().unwrap_or_default().trim_ascii();
    if start.len() < 2 {
        return "it ends within its header".into();
    }
    let shown = quoted(&*String::from_utf8_lossy(&line[..line.len().min(SHOWN)]));
    let mut rest = start.split_inclusive(|&byte| byte == b'\n').skip(1).zip(2..);
    match rest.find(|(line, _)| netpbm(line).is_some()) {
        Some((_, number)) if matches!(named, Format::Ppm | Format::Pfm) => format!(
            "its picture begins in line {number}, after {shown}; messages belong to the standard error, as `std::cerr`"
        ),
        _ => format!("it is not {}, since it begins with {shown}", named_file(&format!("{named:?}"))),
    }
}
