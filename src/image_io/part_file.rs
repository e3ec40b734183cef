//! Reading of parts row by row, so that a picture of any size needs the memory of a row.

use super::Format;
use super::error::ImageError;
use super::part::Part;
use super::writer::{PNG_COMMENT, TGA_HEADER};
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
}

/// What rows are read from.
pub(super) trait Source: BufRead + Seek + Send {}
impl<T: BufRead + Seek + Send> Source for T {}

/// The rows of a picture, from the top.
pub struct Rows {
    /// For messages.
    path: PathBuf,
    size: [u32; 2],
    decoder: Decoder,
}

enum Decoder {
    /// The rows follow the header uncompressed, with blue first.
    Tga(Box<dyn Source>),
    Png(Box<png::Reader<Box<dyn Source>>>),
}

impl PartFile {
    /// Reads what a file says about itself. A picture that is no part of another is an error, and so is one that is
    /// encoded otherwise than by this program.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
        let no_part = || ImageError::NoPart { path: path.to_owned() };
        let (rows, text) = Rows::read(path, format, source(path)?)?;
        let part: Part = text.and_then(|text| text.parse().ok()).ok_or_else(no_part)?;
        let fits = |axis: usize| {
            let end = part.at[axis].checked_add(rows.size[axis]);
            rows.size[axis] > 0 && end.is_some_and(|end| end <= part.whole[axis])
        };
        match fits(0) && fits(1) {
            true => Ok(Self { path: path.to_owned(), part, format, size: rows.size }),
            false => Err(no_part()),
        }
    }

    /// The part's place in the whole.
    pub fn window(&self) -> Window {
        let [[x, y], [width, height]] = [self.part.at, self.size].map(|pair| pair.map(|n| n as usize));
        Window { x, y, width, height }
    }

    /// The rows of the part.
    pub fn rows(&self) -> Result<Rows, ImageError> {
        Rows::read(&self.path, self.format, source(&self.path)?).map(|(rows, _)| rows)
    }
}

/// The content of a regular file. A pipe could block the program.
fn source(path: &Path) -> Result<Box<dyn Source>, ImageError> {
    let failed = |error| ImageError::io("read", path, error);
    match fs::metadata(path).map_err(failed)?.is_file() {
        true => Ok(Box::new(BufReader::with_capacity(1 << 18, File::open(path).map_err(failed)?))),
        false => Err(ImageError::NotAFile { path: path.to_owned() }),
    }
}

impl Rows {
    /// The rows of a file's content, and the comment that stands before them.
    pub(super) fn read(
        path: &Path,
        format: Format,
        source: Box<dyn Source>,
    ) -> Result<(Self, Option<String>), ImageError> {
        let path = path.to_owned();
        let read = match format {
            Format::Tga => tga(source),
            Format::Png => png(source),
            Format::Pfm | Format::Exr => Ok(None),
        };
        match read {
            Ok(Some((size, comment, decoder))) => Ok((Self { path, size, decoder }, comment)),
            Ok(None) => Err(ImageError::OtherEncoding { path }),
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Err(ImageError::NoHeader { path }),
            Err(error) => Err(ImageError::io("read", &path, error)),
        }
    }

    /// Reads the next row as bytes of red, green and blue.
    pub fn next(&mut self, rgb: &mut Vec<u8>) -> Result<(), ImageError> {
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
            io::ErrorKind::UnexpectedEof => ImageError::Short { path: self.path.clone(), width, height },
            _ => ImageError::io("read", &self.path, error),
        })
    }
}

/// The size of a picture, its comment and its rows.
type Start = ([u32; 2], Option<String>, Decoder);

/// None if the file is not encoded as this program does.
fn tga(mut source: Box<dyn Source>) -> io::Result<Option<Start>> {
    let mut header = [0; TGA_HEADER];
    source.read_exact(&mut header)?;
    let mut id = vec![0; header[0].into()];
    source.read_exact(&mut id)?;
    let [_, 0, 2, 0, 0, 0, 0, 0, _, _, _, _, w0, w1, h0, h1, 24, 32] = header else { return Ok(None) };
    let size = [[w0, w1], [h0, h1]].map(|side| u32::from(u16::from_le_bytes(side)));
    Ok(Some((size, String::from_utf8(id).ok(), Decoder::Tga(source))))
}

/// None if the file is not encoded as this program does.
fn png(source: Box<dyn Source>) -> io::Result<Option<Start>> {
    let reader = png::Decoder::new(source).read_info()?;
    let info = reader.info();
    let comment = info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == PNG_COMMENT);
    let comment = comment.map(|chunk| chunk.text.clone());
    let is_own =
        !info.interlaced && (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let size = [info.width, info.height];
    Ok(is_own.then(|| (size, comment, Decoder::Png(Box::new(reader)))))
}
