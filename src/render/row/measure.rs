//! Layers of measurements at the centres of pixels: depths, distances and normals.

use super::{Painter, RenderSetting};
use crate::picture::Color;
use crate::render::layer::Layer;
use crate::sampling::sample_packet::Sample;
use crate::scene::model::MeasureColors;
use glam::DVec3;

impl Painter<'_> {
    /// Adds the measurements at the centres of adjacent pixels to the layers.
    pub(super) fn measure(&mut self, centers: &[Sample]) {
        let first = centers.first().map_or(0, |center| center.source.column);
        let place = |column: usize| column.saturating_sub(first).min(centers.len());
        let shown = &centers[place(self.shown.start)..place(self.shown.end)];
        let RenderSetting { caster, request, .. } = self.setting;
        let t = |center: &Sample| Some(caster.world.hit(&center.ray, center.visible?).t);
        let normal = |center: &Sample| center.surface.map_or(DVec3::ZERO, |surface| surface.normal);
        let MeasureColors { depths, normals } = caster.world.measure_colors;
        for (layer, colors) in request.layers.iter().zip(&mut self.row.layers) {
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
}
