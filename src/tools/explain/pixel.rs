//! Explains a pixel: traces each of its samples, with a recorder of their rays, and sums them to the picture's bytes.

use super::explainer::Explainer;
use super::recorder::Recorder;
use super::stop::Stop;
use super::tree::{LeftOut, PixelTree, RayNode, SampleTree};
use crate::diagnostic::Diagnostic;
use crate::math::ray::Ray;
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
        let camera = self.prepared.camera(request);
        let reached = |middle: usize, count: usize| -> RangeInclusive<usize> {
            let support = request.filter.support().min(width.max(height));
            middle.saturating_sub(support)..=(middle + support).min(count - 1)
        };
        let scene = &self.prepared.renderer().scene;
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
                for (number, offset, weight, part) in self.samples(request, [column, row], target, stop) {
                    let ray = camera.ray(DVec2::new(column as f64, row as f64), offset);
                    let is_kept = tree.samples.len() < MAX_SAMPLES;
                    let kept = if is_kept { room.min(lines / (1 + scene.lights.len())) } else { 0 };
                    let (color, rays, left_out) = self.trace(request, &ray, kept, stop);
                    if stop.is_over() {
                        return Err(Diagnostic::error("the rays behind the pixel take too long"));
                    }
                    row_sum.add_for(weight, color, part);
                    room -= rays.len();
                    lines = lines.saturating_sub(rays.iter().map(RayNode::lines).sum());
                    tree.left_out.rays += left_out.rays;
                    tree.left_out.counts = tree.left_out.counts.merge(left_out.counts);
                    if is_kept {
                        let (pixel, weight) = ([column, height - 1 - row], weight * part);
                        tree.samples.push(SampleTree {
                            pixel,
                            number,
                            offset,
                            weight,
                            color,
                            rays,
                            left_out,
                        });
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

    /// Returns the samples of the pixel `own` with nonzero weight for `target`: index, offset, filter weight, and the
    /// part of the pixel that each represents. Rows count from the bottom.
    fn samples(
        &self,
        request: &Request,
        own: [usize; 2],
        target: [usize; 2],
        stop: &Stop,
    ) -> impl Iterator<Item = (usize, DVec2, f64, f64)> {
        let filter = request.filter;
        let watch = |progress: Progress| stop.watch(progress);
        let samples = self.prepared.samples(request, own, &watch).into_iter();
        samples.enumerate().filter_map(move |(number, (offset, part))| {
            let weight = weight_for(target, filter, own, offset);
            (weight != 0.0).then_some((number, offset, weight, part))
        })
    }

    /// Traces a camera ray and records its descendants as long as there is room.
    fn trace(
        &self,
        request: &Request,
        ray: &Ray,
        room: usize,
        stop: &Stop,
    ) -> (Color, Vec<RayNode>, LeftOut) {
        let mut recorder = Recorder::new(self, *ray, room, stop);
        let is_over = |_| stop.is_over();
        let lights = self.prepared.renderer().scene.lights.len();
        let mut memory = Memory::until(&is_over, lights);
        let tracer = Tracer::new(self.prepared.caster(), request.effects);
        let color = tracer.color(ray, &mut memory, &mut recorder);
        let (rays, left_out) = recorder.finish();
        (color, rays, left_out)
    }
}
