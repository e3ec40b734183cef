//! The flags about parts of pictures.

use super::error::CliError;
use super::flag::Run;
use super::flags;
use super::options::ShowProgress;
use super::outputs::{Output, output_of_bytes};
use super::raw::Raw;
use crate::render::Window;
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

impl Merging {
    /// What the flags ask for, if they ask for parts to be put together.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let Some(values) = raw.values(&flags::MERGE) else { return Ok(None) };
        raw.refuse_others(&flags::MERGE, Run::Merge)?;
        let parts = (flags::MERGE.read)(&values)?;
        Ok(Some(Self {
            parts,
            output: output_of_bytes(raw, &flags::MERGE)?,
            region: raw.read(&flags::REGION)?,
            progress: ShowProgress::from_raw(raw),
        }))
    }
}
