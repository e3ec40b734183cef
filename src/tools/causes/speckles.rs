//! Speckles (shadow acne): a ray hits the surface that it leaves, so a point shadows or mirrors itself.
//!
//! The affected points depend on every rounding, so their picture cannot be reproduced. But a pixel can have only few
//! such colours, one for each choice of the rays that hit their own surface. Pixels with such a colour are scattered
//! among correct ones, whereas other mistakes affect whole regions.

use super::Original;
use super::changes::has_secondary_rays;
use super::finding::Finding;
use super::search::BY_A_LEVEL_AND_MISTAKE;
use super::student::{SelfHitting, Student};
use crate::math::ray::Ray;
use crate::picture::{CHANNELS, Picture, RED_FIRST, truncate_to_bytes};
use crate::render::{Layer, Request};
use crate::tools::compare::{EdgeMap, Rgb, colors, largest_channel_difference};
use glam::DVec2;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU32, Ordering};

/// The smallest number of speckles. Fewer pixels may match by chance.
const MIN_PIXELS: usize = 3;
/// The smallest share of speckles among the differing pixels away from edges, if these are mixed with right pixels and
/// if they are hardly mixed.
const MIN_SHARE: [f64; 2] = [0.6, 0.95];
/// The smallest share of pairs with unlike differences, among pairs of neighbours with at least one differing pixel. If
/// pixels differ at random with probability p, this share is 2 (1 - p) / (2 - p). In a region it is small.
const MIXED: f64 = 0.3;
/// The smallest such share of pixels that are hardly mixed.
const HARDLY_MIXED: f64 = 0.1;
/// The smallest share of the differing pixels that are away from edges.
const MIN_AWAY: f64 = 0.1;
/// The largest number of pixels examined, evenly spread over the differing ones.
const MAX_PIXELS: usize = 1 << 12;
/// The largest number of choices of rays tried for a pixel.
const MAX_CHOICES: usize = 256;
/// The largest number of rays of a pixel that have a choice.
const MAX_RAYS: u32 = 32;
/// With more bounces, a pixel has too many rays to look for speckles.
const MAX_BOUNCES: u32 = 6;

/// Returns the speckles in `a` if they explain its difference from `b`. Both are whole pictures.
pub fn speckles(original: &Original, a: &Picture, b: &Picture) -> Option<Finding> {
    let (renderer, request) = (original.renderer(), &original.request);
    // A pixel with several samples mixes too many colours.
    let can_show = original.layer() == Layer::Color
        && (request.effects.bounces <= MAX_BOUNCES || !has_secondary_rays(&renderer.scene))
        && request.sampler.is_center()
        && request.filter.support() == 0
        && !request.is_reduced;
    if !can_show || original.is_cancelled() {
        return None;
    }
    let (differing, mixed) = differing(request, colors(a), colors(b), &EdgeMap::new(b));
    let count = |differ: fn(Rgb, Rgb) -> bool| {
        colors(a).iter().zip(colors(b)).filter(|&(&a, &b)| differ(a, b)).count() as f64
    };
    let (visible, by_a_level) = (count(|a, b| !nearly(a, b)), count(|a, b| a != b && nearly(a, b)));
    // Acne does not change many pixels by a level.
    let differs_by_a_level = by_a_level > BY_A_LEVEL_AND_MISTAKE * colors(a).len() as f64;
    if differs_by_a_level || mixed < HARDLY_MIXED || (differing.len() as f64) < MIN_AWAY * visible {
        return None;
    }
    let step = differing.len().div_ceil(MAX_PIXELS).max(1);
    let examined: Vec<usize> = differing.iter().copied().step_by(step).collect();
    let camera = renderer.camera(request);
    let student = &Student::new(renderer, original.prepared.caster(), request.effects);
    let count = |rays: SelfHitting| {
        let is_made = |&&at: &&usize| {
            let [width, height] = request.size;
            let pixel = DVec2::new((at % width) as f64, (height - 1 - at / width) as f64);
            let ray = camera.ray(pixel, DVec2::ZERO);
            !original.is_cancelled() && is_made(student, &ray, colors(a)[at], rays)
        };
        examined.par_iter().filter(is_made).count()
    };
    let found = count(SelfHitting::All);
    let min_share = MIN_SHARE[usize::from(mixed < MIXED)];
    if found < MIN_PIXELS || (found as f64) < min_share * examined.len() as f64 {
        return None;
    }
    // Name one kind of rays if it makes nearly all speckles.
    let mut kinds = [SelfHitting::Shadow, SelfHitting::Secondary].into_iter();
    let rays = kinds.find(|&rays| 10 * count(rays) >= 9 * found).unwrap_or(SelfHitting::All);
    Some(Finding::Speckles { pixels: found * differing.len() / examined.len(), rays })
}

/// Returns true if a camera ray has this colour when some of its descendant rays hit the surface that they leave.
fn is_made(student: &Student, ray: &Ray, color: Rgb, rays: SelfHitting) -> bool {
    // One bit for each ray with a choice, in the order in which they start.
    let mut chosen = 0_u32;
    for _ in 0..MAX_CHOICES {
        let started = AtomicU32::new(0);
        let hits_itself = |why, _: &_, _| {
            let number = if rays.has(why) { started.fetch_add(1, Ordering::Relaxed) } else { MAX_RAYS };
            number < MAX_RAYS && chosen >> number & 1 != 0
        };
        let student = Student { hits_itself: Some(&hits_itself), ..*student };
        let mut bytes = [0; CHANNELS];
        truncate_to_bytes::<RED_FIRST>(&[student.color(ray)], &mut bytes);
        if chosen != 0 && nearly(bytes, color) {
            return true;
        }
        // The next choice sets the last ray not chosen, and clears those after it.
        let started = started.into_inner().min(MAX_RAYS);
        let Some(last) = (0..started).rev().find(|ray| chosen >> ray & 1 == 0) else { return false };
        chosen = chosen & ((1 << last) - 1) | 1 << last;
    }
    false
}

/// Returns the indices of the pixels away from edges that differ by more than one level, and the share of unlike pairs
/// among them and their neighbours.
fn differing(request: &Request, a: &[Rgb], b: &[Rgb], edges: &EdgeMap) -> (Vec<usize>, f64) {
    let [width, height] = request.size;
    let differs = |at: usize| !nearly(a[at], b[at]);
    let difference = |at: usize| [0, 1, 2].map(|i| i32::from(a[at][i]) - i32::from(b[at][i]));
    let away: Vec<bool> = (0..a.len()).map(|at| !edges.is_near_edge(at % width, at / width)).collect();
    let (mut pairs, mut mixed) = (0, 0);
    for at in (0..a.len()).filter(|&at| away[at]) {
        let right = (at % width + 1 < width).then_some(at + 1);
        let below = (at / width + 1 < height).then_some(at + width);
        for neighbour in [right, below].into_iter().flatten().filter(|&neighbour| away[neighbour]) {
            pairs += u32::from(differs(at) || differs(neighbour));
            mixed += u32::from(are_unlike(difference(at), difference(neighbour)));
        }
    }
    let differing = (0..a.len()).filter(|&at| away[at] && differs(at)).collect();
    (differing, f64::from(mixed) / f64::from(pairs.max(1)))
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
