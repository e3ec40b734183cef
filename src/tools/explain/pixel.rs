//! Explains a pixel: traces each of its samples, records the rays behind it, and sums them to the picture's bytes.

use super::close_call::{CloseCall, CloseCallKind, close_primitives, is_about_zero};
use super::objects::Objects;
use super::stop::Stop;
use super::tree::{Crossing, LeftOut, LightBlocker, Lighting, NotFollowed};
use super::tree::{PixelTree, RayNode, SampleTree, Shadow, Surface};
use crate::diagnostic::Diagnostic;
use crate::math::ray::{Hit, Ray};
use crate::picture::{CHANNELS, Color, RED_FIRST, truncate_to_bytes};
use crate::render::renderer::Prepared;
use crate::render::{Progress, Request};
use crate::sampling::spread::weight_for;
use crate::sampling::sum::Sum;
use crate::scene::Object;
use crate::scene::material::Phong;
use crate::scene::texels::{FACES, face};
use crate::stats::{Counts, Probe};
use crate::trace::{Event, Memory, Observer, Patience, Tracer, is_critical};
use crate::world::SurfacePoint;
use glam::DVec2;
use std::ops::RangeInclusive;

/// Explains pixels of a scene.
#[derive(Debug)]
pub struct Explainer<'p, 'r> {
    prepared: &'p Prepared<'r>,
    objects: Objects<'p>,
}

/// The largest number of rays kept for a pixel.
const MAX_RAYS: usize = 1 << 12;
/// The largest number of these rays, their shadow rays and the surfaces these cross. Each takes a line of text and 400
/// bytes.
const MAX_LINES: usize = 1 << 17;
/// The largest number of samples kept for a pixel.
const MAX_SAMPLES: usize = 1 << 12;

impl<'p, 'r> Explainer<'p, 'r> {
    /// Creates an explainer for a scene whose renderer has kept its meshes.
    pub fn new(prepared: &'p Prepared<'r>) -> Result<Self, Diagnostic> {
        let renderer = prepared.renderer();
        let uses_mesh = |object: &Object| match *object {
            Object::Mesh { mesh, .. } => mesh >= renderer.meshes().len(),
            _ => false,
        };
        if renderer.scene.objects.iter().any(uses_mesh) {
            return Err(Diagnostic::error("the meshes were not kept"));
        }
        Ok(Self { prepared, objects: Objects::new(renderer)? })
    }

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
            highlight: scene.model.highlight,
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
        let mut recorder = Recorder {
            explainer: self,
            stop,
            rays: vec![],
            room,
            left_out: LeftOut::default(),
            waiting: vec![],
            current: None,
            counts: Counts::default(),
            shadow: None,
        };
        recorder.push(RayNode::new(*ray));
        recorder.non_shadow_ray();
        let is_over = |_| stop.is_over();
        let lights = self.prepared.renderer().scene.lights.len();
        let mut memory = Memory::new(Patience::until(&is_over, lights));
        let tracer = Tracer::new(self.prepared.caster(), request.effects);
        recorder.current = recorder.waiting.pop().flatten();
        let color = tracer.color(ray, &mut memory, &mut recorder);
        recorder.leave_out();
        (color, recorder.rays, recorder.left_out)
    }

    /// Returns a surface that a ray hits, without its lighting.
    fn surface(&self, point: &SurfacePoint, material: &Phong, hit: Hit) -> Surface {
        let world = self.prepared.caster().world;
        let (textures, parts) =
            world.with_rounded_point(point, |rounded| self.objects.mixing(point.material, rounded));
        let mut surface = Surface {
            object: self.objects.of(hit.primitive),
            t: hit.t,
            point: *point,
            material_at: self.objects.material_position(point.material),
            material: *material,
            paint: self.objects.paint(point, world),
            textures,
            parts: vec![],
            ambient: None,
            lights: vec![],
        };
        if parts.len() > 1 {
            // The tracer keeps highlights separate, because they have their own exponents.
            surface.material.specular = parts.iter().map(|part| part.weight * part.phong.specular).sum();
            surface.parts = parts;
        }
        surface
    }

    /// Completes a ray towards the light of this index, which leaves this primitive.
    fn finish_shadow(&self, shadow: &mut Shadow, light: usize, leaves: u32) {
        let caster = self.prepared.caster();
        let world = caster.world;
        let nearest = || {
            let visible = caster.nearest(&shadow.ray, Some(leaves), &mut Counts::default())?;
            Some(world.hit(&shadow.ray, visible))
        };
        let first = shadow.crossed.first().map(|crossing| crossing.hit).or_else(nearest);
        let sees = first.map(|hit| (hit.primitive, hit.t));
        shadow.close_calls = self.close_calls(&shadow.ray, Some(leaves), sees);
        if shadow.crossed.is_empty() {
            // A light on a surface is behind it, even if rounding lets the ray miss the surface.
            let at_light =
                world.primitives_at_light(light).first().map(|place| (place.primitive, shadow.ray.t_max));
            let blocker = sees.or(at_light);
            shadow.blocker =
                blocker.map(|(primitive, t)| LightBlocker { object: self.objects.of(primitive), t });
        }
    }

    fn close_calls(&self, ray: &Ray, leaves: Option<u32>, sees: Option<(u32, f64)>) -> Vec<CloseCall> {
        let close = close_primitives(self.prepared.caster().world, ray, leaves, sees);
        close.into_iter().map(|(kind, id)| CloseCall { kind, object: self.objects.of(id) }).collect()
    }
}

/// Records the descendants of one camera ray while the tracer follows them, as long as there is room.
struct Recorder<'e, 'p, 'r> {
    explainer: &'e Explainer<'p, 'r>,
    stop: &'e Stop,
    rays: Vec<RayNode>,
    /// The largest number of rays kept.
    room: usize,
    /// The rays that are not kept.
    left_out: LeftOut,
    /// The indices of pending rays, in the order of the tracer's pending rays. `None` for a ray that is not kept.
    waiting: Vec<Option<usize>>,
    current: Option<usize>,
    /// The work since the last ray was finished.
    counts: Counts,
    /// The last ray towards a light, until the light's contribution is known.
    shadow: Option<Shadow>,
}

impl RayNode {
    /// Starts the node of a camera ray.
    fn new(ray: Ray) -> Self {
        Self {
            kind: None,
            bounces: 0,
            ray,
            leaves: None,
            filter: Color::ONE,
            weight: 1.0,
            hit: None,
            counts: Counts::default(),
            surface: None,
            cube_face: None,
            color: Color::ZERO,
            ends: vec![],
            children: vec![],
            close_calls: vec![],
        }
    }

    /// Notes an event that concerns this ray alone.
    fn note(&mut self, event: Event) {
        match event {
            Event::NotFollowed { kind, end } => self.ends.push(NotFollowed { kind, end }),
            Event::Refracting { direction, normal, indices } if is_critical(direction, normal, indices) => {
                self.close_calls.insert(0, CloseCall::of(CloseCallKind::Critical));
            }
            Event::Ambient(color) => self.surface.iter_mut().for_each(|it| it.ambient = Some(color)),
            Event::Shaded(color) => self.color = color,
            _ => {}
        }
    }
}

impl Recorder<'_, '_, '_> {
    /// Counts the work for a ray that is not kept.
    fn leave_out(&mut self) {
        if self.current.is_none() {
            self.left_out.counts = self.left_out.counts.merge(std::mem::take(&mut self.counts));
        }
    }

    fn node(&mut self) -> Option<&mut RayNode> {
        self.rays.get_mut(self.current?)
    }

    /// Adds a ray, unless there is no room or its parent was not kept.
    fn push(&mut self, ray: RayNode) {
        let place = self.rays.len();
        let is_kept = place < self.room && (ray.kind.is_none() || self.current.is_some());
        if is_kept {
            self.node().iter_mut().for_each(|parent| parent.children.push(place));
            self.rays.push(ray);
        } else {
            self.left_out.rays += 1;
        }
        self.waiting.push(is_kept.then_some(place));
    }

    /// Notes what the current ray hits.
    fn hit(&mut self, hit: Option<Hit>) {
        let Self { explainer, stop, .. } = *self;
        if self.current.is_none() {
            return;
        }
        let counts = std::mem::take(&mut self.counts);
        let Some(node) = self.node() else { return };
        (node.hit, node.counts) = (hit, counts);
        let has_map = explainer.prepared.renderer().scene.cube_map.is_some();
        node.cube_face = (has_map && hit.is_none()).then(|| FACES[face(node.ray.direction).0]);
        if !stop.is_over() {
            let sees = hit.map(|hit| (hit.primitive, hit.t));
            node.close_calls = explainer.close_calls(&node.ray, node.leaves, sees);
        }
    }

    fn surface(&mut self, point: &SurfacePoint, material: &Phong) {
        let explainer = self.explainer;
        let Some(node) = self.node() else { return };
        let Some(hit) = node.hit else { return };
        let surface = explainer.surface(point, material, hit);
        let is_grazing = is_about_zero(surface.point.normal.dot(node.ray.direction));
        let is_in_boundary = explainer.objects.is_in_boundary(&surface, explainer.prepared.caster().world);
        let found = [(is_grazing, CloseCallKind::Cosine), (is_in_boundary, CloseCallKind::Boundary)];
        node.close_calls.extend(found.into_iter().filter(|(is, _)| *is).map(|(_, kind)| CloseCall::of(kind)));
        node.surface = Some(surface);
    }

    fn light(&mut self, light: Lighting) {
        let Self { explainer, stop, .. } = *self;
        if self.current.is_none() {
            return;
        }
        let counts = std::mem::take(&mut self.counts);
        let mut shadow = self.shadow.take();
        let Some(RayNode { surface: Some(surface), hit: Some(hit), .. }) = self.node() else { return };
        if let Some(shadow) = shadow.as_mut().filter(|_| !stop.is_over()) {
            shadow.counts = counts;
            explainer.finish_shadow(shadow, surface.lights.len(), hit.primitive);
            if is_about_zero(light.cosine) {
                shadow.close_calls.push(CloseCall::of(CloseCallKind::Cosine));
            }
        }
        surface.lights.push(Lighting { shadow, ..light });
    }
}

impl Probe for Recorder<'_, '_, '_> {
    const COUNTS: bool = true;

    fn intersections(&mut self, count: usize) {
        self.counts.intersections(count);
    }

    fn cell(&mut self) {
        self.counts.cell();
    }
}

impl Observer for Recorder<'_, '_, '_> {
    fn non_shadow_ray(&mut self) {
        self.counts.non_shadow_ray();
    }

    fn shadow_ray(&mut self) {
        self.counts.shadow_ray();
    }

    fn observe<'e>(&mut self, event: impl FnOnce() -> Event<'e>) {
        match event() {
            Event::Popped => {
                self.leave_out();
                self.current = self.waiting.pop().flatten();
            }
            Event::Met(hit) => self.hit(hit),
            Event::Surface { point, material } => self.surface(point, material),
            Event::Pushed { kind, ray, filter, weight, .. } => {
                let parent = self.node().map(|node| (node.bounces, node.hit));
                let (bounces, hit) = parent.unwrap_or_default();
                let leaves = hit.map(|hit| hit.primitive);
                let (kind, bounces) = (Some(kind), bounces + 1);
                self.push(RayNode { kind, bounces, leaves, filter, weight, ..RayNode::new(ray) });
            }
            Event::ShadowRay(ray) => {
                let (counts, crossed, close_calls) = Default::default();
                self.shadow =
                    self.current.map(|_| Shadow { ray, crossed, blocker: None, counts, close_calls });
            }
            Event::Crossed { hit, tint, leaves } => {
                if let Some(shadow) = &mut self.shadow {
                    let object = self.explainer.objects.of(hit.primitive);
                    shadow.crossed.push(Crossing { object, hit, tint, leaves });
                }
            }
            Event::Light { incident, cosine, passed, parts } => {
                self.light(Lighting { incident, cosine, passed, parts, shadow: None });
            }
            event => {
                if let Some(node) = self.node() {
                    node.note(event);
                }
            }
        }
    }
}
