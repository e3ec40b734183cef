//! A picture file that is written row by row.
//!
//! The encoded bytes are collected in a spool, and are written to the target when the last row is complete.

use super::bmp;
use super::checksum::{CheckedPart, PartHasher};
use super::complete_file::CompleteFile;
use super::error::ImageError;
use super::float_rows::{Content, Exceptional, FloatRows};
use super::output::Target;
use super::part::{MAX_TEXT, Part};
use super::part_file::Rows;
use super::spool::Spool;
use super::{Format, OutputFile, beside};
use crate::picture::{BLUE_FIRST, CHANNELS, RED_FIRST, truncate_to_bytes};
use crate::scene::Color;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The length of the header of a TGA file, in bytes.
pub(super) const TGA_HEADER: usize = 18;
/// The keyword of the text in a PNG file that says which part of a larger picture it is.
pub(super) const PNG_COMMENT: &str = "Comment";
/// Where the text chunk of a part starts in its PNG file: behind the signature of 8 bytes and the header's chunk of 25.
const PNG_TEXT_CHUNK: usize = 8 + 25;
/// The length of a PNG file's chunks of compressed rows, in bytes.
const CHUNK: usize = 1 << 16;

/// A picture file under construction, which takes the rows from the top.
pub struct PictureWriter {
    /// The path as the user gave it, for messages.
    path: PathBuf,
    target: Target,
    format: Format,
    size: [usize; 2],
    spool: Shared,
    encoder: Encoder,
    /// The number of rows so far.
    rows: usize,
    /// The current row's bytes.
    bytes: Vec<u8>,
    /// How many colours have become black because they have a NaN.
    black: u64,
    /// The part that the picture is, without its checksum, and the rows' checksum so far; none in floating point.
    part: Option<(CheckedPart, PartHasher)>,
}

enum Encoder {
    /// The rows follow the header uncompressed.
    Plain(Plain),
    Png(Box<png::StreamWriter<'static, Shared>>),
    /// PFM or OpenEXR.
    Floats(FloatRows),
}

/// How uncompressed rows are encoded.
struct Plain {
    is_blue_first: bool,
    /// How many zeros follow each row.
    padding: usize,
}

impl Plain {
    const TGA: Self = Self { is_blue_first: true, padding: 0 };
    const PPM: Self = Self { is_blue_first: false, padding: 0 };
}

/// The spool. It is shared, because the PNG encoder owns what it writes to.
#[derive(Clone)]
struct Shared(Arc<Mutex<Spool>>);

impl Shared {
    fn spool(&self) -> MutexGuard<'_, Spool> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.spool().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.spool().flush()
    }
}

impl PictureWriter {
    /// Starts a picture of this width and height in pixels. A size that the format does not support is an
    /// error.
    pub(super) fn new(
        path: PathBuf,
        format: Format,
        target: Target,
        size: [usize; 2],
        content: Content,
        part: Option<&Part>,
    ) -> Result<Self, ImageError> {
        let checked = part.filter(|_| format.has_parts());
        let checked = checked.map(|part| CheckedPart { part: part.clone(), checksum: 0 });
        let bytes = if format.is_float() { size_of::<f32>() } else { 1 };
        let uncompressed = size[0].saturating_mul(size[1]).saturating_mul(CHANNELS * bytes);
        let spool = Shared(Arc::new(Mutex::new(Spool::new(
            target.folder(),
            uncompressed.saturating_add(TGA_HEADER + MAX_TEXT),
        ))));
        let encoder = match format {
            Format::Tga => {
                let [width, height] = size;
                let header = tga_header(size, checked.as_ref()).ok_or(ImageError::Sides {
                    path: path.clone(),
                    width,
                    height,
                })?;
                let written = spool.clone().write_all(&header);
                written.map_err(|error| ImageError::io("write", &path, error))?;
                Encoder::Plain(Plain::TGA)
            }
            Format::Bmp => {
                let [width, height] = size;
                let header = bmp::header(size).ok_or(ImageError::TooLargeForBmp {
                    path: path.clone(),
                    width,
                    height,
                })?;
                let length = bmp::row_length(width);
                spool.spool().reverse_rows(header.len(), length);
                let written = spool.clone().write_all(&header);
                written.map_err(|error| ImageError::io("write", &path, error))?;
                Encoder::Plain(Plain { padding: length - width * CHANNELS, ..Plain::TGA })
            }
            Format::Ppm => {
                let [width, height] = size;
                let written = write!(spool.clone(), "P6\n{width} {height}\n255\n");
                written.map_err(|error| ImageError::io("write", &path, error))?;
                Encoder::Plain(Plain::PPM)
            }
            Format::Png => png_encoder(spool.clone(), size, checked.as_ref())
                .map_err(|error| ImageError::io("write", &path, error.into()))
                .map(|encoder| Encoder::Png(Box::new(encoder)))?,
            Format::Pfm | Format::Exr => {
                let [width, height] = size;
                let rows = FloatRows::new(format == Format::Pfm, content, size, part);
                let rows = rows.ok_or(ImageError::Sides { path: path.clone(), width, height })?;
                let header = rows.header();
                if format == Format::Pfm {
                    spool.spool().reverse_rows(header.len(), rows.row_length());
                }
                let written = spool.clone().write_all(&header);
                written.map_err(|error| ImageError::io("write", &path, error))?;
                Encoder::Floats(rows)
            }
        };
        let part = checked.map(|checked| {
            let hasher = PartHasher::new(&checked.part, size.map(|n| n as u32));
            (checked, hasher)
        });
        Ok(Self { path, target, format, size, spool, encoder, rows: 0, bytes: Vec::new(), black: 0, part })
    }

    /// The colours so far that are not shown as they are.
    pub fn exceptional(&self) -> Exceptional {
        match &self.encoder {
            Encoder::Floats(rows) => rows.exceptional,
            Encoder::Plain(_) | Encoder::Png(_) => {
                Exceptional { black: self.black, ..Exceptional::default() }
            }
        }
    }

    /// Adds the next row from the top.
    pub fn row(&mut self, colors: &[Color]) -> Result<(), ImageError> {
        self.bytes.resize(colors.len() * CHANNELS, 0);
        match &mut self.encoder {
            Encoder::Plain(Plain { is_blue_first: true, .. }) => {
                self.black += truncate_to_bytes::<BLUE_FIRST>(colors, &mut self.bytes);
            }
            Encoder::Plain(_) | Encoder::Png(_) => {
                self.black += truncate_to_bytes::<RED_FIRST>(colors, &mut self.bytes)
            }
            Encoder::Floats(rows) => rows.encode(colors, &mut self.bytes),
        }
        self.encode()
    }

    /// Adds the next row from the top, given as bytes of red, green and blue. This is an error in a file of
    /// floating-point numbers.
    pub fn row_of_bytes(&mut self, bytes: &[u8]) -> Result<(), ImageError> {
        if let Encoder::Floats(_) = self.encoder {
            return Err(ImageError::OnlyBytes { path: self.path.clone() });
        }
        self.bytes.clear();
        self.bytes.extend_from_slice(bytes);
        if let Encoder::Plain(Plain { is_blue_first: true, .. }) = self.encoder {
            self.bytes.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
        }
        self.encode()
    }

    fn encode(&mut self) -> Result<(), ImageError> {
        self.rows += 1;
        match (&mut self.part, self.format) {
            (Some((_, hasher)), Format::Tga) => hasher.row_of_bgr(&self.bytes),
            (Some((_, hasher)), _) => hasher.row(&self.bytes),
            (None, _) => {}
        }
        let written = match &mut self.encoder {
            Encoder::Plain(plain) => {
                self.bytes.resize(self.bytes.len() + plain.padding, 0);
                self.spool.write_all(&self.bytes)
            }
            Encoder::Floats(_) => self.spool.write_all(&self.bytes),
            Encoder::Png(encoder) => encoder.write_all(&self.bytes),
        };
        written.map_err(|error| ImageError::io("write", &self.path, error))
    }

    /// Writes the rows so far to a file beside that of the picture: to `o.partial.tga` instead of `o.tga`. Returns the
    /// file; none if there are no rows, if the picture does not go to a regular file whose name tells its format, or
    /// if its format has no parts.
    pub fn write_part(mut self, part: &Part) -> Result<Option<PathBuf>, ImageError> {
        let part_path = part_beside(&self.path, self.format);
        let Some(path) = part_path.filter(|_| self.rows > 0 && matches!(self.target, Target::Replace { .. }))
        else {
            return Ok(None);
        };
        let failed = |path: &Path, error| ImageError::io("write", path, error);
        let ([width, height], rows) = (self.size, self.rows);
        if let Encoder::Png(_) = self.encoder {
            // The encoder ends only with all rows.
            let black = vec![0; width * CHANNELS];
            (rows..height).try_for_each(|_| self.row_of_bytes(&black))?;
        }
        let (format, own_path) = (self.format, self.path.clone());
        let source = self.end().and_then(|(spool, _)| spool.into_source());
        let source = source.map_err(|error| failed(&own_path, error))?;
        let (mut from, _) = Rows::read(&own_path, format, source)?;
        let mut to = OutputFile::prepare(&path)?.begin([width, rows], Some(part))?;
        let mut row = Vec::new();
        for _ in 0..rows {
            from.next(&mut row)?;
            to.row_of_bytes(&row)?;
        }
        to.finish().map(|_| Some(path))
    }

    /// Writes the picture to its target. If this fails and the target is a regular file, nothing is written.
    pub fn finish(self) -> Result<(), ImageError> {
        self.complete()?.put_in_place()
    }

    /// The file of the picture, which has all of its rows.
    pub fn complete(self) -> Result<CompleteFile, ImageError> {
        let path = self.path.clone();
        let (spool, target) = self.end().map_err(|error| ImageError::io("write", &path, error))?;
        CompleteFile::new(path, target, spool)
    }

    /// Ends the encoding.
    fn end(self) -> io::Result<(Spool, Target)> {
        if let Encoder::Png(encoder) = self.encoder {
            encoder.finish()?;
        }
        if let Some((part, hasher)) = self.part {
            // The text has the same length with any checksum.
            let text = CheckedPart { checksum: hasher.finish(), ..part }.to_string();
            let mut spool = self.spool.spool();
            match self.format {
                Format::Tga => spool.overwrite(TGA_HEADER, text.as_bytes())?,
                _ => spool.overwrite(PNG_TEXT_CHUNK, &png_text_chunk(&text))?,
            }
        }
        let spool = std::mem::replace(&mut *self.spool.spool(), Spool::new(PathBuf::new(), 0));
        Ok((spool, self.target))
    }
}

/// The file of the rows that are complete when a run is stopped: `o.partial.tga` beside `o.tga`. None if the name does
/// not tell the format, or if that has no parts.
pub fn part_beside(path: &Path, format: Format) -> Option<PathBuf> {
    let has_parts = format.has_parts() && Format::of(path) == Some(format);
    has_parts.then(|| beside(path, "partial"))
}

/// The text chunk of a PNG file: its length, type, keyword and text, and their checksum.
fn png_text_chunk(text: &str) -> Vec<u8> {
    let content = [b"tEXt", PNG_COMMENT.as_bytes(), &[0], text.as_bytes()].concat();
    let length = (content.len() - 4) as u32;
    [&length.to_be_bytes(), content.as_slice(), &crc32fast::hash(&content).to_be_bytes()].concat()
}

/// The header as the course's program writes it: uncompressed true colour of 24 bits, with rows from the top. That of a
/// part has an origin, which is its lower left corner from that of the whole, and an image ID. None if a side is longer
/// than 65535 pixels.
pub(super) fn tga_header([width, height]: [usize; 2], part: Option<&CheckedPart>) -> Option<Vec<u8>> {
    let [w0, w1] = u16::try_from(width).ok()?.to_le_bytes();
    let height = u16::try_from(height).ok()?;
    let [h0, h1] = height.to_le_bytes();
    let origin = |CheckedPart { part, .. }: &CheckedPart| {
        let below = part.whole[1].checked_sub(part.at[1])?.checked_sub(height.into())?;
        Some([u16::try_from(part.at[0]).ok()?.to_le_bytes(), u16::try_from(below).ok()?.to_le_bytes()])
    };
    let [[x0, x1], [y0, y1]] = part.map_or(Some([[0; 2]; 2]), origin)?;
    let id = part.map_or(String::new(), CheckedPart::to_string);
    let length = u8::try_from(id.len()).ok()?;
    let header = [length, 0, 2, 0, 0, 0, 0, 0, x0, x1, y0, y1, w0, w1, h0, h1, 24, 32];
    Some([&header, id.as_bytes()].concat())
}

/// An encoder for three channels of eight bits, with the fastest compression that the crate has.
fn png_encoder(
    spool: Shared,
    size: [usize; 2],
    part: Option<&CheckedPart>,
) -> Result<png::StreamWriter<'static, Shared>, png::EncodingError> {
    let [width, height] = size.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let mut encoder = png::Encoder::new(spool, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    if let Some(part) = part {
        encoder.add_text_chunk(PNG_COMMENT.into(), part.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    if let Some(CheckedPart { part: Part { at: [x, y], .. }, .. }) = part {
        const UNIT_PIXEL: u8 = 0;
        let offsets = [&x.to_be_bytes()[..], &y.to_be_bytes(), &[UNIT_PIXEL]].concat();
        writer.write_chunk(png::chunk::ChunkType(*b"oFFs"), &offsets)?;
    }
    writer.into_stream_writer_with_size(CHUNK)
}
