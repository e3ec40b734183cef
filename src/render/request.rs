//! The request: the layers to render, and how to render them.

use super::adaptive::Adaptive;
use super::layer::{Cost, Layer};
use crate::caster::choose::Structure;
use crate::picture::Window;
use crate::render::grid_view::Occupancy;
use crate::sampling::blur::reduced;
use crate::sampling::filter::Filter;
use crate::sampling::sample_packet::Stage;
use crate::sampling::sampler::{Pattern, Sampler};
use crate::scene;
use crate::scene::edition::Edition;
use crate::trace::Effects;
use serde::Serialize;
use std::ops::Range;

/// The way to trace a picture. The picture does not depend on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tracing {
    /// As fast as possible. Only rays that the picture needs are traced. Only the total number of rays is counted.
    #[default]
    Fast,
    /// With all rays of the course's program, whose steps are counted.
    Counted,
}

/// The subject of the layers of colours.
#[derive(Clone, Copy, Debug)]
pub enum View<'a> {
    /// The scene, with the request's effects.
    Scene,
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy),
    /// A colour for the position of each pixel.
    Places,
}

/// The layers of a picture to render, and how to render them.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Width and height of the whole picture in pixels, at least 1 each.
    pub size: [usize; 2],
    /// The part of the picture to render, with the same pixels as in the whole picture. It is clipped to the picture.
    /// `None` means the whole picture.
    pub window: Option<Window>,
    /// A camera in place of the scene's own.
    pub camera: Option<scene::Camera>,
    /// The effects that are modelled.
    pub effects: Effects,
    /// The positions of the samples of a pixel.
    pub sampler: Sampler,
    /// The settings of adaptive samples: each pixel gets as many samples as it needs. Then the sampler only provides
    /// the random numbers.
    pub adaptive: Option<Adaptive>,
    /// True if colours are kept as floats, including colours brighter than white.
    pub has_floats: bool,
    /// The reconstruction filter, which combines samples to pixels.
    pub filter: Filter,
    /// True if the colours are blurred and reduced to a third of the size by [`Blur`](crate::sampling::blur::Blur).
    pub is_reduced: bool,
    /// The layers, in the order in which rows are handed out.
    pub layers: Vec<Layer>,
    /// The structure that rays are cast into. The picture does not depend on it.
    pub structure: Structure,
    /// The way to trace. The picture does not depend on it.
    pub tracing: Tracing,
    /// True if the occupied cells of the grid are drawn in place of the scene.
    pub draws_cells: bool,
}

impl Request {
    /// Returns a request for the colours of a whole picture, with one ray through each pixel's centre, without shadows
    /// or secondary rays.
    pub fn new(size: [usize; 2]) -> Self {
        Self {
            size,
            window: None,
            camera: None,
            effects: Effects::default(),
            sampler: Sampler::CENTER,
            adaptive: None,
            has_floats: false,
            filter: Filter::PIXEL,
            is_reduced: false,
            layers: vec![Layer::Color],
            structure: Structure::Any,
            tracing: Tracing::Fast,
            draws_cells: false,
        }
    }

    /// Returns the width and height of the rendered part, in pixels.
    pub fn window_size(&self) -> [usize; 2] {
        [self.columns().len(), self.rows().len()]
    }

    /// Returns the width and height of a layer's picture, in pixels.
    pub fn layer_size(&self, layer: &Layer) -> [usize; 2] {
        let size = layer.size(self.window_size());
        if self.reduces(layer) { reduced(size) } else { size }
    }

    /// Returns the flag that asks for its samples in an edition of the course.
    pub fn samples_flag(&self, edition: Edition) -> String {
        match (self.adaptive, self.sampler.pattern()) {
            (Some(Adaptive { most, error }), _) => format!("-adaptive_samples {most} {error}"),
            (None, Pattern::Displaced) => "-jitter".into(),
            (None, pattern) => format!("-{} {}", pattern.flag(edition), self.sampler.count()),
        }
    }

    /// Returns the flag `-weight` with its value, unless that is the edition's default.
    pub fn weight_flag(&self, edition: Edition) -> Option<String> {
        let weight = self.effects.min_weight;
        (weight != edition.default_weight()).then(|| format!("-weight {weight}"))
    }

    /// Returns true if a layer's rows are reduced.
    pub(super) fn reduces(&self, layer: &Layer) -> bool {
        self.is_reduced && *layer == Layer::Color
    }

    /// Returns the columns to render.
    pub(crate) fn columns(&self) -> Range<usize> {
        let [width, _] = self.size;
        self.window.map_or(0..width, |w| w.x.min(width)..w.x.saturating_add(w.width).min(width))
    }

    /// Returns the rows to render, counted from the bottom as the camera counts them.
    pub(crate) fn rows(&self) -> Range<usize> {
        let [_, height] = self.size;
        let from_top = |w: Window| w.y.min(height)..w.y.saturating_add(w.height).min(height);
        let rows = self.window.map_or(0..height, from_top);
        height - rows.end..height - rows.start
    }

    /// Returns true if any layer needs colours, or if rays are counted.
    pub(super) fn traces_colors(&self, tracing: Tracing) -> bool {
        tracing == Tracing::Counted
            || self.layers.iter().any(|layer| matches!(layer, Layer::Color | Layer::Samples { .. }))
    }

    /// Returns true if there is a layer of colours.
    pub(super) fn has_colors(&self) -> bool {
        self.layers.contains(&Layer::Color)
    }

    /// Returns the cost that is counted for each pixel.
    pub(super) fn cost(&self) -> Option<Cost> {
        self.layers.iter().find_map(|layer| if let Layer::Cost(cost) = layer { Some(*cost) } else { None })
    }

    /// Returns the width of the border around the window, in pixels, whose samples contribute to the window.
    pub(super) fn support(&self) -> usize {
        if self.has_colors() { self.filter.support() } else { 0 }
    }

    /// Returns the columns whose samples contribute to the window.
    pub(crate) fn traced_columns(&self) -> Range<usize> {
        let (shown, support) = (self.columns(), self.support());
        shown.start.saturating_sub(support)..(shown.end + support).min(self.size[0])
    }

    /// Returns the number of colours in a row of pixels, over all layers.
    pub(super) fn colors_per_row(&self) -> usize {
        self.layers.iter().map(|layer| layer.colors_per_row(self.columns().len())).sum()
    }

    /// Returns these rows and the rows around them whose samples contribute to them.
    pub(crate) fn traced_rows(&self, rows: Range<usize>) -> Range<usize> {
        rows.start.saturating_sub(self.support())..(rows.end + self.support()).min(self.size[1])
    }

    /// Returns the last stage of the rays through the pixels' centres that a layer needs, independent of the positions
    /// of the samples.
    pub(super) fn measured(&self) -> Stage {
        self.layers.iter().map(|layer| layer.measured()).max().unwrap_or(Stage::Rays)
    }

    /// Returns the approximate number of samples of a pixel.
    pub(super) fn samples(&self) -> usize {
        self.adaptive.map_or(self.sampler.count(), Adaptive::usual) as usize
    }

    /// Returns the approximate number of camera rays of the whole picture.
    pub fn camera_rays(&self) -> usize {
        self.size[0] * self.size[1] * self.samples()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTH: Layer = Layer::Depth { near: 1.0, far: 2.0 };

    fn request_of(layers: &[Layer]) -> Request {
        Request { layers: layers.to_vec(), filter: Filter::Tent { radius: 2.5 }, ..Request::new([8, 6]) }
    }

    #[test]
    fn each_layer_asks_for_what_it_shows() {
        let [samples, filter] = [Layer::Samples { zoom: 2 }, Layer::Filter { zoom: 2 }];
        for (layers, traces, has_colors, measured) in [
            (&[][..], false, false, Stage::Rays),
            (&[Layer::Color], true, true, Stage::Rays),
            (&[samples], true, false, Stage::Rays),
            (&[DEPTH], false, false, Stage::Hits),
            (&[Layer::Normals], false, false, Stage::Surfaces),
            (&[filter], false, false, Stage::Rays),
            (&[filter, DEPTH, Layer::Color], true, true, Stage::Hits),
            (&[Layer::SignedNormals, Layer::Distance], false, false, Stage::Surfaces),
        ] {
            let request = request_of(layers);
            assert_eq!(request.traces_colors(Tracing::Fast), traces, "{layers:?}");
            assert!(request.traces_colors(Tracing::Counted));
            assert_eq!(request.has_colors(), has_colors, "{layers:?}");
            assert_eq!(request.support(), if has_colors { 2 } else { 0 }, "{layers:?}");
            assert_eq!(request.measured(), measured, "{layers:?}");
        }
    }
}
