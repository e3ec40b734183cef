//! Layers that are measured at the centres of pixels: depths, distances and normals.

use super::{Painter, Setting};
use crate::mode::Mode;
use crate::render::layer::Layer;
use crate::render::sample_packet::Sample;
use crate::scene::Color;
use crate::trace::Observer;
use glam::DVec3;

impl<M: Mode, P: Observer> Painter<'_, M, P> {
    /// Adds the depth and the normal at a pixel's centre to their layers.
    pub(super) fn measure(&mut self, center: &Sample) {
        if !self.shown.contains(&center.source.column) {
            return;
        }
        let Setting { caster, request, .. } = self.setting;
        let t = || center.visible.map(|visible| caster.world.hit(&center.ray, visible).t);
        let normal = || center.surface.map_or(DVec3::ZERO, |surface| surface.normal);
        for (layer, colors) in request.layers.iter().zip(&mut self.row.layers) {
            match *layer {
                Layer::Depth { near, far } => {
                    let grey = |t: f64| (far - t.clamp(near, far)) / (far - near);
                    colors.push(Color::splat(t().map_or(0.0, grey)));
                }
                Layer::Distance => colors.push(Color::splat(t().unwrap_or(f64::INFINITY))),
                Layer::Normals => colors.push(normal().abs()),
                Layer::SignedNormals => colors.push(normal()),
                Layer::Color | Layer::Samples { .. } | Layer::Cost(_) | Layer::Filter { .. } => {}
            }
        }
    }
}
