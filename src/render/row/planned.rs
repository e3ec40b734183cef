//! Takes the planned adaptive samples of a row of pixels.

use super::{Colors, Painter, RenderSetting};
use crate::picture::Color;
use crate::render::plan::Plan;
use crate::render::tracing::PictureTracer;
use crate::sampling::drand48::Jump;
use crate::sampling::multi_jittered::MultiJittered;
use crate::sampling::sample_packet::SamplePacket;
use crate::stats::Counts;
use glam::DVec2;
use std::ops::Range;

/// The results of rays that do not contribute to the picture.
pub struct Looked {
    pub colors: Vec<Color>,
    /// The cost of all rays together.
    pub counts: Counts,
    /// The cost of each ray, if costs are a layer.
    pub costs: Vec<Counts>,
}

impl RenderSetting<'_> {
    /// Casts rays through these columns of row `j`, at these offsets from their pixels' centres. Returns `None` if the
    /// render is cancelled meanwhile.
    pub fn look(
        &self,
        tracer: &PictureTracer,
        j: usize,
        mut places: impl Iterator<Item = (usize, DVec2)>,
    ) -> Option<Looked> {
        let mut painter = self.painter(self.empty_row(j, None), tracer, false);
        painter.row.colors = Colors::Unwanted;
        let (mut packet, mut colors, mut costs) = (SamplePacket::default(), vec![], vec![]);
        let has_costs = self.request.has_costs();
        let at_once = if has_costs { 1 } else { SamplePacket::SIZE };
        loop {
            places.by_ref().take(at_once).for_each(|(column, offset)| packet.push(column, offset, false));
            let count = packet.samples().len();
            if count == 0 {
                return Some(Looked { colors, counts: painter.row.counts, costs });
            }
            let before = painter.row.counts;
            colors.extend_from_slice(&painter.colors_of(&mut packet)[..count]);
            packet.clear();
            if has_costs {
                costs.push(painter.row.counts.since(before));
            }
            if painter.memory.is_cut() {
                return None;
            }
        }
    }

    /// Returns the offsets of the planned samples of a pixel.
    pub fn offsets(&self, plan: &Plan, [column, j]: [usize; 2]) -> MultiJittered {
        let index = (column * self.request.size[1] + j) as u64;
        let rng = self.request.sampler.rng().jumped(index * MultiJittered::draws(plan.most));
        MultiJittered::new(plan.strata(column), rng)
    }
}

impl Painter<'_> {
    /// Traces the planned samples of the pixels in these columns, packet by packet.
    pub fn take_planned(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        let Some(plan) = self.plan else { return };
        let [_, height] = self.setting.request.size;
        let draws = MultiJittered::draws(plan.most);
        let mut rng = self.setting.request.sampler.rng().jumped(self.index(columns.start) * draws);
        let jump = Jump::of(draws * height as u64);
        for column in columns {
            let mut offsets = MultiJittered::new(plan.strata(column), rng);
            rng = rng.after(jump);
            while let Some(offset) = offsets.next() {
                packet.push(column, offset, offsets.len() == 0);
                if packet.is_full() {
                    self.color_samples(packet);
                }
            }
        }
        self.color_samples(packet);
    }
}
