//! The rows of TGA and PNG files as this program writes them, one by one, and the part of a picture that they state.

use super::cannot;
use super::common_to_readers::{open_regular, too_short, undecoded};
use super::format::{CUT_HEADER, Format, START, TGA_HEADER, identify};
use super::part::{PNG_COMMENT, Part};
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Window};
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// The file of a part, encoded as this program does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartFile {
    /// The path as the user gave it.
    pub path: PathBuf,
    /// Width and height of the whole picture in pixels.
    pub whole: [usize; 2],
    /// The part's place in the whole.
    pub window: Window,
    /// A hash of everything that the bytes of the whole picture depend on.
    pub fingerprint: u128,
}

impl PartFile {
    /// Reads what a file says about itself. An error if it is no part, or not encoded as this program does.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        let no_part = |problem: String| cannot("merge", path, Diagnostic::error(problem));
        let Rows { size: [width, height], comment, .. } = Rows::open(path)?;
        let part = comment.as_deref().and_then(Part::parse);
        let Part { whole, at: [x, y], fingerprint } = part.ok_or_else(|| {
            no_part(format!("it is a picture of {width} x {height} pixels, not a part written by `-region`"))
        })?;
        let window = Window { x, y, width, height };
        if !window.fits(whole) {
            return Err(no_part("its place lies outside its picture".into()));
        }
        Ok(Self { path: path.to_owned(), whole, window, fingerprint })
    }
}

/// The rows of a TGA or PNG file as this program writes it, from the top. They take the memory of a row.
pub struct Rows {
    path: PathBuf,
    /// Width and height in pixels.
    pub(super) size: [usize; 2],
    comment: Option<String>,
    decoder: Decoder,
    /// The number of rows that have not been read.
    left: usize,
}

enum Decoder {
    /// The rows follow uncompressed, with blue first.
    Tga(BufReader<File>),
    Png(Box<png::Reader<BufReader<File>>>),
}

impl Rows {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        let identified = || {
            let (mut file, mut start) = (open_regular(path)?, vec![]);
            file.by_ref().take(START as u64).read_to_end(&mut start)?;
            Ok::<_, Diagnostic>((identify(path, &start)?, file))
        };
        let (format, file) = identified().map_err(|reason| cannot("read", path, reason))?;
        Self::new(path, format, file)
    }

    /// Reads what precedes the rows of a file, which need not have all rows.
    pub(super) fn new(path: &Path, format: Format, mut file: File) -> Result<Self, Diagnostic> {
        let read = file.rewind().and_then(|()| match format {
            Format::Tga => tga(BufReader::new(file)),
            Format::Png => png(BufReader::new(file)),
            Format::Bmp | Format::Ppm | Format::Pfm | Format::Exr => Ok(None),
        });
        match read {
            Ok(Some(Opened { size, comment, decoder })) if !size.contains(&0) => {
                Ok(Self { path: path.to_owned(), size, comment, decoder, left: size[1] })
            }
            // `-convert` reads such a file in another way, and does not show the error.
            Ok(_) => {
                let problem = "it is not encoded like a part written by `-region`";
                Err(cannot("merge", path, Diagnostic::error(problem)))
            }
            Err(error) => Err(cannot("read", path, undecoded(error, Diagnostic::error(CUT_HEADER)))),
        }
    }

    /// Reads the next row as bytes of red, green and blue. The last one of a PNG file is checked with what follows it.
    pub(super) fn next(&mut self, rgb: &mut Vec<u8>) -> Result<(), Diagnostic> {
        rgb.resize(self.size[0] * CHANNELS, 0);
        self.left = self.left.saturating_sub(1);
        let read = match &mut self.decoder {
            Decoder::Tga(source) => {
                let read = source.read_exact(rgb);
                rgb.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
                read
            }
            Decoder::Png(reader) => {
                let read =
                    reader.read_row(rgb).and_then(|_| if self.left > 0 { Ok(()) } else { reader.finish() });
                read.map_err(io::Error::from)
            }
        };
        read.map_err(|error| cannot("read", &self.path, undecoded(error, too_short(self.size))))
    }
}

/// A file whose header has been read.
struct Opened {
    size: [usize; 2],
    comment: Option<String>,
    decoder: Decoder,
}

/// Reads the header of a TGA file. Returns `None` if the file is not encoded as this program does.
fn tga(mut source: BufReader<File>) -> io::Result<Option<Opened>> {
    let mut header = [0; TGA_HEADER];
    source.read_exact(&mut header)?;
    let mut id = vec![0; header[0].into()];
    source.read_exact(&mut id)?;
    let [_, 0, 2, 0, 0, 0, 0, 0, _, _, _, _, w0, w1, h0, h1, 24, 32] = header else { return Ok(None) };
    let size = [[w0, w1], [h0, h1]].map(|side| usize::from(u16::from_le_bytes(side)));
    Ok(Some(Opened { size, comment: String::from_utf8(id).ok(), decoder: Decoder::Tga(source) }))
}

/// Reads what precedes the rows of a PNG file, like [`tga`].
fn png(source: BufReader<File>) -> io::Result<Option<Opened>> {
    let mut options = png::DecodeOptions::default();
    options.set_skip_ancillary_crc_failures(false);
    let reader = png::Decoder::new_with_options(source, options).read_info()?;
    let info = reader.info();
    let text = info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == PNG_COMMENT);
    let size = [info.width, info.height].map(|side| side as usize);
    let comment = text.map(|chunk| chunk.text.clone());
    let is_own =
        !info.interlaced && (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    Ok(is_own.then(|| Opened { size, comment, decoder: Decoder::Png(Box::new(reader)) }))
}
