//! The flags about a picture in another format.

use super::error::CliError;
use super::flag::Run;
use super::flags;
use super::options::ShowProgress;
use super::outputs::{Output, output_of_bytes};
use super::raw::Raw;
use std::path::PathBuf;

/// A picture, and where it goes in another format.
#[derive(Clone, Debug, PartialEq)]
pub struct Converting {
    /// The picture to read.
    pub picture: PathBuf,
    /// Where it goes. Its format is one of bytes.
    pub output: Output,
    /// Where progress is shown, and whether a finished run tells what it wrote.
    pub progress: ShowProgress,
}

impl Converting {
    /// What the flags ask for, if they ask for a picture in another format.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let Some(picture) = raw.read(&flags::CONVERT)? else { return Ok(None) };
        raw.refuse_others(&flags::CONVERT, Run::Convert)?;
        let output = output_of_bytes(raw, &flags::CONVERT)?;
        Ok(Some(Self { picture, output, progress: ShowProgress::from_raw(raw) }))
    }
}
