//! Parts of pictures: files that say where in a whole picture they lie, and reading their rows one by one.
//!
//! A TGA file says it in its image ID, which follows the header and which viewers show as a comment; a PNG file in a text
//! chunk called `Comment`. The place stands there too, beside TGA's fields for the origin and PNG's chunk `oFFs`, which
//! other programs read.

use super::Format;
use super::error::ImageError;
use super::format::{START, identify};
use super::header::{self, TGA_HEADER};
use super::reader::open_regular;
use crate::picture::{CHANNELS, Window};
use std::fmt;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// The keyword of the text in a PNG file that says which part of a larger picture it is.
pub(super) const PNG_COMMENT: &str = "Comment";

/// The place of a picture in a whole one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Width and height of the whole picture in pixels.
    pub whole: [u32; 2],
    /// The part's top left pixel: its column and row in the whole, from the top left.
    pub at: [u32; 2],
    /// What the picture shows, in one word.
    pub kind: String,
    /// A hash of everything that the bytes of the whole picture depend on.
    pub fingerprint: u128,
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { whole: [width, height], at: [x, y], kind, fingerprint } = self;
        write!(f, "part of {width} x {height} at {x}, {y}; {kind}; fingerprint {fingerprint:032x}")
    }
}

/// A text that is not that of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotPart;

impl FromStr for Part {
    type Err = NotPart;

    fn from_str(text: &str) -> Result<Self, NotPart> {
        let parse = || {
            let pair = |text: &str, separator| {
                let (a, b) = text.split_once(separator)?;
                Some([a.parse().ok()?, b.parse().ok()?])
            };
            let (whole, rest) = text.strip_prefix("part of ")?.split_once(" at ")?;
            let (at, rest) = rest.split_once("; ")?;
            let (kind, fingerprint) = rest.split_once("; fingerprint ")?;
            let fingerprint = u128::from_str_radix(fingerprint, 16).ok()?;
            let part =
                Self { whole: pair(whole, " x ")?, at: pair(at, ", ")?, kind: kind.into(), fingerprint };
            // Numbers can be written in other ways too.
            (part.to_string() == text).then_some(part)
        };
        parse().ok_or(NotPart)
    }
}

/// The file of a part, encoded as this program does.
#[derive(Clone, Debug)]
pub struct PartFile {
    /// The path as the user gave it.
    pub path: PathBuf,
    /// What the file says about itself.
    pub part: Part,
    /// The part's place in the whole.
    pub window: Window,
}

impl PartFile {
    /// Reads what a file says about itself. An error if it is no part, or not encoded as this program does.
    pub fn open(path: &Path) -> Result<Self, ImageError> {
        let (rows, text) = Rows::open(path)?;
        let [width, height] = rows.size;
        let bad = |reason: &str| ImageError::file("merge", path, reason);
        let text = text.filter(|text| !text.is_empty()).ok_or_else(|| {
            bad(&format!(
                "it is a whole picture of {width} x {height} pixels, and no part as `-region` makes it"
            ))
        })?;
        let part: Part =
            text.parse().map_err(|_| bad("it is no part of a picture, as `-region` makes it"))?;
        let fits = |axis: usize| {
            let end = part.at[axis].checked_add(rows.size[axis]);
            rows.size[axis] > 0 && end.is_some_and(|end| end <= part.whole[axis])
        };
        if !(fits(0) && fits(1)) {
            return Err(bad("it says that it lies outside of its picture"));
        }
        if rows
            .tga_header()
            .is_some_and(|found| found != header::tga(rows.size.map(|n| n as usize), Some(&part)))
        {
            return Err(bad("its header is not as `-region` makes it"));
        }
        let [x, y, width, height] = [part.at[0], part.at[1], width, height].map(|n| n as usize);
        Ok(Self { path: path.to_owned(), part, window: Window { x, y, width, height } })
    }

    /// Opens the part to read its rows.
    pub(super) fn rows(&self) -> Result<Rows, ImageError> {
        Rows::open(&self.path).map(|(rows, _)| rows)
    }
}

/// The rows of a TGA or PNG file as this program writes it, from the top. They take the memory of a row.
pub(super) struct Rows {
    path: PathBuf,
    /// Width and height in pixels.
    size: [u32; 2],
    decoder: Decoder,
}

enum Decoder {
    /// The header with the image ID, after which the rows follow uncompressed, with blue first.
    Tga(Vec<u8>, BufReader<File>),
    Png(Box<png::Reader<BufReader<File>>>),
}

impl Rows {
    /// Opens a complete file, and reads its comment.
    fn open(path: &Path) -> Result<(Self, Option<String>), ImageError> {
        let failed = |error| ImageError::io("read", path, error);
        let (mut file, mut start) = (open_regular(path)?, vec![]);
        let length = file.metadata().map_err(failed)?.len();
        file.by_ref().take(START as u64).read_to_end(&mut start).map_err(failed)?;
        let (rows, comment) = Self::new(path, identify(path, &start)?, file)?;
        if let Decoder::Tga(header, _) = &rows.decoder {
            let [width, height] = rows.size.map(u64::from);
            let expected = header.len() as u64 + width * height * CHANNELS as u64;
            if length != expected {
                let reason =
                    format!("it has {length} bytes instead of {expected} for {width} x {height} pixels");
                return Err(ImageError::file("read", path, reason));
            }
        }
        Ok((rows, comment))
    }

    /// Reads what precedes the rows of a file, which need not have all rows.
    pub fn new(path: &Path, format: Format, mut file: File) -> Result<(Self, Option<String>), ImageError> {
        let read = file.rewind().and_then(|()| match format {
            Format::Tga => tga(BufReader::new(file)),
            Format::Png => png(BufReader::new(file)),
            Format::Bmp | Format::Ppm | Format::Pfm | Format::Exr => Ok(None),
        });
        match read {
            Ok(Some((size, decoder, comment))) => {
                Ok((Self { path: path.to_owned(), size, decoder }, comment))
            }
            Ok(None) => {
                Err(ImageError::file("merge", path, "it is no part of a picture as this program encodes it"))
            }
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                Err(ImageError::file("read", path, "it ends within its header"))
            }
            Err(error) => Err(ImageError::io("read", path, error)),
        }
    }

    fn tga_header(&self) -> Option<&[u8]> {
        match &self.decoder {
            Decoder::Tga(header, _) => Some(header),
            Decoder::Png(_) => None,
        }
    }

    /// Reads the next row as bytes of red, green and blue.
    pub fn next(&mut self, rgb: &mut Vec<u8>) -> Result<(), ImageError> {
        rgb.resize(self.size[0] as usize * CHANNELS, 0);
        let read = match &mut self.decoder {
            Decoder::Tga(_, source) => source.read_exact(rgb),
            Decoder::Png(reader) => match reader.read_row(rgb) {
                Ok(Some(_)) => Ok(()),
                Ok(None) => Err(io::ErrorKind::UnexpectedEof.into()),
                Err(error) => Err(error.into()),
            },
        };
        if let Decoder::Tga(..) = self.decoder {
            rgb.chunks_exact_mut(CHANNELS).for_each(|pixel| pixel.swap(0, 2));
        }
        read.map_err(|error| ImageError::io("read", &self.path, error))
    }

    /// Checks what follows the last row, which has been read: a PNG file ends with checksums.
    pub fn finish(&mut self) -> Result<(), ImageError> {
        match &mut self.decoder {
            Decoder::Tga(..) => Ok(()),
            Decoder::Png(reader) => {
                reader.finish().map_err(|error| ImageError::io("read", &self.path, error))
            }
        }
    }
}

/// The size of a picture, its rows, and its comment.
type Found = ([u32; 2], Decoder, Option<String>);

/// Returns `None` if the file is not encoded as this program does.
fn tga(mut source: BufReader<File>) -> io::Result<Option<Found>> {
    let mut header = vec![0; TGA_HEADER];
    source.read_exact(&mut header)?;
    let mut id = vec![0; header[0].into()];
    source.read_exact(&mut id)?;
    let &[_, 0, 2, 0, 0, 0, 0, 0, _, _, _, _, w0, w1, h0, h1, 24, 32] = header.as_slice() else {
        return Ok(None);
    };
    let size = [[w0, w1], [h0, h1]].map(|side| u32::from(u16::from_le_bytes(side)));
    header.extend(&id);
    Ok(Some((size, Decoder::Tga(header, source), String::from_utf8(id).ok())))
}

/// Returns `None` if the file is not encoded as this program does.
fn png(source: BufReader<File>) -> io::Result<Option<Found>> {
    let mut options = png::DecodeOptions::default();
    options.set_skip_ancillary_crc_failures(false);
    let reader = png::Decoder::new_with_options(source, options).read_info()?;
    let info = reader.info();
    let comment = info.uncompressed_latin1_text.iter().find(|chunk| chunk.keyword == PNG_COMMENT);
    let comment = comment.map(|chunk| chunk.text.clone());
    let is_own =
        !info.interlaced && (info.color_type, info.bit_depth) == (png::ColorType::Rgb, png::BitDepth::Eight);
    let size = [info.width, info.height];
    Ok(is_own.then(|| (size, Decoder::Png(Box::new(reader)), comment)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_of_a_part_is_read_back_and_any_other_refused() {
        let part = Part { whole: [65535, 7], at: [0, 65534], kind: "color".into(), fingerprint: 0xabc };
        let text = "part of 65535 x 7 at 0, 65534; color; fingerprint 00000000000000000000000000000abc";
        assert_eq!((part.to_string().as_str(), text.parse()), (text, Ok(part)));
        for text in [
            "",
            "made by hand",
            &text[1..],
            &text[..text.len() - 32],
            &text.replace("65535", "-1"),
            &text.replace("65535", "+65535"),
            &text.to_uppercase(),
            &format!("{text} "),
        ] {
            assert_eq!(text.parse::<Part>(), Err(NotPart), "{text}");
        }
    }
}
