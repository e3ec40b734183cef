//! Finds the file that somebody meant whose name is nearly right.

use std::fs;
use std::path::{Path, PathBuf};

/// The largest number of files that are looked at.
const MAX_FILES: usize = 10_000;
/// The longest name that is compared, in bytes, which bounds the time.
const MAX_LENGTH: usize = 255;

/// The other file in the folder of `path` with the nearest name and the same extension (or `.txt` for none), if a third of
/// the name or less differs or if it only lacks its end. If there is none, and `path` is a bare name, it is looked
/// for in the folders of the working directory.
pub fn nearest_file(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str().filter(|name| name.len() <= MAX_LENGTH)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let others = names_in(folder).into_iter().filter(|other| other != name);
    let near = others
        .filter_map(|other| Some((distance(name, &other)?, other)))
        .filter(|(_, other)| folder.join(other).is_file())
        .min();
    match near {
        Some((_, other)) => Some(folder.join(other)),
        None if folder == Path::new("") => in_a_folder(name),
        None => None,
    }
}

fn in_a_folder(name: &str) -> Option<PathBuf> {
    let mut folders = names_in(Path::new(""));
    folders.sort();
    folders.into_iter().map(|folder| Path::new(&folder).join(name)).find(|path| path.is_file())
}

fn names_in(folder: &Path) -> Vec<String> {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).into_iter().flatten().take(MAX_FILES).flatten();
    entries.filter_map(|entry| entry.file_name().into_string().ok()).collect()
}

/// How far two names are from each other, if they may have been confused.
fn distance(name: &str, other: &str) -> Option<usize> {
    let ((stem, extension), (other_stem, other_extension)) = (parts(name), parts(other));
    let is_of_kind = extension == other_extension || (extension.is_empty() && other_extension == "txt");
    if !is_of_kind || other.len() > MAX_LENGTH {
        return None;
    }
    const LEAST_START: usize = 4;
    if stem.len() >= LEAST_START && other_stem.starts_with(&stem) {
        return Some(0);
    }
    let distance = strsim::levenshtein(&stem, &other_stem);
    (distance <= ((stem.chars().count() + 1) / 3).max(1)).then_some(distance)
}

/// The lower-case name without its extension, and the extension.
fn parts(name: &str) -> (String, String) {
    let name = name.to_lowercase();
    let (stem, extension) = name.rsplit_once('.').unwrap_or((&name, ""));
    (stem.to_owned(), extension.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_nearly_there() {
        for (name, other, expected) in [
            ("scene6_1_sphere.txt", "scene6_01_sphere.txt", Some(1)),
            ("scene6_01.txt", "scene6_01_sphere.txt", Some(0)),
            ("Scene.TXT", "scene.txt", Some(0)),
            ("scene.txt", "scene.obj", None),
            ("scene", "scene.txt", Some(0)),
            ("scene", "scene.obj", None),
            ("a.txt", "b.txt", Some(1)),
            ("ab.txt", "xy.txt", None),
            ("s.txt", "scene.txt", None),
        ] {
            assert_eq!(distance(name, other), expected, "{name} {other}");
        }
    }

    #[test]
    fn the_nearest_is_found_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["scene_1.txt", "scene_20.txt", "other.txt"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let near = |name: &str| nearest_file(&folder.path().join(name));
        assert_eq!(near("scene_2.txt"), Some(folder.path().join("scene_20.txt")));
        assert_eq!(near("scene_3.txt"), Some(folder.path().join("scene_1.txt")));
        assert_eq!(near("scen_20.txt"), Some(folder.path().join("scene_20.txt")));
        // One that is there, but is no file that could be read.
        assert_eq!(near("scene_1.txt"), Some(folder.path().join("scene_20.txt")));
        assert_eq!(near("teapot.txt"), None);
        // Neither the name itself, should it be no file, nor a folder.
        fs::create_dir(folder.path().join("folder_1.txt")).unwrap();
        assert_eq!((near("folder_1.txt"), near("folder_2.txt")), (None, None));
        assert_eq!(nearest_file(&folder.path().join("none").join("other.txt")), None);
    }
}
