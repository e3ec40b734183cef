//! Finds and reads the meshes and pictures that a scene names, and suggests the right file for a wrong name.

use crate::base::escape::{escape, quoted};
use crate::base::memory::{self, NoMemory};
use crate::base::patience::Endless;
use crate::diagnostic::{Diagnostic, Place};
use crate::image_io::{ReadFile, Wanted, load_pixels};
use crate::scene::edition::Edition;
use crate::scene::mesh::{NamedFile, ObjFile};
use crate::scene::obj::{self, LIBRARY, memory_for, read_obj};
use crate::scene::texels::{ImageFile, Texels};
use crate::scene::{MeshFile, Position};
use std::collections::BTreeSet;
use std::fs::{self, Metadata};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The contents of a file that a scene names, and its path.
pub type Found<T> = Result<(T, PathBuf), Diagnostic>;

/// The largest number of files examined.
const MAX_FILES: usize = 10_000;
/// The longest name compared, in bytes, which bounds the time. Longer names have no files.
const MAX_LENGTH: usize = 255;
/// The smallest Jaro-Winkler similarity of two names that may have been confused.
const LEAST_LIKENESS: f64 = 0.8;

/// Returns the paths to try for a mesh or a picture. The first folder is the working directory, as in the course's
/// program, the second is the scene's directory if it differs. Some editions reverse this order. In each folder, a name
/// with literal backslashes comes before the same path with slashes, as on Windows.
pub fn mesh_places(name: &str, scene_directory: &Path, edition: Edition) -> Vec<PathBuf> {
    places_in(name, &folders(scene_directory, edition))
}

fn folders(scene_directory: &Path, edition: Edition) -> [&Path; 2] {
    let working_directory = Path::new("");
    if edition.starts_beside_scene() {
        [scene_directory, working_directory]
    } else {
        [working_directory, scene_directory]
    }
}

fn places_in(name: &str, folders: &[&Path]) -> Vec<PathBuf> {
    let with_slashes = name.replace('\\', "/");
    let mut places = Vec::new();
    for folder in folders {
        for place in [name, &with_slashes].map(|name| folder.join(name)) {
            if !places.contains(&place) {
                places.push(place);
            }
        }
    }
    places
}

/// Reads a picture from the first path that exists.
pub fn read_texels(
    ImageFile { name, at, .. }: &ImageFile,
    (folder, edition): (&Path, Edition),
) -> Found<Arc<Texels>> {
    let mut places = mesh_places(name, folder, edition);
    let first = places.iter().position(|place| place.symlink_metadata().is_ok());
    let file = places.swap_remove(first.unwrap_or(0));
    let (picture, _) = load_pixels(&file, Wanted::Bytes).map_err(|reason| Diagnostic {
        hint: hint_to_name(name, folder).or(reason.hint),
        ..image_unreadable(name, *at, &reason.message)
    })?;
    let (size, rgb) = (picture.size(), picture.into_bytes().into_pixels());
    Ok((Arc::new(Texels { size, rgb, divides_last: edition.divides_texels_last() }), file))
}

/// Returns the files that a scene names and that exist.
pub fn files_of_scene(named: &[NamedFile], scene_directory: &Path, edition: Edition) -> Vec<ReadFile> {
    existing_files(named, &folders(scene_directory, edition))
}

/// Returns the files that a mesh names and that exist, with the pictures that its material libraries name. Each is
/// looked for beside the file that names it, then where a mesh would be.
pub fn files_of_mesh(
    mesh: &Path,
    named: &[NamedFile],
    scene_directory: &Path,
    edition: Edition,
) -> Vec<ReadFile> {
    /// The length of the largest material library that is read.
    const LONGEST: u64 = 1 << 24;
    let [first, second] = folders(scene_directory, edition);
    let find = |named: &[NamedFile], file: &Path| {
        existing_files(named, &[file.parent().unwrap_or(Path::new("")), first, second])
    };
    let mut found = find(named, mesh);
    // A library may be named in several ways.
    let mut read = BTreeSet::new();
    for (kind, library) in found.clone() {
        let is_short = |found: Metadata| found.is_file() && found.len() <= LONGEST;
        if kind == LIBRARY
            && fs::metadata(&library).is_ok_and(is_short)
            && fs::canonicalize(&library).is_ok_and(|path| read.insert(path))
            && let Ok(bytes) = fs::read(&library)
        {
            found.extend(find(&obj::named_files(kind, &bytes), &library));
        }
    }
    found
}

fn existing_files(named: &[NamedFile], folders: &[&Path]) -> Vec<ReadFile> {
    let find = |(kind, name): &NamedFile| {
        let mut places = places_in(name, folders).into_iter();
        Some((*kind, places.find(|place| place.is_file())?))
    };
    named.iter().filter_map(find).collect()
}

/// Returns the error for a picture that the scene names at this position.
pub fn image_unreadable(name: &str, at: Position, reason: &str) -> Diagnostic {
    Diagnostic::error(format!("cannot read the texture {}: {}", quoted(name), escape(reason))).at(at)
}

/// Returns the error for a mesh that the scene names at this position, with each path tried and the reason why it
/// failed.
pub fn mesh_unreadable(name: &str, at: Position, tried: &[(String, String)]) -> Diagnostic {
    let tried: Vec<String> =
        tried.iter().map(|(path, reason)| format!("{} ({})", quoted(path), escape(reason))).collect();
    Diagnostic::error(format!("cannot read the mesh {}: tried {}", quoted(name), tried.join(", then ")))
        .at(at)
}

/// Locates an error or a warning in a mesh file, and adds the position where the scene names the mesh.
pub fn in_mesh(found: Diagnostic, named_at: Position, file: &str, bytes: &[u8]) -> Diagnostic {
    let line = found.position().map(|at| format!("line {}: ", at.line)).unwrap_or_default();
    let message = format!("in the mesh {}: {line}{}", quoted(file), found.message);
    let mut found = found.in_text(Path::new(file), &obj::text(bytes));
    found.places.insert(0, Place { at: Some(named_at), ..Place::default() });
    Diagnostic { message, ..found }
}

/// Reads a mesh from the first readable path.
pub fn read_mesh(
    MeshFile { name, at, .. }: &MeshFile,
    (scene_directory, edition): (&Path, Edition),
    is_textured: bool,
) -> Found<ObjFile> {
    let mut tried = Vec::new();
    for place in mesh_places(name, scene_directory, edition) {
        match read_mesh_file(&place)? {
            Ok(bytes) => {
                let in_mesh = |found| in_mesh(found, *at, &lossy(&place), &bytes);
                let mut file = read_obj(&bytes, is_textured, &Endless).map_err(in_mesh)?;
                file.warnings = file.warnings.into_iter().map(in_mesh).collect();
                return Ok((file, place));
            }
            Err(reason) => tried.push((lossy(&place), reason)),
        }
    }
    Err(Diagnostic { hint: hint_to_name(name, scene_directory), ..mesh_unreadable(name, *at, &tried) })
}

/// Returns the bytes of a mesh, or the reason why they cannot be read. Reads only regular files, because a pipe could
/// block the program and a device may have no end. Fails if memory is too small for the mesh.
fn read_mesh_file(place: &Path) -> Result<Result<Vec<u8>, String>, NoMemory> {
    let length = match fs::metadata(place) {
        Ok(found) if found.is_file() => found.len(),
        Ok(found) if found.is_dir() => return Ok(Err("it is a folder".into())),
        Ok(_) => return Ok(Err("it is a pipe or a device, not a regular file".into())),
        Err(error) => return Ok(Err(error.to_string())),
    };
    memory::ask(memory_for(length))?;
    Ok(fs::read(place).map_err(|error| error.to_string()))
}

/// Suggests an existing file for a mesh or a picture that is missing.
fn hint_to_name(name: &str, scene_directory: &Path) -> Option<String> {
    let is_there = |place: &PathBuf| place.symlink_metadata().is_ok();
    let places = mesh_places(name, scene_directory, Edition::Y2004);
    if places.iter().any(is_there) {
        return None;
    }
    let ends = ends_of_path(name);
    if let Some(end) = ends.iter().find(|end| scene_directory.join(end).is_file()) {
        return Some(format!("`{}` lies beside the scene", escape(end)));
    }
    let beside = ends.last().map(|end| scene_directory.join(end));
    let near = places.iter().chain(&beside).find_map(|place| nearest_file(place))?;
    let from_scene = near.strip_prefix(scene_directory).unwrap_or(&near);
    Some(format!("did you mean `{}`?", escape(&lossy(from_scene))))
}

/// Returns the ends of a path of any system, from the longest to the bare name, stopping at `.` and `..`.
fn ends_of_path(path: &str) -> Vec<String> {
    /// The largest number of folders in an end, which bounds the time.
    const MOST: usize = 8;
    let parts = path.split(['/', '\\']).filter(|part| !part.is_empty());
    let mut parts: Vec<&str> =
        parts.rev().take(MOST + 1).take_while(|part| !matches!(*part, "." | "..")).collect();
    parts.reverse();
    (0..parts.len()).map(|start| parts[start..].join("/")).collect()
}

fn lossy(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

/// Returns the other file in the folder of `path` with the most similar name and the same extension (`.txt` if it has
/// none), if similar enough. If there is none and `path` is a bare name, searches the subfolders of the working
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

/// Returns the similarity of two names, from 0 to 1. Files with different extensions have 0.
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
    fn the_working_directory_comes_first() {
        assert_eq!(
            mesh_places("m.obj", Path::new("s"), Edition::Y2004),
            [Path::new("m.obj"), Path::new("s/m.obj")]
        );
        assert_eq!(mesh_places("m.obj", Path::new(""), Edition::Y2004), [Path::new("m.obj")]);
        assert_eq!(mesh_places("/m.obj", Path::new("s"), Edition::Y2004), [Path::new("/m.obj")]);
    }

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
        // Never suggests the file itself, even if it exists.
        assert_eq!(near("scene_1.txt"), Some(folder.path().join("scene_20.txt")));
        assert_eq!(near("teapot.txt"), None);
        // Suggests neither the name itself, even if it is not a file, nor a folder.
        fs::create_dir(folder.path().join("folder_1.txt")).unwrap();
        assert_eq!((near("folder_1.txt"), near("folder_2.txt")), (None, None));
        assert_eq!(nearest_file(&folder.path().join("none").join("other.txt")), None);
    }

    #[test]
    fn a_library_that_is_named_in_two_ways_is_read_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("x.mtl"), "map_Kd t.png").unwrap();
        fs::write(path("t.png"), "").unwrap();
        let named = ["x.mtl", "./x.mtl"].map(|name| (LIBRARY, name.to_owned()));
        let found = files_of_mesh(&path("m.obj"), &named, folder.path(), Edition::Y2004);
        assert_eq!(found.iter().filter(|(kind, _)| *kind == "texture").count(), 1);
    }
}
