//! Which names mean the same file.

use super::complete_file::temporary_names;
use super::output::{folder_of, follow_links};
use crate::undisturbed::undisturbed;
use std::ffi::OsStr;
use std::fs::{self, File, Metadata};
use std::path::{Path, PathBuf};

/// What two names have in common if they mean the same file, by links, by other ways through the folders, or because
/// the system takes two names for one, such as `a.tga` and `A.tga`.
#[derive(Clone, Debug)]
pub struct FileId {
    /// The file, if it exists.
    existing: Option<Inode>,
    /// The folder that it is or will be in, and its path without links to it.
    place: Option<(Inode, PathBuf)>,
}

/// A file or a folder, by its device and its index on the device.
#[cfg(unix)]
type Inode = (u64, u64);
/// A file or a folder, by its path without links.
#[cfg(not(unix))]
type Inode = PathBuf;

impl FileId {
    /// The file that `path` leads to, which need not exist. None for pipes and devices, which hold nothing that could
    /// be lost, and if the folder of one that does not exist cannot be read.
    pub fn of(path: &Path) -> Option<Self> {
        let existing = match fs::metadata(path) {
            Ok(found) if found.is_file() => Some(inode(path, &found)?),
            Ok(_) => return None,
            Err(_) => None,
        };
        let place = follow_links(path).ok().filter(|path| path.file_name().is_some()).and_then(|path| {
            let folder = folder_of(&path);
            Some((inode(folder, &fs::metadata(folder).ok()?)?, path))
        });
        (existing.is_some() || place.is_some()).then_some(Self { existing, place })
    }

    /// Whether the file exists.
    pub fn exists(&self) -> bool {
        self.existing.is_some()
    }

    /// Whether both are one file. Disks that do not tell capitals from small letters may give each spelling of a name a
    /// number of its own (exFAT through FUSE does), so the names are compared even if both files exist.
    pub fn is_same(&self, other: &Self) -> bool {
        let is_one_name = |(folder, path): &(Inode, PathBuf), (other_folder, other): &(Inode, PathBuf)| {
            let names = path.file_name().zip(other.file_name());
            folder == other_folder
                && names
                    .is_some_and(|(a, b)| a == b || may_be_one([a, b]) && are_one([a, b], folder_of(path)))
        };
        self.existing.is_some() && self.existing == other.existing
            || self.exists() == other.exists()
                && self
                    .place
                    .as_ref()
                    .zip(other.place.as_ref())
                    .is_some_and(|(one, other)| is_one_name(one, other))
    }
}

/// Whether some system may take both names for one: Windows and macOS do not tell capitals from small letters, and
/// Windows leaves out dots and blanks at the end. Which letters of other scripts belong together differs from disk to
/// disk.
fn may_be_one(names: [&OsStr; 2]) -> bool {
    let [one, other] = names.map(OsStr::to_string_lossy);
    let plain = |name: &str| name.trim_end_matches(['.', ' ']).to_ascii_lowercase();
    !one.is_ascii() || !other.is_ascii() || plain(&one) == plain(&other)
}

/// Whether both names are one in this folder, or in one that is made in it for a moment to see.
fn are_one([one, other]: [&OsStr; 2], folder: &Path) -> bool {
    let folder = || temporary_names().tempdir_in(folder);
    let holds_other = |folder: tempfile::TempDir| {
        let path = |name| folder.path().join(name);
        File::create_new(path(one)).is_ok() && path(other).symlink_metadata().is_ok()
    };
    undisturbed(|| folder().is_ok_and(holds_other))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether the files of these names are known to be one.
    fn is_one(folder: &Path, names: [&str; 2]) -> bool {
        let [one, other] = names.map(|name| FileId::of(&folder.join(name)));
        one.zip(other).is_some_and(|(one, other)| one.is_same(&other) && other.is_same(&one))
    }

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
        for other in ["file", "sub/link", "hard", "sub/../file"] {
            assert!(is_one(folder, ["file", other]), "{other}");
        }
        for other in ["new", "sub/new link", "sub/../new"] {
            assert!(is_one(folder, ["new", other]), "{other}");
        }
        for names in [["file", "new"], ["new", "other"], ["new", "sub/new"]] {
            assert!(!is_one(folder, names), "{names:?}");
        }
        assert!(FileId::of(Path::new("/dev/null")).is_none());
        assert!(["no/file", "sub"].iter().all(|name| FileId::of(&path(name)).is_none()));
    }

    #[test]
    fn names_are_one_where_the_system_takes_them_for_one() {
        const NAMES: [[&str; 2]; 9] = [
            ["a.tga", "A.tga"],
            ["a.tga", "a.TGA"],
            ["a.tga", "b.tga"],
            ["a.tga", "a.tga."],
            ["a.tga", "a.tga "],
            ["\u{e4}.tga", "\u{c4}.tga"],
            ["\u{e4}.tga", "a\u{308}.tga"],
            ["k.tga", "\u{212a}.tga"],
            ["stra\u{df}e.tga", "STRASSE.tga"],
        ];
        let folder = tempfile::tempdir().unwrap();
        for names in NAMES {
            let found = is_one(folder.path(), names);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{names:?}");
            // What becomes of two files of these names.
            let [one, other] = names.map(|name| folder.path().join(name));
            let is_written = fs::write(&one, "one").and_then(|()| fs::write(&other, "other")).is_ok();
            let is_lost = is_written && fs::read(&one).unwrap() == b"other";
            assert_eq!(found, is_lost, "{names:?}");
            // One of them is there.
            assert_eq!(is_one(folder.path(), names), is_lost, "{names:?}");
            let _ = [one, other].map(fs::remove_file);
        }
    }

    #[test]
    fn names_that_no_system_takes_for_one_are_not_tried() {
        let may_be = |a: &str, b: &str| may_be_one([a.as_ref(), b.as_ref()]);
        assert!(may_be("Picture.tga", "pICTURE.TGA") && may_be("a. .", "a") && may_be("\u{e9}.tga", "E.tga"));
        assert!(!may_be("a.tga", "b.tga") && !may_be("a.tga", "a.png") && !may_be("a .tga", "a.tga"));
    }
}
