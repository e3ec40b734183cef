//! What is to be rendered.

use super::layer::Layer;
use crate::camera::Camera;
use crate::grid::Caster;
use crate::mode::Mode;
use crate::raster::VisibilityBuffer;
use crate::render::grid_view::Occupancy;
use crate::sampling::filter::Filter;
use crate::sampling::sampler::Sampler;
use crate::scene;
use crate::stats::Probe;
use crate::trace::Effects;
use std::ops::Range;

/// What the colours show.
#[derive(Clone, Copy, Debug)]
pub enum View<'a> {
    /// The scene, with the request's effects.
    Scene,
    /// The occupied cells of the grid, lit by the world's lights.
    Cells(&'a Occupancy),
}

/// A rectangle of pixels. Its corner (`x`, `y`) counts from the picture's top left corner, (0, 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// The first column.
    pub x: usize,
    /// The first row from the top.
    pub y: usize,
    /// In pixels.
    pub width: usize,
    /// In pixels.
    pub height: usize,
}

/// Which layers of a picture are wanted, and how they are made.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// Width and height of the whole picture in pixels, at least 1 each.
    pub size: [usize; 2],
    /// The part of the picture that is rendered. Its pixels are those of the whole picture. It is cut to the
    /// picture; none means all of it.
    pub window: Option<Window>,
    /// A camera in place of the scene's own.
    pub camera: Option<scene::Camera>,
    /// What is modelled.
    pub effects: Effects,
    /// Where the samples of a pixel lie.
    pub sampler: Sampler,
    /// How samples become pixels.
    pub filter: Filter,
    /// The layers, in the order in which rows are handed out.
    pub layers: Vec<Layer>,
}

impl Request {
    /// The colours of a whole picture, by one ray through each pixel's centre, without shadows or secondary rays.
    pub fn new(size: [usize; 2]) -> Self {
        Self {
            size,
            window: None,
            camera: None,
            effects: Effects::default(),
            sampler: Sampler::CENTER,
            filter: Filter::PIXEL,
            layers: vec![Layer::Color],
        }
    }

    /// Width and height of what is rendered, in pixels.
    pub fn window_size(&self) -> [usize; 2] {
        [self.columns().len(), self.rows().len()]
    }

    /// The columns that are rendered.
    pub(super) fn columns(&self) -> Range<usize> {
        let [width, _] = self.size;
        self.window.map_or(0..width, |w| w.x.min(width)..w.x.saturating_add(w.width).min(width))
    }

    /// The rows that are rendered, counted from the bottom as the camera counts them.
    pub(super) fn rows(&self) -> Range<usize> {
        let [_, height] = self.size;
        let from_top = |w: Window| w.y.min(height)..w.y.saturating_add(w.height).min(height);
        let rows = self.window.map_or(0..height, from_top);
        height - rows.end..height - rows.start
    }

    /// Whether any layer needs colours, or the probe counts the rays that make them.
    pub(super) fn traces_colors<P: Probe>(&self) -> bool {
        P::COUNTS || self.layers.iter().any(|layer| matches!(layer, Layer::Color | Layer::Samples { .. }))
    }

    /// Whether the colours of pixels are wanted.
    pub(super) fn has_colors(&self) -> bool {
        self.layers.contains(&Layer::Color)
    }

    /// Whether it is counted what each pixel costs.
    pub(super) fn has_costs(&self) -> bool {
        self.layers.iter().any(|layer| matches!(layer, Layer::Cost(_)))
    }

    /// How many pixels around the window are sampled for it.
    pub(super) fn support(&self) -> usize {
        if self.has_colors() { self.filter.support() } else { 0 }
    }

    /// Whether the pixels' centres are measured, wherever the samples lie.
    pub(super) fn measures(&self) -> bool {
        self.layers.iter().any(|layer| matches!(layer, Layer::Depth { .. } | Layer::Normals))
    }

    /// Whether the surfaces at the pixels' centres are needed for a layer.
    pub(super) fn has_normals(&self) -> bool {
        self.layers.contains(&Layer::Normals)
    }

    /// Whether colours are traced along the rays through the pixels' centres.
    pub(super) fn casts_centers<P: Probe>(&self, view: View) -> bool {
        self.traces_colors::<P>() && self.sampler.is_center() && matches!(view, View::Scene)
    }

    /// What the rays through the pixels' centres in these rows see, if these rays are needed and rasterizing the
    /// triangles is cheaper than casting them. The course's program casts them all.
    pub(super) fn visibility<M: Mode, P: Probe>(
        &self,
        camera: &Camera,
        caster: &Caster<M>,
        view: View,
        rows: Range<usize>,
    ) -> Option<VisibilityBuffer> {
        let asks = self.measures() || self.casts_centers::<P>(view);
        (asks && !M::AS_COURSE).then(|| VisibilityBuffer::new(camera, caster, self.size, rows))?
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_counts_from_the_top_and_is_cut_to_the_picture() {
        let request = |window| Request { window, ..Request::new([10, 8]) };
        assert_eq!((request(None).columns(), request(None).rows()), (0..10, 0..8));
        let part = request(Some(Window { x: 2, y: 1, width: 3, height: 4 }));
        assert_eq!((part.columns(), part.rows(), part.window_size()), (2..5, 3..7, [3, 4]));
        let over = request(Some(Window { x: 8, y: 6, width: usize::MAX, height: 9 }));
        assert_eq!((over.columns(), over.rows()), (8..10, 0..2));
        let beside = request(Some(Window { x: 11, y: 9, width: 1, height: 1 }));
        assert_eq!(beside.window_size(), [0, 0]);
    }
}
