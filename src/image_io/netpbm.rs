//! Reading of PBM, PGM, PPM and PAM files, plain or raw, and of PFM files.
//!
//! Each is a header of words, then samples. The formats are described in <https://netpbm.sourceforge.net/doc/> and
//! <https://www.pauldebevec.com/Research/HDR/PFM/>. The samples of a raw file follow one white space and fill the rest
//! of the file. If the rest is longer, its pixels may be shifted, and the file is refused unless line feeds written as
//! CR LF explain every byte.

use super::error::ImageError;
use super::format::BYTE_ORDER_MARK;
use super::reader::{Reader, Remarks, fill_row, level};
use crate::escape::quoted;
use crate::picture::Picture;
use crate::scene::Color;
use std::borrow::Cow;

/// Upper bound on the bytes of a word that are shown.
const SHOWN: usize = 40;
/// The largest sample that the formats allow for white.
const LARGEST_WHITE: u32 = 65535;
/// The hint for a word that is no number.
const OTHER_TEXT: &str = "; messages belong to the standard error, as `std::cerr`";

/// What the header says.
#[derive(Default)]
struct Header {
    size: [u32; 2],
    /// Numbers for each pixel: grey, grey and alpha, RGB, or RGB and alpha.
    channels: usize,
    /// Bits of a raw sample: 1, 8, 16 or, in single precision, 32.
    bits: usize,
    /// The byte for each sample. Empty in single precision.
    levels: Vec<u8>,
    is_little_endian: bool,
}

impl Header {
    fn set_white(&mut self, white: u32) {
        self.levels = (0..=white).map(|sample| level(sample, white)).collect();
        self.bits = if white > 255 { 16 } else { 8 };
    }

    /// Sets a pixel from its samples. Returns false if one of them is above that of white.
    fn set(&self, pixel: &mut [u8; 3], sample: impl Fn(usize) -> usize) -> bool {
        let has_color = usize::from(self.channels > 2);
        let levels = [0, 1, 2].map(|channel| self.levels.get(sample(channel * has_color)).copied());
        *pixel = levels.map(Option::unwrap_or_default);
        levels.iter().all(Option::is_some)
    }
}

/// Reads a picture from the start of a file.
pub(super) fn read(mut reader: Reader) -> Result<(Picture, Remarks), ImageError> {
    reader.bytes = reader.bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(reader.bytes);
    let mut text = Text { start: reader.bytes, reader, size: None };
    let (channels, bits, is_plain) = match text.header_word()? {
        b"P1" => (1, 1, true),
        b"P2" => (1, 8, true),
        b"P3" => (3, 8, true),
        b"P4" => (1, 1, false),
        b"P5" => (1, 8, false),
        b"P6" => (3, 8, false),
        b"PF" => (3, 32, false),
        b"Pf" => (1, 32, false),
        _ => (0, 8, false),
    };
    let header = if channels > 0 { text.header(channels, bits)? } else { text.pam_header()? };
    text.size = Some(header.size);
    if is_plain { Ok((text.plain(&header)?, Remarks::default())) } else { text.raw(&header) }
}

/// A file, of which the header or all is text.
struct Text<'a> {
    /// The whole file.
    start: &'a [u8],
    /// The rest.
    reader: Reader<'a>,
    /// Width and height, once the header has been read.
    size: Option<[u32; 2]>,
}

impl<'a> Text<'a> {
    /// Reads the size, and the sample of white or the scale, whose sign is the order of bytes.
    fn header(&mut self, channels: usize, bits: usize) -> Result<Header, ImageError> {
        let size = [self.number(0, u32::MAX)?, self.number(0, u32::MAX)?];
        let mut header = Header { size, channels, bits, ..Header::default() };
        match bits {
            1 => header.levels = vec![255, 0],
            32 => {
                let word = self.header_word()?;
                let scale = parse::<f64>(word).filter(|scale| scale.is_finite() && *scale != 0.0);
                let scale = scale.ok_or_else(|| self.bad_word(word, "is no scale, a number other than 0"))?;
                header.is_little_endian = scale < 0.0;
            }
            _ => header.set_white(self.number(1, LARGEST_WHITE)?),
        }
        Ok(header)
    }

    fn pam_header(&mut self) -> Result<Header, ImageError> {
        let mut header = Header::default();
        loop {
            match self.header_word()? {
                b"WIDTH" => header.size[0] = self.number(0, u32::MAX)?,
                b"HEIGHT" => header.size[1] = self.number(0, u32::MAX)?,
                b"DEPTH" => header.channels = self.number(1, 4)? as usize,
                b"MAXVAL" => header.set_white(self.number(1, LARGEST_WHITE)?),
                b"TUPLTYPE" => drop(self.header_word()?),
                b"ENDHDR" if header.channels > 0 && header.bits > 0 => return Ok(header),
                word => return Err(self.bad_word(word, "is unknown, or comes before DEPTH or MAXVAL")),
            }
        }
    }

    /// Reads the samples of a plain picture, after which the file has no more words.
    fn plain(&mut self, header: &Header) -> Result<Picture, ImageError> {
        let [width, height] = header.size;
        let mut picture = self.reader.black(header.size, self.start.len() as u64)?;
        for pixel in picture.pixels_mut().as_chunks_mut().0 {
            let mut samples = [0; 3];
            for sample in &mut samples[..header.channels] {
                *sample = match header.bits {
                    1 => self.digit()?,
                    _ => self.number(0, header.levels.len() as u32 - 1)? as usize,
                };
            }
            header.set(pixel, |channel| samples[channel]);
        }
        let Some(word) = self.word() else { return Ok(picture) };
        let hint = if parse::<f64>(word).is_some() { "" } else { OTHER_TEXT };
        Err(self.bad_word(word, &format!("follows the last of {width} x {height} pixels{hint}")))
    }

    fn raw(mut self, header: &Header) -> Result<(Picture, Remarks), ImageError> {
        let ([width, height], channels) = (header.size, header.channels);
        let row_bytes = (u64::from(width) * channels as u64 * header.bits as u64).div_ceil(8);
        let needed = row_bytes.saturating_mul(height.into());
        let is_long_enough = self.reader.bytes.len() as u64 >= needed;
        let mut picture = self.reader.black(header.size, if is_long_enough { u64::MAX } else { 0 })?;
        let (samples, has_line_end) = self.samples(needed as usize)?;
        let mut remarks = Remarks { clamped: 0, has_line_end };
        // Without this the most common files would take three times as long.
        if (channels, header.levels.len()) == (3, 256) {
            picture.pixels_mut().copy_from_slice(&samples);
            return Ok((picture, remarks));
        }
        for (bytes, y) in samples.chunks_exact(row_bytes as usize).zip(0..height as usize) {
            if header.bits == 32 {
                let number = |&bytes: &[u8; 4]| match header.is_little_endian {
                    true => f64::from(f32::from_le_bytes(bytes)),
                    false => f64::from(f32::from_be_bytes(bytes)),
                };
                let pixel = |pixel: &[[u8; 4]]| {
                    [0, channels / 2, channels - 1].map(|channel| number(&pixel[channel]))
                };
                let pixels = bytes.as_chunks().0.chunks_exact(channels);
                let colors: Vec<Color> = pixels.map(|numbers| pixel(numbers).into()).collect();
                // Rows are stored from the bottom.
                remarks.clamped += fill_row(&colors, picture.row_mut(y));
                continue;
            }
            let sample = |at: usize| match header.bits {
                1 => usize::from(bytes[at / 8] >> (7 - at % 8) & 1),
                8 => bytes[at].into(),
                _ => u16::from_be_bytes([bytes[2 * at], bytes[2 * at + 1]]).into(),
            };
            let row = picture.row_mut(height as usize - 1 - y);
            let mut pixels = row.as_chunks_mut().0.iter_mut().enumerate();
            if !pixels.all(|(x, pixel)| header.set(pixel, |channel| sample(x * channels + channel))) {
                let white = header.levels.len() - 1;
                return Err(self.reader.bad(format!("row {} has a sample above {white}, its white", y + 1)));
            }
        }
        Ok((picture, remarks))
    }

    /// Returns the samples, which take `needed` bytes, and whether a line end follows them.
    fn samples(&mut self, needed: usize) -> Result<(Cow<'a, [u8]>, bool), ImageError> {
        let (rest, [width, height]) = (self.reader.bytes, self.size.unwrap_or_default());
        let head = &self.start[..self.start.len() - rest.len()];
        let surplus = rest.len() - needed;
        // White space before the samples could be surplus just as well.
        let is_next_white = rest.first().is_some_and(u8::is_ascii_whitespace);
        let (in_crlf, all_in_crlf) = match rest.strip_prefix(b"\n").filter(|_| head.ends_with(b"\r")) {
            Some(_) => line_ends(&self.start[..=head.len()]),
            None => (false, false),
        };
        match surplus {
            // All lines of the header end in CR LF. So does the last, and a byte is missing.
            0 if all_in_crlf && head.contains(&b'\n') => Err(self.reader.short([width, height])),
            0 => Ok((rest.into(), false)),
            1 if in_crlf => Ok((rest[1..].into(), false)),
            1 | 2 if !is_next_white && matches!(&rest[needed..], b"\n" | b"\r\n") => {
                Ok((rest[..needed].into(), true))
            }
            _ => {
                let samples = all_in_crlf.then(|| without_cr(&rest[1..])).flatten();
                let samples = samples.filter(|samples| samples.len() == needed);
                samples.map(|samples| (samples.into(), false)).ok_or_else(|| {
                    let bytes = if surplus == 1 { "byte" } else { "bytes" };
                    self.reader.bad(format!(
                        "it is {surplus} {bytes} too long for {width} x {height} pixels, so that they may be \
                         shifted; write it in binary mode, one picture in a file"
                    ))
                })
            }
        }
    }

    /// Reads a digit of a bitmap.
    fn digit(&mut self) -> Result<usize, ImageError> {
        self.skip_space();
        match self.reader.take(1) {
            Some([digit @ (b'0' | b'1')]) => Ok(usize::from(digit - b'0')),
            Some(other) => Err(self.bad_word(other, "is neither 0 nor 1")),
            None => Err(self.cut()),
        }
    }

    /// Reads a whole number within these bounds.
    fn number(&mut self, least: u32, most: u32) -> Result<u32, ImageError> {
        let word = self.header_word()?;
        if let Some(number) = parse(word).filter(|number| (least..=most).contains(number)) {
            return Ok(number);
        }
        let hint = match word {
            _ if self.size.is_none() => "",
            [b'-', ..] => "; a negative colour or NaN as an int gives it: clamp colours first",
            word if word.iter().all(u8::is_ascii_digit) => "; clamp colours first",
            word if parse::<f64>(word).is_some() => "; colours are whole numbers here, up to that of white",
            _ => OTHER_TEXT,
        };
        Err(self.bad_word(word, &format!("is not a whole number from {least} to {most}{hint}")))
    }

    fn header_word(&mut self) -> Result<&'a [u8], ImageError> {
        self.word().ok_or_else(|| self.cut())
    }

    /// Reads the next word, outside comments, and the white space or the comment that ends it. `None` at the end of the
    /// file.
    fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let is_end = |byte: &u8| *byte == b'#' || byte.is_ascii_whitespace();
        let bytes = self.reader.bytes;
        let word = self.reader.take(bytes.iter().position(is_end).unwrap_or(bytes.len()))?;
        self.skip_one();
        Some(word).filter(|word| !word.is_empty())
    }

    /// Skips white space and comments.
    fn skip_space(&mut self) {
        while self.skip_one() {}
    }

    /// Skips a white space or a comment, with the byte that ends its line. Returns false if there is none.
    fn skip_one(&mut self) -> bool {
        let bytes = self.reader.bytes;
        let length = match bytes.first() {
            Some(b'#') => {
                bytes.iter().position(|byte| matches!(byte, b'\r' | b'\n')).map_or(bytes.len(), |end| end + 1)
            }
            Some(byte) if byte.is_ascii_whitespace() => 1,
            _ => 0,
        };
        self.reader.take(length).is_some_and(|skipped| !skipped.is_empty())
    }

    /// Returns the error of a file that ends too early.
    fn cut(&self) -> ImageError {
        match self.size {
            Some(size) => self.reader.short(size),
            None => self.reader.bad("it ends within its header"),
        }
    }

    /// Returns the error of a word, which has just been read.
    fn bad_word(&self, word: &[u8], problem: &str) -> ImageError {
        let read = &self.start[..self.start.len() - self.reader.bytes.len()];
        let read = read.strip_suffix(b"\n").or(read.strip_suffix(b"\r")).unwrap_or(read);
        let is_end = |pair: &&[u8]| pair[1] == b'\n' || pair[0] == b'\r' && pair[1] != b'\n';
        let lines = 1 + read.windows(2).filter(is_end).count();
        let shown = String::from_utf8_lossy(&word[..word.len().min(SHOWN)]);
        self.reader.bad(format!("line {lines}: {} {problem}", quoted(&*shown)))
    }
}

fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// Returns whether every CR in a header belongs to a CR LF, and whether every LF does too.
fn line_ends(head: &[u8]) -> (bool, bool) {
    let pairs = head.windows(2).filter(|pair| pair == b"\r\n").count();
    let is_paired = |end: u8| head.iter().filter(|&&byte| byte == end).count() == pairs;
    (is_paired(b'\r'), is_paired(b'\r') && is_paired(b'\n'))
}

/// Returns the bytes of a text with LF in place of CR LF, or `None` if LF occurs alone.
fn without_cr(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut kept = Vec::with_capacity(bytes.len());
    for &byte in bytes {
        if byte == b'\n' {
            kept.pop_if(|last| *last == b'\r')?;
        }
        kept.push(byte);
    }
    Some(kept)
}
