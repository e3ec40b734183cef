//! Output files, which are either complete or not written at all.

use super::Format;
use super::complete_file::{CompleteFile, check_folder};
use super::error::ImageError;
use super::float_rows::Content;
use super::part::Part;
use super::writer::PictureWriter;
use crate::picture::{CHANNELS, Picture};
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::path::{Path, PathBuf};

/// A picture file that is known to be writable and has not been written yet.
///
/// The finished picture is a [`CompleteFile`], which is put in its place in one step, alone or with others. A program
/// that is killed before leaves nothing behind.
#[derive(Debug)]
pub struct OutputFile {
    /// The path as the user gave it, for messages.
    path: PathBuf,
    format: Format,
    target: Target,
}

/// The destination of a file.
#[derive(Debug)]
pub(super) enum Target {
    /// A regular file, which need not exist yet, with links resolved. `permissions` are those of an existing
    /// file.
    Replace { file: PathBuf, permissions: Option<Permissions> },
    /// A pipe or a device, which is written to and not replaced by a file.
    Direct(File),
    /// Standard output.
    StandardOutput,
}

impl OutputFile {
    /// Checks that a picture can be written to `path`: its extension, its folder and the permissions.
    ///
    /// A pipe or a device is opened, which may block until there is a reader.
    pub fn prepare(path: &Path) -> Result<Self, ImageError> {
        let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
        Self::prepare_as(path, format)
    }

    /// Checks like [`prepare`](Self::prepare) that a picture can be written to `path`, whatever the name ends in.
    pub fn prepare_as(path: &Path, format: Format) -> Result<Self, ImageError> {
        Ok(Self { path: path.to_owned(), format, target: Target::prepare(path)? })
    }

    /// A picture that is written to standard output when it is finished.
    pub fn standard_output(format: Format) -> Self {
        Self { path: "standard output".into(), format, target: Target::StandardOutput }
    }

    /// Starts a picture of this width and height in pixels. Its file is written when the picture is finished, and says
    /// which part of a larger picture it is, if it is one.
    pub fn begin(self, size: [usize; 2], part: Option<&Part>) -> Result<PictureWriter, ImageError> {
        self.begin_with(size, Content::Colors, part)
    }

    /// Starts a picture like [`begin`](Self::begin), whose colours mean this.
    pub fn begin_with(
        self,
        size: [usize; 2],
        content: Content,
        part: Option<&Part>,
    ) -> Result<PictureWriter, ImageError> {
        PictureWriter::new(self.path, self.format, self.target, size, content, part)
    }

    /// Writes a picture. If this fails and the target is a regular file, nothing is written.
    pub fn write(self, picture: &Picture) -> Result<(), ImageError> {
        self.complete(picture)?.put_in_place()
    }

    /// The file of a picture.
    pub fn complete(self, picture: &Picture) -> Result<CompleteFile, ImageError> {
        let mut writer = self.begin([picture.width() as usize, picture.height() as usize], None)?;
        let rows = picture.pixels().chunks_exact(picture.width() as usize * CHANNELS);
        rows.into_iter().try_for_each(|row| writer.row_of_bytes(row))?;
        writer.complete()
    }
}

impl Target {
    /// Checks that a file can be written to `path`: its folder and the permissions.
    pub(super) fn prepare(path: &Path) -> Result<Self, ImageError> {
        let failed = |error| ImageError::io("write", path, error);
        let target = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(ImageError::Folder { path: path.to_owned() }),
            Ok(found) => existing(path, &found).map_err(failed)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Self::Replace { file: follow_links(path).map_err(failed)?, permissions: None }
            }
            Err(error) => return Err(failed(error)),
        };
        match target.probe() {
            Err(error) if error.kind() == io::ErrorKind::NotFound && !target.folder().is_dir() => {
                let folder = target.folder();
                Err(ImageError::NoFolder { path: path.to_owned(), folder })
            }
            probed => probed.map_err(failed).map(|()| target),
        }
    }

    /// The folder for temporary files, which is on the disk of the target if that is a regular file.
    pub(super) fn folder(&self) -> PathBuf {
        match self {
            Self::Replace { file, .. } => folder_of(file).to_owned(),
            Self::Direct(_) | Self::StandardOutput => std::env::temp_dir(),
        }
    }

    /// Checks that a file can be created in the target's folder.
    fn probe(&self) -> io::Result<()> {
        match self {
            Self::Replace { file, .. } => check_folder(folder_of(file)),
            Self::Direct(_) | Self::StandardOutput => Ok(()),
        }
    }
}

/// The target for an existing file, pipe or device. It is opened for writing, without truncation, because a
/// write-protected file is an error, although it could be replaced by renaming.
fn existing(path: &Path, found: &Metadata) -> io::Result<Target> {
    let file = OpenOptions::new().write(true).open(path)?;
    match found.is_file() {
        true => Ok(Target::Replace { file: fs::canonicalize(path)?, permissions: Some(found.permissions()) }),
        false => Ok(Target::Direct(file)),
    }
}

/// The target of a symbolic link to a file that does not exist yet; the path itself if it is no link.
pub(super) fn follow_links(path: &Path) -> io::Result<PathBuf> {
    const MAX_LINKS: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            // The target is not a link, or does not exist.
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many links"))
}

pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != OsStr::new("") => folder,
        _ => Path::new("."),
    }
}
