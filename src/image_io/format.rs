//! The formats of picture files. The end of a name decides what is written, the first bytes decide what is read.

use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use serde::Serialize;
use std::ffi::OsStr;
use std::path::Path;

/// The length of the header of a TGA file, in bytes.
pub(super) const TGA_HEADER: usize = 18;

/// The meaning of a picture's colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Red, green and blue, or the coordinates of normals.
    Colors,
    /// Distances, equal in all channels, and infinite where there is nothing.
    Distances,
}

/// The format of a picture file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Format {
    /// `.tga`, byte for byte as the course's program writes it.
    Tga,
    /// `.png`, 8 bits per channel, without alpha.
    Png,
    /// `.bmp`, 24 bits per pixel, with rows from the bottom.
    Bmp,
    /// `.ppm`, 8 bits per channel.
    Ppm,
    /// `.pfm`, single precision, without clamping.
    Pfm,
    /// `.exr`, OpenEXR in single precision, without clamping.
    Exr,
}

/// The endings of names.
const ENDINGS: [(&str, Format); 10] = [
    ("tga", Format::Tga),
    ("png", Format::Png),
    ("bmp", Format::Bmp),
    ("ppm", Format::Ppm),
    ("pfm", Format::Pfm),
    ("exr", Format::Exr),
    // The relatives of PPM are only read.
    ("pbm", Format::Ppm),
    ("pgm", Format::Ppm),
    ("pnm", Format::Ppm),
    ("pam", Format::Ppm),
];
/// The number of the endings of files that are written, which come first.
const WRITTEN: usize = 6;
/// The endings of pictures in formats that are not read.
const UNREAD: [&str; 19] = [
    "jpg", "jpeg", "jfif", "gif", "webp", "tif", "tiff", "heic", "heif", "avif", "jxl", "jp2", "hdr", "psd",
    "xcf", "svg", "pdf", "ico", "dds",
];

impl Format {
    /// The endings of files that are written, as a text.
    pub const WRITTEN: &str = ".tga, .png, .bmp, .ppm, .pfm or .exr";
    /// The endings of files that are written in bytes.
    pub const BYTES: &str = ".tga, .png, .bmp or .ppm";
    /// The endings of files that are read.
    pub const READ: &str = ".tga, .png, .bmp, .ppm, .pgm, .pbm, .pnm, .pam, .pfm or .exr";

    /// Returns the format of a file to write, by the last four bytes of its name, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        Self::named(ending(path)?)
    }

    /// Returns the format of a file to read.
    pub fn of_input(path: &Path) -> Option<Self> {
        Self::among(&ENDINGS, ending(path)?)
    }

    /// Returns the format of files to write with this ending, which has no dot.
    pub fn named(ending: &str) -> Option<Self> {
        Self::among(&ENDINGS[..WRITTEN], ending)
    }

    fn among(endings: &[(&str, Self)], ending: &str) -> Option<Self> {
        endings.iter().find(|(known, _)| known.eq_ignore_ascii_case(ending)).map(|&(_, format)| format)
    }

    /// True if the name has the ending of a picture in a format that is not read.
    pub fn is_unread_picture(path: &Path) -> bool {
        let is_ending = |ending: &OsStr| UNREAD.iter().any(|unread| ending.eq_ignore_ascii_case(unread));
        path.extension().is_some_and(is_ending)
    }

    /// True if its files can say which part of a larger picture they are.
    pub fn has_parts(self) -> bool {
        matches!(self, Self::Tga | Self::Png)
    }

    /// True if it holds numbers as they were rendered, and not bytes.
    pub fn is_float(self) -> bool {
        matches!(self, Self::Pfm | Self::Exr)
    }

    /// True if the first byte of a pixel is blue.
    pub(super) fn is_blue_first(self) -> bool {
        matches!(self, Self::Tga | Self::Bmp)
    }
}

/// Returns the last three bytes of a name, if a dot precedes them.
fn ending(path: &Path) -> Option<&str> {
    let [b'.', ending @ ..] = path.as_os_str().as_encoded_bytes().last_chunk::<4>()? else { return None };
    str::from_utf8(ending).ok()
}

/// The mark at the start of a text in UTF-8.
pub(super) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// The number of bytes at the start of a file by which its format is known.
pub(super) const START: usize = 4096;
/// The number of bytes of an unknown file that are shown.
const SHOWN: usize = 24;
/// The problem of a file that ends too early.
pub(super) const CUT_HEADER: &str = "it ends within its header";
/// Advice for a picture with other text in it.
pub(super) const OTHER_TEXT: &str = "print messages to standard error, as with `std::cerr`";

/// The starts of files that are not read, and what to do with them.
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
    (b"version https://git-lfs", "a pointer of Git LFS", "fetch the picture with `git lfs pull`"),
    (b"\xff\xfe", WIDE, BYTES),
    (b"\xfe\xff", WIDE, BYTES),
    (b"P\x003\0", WIDE, BYTES),
];
const CONVERT: &str = "convert it to PNG";
const WIDE: &str = "text in UTF-16, as `>` in PowerShell writes it";
const BYTES: &str = "use `>` in cmd.exe, or save the file as UTF-8 in an editor";

/// Returns the format of a file by its first bytes. An error, without the file, if its name has the ending of another
/// format.
pub(super) fn identify(path: &Path, bytes: &[u8]) -> Result<Format, Diagnostic> {
    let start = &bytes[..bytes.len().min(START)];
    let foreign = FOREIGN.iter().find(|(mark, ..)| start.starts_with(mark));
    Err(match (known(start), foreign, Format::of_input(path)) {
        (Some(ending), _, Some(named)) if Format::among(&ENDINGS, ending) == Some(named) => return Ok(named),
        (Some(ending), ..) => {
            let right = path.with_extension(ending);
            let right = quoted(right.file_name().unwrap_or_default());
            Diagnostic::error(format!("it is {}", named_file(ending))).with_hint(format!("name it {right}"))
        }
        (None, Some((_, name, advice)), _) => Diagnostic::error(format!("it is {name}")).with_hint(*advice),
        (None, None, Some(Format::Tga)) => return Ok(Format::Tga),
        (None, None, Some(named)) => unknown(start, named),
        (None, None, None) => Diagnostic::error(format!("its name must end in {}", Format::READ)),
    })
}

/// Returns the ending of files that begin like this.
fn known(start: &[u8]) -> Option<&'static str> {
    match start {
        [0x89, b'P', b'N', b'G', ..] => Some("png"),
        [b'B', b'M', ..] => Some("bmp"),
        [0x76, 0x2f, 0x31, 0x01, ..] => Some("exr"),
        _ => netpbm(start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start))
            .or_else(|| is_tga(start).then_some("tga")),
    }
}

fn netpbm(text: &[u8]) -> Option<&'static str> {
    let (&[b'P', kind], rest) = text.split_first_chunk()? else { return None };
    if rest.first().is_some_and(|&byte| byte != b'#' && !byte.is_ascii_whitespace()) {
        return None;
    }
    match kind {
        b'1' | b'4' => Some("pbm"),
        b'2' | b'5' => Some("pgm"),
        b'3' | b'6' => Some("ppm"),
        b'7' => Some("pam"),
        b'F' | b'f' => Some("pfm"),
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

/// Returns a name such as "a PNG file".
fn named_file(ending: &str) -> String {
    let article = if ending.eq_ignore_ascii_case("exr") { "an" } else { "a" };
    format!("{article} {} file", ending.to_uppercase())
}

/// Returns why a file that is in no known format cannot be read.
fn unknown(start: &[u8], named: Format) -> Diagnostic {
    let line = start.split(|&byte| byte == b'\n').next().unwrap_or_default().trim_ascii();
    if start.len() < 2 {
        return Diagnostic::error(CUT_HEADER);
    }
    let shown = quoted(&*String::from_utf8_lossy(&line[..line.len().min(SHOWN)]));
    let mut rest = start.split_inclusive(|&byte| byte == b'\n').skip(1).zip(2..);
    match rest.find(|(line, _)| netpbm(line).is_some()) {
        Some((_, number)) if matches!(named, Format::Ppm | Format::Pfm) => {
            Diagnostic::error(format!("its picture begins in line {number}, after {shown}"))
                .with_hint(OTHER_TEXT)
        }
        _ => {
            let name = named_file(&format!("{named:?}"));
            Diagnostic::error(format!("it is not {name}, since it begins with {shown}"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_texts_name_all_endings() {
        let named = |text: &str| {
            let words = text.split([',', ' ']).filter_map(|word| word.strip_prefix('.'));
            words.map(str::to_owned).collect::<std::collections::BTreeSet<_>>()
        };
        let endings = |of: &[(&str, Format)], is_named: fn(Format) -> bool| {
            of.iter()
                .filter(|(_, format)| is_named(*format))
                .map(|(ending, _)| (*ending).to_owned())
                .collect()
        };
        assert_eq!(named(Format::READ), endings(&ENDINGS, |_| true));
        assert_eq!(named(Format::WRITTEN), endings(&ENDINGS[..WRITTEN], |_| true));
        assert_eq!(named(Format::BYTES), endings(&ENDINGS[..WRITTEN], |format| !format.is_float()));
    }
}
