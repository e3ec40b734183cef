//! Output files: each appears under its name when it is complete, together with the others of a run.
//!
//! Until then the content is in memory or, if it is long, in a temporary file without a name, so that nothing is left
//! however the program ends. It gets a temporary name beside its target only to be renamed.

use super::cannot;
use super::format::{Content, Format};
use crate::base::escape::quoted;
use crate::base::stdio::is_stdio;
use crate::base::{lock, memory};
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Picture};
use std::ffi::OsStr;
use std::fs::{self, File, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::{NamedTempFile, SpooledData, SpooledTempFile, TempPath};

/// The longest content that is kept in memory, in bytes.
const IN_MEMORY: usize = 8 << 20;
/// Upper bound on the memory that is taken while files have temporary names, in bytes.
const WORKING_MEMORY: u64 = 1 << 20;

/// The start of temporary names.
const PREFIX: &str = ".raytracer-";
/// The problem of an output whose name a folder has.
const FOLDER: &str = "it is a folder";

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
        if is_stdio(path) {
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

    /// Returns the file with this picture.
    pub fn picture(self, format: Format, picture: &Picture) -> Result<CompleteFile, Diagnostic> {
        let size = picture.size();
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
        let earlier = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(Diagnostic::error(FOLDER)),
            Ok(found) => {
                // A write-protected file is an error, although it could be replaced by renaming.
                let file = OpenOptions::new().write(true).open(path)?;
                if !found.is_file() {
                    return Ok(Self::Stream(Box::new(file)));
                }
                Some((file, found))
            }
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            Err(error) => return Err(error.into()),
        };
        let file = follow_links(path)?;
        let folder = folder_of(&file);
        let trial = match tempfile::tempfile_in(folder) {
            Ok(trial) => trial,
            Err(error) if error.kind() == ErrorKind::NotFound && !folder.is_dir() => {
                return Err(Diagnostic::error(format!("there is no folder {}", quoted(folder))));
            }
            Err(error) => return Err(error.into()),
        };
        if let Some((earlier, found)) = &earlier {
            check_replaceable(earlier, found, folder, &trial)?;
        }
        Ok(Self::Replace { file, permissions: earlier.map(|(_, found)| found.permissions()) })
    }
}

/// Checks that a file can be replaced by renaming another one in its folder. `trial` is a file of this process there.
#[cfg(unix)]
fn check_replaceable(file: &File, found: &Metadata, folder: &Path, trial: &File) -> Result<(), Diagnostic> {
    use std::os::unix::fs::MetadataExt;
    const STICKY: u32 = 0o1000;
    let others = File::open(folder).ok().and_then(|folder| mount_of(&folder));
    if others.is_some() && mount_of(file).is_some_and(|own| Some(own) != others) {
        let problem = Diagnostic::error("it is mounted alone, so no other file can take its place");
        return Err(problem.with_hint("mount its folder, or write elsewhere and copy"));
    }
    let (folder, own) = (fs::metadata(folder)?, trial.metadata()?.uid());
    if folder.mode() & STICKY != 0 && ![0, found.uid(), folder.uid()].contains(&own) {
        return Err(Diagnostic::error(
            "it belongs to another user, in a folder where only that user can replace it",
        ));
    }
    Ok(())
}

#[cfg(not(unix))]
fn check_replaceable(_: &File, _: &Metadata, _: &Path, _: &File) -> Result<(), Diagnostic> {
    Ok(())
}

/// Returns the number of the mount that an open file belongs to, where the system tells.
#[cfg(unix)]
fn mount_of(file: &File) -> Option<String> {
    use std::os::fd::AsRawFd;
    let described = fs::read_to_string(format!("/proc/self/fdinfo/{}", file.as_raw_fd())).ok()?;
    described.lines().find_map(|line| line.strip_prefix("mnt_id:")).map(|number| number.trim().to_owned())
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
        let named = tempfile::Builder::new().prefix(PREFIX).make_in(folder_of(&target), new_file)?;
        copy(self.content, named.as_file())?;
        permissions.map_or(Ok(()), |permissions| named.as_file().set_permissions(permissions))?;
        Ok(Some((named, target)))
    }
}

/// Puts files in their places, the pipes, devices and standard output first. If one fails, no regular file is replaced
/// or made: new files are removed, and files already replaced are restored.
///
/// They are not flushed to the disk first, because that takes many times as long as rendering a small picture.
pub fn put_in_place(files: Vec<CompleteFile>) -> Result<(), Diagnostic> {
    let mut regular = Vec::with_capacity(files.len());
    for file in files {
        regular.extend(file.write_stream()?);
    }
    // A program that ends for want of memory removes no temporary file.
    memory::ask(WORKING_MEMORY)?;
    let _naming = lock(&NAMING);
    let mut named = Vec::with_capacity(regular.len());
    for file in regular {
        let path = file.output.path.clone();
        let beside = file.name_beside().map_err(|error| cannot("write", &path, error))?;
        named.extend(beside.map(|(file, target)| (path, file, target)));
    }
    let mut replaced: Vec<Replaced> = Vec::with_capacity(named.len());
    let last = named.len().saturating_sub(1);
    for (index, (path, file, target)) in named.into_iter().enumerate() {
        let named = Replaced::keep(&target, index < last).and_then(|kept| {
            replaced.push(kept);
            file.persist(&target).map_err(|error| error.error)
        });
        match named {
            Ok(_) => replaced[index].is_replaced = true,
            Err(error) => {
                let error = cannot("write", &path, error);
                let failures = replaced.into_iter().rev().filter_map(Replaced::put_back);
                return Err(failures.fold(error, Diagnostic::with_hint));
            }
        }
    }
    Ok(())
}

/// The place of a file, before and after the file is put there.
struct Replaced {
    target: PathBuf,
    /// The second name of the file that was there before, if there was one.
    earlier: Option<TempPath>,
    is_replaced: bool,
}

impl Replaced {
    /// Gives the file at `target` a second name, if there is one and it may have to be put back.
    fn keep(target: &Path, may_return: bool) -> io::Result<Self> {
        let is_there = match fs::symlink_metadata(target) {
            Ok(found) if found.is_dir() => return Err(io::Error::other(FOLDER)),
            Ok(_) => may_return,
            Err(error) if error.kind() == ErrorKind::NotFound => false,
            Err(error) => return Err(error),
        };
        let second_name = |path: &Path| match fs::hard_link(target, path) {
            // On a disk without second names the file has no other until the next one takes its place.
            Err(error) if error.kind() != ErrorKind::AlreadyExists => fs::rename(target, path),
            linked => linked,
        };
        let mut names = tempfile::Builder::new();
        names.prefix(PREFIX);
        let earlier = is_there.then(|| names.make_in(folder_of(target), second_name)).transpose()?;
        let earlier = earlier.map(NamedTempFile::into_temp_path);
        Ok(Self { target: target.to_owned(), earlier, is_replaced: false })
    }

    /// Restores the earlier file, or removes the new one. Returns advice if that fails.
    fn put_back(self) -> Option<String> {
        let target = quoted(&self.target);
        let Some(earlier) = self.earlier else {
            let removed = if self.is_replaced { fs::remove_file(&self.target) } else { Ok(()) };
            return removed.err().map(|error| format!("{target} could not be taken away again: {error}"));
        };
        // If both are names of one file, this does nothing, and the second name is removed when it is dropped.
        let error = fs::rename(&earlier, &self.target).err()?;
        let kept = earlier.keep().map(quoted).unwrap_or_default();
        Some(format!("{target} could not be put back, and is kept as {kept}: {error}"))
    }
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
