//! Layers beside the colours: depths, distances and normals at the centres of pixels, and plots of the samples in
//! enlarged pixels.

use super::Painter;
use crate::picture::Color;
use crate::render::layer::Layer;
use crate::render::request::Request;
use crate::sampling::sample_packet::Sample;
use crate::scene::model::MeasureColors;
use glam::{DVec2, DVec3};
use std::ops::Range;

/// Returns the indices of the layers of samples, each with its zoom.
pub(super) fn plots(request: &Request, is_shown: bool) -> Vec<(usize, usize)> {
    let layers = request.layers.iter().enumerate().filter(|_| is_shown);
    let plot = |(k, layer): (usize, &Layer)| match *layer {
        Layer::Samples { zoom } => Some((k, zoom)),
        _ => None,
    };
    layers.filter_map(plot).collect()
}

impl Painter<'_> {
    /// Adds the measurements at the centres of adjacent pixels to the layers.
    pub(super) fn measure(&mut self, centers: &[Sample]) {
        let first = centers.first().map_or(0, |center| center.column);
        let place = |column: usize| column.saturating_sub(first).min(centers.len());
        let shown = &centers[place(self.shown.start)..place(self.shown.end)];
        let world = self.tracer.caster.world;
        let t = |center: &Sample| Some(world.hit(&center.ray, center.visible?).t);
        let normal = |center: &Sample| center.surface.map_or(DVec3::ZERO, |surface| surface.normal);
        let MeasureColors { depths, normals } = world.measure_colors;
        for (layer, colors) in self.tracer.request.layers.iter().zip(&mut self.row.layers) {
            match *layer {
                Layer::Depth { near, far } => {
                    let grey = |t: f64| depths.grey(t, [near, far]);
                    colors.extend(shown.iter().map(|center| Color::splat(t(center).map_or(0.0, grey))));
                }
                Layer::Distance => {
                    colors
                        .extend(shown.iter().map(|center| Color::splat(t(center).unwrap_or(f64::INFINITY))));
                }
                Layer::Normals => {
                    colors.extend(shown.iter().map(|center| normals.color(normal(center))));
                }
                Layer::SignedNormals => colors.extend(shown.iter().map(normal)),
                Layer::Color | Layer::Samples { .. } | Layer::Cost(_) | Layer::Filter { .. } => {}
            }
        }
    }

    /// Draws the chequered background of these columns, on which their samples are plotted.
    pub(super) fn plot_background(&mut self, k: usize, zoom: usize, columns: Range<usize>) {
        let (width, j) = (self.shown.len() * zoom, self.row.j);
        let colors = &mut self.row.layers[k];
        colors.resize(width * zoom, Color::ZERO);
        for i in columns.filter(|i| self.shown.contains(i)) {
            let grey = if (i + j).is_multiple_of(2) { 0.2 } else { 0.0 };
            let x = (i - self.shown.start) * zoom;
            colors.chunks_mut(width).for_each(|row| row[x..x + zoom].fill(Color::splat(grey)));
        }
    }

    /// Plots a sample at its position in its enlarged pixel.
    pub(super) fn plot(&mut self, i: usize, offset: DVec2, color: Color) {
        if !self.shown.contains(&i) {
            return;
        }
        for &(k, zoom) in &self.plots {
            let x = (i - self.shown.start) * zoom + enlarged(i, offset.x, zoom);
            let y = enlarged(self.row.j, offset.y, zoom);
            self.row.layers[k][y * self.shown.len() * zoom + x] = color;
        }
    }
}

/// Returns the place of a sample in its enlarged pixel, along one axis.
fn enlarged(pixel: usize, offset: f64, zoom: usize) -> usize {
    let place = ((pixel as f64 + 0.5 + offset) * zoom as f64) as usize;
    place.clamp(pixel * zoom, pixel * zoom + zoom - 1) - pixel * zoom
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample whose position is rounded to the next pixel, or lies on the border, is plotted in its own pixel.
    #[test]
    fn a_sample_is_plotted_within_its_pixel() {
        let offset = 0.5f64.next_down();
        assert_eq!(5.5 + offset, 6.0);
        assert_eq!([-0.5, 0.0, offset].map(|offset| enlarged(5, offset, 4)), [0, 2, 3]);
    }

    #[test]
    fn rows_beside_the_strip_plot_no_samples() {
        let request =
            |zoom| Request { layers: vec![Layer::Color, Layer::Samples { zoom }], ..Request::new([9, 9]) };
        assert_eq!(plots(&request(3), true), [(1, 3)]);
        assert_eq!(plots(&request(3), false), []);
    }
}
