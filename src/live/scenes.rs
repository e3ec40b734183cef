//! The scenes that are open: the one of the command line, and those that were typed in last.

use super::limits::*;
use crate::base::memory;
use crate::diagnostic::Diagnostic;
use crate::render::renderer::{Meshes, Renderer};
use crate::scene::edition::{Choice, Edition};
use crate::scene::load::{
    self, Hints, LoadedScene, Readers, Source, image_unreadable, in_mesh, mesh_unreadable,
};
use crate::scene::mesh::{ObjFile, memory_for, read_obj};
use crate::scene::texels::ImageFile;
use crate::scene::{MeshFile, Object};
use crate::tools::explain::Stop;
use serde_json::{Value, json};
use std::cell::Cell;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

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

impl OpenScene {
    pub fn primitives(&self) -> usize {
        let world = self.renderer.world();
        world.finite_count() + world.planes.len()
    }
}

pub struct Scenes {
    path: PathBuf,
    hints: Hints,
    first: Arc<OpenScene>,
    /// The one that was used last is the last.
    typed: Mutex<Vec<Arc<OpenScene>>>,
    last: AtomicU64,
    /// Held while a scene is read, so that only one takes the memory for it.
    reading: Mutex<()>,
}

impl Scenes {
    /// Opens the scene of the command line.
    pub fn open(path: &Path, hints: Hints) -> Result<Self, Diagnostic> {
        let loaded = load::load_with(path, &hints)?;
        let choice = loaded.choice.clone();
        let renderer = Renderer::new(loaded, Meshes::Kept)?;
        let first = Arc::new(OpenScene { revision: 0, named: hints.edition, choice, renderer });
        let (typed, last, reading) = Default::default();
        Ok(Self { path: path.to_owned(), hints, first, typed, last, reading })
    }

    /// The scene of the command line.
    pub fn first(&self) -> &Arc<OpenScene> {
        &self.first
    }

    /// Returns the scene of this revision, if it is open.
    pub fn scene(&self, revision: u64) -> Option<Arc<OpenScene>> {
        if revision == 0 {
            return Some(self.first.clone());
        }
        let mut typed = self.typed.lock().unwrap_or_else(PoisonError::into_inner);
        let place = typed.iter().position(|scene| scene.revision == revision)?;
        let scene = typed.remove(place);
        typed.push(scene.clone());
        Some(scene)
    }

    pub fn is_open(&self, revision: u64) -> bool {
        let typed = self.typed.lock().unwrap_or_else(PoisonError::into_inner);
        revision == 0 || typed.iter().any(|scene| scene.revision == revision)
    }

    /// Opens a text, in this edition if one is named, or says why it is no scene. Scenes for which there is no room are
    /// closed.
    pub fn type_in(
        &self,
        text: String,
        named: Option<Edition>,
        stop: &Stop,
    ) -> Result<Arc<OpenScene>, Value> {
        let _reading = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let (choice, renderer) = self.renderer(Source { path: self.path.clone(), text }, named, stop)?;
        let revision = 1 + self.last.fetch_add(1, Ordering::Relaxed);
        let scene = Arc::new(OpenScene { revision, named, choice, renderer });
        let mut typed = self.typed.lock().unwrap_or_else(PoisonError::into_inner);
        typed.push(scene.clone());
        let is_full = |typed: &[Arc<OpenScene>]| {
            let primitives: usize = typed.iter().map(|scene| scene.primitives()).sum();
            typed.len() > MAX_SCENES || typed.len() > 1 && primitives > MAX_PRIMITIVES
        };
        while is_full(&typed) {
            typed.remove(0);
        }
        Ok(scene)
    }

    fn renderer(
        &self,
        source: Source,
        named: Option<Edition>,
        stop: &Stop,
    ) -> Result<(Choice, Renderer), Value> {
        let first = &self.first.renderer;
        let beside = MeshesBeside {
            folder: self.path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new(".")),
            files: Cell::new(MAX_MESHES),
            bytes: Cell::new(MAX_MESH_BYTES),
            stop,
        };
        let read = |file: &MeshFile, _, is_textured| {
            // Those of the command line's scene may lie anywhere.
            let known =
                first.scene.meshes.iter().zip(first.meshes()).find(|(known, _)| known.name == file.name);
            let content = match known {
                Some((known, mesh)) => Ok(ObjFile {
                    mesh: mesh.clone(),
                    vertices: known.vertices,
                    texture_coordinates: known.texture_coordinates.to_vec(),
                    doubts: vec![],
                }),
                None => beside.read(file, is_textured),
            };
            Ok((ObjFile { doubts: vec![], ..content? }, PathBuf::from(&file.name)))
        };
        let read_image = |image: &ImageFile, _| {
            let known = first.scene.images.iter().find(|known| known.name == image.name);
            let reason = "a page opens the pictures of the command line's scene only";
            known
                .map(|known| (known.texels.clone(), PathBuf::from(&image.name)))
                .ok_or_else(|| image_unreadable(&image.name, image.at, reason))
        };
        let hints = Hints { edition: named, ..self.hints.clone() };
        let readers = Readers { mesh: &read, image: &read_image };
        let loaded = load::load_text(source, &hints, readers).map_err(told)?;
        let refused = |message: String| Err(told(Diagnostic::error(message)));
        let (primitives, lights) = (primitives(&loaded), loaded.scene.lights.len());
        if primitives > MAX_PRIMITIVES {
            return refused(format!("a page opens scenes of at most {MAX_PRIMITIVES} primitives"));
        }
        if lights.saturating_mul(primitives) > MAX_LIGHT_PAIRS {
            return refused(format!(
                "{lights} lights and {primitives} primitives are more than a page opens"
            ));
        }
        if let Err(error) = memory::ask(primitives as u64 * BYTES_PER_PRIMITIVE) {
            return refused(error.to_string());
        }
        let choice = loaded.choice.clone();
        Ok((choice, Renderer::new(loaded, Meshes::Kept).map_err(told)?))
    }
}

/// Returns what the page shows of an error: its place, if it has one, the problem in one line, and perhaps a hint.
fn told(error: Diagnostic) -> Value {
    let at = error.position().map(|at| [at.line, at.column]);
    json!({ "at": at, "problem": error.message, "hint": error.hint })
}

/// Counts triangles, shapes and planes, before the meshes are copied to where they stand.
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

/// The meshes in the scene's folder and below it; no way leads out of there, nor does a link.
struct MeshesBeside<'a> {
    folder: &'a Path,
    /// How many may still be read, and how many bytes of them.
    files: Cell<usize>,
    bytes: Cell<u64>,
    stop: &'a Stop,
}

impl MeshesBeside<'_> {
    fn read(&self, MeshFile { name, at, .. }: &MeshFile, is_textured: bool) -> Result<ObjFile, Diagnostic> {
        let refused = |reason: String| mesh_unreadable(name, *at, &[(name.clone(), reason)]);
        let failed = |error: std::io::Error| refused(error.to_string());
        if self.stop.is_over() {
            return Err(refused("nobody waits for it".into()));
        }
        let files = self.files.get().checked_sub(1);
        self.files.set(files.ok_or_else(|| refused(format!("a page opens at most {MAX_MESHES} meshes")))?);
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(refused("a page opens meshes beside the scene only".into()));
        }
        let file = fs::canonicalize(self.folder.join(name)).map_err(failed)?;
        if !file.starts_with(fs::canonicalize(self.folder).map_err(failed)?) {
            return Err(refused("it is a link that leads out of the scene's folder".into()));
        }
        let found = fs::metadata(&file).map_err(failed)?;
        let bytes = self.bytes.get().checked_sub(found.len()).filter(|_| found.is_file());
        self.bytes.set(bytes.ok_or_else(|| refused("it is no file, or too large".into()))?);
        memory::ask(memory_for(found.len()))?;
        let bytes = fs::read(&file).map_err(failed)?;
        read_obj(&bytes, is_textured).map_err(|error| in_mesh(error, *at, name, &bytes))
    }
}
