//! The flags about the grading of a folder.

use super::comparison::tolerance;
use super::error::{CliError, Problem};
use super::flags::{self, Flag};
use super::options::{ShowProgress, THREAD_RANGE};
use super::raw::Raw;
use super::values::{bad, ends_in, wholes};
use crate::tools::compare::Tolerance;
use std::path::{Path, PathBuf};

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

/// The flags that a grading understands.
const UNDERSTOOD: [&Flag; 8] = [
    &flags::GRADE,
    &flags::REFERENCE,
    &flags::COMMANDS,
    &flags::REPORT,
    &flags::TOLERANCE,
    &flags::THREADS,
    &flags::PROGRESS,
    &flags::QUIET,
];

impl Grading {
    /// The page and the table beside it, if they are written.
    pub fn report_files(&self) -> Option<[PathBuf; 2]> {
        let page = self.report.as_ref()?;
        Some([page.clone(), page.with_extension("csv")])
    }

    /// The file of the command lines, if the references are rendered.
    pub fn commands(&self) -> Option<&Path> {
        match &self.references {
            References::Commands(file) => Some(file),
            References::Folder(_) => None,
        }
    }

    /// The grading that the flags ask for, if they do.
    pub(super) fn from_raw(raw: &Raw) -> Result<Option<Self>, CliError> {
        let path = |flag| Ok(raw.values(flag)?.map(|[word]| PathBuf::from(word)));
        let Some(folder) = path(&flags::GRADE)? else { return refuse_without_folder(raw) };
        raw.refuse_others(&flags::GRADE, &UNDERSTOOD)?;
        let references = match (path(&flags::REFERENCE)?, path(&flags::COMMANDS)?) {
            (Some(folder), _) => References::Folder(folder),
            (None, Some(file)) => References::Commands(file),
            (None, None) => return Err(CliError::ReferencesNeeded),
        };
        let threads = wholes(raw, &flags::THREADS, THREAD_RANGE)?.map(|[n]| n as usize);
        let (report, tolerance, progress) = (report(raw)?, tolerance(raw)?, ShowProgress::from_raw(raw));
        Ok(Some(Self { folder, references, report, tolerance, threads, progress }))
    }
}

fn refuse_without_folder(raw: &Raw) -> Result<Option<Grading>, CliError> {
    match [&flags::COMMANDS, &flags::REPORT].into_iter().find(|flag| raw.given(flag)) {
        Some(flag) => Err(CliError::GradeNeeded { flag: flag.name }),
        None => Ok(None),
    }
}

fn report(raw: &Raw) -> Result<Option<PathBuf>, CliError> {
    match raw.values(&flags::REPORT)? {
        Some([word]) if !ends_in(word, ".html") => Err(bad(&flags::REPORT, word, Problem::NotPage)),
        words => Ok(words.map(|[word]| word.into())),
    }
}
