//! What runs are asked for that do not render: grading, parts, conversion, and the report on speed and error.

use super::error::fail;
use super::flags::Flags;
use super::options::{Options, ShowProgress, region, tolerance};
use super::outputs::{Output, output_of_bytes};
use crate::diagnostic::Diagnostic;
use crate::render::Window;
use crate::tools::compare::Tolerance;
use std::path::PathBuf;

/// A folder with a folder of pictures for every name, and what they are to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grading {
    pub folder: PathBuf,
    pub references: References,
    /// The page, whose name ends in `.html`.
    pub report: Option<PathBuf>,
    pub tolerance: Option<Tolerance>,
    pub threads: Option<usize>,
    pub progress: ShowProgress,
}

/// Where the reference pictures come from: the files of a folder, or command lines in a file that render them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum References {
    Folder(PathBuf),
    Commands(PathBuf),
}

/// Parts of a picture, and what they become.
#[derive(Clone, Debug, PartialEq)]
pub struct Merging {
    /// The parts, of which there is at least one. They end in `.tga` or `.png`.
    pub parts: Vec<PathBuf>,
    /// Where the picture goes. Its format is one of bytes.
    pub output: Output,
    /// The part of the picture that they become; none for the whole.
    pub region: Option<Window>,
    pub progress: ShowProgress,
}

/// A picture, and where it goes in another format, which is one of bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Converting {
    pub picture: PathBuf,
    pub output: Output,
    pub progress: ShowProgress,
}

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

impl Grading {
    pub(super) fn new(folder: PathBuf, flags: &Flags) -> Result<Self, Diagnostic> {
        let references = match (&flags.reference, &flags.commands) {
            (Some(folder), _) => References::Folder(folder.clone()),
            (None, Some(commands)) => References::Commands(commands.clone()),
            (None, None) => return fail("-grade needs -reference or -commands"),
        };
        Ok(Self {
            folder,
            references,
            report: flags.report.clone(),
            tolerance: tolerance(flags)?,
            threads: flags.threads,
            progress: ShowProgress::new(flags),
        })
    }

    /// The page and the table beside it, if they are written.
    pub fn report_files(&self) -> Option<[PathBuf; 2]> {
        let page = self.report.as_ref()?;
        Some([page.clone(), page.with_extension("csv")])
    }
}

impl Merging {
    pub(super) fn new(parts: Vec<PathBuf>, flags: &Flags) -> Result<Self, Diagnostic> {
        let region = flags.region.as_deref().map(region).transpose()?;
        Ok(Self { parts, output: output_of_bytes(flags)?, region, progress: ShowProgress::new(flags) })
    }
}

impl ErrorReporting {
    /// The page and the table.
    pub fn report_files(&self) -> [PathBuf; 2] {
        ["report.html", "report.csv"].map(|name| self.folder.join(name))
    }
}
