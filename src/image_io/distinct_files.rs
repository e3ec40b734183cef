//! Checks that a run writes no file that it also reads or writes under another name.

use super::file_id::FileId;
use crate::base::escape::quoted;
use std::collections::HashMap;
use std::fmt;
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

/// A file that a run reads: its kind, as in "scene", and its path. The path `-` is standard input.
pub type ReadFile = (&'static str, PathBuf);

/// Returns an error if two of the written files are the same, or one of them is also read. Pipes and devices are left
/// out. `read` is not used if none of the written files exists.
pub fn check_distinct(
    written: impl IntoIterator<Item = Written>,
    read: impl IntoIterator<Item = ReadFile>,
) -> Result<(), SameFile> {
    let mut known: HashMap<FileId, Written> = HashMap::new();
    for file in written {
        let Some(identity) = file.identity() else { continue };
        if let Some(other) = known.get(&identity) {
            return Err(SameFile::written_twice(other, &file));
        }
        known.insert(identity, file);
    }
    if known.keys().any(FileId::exists) {
        for (kind, path) in read {
            let place = if is_stream(&path) { Path::new("/dev/stdin") } else { &path };
            if let Some(file) = FileId::of(place).and_then(|identity| known.get(&identity)) {
                return Err(SameFile::read(file, kind, &path));
            }
        }
    }
    Ok(())
}

/// The message that two files of a run are the same.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SameFile(String);

impl SameFile {
    fn written_twice(one: &Written, other: &Written) -> Self {
        Self(match other {
            _ if one == other => format!("{one} would be written twice"),
            Written::PartOf { .. } => format!("{other} is also {one}"),
            Written::Named(_) => format!("{one} and {other} are the same file"),
        })
    }

    fn read(file: &Written, kind: &str, path: &Path) -> Self {
        let read = if is_stream(path) { "standard input".into() } else { quoted(path) };
        Self(format!("{file} is the {kind} {read}, which would be lost"))
    }
}

impl fmt::Display for SameFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for SameFile {}

impl Written {
    fn identity(&self) -> Option<FileId> {
        FileId::of(match self {
            Self::Named(path) if is_stream(path) => Path::new("/dev/stdout"),
            Self::Named(path) | Self::PartOf { part: path, .. } => path,
        })
    }
}

impl fmt::Display for Written {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Named(path) if is_stream(path) => f.write_str("standard output"),
            Self::Named(path) => f.write_str(&quoted(path)),
            Self::PartOf { picture, part } => {
                write!(f, "{}, where a stopped run keeps rows of {},", quoted(part), quoted(picture))
            }
        }
    }
}

fn is_stream(path: &Path) -> bool {
    path == Path::new("-")
}
