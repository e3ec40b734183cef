//! Reading of parts row by row, so that a picture of any size needs the memory of a row.

use super::Format;
use super::checksum::{CheckedPart, PartHasher, Unchecked};
use super::error::ImageError;
use super::part::Part;
use super::signature::identify;
use super::writer::{PNG_COMMENT, TGA_HEADER, tga_header};
use crate::picture::CHANNELS;
use crate::render::Window;
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// The file of a part, encoded as this program does.
#[derive(Clone, Debug)]
pub struct PartFile {
    /// The file, as it was named.
    pub path: PathBuf,
    /// What it says about the whole.
    pub part: Part,
    format: Format,
    /// Width and height of the part in pixels.
    size: [u32; 2],
    checksum: u64,
}

/// What rows are read from.
pub(super) trait RowSource: BufRead + Seek + Send {}
impl<T: BufRead + Seek + Send> RowSource for T {}

/// The rows of a picture, from the top.
pub struct Rows {
    /// For messages.
    path: PathBuf,
    size: [u32; 2],
    decoder: Decoder,
    /// How many rows are left.
    left: u32,
    /// For a part, the checksum so far, and what it is in the end.
    checksum: Option<(PartHasher, u64)>,
}

enum Decoder {
    /// The rows follow the header uncompressed, with blue first.
    Tga(Box<dyn RowSource>),
    Png(Box<png::Reader<Box<dyn RowSource>>>),
}

impl PartFile {
    /// Reads what a file says about itself. A picture that is no part of another is an error, and so is one that is
    /// encoded otherwise than by this program.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let no_part = || ImageError::NoPart { path: path.to_owned() };
        let mut source = source(path)?;
        let (format, _) = identify(path, &mut *source)?;
        let (rows, start) = Rows::read(path, format, source)?;
        let whole = || ImageError::Whole { path: path.to_owned(), size: rows.size };
        let text = start.comment.filter(|text| !text.is_empty()).ok_or_else(whole)?;
        let checked = text.parse().map_err(|reason| match reason {
            Unchecked::NotPart => no_part(),
            Unchecked::NoChecksum => ImageError::NoChecksum { path: path.to_owned() },
        })?;
        let header = tga_header(rows.size.map(|n| n as usize), Some(&checked));
        if format == Format::Tga && header != Some(start.header) {
            return Err(ImageError::Damaged { path: path.to_owned() });
        }
        let CheckedPart { part, checksum } = checked;
        let fits = |axis: usize| {
            let end = part.at[axis].checked_add(rows.size[axis]);
            rows.size[axis] > 0 && end.is_some_and(|end| end <= part.whole[axis])
        };
        match fits(0) && fits(1) {
            true => Ok(Self { path: path.to_owned(), part, format, size: rows.size, checksum }),
            false => Err(no_part()),
        }
    }

    /// The part's place in the whole.
    pub fn window(&self) -> Window {
        let [[x, y], [width, height]] = [self.part.at, self.size].map(|pair| pair.map(|n| n as usize));
        Window { x, y, width, height }
    }

    /// Reads all rows. An error if they do not have the part's checksum.
    pub fn check(&self) -> Result<(), ImageError> {
        self.rows()?.check_rest()
    }

    /// The rows of the part. The last one is an error if they do not have the part's checksum.
    pub fn rows(&self) -> Result<Rows, ImageError> {
        let (rows, _) = Rows::read(&self.path, self.format, source(&self.path)?)?;
        Ok(Rows { checksum: Some((PartHasher::new(&self.part, self.size), self.checksum)), ..rows })
    }
}

/// The content of a regular file. A pipe could block the program.
pub(super) fn source(path: &Path) -> Result<Box<dyn RowSource>, ImageError> {
    let failed = |error| ImageError::io("read", path, error);
    match fs::metadata(path).map_err(failed)?.is_file() {
        true => Ok(Box::new(BufReader::with_capacity(1 << 18, File::open(path).map_err(failed)?))),
        false => Err(ImageError::unreadable(path, "it is not a regular file")),
    }
}

impl Rows {
    /// The rows of a file's content, and what stands before them.
    pub(super) fn read(
        path: &Path,
        format: Format,
        source: Box<dyn RowSource>,
    ) -> Result<(Self, Start), ImageError> {
        let path = path.to_owned();
        let read = match format {
            Format::Tga => tga(source),
            Format::Png => png(source),
            Format::Bmp | Format::Ppm | Format::Pfm | Format::Exr => Ok(None),
        };
        match read {
            Ok(Some((size, decoder, start))) => {
                Ok((Self { path, size, decoder, left: size[1], checksum: None }, start))
            }
            Ok(None) => Err(ImageError::OtherEncoding { path }),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                Err(ImageError::unreadable(&path, "it ends within its header"))
            }
            Err(error) => Err(ImageError::io("read", &path, error)),
        }
    }

    /// Reads the next row as bytes of red, green and blue.
    pub fn next(&mut self, rgb: &mut Vec<u8>) -> Result<(), ImageError> {
        self.read_row(rgb)?;
        self.left = self.left.saturating_sub(1);
        let Some((hasher, expected)) = &mut self.checksum else { return Ok(()) };
        hasher.row(rgb);
        match self.left > 0 || hasher.finish() == *expected && self.decoder.is_at_end() {
            true => Ok(()),
            false => Err(ImageError::Damaged { path: self.path.clone() }),
        }
    }

    /// Reads the rows that are left, for their checksum.
    pub fn check_rest(&mut self) -> Result<(), ImageError> {
        let mut row = Vec::new();
        (0..self.left).try_for_each(|_| self.next(&mut row))
    }

    fn read_row(&mut self, rgb: &mut Vec<u8>) -> Result<(), ImageError> {
        let [width, height] = self.size;
        rgb.resize(width as usize * CHANNELS, 0);
        let read = match &mut self.decoder {
            Decoder::Tga(source) => source.read_exact(rgb),
            Decoder::Png(reader) => match reader.read_row(rgb) {
                Ok(Some(_)) => Ok(()),
                Ok(None) => Err(io::ErrorKind::UnexpectedEof.into()),
                Err(error) => Err(error.into()),
            },
        };
        if let Decoder::Tga(_) = self.decoder {
            rgb.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
        }
        read.map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                ImageError::unreadable(&self.path, format!("it is too short for {width} x {height} pixels"))
            }
            _ => ImageError::io("read", &self.path, error),
        })
    }
}

impl Decoder {
    /// Whether nothing follows the last row, which has been read, but what belongs to the format.
    fn is_at_end(&mut self) -> bool {
        match self {
            Self::Tga(source) => source.fill_buf().is_ok_and(|rest| rest.is_empty()),
            Self::Png(reader) => reader.finish().is_ok(),
        }
    }
}

/// What stands before the rows.
pub(super) struct Start {
    comment: Option<String>,
    /// The bytes of a TGA file; nothing of another, which has checksums of its own.
    header: Vec<u8>,
}

/// The size of a picture and its rows.
type Found = ([u32; 2], Decoder, Start);

/// None if the file is not encoded as this program does.
fn tga(mut source: Box<dyn RowSource>) -> io::Result<Option<Found>> {
    let mut header = [0; TGA_HEADER];
    source.read_exact(&mut header)?;
    let mut id = vec![0; header[0].into()];
    source.read_exact(&mut id)?;
    let start = Start { header: [&header, id.as_slice()].concat(), comment: String::from_utf8(id).ok() };
    let [_, 0, 2, 0, 0, 0, 0, 0, _, _, _, _, w0, w1, h0, h1, 24, 32] = header else { return Ok(None) };
    let size = [[w0, w1], [h0, h1]].map(|side| u32::from(u16::from_le_bytes(side)));
    Ok(Some((size, Decoder::Tga(source), start)))
}

/// None if the file is not encoded as this program does.
fn png(source: Box<dyn RowSource>) -> io::Result<Option<Found>> {
    let mut options = png::DecodeOptions::default();
    options.set_skip_ancillary_crc_failures(false);
    let reader = png::Decoder::new_with_options(source, options).read_info()?;
    let info = reader.info();
    let comment = info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == PNG_COMMENT);
    let comment = comment.map(|chunk| chunk.text.clone());
    let is_own =
        !info.interlaced && (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let size = [info.width, info.height];
    let start = Start { comment, header: vec![] };
    Ok(is_own.then(|| (size, Decoder::Png(Box::new(reader)), start)))
}
