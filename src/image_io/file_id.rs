//! Which names mean the same file.

use super::output::{folder_of, follow_links};
use std::fs;
use std::path::{Path, PathBuf};

/// What two names have in common if they mean the same file, by links or by other ways through the folders.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FileId {
    /// A file that exists, by its device and its index on the device.
    #[cfg(unix)]
    Inode(u64, u64),
    /// Any other file, by the folder's path without links and the name in it.
    Place(PathBuf),
}

impl FileId {
    /// The file that `path` leads to, which need not exist. None for devices, which hold nothing that could be lost,
    /// and if the folder cannot be read.
    pub fn of(path: &Path) -> Option<Self> {
        match fs::metadata(path) {
            Ok(found) => existing(path, &found),
            Err(_) => {
                let target = follow_links(path).ok()?;
                Some(Self::Place(fs::canonicalize(folder_of(&target)).ok()?.join(target.file_name()?)))
            }
        }
    }
}

#[cfg(unix)]
fn existing(_: &Path, found: &fs::Metadata) -> Option<FileId> {
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let kind = found.file_type();
    let is_device = kind.is_char_device() || kind.is_block_device();
    (!is_device).then(|| FileId::Inode(found.dev(), found.ino()))
}

#[cfg(not(unix))]
fn existing(path: &Path, _: &fs::Metadata) -> Option<FileId> {
    fs::canonicalize(path).ok().map(FileId::Place)
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
        assert_eq!([FileId::of(Path::new("/dev/null")), id("no/file")], [None, None]);
    }
}
