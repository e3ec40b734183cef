//! Code that all readers share: opening a file, the errors of its size and its end, and samples that become levels.

use crate::base::escape::quoted;
use crate::base::memory::Bytes;
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Color, Pixels};
use std::error::Error;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::iter;
use std::path::Path;

/// Facts that a user should know about a picture that was read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadNotes {
    /// The number of pixels with a channel below 0, above 1 or NaN, which a byte cannot store.
    pub clamped: u64,
    /// The number of pixels whose alpha, which is ignored, is not opaque.
    pub transparent: u64,
    /// True if a line end follows the last pixel.
    pub has_line_end: bool,
}

/// The form in which the numbers of PFM and OpenEXR files are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// Cut to bytes, as the colours of a rendering are.
    Bytes,
    /// As they are.
    Numbers,
}

/// Opens a regular file. A pipe could block the program.
pub(super) fn open_regular(path: &Path) -> Result<File, Diagnostic> {
    match fs::metadata(path)?.is_file() {
        true => Ok(File::open(path)?),
        false => Err(Diagnostic::error("it is not a regular file")),
    }
}

/// Converts a decoder's error. The result is `too_early` if the file ends too early.
pub(super) fn undecoded(error: io::Error, too_early: Diagnostic) -> Diagnostic {
    match error.kind() {
        ErrorKind::UnexpectedEof => too_early,
        // The crates' own errors.
        ErrorKind::Other | ErrorKind::InvalidData | ErrorKind::InvalidInput => refused(&error),
        _ => error.into(),
    }
}

/// Returns a picture of zeros, to be filled from the numbers of the file. `limit` bounds the bytes that it has as 8-bit
/// RGB, also if its numbers are kept.
pub(super) fn zeros(size: [u32; 2], limit: u64, wanted: Wanted) -> Result<Pixels, Diagnostic> {
    let pixels = u64::from(size[0]) * u64::from(size[1]);
    check_bytes(size, pixels.saturating_mul(CHANNELS as u64), limit)?;
    Ok(Pixels::zeros(size.map(|side| side as usize), wanted == Wanted::Numbers)?)
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

pub(super) fn too_short([width, height]: [impl Display; 2]) -> Diagnostic {
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
