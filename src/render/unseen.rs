//! What the rays through the corners of pixels are likely to miss: what is known of the picture without casting a ray.
//!
//! An edge that crosses a pixel has corners of the pixel on both sides. What is smaller than a pixel, or narrower, may have
//! none, and neither may the ends of something large. All triangles and shapes are projected onto the pixels. Where
//! something may be that no corner of a pixel shows, samples have a variance of p (1 - p) at most, with the part p of
//! the pixel that is covered. What materials may show beside what a ray has seen, such as highlights and mirrored or
//! refracted images, has no such bounds; there is a guess for each kind.
//!
//! All of this is part of what the picture means, since it decides how many samples are taken, but not of its expected
//! value.

use super::request::Request;
use crate::camera::{Camera, Eye, Projection};
use crate::math::aabb::Aabb;
use crate::primitive::shape::Form;
use crate::sampling::adaptive::Corner;
use crate::scene::Light;
use crate::scene::material::{Material, Phong};
use crate::trace::Effects;
use crate::world::{SurfacePoint, World};
use glam::{DVec2, DVec3, Vec2, Vec3A};
use std::ops::Range;

/// What samples may miss in a picture.
pub struct Unseen<'a> {
    world: &'a World,
    view: View,
    width: usize,
    /// For each material the variance that it may hide, and about its colour.
    materials: Vec<(f32, Option<Vec3A>)>,
    /// Where the vertices of the triangles are.
    vertices: Vec<Vertex>,
}

/// The same for some rows.
pub struct UnseenRows {
    width: usize,
    first_row: usize,
    pixels: Vec<Small>,
}

/// The small things in a pixel.
#[derive(Clone, Copy)]
struct Small {
    /// The part of the pixel that they cover.
    part: f32,
    /// How far ahead the nearest of them is.
    depth: f32,
    /// The material of all of them, or [`MIXED`].
    material: u32,
}

/// The bytes that a pixel takes.
pub const BYTES_PER_PIXEL: usize = size_of::<Small>();

/// The material of things of several materials.
const MIXED: u32 = u32::MAX;

const NOTHING: Small = Small { part: 0.0, depth: f32::INFINITY, material: MIXED };

/// A vertex in the picture.
#[derive(Clone, Copy)]
struct Vertex {
    /// In pixels from the lower left corner; NaN if it is not ahead of the eye.
    at: Vec2,
    depth: f32,
}

/// The square of a number of levels, the steps from one byte to the next.
const fn square_of_levels(levels: f32) -> f32 {
    (levels / 255.0) * (levels / 255.0)
}

/// The variances that are assumed where a surface is a mirror, clear glass, has a highlight that is narrow, or a texture,
/// and where something small is of the material that all corners show. They were chosen by `examples/sampling_marks`.
const IN_MIRROR: f32 = square_of_levels(6.0);
const IN_GLASS: f32 = square_of_levels(8.0);
const IN_HIGHLIGHT: f32 = square_of_levels(4.0);
const IN_TEXTURE: f32 = square_of_levels(6.0);
const OF_SAME_MATERIAL: f32 = square_of_levels(4.0);

/// The square of the contrast that small things have at least.
const LEAST_CONTRAST: f32 = square_of_levels(32.0);

/// The exponent from which highlights are narrow.
const NARROW: f64 = 40.0;

/// The part of a pixel that the end of something large covers.
const END: f32 = 1.0 / 64.0;

/// What is narrower than this number of pixels is small.
const SMALL: f32 = 1.5;

/// How far a projected vertex may be off, in pixels.
const ERROR: f32 = 1.0 / 32.0;

impl<'a> Unseen<'a> {
    /// For the whole picture of a request.
    pub fn new(camera: &Camera, world: &'a World, request: &Request) -> Self {
        let view = View::new(camera);
        let vertices = world.vertices.iter().map(|&vertex| view.project(vertex)).collect();
        let materials = materials(world, &request.effects);
        Self { world, view, width: request.size[0], materials, vertices }
    }

    /// The variance that a ray may hide that sees this surface.
    pub fn hidden_by(&self, surface: &SurfacePoint) -> f32 {
        self.materials.get(surface.material).map_or(0.0, |material| material.0)
    }

    /// How far ahead a point is.
    pub fn depth(&self, point: DVec3) -> f32 {
        self.view.depth(point) as f32
    }

    /// The same in these rows.
    pub fn rows(&self, rows: Range<usize>) -> UnseenRows {
        let pixels = vec![NOTHING; self.width * rows.len()];
        let mut found = UnseenRows { width: self.width, first_row: rows.start, pixels };
        let band = [rows.start as f32 - 1.0, rows.end as f32 + 1.0];
        for (id, triangle) in self.world.triangles.iter().enumerate() {
            let corners = triangle.map(|vertex| self.vertices[vertex as usize]);
            let [a, b, c] = corners.map(|corner| corner.at);
            let (min, max) = (a.min(b).min(c), a.max(b).max(c));
            if max.y < band[0] || min.y > band[1] || !self.world.may_be_hit(id as u32) {
                continue;
            }
            let material = self.world.material_of(id as u32) as u32;
            let depth = corners.iter().fold(f32::INFINITY, |least, corner| least.min(corner.depth));
            let area = 0.5 * (b - a).perp_dot(c - a).abs();
            let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt();
            // Where a corner is not ahead, there is no area, and the triangle is not small.
            if longest < SMALL {
                found.add_evenly(min, max, area, Small { part: 0.0, depth, material });
            } else if 2.0 * area < SMALL * longest {
                found.add_triangle([a, b, c], area, Small { part: 0.0, depth, material });
            } else {
                corners
                    .iter()
                    .for_each(|corner| found.add_end(corner.at, Small { part: END, depth, material }));
            }
        }
        for (shape, id) in self.world.shapes.iter().zip(self.world.triangles.len() as u32..) {
            let material = self.world.material_of(id) as u32;
            let Some((min, max, depth)) = self.view.bounds(&shape.bounds()) else { continue };
            if max.y < band[0] || min.y > band[1] {
                continue;
            }
            if (max - min).min_element() < SMALL {
                found.add_box(min, max, Small { part: 0.8, depth, material });
            } else {
                let middle = 0.5 * (min + max);
                let ends = [(min.x, middle.y), (max.x, middle.y), (middle.x, min.y), (middle.x, max.y)];
                ends.iter().for_each(|&end| found.add_end(end.into(), Small { part: END, depth, material }));
            }
        }
        found
    }
}

impl UnseenRows {
    /// The variance of samples in a pixel, beside what its corners show.
    pub fn variance(&self, unseen: &Unseen, [column, row]: [usize; 2], corners: &[Corner; 4]) -> f32 {
        let place = row.checked_sub(self.first_row).map(|row| row * self.width + column);
        let Some(Small { part, depth, material }) = place.and_then(|place| self.pixels.get(place)) else {
            return 0.0;
        };
        // What all corners show is nearer.
        if *part == 0.0 || corners.iter().all(|corner| corner.depth < *depth) {
            return 0.0;
        }
        if corners.iter().all(|corner| corner.material == Some(*material)) {
            return OF_SAME_MATERIAL * part.min(1.0);
        }
        let part = part.min(0.5);
        let color = unseen.materials.get(*material as usize).and_then(|material| material.1);
        let contrast = color.map_or(1.0, |color| {
            let squares = corners.iter().map(|corner| corner.color.distance_squared(color));
            (squares.sum::<f32>() / 12.0).clamp(LEAST_CONTRAST, 1.0)
        });
        part * (1.0 - part) * contrast
    }

    /// Adds something to a pixel, if that is in the rows.
    fn add(&mut self, [x, y]: [i64; 2], small: Small) {
        let row = y - self.first_row as i64;
        if row < 0 || x < 0 || x >= self.width as i64 {
            return;
        }
        let Some(pixel) = self.pixels.get_mut(row as usize * self.width + x as usize) else { return };
        let is_same = pixel.part == 0.0 || pixel.material == small.material;
        *pixel = Small {
            part: pixel.part + small.part,
            depth: pixel.depth.min(small.depth),
            material: if is_same { small.material } else { MIXED },
        };
    }

    /// The pixels of the rows that have a part between two places.
    fn pixels(&self, min: Vec2, max: Vec2) -> [Range<i64>; 2] {
        [0, 1].map(|axis| {
            let (first, end) = if axis == 0 {
                (0, self.width)
            } else {
                (self.first_row, self.first_row + self.pixels.len() / self.width)
            };
            // Numbers that are too large or small for an integer become the nearest one, and those below zero zero.
            let from = ((min[axis] - ERROR).max(0.0) as i64).max(first as i64);
            let end = if max[axis] < -ERROR { 0 } else { end };
            from..((max[axis] + ERROR) as i64).saturating_add(1).min(end as i64)
        })
    }

    /// Adds something that covers this area of its box, in which it may be anywhere.
    fn add_evenly(&mut self, min: Vec2, max: Vec2, area: f32, small: Small) {
        let [columns, rows] = self.pixels(min, max);
        let part = (area / (columns.clone().count() * rows.clone().count()) as f32).max(END / 4.0);
        for y in rows {
            columns.clone().for_each(|x| self.add([x, y], Small { part, ..small }));
        }
    }

    fn add_end(&mut self, at: Vec2, small: Small) {
        if at.is_finite() {
            self.add([at.x.floor() as i64, at.y.floor() as i64], small);
        }
    }

    /// Adds something that fills a part of its box, which is given, evenly.
    fn add_box(&mut self, min: Vec2, max: Vec2, small: Small) {
        let [columns, rows] = self.pixels(min, max);
        for y in rows {
            for x in columns.clone() {
                let corner = Vec2::new(x as f32, y as f32);
                let inside = (max.min(corner + 1.0) - min.max(corner)).max(Vec2::ZERO);
                let part = (small.part * inside.x * inside.y).max(END / 4.0);
                self.add([x, y], Small { part, ..small });
            }
        }
    }

    /// Adds a triangle that is narrow.
    fn add_triangle(&mut self, corners: [Vec2; 3], area: f32, small: Small) {
        let [a, b, c] = corners;
        let [_, rows] = self.pixels(a.min(b).min(c), a.max(b).max(c));
        let height = a.max(b).max(c).y - a.min(b).min(c).y;
        for y in rows {
            // The columns that its sides pass in this row.
            let (low, high) = (y as f32 - ERROR, (y + 1) as f32 + ERROR);
            let (mut min, mut max) = (Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY));
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let way = to - from;
                let at = |y: f32| from + ((y - from.y) / way.y).clamp(0.0, 1.0) * way;
                let ends = if way.y == 0.0 { [from, to] } else { [at(low), at(high)] };
                for end in ends.into_iter().filter(|end| end.y >= low - ERROR && end.y <= high + ERROR) {
                    (min, max) = (min.min(end), max.max(end));
                }
            }
            if min.x > max.x {
                continue;
            }
            let in_row = (max.y.min(high) - min.y.max(low)).max(0.0) / height.max(ERROR);
            let [columns, _] = self.pixels(min, max);
            let count = (columns.end - columns.start).max(1) as f32;
            for x in columns {
                let part = (area * in_row / count).max(END / 4.0);
                self.add([x, y], Small { part, ..small });
            }
        }
    }
}

/// For each material the variance that it may hide, and about its colour, if it has one.
fn materials(world: &World, effects: &Effects) -> Vec<(f32, Option<Vec3A>)> {
    let light = world.ambient + world.lights.iter().map(color_of).sum::<DVec3>();
    let brightness = |material: &Material| match material {
        Material::Phong(phong) => (phong.diffuse * light).max_element(),
        Material::Texture(_) | Material::Painted(..) => 0.0,
    };
    let brightest = world.materials.iter().map(brightness).fold(world.background.max_element(), f64::max);
    let mut materials: Vec<(f32, Option<Vec3A>)> = Vec::with_capacity(world.materials.len());
    for material in &world.materials {
        materials.push(match material {
            Material::Phong(phong) => {
                let half = (phong.diffuse * 0.5 * (world.ambient + light)).min(DVec3::ONE);
                let is_dull = !material.has_secondary_rays() || effects.bounces == 0;
                let hidden = hidden_by_phong(phong, effects, brightest.clamp(1.0, 4.0) as f32);
                (hidden, is_dull.then(|| half.as_vec3a()))
            }
            Material::Painted(phong, _) => {
                (IN_TEXTURE + hidden_by_phong(phong, effects, brightest.clamp(1.0, 4.0) as f32), None)
            }
            Material::Texture(texture) => {
                let children = texture.children.iter().filter_map(|&child| materials.get(child));
                (children.fold(IN_TEXTURE, |a, b| a.max(b.0)), None)
            }
        });
    }
    materials
}

fn color_of(light: &Light) -> DVec3 {
    let (Light::Directional { color, .. } | Light::Point { color, .. }) = *light;
    color
}

fn hidden_by_phong(phong: &Phong, effects: &Effects, brightest: f32) -> f32 {
    let square = |color: DVec3| (color.max_element().min(1.0) as f32).powi(2);
    let highlight = if phong.exponent >= NARROW { IN_HIGHLIGHT * square(phong.specular) } else { 0.0 };
    let secondary = IN_MIRROR * square(phong.reflective) + IN_GLASS * square(phong.transparent);
    highlight + if effects.bounces > 0 { secondary * brightest * brightest } else { 0.0 }
}

/// The picture that things are projected onto.
struct View {
    eye: Eye,
    is_perspective: bool,
    axes: [DVec3; 2],
}

impl View {
    fn new(camera: &Camera) -> Self {
        let (eye, is_perspective) = match camera.projection() {
            Projection::Perspective(eye) => (eye, true),
            Projection::Orthographic(eye) => (eye, false),
        };
        let axes = [eye.right, eye.up].map(|axis| axis / axis.length_squared());
        Self { eye, is_perspective, axes }
    }

    fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye.center).dot(self.eye.direction)
    }

    #[inline(always)]
    fn project(&self, point: DVec3) -> Vertex {
        let from_eye = point - self.eye.center;
        let across = DVec2::new(from_eye.dot(self.axes[0]), from_eye.dot(self.axes[1]));
        let depth = self.depth(point);
        let at = if self.is_perspective { across / depth } else { across } + self.eye.middle + 0.5;
        let at = if self.is_perspective && depth <= 0.0 { DVec2::NAN } else { at };
        Vertex { at: at.as_vec2(), depth: depth as f32 }
    }

    /// The box of a box in the picture, and the least depth; none if a part of it is not ahead of the eye.
    fn bounds(&self, bounds: &Aabb) -> Option<(Vec2, Vec2, f32)> {
        let (mut min, mut max, mut depth) = (Vec2::INFINITY, Vec2::NEG_INFINITY, f32::INFINITY);
        for corner in bounds.corners() {
            let vertex = self.project(corner);
            if !vertex.at.is_finite() {
                return None;
            }
            (min, max, depth) = (min.min(vertex.at), max.max(vertex.at), depth.min(vertex.depth));
        }
        Some((min, max, depth))
    }
}

#[cfg(test)]
mod tests;
