//! The flags about the grading of a folder.

use super::error::CliError;
use super::flag::Run;
use super::flags;
use super::options::ShowProgress;
use super::raw::Raw;
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
        let Some(folder) = raw.read(&flags::GRADE)? else {
            return raw.refuse_without(&flags::GRADE).map(|()| None);
        };
        raw.refuse_others(&flags::GRADE, Run::Grade)?;
        let folder_of_references = raw.values(&flags::REFERENCE).map(|values| values.path()).transpose()?;
        let references = match (folder_of_references, raw.read(&flags::COMMANDS)?) {
            (Some(folder), _) => References::Folder(folder),
            (None, Some(file)) => References::Commands(file),
            (None, None) => return Err(CliError::ReferencesNeeded),
        };
        Ok(Some(Self {
            folder,
            references,
            threads: raw.read(&flags::THREADS)?,
            report: raw.read(&flags::REPORT)?,
            tolerance: raw.read(&flags::TOLERANCE)?,
            progress: ShowProgress::from_raw(raw),
        }))
    }
}
