//! Which names mean the same file.

use super::output::{folder_of, follow_links};
use std::ffi::OsString;
use std::fs::{self, Metadata};
use std::path::Path;

/// Identifies a regular file, by whatever links and paths it is named.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum FileId {
    /// A file that exists.
    Existing(Node),
    /// The folder and the name of a file that does not exist yet.
    New(Node, OsString),
}

/// A file or a folder, by its device and its index on the device.
#[cfg(unix)]
type Node = (u64, u64);
/// A file or a folder, by its path without links.
#[cfg(not(unix))]
type Node = std::path::PathBuf;

impl FileId {
    /// Returns the file that `path` leads to. `None` for pipes and devices, which hold nothing that could be lost, and
    /// for new files in folders that cannot be read.
    pub fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) => found.is_file().then(|| node(path, &found).map(Self::Existing))?,
            Err(_) => {
                let path = follow_links(path).ok()?;
                let mut name = path.file_name()?.to_owned();
                // Their disks do not tell capitals from small letters, and Windows leaves out dots and blanks at the
                // end.
                if cfg!(any(windows, target_vendor = "apple")) {
                    name = name.to_string_lossy().trim_end_matches(['.', ' ']).to_lowercase().into();
                }
                let folder = folder_of(&path);
                Some(Self::New(node(folder, &fs::metadata(folder).ok()?)?, name))
            }
        }
    }

    /// True if the file exists.
    pub fn exists(&self) -> bool {
        matches!(self, Self::Existing(_))
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

#[cfg(test)]
mod tests {
    #[cfg(unix)]
    use super::*;

    #[cfg(unix)]
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
            let [one, other] = names.map(|name| FileId::of(&path(name)).unwrap());
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
        assert!(FileId::of(Path::new("/dev/null")).is_none());
        assert!(["no/file", "sub"].iter().all(|name| FileId::of(&path(name)).is_none()));
    }
}
