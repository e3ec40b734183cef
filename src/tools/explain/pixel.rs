//! Everything behind one pixel: its samples, each traced by itself, and the sum that becomes the picture's bytes.

use super::close_call::{CloseCall, CloseCallKind, RayEnds, close_primitives, is_about_zero};
use super::objects::Objects;
use super::ray_tree::{LightBlocker, RayNode, Recorder, Shadow, Surface};
use crate::camera::Camera;
use crate::caster::Caster;
use crate::math::ray::Ray;
use crate::math::robust::UNIT_ROUNDOFF;
use crate::picture::{CHANNELS, RED_FIRST, truncate_to_bytes};
use crate::render::Request;
use crate::renderer::Prepared;
use crate::sampling::spread::weight_for;
use crate::sampling::sum::Sum;
use crate::scene::error::SceneError;
use crate::scene::material::Material;
use crate::scene::{Color, Object};
use crate::shading::texture::is_in_boundary;
use crate::stats::Counts;
use crate::trace::{ByModel, Observer, Tracer};
use crate::world::World;
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

/// Why no pixel can be explained.
#[derive(Clone, Debug)]
pub enum ExplainError {
    /// The renderer has not kept its meshes.
    NoMeshes,
    /// The objects do not fit into a world.
    Scene(Box<SceneError>),
}

/// A pixel with all that contributes to it. `Display` prints it.
#[derive(Clone, Debug, Serialize)]
pub struct PixelTree {
    /// Column and row from the top left, (0, 0).
    pub pixel: [usize; 2],
    /// Whether there is a grid, whose cells are counted.
    pub has_grid: bool,
    /// The samples that have weight.
    pub samples: Vec<SampleTree>,
    /// The pixel's colour: the sum of the weighted colours over the sum of the weights.
    pub color: Color,
    /// The bytes of the picture.
    pub bytes: [u8; CHANNELS],
}

/// A sample with the rays behind it.
#[derive(Clone, Debug, Serialize)]
pub struct SampleTree {
    /// The pixel that it is a sample of: column and row from the top left.
    pub pixel: [usize; 2],
    /// Which of that pixel's samples it is, from 0.
    pub number: usize,
    /// From that pixel's centre to the right and up, in pixels.
    pub offset: DVec2,
    /// What it weighs in the sum.
    pub weight: f64,
    /// Its colour.
    pub color: Color,
    /// The camera's ray and all that follow from it, each after the one that it left.
    pub rays: Vec<RayNode>,
}

impl<'p, 'r> Explainer<'p, 'r> {
    /// For a scene whose renderer has kept its meshes.
    pub fn new(prepared: &'p Prepared<'r>) -> Result<Self, ExplainError> {
        let renderer = prepared.renderer();
        let uses_mesh = |object: &Object| match *object {
            Object::Mesh { mesh, .. } => mesh >= renderer.meshes().len(),
            _ => false,
        };
        if renderer.scene.objects.iter().any(uses_mesh) {
            return Err(ExplainError::NoMeshes);
        }
        let objects = Objects::new(renderer).map_err(|error| ExplainError::Scene(Box::new(error)))?;
        Ok(Self { prepared, objects })
    }

    /// Explains a pixel, by column and row from the top left, of the colours that a request shows; none where the
    /// picture has no such pixel.
    ///
    /// Samples are added up in the film's order, so that the colour is the rendered one to the last bit.
    pub fn pixel(&self, request: &Request, [x, y]: [usize; 2]) -> Option<PixelTree> {
        let [width, height] = request.size;
        if x >= width || y >= height {
            return None;
        }
        let target = [x, height - 1 - y];
        let camera = self.prepared.camera(request);
        let reached = |middle: usize, count: usize| -> RangeInclusive<usize> {
            let support = request.filter.support().min(width.max(height));
            middle.saturating_sub(support)..=(middle + support).min(count - 1)
        };
        let mut samples = vec![];
        let mut sum: Option<Sum> = None;
        for row in reached(target[1], height) {
            let mut row_sum = Sum::default();
            for column in reached(x, width) {
                for sample in self.samples(request, &camera, [column, row], target) {
                    row_sum.add(sample.weight, sample.color);
                    samples.push(sample);
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
        Some(PixelTree { pixel: [x, y], has_grid, samples, color, bytes })
    }

    /// The samples of the pixel `own` that have weight for `target`; rows count from the bottom.
    fn samples(
        &self,
        request: &Request,
        camera: &Camera,
        own: [usize; 2],
        target: [usize; 2],
    ) -> impl Iterator<Item = SampleTree> {
        let [column, row] = own;
        let height = request.size[1];
        let samples = self.prepared.samples(request, own).into_iter();
        samples.enumerate().filter_map(move |(number, (offset, area))| {
            let weight = weight_for(target, request.filter, own, offset) * area;
            (weight != 0.0).then(|| {
                let ray = camera.ray(DVec2::new(column as f64, row as f64), offset);
                let (color, rays) = self.trace(request, &ray);
                SampleTree { pixel: [column, height - 1 - row], number, offset, weight, color, rays }
            })
        })
    }

    /// Traces a camera ray and notes everything about it.
    fn trace(&self, request: &Request, ray: &Ray) -> (Color, Vec<RayNode>) {
        let caster = self.prepared.caster();
        let mut recorder = Recorder::of(*ray);
        recorder.non_shadow_ray();
        let effects = request.effects;
        let color = match caster.world.is_of_course() {
            true => Tracer { rules: caster, effects }.color(ray, &mut recorder),
            false => Tracer { rules: &ByModel(caster), effects }.color(ray, &mut recorder),
        };
        let mut rays = recorder.finish();
        // What a ray leaves is what the ray before it sees.
        let mut left = vec![None; rays.len()];
        for place in 0..rays.len() {
            for &child in &rays[place].children {
                left[child] = rays[place].hit.map(|hit| hit.primitive);
            }
            self.annotate(&mut rays[place], left[place]);
        }
        (color, rays)
    }

    /// Finds out what the tracer itself does not need to know.
    fn annotate(&self, node: &mut RayNode, leaves: Option<u32>) {
        let world = self.prepared.caster().world;
        let sees = node.hit.map(|hit| (hit.primitive, hit.t));
        node.close_calls.extend(self.close_calls(&node.ray, RayEnds { leaves, sees }));
        let (Some(surface), Some(hit)) = (&mut node.surface, node.hit) else { return };
        surface.object = self.objects.of(hit.primitive);
        surface.t = hit.t;
        surface.material_at = self.objects.material_position(surface.point.material);
        surface.textures = world
            .with_rounded_point(&surface.point, |point| self.objects.textures(surface.point.material, point));
        if is_about_zero(surface.point.normal.dot(node.ray.direction)) {
            node.close_calls.push(CloseCall { kind: CloseCallKind::Cosine, object: None });
        }
        if self.is_in_boundary(surface, world) {
            node.close_calls.push(CloseCall { kind: CloseCallKind::Boundary, object: None });
        }
        for (index, light) in surface.lights.iter_mut().enumerate() {
            let Some(shadow) = &mut light.shadow else { continue };
            self.annotate_shadow(shadow, index, hit.primitive);
            if is_about_zero(light.cosine) {
                shadow.close_calls.push(CloseCall { kind: CloseCallKind::Cosine, object: None });
            }
        }
    }

    /// Whether a checkerboard decides by roundings which material the surface has.
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
            let exclude = ((leaves as usize) < world.triangles.len()).then_some(leaves);
            caster
                .nearest(&shadow.ray, exclude, &mut Counts::default())
                .map(|visible| world.hit(&shadow.ray, visible))
        });
        let sees = sees.map(|hit| (hit.primitive, hit.t));
        shadow.close_calls = self.close_calls(&shadow.ray, RayEnds { leaves: Some(leaves), sees });
        if shadow.crossed.is_empty() {
            // A light on a triangle is behind it, whether or not the ray's roundings let it meet the triangle.
            let at_light =
                world.triangles_at_light(light).first().map(|&triangle| (triangle, shadow.ray.t_max));
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
    /// The work for all samples.
    pub fn counts(&self) -> Counts {
        let rays = self.samples.iter().flat_map(|sample| &sample.rays);
        rays.fold(Counts::default(), |sum, node| sum.merge(node.all_counts()))
    }

    /// The names of the channels whose byte a few roundings could change.
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
            Self::NoMeshes => f.write_str("the meshes were not kept"),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExplainError {}
