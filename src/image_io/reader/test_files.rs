//! Test files: TGA and PNG files of every variant, written byte by byte.

use super::{Diagnostic, Picture, read_picture};
use std::fs;
use std::path::PathBuf;
use tempfile::{TempDir, tempdir};

pub(super) type Rgb = [u8; 3];
/// The name of a chunk of a PNG file, and its data.
pub(super) type Chunk = (&'static [u8; 4], &'static [u8]);

pub(super) const WIDTH: u16 = 3;
pub(super) const HEIGHT: u16 = 2;
/// The pixels of a picture, in rows from the top. Their levels are representable in 5 bits.
pub(super) const COLORS: [Rgb; 6] =
    [[255, 0, 0], [0, 255, 0], [8, 132, 247], [8, 132, 247], [8, 132, 247], [33, 66, 99]];
pub(super) const GREYS: [u8; 6] = [9, 9, 200, 4, 0, 255];

/// The properties of a TGA file.
#[derive(Clone, Copy)]
pub(super) struct Tga {
    pub(super) image_type: u8,
    pub(super) bits: u8,
    pub(super) descriptor: u8,
    /// The first index, bits per entry and number of entries.
    pub(super) map: (u16, u8, u16),
}

impl Tga {
    pub(super) fn header(self, width: u16, height: u16) -> Vec<u8> {
        let (first, map_bits, entries) = self.map;
        let id_length = 3;
        let mut bytes = vec![id_length, u8::from(entries > 0), self.image_type];
        [first, entries].iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        bytes.push(map_bits);
        [7, 9, width, height].iter().for_each(|word| bytes.extend(word.to_le_bytes()));
        bytes.extend([self.bits, self.descriptor]);
        bytes.extend([1, 2, 3]);
        bytes
    }

    /// A file with this colour map and these encoded pixels, which are in rows from the top.
    pub(super) fn file(self, map: &[u8], pixels: &[Vec<u8>; 6]) -> Vec<u8> {
        let stored = self.in_order_of_storage(pixels);
        let data = if self.image_type < 8 { stored.concat() } else { run_lengths(&stored) };
        [&self.header(WIDTH, HEIGHT), map, &data].concat()
    }

    /// Pixels are stored from the right if bit 4 of the descriptor is set, and rows from the top if bit 5 is.
    fn in_order_of_storage(self, pixels: &[Vec<u8>; 6]) -> Vec<Vec<u8>> {
        let mut rows: Vec<Vec<Vec<u8>>> = pixels.chunks(WIDTH.into()).map(<[_]>::to_vec).collect();
        if self.descriptor & 0x20 == 0 {
            rows.reverse();
        }
        if self.descriptor & 0x10 != 0 {
            rows.iter_mut().for_each(|row| row.reverse());
        }
        rows.concat()
    }
}

/// Run-length encoding, with packets that may extend into the next row. A single pixel is a raw packet.
fn run_lengths(pixels: &[Vec<u8>]) -> Vec<u8> {
    let mut data = Vec::new();
    for run in pixels.chunk_by(|a, b| a == b) {
        let marker = if run.len() > 1 { 0x80 } else { 0 };
        data.push(marker | (run.len() - 1) as u8);
        data.extend(&run[0]);
    }
    data
}

/// A colour in 16 bits: 5 bits for each channel, and an attribute bit.
pub(super) fn packed(color: Rgb) -> Vec<u8> {
    let [red, green, blue] = color.map(|level| (f64::from(level) * 31.0 / 255.0).round() as u16);
    (0x8000 | red << 10 | green << 5 | blue).to_le_bytes().to_vec()
}

pub(super) fn bgr([red, green, blue]: Rgb) -> Vec<u8> {
    vec![blue, green, red]
}

pub(super) fn bgra(color: Rgb) -> Vec<u8> {
    [bgr(color), vec![17]].concat()
}

pub(super) struct Folder(pub(super) TempDir);

impl Folder {
    pub(super) fn new() -> Self {
        Self(tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.path().join(name);
        // The file is removed first, because some file systems flush a file to the disk when it is
        // overwritten.
        fs::remove_file(&path).ok();
        fs::write(&path, bytes).unwrap();
        path
    }

    pub(super) fn read(&self, name: &str, bytes: &[u8]) -> Result<Picture, Diagnostic> {
        read_picture(&self.file(name, bytes))
    }

    /// The message of the error of a file, which must be one line.
    pub(super) fn complaint(&self, name: &str, bytes: &[u8]) -> String {
        let shown = self.read(name, bytes).unwrap_err().in_one_line();
        assert_eq!(shown.lines().count(), 1, "{shown}");
        shown.replace(&*self.0.path().to_string_lossy(), "F").replace("F\\", "F/")
    }
}

pub(super) fn picture(colors: &[Rgb; 6]) -> Picture {
    Picture::from_rgb(WIDTH.into(), HEIGHT.into(), colors.concat())
}

/// A PNG file whose data is in a stored block, that is, uncompressed.
pub(super) fn png(size: [u32; 2], bits: u8, color_type: u8, chunks: &[Chunk], rows: &[&[u8]]) -> Vec<u8> {
    let header = [&size[0].to_be_bytes()[..], &size[1].to_be_bytes(), &[bits, color_type, 0, 0, 0]].concat();
    // Each row begins with the number of its filter.
    let data: Vec<u8> = rows.iter().flat_map(|row| [&[0], *row].concat()).collect();
    let length = data.len() as u16;
    let (low, high) = data.iter().fold((1, 0), |(low, high), &byte| {
        ((low + u32::from(byte)) % 65521, (high + low + u32::from(byte)) % 65521)
    });
    let stored = [
        &[0x78, 1, 1][..],
        &length.to_le_bytes(),
        &(!length).to_le_bytes(),
        &data,
        &(high << 16 | low).to_be_bytes(),
    ];
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    file.extend(chunk(b"IHDR", &header));
    chunks.iter().for_each(|(name, data)| file.extend(chunk(name, data)));
    [file, chunk(b"IDAT", &stored.concat()), chunk(b"IEND", &[])].concat()
}

pub(super) fn chunk(name: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let checked = [&name[..], data].concat();
    let check = !checked.iter().fold(!0_u32, |state, &byte| {
        (0..8).fold(state ^ u32::from(byte), |state, _| {
            state >> 1 ^ if state & 1 == 1 { 0xEDB8_8320 } else { 0 }
        })
    });
    [&(data.len() as u32).to_be_bytes()[..], &checked, &check.to_be_bytes()].concat()
}

/// An uncompressed BMP file of 24 bits per pixel, with its rows from the bottom or, with a negative height, from the top.
pub(super) fn bmp(is_from_top: bool) -> Vec<u8> {
    let mut rows: Vec<Vec<u8>> =
        COLORS.chunks(WIDTH.into()).map(|row| row.iter().flat_map(|&rgb| bgr(rgb)).collect()).collect();
    rows.iter_mut().for_each(|row| row.resize(row.len().next_multiple_of(4), 0));
    let height = if is_from_top { -i32::from(HEIGHT) } else { i32::from(HEIGHT) };
    if !is_from_top {
        rows.reverse();
    }
    bmp_file([WIDTH.into(), height], 24, 0, &[], &rows.concat())
}

/// A BMP file with this table of colours and these rows.
pub(super) fn bmp_file(
    [width, height]: [i32; 2],
    bits: u8,
    compression: u8,
    map: &[u8],
    rows: &[u8],
) -> Vec<u8> {
    let start = (54 + map.len()) as u32;
    let length = start + rows.len() as u32;
    let colors = (map.len() / 4) as u32;
    let mut file = b"BM".to_vec();
    for field in
        [length, 0, start, 40, width as u32, height as u32, 1 | u32::from(bits) << 16, compression.into()]
    {
        file.extend(field.to_le_bytes());
    }
    for field in [rows.len() as u32, 0, 0, colors, 0] {
        file.extend(field.to_le_bytes());
    }
    [file, map.to_vec(), rows.to_vec()].concat()
}
