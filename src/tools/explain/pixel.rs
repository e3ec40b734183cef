//! Explains a pixel: traces each of its samples, and sums them to the picture's bytes.

use super::close_call::{CloseCall, CloseCallKind, RayEnds, close_primitives, is_about_zero};
use super::objects::{MaterialPart, Objects};
use super::ray_tree::{LeftOut, LightBlocker, RayNode, Recorder, Shadow, Surface};
use super::stop::Stop;
use crate::base::escape::escape;
use crate::caster::{Caster, RayOrigin};
use crate::diagnostic::Diagnostic;
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::picture::{CHANNELS, Color, RED_FIRST, truncate_to_bytes};
use crate::render::renderer::Prepared;
use crate::render::{Progress, Request};
use crate::sampling::spread::weight_for;
use crate::sampling::sum::Sum;
use crate::scene::Object;
use crate::scene::material::{Material, Paint};
use crate::scene::model::Highlight;
use crate::scene::texels::{FACES, face};
use crate::shading::texture::is_in_boundary;
use crate::stats::Counts;
use crate::trace::{Memory, Observer, Tracer};
use crate::world::{SurfacePoint, World};
use glam::DVec2;
use serde::Serialize;
use std::fmt;
use std::ops::RangeInclusive;

/// Explains pixels of a scene.
#[derive(Debug)]
pub struct Explainer<'p, 'r> {
    prepared: &'p Prepared<'r>,
    objects: Objects<'p>,
}

/// The reason why a pixel cannot be explained.
#[derive(Clone, Debug)]
pub enum ExplainError {
    /// The picture does not contain the pixel.
    Outside,
    /// It took too long, or was cancelled.
    Stopped,
}

/// A pixel with everything that contributes to it. `Display` prints it.
#[derive(Clone, Debug, Serialize)]
pub struct PixelTree {
    /// Column and row from the top left, (0, 0).
    pub pixel: [usize; 2],
    /// True if there is a grid, whose cells are counted.
    pub has_grid: bool,
    /// The terms of the scene's language for materials.
    #[serde(skip)]
    pub words: MaterialWords,
    /// The first samples with nonzero weight.
    pub samples: Vec<SampleTree>,
    /// The number of further samples.
    pub more_samples: u64,
    /// The rays of all samples that are not kept.
    pub left_out: LeftOut,
    /// The pixel's colour: the sum of the weighted colours over the sum of the weights.
    pub color: Color,
    /// The bytes in the picture.
    pub bytes: [u8; CHANNELS],
}

/// The terms of a scene language for materials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialWords {
    /// Mirrors have a reflective colour, glass a transparent one, and highlights a specular one with an exponent.
    Reflective,
    /// The specular colour applies to mirrors, glass and highlights, which have a shininess.
    Specular,
}

impl MaterialWords {
    /// Returns the terms used in scenes with these highlights.
    fn of(highlight: Highlight) -> Self {
        match highlight {
            Highlight::Blinn => Self::Reflective,
            Highlight::Phong => Self::Specular,
        }
    }
}

/// A sample with the rays behind it.
#[derive(Clone, Debug, Serialize)]
pub struct SampleTree {
    /// The pixel that contains the sample: column and row from the top left.
    pub pixel: [usize; 2],
    /// The index of the sample in that pixel, from 0.
    pub number: usize,
    /// The offset from that pixel's centre to the right and up, in pixels.
    pub offset: DVec2,
    /// Its weight in the sum.
    pub weight: f64,
    /// The colour of the sample.
    pub color: Color,
    /// The camera ray and all its descendants. Each comes after its parent. If there are too many, only the first ones
    /// are kept.
    pub rays: Vec<RayNode>,
    /// The rays that are not kept.
    pub left_out: LeftOut,
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
    pub fn pixel(
        &self,
        request: &Request,
        [x, y]: [usize; 2],
        stop: &Stop,
    ) -> Result<PixelTree, ExplainError> {
        let [width, height] = request.size;
        if x >= width || y >= height {
            return Err(ExplainError::Outside);
        }
        let target = [x, height - 1 - y];
        let camera = self.prepared.camera(request);
        let reached = |middle: usize, count: usize| -> RangeInclusive<usize> {
            let support = request.filter.support().min(width.max(height));
            middle.saturating_sub(support)..=(middle + support).min(count - 1)
        };
        let mut samples = vec![];
        let (mut more_samples, mut left_out) = (0, LeftOut::default());
        let lights = self.prepared.renderer().scene.lights.len();
        let (mut room, mut lines) = (MAX_RAYS, MAX_LINES);
        let mut sum: Option<Sum> = None;
        for row in reached(target[1], height) {
            let mut row_sum = Sum::default();
            for column in reached(x, width) {
                for (number, offset, weight, part) in self.samples(request, [column, row], target, stop) {
                    let ray = camera.ray(DVec2::new(column as f64, row as f64), offset);
                    let is_kept = samples.len() < MAX_SAMPLES;
                    let kept = if is_kept { room.min(lines / (1 + lights)) } else { 0 };
                    let (color, rays, rest) = self.trace(request, &ray, kept, stop);
                    if stop.is_over() {
                        return Err(ExplainError::Stopped);
                    }
                    row_sum.add_for(weight, color, part);
                    room -= rays.len();
                    lines = lines.saturating_sub(rays.iter().map(RayNode::lines).sum());
                    left_out.rays += rest.rays;
                    left_out.counts = left_out.counts.merge(rest.counts);
                    if is_kept {
                        let pixel = [column, height - 1 - row];
                        let (left_out, weight) = (rest, weight * part);
                        samples.push(SampleTree { pixel, number, offset, weight, color, rays, left_out });
                    } else {
                        more_samples += 1;
                    }
                }
            }
            match &mut sum {
                Some(sum) => sum.join(row_sum),
                None => sum = Some(row_sum),
            }
        }
        let color = sum.unwrap_or_default().color();
        let mut bytes = [0; CHANNELS];
        truncate_to_bytes::<RED_FIRST>(&[color], &mut bytes);
        let has_grid = self.prepared.cells().is_some();
        let words = MaterialWords::of(self.prepared.renderer().scene.lighting.highlight);
        Ok(PixelTree { pixel: [x, y], has_grid, words, samples, more_samples, left_out, color, bytes })
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
        let mut recorder = Recorder::of(*ray, room);
        recorder.non_shadow_ray();
        let tracer = Tracer::new(self.prepared.caster(), request.effects);
        let lights = self.prepared.renderer().scene.lights.len();
        let is_over = |_| stop.is_over();
        let mut memory = Memory::until(&is_over, lights);
        let color = tracer.color(ray, &mut memory, &mut recorder);
        let (mut rays, left_out) = recorder.finish();
        // A ray leaves the primitive that its parent hits.
        let mut left = vec![None; rays.len()];
        for place in 0..rays.len() {
            if stop.is_over() {
                break;
            }
            for &child in &rays[place].children {
                left[child] = rays[place].hit.map(|hit| hit.primitive);
            }
            self.annotate(&mut rays[place], left[place], stop);
        }
        (color, rays, left_out)
    }

    /// Adds information that the tracer itself does not need.
    fn annotate(&self, node: &mut RayNode, leaves: Option<u32>, stop: &Stop) {
        let world = self.prepared.caster().world;
        let sees = node.hit.map(|hit| (hit.primitive, hit.t));
        node.close_calls.extend(self.close_calls(&node.ray, RayEnds { leaves, sees }));
        let (Some(surface), Some(hit)) = (&mut node.surface, node.hit) else {
            let has_map = self.prepared.renderer().scene.cube_map.is_some();
            node.cube_face = has_map.then(|| FACES[face(node.ray.direction).0]);
            return;
        };
        surface.paint = self.paint(&surface.point, world);
        surface.object = self.objects.of(hit.primitive);
        surface.t = hit.t;
        surface.material_at = self.objects.material_position(surface.point.material);
        let mixing = world
            .with_rounded_point(&surface.point, |point| self.objects.mixing(surface.point.material, point));
        surface.textures = mixing.textures;
        if mixing.parts.len() > 1 {
            // The tracer keeps highlights separate, because they have their own exponents.
            let specular = |part: &MaterialPart| part.weight * part.phong.specular;
            surface.material.specular = mixing.parts.iter().map(specular).sum();
            surface.parts = mixing.parts;
        }
        if is_about_zero(surface.point.normal.dot(node.ray.direction)) {
            node.close_calls.push(CloseCall { kind: CloseCallKind::Cosine, object: None });
        }
        if self.is_in_boundary(surface, world) {
            node.close_calls.push(CloseCall { kind: CloseCallKind::Boundary, object: None });
        }
        for (index, light) in surface.lights.iter_mut().enumerate() {
            if stop.is_over() {
                return;
            }
            let Some(shadow) = &mut light.shadow else { continue };
            self.annotate_shadow(shadow, index, hit.primitive);
            if is_about_zero(light.cosine) {
                shadow.close_calls.push(CloseCall { kind: CloseCallKind::Cosine, object: None });
            }
        }
    }

    /// Returns the source of the diffuse colour at a point, if it is not the material itself.
    fn paint(&self, point: &SurfacePoint, world: &World) -> Option<String> {
        let scene = &self.prepared.renderer().scene;
        match scene.materials.get(point.material)? {
            &Material::Painted(_, Paint::Image { image, .. }) => {
                world.image_color(image, point)?;
                Some(format!("the texture {}", escape(&scene.images.get(image)?.name)))
            }
            Material::Painted(_, Paint::Pattern(..)) => Some("the noise".into()),
            Material::Phong(_) | Material::Texture(_) => None,
        }
    }

    /// Returns true if rounding decides which material of a checkerboard the surface has.
    fn is_in_boundary(&self, surface: &Surface, world: &World) -> bool {
        let materials = &self.prepared.renderer().scene.materials;
        surface.textures.iter().any(|texture| match materials.get(texture.material) {
            Some(Material::Texture(texture)) => {
                world.with_rounded_point(&surface.point, |point| is_in_boundary(texture, point))
            }
            _ => false,
        })
    }

    fn annotate_shadow(&self, shadow: &mut Shadow, light: usize, leaves: u32) {
        let caster: &Caster = self.prepared.caster();
        let world = caster.world;
        for crossing in &mut shadow.crossed {
            crossing.object = self.objects.of(crossing.hit.primitive);
        }
        let first = shadow.crossed.first().map(|crossing| crossing.hit);
        let sees = first.or_else(|| {
            caster
                .nearest(&shadow.ray, RayOrigin::on(world, Some(leaves)), &mut Counts::default())
                .map(|visible| world.hit(&shadow.ray, visible))
        });
        let sees = sees.map(|hit| (hit.primitive, hit.t));
        shadow.close_calls = self.close_calls(&shadow.ray, RayEnds { leaves: Some(leaves), sees });
        if shadow.crossed.is_empty() {
            // A light on a surface is behind it, even if rounding lets the ray miss the surface.
            let at_light =
                world.primitives_at_light(light).first().map(|place| (place.primitive, shadow.ray.t_max));
            let blocker = sees.or(at_light);
            shadow.blocker =
                blocker.map(|(primitive, t)| LightBlocker { object: self.objects.of(primitive), t });
        }
    }

    fn close_calls(&self, ray: &Ray, seen: RayEnds) -> Vec<CloseCall> {
        let close = close_primitives(self.prepared.caster().world, ray, seen);
        close.into_iter().map(|(kind, id)| CloseCall { kind, object: self.objects.of(id) }).collect()
    }
}

impl PixelTree {
    /// Returns the work for all samples.
    pub fn counts(&self) -> Counts {
        let rays = self.samples.iter().flat_map(|sample| &sample.rays);
        rays.fold(self.left_out.counts, |sum, node| sum.merge(node.all_counts()))
    }

    /// Returns the names of the channels whose byte a few roundings could change.
    pub fn close_channels(&self) -> impl Iterator<Item = &'static str> {
        let channels = ["red", "green", "blue"].into_iter().zip(self.color.to_array());
        channels.filter(|&(_, channel)| is_about_to_change(channel)).map(|(name, _)| name)
    }
}

fn is_about_to_change(channel: f64) -> bool {
    const ROUNDINGS: f64 = 16.0;
    let level = 255.0 * channel;
    let whole = level.round();
    (1.0..=255.0).contains(&whole) && (level - whole).abs() <= ROUNDINGS * UNIT_ROUNDOFF * whole
}

impl fmt::Display for ExplainError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Outside => f.write_str("outside the picture"),
            Self::Stopped => f.write_str("the rays behind the pixel take too long"),
        }
    }
}

impl std::error::Error for ExplainError {}
