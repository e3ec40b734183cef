//! Reads a scene and its meshes from files.

mod error;

use crate::escape::escape;
use crate::memory;
use crate::near_names::nearest_file;
use crate::scene::error::{Problem, SceneError};
use crate::scene::mesh::{Mesh, memory_for, read_obj};
use crate::scene::parser::{self, Places, Reading};
use crate::scene::recovery::MAX_ERRORS;
use crate::scene::warning::SceneWarning;
use crate::scene::{MeshFile, Scene};
pub use error::LoadError;
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// A scene with everything that it names.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What the file says.
    pub scene: Scene,
    /// By the index in [`Scene::meshes`].
    pub meshes: Vec<Mesh>,
    /// Where each mesh was found.
    pub mesh_files: Vec<PathBuf>,
    /// What the scene was read from, to show where a later error lies.
    pub source: Source,
    /// What its text says without an error, but hardly on purpose.
    pub warnings: Vec<SceneWarning>,
    /// Where its text says what.
    pub places: Places,
}

/// A scene's text, without a byte order mark, and the file that it comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The file, as it was named.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

impl Source {
    /// The whole message for an error in this text, as [`SceneError::render`] gives it.
    pub fn render(&self, error: &SceneError) -> String {
        error.render(&self.path, &self.text)
    }
}

/// Upper bound on the size of a scene that comes from a pipe or a device, which may have no end.
const LONGEST_STREAM: u64 = 1 << 28;

/// Reads the scene at `path` and every mesh that it names. `-` is standard input.
///
/// A mesh is looked for in the working directory and then beside the scene, and read once however
/// often it is named. Errors: an unreadable or malformed scene, or mesh.
pub fn load(path: &Path) -> Result<LoadedScene, LoadError> {
    load_announcing(path, &|_| ())
}

/// The same. `announce` is told the size of each mesh's file, in bytes, before it is parsed.
pub fn load_announcing(path: &Path, announce: &dyn Fn(usize)) -> Result<LoadedScene, LoadError> {
    let is_standard_input = path == Path::new("-");
    let bytes = if is_standard_input { read_stream(io::stdin().lock()) } else { read_scene(path) };
    let path = if is_standard_input { Path::new("standard input") } else { path };
    let bytes = bytes.map_err(|error| LoadError::Unreadable { path: path.to_owned(), error })?;
    load_source(Source { path: path.to_owned(), text: decode(path, bytes)? }, announce)
}

/// Reads a scene from the text of its file.
pub fn load_source(source: Source, announce: &dyn Fn(usize)) -> Result<LoadedScene, LoadError> {
    let path = source.path.clone();
    let directory = path.parent().unwrap_or(Path::new(""));
    let read = |file: &MeshFile| {
        read_mesh(file, directory, announce).map_err(|problem| SceneError {
            at: file.at,
            hint: problem.mesh_hint().or_else(|| hint_to_name(&problem, directory)),
            problem,
        })
    };
    load_text(source, &read)
}

/// A mesh that a scene names.
#[derive(Debug)]
pub struct FoundMesh {
    /// The mesh.
    pub mesh: Mesh,
    /// Its file.
    pub file: PathBuf,
    /// What the file says without an error, but hardly on purpose.
    pub warnings: Vec<SceneWarning>,
}

/// Reads a mesh that a scene names.
pub type ReadMesh<'a> = &'a dyn Fn(&MeshFile) -> Result<FoundMesh, SceneError>;

/// Reads a scene from its text. `read_mesh` reads each mesh that it names.
pub fn load_text(source: Source, read_mesh: ReadMesh) -> Result<LoadedScene, LoadError> {
    match read_with_meshes(&source.text, read_mesh) {
        Ok((Reading { scene, mut warnings, places }, found)) => {
            let (mut meshes, mut mesh_files) = (vec![], vec![]);
            for found in found {
                meshes.push(found.mesh);
                mesh_files.push(found.file);
                warnings.extend(found.warnings);
            }
            Ok(LoadedScene { scene, meshes, mesh_files, source, warnings, places })
        }
        Err(errors) => Err(LoadError::Scene { source, errors }),
    }
}

fn read_scene(path: &Path) -> io::Result<Vec<u8>> {
    if fs::metadata(path)?.is_file() { fs::read(path) } else { read_stream(File::open(path)?) }
}

fn read_stream(stream: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match stream.take(LONGEST_STREAM + 1).read_to_end(&mut bytes)? as u64 {
        0..=LONGEST_STREAM => Ok(bytes),
        _ => Err(io::Error::other("it does not end after 256 MiB")),
    }
}

fn read_with_meshes(text: &str, read_mesh: ReadMesh) -> Result<(Reading, Vec<FoundMesh>), Vec<SceneError>> {
    let reading = parser::read(text)?;
    let (mut meshes, mut errors) = (vec![], vec![]);
    for file in &reading.scene.meshes {
        match read_mesh(file) {
            Ok(mesh) => meshes.push(mesh),
            Err(error) => errors.push(error),
        }
        if errors.len() == MAX_ERRORS {
            break;
        }
    }
    if errors.is_empty() { Ok((reading, meshes)) } else { Err(errors) }
}

/// Advice on a mesh's name for which there is no file: the name of one that is there.
fn hint_to_name(problem: &Problem, scene_directory: &Path) -> Option<String> {
    let Problem::MeshUnreadable { name, .. } = problem else { return None };
    let is_there = |place: &PathBuf| place.symlink_metadata().is_ok();
    if mesh_places(name, scene_directory).iter().any(is_there) {
        return None;
    }
    let near = mesh_places(name, scene_directory).iter().find_map(|place| nearest_file(place))?;
    let from_scene = near.strip_prefix(scene_directory).unwrap_or(&near);
    Some(format!("did you mean `{}`?", escape(&lossy(from_scene))))
}

/// Reads the mesh that a scene names from the first place where it can be read.
fn read_mesh(
    MeshFile { name, at }: &MeshFile,
    scene_directory: &Path,
    announce: &dyn Fn(usize),
) -> Result<FoundMesh, Problem> {
    let mut tried = Vec::new();
    for place in mesh_places(name, scene_directory) {
        match read_mesh_file(&place)? {
            Ok(bytes) => {
                announce(bytes.len());
                let (mesh, doubts) =
                    read_obj(&bytes).map_err(|error| Problem::of_mesh(lossy(&place), error, &bytes))?;
                let warning = |doubt| SceneWarning::in_mesh(*at, lossy(&place), doubt, &bytes);
                let warnings = doubts.into_iter().map(warning).collect();
                return Ok(FoundMesh { mesh, file: place, warnings });
            }
            Err(reason) => tried.push((lossy(&place), reason)),
        }
    }
    Err(Problem::MeshUnreadable { name: name.to_owned(), tried })
}

/// The bytes of a mesh, or the reason why there are none. Only a regular file is read, because a pipe could block the
/// program and a device may have no end. Too little memory for the mesh is an error.
fn read_mesh_file(place: &Path) -> Result<Result<Vec<u8>, String>, Problem> {
    let length = match fs::metadata(place) {
        Ok(found) if found.is_file() => found.len(),
        Ok(found) if found.is_dir() => return Ok(Err("it is a folder".into())),
        Ok(_) => return Ok(Err("it is a pipe or a device, not a regular file".into())),
        Err(error) => return Ok(Err(error.to_string())),
    };
    memory::ask(memory_for(length)).map_err(Problem::Memory)?;
    Ok(fs::read(place).map_err(|error| error.to_string()))
}

/// The files that are read for the meshes of a scene, each in the first place where it is; none of a scene that is no
/// regular file or cannot be read.
pub fn mesh_files(scene: &Path) -> Vec<PathBuf> {
    let is_file = |path: &Path| fs::metadata(path).is_ok_and(|found| found.is_file());
    let bytes = if is_file(scene) { fs::read(scene).ok() } else { None };
    let text = bytes.and_then(|bytes| decode(scene, bytes).ok());
    let Some(Ok(Reading { scene: named, .. })) = text.map(|text| parser::read(&text)) else { return vec![] };
    let folder = scene.parent().unwrap_or(Path::new(""));
    let find = |file: &MeshFile| mesh_places(&file.name, folder).into_iter().find(|place| is_file(place));
    named.meshes.iter().filter_map(find).collect()
}

/// Where to look for a mesh: relative to the working directory, as the course's program does, then beside the scene,
/// unless that is the same. In either folder, a file whose name has backslashes comes before a path that is written with
/// them, as on Windows.
pub fn mesh_places(name: &str, scene_directory: &Path) -> Vec<PathBuf> {
    let with_slashes = name.replace('\\', "/");
    let mut places = Vec::new();
    for folder in [Path::new(""), scene_directory] {
        for place in [name, &with_slashes].map(|name| folder.join(name)) {
            if !places.contains(&place) {
                places.push(place);
            }
        }
    }
    places
}

/// The text in a scene's bytes, without a byte order mark.
fn decode(path: &Path, bytes: Vec<u8>) -> Result<String, LoadError> {
    let mut text = String::from_utf8(bytes).map_err(|error| not_utf8(path, &error))?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

fn not_utf8(path: &Path, error: &std::string::FromUtf8Error) -> LoadError {
    let bytes = error.as_bytes();
    let good = String::from_utf8_lossy(&bytes[..error.utf8_error().valid_up_to()]);
    let last_line = good.rsplit('\n').next().unwrap_or_default();
    LoadError::NotUtf8 {
        path: path.to_owned(),
        line: good.matches('\n').count() + 1,
        column: last_line.chars().count() + 1,
        is_utf16: bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff"),
    }
}

fn lossy(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;

    const CAMERA: &str = "OrthographicCamera { center 0 0 0 direction 0 0 -1 up 0 1 0 size 1 }\n";

    fn mesh_scene(names: &[&str]) -> String {
        let meshes: String =
            names.iter().map(|name| format!("TriangleMesh {{ obj_file {name} }}\n")).collect();
        format!("{CAMERA}Group {{ numObjects {} Material {{ }}\n{meshes}}}", names.len())
    }

    /// A directory with these files, the first of which is the scene.
    fn directory(files: &[(&str, &[u8])]) -> (TempDir, PathBuf) {
        let directory = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            fs::write(directory.path().join(name), bytes).unwrap();
        }
        let scene = directory.path().join(files[0].0);
        (directory, scene)
    }

    fn refuse(files: &[(&str, &[u8])]) -> String {
        let (_directory, scene) = directory(files);
        load(&scene).unwrap_err().to_string()
    }

    #[test]
    fn meshes_are_found_beside_the_scene_and_read_once() {
        let text = mesh_scene(&["one.obj", "two.obj", "one.obj"]);
        let one = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
        let two = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1";
        let (_directory, path) = directory(&[("a.txt", text.as_bytes()), ("one.obj", one), ("two.obj", two)]);
        let loaded = load(&path).unwrap();
        assert_eq!(loaded.meshes.iter().map(|mesh| mesh.triangles.len()).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(loaded.source, Source { path, text });
    }

    #[test]
    fn the_working_directory_comes_first() {
        assert_eq!(mesh_places("m.obj", Path::new("s")), [Path::new("m.obj"), Path::new("s/m.obj")]);
        assert_eq!(mesh_places("m.obj", Path::new("")), [Path::new("m.obj")]);
        assert_eq!(mesh_places("/m.obj", Path::new("s")), [Path::new("/m.obj")]);
    }

    #[test]
    fn backslashes_are_slashes_where_no_file_has_them_in_its_name() {
        let as_on_windows = mesh_scene(&["a\\m.obj"]);
        let mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
        let (folder, scene) = directory(&[("s.txt", as_on_windows.as_bytes())]);
        fs::create_dir(folder.path().join("a")).unwrap();
        fs::write(folder.path().join("a/m.obj"), mesh).unwrap();
        assert_eq!(load(&scene).unwrap().meshes[0].triangles.len(), 1);
        assert_eq!(mesh_files(&scene), load(&scene).unwrap().mesh_files);
        if cfg!(unix) {
            let two = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1";
            fs::write(folder.path().join("a\\m.obj"), two).unwrap();
            assert_eq!(load(&scene).unwrap().meshes[0].triangles.len(), 2);
        }
    }

    #[test]
    fn a_missing_scene() {
        let message = load(Path::new("no/such.txt")).unwrap_err().to_string();
        assert!(message.starts_with("no/such.txt: error: cannot read the scene: "), "{message}");
    }

    #[test]
    fn a_missing_mesh_is_shown_in_the_scene() {
        let text = mesh_scene(&["no-such.obj"]);
        let message = refuse(&[("a.txt", text.as_bytes())]);
        for part in
            ["a.txt:3:25: error: cannot read the mesh `no-such.obj`: tried `no-such.obj` (", ", then `", "^"]
        {
            assert!(message.contains(part), "{message}");
        }
    }

    #[test]
    fn a_broken_mesh_names_both_files() {
        let text = mesh_scene(&["bad.obj"]);
        let message = refuse(&[("a.txt", text.as_bytes()), ("bad.obj", b"v 0 0 0\nf 1 1 2")]);
        assert!(message.contains("a.txt:3:25: error: in the mesh `"), "{message}");
        assert!(message.contains("bad.obj`: line 2: a face names a vertex"), "{message}");
    }

    #[test]
    fn a_byte_order_mark_is_skipped() {
        let text = format!("\u{feff}{CAMERA}Grup");
        let message = refuse(&[("a.txt", text.as_bytes())]);
        assert!(message.contains("a.txt:2:1: error: expected"), "{message}");
    }

    #[test]
    fn other_encodings_are_refused() {
        let message = refuse(&[("a.txt", b"# ok\n# \xc3\xa9 \xe9\n")]);
        assert!(message.ends_with("a.txt:2:5: error: the scene is not UTF-8 text"), "{message}");
        let message = refuse(&[("a.txt", b"\xff\xfeG\0r\0")]);
        assert!(message.contains("a.txt:1:1: error:") && message.contains("UTF-16"), "{message}");
    }
}
