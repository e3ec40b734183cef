//! Finds the file that a name means which is nearly right.

use std::fs;
use std::path::{Path, PathBuf};

/// The largest number of files that are looked at.
const MAX_FILES: usize = 10_000;
/// The longest name that is compared, in bytes, which bounds the time. Longer names have no files.
const MAX_LENGTH: usize = 255;
/// The least similarity, by Jaro and Winkler, of two names that may have been confused.
const LEAST_LIKENESS: f64 = 0.8;

/// Returns the other file in the folder of `path` with the most similar name and the same extension (or `.txt` for none),
/// if it is similar. If there is none, and `path` is a bare name, it is looked for in the folders of the working
/// directory.
pub fn nearest_file(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str().filter(|name| name.len() <= MAX_LENGTH)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let others = names_in(folder).into_iter().filter(|other| other != name);
    let near = others
        .map(|other| (likeness(name, &other), other))
        .filter(|(likeness, other)| *likeness >= LEAST_LIKENESS && folder.join(other).is_file())
        .max_by(|(one, name), (other, other_name)| one.total_cmp(other).then_with(|| other_name.cmp(name)));
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

/// Returns how similar two names are, from 0 to 1; 0 for files of different kinds.
fn likeness(name: &str, other: &str) -> f64 {
    let [name, other] = [name, other].map(str::to_lowercase);
    let [(stem, kind), (other_stem, other_kind)] =
        [&name, &other].map(|name| name.rsplit_once('.').unwrap_or((name, "txt")));
    if kind == other_kind { strsim::jaro_winkler(stem, other_stem) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_nearly_there() {
        for (name, other, is_near) in [
            ("scene6_1_sphere.txt", "scene6_01_sphere.txt", true),
            ("scene6_01.txt", "scene6_01_sphere.txt", true),
            ("Scene.TXT", "scene.txt", true),
            ("scene.txt", "scene.obj", false),
            ("scene", "scene.txt", true),
            ("scene", "scene.obj", false),
            ("tepaot.txt", "teapot.txt", true),
            ("ab.txt", "xy.txt", false),
            ("s.txt", "scene.txt", false),
            ("sphere.txt", "plane.txt", false),
        ] {
            assert_eq!(likeness(name, other) >= LEAST_LIKENESS, is_near, "{name} {other}");
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
