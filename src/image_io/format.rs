//! The formats of picture files. The end of a name decides what is written, the first bytes decide what is read.

use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use serde::Serialize;
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
const ENDINGS: [(&[u8; 4], Format); 10] = [
    (b".tga", Format::Tga),
    (b".png", Format::Png),
    (b".bmp", Format::Bmp),
    (b".ppm", Format::Ppm),
    (b".pfm", Format::Pfm),
    (b".exr", Format::Exr),
    // The relatives of PPM are only read.
    (b".pbm", Format::Ppm),
    (b".pgm", Format::Ppm),
    (b".pnm", Format::Ppm),
    (b".pam", Format::Ppm),
];
/// The number of the endings of files that are written, which come first.
const WRITTEN: usize = 6;

impl Format {
    /// The endings of names of files that are read, as a text.
    pub const READ: &str = ".tga, .png, .bmp, .ppm, .pgm, .pbm, .pnm, .pam, .pfm or .exr";

    /// Returns the format of a file to write, by the last four bytes of its name, in upper or lower case.
    pub fn of(path: &Path) -> Option<Self> {
        Self::among(&ENDINGS[..WRITTEN], path)
    }

    /// Returns the format of a file to read.
    pub fn of_input(path: &Path) -> Option<Self> {
        Self::among(&ENDINGS, path)
    }

    fn among(endings: &[(&[u8; 4], Self)], path: &Path) -> Option<Self> {
        let end = path.as_os_str().as_encoded_bytes().last_chunk::<4>()?;
        endings.iter().find(|(ending, _)| ending.eq_ignore_ascii_case(end)).map(|&(_, format)| format)
    }

    /// Returns the format with this name, which is an ending without the dot.
    pub fn named(name: &str) -> Option<Self> {
        Self::of(Path::new(&format!(".{name}"))).filter(|_| name.len() == 3)
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
        (Some((format, _)), _, Some(named)) if format == named => return Ok(format),
        (Some((_, ending)), ..) => {
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

/// Returns a format, and the ending of its files' names.
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
