//! Which names mean the same file.

use super::output::{folder_of, follow_links};
use std::ffi::OsString;
use std::fs::{self, Metadata};
use std::path::Path;

/// What two names have in common if they mean the same file, by links or by other ways through the folders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileId {
    /// A file that exists.
    Existing(Inode),
    /// A file that does not exist yet, by the folder and the name in it.
    New(Inode, OsString),
}

/// A file or a folder, by its device and its index on the device.
#[cfg(unix)]
type Inode = (u64, u64);
/// A file or a folder, by its path without links.
#[cfg(not(unix))]
type Inode = std::path::PathBuf;

impl FileId {
    /// The file that `path` leads to, which need not exist. None for pipes and devices, which hold nothing that could
    /// be lost, and if the folder cannot be read.
    pub fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) if found.is_file() => inode(path, &found).map(Self::Existing),
            Ok(_) => None,
            Err(_) => {
                let target = follow_links(path).ok()?;
                let folder = folder_of(&target);
                let folder = inode(folder, &fs::metadata(folder).ok()?)?;
                Some(Self::New(folder, target.file_name()?.to_owned()))
            }
        }
    }

    /// Whether the file exists.
    pub fn exists(&self) -> bool {
        matches!(self, Self::Existing(_))
    }
}

#[cfg(unix)]
fn inode(_: &Path, found: &Metadata) -> Option<Inode> {
    use std::os::unix::fs::MetadataExt;
    Some((found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn inode(path: &Path, _: &Metadata) -> Option<Inode> {
    fs::canonicalize(path).ok()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_file_is_known_by_any_of_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("file"), "").unwrap();
        fs::create_dir(path("sub")).unwrap();
        symlink("../file", path("sub/link")).unwrap();
        symlink("../new", path("sub/new link")).unwrap();
        fs::hard_link(path("file"), path("hard")).unwrap();
        let id = |name| FileId::of(&path(name));
        assert!(id("file").is_some() && id("new").is_some() && id("file") != id("new"));
        assert_eq!([id("sub/link"), id("hard"), id("sub/../file")], [(); 3].map(|()| id("file")));
        assert_eq!([id("sub/new link"), id("sub/../new")], [(); 2].map(|()| id("new")));
        assert_ne!(id("new"), id("sub/new"));
        assert_eq!([FileId::of(Path::new("/dev/null")), id("no/file"), id("sub")], [None, None, None]);
    }
}
