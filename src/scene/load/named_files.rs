//! The files that a scene names: where its meshes and its pictures lie, and what is in them.

use super::FoundMesh;
use super::near_names::nearest_file;
use crate::base::escape::{escape, quoted};
use crate::base::memory::{self, NoMemory};
use crate::diagnostic::{Diagnostic, Place};
use crate::image_io::load_picture;
use crate::scene::edition::Edition;
use crate::scene::mesh::{self, memory_for, read_obj};
use crate::scene::texels::{ImageFile, Texels};
use crate::scene::{MeshFile, Position};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where to look for a mesh or a picture: relative to the working directory, as the course's program does, then beside the
/// scene, unless that is the same; in some editions the other way round. In either folder, a file whose name has
/// backslashes comes before a path that is written with them, as on Windows.
pub fn mesh_places(name: &str, scene_directory: &Path, edition: Edition) -> Vec<PathBuf> {
    let with_slashes = name.replace('\\', "/");
    let mut places = Vec::new();
    let mut folders = [Path::new(""), scene_directory];
    if edition.starts_beside_scene() {
        folders.reverse();
    }
    for folder in folders {
        for place in [name, &with_slashes].map(|name| folder.join(name)) {
            if !places.contains(&place) {
                places.push(place);
            }
        }
    }
    places
}

/// Reads a picture that a scene names from the first place where there is one.
pub fn find_texels(
    ImageFile { name, at, .. }: &ImageFile,
    (folder, edition): (&Path, Edition),
) -> Result<(Arc<Texels>, PathBuf), Diagnostic> {
    let places = mesh_places(name, folder, edition);
    let place = places.iter().find(|place| place.symlink_metadata().is_ok()).or(places.first());
    let file = place.map(PathBuf::as_path).unwrap_or(Path::new(name));
    let (picture, _) = load_picture(file).map_err(|reason| Diagnostic {
        hint: hint_to_name(name, folder).or(reason.hint),
        ..image_unreadable(name, *at, &reason.message)
    })?;
    let size = [picture.width(), picture.height()].map(|n| n as usize);
    let rgb = picture.into_pixels();
    Ok((Arc::new(Texels { size, rgb, divides_last: edition.divides_texels_last() }), file.to_owned()))
}

/// The error of a picture that the scene names at a position.
pub fn image_unreadable(name: &str, at: Position, reason: &str) -> Diagnostic {
    Diagnostic::error(format!("cannot read the picture {}: {}", quoted(name), escape(reason))).at(at)
}

/// The error of a mesh that the scene names at a position, with the paths that were tried and the reason for each.
pub fn mesh_unreadable(name: &str, at: Position, tried: &[(String, String)]) -> Diagnostic {
    let tried: Vec<String> =
        tried.iter().map(|(path, reason)| format!("{} ({})", quoted(path), escape(reason))).collect();
    Diagnostic::error(format!("cannot read the mesh {}: tried {}", quoted(name), tried.join(", then ")))
        .at(at)
}

/// An error or a warning about the contents of a mesh file, which the scene names at a position.
pub fn in_mesh(found: Diagnostic, named_at: Position, file: &str, bytes: &[u8]) -> Diagnostic {
    let line = found.position().map(|at| format!("line {}: ", at.line)).unwrap_or_default();
    let message = format!("in the mesh {}: {line}{}", quoted(file), found.message);
    let mut found = found.in_text(Path::new(file), &mesh::text(bytes));
    found.places.insert(0, Place { at: Some(named_at), ..Place::default() });
    Diagnostic { message, ..found }
}

/// Reads the mesh that a scene names from the first place where it can be read.
pub fn read_mesh(
    MeshFile { name, at, .. }: &MeshFile,
    (scene_directory, edition): (&Path, Edition),
    is_textured: bool,
) -> Result<FoundMesh, Diagnostic> {
    let mut tried = Vec::new();
    for place in mesh_places(name, scene_directory, edition) {
        match read_mesh_file(&place)? {
            Ok(bytes) => {
                let in_mesh = |found| in_mesh(found, *at, &lossy(&place), &bytes);
                let content = read_obj(&bytes, is_textured).map_err(in_mesh)?;
                let warnings = content.doubts.iter().map(|doubt| in_mesh(doubt.clone())).collect();
                return Ok(FoundMesh { content, file: place, warnings });
            }
            Err(reason) => tried.push((lossy(&place), reason)),
        }
    }
    Err(Diagnostic { hint: hint_to_name(name, scene_directory), ..mesh_unreadable(name, *at, &tried) })
}

/// The bytes of a mesh, or the reason why there are none. Only a regular file is read, because a pipe could block the
/// program and a device may have no end. Too little memory for the mesh is an error.
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

/// Advice on the name of a mesh or a picture for which there is no file: the name of one that is there.
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

/// The ends of a path of any system, from the longest to the name alone, without one that would lead elsewhere.
fn ends_of_path(path: &str) -> Vec<String> {
    /// How many folders the longest has, which bounds the time.
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
}
