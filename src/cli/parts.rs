//! The flags about parts of pictures.

use super::error::CliError;
use super::flags::{self, Flag};
use super::options::{SIZE_RANGE, ShowProgress};
use super::raw::Raw;
use super::values::{bad, picture_name, whole};
use crate::render::Window;
use std::path::PathBuf;

/// Parts of a picture, and what they become.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Merging {
    /// The parts, of which there is at least one. They end in `.tga` or `.png`.
    pub parts: Vec<PathBuf>,
    /// The picture's file; ends in `.tga` or `.png`.
    pub output: PathBuf,
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
        let parts = words.into_iter().map(|word| picture_name(&flags::MERGE, word));
        let parts = parts.collect::<Result<_, _>>()?;
        let [output] = raw.values(&flags::OUTPUT)?.ok_or(CliError::OutputNeeded)?;
        let output = picture_name(&flags::OUTPUT, output)?;
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
