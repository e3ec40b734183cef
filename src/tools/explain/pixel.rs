//! Explains a pixel: traces each of its samples, with a recorder of their rays, and sums them to the picture's bytes.

use super::explainer::Explainer;
use super::recorder::Recorder;
use super::stop::Stop;
use super::tree::{LeftOut, PixelTree, RayNode, SampleTree};
use crate::diagnostic::Diagnostic;
use crate::picture::{CHANNELS, Color, RED_FIRST, truncate_to_bytes};
use crate::render::{Progress, Request};
use crate::sampling::spread::weight_for;
use crate::sampling::sum::Sum;
use crate::trace::{Memory, Tracer};
use glam::DVec2;
use std::ops::RangeInclusive;

/// The largest number of rays kept for a pixel.
const MAX_RAYS: usize = 1 << 12;
/// The largest number of these rays, their shadow rays and the surfaces these cross. Each takes a line of text and 400
/// bytes.
const MAX_LINES: usize = 1 << 17;
/// The largest number of samples kept for a pixel.
const MAX_SAMPLES: usize = 1 << 12;

impl Explainer<'_, '_> {
    /// Explains the colour of a pixel, given by column and row from the top left. Fails if the picture does not contain
    /// the pixel, or if `stop` ends the work.
    ///
    /// Samples are added in the film's order, so the colour equals the rendered one to the last bit. The first rays and
    /// samples are kept, and the others are counted.
    pub fn pixel(&self, request: &Request, [x, y]: [usize; 2], stop: &Stop) -> Result<PixelTree, Diagnostic> {
        let [width, height] = request.size;
        if x >= width || y >= height {
            return Err(Diagnostic::error("outside the picture"));
        }
        let target = [x, height - 1 - y];
        let reached = |middle: usize, count: usize| -> RangeInclusive<usize> {
            let support = request.filter.support().min(width.max(height));
            middle.saturating_sub(support)..=(middle + support).min(count - 1)
        };
        let (watch, is_over) = (|progress: Progress| stop.watch(progress), |_| stop.is_over());
        let (camera, scene) = (self.prepared.camera(request), &self.prepared.renderer().scene);
        let tracer = Tracer::new(self.prepared.caster(), request.effects);
        let mut memory = Memory::until(&is_over, scene.lights.len());
        let mut tree = PixelTree {
            pixel: [x, y],
            has_grid: self.prepared.cells().is_some(),
            highlight: scene.lighting.highlight,
            has_cube_map: scene.cube_map.is_some(),
            samples: vec![],
            more_samples: 0,
            left_out: LeftOut::default(),
            color: Color::ZERO,
            bytes: [0; CHANNELS],
        };
        let (mut room, mut lines) = (MAX_RAYS, MAX_LINES);
        let mut sum: Option<Sum> = None;
        for row in reached(target[1], height) {
            let mut row_sum = Sum::default();
            for column in reached(x, width) {
                let own = [column, row];
                let samples = self.prepared.samples(request, own, &watch);
                for (number, (offset, part)) in samples.into_iter().enumerate() {
                    let weight = weight_for(target, request.filter, own, offset);
                    if weight == 0.0 {
                        continue;
                    }

                    // Trace the sample, and record its rays as long as there is room.
                    let ray = camera.ray(DVec2::new(column as f64, row as f64), offset);
                    let is_kept = tree.samples.len() < MAX_SAMPLES;
                    let kept = if is_kept { room.min(lines / (1 + scene.lights.len())) } else { 0 };
                    let mut recorder = Recorder::new(self, ray, kept, stop);
                    let color = tracer.color(&ray, &mut memory, &mut recorder);
                    let (rays, left_out) = recorder.finish();
                    if stop.is_over() {
                        return Err(Diagnostic::error("the rays behind the pixel take too long"));
                    }

                    // Add it to the tree.
                    row_sum.add(weight, color, part);
                    room -= rays.len();
                    lines = lines.saturating_sub(rays.iter().map(RayNode::lines).sum());
                    tree.left_out.rays += left_out.rays;
                    tree.left_out.counts = tree.left_out.counts.merge(left_out.counts);
                    if is_kept {
                        let (pixel, weight) = ([column, height - 1 - row], weight * part);
                        let sample = SampleTree { pixel, number, offset, weight, color, rays, left_out };
                        tree.samples.push(sample);
                    } else {
                        tree.more_samples += 1;
                    }
                }
            }
            match &mut sum {
                Some(sum) => sum.join(row_sum),
                None => sum = Some(row_sum),
            }
        }
        tree.color = sum.unwrap_or_default().color();
        truncate_to_bytes::<RED_FIRST>(&[tree.color], &mut tree.bytes);
        Ok(tree)
    }
}
