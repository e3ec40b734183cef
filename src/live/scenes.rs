//! The open scenes: the command line's scene, and the scenes that were typed in last.

use super::limits::*;
use super::lock;
use crate::base::memory;
use crate::base::patience::{Endless, Patience};
use crate::cli::Options;
use crate::diagnostic::Diagnostic;
use crate::image_io::ReadFile;
use crate::render::Stop;
use crate::render::renderer::{Meshes, Renderer};
use crate::scene::MeshFile;
use crate::scene::edition::{Choice, Edition};
use crate::scene::load::{
    self, Found, Hints, LoadedScene, Readers, Source, image_unreadable, in_mesh, mesh_unreadable,
};
use crate::scene::mesh::ObjFile;
use crate::scene::obj::{memory_for, read_obj};
use crate::scene::texels::ImageFile;
use std::cell::Cell;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// A scene that can be rendered.
#[derive(Debug)]
pub struct OpenScene {
    /// The number by which a page names it; 0 for the command line's scene.
    pub revision: u64,
    /// The edition that was named, if any.
    pub named: Option<Edition>,
    /// The edition in which it was read.
    pub choice: Choice,
    /// The files of its meshes and pictures.
    pub files: Vec<ReadFile>,
    /// The files of its meshes, in the order of the renderer's meshes.
    mesh_files: Vec<PathBuf>,
    pub renderer: Renderer,
}

impl OpenScene {
    fn new(
        revision: u64,
        named: Option<Edition>,
        loaded: LoadedScene,
        patience: &dyn Patience,
    ) -> Result<Self, Diagnostic> {
        let (choice, files, mesh_files) = (loaded.choice.clone(), loaded.files(), loaded.mesh_files.clone());
        let renderer = Renderer::within(loaded, Meshes::Kept, patience)?;
        Ok(Self { revision, named, choice, files, mesh_files, renderer })
    }

    pub fn primitives(&self) -> usize {
        self.renderer.world().ids().len()
    }

    /// Returns the memory in bytes of a copy of the scene.
    pub fn bytes(&self) -> u64 {
        self.primitives() as u64 * SCENE_BYTES_PER_PRIMITIVE
    }
}

pub struct Scenes {
    path: PathBuf,
    hints: Hints,
    pub first: Arc<OpenScene>,
    /// In the order of their last use.
    typed: Mutex<Vec<Arc<OpenScene>>>,
    /// The last revision.
    last: AtomicU64,
}

impl Scenes {
    /// Opens the scene of the command line.
    pub fn open(line: &Options, path: &Path) -> Result<Self, Diagnostic> {
        let hints = line.hints();
        let first = OpenScene::new(0, hints.edition, load::load_with(path, &hints)?, &Endless)?;
        let (typed, last) = Default::default();
        Ok(Self { path: path.to_owned(), hints, first: Arc::new(first), typed, last })
    }

    /// Returns the scene of this revision, if it is open.
    pub fn scene(&self, revision: u64) -> Option<Arc<OpenScene>> {
        if revision == 0 {
            return Some(self.first.clone());
        }
        let mut typed = lock(&self.typed);
        let place = typed.iter().position(|scene| scene.revision == revision)?;
        typed[place..].rotate_left(1);
        typed.last().cloned()
    }

    /// Opens a text, in this edition if one is named. Scenes for which there is no room are closed. An error says why
    /// the text is no scene.
    pub fn type_in(
        &self,
        text: String,
        named: Option<Edition>,
        stop: &Stop,
    ) -> Result<Arc<OpenScene>, Diagnostic> {
        let left = Cell::new(MAX_MESH_BYTES);
        let read = |file: &MeshFile, _, is_textured| match self.known_mesh(&file.name) {
            Some(known) => Ok(known),
            None => self.mesh_beside(file, is_textured, &left, stop),
        };
        let read_image = |image: &ImageFile, _| {
            let known = self.first.renderer.scene.images.iter().find(|known| known.name == image.name);
            let found = known.and_then(|known| Some((known.texels.clone(), known.file.clone()?)));
            let reason = "a page opens the pictures of the command line's scene only";
            found.ok_or_else(|| image_unreadable(&image.name, image.at, reason))
        };
        let hints = Hints { edition: named, ..self.hints.clone() };
        let readers = Readers { mesh: &read, image: &read_image };
        let loaded = load::load_text_within(Source { path: self.path.clone(), text }, &hints, readers, stop)?;
        // Counted before the meshes are copied to where they stand.
        let counts = loaded.scene.objects.iter().filter_map(|object| object.primitives(&loaded.meshes));
        let primitives = counts.fold(0, usize::saturating_add);
        if primitives > MAX_PRIMITIVES {
            let most = format!("a page opens scenes of at most {MAX_PRIMITIVES} primitives");
            return Err(Diagnostic::error(most));
        }
        memory::ask(primitives as u64 * SCENE_BYTES_PER_PRIMITIVE)?;
        let revision = 1 + self.last.fetch_add(1, Ordering::Relaxed);
        let scene = Arc::new(OpenScene::new(revision, named, loaded, stop)?);
        let mut typed = lock(&self.typed);
        typed.push(scene.clone());
        while typed.len() > MAX_SCENES || is_too_large(typed.iter()) {
            typed.remove(0);
        }
        Ok(scene)
    }

    /// Returns a mesh that the command line's scene names. It may lie anywhere.
    fn known_mesh(&self, name: &str) -> Option<(ObjFile, PathBuf)> {
        let OpenScene { renderer, mesh_files, .. } = &*self.first;
        let index = renderer.scene.meshes.iter().position(|known| known.name == name)?;
        let known = &renderer.scene.meshes[index];
        let content = ObjFile {
            mesh: renderer.meshes()[index].clone(),
            vertices: known.vertices,
            texture_coordinates: known.texture_coordinates.to_vec(),
            ..ObjFile::default()
        };
        Some((content, mesh_files[index].clone()))
    }

    /// Reads a mesh in the scene's folder or below it. Neither the name nor a link may lead out of the folder. `left`
    /// has the number of bytes that may still be read.
    fn mesh_beside(
        &self,
        MeshFile { name, at, .. }: &MeshFile,
        is_textured: bool,
        left: &Cell<u64>,
        stop: &Stop,
    ) -> Found<ObjFile> {
        let refused = |reason: &str| mesh_unreadable(name, *at, &[(name.clone(), reason.into())]);
        let failed = |error: std::io::Error| refused(&error.to_string());
        if stop.is_over() {
            return Err(refused("the page no longer waits for it"));
        }
        if !Path::new(name).components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(refused("a page opens meshes beside the scene only"));
        }
        let folder = self.path.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
        let file = fs::canonicalize(folder.join(name)).map_err(failed)?;
        if !file.starts_with(fs::canonicalize(folder).map_err(failed)?) {
            return Err(refused("it is a link that leads out of the scene's folder"));
        }
        let found = fs::metadata(&file).map_err(failed)?;
        let rest = left.get().checked_sub(found.len()).filter(|_| found.is_file());
        left.set(rest.ok_or_else(|| refused("it is no file, or too large"))?);
        memory::ask(memory_for(found.len()))?;
        let bytes = fs::read(&file).map_err(failed)?;
        let content =
            read_obj(&bytes, is_textured, stop).map_err(|error| in_mesh(error, *at, name, &bytes))?;
        Ok((ObjFile { warnings: vec![], ..content }, file))
    }
}

/// Returns true if several scenes have more primitives together than may stay in memory.
pub fn is_too_large<'s>(scenes: impl Iterator<Item = &'s Arc<OpenScene>>) -> bool {
    let sizes: Vec<usize> = scenes.map(|scene| scene.primitives()).collect();
    sizes.len() > 1 && sizes.iter().sum::<usize>() > MAX_PRIMITIVES
}
