//! Speckles (shadow acne): a ray hits the surface that it leaves, so a point shadows or mirrors itself.
//!
//! Neighbouring pixels differ in different ways, because which rays do depends on every rounding. Other mistakes affect
//! whole regions in one way.

use super::Original;
use super::changes::has_secondary_rays;
use super::finding::Finding;
use super::paint::Painter;
use super::rendering::RenderedPixel;
use super::rules::SelfHitting;
use super::self_hits::possible_colors;
use super::student::Student;
use crate::render::Layer;
use crate::tools::compare::{Rgb, colors};
use crate::world::SurfacePoint;
use glam::DVec2;
use rayon::prelude::*;

/// The smallest number of speckles. Fewer pixels may match by chance.
const MIN_PIXELS: usize = 3;
/// The smallest share of speckles among the wrong pixels: if at least [`SCATTERED`] of the neighbours are unlike, and if
/// fewer are.
const MIN_SHARES: [f64; 2] = [0.6, 0.95];
/// The smallest share of unlike neighbours among scattered pixels. If pixels differ at random with probability p, this
/// share is 2 (1 - p) / (2 - p). In a region it is small.
const SCATTERED: f64 = 0.3;
/// The smallest share of unlike neighbours at which speckles are looked for.
const LEAST_SCATTERED: f64 = 0.1;
/// The largest number of pixels examined.
const MAX_PIXELS: usize = 1 << 8;
/// With more bounces, a pixel has too many rays to look for speckles.
const MAX_BOUNCES: u32 = 6;

/// Returns the speckles in a picture if they make most of these wrong pixels, in ascending order.
pub fn speckles(original: &Original, picture: &[Rgb], wrong: &[usize]) -> Option<Finding> {
    let (renderer, request) = (original.renderer(), &original.request);
    let own = original.own();
    let scattered = unlike_neighbours(picture, colors(&own), wrong, request.size[0]).at_wrong;
    // A pixel with several samples mixes too many colours.
    let can_show = original.layer == Layer::Color
        && (request.effects.bounces <= MAX_BOUNCES || !has_secondary_rays(&renderer.scene))
        && request.sampler.is_center()
        && request.filter.support() == 0
        && !request.is_reduced;
    if !can_show || scattered < LEAST_SCATTERED {
        return None;
    }
    let examined: Vec<usize> =
        wrong.iter().copied().step_by(wrong.len().div_ceil(MAX_PIXELS).max(1)).collect();
    let patience = &original.patience;
    let caster = &original.prepared.caster(patience).ok()?;
    let student = &Student { patience, ..Student::new(renderer, caster, request.effects) };
    let painter = Painter::new(student, request, &[]);
    let count = |rays: SelfHitting| {
        let may_hit = |kind, _: &SurfacePoint, _| rays.has(kind);
        let is_speckle = |&&at: &&usize| {
            let source = [at % request.size[0], at / request.size[0]];
            let mut colors = possible_colors(&painter, source, DVec2::ZERO, &may_hit);
            !original.is_cancelled() && colors.any(|color| RenderedPixel::new(color).levels(picture[at]) <= 1)
        };
        examined.par_iter().filter(is_speckle).count()
    };
    let found = count(SelfHitting::All);
    let min_share = MIN_SHARES[usize::from(scattered < SCATTERED)];
    if found < MIN_PIXELS || (found as f64) < min_share * examined.len() as f64 {
        return None;
    }
    // Name one kind of rays if it makes nearly all speckles.
    let mut kinds = [SelfHitting::Shadow, SelfHitting::Secondary].into_iter();
    let rays = kinds.find(|&rays| 10 * count(rays) >= 9 * found).unwrap_or(SelfHitting::All);
    Some(Finding::Speckles { pixels: found * wrong.len() / examined.len(), rays })
}

/// Shares of pairs of neighbours with unlike differences.
pub struct UnlikeNeighbours {
    /// Among pairs with at least one wrong pixel.
    pub at_wrong: f64,
    /// Among pairs of wrong pixels.
    pub among_wrong: f64,
}

/// Compares the differences of neighbours in a picture of this width. The wrong pixels are in ascending order.
pub fn unlike_neighbours(picture: &[Rgb], own: &[Rgb], wrong: &[usize], width: usize) -> UnlikeNeighbours {
    let difference = |at: usize| [0, 1, 2].map(|i| i32::from(picture[at][i]) - i32::from(own[at][i]));
    // By the number of wrong pixels in a pair.
    let (mut pairs, mut unlike) = ([0_u32; 3], [0_u32; 3]);
    for at in 0..picture.len() {
        let right = ((at + 1) % width != 0).then_some(at + 1);
        let below = (at + width < picture.len()).then_some(at + width);
        for neighbour in [right, below].into_iter().flatten() {
            let count = [at, neighbour].iter().filter(|pixel| wrong.binary_search(pixel).is_ok()).count();
            pairs[count] += 1;
            unlike[count] += u32::from(count > 0 && are_unlike(difference(at), difference(neighbour)));
        }
    }
    let share = |unlike: u32, pairs: u32| f64::from(unlike) / f64::from(pairs.max(1));
    let [at_wrong, among_wrong] =
        [share(unlike[1] + unlike[2], pairs[1] + pairs[2]), share(unlike[2], pairs[2])];
    UnlikeNeighbours { at_wrong, among_wrong }
}

/// Returns true if two differences differ by more than half of the larger one and by more than rounding.
fn are_unlike(one: [i32; 3], other: [i32; 3]) -> bool {
    let largest = |all: [i32; 3]| all.into_iter().map(i32::abs).max().unwrap_or(0);
    let apart = largest([0, 1, 2].map(|i| one[i] - other[i]));
    apart > 1 && 2 * apart > largest(one).max(largest(other))
}
