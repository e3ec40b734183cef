//! A picture file that is written row by row.

use super::header;
use super::output::{CompleteFile, OutputFile};
use super::part::{PNG_COMMENT, Part, Rows};
use super::{Format, ImageError, beside};
use crate::picture::{BLUE_FIRST, CHANNELS, Color, RED_FIRST, truncate_to_bytes};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::SpooledTempFile;

/// The length of a PNG file's chunks of compressed rows, in bytes.
const PNG_CHUNK: usize = 1 << 16;

/// What the colours of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Red, green and blue, or the coordinates of normals.
    Colors,
    /// Distances, equal in all channels, and infinite where there is nothing.
    Distances,
}

/// The number of pixels whose colours a file does not show, or not as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exceptional {
    /// Those that are black in a file of bytes because a channel is not a number.
    pub black: u64,
    /// Those that have a NaN in a file of floating-point numbers.
    pub nan: u64,
    /// Those with a number that is infinite in a file of floating-point numbers, or a distance that is 0 there, because
    /// single precision ends at about 3.4e38 and 1.4e-45.
    pub out_of_range: u64,
}

impl std::ops::AddAssign for Exceptional {
    fn add_assign(&mut self, other: Self) {
        self.black += other.black;
        self.nan += other.nan;
        self.out_of_range += other.out_of_range;
    }
}

/// A picture file under construction, which takes the rows from the top.
pub struct PictureWriter {
    output: OutputFile,
    format: Format,
    /// Width and height in pixels.
    size: [usize; 2],
    content: Content,
    /// The row of the whole picture that comes first.
    top: usize,
    spool: Shared,
    /// The length of what precedes the rows, but for PNG.
    header: usize,
    png: Option<Box<png::StreamWriter<'static, Shared>>>,
    /// The number of rows so far.
    rows: usize,
    /// The current row's bytes.
    bytes: Vec<u8>,
    /// Counts the colours so far that are not shown as they are.
    pub exceptional: Exceptional,
}

/// The file's content. It is shared, because the PNG encoder owns what it writes to.
#[derive(Clone)]
struct Shared(Arc<Mutex<SpooledTempFile>>);

impl Shared {
    fn lock(&self) -> MutexGuard<'_, SpooledTempFile> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lock().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.lock().flush()
    }
}

impl OutputFile {
    /// Begins a picture of this width and height in pixels, of colours or of distances. Its file says which part of a
    /// larger picture it is, if it is one. A size that the format does not support is an error.
    pub fn begin(
        self,
        format: Format,
        size: [usize; 2],
        content: Content,
        part: Option<&Part>,
    ) -> Result<PictureWriter, ImageError> {
        let header = header_of(format, size, content, part);
        let header = header.map_err(|reason| ImageError::new("write", &self.path, reason))?;
        let rows = size[1].saturating_mul(row_length(format, size[0], content));
        let begin = || {
            let mut spool = Shared(Arc::new(Mutex::new(self.spool(header.len().saturating_add(rows))?)));
            spool.write_all(&header)?;
            let encoder = (format == Format::Png).then(|| png_encoder(spool.clone(), size, part));
            io::Result::Ok((spool, encoder.transpose()?.map(Box::new)))
        };
        let (spool, png) = begin().map_err(|error| ImageError::io("write", &self.path, error))?;
        let (header, top) = (header.len(), part.map_or(0, |part| part.at[1] as usize));
        let (output, rows, bytes, exceptional) = (self, 0, vec![], Exceptional::default());
        Ok(PictureWriter { output, format, size, content, top, spool, header, png, rows, bytes, exceptional })
    }
}

impl PictureWriter {
    /// Adds the next row from the top.
    pub fn row(&mut self, colors: &[Color]) -> Result<(), ImageError> {
        if self.format.is_float() {
            self.encode_numbers(colors);
        } else {
            self.bytes.resize(colors.len() * CHANNELS, 0);
            self.exceptional.black += match self.format.is_blue_first() {
                true => truncate_to_bytes::<BLUE_FIRST>(colors, &mut self.bytes),
                false => truncate_to_bytes::<RED_FIRST>(colors, &mut self.bytes),
            };
        }
        self.write_bytes()
    }

    /// Adds the next row from the top, given as bytes of red, green and blue. This is an error in a file of
    /// floating-point numbers.
    pub fn row_of_bytes(&mut self, bytes: &[u8]) -> Result<(), ImageError> {
        if self.format.is_float() {
            let reason = "a picture of bytes has no floating-point numbers";
            return Err(ImageError::new("write", &self.output.path, reason));
        }
        self.bytes.clear();
        self.bytes.extend_from_slice(bytes);
        if self.format.is_blue_first() {
            self.bytes.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
        }
        self.write_bytes()
    }

    /// Encodes a row in single precision, neither clamped nor cut, and counts the exceptional pixels.
    fn encode_numbers(&mut self, colors: &[Color]) {
        for color in colors {
            let single = color.as_vec3();
            let is_in_range = match self.content {
                Content::Colors => single.is_finite(),
                // An infinite distance says that there is nothing.
                Content::Distances => {
                    !color.is_finite() || single.is_finite() && (single.x != 0.0 || color.x == 0.0)
                }
            };
            self.exceptional.nan += u64::from(color.is_nan());
            self.exceptional.out_of_range += u64::from(!is_in_range && !color.is_nan());
        }
        self.bytes.clear();
        if self.format == Format::Exr {
            let channels = if self.content == Content::Colors { 3 } else { 1 };
            self.bytes.extend(header::exr_row(self.top + self.rows, colors.len() * channels));
        }
        let mut push = |number: f64| self.bytes.extend((number as f32).to_le_bytes());
        match (self.content, self.format) {
            (Content::Distances, _) => colors.iter().for_each(|color| push(color.x)),
            (Content::Colors, Format::Exr) => {
                [2, 1, 0].iter().for_each(|&channel| colors.iter().for_each(|color| push(color[channel])));
            }
            (Content::Colors, _) => colors.iter().flat_map(Color::to_array).for_each(push),
        }
    }

    /// Writes the bytes of a row, with BMP's padding.
    fn write_bytes(&mut self) -> Result<(), ImageError> {
        if self.format == Format::Bmp {
            self.bytes.resize(header::bmp_row(self.size[0]), 0);
        }
        let mut write = || match &mut self.png {
            Some(encoder) => encoder.write_all(&self.bytes),
            None => {
                let mut spool = self.spool.lock();
                if matches!(self.format, Format::Bmp | Format::Pfm) {
                    // Their rows are stored from the bottom.
                    let below = self.size[1].saturating_sub(1 + self.rows);
                    spool.seek(SeekFrom::Start((self.header + below * self.bytes.len()) as u64))?;
                }
                spool.write_all(&self.bytes)
            }
        };
        write().map_err(|error| ImageError::io("write", &self.output.path, error))?;
        self.rows += 1;
        Ok(())
    }

    /// Writes the rows so far to a file beside that of the picture: to `o.partial.tga` instead of `o.tga`. Returns the
    /// file, or `None` if there are no rows, if the picture does not go to a regular file whose name tells its format,
    /// or if its format has no parts.
    pub fn write_part(mut self, part: &Part) -> Result<Option<PathBuf>, ImageError> {
        let path_of_part = part_beside(&self.output.path, self.format);
        let Some(path_of_part) = path_of_part.filter(|_| self.rows > 0 && !self.output.is_stream()) else {
            return Ok(None);
        };
        let Self { size: [width, height], rows, format, content, .. } = self;
        if self.png.is_some() {
            // The encoder ends only with all rows.
            let black = vec![0; width * CHANNELS];
            (rows..height).try_for_each(|_| self.row_of_bytes(&black))?;
        }
        let CompleteFile { output: OutputFile { path, .. }, content: spool } = self.complete()?;
        let file = spool.into_file().map_err(|error| ImageError::io("write", &path, error))?;
        let mut from = Rows::new(&path, format, file)?;
        let mut to = OutputFile::prepare(&path_of_part)?.begin(format, [width, rows], content, Some(part))?;
        let mut row = Vec::new();
        for _ in 0..rows {
            from.next(&mut row)?;
            to.row_of_bytes(&row)?;
        }
        to.finish().map(|()| Some(path_of_part))
    }

    /// Writes the picture to its target. If this fails and the target is a regular file, nothing is written.
    pub fn finish(self) -> Result<(), ImageError> {
        self.complete()?.put_in_place()
    }

    /// Returns the file of the picture, which has all of its rows.
    pub fn complete(self) -> Result<CompleteFile, ImageError> {
        let end = || {
            self.png.map_or(Ok(()), |encoder| encoder.finish())?;
            io::Result::Ok(std::mem::replace(&mut *self.spool.lock(), tempfile::spooled_tempfile(0)))
        };
        let content = end().map_err(|error| ImageError::io("write", &self.output.path, error))?;
        Ok(CompleteFile { output: self.output, content })
    }
}

/// Returns the file of the rows that are complete when a run is stopped: `o.partial.tga` beside `o.tga`. `None` if the
/// name does not tell the format, or if that has no parts.
pub fn part_beside(path: &Path, format: Format) -> Option<PathBuf> {
    let has_parts = format.has_parts() && Format::of(path) == Some(format);
    has_parts.then(|| beside(path, "partial"))
}

/// Returns what precedes the rows, but for PNG, or why the format cannot hold the picture.
fn header_of(
    format: Format,
    size @ [width, height]: [usize; 2],
    content: Content,
    part: Option<&Part>,
) -> Result<Vec<u8>, String> {
    let whole = part.map_or(size, |part| part.whole.map(|side| side as usize));
    let has_short_sides = matches!(format, Format::Tga | Format::Pfm | Format::Exr);
    if let (true, [width, height]) = (has_short_sides, whole)
        && width.max(height) > u16::MAX.into()
    {
        return Err(format!("{width} x {height} is above 65535 pixels a side"));
    }
    let is_grey = content == Content::Distances;
    Ok(match format {
        Format::Tga => header::tga(size, part),
        Format::Png => vec![],
        Format::Bmp => header::bmp(size)
            .ok_or_else(|| format!("{width} x {height} pixels are above 4 GB, where a BMP file ends"))?,
        Format::Ppm => format!("P6\n{width} {height}\n255\n").into_bytes(),
        // The negative number says that the lowest byte comes first.
        Format::Pfm => format!("P{}\n{width} {height}\n-1.0\n", if is_grey { 'f' } else { 'F' }).into_bytes(),
        Format::Exr => {
            let at = part.map_or([0; 2], |part| part.at.map(|n| n as usize));
            header::exr(size, whole, at, if is_grey { &["Z"] } else { &["B", "G", "R"] })
        }
    })
}

/// Returns the length of an encoded row in bytes; 0 for PNG, which compresses them.
fn row_length(format: Format, width: usize, content: Content) -> usize {
    let numbers = if content == Content::Distances { width } else { CHANNELS * width };
    match format {
        Format::Tga | Format::Ppm => CHANNELS * width,
        Format::Png => 0,
        Format::Bmp => header::bmp_row(width),
        Format::Pfm => size_of::<f32>() * numbers,
        Format::Exr => header::exr_row(0, 0).len() + size_of::<f32>() * numbers,
    }
}

/// Returns an encoder for three channels of eight bits, with the fastest compression that the crate has.
fn png_encoder(
    spool: Shared,
    size: [usize; 2],
    part: Option<&Part>,
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
    if let Some(Part { at: [x, y], .. }) = part {
        const UNIT_PIXEL: u8 = 0;
        let offsets = [&x.to_be_bytes()[..], &y.to_be_bytes(), &[UNIT_PIXEL]].concat();
        writer.write_chunk(png::chunk::ChunkType(*b"oFFs"), &offsets)?;
    }
    writer.into_stream_writer_with_size(PNG_CHUNK)
}
