//! The flags about the report on speed and error.

use super::error::CliError;
use super::flag::Run;
use super::flags;
use super::options::Options;
use super::raw::Raw;
use std::path::PathBuf;

/// A report on what settings cost and buy.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorReporting {
    /// The scene and what is asked for. There is a scene.
    pub options: Options,
    /// Where the report is written. The folder need not exist.
    pub folder: PathBuf,
    /// The error to reach, in levels, not negative.
    pub target: Option<f64>,
}

impl ErrorReporting {
    /// The page and the table.
    pub fn report_files(&self) -> [PathBuf; 2] {
        ["report.html", "report.csv"].map(|name| self.folder.join(name))
    }

    /// The report that the flags ask for, if they do.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let Some(folder) = raw.read(&flags::ERROR_REPORT)? else {
            return raw.refuse_without(&flags::ERROR_REPORT).map(|()| None);
        };
        raw.refuse_others(&flags::ERROR_REPORT, Run::ErrorReport)?;
        Ok(Some(Self { options: Options::from_raw(raw)?, folder, target: raw.read(&flags::TARGET)? }))
    }
}
