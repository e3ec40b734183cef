//! A view of a scene.

use super::limits::VIEW_BYTES_PER_PIXEL;
use super::scenes::OpenScene;
use crate::cli::Options;
use crate::render::{Cost, Layer, Request, Tracing};
use crate::scene::Camera;
use std::sync::Arc;

/// A view of a scene, as the controls and the hand have set it.
#[derive(Clone)]
pub struct View {
    pub scene: Arc<OpenScene>,
    /// The flags that shape the picture, with their values.
    pub words: Vec<String>,
    /// The options that they ask for. Only the picture and its structure are used.
    pub options: Options,
    pub camera: Option<Camera>,
    /// The cost that is shown in place of the colours.
    pub cost: Option<Cost>,
    /// The size of a sketch with one ray through each centre, in place of the picture.
    pub sketch: Option<[usize; 2]>,
}

impl View {
    /// The request for one layer of the picture.
    pub fn request(&self, layer: Layer) -> Request {
        let whole = self.options.request();
        let drawn = match self.sketch {
            Some(size) => Request { effects: whole.effects, ..Request::new(size) },
            None => whole,
        };
        let tracing = if matches!(layer, Layer::Cost(_)) { Tracing::Counted } else { Tracing::Fast };
        Request { camera: self.camera, layers: vec![layer], tracing, ..drawn }
    }

    /// Returns the memory in bytes of the picture, or of comparing it with another.
    pub fn bytes(&self) -> u64 {
        let [width, height] = self.request(Layer::Color).size.map(|side| side as u64);
        width * height * VIEW_BYTES_PER_PIXEL
    }
}
