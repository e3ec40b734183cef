//! What a run reads it never writes, and no file is written twice: the files of a run are listed and compared, whatever
//! their names are.

use crate::cli::{Converting, ErrorReporting, Grading, Merging, Options, Output, References};
use crate::escape::quoted;
use crate::image_io::{FileId, part_beside};
use crate::render::Layer;
use crate::scene_io::LoadedScene;
use std::fmt;
use std::path::{Path, PathBuf};

/// The files that a run writes, which differ.
#[derive(Debug)]
pub struct WrittenFiles(Vec<(Written, Option<FileId>)>);

/// A file that a run writes.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Written {
    /// A file with this name.
    Named(PathBuf),
    /// The complete rows of this picture, if the run is stopped.
    PartOf(PathBuf, PathBuf),
    /// A picture or text.
    StandardOutput,
}

/// A file that a run writes and that is one of its other files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SameFile {
    written: Written,
    other: Other,
}

/// What else the file is.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Other {
    Written(Written),
    Read(ReadAs, PathBuf),
}

/// What a file is read for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadAs {
    /// A scene.
    Scene,
    /// A mesh that a scene names.
    Mesh,
    /// A picture, to compare with another or to convert.
    Picture,
    /// A part of a picture.
    Part,
    /// A list of command lines.
    Commands,
}

impl WrittenFiles {
    /// Those of a run that renders or compares. An error also if one of them is the scene or a picture to compare.
    pub fn of_rendering(options: &Options) -> Result<Self, SameFile> {
        let comparison = options.comparison.as_ref();
        let mut all: Vec<Written> = options.outputs.iter().map(Written::output).collect();
        all.extend(comparison.and_then(|wanted| wanted.difference.clone()).map(Written::Named));
        all.extend(options.json_file().map(|file| Written::Named(file.to_owned())));
        if options.needs_standard_output() && !options.has_standard_output() {
            all.push(Written::StandardOutput);
        }
        // One that is not there can only be another file that is written.
        let has_others = all.len() > 1;
        let parts = options.outputs.iter().filter_map(Written::part);
        all.extend(
            parts
                .filter(|(_, part)| has_others || part.exists())
                .map(|(picture, part)| Written::PartOf(picture, part)),
        );
        let files = Self::distinct(all)?;
        let pictures = comparison.into_iter().flat_map(|wanted| [&wanted.picture, &wanted.reference]);
        options.input.iter().try_for_each(|scene| files.check_read(ReadAs::Scene, scene))?;
        pictures.flatten().try_for_each(|picture| files.check_read(ReadAs::Picture, picture))?;
        Ok(files)
    }

    /// That of a run that puts parts together. An error also if it is one of the parts.
    pub fn of_merging(merging: &Merging) -> Result<Self, SameFile> {
        let files = Self::distinct(vec![Written::output(&merging.output)])?;
        merging.parts.iter().try_for_each(|part| files.check_read(ReadAs::Part, part))?;
        Ok(files)
    }

    /// That of a run that writes a picture in another format. An error also if it is that picture.
    pub fn of_converting(converting: &Converting) -> Result<Self, SameFile> {
        let files = Self::distinct(vec![Written::output(&converting.output)])?;
        files.check_read(ReadAs::Picture, &converting.picture).map(|()| files)
    }

    /// Those of a run that grades. An error also if one of them is the list of command lines.
    pub fn of_grading(grading: &Grading) -> Result<Self, SameFile> {
        let report = grading.report_files().into_iter().flatten().map(Written::Named);
        let files = Self::distinct(report.chain([Written::StandardOutput]).collect())?;
        if let References::Commands(commands) = &grading.references {
            files.check_read(ReadAs::Commands, commands)?;
        }
        Ok(files)
    }

    /// Those of a run that reports errors. An error also if one of them is the scene.
    pub fn of_error_reporting(reporting: &ErrorReporting) -> Result<Self, SameFile> {
        let report = reporting.report_files().map(Written::Named);
        let files = Self::distinct(report.into_iter().chain([Written::StandardOutput]).collect())?;
        reporting.options.input.iter().try_for_each(|scene| files.check_read(ReadAs::Scene, scene))?;
        Ok(files)
    }

    /// Those of a page that saves these pictures.
    pub fn of_saving(outputs: &[Output]) -> Result<Self, SameFile> {
        Self::distinct(outputs.iter().map(Written::output).collect())
    }

    fn distinct(all: Vec<Written>) -> Result<Self, SameFile> {
        let files: Vec<_> =
            all.into_iter().map(|file| (file.id(), file)).map(|(id, file)| (file, id)).collect();
        for (index, (written, id)) in files.iter().enumerate() {
            let is_same = |(_, other): &&(Written, Option<FileId>)| id.is_some() && id == other;
            if let Some((other, _)) = files[..index].iter().find(is_same) {
                return Err(SameFile { written: other.clone(), other: Other::Written(written.clone()) });
            }
        }
        Ok(Self(files))
    }

    /// An error if one of the files is this one, which is read.
    pub fn check_read(&self, kind: ReadAs, path: &Path) -> Result<(), SameFile> {
        if !self.may_be_read() {
            return Ok(());
        }
        let Some(read) = FileId::of(if path == Path::new("-") { Path::new("/dev/stdin") } else { path })
        else {
            return Ok(());
        };
        match self.0.iter().find(|(_, id)| id.as_ref() == Some(&read)) {
            Some((written, _)) => {
                Err(SameFile { written: written.clone(), other: Other::Read(kind, path.to_owned()) })
            }
            None => Ok(()),
        }
    }

    /// An error if one of the files is a mesh or a picture that the scene names.
    pub fn check_loaded(&self, loaded: &LoadedScene) -> Result<(), SameFile> {
        loaded.mesh_files.iter().try_for_each(|mesh| self.check_read(ReadAs::Mesh, mesh))?;
        let mut pictures = loaded.scene.images.iter().filter_map(|image| image.file.as_deref());
        pictures.try_for_each(|picture| self.check_read(ReadAs::Picture, picture))
    }

    /// Whether one of the files exists: what does not cannot be read.
    pub fn may_be_read(&self) -> bool {
        self.0.iter().any(|(_, id)| id.as_ref().is_some_and(FileId::exists))
    }
}

impl Written {
    fn output(output: &Output) -> Self {
        if output.is_standard_output() { Self::StandardOutput } else { Self::Named(output.file.clone()) }
    }

    /// A picture and what a stopped run writes in place of it, if it does.
    fn part(output: &Output) -> Option<(PathBuf, PathBuf)> {
        let has_parts =
            !output.is_standard_output() && !matches!(output.layer, Layer::Filter { .. } | Layer::Cost(_));
        let part = part_beside(&output.file, output.format).filter(|_| has_parts)?;
        Some((output.file.clone(), part))
    }

    fn id(&self) -> Option<FileId> {
        FileId::of(match self {
            Self::Named(path) | Self::PartOf(_, path) => path,
            Self::StandardOutput => Path::new("/dev/stdout"),
        })
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(path) => f.write_str(&quoted(path)),
            Self::PartOf(picture, part) => {
                write!(f, "{}, where a stopped run keeps rows of {},", quoted(part), quoted(picture))
            }
            Self::StandardOutput => f.write_str("standard output"),
        }
    }
}

impl fmt::Display for SameFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { written, other } = self;
        match other {
            Other::Written(other) if other == written => write!(f, "{written} would be written twice"),
            Other::Written(part @ Written::PartOf(..)) => write!(f, "{part} is also {written}"),
            Other::Written(other) => write!(f, "{written} and {other} are the same file"),
            Other::Read(kind, path) => {
                let kind = match kind {
                    ReadAs::Scene => "scene",
                    ReadAs::Mesh => "mesh",
                    ReadAs::Picture => "picture",
                    ReadAs::Part => "part",
                    ReadAs::Commands => "list of commands",
                };
                let read = if path == Path::new("-") { "standard input".into() } else { quoted(path) };
                write!(f, "{written} is the {kind} {read}, which would be lost")
            }
        }
    }
}

impl std::error::Error for SameFile {}
