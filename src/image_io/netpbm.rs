//! Reading of PBM, PGM, PPM and PAM files, plain or raw, and of PFM files.
//!
//! Each is a header of words, then samples. The formats are described in <https://netpbm.sourceforge.net/doc/> and
//! <https://www.pauldebevec.com/Research/HDR/PFM/>. The samples of a raw file follow one white space and fill the rest
//! of the file. If the rest is longer, its pixels may be shifted, and the file is refused unless line feeds written as
//! CR LF explain every byte.

use super::common_to_readers::{ReadNotes, Wanted, beyond_bytes, level, no_pixels, too_short, zeros};
use super::format::{BYTE_ORDER_MARK, CUT_HEADER, OTHER_TEXT};
use crate::base::escape::quoted;
use crate::diagnostic::Diagnostic;
use crate::picture::{Color, Picture, Pixels};
use std::borrow::Cow;

/// Upper bound on the bytes of a word that are shown.
const SHOWN: usize = 40;
/// The largest sample that the formats allow for white.
const LARGEST_WHITE: u32 = 65535;

/// The values of the header.
#[derive(Clone, Copy, Default)]
struct Header {
    size: [u32; 2],
    /// Samples for each pixel: grey, grey and alpha, RGB, or RGB and alpha.
    channels: usize,
    /// Bits of a raw sample: 1, 8, 16 or, in single precision, 32.
    bits: usize,
    /// The sample of white.
    white: u32,
    is_little_endian: bool,
}

impl Header {
    fn set_white(&mut self, white: u32) {
        (self.white, self.bits) = (white, if white > 255 { 16 } else { 8 });
    }

    /// Returns the length of a raw row in bytes.
    fn row_bytes(&self) -> u64 {
        (u64::from(self.size[0]) * self.channels as u64 * self.bits as u64).div_ceil(8)
    }

    /// Sets a pixel from its samples. Returns false if one of them is above white.
    fn set(&self, pixel: &mut [u8; 3], sample: impl Fn(usize) -> u32) -> bool {
        let has_color = usize::from(self.channels > 2);
        let samples = [0, 1, 2].map(|channel| sample(channel * has_color));
        *pixel = samples.map(|sample| level(sample.min(self.white), self.white));
        samples.iter().all(|&sample| sample <= self.white)
    }
}

/// Reads a picture from the start of a file.
pub(super) fn read(file: &[u8], limit: u64, wanted: Wanted) -> Result<(Pixels, ReadNotes), Diagnostic> {
    let start = file.strip_prefix(BYTE_ORDER_MARK).unwrap_or(file);
    let mut text = Text { start, rest: start, size: None };
    let kind = text.word()?;
    let header = match kind {
        b"P1" | b"P4" => text.header(1, 1)?,
        b"P2" | b"P5" => text.header(1, 8)?,
        b"P3" | b"P6" => text.header(3, 8)?,
        b"PF" => text.header(3, 32)?,
        b"Pf" => text.header(1, 32)?,
        _ => text.pam_header()?,
    };
    text.size = Some(header.size);
    let is_plain = matches!(kind, b"P1" | b"P2" | b"P3");
    let [width, height] = header.size.map(u64::from);
    // A pixel of a plain picture has a character or more.
    let row = if is_plain { width } else { header.row_bytes() };
    if width == 0 || height == 0 {
        return Err(no_pixels());
    } else if row.saturating_mul(height) > text.rest.len() as u64 {
        return Err(too_short(header.size));
    }
    if header.bits == 32 {
        return text.numbers(&header, zeros(header.size, limit, wanted)?);
    }
    let picture = zeros(header.size, limit, Wanted::Bytes)?.into_bytes();
    let (picture, notes) = if is_plain { text.plain(&header, picture)? } else { text.raw(&header, picture)? };
    Ok((Pixels::Bytes(picture), notes))
}

/// A file, of which the header or all is text.
struct Text<'a> {
    /// The whole file.
    start: &'a [u8],
    /// The bytes that have not been read.
    rest: &'a [u8],
    /// Width and height, once the header has been read.
    size: Option<[u32; 2]>,
}

impl<'a> Text<'a> {
    /// Reads the size, and the sample of white or the scale, whose sign is the order of bytes.
    fn header(&mut self, channels: usize, bits: usize) -> Result<Header, Diagnostic> {
        let size = [self.number(0, u32::MAX)?, self.number(0, u32::MAX)?];
        let mut header = Header { size, channels, bits, white: 1, is_little_endian: false };
        if bits == 8 {
            header.set_white(self.number(1, LARGEST_WHITE)?);
        } else if bits == 32 {
            let word = self.word()?;
            let scale = parse::<f64>(word).filter(|scale| scale.is_finite() && *scale != 0.0);
            let scale = scale.ok_or_else(|| self.bad_word(word, "is not a scale: a number other than 0"))?;
            header.is_little_endian = scale < 0.0;
        }
        Ok(header)
    }

    fn pam_header(&mut self) -> Result<Header, Diagnostic> {
        let mut header = Header::default();
        loop {
            match self.word()? {
                b"WIDTH" => header.size[0] = self.number(0, u32::MAX)?,
                b"HEIGHT" => header.size[1] = self.number(0, u32::MAX)?,
                b"DEPTH" => header.channels = self.number(1, 4)? as usize,
                b"MAXVAL" => header.set_white(self.number(1, LARGEST_WHITE)?),
                b"TUPLTYPE" => drop(self.word()?),
                b"ENDHDR" if header.channels > 0 && header.bits > 0 => return Ok(header),
                word => return Err(self.bad_word(word, "is unknown, or comes before DEPTH or MAXVAL")),
            }
        }
    }

    /// Reads the samples of a plain picture, after which the file has no more words.
    fn plain(mut self, header: &Header, mut picture: Picture) -> Result<(Picture, ReadNotes), Diagnostic> {
        let [width, height] = header.size;
        for pixel in picture.pixels_mut().as_chunks_mut().0 {
            let mut samples = [0; 3];
            for sample in &mut samples[..header.channels] {
                *sample = if header.bits == 1 { self.bit()? } else { self.number(0, header.white)? };
            }
            header.set(pixel, |channel| samples[channel]);
        }
        let Some(word) = self.next_word() else { return Ok((picture, ReadNotes::default())) };
        let hint = parse::<f64>(word).is_none().then(|| OTHER_TEXT.into());
        let problem = format!("follows the last of {width} x {height} pixels");
        Err(Diagnostic { hint, ..self.bad_word(word, &problem) })
    }

    fn raw(self, header: &Header, mut picture: Picture) -> Result<(Picture, ReadNotes), Diagnostic> {
        let Header { channels, bits, white, size: [_, height], .. } = *header;
        let (row_bytes, height) = (header.row_bytes() as usize, height as usize);
        let (samples, has_line_end) = self.samples(row_bytes * height)?;
        let mut transparent = 0;
        for (bytes, y) in samples.chunks_exact(row_bytes).zip(0..height) {
            let row = picture.row_mut(height - 1 - y);
            if (channels, bits, white) == (3, 8, 255) {
                row.copy_from_slice(bytes);
                continue;
            }
            let sample = |at: usize| match bits {
                // A bit is set for black.
                1 => u32::from(!bytes[at / 8] >> (7 - at % 8) & 1),
                8 => bytes[at].into(),
                _ => u16::from_be_bytes([bytes[2 * at], bytes[2 * at + 1]]).into(),
            };
            let mut pixels = row.as_chunks_mut().0.iter_mut().enumerate();
            if !pixels.all(|(x, pixel)| header.set(pixel, |channel| sample(x * channels + channel))) {
                let problem = format!("row {} has a sample above {white}, the maximum", y + 1);
                return Err(Diagnostic::error(problem));
            }
            if matches!(channels, 2 | 4) {
                let alphas = (0..header.size[0] as usize).map(|x| sample((x + 1) * channels - 1));
                transparent += alphas.filter(|&alpha| alpha < white).count() as u64;
            }
        }
        Ok((picture, ReadNotes { transparent, has_line_end, ..ReadNotes::default() }))
    }

    /// Reads numbers in single precision. Their rows are stored from the bottom.
    fn numbers(self, header: &Header, mut picture: Pixels) -> Result<(Pixels, ReadNotes), Diagnostic> {
        let Header { channels, size: [_, height], is_little_endian, .. } = *header;
        let (row_bytes, height) = (header.row_bytes() as usize, height as usize);
        let (samples, has_line_end) = self.samples(row_bytes * height)?;
        let mut notes = ReadNotes { has_line_end, ..ReadNotes::default() };
        let number = |&bytes: &[u8; 4]| match is_little_endian {
            true => f64::from(f32::from_le_bytes(bytes)),
            false => f64::from(f32::from_be_bytes(bytes)),
        };
        for (bytes, y) in samples.chunks_exact(row_bytes).zip((0..height).rev()) {
            let pixels = bytes.as_chunks().0.chunks_exact(channels);
            let color =
                |pixel: &[[u8; 4]]| [0, channels / 2, channels - 1].map(|index| number(&pixel[index]));
            let colors: Vec<Color> = pixels.map(|pixel| color(pixel).into()).collect();
            picture.set([0, y], &colors);
            notes.clamped += beyond_bytes(&colors);
        }
        Ok((picture, notes))
    }

    /// Returns the samples, which take `needed` bytes, and whether a line end follows them. After the last word of the
    /// header and its one white space, a file may have:
    ///
    /// | bytes | reason |
    /// |---|---|
    /// | the samples | as the format says |
    /// | LF, the samples | the white space is a CR, since all lines of the header end in CR LF |
    /// | the samples, then LF or CR LF | a program has ended the last line, unless the samples begin with white space |
    /// | LF, the samples with a CR before each LF | the white space is a CR, since the file was written as text |
    fn samples(&self, needed: usize) -> Result<(Cow<'a, [u8]>, bool), Diagnostic> {
        let (rest, [width, height]) = (self.rest, self.size.unwrap_or_default());
        let head = &self.start[..self.start.len() - rest.len()];
        let surplus = rest.len() - needed;
        // White space before the samples could be surplus just as well.
        let is_next_white = rest.first().is_some_and(u8::is_ascii_whitespace);
        let is_in_crlf =
            head.ends_with(b"\r") && rest.starts_with(b"\n") && has_crlf_only(&self.start[..=head.len()]);
        match surplus {
            // All lines of the header end in CR LF. So does the last, and a byte is missing.
            0 if is_in_crlf && head.contains(&b'\n') => Err(too_short([width, height])),
            0 => Ok((rest.into(), false)),
            1 if is_in_crlf => Ok((rest[1..].into(), false)),
            1 | 2 if !is_next_white && matches!(&rest[needed..], b"\n" | b"\r\n") => {
                Ok((rest[..needed].into(), true))
            }
            _ => {
                let samples = is_in_crlf.then(|| without_cr(&rest[1..])).flatten();
                if let Some(samples) = samples.filter(|samples| samples.len() == needed) {
                    return Ok((samples.into(), false));
                }
                let bytes = if surplus == 1 { "byte" } else { "bytes" };
                let problem = format!("it is {surplus} {bytes} too long for {width} x {height} pixels");
                Err(Diagnostic::error(problem + ": they may be shifted")
                    .with_hint("write it in binary mode, one picture in a file"))
            }
        }
    }

    /// Reads a digit of a bitmap. Returns 1 for white.
    fn bit(&mut self) -> Result<u32, Diagnostic> {
        self.skip_space();
        match self.rest.split_off(..1) {
            Some(b"0") => Ok(1),
            Some(b"1") => Ok(0),
            Some(other) => Err(self.bad_word(other, "is neither 0 nor 1")),
            None => Err(self.cut()),
        }
    }

    /// Reads a whole number within these bounds.
    fn number(&mut self, least: u32, most: u32) -> Result<u32, Diagnostic> {
        let word = self.word()?;
        if let Some(number) = parse(word).filter(|number| (least..=most).contains(number)) {
            return Ok(number);
        }
        let hint = match parse::<f64>(word) {
            _ if self.size.is_none() => None,
            Some(_) => Some("clamp colours before they become whole numbers; NaN as an int is negative"),
            None => Some(OTHER_TEXT),
        };
        let problem = format!("is not a whole number from {least} to {most}");
        Err(Diagnostic { hint: hint.map(String::from), ..self.bad_word(word, &problem) })
    }

    fn word(&mut self) -> Result<&'a [u8], Diagnostic> {
        self.next_word().ok_or_else(|| self.cut())
    }

    /// Reads the next word, outside comments, and the white space or the comment that ends it. `None` at the end of the
    /// file.
    fn next_word(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let is_end = |byte: &u8| *byte == b'#' || byte.is_ascii_whitespace();
        let length = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
        let word = self.rest.split_off(..length)?;
        self.skip_one();
        Some(word).filter(|word| !word.is_empty())
    }

    fn skip_space(&mut self) {
        while self.skip_one() {}
    }

    /// Skips a white space or a comment, with the byte that ends its line. Returns false if there is none.
    fn skip_one(&mut self) -> bool {
        let length = match self.rest.first() {
            Some(b'#') => {
                let end = self.rest.iter().position(|byte| matches!(byte, b'\r' | b'\n'));
                end.map_or(self.rest.len(), |end| end + 1)
            }
            Some(byte) if byte.is_ascii_whitespace() => 1,
            _ => return false,
        };
        self.rest.split_off(..length).is_some()
    }

    /// Returns the error of a file that ends too early.
    fn cut(&self) -> Diagnostic {
        self.size.map_or_else(|| Diagnostic::error(CUT_HEADER), too_short)
    }

    /// Returns the error of a word, which has just been read.
    fn bad_word(&self, word: &[u8], problem: &str) -> Diagnostic {
        let read = &self.start[..self.start.len() - self.rest.len()];
        let read = read.strip_suffix(b"\n").or(read.strip_suffix(b"\r")).unwrap_or(read);
        let is_end = |pair: &&[u8]| pair[1] == b'\n' || pair[0] == b'\r';
        let lines = 1 + read.windows(2).filter(is_end).count();
        let shown = String::from_utf8_lossy(&word[..word.len().min(SHOWN)]);
        Diagnostic::error(format!("line {lines}: {} {problem}", quoted(&*shown)))
    }
}

fn parse<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    str::from_utf8(word).ok()?.parse().ok()
}

/// True if every CR and every LF belongs to a CR LF.
fn has_crlf_only(text: &[u8]) -> bool {
    let pairs = text.windows(2).filter(|pair| pair == b"\r\n").count();
    [b'\r', b'\n'].iter().all(|end| text.iter().filter(|&byte| byte == end).count() == pairs)
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
