//! A folder with a folder of pictures for every name.

use crate::base::escape::quoted;
use crate::base::memory;
use crate::diagnostic::Diagnostic;
use crate::image_io::{Format, load_picture};
use crate::picture::CHANNELS;
use crate::tools::grade::Submission;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// The number of files without a reference that are listed for each name.
const NAMED: usize = 10;

/// The folders in a folder, without the ones whose names start with a dot.
pub struct Folder {
    path: PathBuf,
    /// In order.
    pub names: Vec<OsString>,
    /// For each wanted picture, the file that is taken for it in the folder of each name, by its path there.
    pub taken: Vec<Vec<PathBuf>>,
    /// A line for each thing in the folder that is not graded.
    pub notes: Vec<String>,
}

/// The depth of folders to which pictures are looked for.
const DEEPEST: usize = 6;
/// The number of pictures of a name after which no more are looked for.
const MOST: usize = 10_000;

impl Folder {
    /// Looks for pictures of the wanted names in the folders among these entries of a folder.
    pub fn new(path: &Path, entries: Vec<OsString>, wanted: &[&OsStr]) -> Result<Self, Diagnostic> {
        let is_folder = |name: &OsString| path.join(name).is_dir();
        let (names, others): (Vec<_>, Vec<_>) = entries.into_iter().partition(is_folder);
        if names.is_empty() {
            return Err(Diagnostic::error(format!(
                "{} has no folder of pictures in it: put the pictures of each name into a folder",
                quoted(path)
            )));
        }
        let mut taken = vec![vec![]; wanted.len()];
        let mut notes: Vec<String> =
            others.iter().map(|name| format!("{}: not a folder", name.to_string_lossy())).collect();
        for name in &names {
            let folder = path.join(name);
            let files = pictures(&folder);
            let own: Vec<PathBuf> =
                wanted.iter().map(|picture| taken_for(picture, &folder, &files, wanted)).collect();
            let others = others_in(&folder, &own, wanted);
            notes.extend(others.map(|others| format!("{}: {others}", name.to_string_lossy())));
            taken.iter_mut().zip(own).for_each(|(all, file)| all.push(file));
        }
        Ok(Self { path: path.to_owned(), names, taken, notes })
    }

    /// The files that are read. A link is not read.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let files = (0..self.taken.len()).flat_map(|index| self.files_for(index));
        files.filter(|file| fs::symlink_metadata(file).is_ok_and(|found| found.is_file()))
    }

    /// Reads the files that are taken for a wanted picture, which has this width and height.
    pub fn submissions(
        &self,
        index: usize,
        size: [u32; 2],
    ) -> impl Iterator<Item = Result<Submission, Diagnostic>> {
        self.files_for(index).map(move |file| submission(&file, size))
    }

    /// The files that are taken for a wanted picture.
    fn files_for(&self, index: usize) -> impl Iterator<Item = PathBuf> {
        self.names.iter().zip(&self.taken[index]).map(|(name, taken)| self.path.join(name).join(taken))
    }
}

/// Returns the path of the file that is taken for this picture in a folder with these files: the picture's own name, or
/// else a file whose name has another ending or case, or that lies in a folder in it.
fn taken_for(picture: &OsStr, folder: &Path, files: &[PathBuf], wanted: &[&OsStr]) -> PathBuf {
    if fs::symlink_metadata(folder.join(picture)).is_ok() {
        return picture.into();
    }
    let alike = files.iter().filter_map(|file| Some((mismatch(file, picture, wanted)?, file)));
    alike.min().map_or(picture.into(), |(_, file)| file.clone())
}

/// Lists the pictures in a folder that are neither wanted nor taken for a wanted one, if there are any.
fn others_in(folder: &Path, taken: &[PathBuf], wanted: &[&OsStr]) -> Option<String> {
    let mut others = match entries(folder) {
        Ok(files) => files,
        Err(error) => return Some(error.to_string()),
    };
    others.retain(|file| {
        let is_taken = taken.iter().any(|other| other == file);
        Format::of_input(Path::new(file)).is_some() && !wanted.contains(&&**file) && !is_taken
    });
    let named: Vec<_> = others.iter().take(NAMED).map(|file| file.to_string_lossy()).collect();
    let more = others.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    (!others.is_empty()).then(|| format!("no reference for {}{more}", named.join(", ")))
}

/// The pictures in a folder and the folders in it, by their paths from there. Leaves out links, names that start with a
/// dot, and folders that cannot be read.
fn pictures(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut waiting = vec![(PathBuf::new(), 0)];
    while let Some((inside, depth)) = waiting.pop() {
        for name in entries(&folder.join(&inside)).unwrap_or_default() {
            let path = inside.join(&name);
            match fs::symlink_metadata(folder.join(&path)) {
                Ok(kind) if kind.is_dir() && depth < DEEPEST => waiting.push((path, depth + 1)),
                Ok(kind) if kind.is_file() && Format::of_input(&path).is_some() => found.push(path),
                _ => {}
            }
        }
        if found.len() >= MOST {
            break;
        }
    }
    found
}

/// Returns how much the path of a file differs from a picture's name, to be compared in this order: how deep the file
/// lies, and whether its name has another case or another ending. `None` if it is another picture.
fn mismatch(file: &Path, picture: &OsStr, wanted: &[&OsStr]) -> Option<(usize, bool, bool)> {
    let name = file.file_name()?;
    let depth = file.components().count() - 1;
    if wanted.contains(&name) && (depth == 0 || name != picture) {
        return None;
    }
    let stem = |name: &OsStr| Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let (own, wanted) = (stem(name)?, stem(picture)?);
    let has_other_ending = Path::new(name).extension() != Path::new(picture).extension();
    (own.to_lowercase() == wanted.to_lowercase()).then_some((depth, own != wanted, has_other_ending))
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

/// Reads a picture. A link is not read, because it may lead to another name's picture. Too little memory for a picture
/// of this size is an error, and not a fault of the picture.
fn submission(path: &Path, size: [u32; 2]) -> Result<Submission, Diagnostic> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Submission::Missing),
        Ok(found) if found.is_symlink() => return Ok(Submission::Unusable("it is a link".into())),
        _ => {}
    }
    let bytes = size.iter().map(|&side| u64::from(side)).product::<u64>() * CHANNELS as u64;
    memory::ask(bytes)
        .map_err(|error| Diagnostic::error(format!("cannot read {}: {error}", quoted(path))))?;
    // The report has the path already.
    match load_picture(path).map(|(picture, _)| picture) {
        Ok(picture) if [picture.width(), picture.height()] == size => Ok(Submission::Picture(picture)),
        Ok(picture) => {
            let ([width, height], [right_width, right_height]) = ([picture.width(), picture.height()], size);
            let sizes = format!("{width} x {height} pixels instead of {right_width} x {right_height}");
            Ok(Submission::Unusable(format!("its size is {sizes}")))
        }
        Err(reason) => Ok(Submission::Unusable(reason.in_one_line())),
    }
}
