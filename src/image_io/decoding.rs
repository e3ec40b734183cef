//! Helpers of all readers: opening a file, the errors of its size and its end, and samples that become
//! levels.

use crate::base::escape::quoted;
use crate::base::memory::Bytes;
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Color, FloatPicture, Picture, Pixels};
use std::error::Error;
use std::fs::{self, File};
use std::path::Path;
use std::{io, iter};

/// Facts that a user should know about a picture that was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Remarks {
    /// The number of pixels with a channel below 0, above 1 or NaN, which a byte cannot store.
    pub clamped: u64,
    /// The number of pixels whose alpha, which is ignored, is not opaque.
    pub transparent: u64,
    /// True if a line end follows the last pixel.
    pub has_line_end: bool,
}

/// The form in which the numbers of a file are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    Bytes,
    Numbers,
}

/// Opens a regular file. A pipe could block the program.
pub(super) fn open_regular(path: &Path) -> Result<File, Diagnostic> {
    match fs::metadata(path)?.is_file() {
        true => Ok(File::open(path)?),
        false => Err(Diagnostic::error("it is not a regular file")),
    }
}

/// Returns an error of reading, with other words for a file that ends too early.
pub(super) fn or_too_early(error: io::Error, too_early: Diagnostic) -> Diagnostic {
    if error.kind() == io::ErrorKind::UnexpectedEof { too_early } else { error.into() }
}

/// Returns a black picture, to be filled from the file.
pub(super) fn black(size @ [width, height]: [u32; 2], limit: u64) -> Result<Picture, Diagnostic> {
    let pixels = u64::from(width) * u64::from(height);
    check_bytes(size, pixels.saturating_mul(CHANNELS as u64), limit)?;
    Ok(Picture::new(width, height)?)
}

/// Returns a picture of zeros, to be filled from the numbers of the file. `limit` bounds the bytes that it has as 8-bit
/// RGB, also if its numbers are kept.
pub(super) fn zeros(
    size @ [width, height]: [u32; 2],
    limit: u64,
    wanted: Wanted,
) -> Result<Pixels, Diagnostic> {
    if wanted == Wanted::Bytes {
        return black(size, limit).map(Pixels::Bytes);
    }
    let pixels = u64::from(width) * u64::from(height);
    check_bytes(size, pixels.saturating_mul(CHANNELS as u64), limit)?;
    let mut picture = FloatPicture::with_room(size.map(|n| n as usize))?;
    picture.colors.resize(pixels as usize, Color::ZERO);
    Ok(Pixels::Numbers(picture))
}

/// Counts the colours with a channel below 0, above 1 or NaN.
pub(super) fn beyond_bytes(colors: &[Color]) -> u64 {
    let is_shown = |channel: f64| (0.0..=1.0).contains(&channel);
    colors.iter().filter(|color| !color.to_array().into_iter().all(is_shown)).count() as u64
}

/// Returns an error if the pixels take more than `limit` bytes.
pub(super) fn check_bytes([width, height]: [u32; 2], bytes: u64, limit: u64) -> Result<(), Diagnostic> {
    if bytes <= limit {
        return Ok(());
    }
    let [shown, limit] = [bytes, limit].map(Bytes);
    let problem = format!("its {width} x {height} pixels take {shown}, above the limit of {limit}");
    Err(Diagnostic::error(problem))
}

pub(super) fn no_pixels() -> Diagnostic {
    Diagnostic::error("the picture has no pixels")
}

pub(super) fn too_short([width, height]: [u32; 2]) -> Diagnostic {
    Diagnostic::error(format!("it is too short for {width} x {height} pixels"))
}

/// Returns the error of a TGA, PNG or BMP file that its decoder refuses.
pub(super) fn refused(reason: &(dyn Error + 'static)) -> Diagnostic {
    let reasons = iter::successors(Some(reason), |reason| (*reason).source());
    let shown = quoted(reasons.last().unwrap_or(reason).to_string());
    Diagnostic::error(format!("it is damaged, or of a rare variant: its decoder says {shown}"))
        .with_hint("copy it again, in binary mode, or save it as PNG with 8 bits per channel")
}

/// Returns the level nearest to a sample between 0 and `white`.
pub(super) fn level(sample: u32, white: u32) -> u8 {
    ((sample * 255 + white / 2) / white) as u8
}
