//! Says what is wrong with a TGA, PNG or BMP file that its decoder refuses, and what to do.

use super::decoding::too_short;
use super::format::{CUT_HEADER, TGA_HEADER};
use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use crc32fast::Hasher;
use std::io::{self, Read};

const PNG_SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// Advice for a variant of a format that is not read.
const SAVE: &str = "save it as PNG, or with 24 bits per pixel and without compression";
/// Advice for a file that is damaged.
const COPY: &str = "the file is damaged: copy it again, or write it again";

/// Returns the error for a PNG file. It is read once, chunk by chunk.
pub(super) fn in_png(file: impl Read) -> Diagnostic {
    walk_png(file).unwrap_or_else(|fault| fault)
}

/// Returns the last fault of all, which is in the compressed pixels, or the first one as an error.
fn walk_png(mut file: impl Read) -> Result<Diagnostic, Diagnostic> {
    let mut signature = [0; 8];
    let cut = |error: io::Error, size: Option<[u32; 2]>| match error.kind() {
        io::ErrorKind::UnexpectedEof => size.map_or_else(|| Diagnostic::error(CUT_HEADER), too_short),
        _ => error.into(),
    };
    file.read_exact(&mut signature).map_err(|error| cut(error, None))?;
    if signature != PNG_SIGNATURE {
        let hint = "it was copied as text: copy it in binary mode";
        return Err(Diagnostic::error("the first bytes of the PNG file are damaged").with_hint(hint));
    }
    let (mut size, mut needs_palette, mut has_pixels) = (None, false, false);
    loop {
        let mut start = [0; 8];
        file.read_exact(&mut start).map_err(|error| cut(error, size))?;
        let [length, name] = [0, 4].map(|at| [start[at], start[at + 1], start[at + 2], start[at + 3]]);
        let shown = quoted(&*String::from_utf8_lossy(&name));
        match (&name, size) {
            (b"CgBI", None) => {
                let hint = "`xcrun pngcrush -revert-iphone-optimizations a.png b.png` makes an ordinary one";
                let problem = "it is a PNG file in Apple's own form, as Xcode packs them";
                return Err(Diagnostic::error(problem).with_hint(hint));
            }
            (b"IHDR", None) => {}
            (_, None) => {
                return Err(damaged(format!("it begins with the chunk {shown} in place of its header")));
            }
            _ => {}
        }
        let length = u64::from(u32::from_be_bytes(length));
        if length > i32::MAX as u64 {
            return Err(damaged(format!("its chunk {shown} has an impossible length")));
        }
        let (header, checksum) = check(&mut file, &name, length).map_err(|error| cut(error, size))?;
        let mut stored = [0; 4];
        file.read_exact(&mut stored).map_err(|error| cut(error, size))?;
        if u32::from_be_bytes(stored) != checksum {
            return Err(damaged(format!("the checksum of its chunk {shown} is wrong")));
        }
        match &name {
            b"IHDR" => {
                let [width, height] =
                    [0, 4].map(|at| [header[at], header[at + 1], header[at + 2], header[at + 3]]);
                size = Some([width, height].map(u32::from_be_bytes));
                needs_palette = header[9] == 3;
                if length != 13 {
                    return Err(damaged(format!("its header has {length} bytes instead of 13")));
                }
                check_header(header[8..].try_into().unwrap_or_default())?;
            }
            b"PLTE" => needs_palette = false,
            b"IDAT" if needs_palette => return Err(damaged("it has no palette before its pixels".into())),
            b"IDAT" => has_pixels = true,
            b"IEND" if !has_pixels => return Err(size.map_or_else(|| damaged(String::new()), too_short)),
            b"IEND" => return Ok(damaged("its compressed pixels are damaged or end too early".into())),
            _ => {}
        }
    }
}

/// Reads the data of a chunk. Returns its first bytes and its checksum.
fn check(file: &mut impl Read, name: &[u8], length: u64) -> io::Result<([u8; 13], u32)> {
    let (mut first, mut hasher, mut left) = ([0; 13], Hasher::new(), length);
    hasher.update(name);
    let mut buffer = vec![0; length.min(1 << 16) as usize];
    while left > 0 {
        let part = &mut buffer[..left.min(1 << 16) as usize];
        file.read_exact(part)?;
        if left == length {
            let count = part.len().min(first.len());
            first[..count].copy_from_slice(&part[..count]);
        }
        hasher.update(part);
        left -= part.len() as u64;
    }
    Ok((first, hasher.finalize()))
}

/// Checks the header of a PNG file behind its size.
fn check_header([bits, kind, compression, filter, interlacing]: [u8; 5]) -> Result<(), Diagnostic> {
    let allowed: &[u8] = match kind {
        0 => &[1, 2, 4, 8, 16],
        3 => &[1, 2, 4, 8],
        2 | 4 | 6 => &[8, 16],
        _ => return Err(damaged(format!("its colour type, {kind}, is not one of PNG's"))),
    };
    if !allowed.contains(&bits) {
        return Err(damaged(format!(
            "it has {bits} bits per sample, which PNG's colour type {kind} has not"
        )));
    }
    if (compression, filter) != (0, 0) || interlacing > 1 {
        return Err(damaged(
            "its method of compression, filtering or interlacing is not one of PNG's".into(),
        ));
    }
    Ok(())
}

fn damaged(problem: String) -> Diagnostic {
    Diagnostic::error(problem).with_hint(COPY)
}

/// Returns the error for a BMP file.
pub(super) fn in_bmp(bytes: &[u8]) -> Diagnostic {
    let number = |at: usize| bytes.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes));
    let half = |at: usize| bytes.get(at..)?.first_chunk().map(|bytes| u16::from_le_bytes(*bytes));
    let unread = |problem: String| Diagnostic::error(problem).with_hint(SAVE);
    let Some(header) = number(14) else { return Diagnostic::error(CUT_HEADER) };
    if !matches!(header, 12 | 40 | 52 | 56 | 108 | 124) {
        return unread(format!("its header has {header} bytes, which no BMP file of Windows has"));
    }
    let is_oldest = header == 12;
    let [planes, bits] = if is_oldest { [half(22), half(24)] } else { [half(26), half(28)] };
    let (Some(planes), Some(bits)) = (planes, bits) else { return Diagnostic::error(CUT_HEADER) };
    let compression = if is_oldest { 0 } else { number(30).unwrap_or(0) };
    let [width, height] = [18, 22].map(|at| number(at).unwrap_or(0) as i32);
    let name = match compression {
        0..=3 => None,
        4 => Some("JPEG"),
        5 => Some("PNG"),
        6 => Some("a field of bits with alpha"),
        11..=13 => Some("for four inks"),
        _ => Some("unknown"),
    };
    let is_allowed = match compression {
        0 if is_oldest => [1, 4, 8, 24].contains(&bits),
        0 => [1, 2, 4, 8, 16, 24, 32].contains(&bits),
        1 => bits == 8,
        2 => bits == 4,
        _ => [16, 32].contains(&bits),
    };
    match name {
        _ if planes != 1 => damaged(format!("it has {planes} planes, and a BMP file has 1")),
        _ if !is_oldest && (width < 0 || height == i32::MIN) => {
            damaged(format!("its size is {width} x {height} pixels"))
        }
        _ if !is_oldest && width.max(height) > 65535 => {
            unread(format!("it has {width} x {height} pixels, and at most 65535 a side are read"))
        }
        Some(name) => unread(format!("its compression is {name} (number {compression})")),
        None if !is_allowed => {
            unread(format!("it has {bits} bits per pixel, which BMP's compression {compression} has not"))
        }
        None if height < 0 && matches!(compression, 1 | 2) => {
            unread("it is compressed and begins with the top row".into())
        }
        None if !is_oldest && bits <= 8 && number(46).is_some_and(|colors| colors > 1 << bits) => {
            damaged(format!("its palette has more colours than {bits} bits can choose"))
        }
        None if compression == 3 => unread("the masks of its colours are not valid".into()),
        None => damaged("its pixels are damaged or end too early".into()),
    }
}

/// Returns the error for a TGA file whose type is known.
pub(super) fn in_tga(header: &[u8; TGA_HEADER]) -> Diagnostic {
    let &[_, map_kind, kind, _, _, _, _, entry_bits, .., bits, _] = header;
    let unread = |problem: String| Diagnostic::error(problem).with_hint(SAVE);
    let (allowed, content): (&[u8], _) = match kind % 8 {
        1 => (&[8, 16], "with a colour map"),
        2 => (&[15, 16, 24, 32], "of colours"),
        _ => (&[8, 16], "of greys"),
    };
    match kind % 8 {
        _ if !allowed.contains(&bits) => {
            let list = allowed.iter().map(u8::to_string).collect::<Vec<_>>().join(", ");
            let unit = if bits == 1 { "bit" } else { "bits" };
            unread(format!("it has {bits} {unit} per pixel; TGA files {content} are read with {list}"))
        }
        1 if map_kind != 1 => damaged("its pixels are indices, but it has no colour map".into()),
        _ if map_kind == 1 && ![15, 16, 24, 32].contains(&entry_bits) => {
            unread(format!("the colours of its map have {entry_bits} bits, not 15, 16, 24 or 32"))
        }
        1 if bits > entry_bits || usize::from(bits / 8) > 3 => {
            unread("its indices are longer than the colours of its map".into())
        }
        1 => damaged("a pixel has an index beyond its colour map".into()),
        _ => damaged("its pixels are damaged".into()),
    }
}
