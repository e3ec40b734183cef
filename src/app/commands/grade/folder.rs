//! A folder that has a folder of pictures for every name.

use super::references::References;
use crate::app::failed;
use rayon::prelude::*;
use raytracer::escape::quoted;
use raytracer::image_io::{Format, read_picture_of_size};
use raytracer::tools::grade::Submission;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::{Path, PathBuf};

/// How many files without a reference are named for each name.
const NAMED: usize = 10;

/// The folders in a folder. Those whose names start with a dot are no names.
pub struct Folder {
    path: PathBuf,
    /// In order.
    names: Vec<OsString>,
    /// What is not a folder.
    others: Vec<OsString>,
}

impl Folder {
    /// Lists the folder.
    pub fn open(path: &Path) -> Result<Self, String> {
        let (folders, others) = entries(path)?.into_iter().partition(|name| path.join(name).is_dir());
        let folder = Self { path: path.to_owned(), names: folders, others };
        match folder.names.is_empty() {
            true => Err(failed(format!("{} has no folder of pictures in it", quoted(path)))),
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
    pub fn files(&self, picture: &OsStr) -> impl Iterator<Item = PathBuf> {
        let files = self.names.iter().map(move |name| self.path.join(name).join(picture));
        files.filter(|file| fs::symlink_metadata(file).is_ok_and(|found| found.is_file()))
    }

    /// What everybody handed in as this picture, which is of this width and height.
    pub fn submissions(&self, picture: &OsStr, size: [u32; 2]) -> Vec<Submission> {
        self.names.par_iter().map(|name| submission(&self.path.join(name).join(picture), size)).collect()
    }

    /// What is in the folder and is not graded, a line each.
    pub fn notes(&self, references: &References) -> Vec<String> {
        let others = self.others.iter().map(|name| format!("{}: not a folder", name.to_string_lossy()));
        others.chain(self.names.iter().filter_map(|name| self.extra(name, references))).collect()
    }

    /// The pictures of a name that no reference names.
    fn extra(&self, name: &OsStr, references: &References) -> Option<String> {
        let shown = name.to_string_lossy();
        let mut extra = match entries(&self.path.join(name)) {
            Ok(files) => files,
            Err(error) => return Some(format!("{shown}: {error}")),
        };
        extra.retain(|file| Format::of(Path::new(file)).is_some() && !references.has(file));
        let named: Vec<_> = extra.iter().take(NAMED).map(|file| file.to_string_lossy()).collect();
        let more = extra.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        (!extra.is_empty()).then(|| format!("{shown}: no reference for {}{more}", named.join(", ")))
    }
}

/// The sorted names of what is in a folder, without those that start with a dot.
pub fn entries(path: &Path) -> Result<Vec<OsString>, String> {
    let unreadable = |error| failed(format!("cannot read the folder {}: {error}", quoted(path)));
    let all = fs::read_dir(path).map_err(unreadable)?.map(|entry| entry.map(|entry| entry.file_name()));
    let mut names = all.collect::<Result<Vec<_>, _>>().map_err(unreadable)?;
    names.retain(|name| !name.as_encoded_bytes().starts_with(b"."));
    names.sort();
    Ok(names)
}

/// A picture that is a link is not read, because it may lead to a picture of somebody else.
fn submission(path: &Path, size: [u32; 2]) -> Submission {
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Submission::Missing,
        Ok(found) if found.is_symlink() => return Submission::Unusable("it is a link".into()),
        _ => {}
    }
    match read_picture_of_size(path, size) {
        Ok(picture) => Submission::Picture(picture),
        Err(error) => {
            let message = error.to_string();
            let start = format!("cannot read {}: ", quoted(path));
            Submission::Unusable(message.strip_prefix(&start).unwrap_or(&message).to_owned())
        }
    }
}
