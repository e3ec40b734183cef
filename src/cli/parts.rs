//! The flags about parts of pictures.

use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::options::{SIZE_RANGE, ShowProgress};
use super::outputs::Output;
use super::raw::Raw;
use super::values::{bad, byte_picture_name, picture_file, whole};
use crate::render::{Layer, Window};
use std::path::PathBuf;

/// Parts of a picture, and what they become.
#[derive(Clone, Debug, PartialEq)]
pub struct Merging {
    /// The parts, of which there is at least one. They end in `.tga` or `.png`.
    pub parts: Vec<PathBuf>,
    /// Where the picture goes. Its format is one of bytes.
    pub output: Output,
    /// The part of the picture that they become; none for the whole.
    pub region: Option<Window>,
    /// Where progress is shown.
    pub progress: ShowProgress,
}

/// The flags that are understood together with `-merge`.
const UNDERSTOOD: [&Flag; 5] =
    [&flags::MERGE, &flags::OUTPUT, &flags::REGION, &flags::PROGRESS, &flags::QUIET];

impl Merging {
    /// What the flags ask for, if they ask for parts to be put together.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let Some(words) = raw.all_values(&flags::MERGE) else { return Ok(None) };
        raw.refuse_others(&flags::MERGE, &UNDERSTOOD)?;
        let parts = words.into_iter().map(|word| byte_picture_name(&flags::MERGE, word));
        let parts = parts.collect::<Result<_, _>>()?;
        let ([name], word) = raw.picture_values(&flags::OUTPUT)?.ok_or(CliError::OutputNeeded)?;
        let (file, format) = picture_file(&flags::OUTPUT, name, word)?;
        if format.is_float() {
            return Err(bad(&flags::OUTPUT, word.unwrap_or(name), Problem::NotBytes));
        }
        let output = Output { layer: Layer::Color, file, format };
        Ok(Some(Self { parts, output, region: region(raw)?, progress: ShowProgress::from_raw(raw) }))
    }
}

/// The part of the picture that is asked for.
pub(super) fn region(raw: &Raw) -> Result<Option<Window>, CliError> {
    let Some(words) = raw.values::<4>(&flags::REGION)? else { return Ok(None) };
    let mut numbers = [0; 4];
    let place = (0, SIZE_RANGE.1 - 1);
    for ((number, word), range) in numbers.iter_mut().zip(words).zip([place, place, SIZE_RANGE, SIZE_RANGE]) {
        *number = whole(word, range).map_err(|problem| bad(&flags::REGION, word, problem))? as usize;
    }
    let [x, y, width, height] = numbers;
    Ok(Some(Window { x, y, width, height }))
}
