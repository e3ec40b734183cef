//! A folder that has a folder of pictures for every name.

use super::references::References;
use raytracer::base::escape::quoted;
use raytracer::base::memory;
use raytracer::diagnostic::Diagnostic;
use raytracer::image_io::{Format, load_picture};
use raytracer::picture::CHANNELS;
use raytracer::tools::grade::{Column, Submission};
use std::ffi::{OsStr, OsString};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// How many files without a reference are named for each name.
const NAMED: usize = 10;

/// The folders in a folder. Those whose names start with a dot are no names.
pub struct Folder {
    path: PathBuf,
    /// In order.
    names: Vec<OsString>,
    /// The pictures in the folder of each, at any depth, by their paths in it.
    pictures: Vec<Vec<PathBuf>>,
    /// What is not a folder.
    others: Vec<OsString>,
}

/// How deep pictures are looked for.
const DEEPEST: usize = 6;
/// How many pictures of a name are listed.
const MOST: usize = 10_000;

impl Folder {
    /// Lists the folder.
    pub fn open(path: &Path) -> Result<Self, Diagnostic> {
        let (folders, others) = entries(path)?.into_iter().partition(|name| path.join(name).is_dir());
        let folders: Vec<OsString> = folders;
        let pictures = folders.iter().map(|name| pictures(&path.join(name))).collect();
        let folder = Self { path: path.to_owned(), names: folders, pictures, others };
        match folder.names.is_empty() {
            true => Err(Diagnostic::error(format!("{} has no folder of pictures in it", quoted(path)))),
            false => Ok(folder),
        }
    }

    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// The names as text.
    pub fn shown_names(&self) -> Vec<String> {
        self.names.iter().map(|name| name.to_string_lossy().into_owned()).collect()
    }

    /// The files that are read for this picture. A link is not read.
    pub fn files(&self, picture: &OsStr, references: &References) -> impl Iterator<Item = PathBuf> {
        let files = self.taken(picture, references).into_iter().zip(&self.names);
        let files = files.map(|(taken, name)| self.path.join(name).join(taken));
        files.filter(|file| fs::symlink_metadata(file).is_ok_and(|found| found.is_file()))
    }

    /// The path of the file that is taken for this picture in the folder of each name: that of the picture's name, or
    /// else one whose name has another ending or case, or that lies in a folder in it.
    pub fn taken(&self, picture: &OsStr, references: &References) -> Vec<PathBuf> {
        let taken = |(name, files): (&OsString, &Vec<PathBuf>)| {
            let exact = PathBuf::from(picture);
            if fs::symlink_metadata(self.path.join(name).join(&exact)).is_ok() {
                return exact;
            }
            let others = files.iter().filter_map(|file| Some((likeness(file, picture, references)?, file)));
            others.min().map_or(exact, |(_, file)| file.clone())
        };
        self.names.iter().zip(&self.pictures).map(taken).collect()
    }

    /// Reads what each name handed in as this picture, which is of this width and height, in the files that are taken.
    pub fn submissions<'f>(
        &'f self,
        taken: &'f [PathBuf],
        size: [u32; 2],
    ) -> impl Iterator<Item = Result<Submission, Diagnostic>> + 'f {
        let files = self.names.iter().zip(taken).map(|(name, taken)| self.path.join(name).join(taken));
        files.map(move |file| submission(&file, size))
    }

    /// What is in the folder and is not graded, a line each.
    pub fn notes(&self, references: &References, columns: &[Column]) -> Vec<String> {
        let others = self.others.iter().map(|name| format!("{}: not a folder", name.to_string_lossy()));
        let extra = |(row, name): (usize, &OsString)| self.extra(row, name, references, columns);
        others.chain(self.names.iter().enumerate().filter_map(extra)).collect()
    }

    /// The pictures of a name that no reference names, and that are not taken for another.
    fn extra(&self, row: usize, name: &OsStr, references: &References, columns: &[Column]) -> Option<String> {
        let shown = name.to_string_lossy();
        let mut extra = match entries(&self.path.join(name)) {
            Ok(files) => files,
            Err(error) => return Some(format!("{shown}: {error}")),
        };
        let is_taken = |file: &OsString| {
            let shown = file.to_string_lossy();
            columns.iter().any(|column| column.found_as[row].as_deref() == Some(&*shown))
        };
        extra.retain(|file| {
            Format::of_input(Path::new(file)).is_some() && !references.has(file) && !is_taken(file)
        });
        let named: Vec<_> = extra.iter().take(NAMED).map(|file| file.to_string_lossy()).collect();
        let more = extra.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        (!extra.is_empty()).then(|| format!("{shown}: no reference for {}{more}", named.join(", ")))
    }
}

/// The pictures in a folder and the folders in it, by their paths from there. What cannot be read is left out, and so
/// are links, and names that start with a dot.
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

/// How much a file is like a picture of this name, where less is more alike: how deep it lies, whether its name has
/// another case, and another ending. None where it is another picture, or stands where another reference has its own.
fn likeness(file: &Path, picture: &OsStr, references: &References) -> Option<(usize, bool, bool)> {
    let name = file.file_name()?;
    let depth = file.components().count() - 1;
    if depth == 0 && references.has(name) || name != picture && references.has(name) {
        return None;
    }
    let stem = |name: &OsStr| Path::new(name).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let (own, wanted) = (stem(name)?, stem(picture)?);
    let has_other_ending = Path::new(name).extension() != Path::new(picture).extension();
    (own.to_lowercase() == wanted.to_lowercase()).then_some((depth, own != wanted, has_other_ending))
}

/// The sorted names of what is in a folder, without those that start with a dot.
pub fn entries(path: &Path) -> Result<Vec<OsString>, Diagnostic> {
    let unreadable = |error| Diagnostic::error(format!("cannot read the folder {}: {error}", quoted(path)));
    let all = fs::read_dir(path).map_err(unreadable)?.map(|entry| entry.map(|entry| entry.file_name()));
    let mut names = all.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    names.retain(|name| !name.as_encoded_bytes().starts_with(b"."));
    names.sort();
    Ok(names)
}

/// Reads a picture. One that is a link is not read, because it may lead to another name's picture. Too little memory for
/// a picture of this size is an error, since it says nothing of the picture.
fn submission(path: &Path, size: [u32; 2]) -> Result<Submission, Diagnostic> {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Submission::Missing),
        Ok(found) if found.is_symlink() => return Ok(Submission::Unusable("it is a link".into())),
        _ => {}
    }
    let bytes = size.iter().map(|&side| u64::from(side)).product::<u64>() * CHANNELS as u64;
    memory::ask(bytes)
        .map_err(|error| Diagnostic::error(format!("cannot read {}: {error}", quoted(path))))?;
    // The path is known.
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
