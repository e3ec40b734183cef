//! Reading of PBM, PGM, PPM and PAM files, plain or raw, and of PFM files.
//!
//! Each is a header of words, then samples. The formats are described in <https://netpbm.sourceforge.net/doc/> and
//! <https://www.pauldebevec.com/Research/HDR/PFM/>. The samples of a raw file follow one white space and fill the rest
//! of the file. If the rest is longer, its pixels may be shifted, and the file is refused unless line feeds written as
//! CR LF explain every byte.

use super::error::ImageError;
use super::input::{InputFile, Remarks, fill_row, level};
use super::part_file::RowSource;
use super::signature::BYTE_ORDER_MARK;
use crate::escape::quoted;
use crate::picture::Picture;
use crate::scene::Color;
use arrayvec::ArrayString;
use std::io::{Cursor, SeekFrom};

/// Upper bound on the length of a word.
const LONGEST_WORD: usize = 40;
/// The largest sample that the formats allow for white.
const LARGEST_WHITE: u32 = 65535;

/// The hint for a word that is no number.
const OTHER_TEXT: &str = "; messages belong to the standard error, as `std::cerr`";

type Word = ArrayString<LONGEST_WORD>;

/// What the header says.
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
    /// Sets a pixel from its samples. Returns false if one of them is above that of white.
    fn set(&self, pixel: &mut [u8; 3], sample: impl Fn(usize) -> usize) -> bool {
        let has_color = usize::from(self.channels > 2);
        let levels = [0, 1, 2].map(|channel| self.levels.get(sample(channel * has_color)).copied());
        *pixel = levels.map(Option::unwrap_or_default);
        levels.iter().all(Option::is_some)
    }

    fn set_white(&mut self, white: u32) {
        self.levels = (0..=white).map(|sample| level(sample, white)).collect();
        self.bits = if white > 255 { 16 } else { 8 };
    }
}

/// A file, of which the header or all is text.
pub(super) struct Text<'a> {
    file: InputFile<'a>,
    source: Box<dyn RowSource + 'a>,
    /// Number of bytes read, of line feeds and carriage returns in them, and of both together.
    read: u64,
    lf: u64,
    cr: u64,
    crlf: u64,
    /// The latest byte.
    last: u8,
    /// Width and height, once the header has been read.
    size: Option<[u32; 2]>,
}

impl<'a> Text<'a> {
    pub(super) fn new(file: InputFile<'a>, source: Box<dyn RowSource + 'a>) -> Self {
        Self { file, source, read: 0, lf: 0, cr: 0, crlf: 0, last: 0, size: None }
    }

    pub(super) fn picture(mut self) -> Result<(Picture, Remarks), ImageError> {
        while self.peek()?.is_some_and(|byte| BYTE_ORDER_MARK.contains(&byte)) {
            self.byte()?;
        }
        let (channels, bits, is_plain) = match &*self.header_word()? {
            "P1" => (1, 1, true),
            "P2" => (1, 8, true),
            "P3" => (3, 8, true),
            "P4" => (1, 1, false),
            "P5" => (1, 8, false),
            "P6" => (3, 8, false),
            "PF" => (3, 32, false),
            "Pf" => (1, 32, false),
            _ => (0, 8, false),
        };
        let header = if channels > 0 { self.header(channels, bits)? } else { self.pam_header()? };
        self.size = Some(header.size);
        if is_plain { Ok((self.plain(&header)?, Remarks::default())) } else { self.raw(&header) }
    }

    /// Reads the size, and the sample of white or the scale, whose sign is the order of bytes.
    fn header(&mut self, channels: usize, bits: usize) -> Result<Header, ImageError> {
        let size = [self.number(0, u32::MAX)?, self.number(0, u32::MAX)?];
        let mut header = Header { size, channels, bits, levels: vec![], is_little_endian: false };
        match bits {
            1 => header.levels = vec![255, 0],
            32 => {
                let scale = self.header_word()?;
                let number = scale.parse::<f64>().ok().filter(|scale| scale.is_finite() && *scale != 0.0);
                let number =
                    number.ok_or_else(|| self.bad_word(&scale, "is no scale, a number other than 0"))?;
                header.is_little_endian = number < 0.0;
            }
            _ => header.set_white(self.number(1, LARGEST_WHITE)?),
        }
        Ok(header)
    }

    fn pam_header(&mut self) -> Result<Header, ImageError> {
        let mut header =
            Header { size: [0; 2], channels: 0, bits: 8, levels: vec![], is_little_endian: false };
        loop {
            match &*self.header_word()? {
                "WIDTH" => header.size[0] = self.number(0, u32::MAX)?,
                "HEIGHT" => header.size[1] = self.number(0, u32::MAX)?,
                "DEPTH" => header.channels = self.number(1, 4)? as usize,
                "MAXVAL" => header.set_white(self.number(1, LARGEST_WHITE)?),
                "TUPLTYPE" => drop(self.header_word()?),
                "ENDHDR" if header.channels > 0 && !header.levels.is_empty() => return Ok(header),
                word => return Err(self.bad_word(word, "is unknown, or comes before DEPTH or MAXVAL")),
            }
        }
    }

    /// Reads the samples of a plain picture, after which the file has no more words.
    fn plain(&mut self, header: &Header) -> Result<Picture, ImageError> {
        let [width, height] = header.size;
        let mut picture = self.file.black(header.size, self.file.length)?;
        for row in (0..height as usize).rev() {
            for pixel in picture.row_mut(row).as_chunks_mut().0 {
                let mut samples = [0; 3];
                for sample in &mut samples[..header.channels] {
                    *sample = match header.bits {
                        1 => self.digit()?,
                        _ => self.number(0, header.levels.len() as u32 - 1)?,
                    } as usize;
                }
                header.set(pixel, |channel| samples[channel]);
            }
        }
        let Some(word) = self.word()? else { return Ok(picture) };
        let hint = if word.parse::<f64>().is_ok() { "" } else { OTHER_TEXT };
        Err(self.bad_word(&word, &format!("follows the last of {width} x {height} pixels{hint}")))
    }

    fn raw(mut self, header: &Header) -> Result<(Picture, Remarks), ImageError> {
        let (file, [width, height], channels) = (self.file, header.size, header.channels);
        let row_bytes = (u64::from(width) * channels as u64 * header.bits as u64).div_ceil(8);
        let needed = row_bytes.saturating_mul(height.into());
        let is_long_enough = file.length - self.read >= needed;
        let mut picture = file.black(header.size, if is_long_enough { u64::MAX } else { 0 })?;
        let mut bytes = file.zeros(row_bytes, header.size)?;
        let mut remarks = Remarks { clamped: 0, has_line_end: self.find_samples(needed)? };
        let mut colors = Vec::new();
        // Without this the most common files would take three times as long.
        let is_rgb = (channels, header.levels.len()) == (3, 256);
        for index in 0..height as usize {
            self.source.read_exact(&mut bytes).map_err(|error| file.cut(error, header.size))?;
            if is_rgb {
                picture.row_mut(height as usize - 1 - index).copy_from_slice(&bytes);
                continue;
            }
            if header.bits == 32 {
                let number = |&bytes: &[u8; 4]| match header.is_little_endian {
                    true => f64::from(f32::from_le_bytes(bytes)),
                    false => f64::from(f32::from_be_bytes(bytes)),
                };
                let pixels = bytes.as_chunks().0.chunks_exact(channels);
                colors.clear();
                colors.extend(pixels.map(|pixel| {
                    Color::new(number(&pixel[0]), number(&pixel[channels / 2]), number(&pixel[channels - 1]))
                }));
                // Rows are stored from the bottom.
                remarks.clamped += fill_row(&colors, picture.row_mut(index));
                continue;
            }
            let sample = |at: usize| match header.bits {
                1 => usize::from(bytes[at / 8] >> (7 - at % 8) & 1),
                8 => bytes[at].into(),
                _ => u16::from_be_bytes([bytes[2 * at], bytes[2 * at + 1]]).into(),
            };
            let row = picture.row_mut(height as usize - 1 - index);
            let mut pixels = row.as_chunks_mut().0.iter_mut().enumerate();
            if !pixels.all(|(x, pixel)| header.set(pixel, |channel| sample(x * channels + channel))) {
                let white = header.levels.len() - 1;
                return Err(file.bad(format!("row {} has a sample above {white}, its white", index + 1)));
            }
        }
        Ok((picture, remarks))
    }

    /// Moves to the samples, which take `needed` bytes. Returns true if a line end follows them.
    fn find_samples(&mut self, needed: u64) -> Result<bool, ImageError> {
        let (file, size) = (self.file, self.size.unwrap_or_default());
        let failed = |error| ImageError::io("read", file.path, error);
        let surplus = file.length - self.read - needed;
        let next = self.peek()?;
        let ends_in_crlf = (self.last, next) == (b'\r', Some(b'\n')) && self.cr == self.crlf + 1;
        let all_end_in_crlf = ends_in_crlf && self.lf == self.crlf;
        match surplus {
            // All lines of the header end in CR LF. So does the last, and a byte is missing.
            0 if all_end_in_crlf && self.lf > 0 => return Err(file.short(size)),
            0 => return Ok(false),
            1 if ends_in_crlf => {
                self.source.consume(1);
                return Ok(false);
            }
            // White space before the samples could be surplus just as well.
            1 | 2 if !next.is_some_and(|byte| byte.is_ascii_whitespace()) => {
                let mut end = vec![];
                self.source.seek(SeekFrom::Start(file.length - surplus)).map_err(failed)?;
                self.source.read_to_end(&mut end).map_err(failed)?;
                self.source.seek(SeekFrom::Start(self.read)).map_err(failed)?;
                if matches!(end.as_slice(), b"\n" | b"\r\n") {
                    return Ok(true);
                }
            }
            _ if all_end_in_crlf => {
                self.source.consume(1);
                let mut bytes = file.zeros(needed + surplus - 1, size)?;
                self.source.read_exact(&mut bytes).map_err(failed)?;
                if let Some(samples) = without_cr(bytes).filter(|samples| samples.len() as u64 == needed) {
                    self.source = Box::new(Cursor::new(samples));
                    return Ok(false);
                }
            }
            _ => {}
        }
        let [width, height] = size;
        let bytes = if surplus == 1 { "byte" } else { "bytes" };
        Err(file.bad(format!(
            "it is {surplus} {bytes} too long for {width} x {height} pixels, so that they may be shifted; \
             write it in binary mode, one picture in a file"
        )))
    }

    /// Reads a digit of a bitmap.
    fn digit(&mut self) -> Result<u32, ImageError> {
        loop {
            match self.byte()? {
                Some(b'#') => self.skip_comment()?,
                Some(space) if space.is_ascii_whitespace() => {}
                Some(digit @ (b'0' | b'1')) => return Ok(u32::from(digit - b'0')),
                Some(other) => {
                    return Err(self.bad_word(&char::from(other).to_string(), "is neither 0 nor 1"));
                }
                None => return Err(self.cut()),
            }
        }
    }

    /// Reads a whole number within these bounds.
    fn number(&mut self, least: u32, most: u32) -> Result<u32, ImageError> {
        let word = self.word()?.ok_or_else(|| self.cut())?;
        if let Some(number) = word.parse().ok().filter(|number| (least..=most).contains(number)) {
            return Ok(number);
        }
        let hint = match &*word {
            _ if self.size.is_none() => "",
            word if word.starts_with('-') => {
                "; a negative colour or NaN as an int gives it: clamp colours first"
            }
            word if word.bytes().all(|byte| byte.is_ascii_digit()) => "; clamp colours first",
            word if word.parse::<f64>().is_ok() => "; colours are whole numbers here, up to that of white",
            _ => OTHER_TEXT,
        };
        Err(self.bad_word(&word, &format!("is not a whole number from {least} to {most}{hint}")))
    }

    fn header_word(&mut self) -> Result<Word, ImageError> {
        self.word()?.ok_or_else(|| self.cut())
    }

    /// Reads the next word, outside comments, and the white space that ends it. None at the end of the file.
    fn word(&mut self) -> Result<Option<Word>, ImageError> {
        let mut word = Word::new();
        while let Some(byte) = self.byte()? {
            match byte {
                b'#' => self.skip_comment()?,
                space if space.is_ascii_whitespace() => {}
                letter => {
                    if word.try_push(char::from(letter)).is_err() {
                        return Err(self.bad_word(&word, "begins a word that is too long"));
                    }
                    continue;
                }
            }
            if !word.is_empty() {
                break;
            }
        }
        Ok(Some(word).filter(|word| !word.is_empty()))
    }

    /// Reads the rest of a comment and the byte that ends its line.
    fn skip_comment(&mut self) -> Result<(), ImageError> {
        while !matches!(self.byte()?, None | Some(b'\r' | b'\n')) {}
        Ok(())
    }

    fn byte(&mut self) -> Result<Option<u8>, ImageError> {
        let Some(byte) = self.peek()? else { return Ok(None) };
        self.source.consume(1);
        self.read += 1;
        self.lf += u64::from(byte == b'\n');
        self.cr += u64::from(byte == b'\r');
        self.crlf += u64::from((self.last, byte) == (b'\r', b'\n'));
        self.last = byte;
        Ok(Some(byte))
    }

    fn peek(&mut self) -> Result<Option<u8>, ImageError> {
        let rest = self.source.fill_buf().map_err(|error| ImageError::io("read", self.file.path, error))?;
        Ok(rest.first().copied())
    }

    /// The error of a file that ends too early.
    fn cut(&self) -> ImageError {
        match self.size {
            Some(size) => self.file.short(size),
            None => self.file.bad("it ends within its header"),
        }
    }

    /// The error of a word, which the latest byte belongs to or ends.
    fn bad_word(&self, word: &str, problem: &str) -> ImageError {
        let lines = self.lf + self.cr - self.crlf + u64::from(!matches!(self.last, b'\r' | b'\n'));
        self.file.bad(format!("line {lines}: {} {problem}", quoted(word)))
    }
}

/// Returns the bytes of a text with LF in place of CR LF, or `None` if LF occurs alone.
fn without_cr(mut bytes: Vec<u8>) -> Option<Vec<u8>> {
    let (mut kept, mut previous) = (0, 0);
    for index in 0..bytes.len() {
        let byte = bytes[index];
        match (previous, byte) {
            // It replaces the CR.
            (b'\r', b'\n') => kept -= 1,
            (_, b'\n') => return None,
            _ => {}
        }
        (bytes[kept], previous) = (byte, byte);
        kept += 1;
    }
    bytes.truncate(kept);
    Some(bytes)
}
