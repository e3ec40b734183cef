//! Output files, which are either complete or not written at all.

use super::Format;
use super::error::ImageError;
use super::float_rows::Content;
use super::part::Part;
use super::spool::Spool;
use super::writer::PictureWriter;
use crate::memory;
use crate::picture::{CHANNELS, Picture};
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A picture file that is known to be writable and has not been written yet.
///
/// The finished picture is written to a temporary file in the target's folder, which is then renamed to the
/// target in one step. There is no such file while the program renders, so that a program that is killed
/// leaves nothing behind.
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
        let mut writer = self.begin([picture.width() as usize, picture.height() as usize], None)?;
        let rows = picture.pixels().chunks_exact(picture.width() as usize * CHANNELS);
        rows.into_iter().try_for_each(|row| writer.row_of_bytes(row))?;
        writer.finish()
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
        target.probe().map_err(failed)?;
        Ok(target)
    }

    /// The folder for temporary files, which is on the disk of the target if that is a regular file.
    pub(super) fn folder(&self) -> PathBuf {
        match self {
            Self::Replace { file, .. } => folder_of(file).to_owned(),
            Self::Direct(_) | Self::StandardOutput => std::env::temp_dir(),
        }
    }

    /// Writes the complete content.
    pub(super) fn fill(self, content: Spool) -> io::Result<()> {
        match self {
            Self::Direct(file) => content.copy_to(&file),
            Self::StandardOutput => content.copy_to(io::stdout().lock()),
            Self::Replace { file, permissions } => {
                let temporary = temporary_beside(&file)?;
                content.copy_to(temporary.as_file())?;
                install(temporary, &file, permissions.as_ref())
            }
        }
    }

    /// Checks that a file can be created in the target's folder, by creating one.
    fn probe(&self) -> io::Result<()> {
        match self {
            Self::Replace { file, .. } => temporary_beside(file).map(drop),
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

/// The memory that is taken while there is a temporary file, in bytes: names and a buffer, with much to spare.
const WORKING_MEMORY: u64 = 1 << 20;

/// A new file in the target's folder, with the permissions of any new file. It is removed when it is dropped.
fn temporary_beside(target: &Path) -> io::Result<NamedTempFile> {
    // A program that ends for want of memory removes nothing.
    memory::ask(WORKING_MEMORY)?;
    let open = |path: &Path| OpenOptions::new().write(true).create_new(true).open(path);
    tempfile::Builder::new().prefix(".raytracer-").make_in(folder_of(target), open)
}

/// Renames the complete file to the target. It is not flushed to the disk first, because that takes many
/// times as long as rendering a small picture.
fn install(temporary: NamedTempFile, target: &Path, permissions: Option<&Permissions>) -> io::Result<()> {
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions.clone())?;
    }
    temporary.persist(target).map(drop).map_err(|error| error.error)
}
