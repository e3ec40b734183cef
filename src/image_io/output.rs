//! Output files that are complete or not there at all.

use super::Format;
use super::error::ImageError;
use super::spool::Spool;
use super::writer::PictureWriter;
use crate::picture::{CHANNELS, Picture};
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A picture file that is known to be writable but not yet written.
///
/// The finished picture goes to a temporary file beside the target, which then takes the target's name in one step.
/// No file with a name stands on disk while the program renders, so that a program that is killed leaves nothing
/// behind.
#[derive(Debug)]
pub struct OutputFile {
    /// As the user named it, for messages.
    path: PathBuf,
    format: Format,
    target: Target,
}

/// What becomes the picture file.
#[derive(Debug)]
pub(super) enum Target {
    /// A regular file or none yet, links followed. `permissions` are those of the existing file.
    Replace { file: PathBuf, permissions: Option<Permissions> },
    /// A pipe or a device, which must not be replaced by a file.
    Direct(File),
}

impl OutputFile {
    /// Checks that a picture can be written to `path`: its ending, its folder, permissions.
    ///
    /// Opens a pipe or device, which waits for a reader where the system does so.
    pub fn prepare(path: &Path) -> Result<Self, ImageError> {
        let format = Format::of(path).ok_or_else(|| ImageError::Ending { path: path.to_owned() })?;
        let failed = |error| ImageError::io("write", path, error);
        let target = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(ImageError::Folder { path: path.to_owned() }),
            Ok(found) => existing(path, &found).map_err(failed)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Target::Replace { file: follow_links(path).map_err(failed)?, permissions: None }
            }
            Err(error) => return Err(failed(error)),
        };
        target.probe().map_err(failed)?;
        Ok(Self { path: path.to_owned(), format, target })
    }

    /// Begins a picture of this width and height in pixels. Its file appears when it is finished.
    pub fn begin(self, size: [usize; 2]) -> Result<PictureWriter, ImageError> {
        PictureWriter::new(self.path, self.format, self.target, size)
    }

    /// Writes the whole picture or, where the target is a regular file, nothing at all.
    pub fn write(self, picture: &Picture) -> Result<(), ImageError> {
        let mut writer = self.begin([picture.width() as usize, picture.height() as usize])?;
        let rows = picture.pixels().chunks_exact(picture.width() as usize * CHANNELS);
        rows.into_iter().try_for_each(|row| writer.row_of_bytes(row))?;
        writer.finish().map(drop)
    }
}

impl Target {
    /// Where bytes may wait for the picture to be complete: on the disk that will hold them.
    pub(super) fn folder(&self) -> PathBuf {
        match self {
            Self::Replace { file, .. } => folder_of(file).to_owned(),
            Self::Direct(_) => std::env::temp_dir(),
        }
    }

    /// Takes the whole content.
    pub(super) fn fill(self, content: Spool) -> io::Result<()> {
        match self {
            Self::Direct(file) => content.copy_to(&file),
            Self::Replace { file, permissions } => {
                let temporary = temporary_beside(&file)?;
                content.copy_to(temporary.as_file())?;
                install(temporary, &file, permissions.as_ref())
            }
        }
    }

    /// Finds out whether a file can be made beside the target, by making one.
    fn probe(&self) -> io::Result<()> {
        match self {
            Self::Replace { file, .. } => temporary_beside(file).map(drop),
            Self::Direct(_) => Ok(()),
        }
    }
}

/// Opening without cutting finds a write-protected file, which a rename would replace regardless.
fn existing(path: &Path, found: &Metadata) -> io::Result<Target> {
    let file = OpenOptions::new().write(true).open(path)?;
    match found.is_file() {
        true => Ok(Target::Replace { file: fs::canonicalize(path)?, permissions: Some(found.permissions()) }),
        false => Ok(Target::Direct(file)),
    }
}

/// Where a link to a file that does not exist yet leads; the path itself if it is no link.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    const MOST: usize = 40;
    let mut target = path.to_owned();
    for _ in 0..MOST {
        match fs::read_link(&target) {
            Ok(next) => target = folder_of(&target).join(next),
            // Not a link, or nothing there.
            Err(_) => return Ok(target),
        }
    }
    Err(io::Error::other("too many links"))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != OsStr::new("") => folder,
        _ => Path::new("."),
    }
}

/// A new file in the target's folder with a new file's usual permissions, removed when dropped.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    let open = |path: &Path| OpenOptions::new().write(true).create_new(true).open(path);
    tempfile::Builder::new().prefix(".raytracer-").make_in(folder_of(target), open)
}

/// Gives the complete file its name. It is not forced to the disk first: that takes many times as
/// long as a small picture takes to render.
fn install(temporary: NamedTempFile, target: &Path, permissions: Option<&Permissions>) -> io::Result<()> {
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions.clone())?;
    }
    temporary.persist(target).map(drop).map_err(|error| error.error)
}
