//! What runs are asked for that do not render: grading, parts, conversion, and the report on speed and error.

use super::error::CliError;
use super::flags::Flags;
use super::options::{Options, ShowProgress, tolerance};
use super::outputs::Output;
use crate::render::Window;
use crate::tools::compare::Tolerance;
use std::path::PathBuf;

/// A folder with a folder of pictures for every name, and what they are to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grading {
    /// The folder of folders.
    pub folder: PathBuf,
    /// What the pictures are compared with.
    pub references: References,
    /// The page, whose name ends in `.html`.
    pub report: Option<PathBuf>,
    /// The difference that passes; none if none was named.
    pub tolerance: Option<Tolerance>,
    /// The number of threads, 1 to 4096; `None` for all cores.
    pub threads: Option<usize>,
    /// Where progress is shown.
    pub progress: ShowProgress,
}

/// Where the reference pictures come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum References {
    /// The picture files of a folder.
    Folder(PathBuf),
    /// Rendered by the command lines in a file.
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
    /// Where progress is shown.
    pub progress: ShowProgress,
}

/// A picture, and where it goes in another format.
#[derive(Clone, Debug, PartialEq)]
pub struct Converting {
    /// The picture to read.
    pub picture: PathBuf,
    /// Where it goes. Its format is one of bytes.
    pub output: Output,
    /// Where progress is shown, and whether a finished run prints what it wrote.
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
    pub(super) fn new(folder: PathBuf, flags: Flags) -> Result<Self, CliError> {
        let pictures = flags.comparing.reference.clone().map(References::Folder);
        let references = pictures.or(flags.grading.commands.clone().map(References::Commands));
        let references = references.ok_or_else(|| CliError::new("-grade needs -reference or -commands"))?;
        Ok(Self {
            folder,
            references,
            threads: flags.other.threads.map(|threads| threads as usize),
            tolerance: tolerance(&flags.comparing)?,
            progress: ShowProgress::new(&flags),
            report: flags.grading.report,
        })
    }

    /// The page and the table beside it, if they are written.
    pub fn report_files(&self) -> Option<[PathBuf; 2]> {
        let page = self.report.as_ref()?;
        Some([page.clone(), page.with_extension("csv")])
    }
}

impl ErrorReporting {
    /// The page and the table.
    pub fn report_files(&self) -> [PathBuf; 2] {
        ["report.html", "report.csv"].map(|name| self.folder.join(name))
    }
}
