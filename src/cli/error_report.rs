//! The flags about the report on speed and error.

use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::options::Options;
use super::raw::Raw;
use super::shaping::SHAPING;
use super::values::{bad, finite};
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

/// The flags that a report understands, beside those that shape the colour picture.
const UNDERSTOOD: [&Flag; 6] =
    [&flags::ERROR_REPORT, &flags::TARGET, &flags::INPUT, &flags::THREADS, &flags::PROGRESS, &flags::QUIET];

impl ErrorReporting {
    /// The page and the table.
    pub fn report_files(&self) -> [PathBuf; 2] {
        ["report.html", "report.csv"].map(|name| self.folder.join(name))
    }

    /// The report that the flags ask for, if they do.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let Some([folder]) = raw.values(&flags::ERROR_REPORT)? else {
            let needs_folder = raw.given(&flags::TARGET);
            let needed = CliError::ErrorReportNeeded { flag: flags::TARGET.name };
            return if needs_folder { Err(needed) } else { Ok(None) };
        };
        raw.refuse_others(&flags::ERROR_REPORT, &[UNDERSTOOD.as_slice(), &SHAPING].concat())?;
        let options = Options::from_raw(raw)?;
        Ok(Some(Self { options, folder: folder.into(), target: target(raw)? }))
    }
}

fn target(raw: &Raw) -> Result<Option<f64>, CliError> {
    let Some([word]) = raw.values(&flags::TARGET)? else { return Ok(None) };
    match finite(&flags::TARGET, word)? {
        target if target < 0.0 => Err(bad(&flags::TARGET, word, Problem::Negative)),
        target => Ok(Some(target)),
    }
}
