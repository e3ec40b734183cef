//! Checks that a run writes no file that it also reads or writes under another name.

use super::output::{folder_of, follow_links};
use crate::base::escape::quoted;
use crate::base::stdio::is_stdio;
use crate::diagnostic::Diagnostic;
use std::collections::HashMap;
use std::ffi::OsString;
use std::fmt;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};

/// A file that a run writes. The path `-` is standard output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Written {
    /// A file with this name.
    Named(PathBuf),
    /// The file for the complete rows of a picture if the run is stopped.
    PartOf {
        /// The picture.
        picture: PathBuf,
        /// The file.
        part: PathBuf,
    },
}

impl From<PathBuf> for Written {
    fn from(path: PathBuf) -> Self {
        Self::Named(path)
    }
}

/// A file that a run reads: its kind, as in "scene", and its path. The path `-` is standard input.
pub type ReadFile = (&'static str, PathBuf);

/// Returns an error if two of the written files are the same, or one of them is also read. Pipes and devices are left
/// out. `read` is not used if none of the written files exists.
pub fn check_distinct(
    written: impl IntoIterator<Item = impl Into<Written>>,
    read: impl IntoIterator<Item = ReadFile>,
) -> Result<(), Diagnostic> {
    let mut known: HashMap<FileId, Written> = HashMap::new();
    for file in written {
        let file = file.into();
        let (Written::Named(path) | Written::PartOf { part: path, .. }) = &file;
        let Some(identity) = FileId::of(path, "/dev/stdout") else { continue };
        if let Some(other) = known.get(&identity) {
            return Err(Diagnostic::error(match &file {
                _ if file == *other => format!("{other} would be written twice"),
                Written::PartOf { .. } => format!("{file} is also {other}"),
                Written::Named(_) => format!("{other} and {file} are the same file"),
            }));
        }
        known.insert(identity, file);
    }
    if known.keys().any(|identity| identity.new_name.is_none()) {
        for (kind, path) in read {
            if let Some(file) = FileId::of(&path, "/dev/stdin").and_then(|identity| known.get(&identity)) {
                let path = if is_stdio(&path) { "standard input".into() } else { quoted(&path) };
                return Err(Diagnostic::error(format!("{file} would overwrite the {kind} {path}")));
            }
        }
    }
    Ok(())
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(path) if is_stdio(path) => f.write_str("standard output"),
            Self::Named(path) => f.write_str(&quoted(path)),
            Self::PartOf { picture, part } => {
                write!(f, "{}, where a stopped run keeps rows of {},", quoted(part), quoted(picture))
            }
        }
    }
}

/// Identifies a regular file, independent of the links and paths that lead to it.
#[derive(PartialEq, Eq, Hash)]
struct FileId {
    /// The file, or the folder of one that does not exist yet.
    node: Node,
    /// The name of a file that does not exist yet.
    new_name: Option<OsString>,
}

/// A file or a folder, by its device and its index on the device.
#[cfg(unix)]
type Node = (u64, u64);
/// A file or a folder, by its path without links.
#[cfg(not(unix))]
type Node = PathBuf;

impl FileId {
    /// Returns the file that `path` leads to, which is `stream` if it is `-`. `None` for pipes and devices, which hold
    /// nothing that could be lost, and for new files in folders that cannot be read.
    fn of(path: &Path, stream: &str) -> Option<Self> {
        let path = if is_stdio(path) { Path::new(stream) } else { path };
        if let Ok(found) = fs::metadata(path) {
            let node = if found.is_file() { node(path, &found) } else { None };
            return node.map(|node| Self { node, new_name: None });
        }
        let path = follow_links(path).ok()?;
        let mut name = path.file_name()?.to_owned();
        // Their disks do not tell capitals from small letters, and Windows leaves out dots and blanks at the end.
        if cfg!(any(windows, target_vendor = "apple")) {
            name = name.to_string_lossy().trim_end_matches(['.', ' ']).to_lowercase().into();
        }
        let folder = folder_of(&path);
        Some(Self { node: node(folder, &fs::metadata(folder).ok()?)?, new_name: Some(name) })
    }
}

#[cfg(unix)]
fn node(_: &Path, found: &Metadata) -> Option<Node> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn node(path: &Path, _: &Metadata) -> Option<Node> {
    fs::canonicalize(path).ok()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_any_of_its_names() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let path = |name: &str| folder.join(name);
        fs::write(path("file"), "").unwrap();
        fs::create_dir(path("sub")).unwrap();
        symlink("../file", path("sub/link")).unwrap();
        symlink("../new", path("sub/new link")).unwrap();
        fs::hard_link(path("file"), path("hard")).unwrap();
        let is_one = |names: [&str; 2]| {
            let [one, other] = names.map(|name| FileId::of(&path(name), "").unwrap());
            one == other
        };
        for other in ["file", "sub/link", "hard", "sub/../file"] {
            assert!(is_one(["file", other]), "{other}");
        }
        for other in ["new", "sub/new link", "sub/../new"] {
            assert!(is_one(["new", other]), "{other}");
        }
        for names in [["file", "new"], ["new", "other"], ["new", "sub/new"]] {
            assert!(!is_one(names), "{names:?}");
        }
        assert!(FileId::of(Path::new("/dev/null"), "").is_none());
        assert!(["no/file", "sub"].iter().all(|name| FileId::of(&path(name), "").is_none()));
    }
}
