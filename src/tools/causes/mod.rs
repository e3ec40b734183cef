//! Why a picture differs from this program's: what those who write a ray tracer get wrong is tried, one mistake
//! after the other.
//!
//! Each [`Cause`] makes a wrong picture of its own: from the finished picture, from another request or another scene,
//! or by a student's tracer with a switch for each mistake. The one that makes the picture in question is the cause.

#[cfg(test)]
mod confusion;
mod finding;
mod finished;
mod object_space;
mod paint;
mod pixels;
mod requests;
mod rotations;
mod rules;
mod scenes;
mod speckles;
mod student;
mod transform_order;
mod window;

pub use finding::Finding;
pub use finished::FinishedPicture;
pub use pixels::PixelChange;
pub use requests::RequestChange;
pub(crate) use requests::has_secondary_rays;
pub(crate) use rules::{MAX_BOUNCES, colors as mistaken_colors};
pub use rules::{Rule, SelfHitting};
pub use scenes::{OppositeFaces, SceneChange};
pub(crate) use student::Hits;

use crate::caster::choose::{Rays, Structure};
use crate::picture::{Color, FloatPicture, Picture};
use crate::render::renderer::{Prepared, Renderer};
use crate::render::{Layer, Progress, Request, Tracing, Watch};
use crate::scene::Scene;
use serde::Serialize;
use std::borrow::Cow;
use std::fmt;
use std::ops::ControlFlow;

/// A mistake that explains a difference. `Display` completes "this program's picture".
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Cause {
    /// None: the picture is this program's, and it is the reference that differs.
    Unchanged,
    /// The finished picture is changed.
    Pixels(PixelChange),
    /// Something else is rendered of the same scene.
    Request(RequestChange),
    /// The scene is understood otherwise.
    Scene(SceneChange),
    /// Rays are generated, traced or shaded otherwise.
    Rule(Rule),
}

impl Cause {
    /// Every cause that is tried, the cheap ones first.
    pub fn all() -> impl Iterator<Item = Self> {
        std::iter::once(Self::Unchanged)
            .chain(PixelChange::ALL.map(Self::Pixels))
            .chain(RequestChange::ALL.map(Self::Request))
            // Where nothing casts a shadow on another, reversed lights look the same, which are less common.
            .chain([Self::Rule(Rule::NoEpsilon { rays: SelfHitting::Shadow })])
            .chain(SceneChange::ALL.map(Self::Scene))
            .chain(Rule::all().map(Self::Rule))
    }
}

impl Cause {
    /// Whether both are one mistake to another degree.
    fn is_akin(self, other: Self) -> bool {
        use Rule::{Epsilon, NoEpsilon, Shifted, SmallerEpsilon};
        use SceneChange::CubeFacesSwapped;
        let is_gamma = |change| matches!(change, PixelChange::GammaEncoded | PixelChange::BytesGammaEncoded);
        match (self, other) {
            (Self::Pixels(one), Self::Pixels(other)) => one == other || is_gamma(one) && is_gamma(other),
            (Self::Rule(one), Self::Rule(other)) => {
                one == other
                    || matches!(
                        (one, other),
                        (Epsilon { .. } | SmallerEpsilon { .. }, Epsilon { .. } | SmallerEpsilon { .. })
                            | (NoEpsilon { .. }, NoEpsilon { .. })
                            | (Shifted { .. }, Shifted { .. })
                    )
            }
            (Self::Scene(CubeFacesSwapped { .. }), Self::Scene(CubeFacesSwapped { .. })) => true,
            _ => self == other,
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unchanged => Ok(()),
            Self::Pixels(change) => write!(f, " {change}"),
            Self::Request(change) => write!(f, " {change}"),
            Self::Scene(change) => write!(f, " {change}"),
            Self::Rule(rule) => write!(f, " {rule}"),
        }
    }
}

/// This program's picture, and what it was rendered from.
pub struct Original<'a> {
    prepared: Prepared<'a>,
    watch: Watch<'a>,
    structure: Structure,
    /// Its window is the part of the picture by which causes are judged.
    request: Request,
    /// The whole picture.
    colors: FloatPicture,
}

impl<'a> Original<'a> {
    /// Renders the request's first layer, or else its colours, with this structure; none where there is no memory for it.
    /// The renderer must have kept the meshes.
    pub fn new(renderer: &'a Renderer, structure: Structure, request: &Request) -> Option<Self> {
        Self::watched(renderer, structure, request, &|_| ControlFlow::Continue(()))
    }

    /// The same for a search that soon ends, with any result, when the watch cancels it. None also if it does so before.
    pub fn watched(
        renderer: &'a Renderer,
        structure: Structure,
        request: &Request,
        watch: Watch<'a>,
    ) -> Option<Self> {
        let layer = request.layers.first().copied().unwrap_or(Layer::Color);
        let request = Request { layers: vec![layer], window: None, ..request.clone() };
        // The tracer casts all rays, also those that the renderer need not cast.
        let rays = request.camera_rays();
        let prepared = renderer.prepare_as(structure, Rays::cast(rays), Tracing::Fast).ok()?;
        let colors = rendered(&prepared, &request, watch)?;
        Some(Self { prepared, watch, structure, request, colors })
    }

    /// Whether the watch has cancelled the search.
    fn is_cancelled(&self) -> bool {
        (self.watch)(Progress { done: 0, rows: 0, rays: 0 }).is_break()
    }

    /// The picture that is made by the mistake; none where it is a mistake that this scene or this request cannot
    /// show.
    pub fn picture(&self, cause: Cause) -> Option<Picture> {
        let Self { prepared, request, watch, .. } = self;
        if self.is_cancelled() {
            return None;
        }
        let Renderer { scene, source, .. } = prepared.renderer();
        match cause {
            Cause::Unchanged => Some(self.colors_in_window().to_picture()),
            Cause::Pixels(change) if change.moves() => Some(self.in_window(change.apply(&self.colors))),
            Cause::Pixels(change) => Some(change.apply(&self.colors_in_window())),
            Cause::Request(change) if self.layer() != Layer::Color && !change.is_camera() => None,
            Cause::Request(change) => {
                let request = change.apply(scene, request)?;
                Some(rendered(prepared, &request, watch)?.to_picture())
            }
            Cause::Scene(change) if !change.shows_in(self.layer()) => None,
            Cause::Scene(change) => self.picture_of(change.apply(scene, &source.text)?, request),
            Cause::Rule(rule) if rule.applies(scene, request) && rule.shows_in(self.layer()) => {
                rules::picture(self, Some(rule))
            }
            Cause::Rule(_) => None,
        }
    }

    /// The picture of another scene with the same meshes.
    fn picture_of(&self, scene: Scene, request: &Request) -> Option<Picture> {
        let renderer = self.renderer().with_scene(scene).ok()?;
        let prepared = renderer.prepare_for(self.structure, request, Tracing::Fast).ok()?;
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

    /// The window of a whole picture.
    fn in_window(&self, picture: Picture) -> Picture {
        match self.request.window {
            None => picture,
            Some(window) => window::part(&picture, window),
        }
    }
}

/// The request's only layer; none where there is no memory for it, or where the watch cancels.
fn rendered(prepared: &Prepared, request: &Request, watch: Watch) -> Option<FloatPicture> {
    let mut picture = FloatPicture::with_room(request.layer_size(request.layers.first()?)).ok()?;
    let mut take_row = |_: usize, row: &[Color]| {
        picture.colors.extend_from_slice(row);
        ControlFlow::Continue(())
    };
    prepared.render_rows_fast(request, watch, &mut take_row).ok()?;
    Some(picture)
}
