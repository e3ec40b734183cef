//! Reads a scene from its file, with its meshes and pictures.

mod named_files;

use crate::base::escape::quoted;
use crate::base::patience::{Endless, Patience};
use crate::base::stdio::is_stdio;
use crate::diagnostic::{Diagnostic, limited};
use crate::image_io::ReadFile;
use crate::scene::edition::{Choice, Edition, newer_language};
use crate::scene::foreign_format::is_wide_text;
use crate::scene::lexer::Lexer;
use crate::scene::material::{Material, Paint};
use crate::scene::mesh::{Mesh, NamedFile, ObjFile};
use crate::scene::model::Shows;
use crate::scene::obj;
use crate::scene::parser::{self, Reading, Unfinished};
use crate::scene::texels::{ImageFile, Texels};
use crate::scene::{MeshFile, Position, Scene};
pub use named_files::{Found, mesh_places};
use named_files::{files_of_mesh, files_of_scene, nearest_file, read_mesh, read_texels};
#[cfg(feature = "gui")]
pub(crate) use named_files::{image_unreadable, in_mesh, mesh_unreadable};
use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A scene with its meshes and pictures.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    pub scene: Scene,
    /// The meshes, in the order of [`Scene::meshes`].
    pub meshes: Vec<Mesh>,
    /// The paths of the mesh files.
    pub mesh_files: Vec<PathBuf>,
    /// The files that the scene or a mesh names and that have no effect, such as bump maps and material libraries.
    pub unread: Vec<ReadFile>,
    pub source: Source,
    /// Warnings about the text and the meshes: at most 20 of each kind, then the number of the others.
    pub warnings: Vec<Diagnostic>,
    /// The edition in whose language the scene was read.
    pub choice: Choice,
}

impl LoadedScene {
    /// Returns the files that the scene and its meshes name, whether they are read or not. The meshes come first.
    pub fn files(&self) -> Vec<ReadFile> {
        let meshes = self.mesh_files.iter().map(|mesh| ("mesh", mesh.clone()));
        let pictures = self.scene.images.iter().filter_map(|image| Some(("texture", image.file.clone()?)));
        meshes.chain(pictures).chain(self.unread.iter().cloned()).collect()
    }

    /// Reads the meshes and the pictures that the scene names.
    fn read_files(&mut self, readers: Readers) -> Result<(), Diagnostic> {
        let (scene, edition) = (&mut self.scene, self.choice.edition);
        let folder = directory_of(&self.source.path);
        let is_image = |material: &Material| matches!(material, Material::Painted(_, Paint::Image { .. }));
        let is_textured = scene.materials.iter().any(is_image);
        for image in &mut scene.images {
            let (texels, file) = (readers.image)(image, edition)?;
            (image.texels, image.file) = (texels, Some(file));
        }
        let mut of_meshes = vec![];
        for named in &mut scene.meshes {
            let (found, file) = (readers.mesh)(named, edition, is_textured)?;
            named.vertices = found.vertices;
            named.texture_coordinates = Arc::new(found.texture_coordinates);
            self.unread.extend(files_of_mesh(&file, &found.files, folder, edition));
            self.meshes.push(found.mesh);
            self.mesh_files.push(file);
            of_meshes.extend(found.warnings);
        }
        self.warnings.extend(limited(of_meshes));
        Ok(())
    }
}

/// Information about a scene that is not in its text.
#[derive(Clone, Debug, Default)]
pub struct Hints {
    /// The edition, if the user chose one.
    pub edition: Option<Edition>,
    /// True if the picture shows pixel coordinates instead of the scene.
    pub shows_places: bool,
}

/// A scene's text without a byte order mark, and its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// The path as the user wrote it.
    pub path: PathBuf,
    pub text: String,
}

impl Source {
    /// Adds the file and the line of the text to an error or a warning.
    pub fn locate(&self, found: Diagnostic) -> Diagnostic {
        found.in_text(&self.path, &self.text)
    }
}

/// The largest size of a scene read from a pipe or a device, which may have no end.
const LONGEST_STREAM: u64 = 1 << 28;

/// Reads the scene at `path` and the files that it names. `-` is standard input. Fails if a file is unreadable or
/// malformed.
pub fn load(path: &Path) -> Result<LoadedScene, Diagnostic> {
    load_with(path, &Hints::default())
}

/// Reads a scene like [`load`], using `hints`.
pub fn load_with(path: &Path, hints: &Hints) -> Result<LoadedScene, Diagnostic> {
    let is_standard_input = is_stdio(path);
    let bytes = if is_standard_input { read_stream(io::stdin().lock()) } else { read_scene(path) };
    let path = if is_standard_input { Path::new("standard input") } else { path };
    let bytes = bytes.map_err(|error| unreadable(path, &error))?;
    let source = Source { path: path.to_owned(), text: decode(path, bytes)? };
    let directory = directory_of(path);
    let mesh = |file: &MeshFile, edition, is_textured| read_mesh(file, (directory, edition), is_textured);
    let image = |image: &ImageFile, edition| read_texels(image, (directory, edition));
    load_text(source, hints, Readers { mesh: &mesh, image: &image })
}

/// Functions that read the files named by a scene, given its edition.
#[derive(Clone, Copy)]
pub struct Readers<'a> {
    /// Reads a mesh, with texture coordinates if the last argument is true.
    pub mesh: &'a dyn Fn(&MeshFile, Edition, bool) -> Found<ObjFile>,
    /// Reads a picture.
    pub image: &'a dyn Fn(&ImageFile, Edition) -> Found<Arc<Texels>>,
}

/// Reads a scene from text, and the files that it names.
pub fn load_text(source: Source, hints: &Hints, readers: Readers) -> Result<LoadedScene, Diagnostic> {
    load_text_within(source, hints, readers, &Endless)
}

/// Reads a scene like [`load_text`], as long as there is patience. The readers have patience of their own.
pub(crate) fn load_text_within(
    source: Source,
    hints: &Hints,
    readers: Readers,
    patience: &dyn Patience,
) -> Result<LoadedScene, Diagnostic> {
    let words = read_words(&source.text, hints.edition, patience);
    let read = words.and_then(|(choice, unfinished)| Ok((choice, unfinished.finish(patience)?)));
    let (choice, reading) = read.map_err(|error| source.locate(error))?;
    let Reading { mut scene, unread, warnings } = reading;
    if hints.shows_places {
        scene.shows = Shows::Places;
    }
    let unread = files_of_scene(&unread, directory_of(&source.path), choice.edition);
    let (meshes, mesh_files) = (vec![], vec![]);
    let mut loaded = LoadedScene { scene, meshes, mesh_files, unread, source, warnings, choice };
    match loaded.read_files(readers) {
        Ok(()) => Ok(loaded),
        Err(error) => Err(loaded.source.locate(error)),
    }
}

/// Reads a scene in the language of an edition.
fn read_words(
    text: &str,
    named: Option<Edition>,
    patience: &dyn Patience,
) -> Result<(Choice, Unfinished), Diagnostic> {
    read_in_some(text, named, patience).map_err(|error| newer_language(text).unwrap_or(error))
}

/// Reads a scene in the language of the named edition. Without a name, tries 2004 first, then the edition that its
/// keywords identify.
fn read_in_some(
    text: &str,
    named: Option<Edition>,
    patience: &dyn Patience,
) -> Result<(Choice, Unfinished), Diagnostic> {
    let edition = named.unwrap_or_default();
    let error = match parser::read_words(edition, text, patience) {
        Ok(reading) => return Ok((Choice { edition, ..Choice::default() }, reading)),
        Err(error) => error,
    };
    let told = if named.is_none() { Edition::of_words(text) } else { None };
    let Some(mut choice) = told else { return Err(error) };
    match parser::read_words(choice.edition, text, patience) {
        Ok(reading) => {
            choice.others.retain(|&other| parser::read_words(other, text, patience).is_ok());
            Ok((choice, reading))
        }
        Err(error) => {
            let because = choice.because.unwrap_or_default();
            let read = format!("the scene is read as `-edition {}`, because of {because}", choice.edition);
            let hint = error.hint.as_ref().map_or(read.clone(), |hint| format!("{hint}; {read}"));
            Err(error.with_hint(hint))
        }
    }
}

fn unreadable(path: &Path, error: &io::Error) -> Diagnostic {
    let near = if error.kind() == io::ErrorKind::NotFound { nearest_file(path) } else { None };
    let hint = near.map(|near| format!("did you mean {}?", quoted(near)));
    Diagnostic { hint, ..Diagnostic::error(format!("cannot read the scene: {error}")) }.in_file(path)
}

fn read_scene(path: &Path) -> io::Result<Vec<u8>> {
    if fs::metadata(path)?.is_file() { fs::read(path) } else { read_stream(File::open(path)?) }
}

fn read_stream(stream: impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    match stream.take(LONGEST_STREAM + 1).read_to_end(&mut bytes)? as u64 {
        0..=LONGEST_STREAM => Ok(bytes),
        _ => Err(io::Error::other("it is longer than 256 MiB")),
    }
}

/// Returns the files that a scene and its meshes name, each at the first path where it exists. Returns nothing if the
/// scene is not a regular file or cannot be read.
pub fn named_files(scene: &Path, hints: &Hints) -> Vec<ReadFile> {
    let is_file = |path: &Path| fs::metadata(path).is_ok_and(|found| found.is_file());
    let bytes = if is_file(scene) { fs::read(scene).ok() } else { None };
    let text = bytes.and_then(|bytes| decode(scene, bytes).ok());
    let read = |text: String| read_words(&text, hints.edition, &Endless);
    let Some(Ok((Choice { edition, .. }, Unfinished { reading, .. }))) = text.map(read) else {
        return vec![];
    };
    let Reading { scene: named, unread, .. } = reading;
    let folder = directory_of(scene);
    let meshes = named.meshes.into_iter().map(|mesh| ("mesh", mesh.name));
    let images = named.images.into_iter().map(|image| ("texture", image.name));
    let all: Vec<NamedFile> = meshes.chain(images).chain(unread).collect();
    let mut found = files_of_scene(&all, folder, edition);
    for (kind, mesh) in found.clone() {
        if kind == "mesh"
            && is_file(&mesh)
            && let Ok(bytes) = fs::read(&mesh)
        {
            found.extend(files_of_mesh(&mesh, &obj::named_files(kind, &bytes), folder, edition));
        }
    }
    found
}

fn directory_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

/// Decodes a scene without its byte order mark. Comments may have any encoding that contains ASCII: bytes in them that
/// are not UTF-8 are replaced.
fn decode(path: &Path, bytes: Vec<u8>) -> Result<String, Diagnostic> {
    let not_utf8 = |at, hint| {
        let error = Diagnostic::error("the scene is not UTF-8 text").with_hint(hint);
        Err(error.at(at).in_file(path))
    };
    if is_wide_text(&bytes) {
        let hint = "this looks like UTF-16; save the file as UTF-8";
        return not_utf8(Position { line: 1, column: 1 }, hint);
    }
    let mut text = match String::from_utf8(bytes) {
        Ok(text) => text,
        Err(error) => {
            let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
            if let Some(at) = Lexer::new(&text).first(char::REPLACEMENT_CHARACTER) {
                return not_utf8(at, "save the file as UTF-8");
            }
            text
        }
    };
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
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

    /// Creates a directory with these files. The first file is the scene.
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
    fn backslashes_are_slashes_where_no_file_has_them_in_its_name() {
        let as_on_windows = mesh_scene(&["a\\m.obj"]);
        let mesh = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
        let (folder, scene) = directory(&[("s.txt", as_on_windows.as_bytes())]);
        fs::create_dir(folder.path().join("a")).unwrap();
        fs::write(folder.path().join("a/m.obj"), mesh).unwrap();
        assert_eq!(load(&scene).unwrap().meshes[0].triangles.len(), 1);
        assert_eq!(named_files(&scene, &Hints::default()), load(&scene).unwrap().files());
        if cfg!(unix) {
            let two = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 3 2 1";
            fs::write(folder.path().join("a\\m.obj"), two).unwrap();
            assert_eq!(load(&scene).unwrap().meshes[0].triangles.len(), 2);
        }
    }

    #[test]
    fn a_byte_order_mark_is_skipped() {
        let text = format!("\u{feff}{CAMERA}Grup");
        let message = refuse(&[("a.txt", text.as_bytes())]);
        assert!(message.contains("a.txt:2:1: error: expected"), "{message}");
    }

    #[test]
    fn comments_may_be_in_any_encoding() {
        let text = format!("{CAMERA}Group {{ numObjects 0 }}");
        // Latin-1, GBK with a brace as second byte, Shift-JIS with a backslash as second byte, and arbitrary bytes.
        for comment in [&b"# caf\xe9"[..], b"// \x81\x7b \x81\x7d", b"# \x83\x5c", b"#\x00\xfe\xff\x80"] {
            for end in [&b"\n"[..], b"\r", b"\r\n"] {
                let (_folder, scene) =
                    directory(&[("a.txt", &[comment, end, text.as_bytes(), comment].concat())]);
                let found = load(&scene).unwrap();
                assert_eq!(found.scene.objects.len(), 1);
                assert_eq!(found.scene.positions.camera, Position { line: 2, column: 1 });
            }
        }
    }
}
