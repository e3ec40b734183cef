//! A picture file that is written row by row.

use super::beside;
use super::format::{Content, Format};
use super::output::{CompleteFile, OutputFile};
use super::part::{PNG_COMMENT, Part};
use super::rows::Rows;
use super::written_headers::{bmp_row, exr_row, header};
use crate::base::lock;
use crate::diagnostic::Diagnostic;
use crate::picture::{BLUE_FIRST, CHANNELS, Color, RED_FIRST, truncate_to_bytes};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use tempfile::SpooledTempFile;

/// The length of a PNG file's chunks of compressed rows, in bytes.
const PNG_CHUNK: usize = 1 << 16;

/// The number of pixels whose colours a file does not show, or not as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exceptional {
    /// Pixels that are black in a file of bytes because a channel is not a number.
    pub black: u64,
    /// Pixels that have a NaN in a file of floating-point numbers.
    pub nan: u64,
    /// Pixels with a number that is infinite in a file of floating-point numbers, or a distance that is 0 there,
    /// because single precision ends at about 3.4e38 and 1.4e-45.
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

impl Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        lock(&self.0).write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        lock(&self.0).flush()
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
    ) -> Result<PictureWriter, Diagnostic> {
        let mut spool = Shared(Arc::new(Mutex::new(self.spool())));
        let mut begin = || {
            spool.write_all(&header(format, size, content, part)?)?;
            let encoder = (format == Format::Png).then(|| png_encoder(spool.clone(), size, part));
            Ok::<_, Diagnostic>(encoder.transpose()?.map(Box::new))
        };
        let png = self.written(begin())?;
        let (output, top) = (self, part.map_or(0, |part| part.at[1]));
        let (rows, bytes, exceptional) = (0, vec![], Exceptional::default());
        Ok(PictureWriter { output, format, size, content, top, spool, png, rows, bytes, exceptional })
    }
}

impl PictureWriter {
    /// Adds the next row from the top.
    pub fn row(&mut self, colors: &[Color]) -> Result<(), Diagnostic> {
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
    pub fn row_of_bytes(&mut self, bytes: &[u8]) -> Result<(), Diagnostic> {
        if self.format.is_float() {
            let reason = "a picture of bytes has no floating-point numbers";
            return self.output.written(Err(Diagnostic::error(reason)));
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
            self.bytes.extend(exr_row(self.top + self.rows, colors.len() * channels));
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
    fn write_bytes(&mut self) -> Result<(), Diagnostic> {
        if self.format == Format::Bmp {
            self.bytes.resize(bmp_row(self.size[0]), 0);
        }
        let mut write = || match &mut self.png {
            Some(encoder) => encoder.write_all(&self.bytes),
            None => {
                let mut spool = lock(&self.spool.0);
                if matches!(self.format, Format::Bmp | Format::Pfm) {
                    // Their rows are stored from the bottom: from the end of one, it is two rows to the next.
                    let rows = if self.rows == 0 { self.size[1].saturating_sub(1) as i64 } else { -2 };
                    spool.seek(SeekFrom::Current(rows * self.bytes.len() as i64))?;
                }
                spool.write_all(&self.bytes)
            }
        };
        self.output.written(write())?;
        self.rows += 1;
        Ok(())
    }

    /// Writes the rows so far to a file beside the picture's: to `o.partial.tga` instead of `o.tga`. Returns the
    /// file, or `None` if there are no rows, if the picture does not go to a regular file whose name tells its format,
    /// or if its format has no parts.
    pub fn write_part(mut self, part: &Part) -> Result<Option<PathBuf>, Diagnostic> {
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
        let CompleteFile { output, content: spool } = self.complete()?;
        let mut from = Rows::new(&output.path, format, output.written(spool.into_file())?)?;
        let mut to = OutputFile::prepare(&path_of_part)?.begin(format, [width, rows], content, Some(part))?;
        to.copy(&mut from, rows)?;
        to.complete()?.put_in_place().map(|()| Some(path_of_part))
    }

    /// Returns true if all rows were taken.
    pub fn has_all_rows(&self) -> bool {
        self.rows == self.size[1]
    }

    /// Takes this number of rows from a file.
    fn copy(&mut self, from: &mut Rows, rows: usize) -> Result<(), Diagnostic> {
        let mut row = vec![];
        (0..rows).try_for_each(|_| {
            from.next(&mut row)?;
            self.row_of_bytes(&row)
        })
    }

    /// Returns the file of the picture, which has all of its rows.
    pub fn complete(self) -> Result<CompleteFile, Diagnostic> {
        self.output.written(self.png.map_or(Ok(()), |encoder| encoder.finish()))?;
        let content = std::mem::replace(&mut *lock(&self.spool.0), tempfile::spooled_tempfile(0));
        Ok(CompleteFile { output: self.output, content })
    }
}

/// Returns a file with the picture of these rows, none of which has been read.
pub fn convert(mut rows: Rows, file: OutputFile, format: Format) -> Result<CompleteFile, Diagnostic> {
    let mut writer = file.begin(format, rows.size, Content::Colors, None)?;
    writer.copy(&mut rows, writer.size[1])?;
    writer.complete()
}

/// Returns the file of the rows that are complete when a run is stopped: `o.partial.tga` beside `o.tga`. `None` if the
/// name does not tell the format, or if that has no parts.
pub fn part_beside(path: &Path, format: Format) -> Option<PathBuf> {
    let has_parts = format.has_parts() && Format::of(path) == Some(format);
    has_parts.then(|| beside(path, "partial"))
}

/// Returns an encoder for three channels of eight bits, with the fastest compression that the crate has.
fn png_encoder(
    spool: Shared,
    size: [usize; 2],
    part: Option<&Part>,
) -> Result<png::StreamWriter<'static, Shared>, png::EncodingError> {
    let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
    let mut encoder = png::Encoder::new(spool, number(size[0]), number(size[1]));
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Adaptive);
    if let Some(part) = part {
        encoder.add_text_chunk(PNG_COMMENT.into(), part.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    if let Some(part) = part {
        const UNIT_PIXEL: u8 = 0;
        let [x, y] = part.at.map(|n| number(n).to_be_bytes());
        let offsets = [&x[..], &y, &[UNIT_PIXEL]].concat();
        writer.write_chunk(png::chunk::ChunkType(*b"oFFs"), &offsets)?;
    }
    writer.into_stream_writer_with_size(PNG_CHUNK)
}
