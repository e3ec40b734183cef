//! Speckles (shadow acne): a ray hits the surface that it leaves, so a point shadows or mirrors itself.
//!
//! Pixels with a colour that such rays make are scattered among correct ones, whereas other mistakes affect whole regions.

use super::Original;
use super::changes::has_secondary_rays;
use super::finding::Finding;
use super::paint::Painter;
use super::rounding::Rest;
use super::self_hits::is_made;
use super::student::{SelfHitting, Student};
use crate::picture::Color;
use crate::render::{Layer, Request};
use crate::tools::compare::{EdgeMap, Rgb, colors, largest_channel_difference};
use crate::world::SurfacePoint;
use glam::DVec2;
use rayon::prelude::*;

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
/// The largest share of all pixels that differ by one level.
const BY_A_LEVEL: f64 = 0.2;
/// The largest number of pixels examined, evenly spread over the differing ones.
const MAX_PIXELS: usize = 1 << 12;
/// With more bounces, a pixel has too many rays to look for speckles.
const MAX_BOUNCES: u32 = 6;

/// Returns the speckles in a picture if they explain the pixels that rounding does not.
pub fn speckles(original: &Original, picture: &[Rgb], before: &Rest) -> Option<Finding> {
    let (renderer, request) = (original.renderer(), &original.request);
    // A pixel with several samples mixes too many colours.
    let can_show = original.layer() == Layer::Color
        && (request.effects.bounces <= MAX_BOUNCES || !has_secondary_rays(&renderer.scene))
        && request.sampler.is_center()
        && request.filter.support() == 0
        && !request.is_reduced;
    // Acne does not change many pixels by a level.
    let by_a_level = before.differing - before.visible.len();
    let differs_by_a_level = by_a_level as f64 > BY_A_LEVEL * picture.len() as f64;
    if !can_show || differs_by_a_level || original.is_cancelled() {
        return None;
    }
    let own = original.own();
    let (differing, mixed) = differing(request, picture, colors(&own), &EdgeMap::new(&own));
    if mixed < HARDLY_MIXED || (differing.len() as f64) < MIN_AWAY * before.visible.len() as f64 {
        return None;
    }
    let step = differing.len().div_ceil(MAX_PIXELS).max(1);
    let examined: Vec<usize> = differing.iter().copied().step_by(step).collect();
    let patience = &original.patience;
    let caster = &original.prepared.caster().patient(patience);
    let student = &Student { patience, ..Student::new(renderer, caster, request.effects) };
    let painter = Painter::new(student, request);
    let count = |rays: SelfHitting| {
        let may_hit = |why, _: &SurfacePoint, _| rays.has(why);
        let is_made = |&&at: &&usize| {
            let source = [at % request.size[0], at / request.size[0]];
            let right = painter.pixels(&[source], DVec2::ZERO)[0];
            let accepts = |color| {
                let bytes = bytes_of(color);
                bytes != bytes_of(right) && nearly(bytes, picture[at])
            };
            !original.is_cancelled() && is_made(&painter, source, DVec2::ZERO, &may_hit, &accepts)
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

fn bytes_of(color: Color) -> Rgb {
    color.to_array().map(|channel| (255.0 * channel) as u8)
}
