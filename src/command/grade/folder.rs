//! A folder with a folder of pictures for every name: lists and reads its files.

use crate::base::escape::quoted;
use crate::base::memory;
use crate::diagnostic::Diagnostic;
use crate::image_io::{Wanted, load_pixels};
use crate::picture::CHANNELS;
use crate::tools::grade::{Kind, Listed, NotGraded, Pairing, Reason, Remark, Submission};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};

/// The folders in a folder, without the ones whose names start with a dot.
pub struct Folder {
    path: PathBuf,
    /// In order, of which upper and lower case make no difference.
    pub names: Vec<OsString>,
    /// The names of the wanted pictures.
    pub wanted: Vec<OsString>,
    /// The files of each name.
    pairings: Vec<Pairing>,
    /// The files that lie in the folder of no name.
    outside: Vec<NotGraded>,
}

/// The depth of folders to which pictures are looked for.
const DEEPEST: usize = 6;
/// The number of files of a name after which no more are looked for.
const MOST: usize = 10_000;

impl Folder {
    /// Looks for pictures of the wanted names in the folders among these entries of a folder, or only in the folder called
    /// `student`.
    pub fn new(
        path: &Path,
        entries: Vec<OsString>,
        wanted: Vec<OsString>,
        student: Option<&OsStr>,
    ) -> Result<Self, Diagnostic> {
        let is_folder = |name: &OsString| path.join(name).is_dir();
        let (mut names, others): (Vec<_>, Vec<_>) = entries.into_iter().partition(is_folder);
        if names.is_empty() {
            return Err(Diagnostic::error(format!(
                "{} has no folder of pictures in it: put the pictures of each name into a folder",
                quoted(path)
            )));
        }
        let mut outside = vec![];
        match student {
            None => {
                let reason = Reason::OutsideFolders;
                let files = others.iter().map(|file| file.to_string_lossy().into_owned());
                outside.extend(files.map(|file| NotGraded { name: None, file, reason, meant_for: None }));
            }
            Some(student) => {
                names.retain(|name| name == student);
                if names.is_empty() {
                    let (student, path) = (quoted(student), quoted(path));
                    return Err(Diagnostic::error(format!("there is no folder {student} in {path}")));
                }
            }
        }
        names.sort_by_cached_key(|name| (name.to_string_lossy().to_lowercase(), name.clone()));
        let pictures: Vec<&OsStr> = wanted.iter().map(OsString::as_os_str).collect();
        let pairing = |name: &OsString| Pairing::new(name, &files(&path.join(name)), &pictures);
        let pairings = names.iter().map(pairing).collect();
        Ok(Self { path: path.to_owned(), names, wanted, pairings, outside })
    }

    /// Returns the files that are not graded.
    pub fn not_graded(&self) -> impl Iterator<Item = &NotGraded> {
        self.outside.iter().chain(self.pairings.iter().flat_map(|pairing| &pairing.others))
    }

    /// The files that are read. A link is not read.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let rows = self.names.iter().map(|name| self.path.join(name)).zip(&self.pairings);
        let files = rows.flat_map(|(folder, pairing)| {
            pairing.taken.iter().flatten().map(move |taken| folder.join(taken))
        });
        files.filter(|file| fs::symlink_metadata(file).is_ok_and(|found| found.is_file()))
    }

    /// Reads the file of a name that is taken for a wanted picture, which has this width and height. A link is not read,
    /// because it may lead to another name's picture. Too little memory for a picture of this size is an error, and not a
    /// fault of the picture.
    pub fn submission(&self, row: usize, index: usize, size: [usize; 2]) -> Result<Submission, Diagnostic> {
        let Some(taken) = &self.pairings[row].taken[index] else { return Ok(Submission::Missing) };
        let path = self.path.join(&self.names[row]).join(taken);
        if fs::symlink_metadata(&path).is_ok_and(|found| found.is_symlink()) {
            return Ok(Submission::Unusable(Reason::Link.words().into()));
        }
        let bytes = (size[0] * size[1] * CHANNELS) as u64;
        memory::ask(bytes)
            .map_err(|error| Diagnostic::error(format!("cannot read {}: {error}", quoted(&path))))?;
        // The report has the path already.
        Ok(match load_pixels(&path, Wanted::Numbers) {
            Ok((picture, _)) => Submission::Picture(picture),
            Err(reason) => Submission::Unusable(reason.in_one_line()),
        })
    }

    /// Returns the other name of the file that is taken for a wanted picture, if it has one.
    fn other_name(&self, row: usize, index: usize) -> Option<String> {
        let taken = self.pairings[row].taken[index].as_ref()?;
        (taken != Path::new(&self.wanted[index])).then(|| taken.to_string_lossy().into_owned())
    }

    /// Returns the remark on the file that is taken for a wanted picture.
    pub fn remark(&self, row: usize, index: usize) -> Remark {
        let others = self.pairings[row].meant_for(&self.wanted[index]);
        Remark { found_as: self.other_name(row, index), others }
    }
}

/// Lists the files in a folder and the folders in it, by their paths from there. Leaves out names that start with a dot.
fn files(folder: &Path) -> Vec<Listed> {
    let mut listed = vec![];
    let mut waiting = vec![(PathBuf::new(), 0)];
    while let Some((inside, depth)) = waiting.pop() {
        let Ok(names) = entries(&folder.join(&inside)) else {
            listed.push(Listed { path: inside, kind: Kind::Refused(Reason::Unreadable) });
            continue;
        };
        for name in names {
            let path = inside.join(&name);
            let is_listed = depth < DEEPEST && listed.len() < MOST;
            let kind = match fs::symlink_metadata(folder.join(&path)) {
                Ok(kind) if kind.is_file() => Kind::Regular,
                Ok(kind) if kind.is_symlink() => Kind::Refused(Reason::Link),
                Ok(kind) if kind.is_dir() && is_listed => Kind::Folder,
                Ok(kind) if kind.is_dir() => Kind::Refused(Reason::Unlisted),
                _ => Kind::Refused(Reason::Special),
            };
            if kind == Kind::Folder {
                waiting.push((path.clone(), depth + 1));
            }
            listed.push(Listed { path, kind });
        }
    }
    listed.sort();
    listed
}

/// Lists the sorted names in a folder, without the ones that start with a dot.
pub fn entries(path: &Path) -> Result<Vec<OsString>, Diagnostic> {
    let unreadable = |error| Diagnostic::error(format!("cannot read the folder {}: {error}", quoted(path)));
    let all = fs::read_dir(path).map_err(unreadable)?.map(|entry| entry.map(|entry| entry.file_name()));
    let mut names = all.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    names.retain(|name| !name.as_encoded_bytes().starts_with(b"."));
    names.sort();
    Ok(names)
}
