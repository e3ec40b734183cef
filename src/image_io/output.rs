//! Output files: each appears under its name when it is complete, together with the others of a run.
//!
//! Until then the content is in memory or, if it is long, in a temporary file without a name, so that nothing is left
//! however the program ends. It gets a temporary name beside its target only to be renamed.

use super::format::{Content, Format};
use super::{cannot, unknown_ending};
use crate::base::escape::quoted;
use crate::base::memory;
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Picture};
use std::ffi::OsStr;
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use tempfile::{NamedTempFile, SpooledData, SpooledTempFile};

/// The longest content that is kept in memory, in bytes.
const IN_MEMORY: usize = 8 << 20;
/// Upper bound on the memory that is taken while files have temporary names, in bytes.
const WORKING_MEMORY: u64 = 1 << 20;

/// Held while files have temporary names, which would be left if the program ended then.
pub static NAMING: Mutex<()> = Mutex::new(());

/// A file that is known to be writable and has not been written yet.
pub struct OutputFile {
    /// The path as the user gave it, for messages.
    pub(super) path: PathBuf,
    target: Target,
}

/// A file with all of its content, which is not in its place yet.
#[must_use = "the file gets its name when it is put in its place"]
pub struct CompleteFile {
    pub(super) output: OutputFile,
    pub(super) content: SpooledTempFile,
}

/// The destination of a file.
enum Target {
    /// A regular file, with links resolved. If it exists, `permissions` are its own.
    Replace { file: PathBuf, permissions: Option<Permissions> },
    /// A pipe, a device or standard output, which is written to and not replaced by a file.
    Stream(Box<dyn Write + Send>),
}

impl OutputFile {
    /// Checks that a file can be written to `path`: its folder and the permissions. `-` is standard output.
    ///
    /// A pipe or a device is opened, which may block until there is a reader.
    pub fn prepare(path: &Path) -> Result<Self, Diagnostic> {
        if path == Path::new("-") {
            return Ok(Self::standard_output());
        }
        match Target::of(path) {
            Ok(target) => Ok(Self { path: path.to_owned(), target }),
            Err(reason) => Err(cannot("write", path, reason)),
        }
    }

    /// Returns the file that is written to standard output when it is complete.
    pub fn standard_output() -> Self {
        Self { path: "standard output".into(), target: Target::Stream(Box::new(io::stdout())) }
    }

    /// True for a pipe, a device or standard output.
    pub fn is_stream(&self) -> bool {
        matches!(self.target, Target::Stream(_))
    }

    /// Writes a picture in the format that the file's name tells. If this fails and the target is a regular file,
    /// nothing is written.
    pub fn write(self, picture: &Picture) -> Result<(), Diagnostic> {
        let format = self.written(Format::of(&self.path).ok_or_else(unknown_ending))?;
        self.picture(format, picture)?.put_in_place()
    }

    /// Returns the file with this picture.
    pub fn picture(self, format: Format, picture: &Picture) -> Result<CompleteFile, Diagnostic> {
        let size = [picture.width(), picture.height()].map(|side| side as usize);
        let mut writer = self.begin(format, size, Content::Colors, None)?;
        picture.pixels().chunks_exact(size[0] * CHANNELS).try_for_each(|row| writer.row_of_bytes(row))?;
        writer.complete()
    }

    /// Returns the file with this text.
    pub fn text(self, text: &str) -> Result<CompleteFile, Diagnostic> {
        let mut content = self.spool();
        self.written(content.write_all(text.as_bytes()))?;
        Ok(CompleteFile { output: self, content })
    }

    /// Returns an empty content, whose temporary file is on the disk of the target.
    pub(super) fn spool(&self) -> SpooledTempFile {
        match &self.target {
            Target::Replace { file, .. } => tempfile::spooled_tempfile_in(IN_MEMORY, folder_of(file)),
            Target::Stream(_) => tempfile::spooled_tempfile(IN_MEMORY),
        }
    }

    /// Adds to an error that this file cannot be written.
    pub(super) fn written<T>(&self, result: Result<T, impl Into<Diagnostic>>) -> Result<T, Diagnostic> {
        result.map_err(|reason| cannot("write", &self.path, reason))
    }
}

impl Target {
    fn of(path: &Path) -> Result<Self, Diagnostic> {
        let permissions = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(Diagnostic::error("it is a folder")),
            Ok(found) => {
                // A write-protected file is an error, although it could be replaced by renaming.
                let file = OpenOptions::new().write(true).open(path)?;
                if !found.is_file() {
                    return Ok(Self::Stream(Box::new(file)));
                }
                Some(found.permissions())
            }
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error.into()),
        };
        let file = follow_links(path)?;
        let folder = folder_of(&file);
        match tempfile::tempfile_in(folder) {
            Ok(_) => Ok(Self::Replace { file, permissions }),
            Err(error) if error.kind() == ErrorKind::NotFound && !folder.is_dir() => {
                Err(Diagnostic::error(format!("there is no folder {}", quoted(folder))))
            }
            Err(error) => Err(error.into()),
        }
    }
}

impl CompleteFile {
    /// True for a pipe, a device or standard output.
    pub fn is_stream(&self) -> bool {
        self.output.is_stream()
    }

    /// Writes the content of a pipe, a device or standard output, which may wait for a reader; one that has gone away
    /// has seen enough. Returns a regular file as it is.
    pub fn write_stream(self) -> Result<Option<Self>, Diagnostic> {
        let OutputFile { path, target: Target::Stream(stream) } = self.output else { return Ok(Some(self)) };
        match copy(self.content, stream) {
            Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(cannot("write", &path, error)),
            _ => Ok(None),
        }
    }

    /// Puts this file alone in its place.
    pub fn put_in_place(self) -> Result<(), Diagnostic> {
        put_in_place(vec![self])
    }

    /// Copies the content of a regular file to a file with a temporary name beside the target, which is returned too.
    fn name_beside(self) -> io::Result<Option<(NamedTempFile, PathBuf)>> {
        let Target::Replace { file: target, permissions } = self.output.target else { return Ok(None) };
        let new_file = |path: &Path| OpenOptions::new().read(true).write(true).create_new(true).open(path);
        let named = tempfile::Builder::new().prefix(".raytracer-").make_in(folder_of(&target), new_file)?;
        copy(self.content, named.as_file())?;
        permissions.map_or(Ok(()), |permissions| named.as_file().set_permissions(permissions))?;
        Ok(Some((named, target)))
    }
}

/// Puts files in their places, the pipes, devices and standard output first. If one fails, no regular file is replaced
/// or made.
///
/// They are not flushed to the disk first, because that takes many times as long as rendering a small picture.
pub fn put_in_place(files: Vec<CompleteFile>) -> Result<(), Diagnostic> {
    let mut regular = Vec::with_capacity(files.len());
    for file in files {
        regular.extend(file.write_stream()?);
    }
    // A program that ends for want of memory removes no temporary file.
    memory::ask(WORKING_MEMORY)?;
    let _naming = NAMING.lock().unwrap_or_else(PoisonError::into_inner);
    let mut named = Vec::with_capacity(regular.len());
    for file in regular {
        let path = file.output.path.clone();
        let beside = file.name_beside().map_err(|error| cannot("write", &path, error))?;
        named.extend(beside.map(|(file, target)| (path, file, target)));
    }
    named.into_iter().try_for_each(|(path, file, target)| match file.persist(target) {
        Ok(_) => Ok(()),
        Err(error) => Err(cannot("write", &path, error.error)),
    })
}

fn copy(content: SpooledTempFile, mut target: impl Write) -> io::Result<()> {
    match content.into_inner() {
        SpooledData::InMemory(bytes) => target.write_all(bytes.get_ref())?,
        SpooledData::OnDisk(mut file) => {
            file.rewind()?;
            io::copy(&mut file, &mut target)?;
        }
    }
    target.flush()
}

/// Returns the target of a symbolic link, whether it exists or not, or the path itself if it is no link.
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
