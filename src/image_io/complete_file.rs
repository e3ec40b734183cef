//! Files that are complete, and get their names together.
//!
//! Until then a file has no name, so that it vanishes however the program ends. Where the system has no such files, its
//! content is copied to a file with a temporary name, in a moment in which no signal ends the program.

use super::error::ImageError;
use super::output::{Target, folder_of};
use super::spool::Spool;
use crate::memory;
use crate::undisturbed::undisturbed;
use std::fs::{File, OpenOptions, Permissions};
use std::io::{self, Seek};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// A file with all of its content that has not been put in its place yet.
#[must_use = "the file gets its name when it is put in its place"]
#[derive(Debug)]
pub struct CompleteFile {
    /// The path as the user gave it, for messages.
    path: PathBuf,
    content: Content,
}

#[derive(Debug)]
enum Content {
    /// Of a regular file.
    Regular(Nameless),
    /// Of a pipe, a device or standard output.
    Stream(Target, Spool),
}

/// The content of a regular file.
#[derive(Debug)]
struct Nameless {
    file: File,
    /// The place of the file, with links resolved.
    target: PathBuf,
    /// Those of the file that is replaced, if there is one.
    permissions: Option<Permissions>,
}

impl CompleteFile {
    /// A file with this content. That of a regular file is written to the disk.
    pub(super) fn new(path: PathBuf, target: Target, content: Spool) -> Result<Self, ImageError> {
        let content = match target {
            Target::Replace { file: target, permissions } => {
                let write = || {
                    let mut file = nameless_file(folder_of(&target))?;
                    content.copy_to(&mut file)?;
                    io::Result::Ok(file)
                };
                let file = write().map_err(|error| ImageError::io("write", &path, error))?;
                Content::Regular(Nameless { file, target, permissions })
            }
            stream => Content::Stream(stream, content),
        };
        Ok(Self { path, content })
    }

    /// Whether it is written to a pipe, a device or standard output.
    pub fn is_stream(&self) -> bool {
        matches!(self.content, Content::Stream(..))
    }

    /// Writes the content of a pipe, a device or standard output, which may wait for a reader. A regular file stays as
    /// it is.
    pub fn write_stream(self) -> Result<Option<Self>, ImageError> {
        let Content::Stream(target, content) = self.content else { return Ok(Some(self)) };
        let written = match target {
            Target::Direct(file) => content.copy_to(file),
            Target::StandardOutput => content.copy_to(io::stdout().lock()),
            Target::Replace { .. } => Ok(()),
        };
        written.map(|()| None).map_err(|error| ImageError::io("write", &self.path, error))
    }

    /// Puts this file alone in its place.
    pub fn put_in_place(self) -> Result<(), ImageError> {
        put_in_place(vec![self])
    }
}

/// Puts files in their places, the pipes, devices and standard output first. If one fails, no regular file is replaced
/// or made.
///
/// They are not flushed to the disk first, because that takes many times as long as rendering a small picture.
pub fn put_in_place(files: Vec<CompleteFile>) -> Result<(), ImageError> {
    let mut regular = Vec::with_capacity(files.len());
    for file in files {
        if let Some(CompleteFile { path, content: Content::Regular(file) }) = file.write_stream()? {
            regular.push((path, file));
        }
    }
    if regular.is_empty() {
        return Ok(());
    }
    // A program that ends for want of memory removes nothing.
    memory::ask(WORKING_MEMORY).map_err(|error| ImageError::io("write", &regular[0].0, error.into()))?;
    undisturbed(|| name_all(regular))
}

/// The memory that is taken while there are temporary names, in bytes: names and a buffer, with much to spare.
const WORKING_MEMORY: u64 = 1 << 20;

/// Gives all files their names, or none.
fn name_all(mut files: Vec<(PathBuf, Nameless)>) -> Result<(), ImageError> {
    let failed = |path: &Path, error| ImageError::io("write", path, error);
    // What has a name already is removed when an error ends this.
    let (mut new, mut beside) = (Vec::new(), Vec::new());
    for (path, file) in &mut files {
        match file.name_new().map_err(|error| failed(path, error))? {
            Some(named) => new.push(named),
            None => {
                let named = file.name_beside().map_err(|error| failed(path, error))?;
                beside.push((named, &file.target, &*path));
            }
        }
    }
    // Whatever may fail has been done: these have their room in the folder.
    for (named, target, path) in beside {
        named.persist(target).map_err(|error| failed(path, error.error))?;
    }
    for named in new {
        // The name is kept from now on.
        let _ = named.keep();
    }
    Ok(())
}

impl Nameless {
    /// Gives the file its own name, unless a file has it or the system cannot do so.
    fn name_new(&self) -> io::Result<Option<TempPath>> {
        if self.permissions.is_some() || !is_linked(&self.file, &self.target) {
            return Ok(None);
        }
        TempPath::try_from_path(&self.target).map(Some)
    }

    /// Gives the file a temporary name beside its own.
    fn name_beside(&mut self) -> io::Result<TempPath> {
        let named =
            temporary_names().make_in(folder_of(&self.target), |path| match is_linked(&self.file, path) {
                true => Ok(None),
                false => new_file(path).map(Some),
            })?;
        let (copy, named) = named.into_parts();
        if let Some(mut copy) = copy {
            self.file.rewind()?;
            io::copy(&mut self.file, &mut copy)?;
            self.file = copy;
        }
        if let Some(permissions) = &self.permissions {
            self.file.set_permissions(permissions.clone())?;
        }
        Ok(named)
    }
}

/// Checks that a file can be made in this folder, by making one.
pub(super) fn check_folder(folder: &Path) -> io::Result<()> {
    nameless_file(folder).map(drop)
}

/// A new file without a name on the disk of a folder, with the permissions of any new file.
pub(super) fn nameless_file(folder: &Path) -> io::Result<File> {
    match without_name(folder) {
        Some(result) => result,
        // It has a name for a moment.
        None => {
            memory::ask(WORKING_MEMORY)?;
            undisturbed(|| temporary_names().make_in(folder, new_file).map(NamedTempFile::into_file))
        }
    }
}

/// Names of files and folders that are there for a moment.
pub(super) fn temporary_names() -> tempfile::Builder<'static, 'static> {
    let mut names = tempfile::Builder::new();
    names.prefix(".raytracer-");
    names
}

/// A file with the permissions of any new file, which must not exist.
fn new_file(path: &Path) -> io::Result<File> {
    OpenOptions::new().read(true).write(true).create_new(true).open(path)
}

/// A file that never had a name; none where the system or the disk has no such files.
#[cfg(target_os = "linux")]
fn without_name(folder: &Path) -> Option<io::Result<File>> {
    use rustix::fs::{Mode, OFlags, open};
    use rustix::io::Errno;
    const ANY_NEW_FILE: Mode = Mode::from_raw_mode(0o666);
    match open(folder, OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC, ANY_NEW_FILE) {
        Err(Errno::OPNOTSUPP | Errno::ISDIR | Errno::INVAL) => None,
        opened => Some(opened.map(File::from).map_err(io::Error::from)),
    }
}

#[cfg(not(target_os = "linux"))]
fn without_name(_: &Path) -> Option<io::Result<File>> {
    None
}

/// Gives a file without a name this one, and says whether that could be done.
#[cfg(target_os = "linux")]
fn is_linked(file: &File, path: &Path) -> bool {
    use rustix::fs::{AtFlags, CWD, linkat};
    use std::os::fd::AsRawFd;
    let source = format!("/proc/self/fd/{}", file.as_raw_fd());
    linkat(CWD, source, CWD, path, AtFlags::SYMLINK_FOLLOW).is_ok()
}

#[cfg(not(target_os = "linux"))]
fn is_linked(_: &File, _: &Path) -> bool {
    false
}
