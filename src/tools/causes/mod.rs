//! Finds why a picture differs from this program's, by trying common mistakes in ray tracers one after the other.
//!
//! Each [`Mistake`] produces a wrong picture: by changing the finished picture, the request or the scene, or by a
//! student's tracer with a switch for each mistake. The mistake that produces the examined picture is the cause.

mod changes;
mod finding;
mod finished;
mod mistakes;
mod object_space;
mod paint;
mod rotations;
mod speckles;
mod student;
#[cfg(test)]
mod tests;
mod transform_order;
mod window;

pub(crate) use changes::has_secondary_rays;
pub use finding::Finding;
pub use finished::FinishedPicture;
pub use mistakes::{Mistake, OppositeFaces};
pub(crate) use paint::colors as student_colors;
pub use student::SelfHitting;
pub(crate) use student::{Hits, MAX_BOUNCES};

use crate::caster::choose::{Rays, Structure};
use crate::picture::{Color, FloatPicture, Picture};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Progress, Request, Tracing, Watch};
use crate::scene::Scene;
use mistakes::{Make, Setting};
use std::borrow::Cow;
use std::ops::ControlFlow;

/// This program's picture, with its renderer and request.
pub struct Original<'a> {
    prepared: Prepared<'a>,
    watch: Watch<'a>,
    /// The request. Its window is the part of the picture used to judge causes.
    request: Request,
    /// The whole picture.
    colors: FloatPicture,
}

impl<'a> Original<'a> {
    /// Renders the request's first layer, or its colours if there is none, with this structure. `None` if memory is too
    /// small. The renderer must have kept the meshes.
    pub fn new(renderer: &'a Renderer, structure: Structure, request: &Request) -> Option<Self> {
        Self::watched(renderer, structure, request, &|_| ControlFlow::Continue(()))
    }

    /// Renders like [`new`](Self::new), and lets `watch` cancel. After that the search ends soon, with an unspecified
    /// result. `None` also if it is cancelled during this call.
    pub fn watched(
        renderer: &'a Renderer,
        structure: Structure,
        request: &Request,
        watch: Watch<'a>,
    ) -> Option<Self> {
        let layer = request.layers.first().copied().unwrap_or(Layer::Color);
        let (layers, tracing, draws_cells) = (vec![layer], Tracing::Fast, false);
        let request = Request { layers, tracing, draws_cells, structure, window: None, ..request.clone() };
        // The tracer casts all rays, even those that the renderer can skip.
        let rays = request.camera_rays();
        let prepared = renderer.prepare_as(structure, Rays::cast(rays), Tracing::Fast).ok()?;
        let colors = rendered(&prepared, &request, watch)?;
        Some(Self { prepared, watch, request, colors })
    }

    /// Returns true if the watch has cancelled the search.
    fn is_cancelled(&self) -> bool {
        (self.watch)(Progress { done: 0, rows: 0, rays: 0 }).is_break()
    }

    /// Returns the picture with the mistake. `None` if this scene or request cannot show the mistake.
    pub fn picture(&self, mistake: Mistake) -> Option<Picture> {
        let Self { prepared, request, watch, .. } = self;
        if self.is_cancelled() || !mistake.shows_in(self.layer()) {
            return None;
        }
        let Renderer { scene, source, .. } = prepared.renderer();
        match mistake.make()? {
            Make::Pixels(change) if mistake.moves_pixels() => Some(self.in_window(change(&self.colors))),
            Make::Pixels(change) => Some(change(&self.colors_in_window())),
            make @ (Make::Camera(_) | Make::Effects(_)) => {
                Some(rendered(prepared, &make.request(scene, request)?, watch)?.to_picture())
            }
            make @ (Make::Scene(_) | Make::Text(_)) => {
                self.picture_of(make.scene(scene, &source.text)?, request)
            }
            Make::Student(shows) => {
                let setting = Setting { scene, request };
                let is_tried = setting.bounces() <= MAX_BOUNCES && shows(&setting);
                is_tried.then(|| paint::picture(self, Some(mistake)))?
            }
        }
    }

    /// Returns the picture of another scene with the same meshes.
    fn picture_of(&self, scene: Scene, request: &Request) -> Option<Picture> {
        let renderer = self.renderer().with_scene(scene).ok()?;
        let prepared = renderer.prepare(request).ok()?;
        Some(rendered(&prepared, request, self.watch)?.to_picture())
    }

    fn layer(&self) -> Layer {
        self.request.layers.first().copied().unwrap_or(Layer::Color)
    }

    fn renderer(&self) -> &Renderer {
        self.prepared.renderer()
    }

    fn colors_in_window(&self) -> Cow<'_, FloatPicture> {
        match self.request.window {
            None => Cow::Borrowed(&self.colors),
            Some(window) => Cow::Owned(window::part_of_colors(&self.colors, window)),
        }
    }

    /// Returns the part of a whole picture in the window.
    fn in_window(&self, picture: Picture) -> Picture {
        match self.request.window {
            None => picture,
            Some(window) => window::part(&picture, window),
        }
    }
}

/// Renders the request's only layer. `None` if memory is too small or the watch cancels.
fn rendered(prepared: &Prepared, request: &Request, watch: Watch) -> Option<FloatPicture> {
    let mut picture = FloatPicture::with_room(request.layer_size(request.layers.first()?)).ok()?;
    let mut take_row = |_: usize, row: &[Color]| {
        picture.colors.extend_from_slice(row);
        ControlFlow::Continue(())
    };
    prepared.render_rows(request, watch, &mut take_row).ok()?;
    Some(picture)
}
