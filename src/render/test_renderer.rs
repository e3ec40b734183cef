//! Makes renderers for tests.

use super::renderer::{Meshes, Renderer};
use crate::diagnostic::Diagnostic;
use crate::scene::MeshFile;
use crate::scene::load::{Hints, Readers, Source, load_text};
use crate::scene::texels::ImageFile;

/// Returns a renderer of this scene, which names no files.
pub fn renderer_of(text: &str) -> Renderer {
    let source = Source { path: "s.txt".into(), text: text.into() };
    let no_mesh = |_: &MeshFile, _, _| Err(Diagnostic::error("no mesh"));
    let no_image = |_: &ImageFile, _| Err(Diagnostic::error("no picture"));
    let loaded = load_text(source, &Hints::default(), Readers { mesh: &no_mesh, image: &no_image });
    Renderer::new(loaded.unwrap(), Meshes::Kept).unwrap()
}
