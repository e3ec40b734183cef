//! Speckles (shadow acne): a ray hits the surface that it leaves, so a point shadows or mirrors itself.
//!
//! The affected points depend on every rounding, so their picture cannot be reproduced. But a pixel can have only few
//! such colours, one for each choice of the rays that hit their own surface. Pixels with such a colour are scattered
//! among correct ones, whereas other mistakes affect whole regions.

use super::Original;
use super::changes::has_secondary_rays;
use super::object_space::ObjectSpaces;
use super::student::{Departure, SelfHitting, Student, from_other_side};
use crate::math::ray::Ray;
use crate::picture::Picture;
use crate::picture::{CHANNELS, RED_FIRST, truncate_to_bytes};
use crate::render::{Layer, Request};
use crate::tools::compare::{EdgeMap, Rgb, colors, largest_channel_difference};
use crate::trace::Shadows;
use crate::world::SurfacePoint;
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// Fewer pixels may match by chance.
const MIN_PIXELS: f64 = 3.0;
/// The smallest share of speckles among the differing pixels away from edges.
const MIN_SHARE: f64 = 0.6;
/// The smallest share if most pixels are affected, because they are then less mixed with others.
const MIN_SHARE_OF_DENSE: f64 = 0.95;
/// The smallest share of the differing pixels that must be away from edges.
const MIN_SHARE_OF_ALL: f64 = 0.1;
/// The smallest share of pairs with unlike differences, among pairs of neighbours with at least one differing pixel. If
/// pixels differ at random with probability p, this share is 2 (1 - p) / (2 - p). In a region it is small.
const MIXED: f64 = 0.3;
/// The smallest share if nearly all of these pixels are speckles.
const MIN_MIXED: f64 = 0.1;
/// The largest number of pixels examined, evenly spread over the differing ones.
const MAX_PIXELS: usize = 1 << 12;
/// The largest number of choices of rays tried for a pixel.
const MAX_CHOICES: usize = 256;
/// The largest number of rays of a pixel that have a choice.
const MAX_RAYS: u32 = 32;
/// With more bounces, a pixel has too many rays to look for speckles.
const MAX_BOUNCES: u32 = 6;
/// If one kind of rays makes this share of the speckles, only this kind is named.
const MOST: f64 = 0.9;

/// The speckles of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Speckles {
    /// The number of pixels affected.
    pub pixels: usize,
    /// The rays that hit the surface that they leave.
    pub rays: SelfHitting,
}

/// Returns the speckles in `a` if they explain its difference from `b`. Both are whole pictures.
pub fn speckles(original: &Original, a: &Picture, b: &Picture) -> Option<Speckles> {
    if !can_show(original) || original.is_cancelled() {
        return None;
    }
    let differing = Differing::new(original, a, b);
    let Differing { all, away_from_edges, .. } = &differing;
    let share_of_all = away_from_edges.len() as f64 / (*all).max(1) as f64;
    if share_of_all < MIN_SHARE_OF_ALL || differing.mixed < MIN_MIXED {
        return None;
    }
    let step = away_from_edges.len().div_ceil(MAX_PIXELS).max(1);
    let looked_at: Vec<usize> = away_from_edges.iter().copied().step_by(step).collect();
    let renderer = original.renderer();
    let camera = renderer.camera(&original.request);
    let spaces = &ObjectSpaces::new(&renderer.scene, renderer.meshes(), renderer.world());
    let student = &Student::new(renderer, original.prepared.caster(), original.request.effects, spaces);
    let count = |rays: SelfHitting| {
        let is_made = |&&at: &&usize| {
            let [width, height] = original.request.size;
            let pixel = DVec2::new((at % width) as f64, (height - 1 - at / width) as f64);
            let ray = camera.ray(pixel, DVec2::ZERO);
            !original.is_cancelled() && is_made(student, &ray, colors(a)[at], rays)
        };
        looked_at.par_iter().filter(is_made).count() as f64
    };
    let found = count(SelfHitting::All);
    let min_share = if differing.mixed < MIXED { MIN_SHARE_OF_DENSE } else { MIN_SHARE };
    if found < MIN_PIXELS || found < min_share * looked_at.len() as f64 {
        return None;
    }
    let one_kind = [SelfHitting::Shadow, SelfHitting::Secondary];
    let rays = one_kind.into_iter().find(|&rays| count(rays) >= MOST * found).unwrap_or(SelfHitting::All);
    let share = found / looked_at.len() as f64;
    Some(Speckles { pixels: (share * away_from_edges.len() as f64) as usize, rays })
}

/// Returns true if speckles could be found. A pixel with several samples mixes too many colours.
pub fn can_show(original: &Original) -> bool {
    let Original { request, .. } = original;
    let scene = &original.renderer().scene;
    let effects = request.effects;
    let has_shadows = effects.shadows != Shadows::None && !scene.lights.is_empty();
    let bounces = if has_secondary_rays(scene) { effects.bounces } else { 0 };
    original.layer() == Layer::Color
        && (has_shadows || bounces > 0)
        && bounces <= MAX_BOUNCES
        && request.sampler.is_center()
        && request.filter.support() == 0
        && !request.is_reduced
}

/// Returns true if a camera ray has this colour when some of its descendant rays hit the surface that they leave.
fn is_made(student: &Student, ray: &Ray, color: Rgb, rays: SelfHitting) -> bool {
    // One bit for each ray with a choice, in the order in which they start.
    let mut chosen = 0;
    for _ in 0..MAX_CHOICES {
        let passed = AtomicU32::new(0);
        let starts = |why, surface: &SurfacePoint, direction| {
            let number = Departure::is_one_of(why, rays).then(|| passed.fetch_add(1, Ordering::Relaxed))?;
            let is_chosen = number < MAX_RAYS && chosen >> number & 1 != 0;
            is_chosen.then(|| from_other_side(surface, direction))
        };
        let student = Student { starts: Some(&starts), ..*student };
        let mut bytes = [0; CHANNELS];
        truncate_to_bytes::<RED_FIRST>(&[student.color(ray)], &mut bytes);
        if chosen != 0 && nearly(bytes, color) {
            return true;
        }
        // The next choice sets the last ray not chosen, and clears those after it.
        let passed = passed.into_inner().min(MAX_RAYS);
        let Some(last) = (0..passed).rev().find(|ray| chosen >> ray & 1 == 0) else { return false };
        chosen = chosen & ((1 << last) - 1) | 1 << last;
    }
    false
}

/// The pixels that differ by more than one level.
struct Differing {
    all: usize,
    /// Indices from the top left.
    away_from_edges: Vec<usize>,
    /// The share of unlike pairs, among pairs of neighbours away from edges with at least one differing pixel.
    mixed: f64,
}

impl Differing {
    fn new(original: &Original, a: &Picture, b: &Picture) -> Self {
        let Request { size: [width, height], .. } = original.request;
        let (a, b, edges) = (colors(a), colors(b), EdgeMap::new(b));
        let differs = |at: usize| !nearly(a[at], b[at]);
        let difference = |at: usize| [0, 1, 2].map(|i| i32::from(a[at][i]) - i32::from(b[at][i]));
        let is_away = |at: usize| !edges.is_near_edge(at % width, at / width);
        let mut found = Self { all: 0, away_from_edges: vec![], mixed: 0.0 };
        let (mut pairs, mut mixed) = (0, 0);
        for at in 0..width * height {
            found.all += usize::from(differs(at));
            if !is_away(at) {
                continue;
            }
            if differs(at) {
                found.away_from_edges.push(at);
            }
            let right = (at % width + 1 < width).then_some(at + 1);
            let below = (at / width + 1 < height).then_some(at + width);
            for neighbour in [right, below].into_iter().flatten().filter(|&neighbour| is_away(neighbour)) {
                pairs += usize::from(differs(at) || differs(neighbour));
                mixed += usize::from(are_unlike(difference(at), difference(neighbour)));
            }
        }
        found.mixed = f64::from(mixed as u32) / pairs.max(1) as f64;
        found
    }
}

/// Returns true if two differences differ by more than half of the larger one and by more than rounding.
fn are_unlike(one: [i32; 3], other: [i32; 3]) -> bool {
    let largest = |all: [i32; 3]| all.into_iter().map(i32::abs).max().unwrap_or(0);
    let apart = largest([0, 1, 2].map(|i| one[i] - other[i]));
    apart > 1 && 2 * apart > largest(one).max(largest(other))
}

fn nearly(a: Rgb, b: Rgb) -> bool {
    largest_channel_difference(a, b) <= 1
}
