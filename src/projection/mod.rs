//! What the camera sees first: the triangles and planes, projected onto the centres of the pixels.
//!
//! Where one ray for each pixel leaves one eye, it is much cheaper to ask each triangle for its pixels
//! than each ray for its triangle. The answer is the one that casting the ray gives, or none: where
//! rounding leaves a doubt, the ray has to be cast.

mod band;
mod outline;
mod sprite;
#[cfg(test)]
mod worst_cases;

use crate::camera::{Camera, Eye};
use crate::grid::Caster;
use crate::math::aabb::Aabb;
use crate::math::ray::{Hit, Ray};
use crate::world::{Primitive, World};
use band::Band;
use glam::DVec3;
use outline::Layer;
use rayon::prelude::*;
use sprite::{Place, Sprite};
use std::ops::Range;

/// What the rays through the centres of some rows of pixels hit first.
#[derive(Debug)]
pub struct Projection {
    /// From one row to the next.
    stride: usize,
    first_row: usize,
    /// A primitive's number for each pixel, or one of the two below.
    seen: Vec<u32>,
}

/// The number of no primitive.
const NOTHING: u32 = u32::MAX;
/// The number of what only a ray can find out.
const UNSURE: u32 = u32::MAX - 1;

/// Rows of pixels that are drawn at a time, by one thread, in memory that is close to it.
const BAND: usize = 32;

/// How many pixels may be looked at for each ray that need not be cast.
const PIXELS_PER_RAY: usize = 16;

impl Projection {
    /// What `caster` finds in a world of triangles and planes, for the rays through the pixels' centres in
    /// these rows. None where the world has other things, or where casting the rays is less work.
    pub fn new(camera: &Camera, caster: &Caster, size: [usize; 2], rows: Range<usize>) -> Option<Self> {
        let (world, [width, height]) = (caster.world, size);
        let pixels = width * rows.len();
        let is_possible = world.finite_count() == world.triangles.len() && width.max(height) <= sprite::MOST;
        // Measured: a ray takes as long as 3/4 of a triangle where there is a grid, else as one in 64 of all.
        let count = world.triangles.len();
        let most =
            if caster.has_grid() { pixels / 4 * 3 } else { pixels.saturating_mul((count / 64).max(1)) };
        if !is_possible || count > most {
            return None;
        }
        let canvas = Canvas::new(camera.eye()?, world.bounds, width, rows.clone())?;
        let piles = piles(&canvas, world);
        let work = piles.iter().flatten().fold(0usize, |work, pile| work.saturating_add(pile.pixels));
        if work > PIXELS_PER_RAY * pixels {
            return None;
        }
        let planes: Vec<Layer> = world.planes.iter().map(|plane| Layer::of_plane(&canvas, plane)).collect();
        let stride = width + band::LANES;
        let mut seen = vec![NOTHING; stride * rows.len()];
        seen.par_chunks_mut(BAND * stride).enumerate().for_each(|(k, seen)| {
            let mut band = Band::new(&canvas, rows.start + k * BAND, stride, seen);
            for side in [FRONTS, BACKS] {
                let sprites = piles.iter().flat_map(|piles| &piles[k].sides[side]);
                sprites.for_each(|sprite| band.draw(sprite, world));
            }
            for (plane, number) in planes.iter().zip(world.first_plane()..) {
                band.fill(plane, number);
            }
        });
        Some(Self { stride, first_row: rows.start, seen })
    }

    /// What `ray`, the one through the centre of the pixel in column `i` of row `j`, hits first; none where
    /// only casting it can tell. The t of a triangle is left open: a NaN.
    pub fn hit(&self, world: &World, ray: &Ray, i: usize, j: usize) -> Option<Option<Hit>> {
        let primitive = self.seen[(j - self.first_row) * self.stride + i];
        match primitive {
            NOTHING => Some(None),
            UNSURE => None,
            _ => match world.primitive(primitive) {
                Primitive::Plane(k) => Some(Some(Hit { t: world.planes[k].intersect(ray)?, primitive })),
                _ => Some(Some(Hit { t: f64::NAN, primitive })),
            },
        }
    }
}

/// What stands in one band.
#[derive(Clone, Default)]
struct Pile {
    /// Fronts are drawn first: they hide most backs, which then need no drawing.
    sides: [Vec<Sprite>; 2],
    /// How many pixels they have.
    pixels: usize,
}

const FRONTS: usize = 0;
const BACKS: usize = 1;

/// Piles for each band, from each part of the triangles.
fn piles(canvas: &Canvas, world: &World) -> Vec<Vec<Pile>> {
    const PART: usize = 1 << 14;
    let places: Vec<Place> = world.vertices.par_iter().map(|&v| Place::of(v, canvas)).collect();
    let count = world.triangles.len();
    let parts = (0..count.div_ceil(PART)).into_par_iter();
    let piles = parts.map(|part| {
        let mut piles = vec![Pile::default(); canvas.rows.len().div_ceil(BAND)];
        for number in part * PART..count.min((part + 1) * PART) {
            if let Some((sprite, is_front)) = Sprite::new(canvas, world, &places, number as u32) {
                let (side, rows) = (if is_front { FRONTS } else { BACKS }, sprite.rows.range());
                let [first, last] = [rows.start, rows.end - 1].map(|j| (j - canvas.rows.start) / BAND);
                for pile in &mut piles[first..=last] {
                    pile.sides[side].push(sprite);
                }
                piles[first].pixels += sprite.pixels();
            }
        }
        piles
    });
    piles.collect()
}

/// Where it is drawn.
///
/// A pixel's ray runs along d + x h + y v, with x and y counted from the picture's middle in pixels.
struct Canvas {
    eye: Eye,
    /// A power of two that brings all finite things to within 1 of the eye.
    scale: f64,
    /// What takes a point one unit in front of the eye to its x and its y.
    axes: [DVec3; 2],
    /// The most that d, x h and y v are long together.
    reach: f64,
    width: usize,
    rows: Range<usize>,
}

impl Canvas {
    /// None where numbers are too large or too small to compute with, or the view so narrow or so skew that
    /// a place is off by more than a small part of a pixel.
    fn new(eye: Eye, bounds: Aabb, width: usize, rows: Range<usize>) -> Option<Self> {
        let distance = |corner: DVec3| (corner - eye.center).length();
        let farthest = bounds.corners().map(distance).into_iter().fold(0.0, f64::max);
        let scale = libm::ldexp(1.0, -libm::frexp(farthest).1);
        let axes = [eye.right, eye.up].map(|axis| axis / axis.length_squared());
        let [across, along] = [(eye.middle.x, eye.right), (eye.middle.y, eye.up)]
            .map(|(middle, axis)| (middle + 0.5) * axis.length());
        let reach = eye.direction.length() + across + along;
        let off = sprite::place_error_bound(&eye, axes, reach);
        let is_usual = (1e-60..1e60).contains(&scale) && reach < 1e12 && off < sprite::MOST_OFF;
        is_usual.then_some(Self { eye, scale, axes, reach, width, rows })
    }

    /// A point as the eye sees it.
    fn seen(&self, point: DVec3) -> DVec3 {
        (point - self.eye.center) * self.scale
    }

    /// `normal` times a pixel's direction.
    fn affine(&self, normal: DVec3) -> Affine {
        let Eye { direction, right, up, .. } = self.eye;
        Affine { constant: normal.dot(direction), per_x: normal.dot(right), per_y: normal.dot(up) }
    }
}

/// A function of a pixel's x and y.
#[derive(Clone, Copy)]
struct Affine {
    constant: f64,
    per_x: f64,
    per_y: f64,
}

impl Affine {
    fn at(self, x: f64, y: f64) -> f64 {
        self.constant + self.per_x * x + self.per_y * y
    }

    fn plus(self, other: Self) -> Self {
        Self {
            constant: self.constant + other.constant,
            per_x: self.per_x + other.per_x,
            per_y: self.per_y + other.per_y,
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Self { constant: factor * self.constant, per_x: factor * self.per_x, per_y: factor * self.per_y }
    }
}
