//! The scenes that are open: the one of the command line, and the one that was typed in last.

use super::limits::{BYTES_PER_PRIMITIVE, MAX_MESH_FILE, MAX_MESHES, MAX_PRIMITIVES};
use crate::diagnostic::Diagnostic;
use crate::memory;
use crate::renderer::{Meshes, Renderer};
use crate::scene::edition::{Choice, Edition};
use crate::scene::mesh::{Mesh, ObjFile, memory_for, read_obj};
use crate::scene::texels::ImageFile;
use crate::scene::{MeshFile, Object};
use crate::scene_io::{
    self, FoundMesh, Hints, LoadedScene, Readers, Source, image_unreadable, in_mesh, mesh_unreadable,
};
use rayon::ThreadPool;
use std::cell::Cell;
use std::collections::HashMap;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

/// A scene that can be rendered.
#[derive(Debug)]
pub struct OpenScene {
    /// By which a page names it; 0 is the command line's.
    pub revision: u64,
    /// The edition that was named, if any.
    pub named: Option<Edition>,
    /// The one that it was read in.
    pub choice: Choice,
    pub renderer: Renderer,
}

/// The open scenes: the command line's, and the one that was typed in last.
pub struct Stage {
    path: PathBuf,
    hints: Hints,
    /// Those of the command line's scene, which may stand anywhere.
    meshes: HashMap<String, Mesh>,
    first: Arc<OpenScene>,
    typed: Option<Arc<OpenScene>>,
    threads: Arc<ThreadPool>,
}

impl Stage {
    /// Opens the scene of the command line, from this text where it is known already.
    pub fn open(
        path: &Path,
        text: Option<String>,
        hints: &Hints,
        threads: Arc<ThreadPool>,
    ) -> Result<Self, Diagnostic> {
        let loaded = match text {
            Some(text) => scene_io::load_source(Source { path: path.to_owned(), text }, hints, &|_| ())?,
            None => scene_io::load_announcing(path, hints, &|_| ())?,
        };
        let choice = loaded.choice.clone();
        let renderer = Renderer::new(loaded, Meshes::Kept)?.on_threads(threads.clone());
        let names = renderer.scene.meshes.iter().map(|file| file.name.clone());
        let meshes = names.zip(renderer.meshes().iter().cloned()).collect();
        let first = Arc::new(OpenScene { revision: 0, named: hints.edition, choice, renderer });
        Ok(Self { path: path.to_owned(), hints: hints.clone(), meshes, first, typed: None, threads })
    }

    /// The scene of the command line.
    pub fn first(&self) -> &Arc<OpenScene> {
        &self.first
    }

    /// The scene of this revision, if it is open.
    pub fn scene(&self, revision: u64) -> Option<Arc<OpenScene>> {
        [&self.first].into_iter().chain(&self.typed).find(|scene| scene.revision == revision).cloned()
    }

    /// Opens a text in place of the one that was typed in before, in this edition if one is named.
    pub fn type_in(
        &mut self,
        revision: u64,
        text: String,
        named: Option<Edition>,
    ) -> Result<Arc<OpenScene>, Diagnostic> {
        let source = Source { path: self.path.clone(), text };
        let (choice, renderer) = self.renderer(source, named)?;
        let renderer = renderer.on_threads(self.threads.clone());
        let scene = Arc::new(OpenScene { revision, named, choice, renderer });
        self.typed = Some(scene.clone());
        Ok(scene)
    }

    fn renderer(&self, source: Source, named: Option<Edition>) -> Result<(Choice, Renderer), Diagnostic> {
        let folder = self.path.parent().unwrap_or(Path::new(""));
        let files = Cell::new(0);
        let first = &self.first.renderer.scene;
        let find = |named: &MeshFile, is_textured| match self.meshes.get(&named.name) {
            Some(mesh) => {
                let known =
                    first.meshes.iter().find(|file| file.name == named.name).cloned().unwrap_or_default();
                let texture_coordinates = known.texture_coordinates.to_vec();
                Ok(ObjFile {
                    mesh: mesh.clone(),
                    vertices: known.vertices,
                    texture_coordinates,
                    doubts: vec![],
                })
            }
            None if files.replace(files.get() + 1) >= MAX_MESHES => {
                Err(refused(named, &format!("a page opens at most {MAX_MESHES} meshes")))
            }
            None => mesh_beside(named, folder, is_textured),
        };
        let read = |file: &MeshFile, _, is_textured| {
            let content = find(file, is_textured)?;
            Ok(FoundMesh { content, file: PathBuf::from(&file.name), warnings: vec![] })
        };
        // Pictures are those of the command line's scene, which may stand anywhere.
        let read_image = |image: &ImageFile, _| {
            let known = first.images.iter().find(|known| known.name == image.name);
            let reason = "a page opens the pictures of the command line's scene only";
            known
                .map(|known| (known.texels.clone(), PathBuf::from(&image.name)))
                .ok_or_else(|| image_unreadable(&image.name, image.at, reason))
        };
        let readers = Readers { mesh: &read, image: &read_image };
        let hints = Hints { edition: named, ..self.hints.clone() };
        let loaded = scene_io::load_text(source, &hints, readers)?;
        let count = primitives(&loaded);
        if count > MAX_PRIMITIVES {
            let message = format!("a page opens scenes of at most {MAX_PRIMITIVES} primitives");
            return Err(Diagnostic::error(message));
        }
        memory::ask(count as u64 * BYTES_PER_PRIMITIVE)?;
        let choice = loaded.choice.clone();
        Ok((choice, Renderer::new(loaded, Meshes::Kept)?))
    }
}

/// Triangles, spheres and planes, before the meshes are copied to where they stand.
fn primitives(LoadedScene { scene, meshes, .. }: &LoadedScene) -> usize {
    const BOX: usize = 12;
    let count = |object: &Object| match object {
        Object::Mesh { mesh, .. } => meshes.get(*mesh).map_or(0, |mesh| mesh.triangles.len()),
        Object::Box { .. } => BOX,
        Object::Grid { surface, .. } => surface.triangles.len(),
        _ => 1,
    };
    scene.objects.iter().map(count).fold(0, usize::saturating_add)
}

/// Reads a mesh that lies in the scene's folder or below it; no way leads out of there, nor does a link.
fn mesh_beside(named: &MeshFile, folder: &Path, is_textured: bool) -> Result<ObjFile, Diagnostic> {
    let name = &named.name;
    let is_inside = Path::new(name).components().all(|part| matches!(part, Component::Normal(_)));
    if !is_inside {
        return Err(refused(named, "a page opens meshes beside the scene only"));
    }
    let failed = |error: std::io::Error| refused(named, &error.to_string());
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    let file = fs::canonicalize(folder.join(name)).map_err(failed)?;
    if !file.starts_with(fs::canonicalize(folder).map_err(failed)?) {
        return Err(refused(named, "it is a link that leads out of the scene's folder"));
    }
    let found = fs::metadata(&file).map_err(failed)?;
    if !found.is_file() || found.len() > MAX_MESH_FILE {
        return Err(refused(named, "it is no file, or too large"));
    }
    memory::ask(memory_for(found.len()))?;
    let bytes = fs::read(&file).map_err(failed)?;
    read_obj(&bytes, is_textured).map_err(|error| in_mesh(error.into(), named.at, name, &bytes))
}

fn refused(MeshFile { name, at, .. }: &MeshFile, reason: &str) -> Diagnostic {
    mesh_unreadable(name, *at, &[(name.clone(), reason.to_owned())])
}
