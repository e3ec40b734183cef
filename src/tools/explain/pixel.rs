//! Explains a pixel: traces each of its samples, records their rays, and sums them to the picture's bytes.

use super::close_call::is_about_zero;
use super::explainer::Explainer;
use super::tree::{CloseCall, CloseCallKind, Crossing, LeftOut, Lighting, NotFollowed};
use super::tree::{PixelTree, RayNode, SampleTree, Shadow};
use crate::caster::{Caster, CourseSteps};
use crate::diagnostic::Diagnostic;
use crate::math::ray::Ray;
use crate::picture::{Color, RED_FIRST, truncate_to_bytes};
use crate::render::{Progress, Request, Stop};
use crate::sampling::spread::weight_for;
use crate::sampling::sum::Sum;
use crate::stats::Counts;
use crate::trace::{Event, Observer, RayStack, Secondary, Tracer, is_critical};
use glam::DVec2;
use std::mem::take;

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
        let reached = |middle: usize, count: usize| {
            let support = request.filter.support().min(width.max(height));
            middle.saturating_sub(support)..=(middle + support).min(count - 1)
        };
        let (watch, is_over) = (|progress: Progress| stop.watch(progress), |_| stop.is_over());
        let (camera, lights) = (self.prepared.camera(request), self.scene.lights.len());
        let caster = self.prepared.caster(stop)?;
        let tracer = Tracer::new(&caster, request.effects);
        let mut stack = RayStack::until(&is_over, caster.world);
        let mut tree = PixelTree {
            pixel: [x, y],
            has_grid: self.prepared.cells().is_some(),
            highlight: self.scene.lighting.highlight,
            has_cube_map: self.scene.cube_map.is_some(),
            ..PixelTree::default()
        };
        let (mut room, mut lines) = (MAX_RAYS, MAX_LINES);
        let mut sum = Sum::default();
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
                    let kept = if is_kept { room.min(lines / (1 + lights)) } else { 0 };
                    let mut recorder = Recorder::new(self, &caster, ray, kept, stop);
                    let color = tracer.color(&ray, &mut stack, &mut recorder);
                    recorder.leave_out();
                    if stop.is_over() {
                        return Err(Diagnostic::error("the rays behind the pixel take too long"));
                    }

                    // Add it to the tree.
                    let Recorder { rays, left_out, .. } = recorder;
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
            sum.join(row_sum);
        }
        tree.color = sum.color();
        truncate_to_bytes::<RED_FIRST>(&[tree.color], &mut tree.bytes);
        Ok(tree)
    }
}

/// Records the descendants of one camera ray while the tracer follows them, as long as there is room.
struct Recorder<'e, 'p, 'r> {
    explainer: &'e Explainer<'p, 'r>,
    caster: &'e Caster<'e>,
    stop: &'e Stop,
    /// The camera ray first, and each ray after its parent.
    rays: Vec<RayNode>,
    /// The largest number of rays kept.
    room: usize,
    left_out: LeftOut,
    /// The index of each ray that waits on the tracer's stack, or `None` if it is not kept.
    waiting: Vec<Option<usize>>,
    current: Option<usize>,
    /// The work since the last ray was finished.
    counts: Counts,
    /// The last ray towards a light, until the light's contribution is known.
    shadow: Option<Shadow>,
}

impl<'e, 'p, 'r> Recorder<'e, 'p, 'r> {
    /// Starts with a camera ray.
    fn new(
        explainer: &'e Explainer<'p, 'r>,
        caster: &'e Caster,
        ray: Ray,
        room: usize,
        stop: &'e Stop,
    ) -> Self {
        let (rays, left_out, waiting, current, counts, shadow) = Default::default();
        let mut recorder =
            Self { explainer, caster, stop, rays, room, left_out, waiting, current, counts, shadow };
        recorder.push(None, ray, Color::ONE, 1.0);
        recorder.current = recorder.waiting.pop().flatten();
        recorder.non_shadow_ray();
        recorder
    }

    /// Counts the work for the current ray if it is not kept.
    fn leave_out(&mut self) {
        if self.current.is_none() {
            self.left_out.counts = self.left_out.counts.merge(take(&mut self.counts));
        }
    }

    /// Adds a ray, unless there is no room or its parent was not kept.
    fn push(&mut self, kind: Option<Secondary>, ray: Ray, filter: Color, weight: f64) {
        let place = self.rays.len();
        let is_kept = place < self.room && (kind.is_none() || self.current.is_some());
        self.waiting.push(is_kept.then_some(place));
        if !is_kept {
            self.left_out.rays += 1;
            return;
        }
        let (mut bounces, mut origin_primitive) = (0, None);
        if let Some(parent) = self.current.map(|parent| &mut self.rays[parent]) {
            parent.children.push(place);
            (bounces, origin_primitive) = (parent.bounces + 1, parent.hit.map(|hit| hit.primitive));
        }
        self.rays.push(RayNode {
            kind,
            bounces,
            ray,
            origin_primitive,
            filter,
            weight,
            ..RayNode::default()
        });
    }
}

impl Observer for Recorder<'_, '_, '_> {
    const COUNTS: bool = true;

    fn steps(&mut self, steps: CourseSteps) {
        self.counts.steps(steps);
    }

    fn non_shadow_ray(&mut self) {
        self.counts.non_shadow_ray();
    }

    fn shadow_ray(&mut self) {
        self.counts.shadow_ray();
    }

    fn observe<'e>(&mut self, event: impl FnOnce() -> Event<'e>) {
        let (event, node) = (event(), self.current.map(|place| &mut self.rays[place]));
        let (explainer, is_in_time) = (self.explainer, || !self.stop.is_over());
        let close = |kind| CloseCall { kind, object: None };
        match (event, node) {
            (Event::Popped, _) => {
                self.leave_out();
                self.current = self.waiting.pop().flatten();
            }
            (Event::Pushed { kind, ray, filter, weight }, _) => self.push(Some(kind), ray, filter, weight),
            // The other events concern the current ray.
            (_, None) => {}
            (Event::Met(hit), Some(node)) => {
                (node.hit, node.counts) = (hit, take(&mut self.counts));
                if is_in_time() {
                    node.close_calls = explainer.close_calls(&node.ray, node.origin_primitive, hit);
                }
            }
            (Event::Surface { point, material }, Some(node)) => explainer.add_surface(node, point, material),
            (Event::NotFollowed { kind, end }, Some(node)) => node.ends.push(NotFollowed { kind, end }),
            (Event::Refracting { direction, normal, indices }, Some(node)) => {
                if is_critical(direction, normal, indices) {
                    node.close_calls.insert(0, close(CloseCallKind::Critical));
                }
            }
            (Event::Ambient(color), Some(node)) => {
                node.surface.iter_mut().for_each(|surface| surface.ambient = Some(color));
            }
            (Event::ShadowRay(ray), Some(_)) => self.shadow = Some(Shadow { ray, ..Shadow::default() }),
            (Event::Crossed { hit, tint, is_leaving }, Some(_)) => {
                if let Some(shadow) = &mut self.shadow {
                    let object = explainer.object(hit.primitive);
                    shadow.crossed.push(Crossing { object, hit, tint, is_leaving });
                }
            }
            (Event::Light { incident, cosine, passed, parts }, Some(node)) => {
                let (Some(surface), Some(hit)) = (&mut node.surface, node.hit) else { return };
                let (counts, mut shadow) = (take(&mut self.counts), self.shadow.take());
                if let Some(shadow) = shadow.as_mut().filter(|_| is_in_time()) {
                    shadow.counts = counts;
                    explainer.finish_shadow(shadow, surface.lights.len(), hit.primitive, self.caster);
                    if is_about_zero(cosine) {
                        shadow.close_calls.push(close(CloseCallKind::Cosine));
                    }
                }
                surface.lights.push(Lighting { incident, cosine, passed, parts, shadow });
            }
            (Event::Shaded(color), Some(node)) => node.color = color,
        }
    }
}
