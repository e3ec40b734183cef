//! Judges mistakes by the pixels that they make right: first by a sample, and then by the whole picture.
//!
//! The sample has several hundred wrong pixels, and right ones, which a mistake must leave right. A mistake explains
//! most of the difference if it makes most of the wrong pixels right, and shows wherever it can. It explains all if
//! rounding explains what it leaves.

use super::finding::Finding;
use super::mistakes::Mistake;
use super::rendering::{RenderedPixel, Rendering};
use super::rounding::{self, Residual};
use super::variant::{PixelChanges, Thresholds, Variant, colors_at};
use crate::picture::{Color, FloatPicture};
use crate::tools::compare::Rgb;
use glam::DVec2;
use std::rc::Rc;

/// The size of a sample of pixels. Few are enough where each needs many rays.
struct SampleSize {
    most: usize,
    least: usize,
    /// The number of camera rays that it should not exceed.
    rays: usize,
}

impl SampleSize {
    /// Returns the number of pixels, each of which depends on this many camera rays.
    fn pixels(&self, rays_per_pixel: usize) -> usize {
        (self.rays / rays_per_pixel).clamp(self.least, self.most)
    }
}

/// The wrong pixels by which a mistake is judged first.
const FIRST: SampleSize = SampleSize { most: 48, least: 12, rays: 1 << 10 };
/// The wrong pixels in the sample.
const WRONG: SampleSize = SampleSize { most: 512, least: 48, rays: 1 << 14 };
/// The right pixels in the sample.
const RIGHT: SampleSize = SampleSize { most: 256, ..WRONG };
/// The smallest share of the first wrong pixels that a mistake makes right.
const MIN_FIRST_SHARE: f64 = 0.15;

/// The shares of pixels that a mistake makes right.
#[derive(Clone, Copy)]
struct Shares {
    of_wrong: f64,
    of_changed: f64,
}

/// The smallest shares of most mistakes. A change that is only similar to the mistake leaves an error in the same
/// pixels.
const MIN_SHARES: Shares = Shares { of_wrong: 0.6, of_changed: 0.75 };
/// The smallest shares of a mistake that makes nearly all right that it changes. Other mistakes explain the other wrong
/// pixels.
const MIN_SHARES_IF_PRECISE: Shares = Shares { of_wrong: 1.0 / 3.0, of_changed: 0.98 };
/// The smallest shares if few pixels are visibly wrong. Many mistakes make half of the pixels right that are wrong
/// by a level.
const MIN_SHARES_BY_A_LEVEL: Shares = Shares { of_wrong: 0.9, of_changed: 0.75 };
/// The largest share of the pixels changed by a mistake that may be right without it. A mistake shows where it can.
const MAX_CONTRADICTED: f64 = 0.03;
/// The largest number of pixels that a mistake makes nearly right, for each one that it makes right. A mistake that is
/// only similar is often off by a few levels.
const MAX_NEARLY: f64 = 0.1;
/// A pixel is nearly right if it differs by at most this many levels.
const NEARLY: u8 = 6;
/// The largest number of mistakes that are judged by the whole picture.
const MAX_SHORTLIST: usize = 10;
/// The largest number of camera rays of all their pictures. Two are always judged.
const MAX_SHORTLIST_RAYS: usize = 1 << 22;
/// Every mistake of another kind must leave at least this many times as many wrong pixels.
const MIN_LEAD: f64 = 2.0;
/// The number of pixels that a correct tracer in single precision may leave unexplained.
pub const MAX_UNEXPLAINED: usize = 2;
/// With fewer unexplained pixels, only a mistake that gives the very picture is named.
pub const MIN_VISIBLE: usize = 4;

/// Mistakes that may explain the picture, judged by the sample.
pub struct Suspect {
    pub mistakes: Vec<Mistake>,
    /// The number of pixels in the sample that they leave wrong.
    left: usize,
}

/// Mistakes that explain most of the picture, judged by all pixels.
pub struct Candidate {
    pub mistakes: Vec<Mistake>,
    pub rendering: Rc<Rendering>,
    /// The difference that they leave.
    pub residual: Residual,
    /// The share of the wrong pixels that they make right.
    pub share: f64,
}

/// The search for the cause of one picture.
pub struct Search<'p> {
    picture: &'p [Rgb],
    /// The picture on which mistakes are made: this program's own, or one with a mistake that is known.
    base: Rc<Rendering>,
    size: [usize; 2],
    /// True for each pixel that the base and rounding do not explain.
    is_wrong: Vec<bool>,
    /// A pixel is right if it differs by at most this many levels besides rounding: one if many pixels differ visibly,
    /// or else none.
    level: u8,
    /// The pixels by which mistakes are judged first: wrong ones, and then right ones.
    sample: Vec<usize>,
    /// The number of wrong pixels in the sample.
    wrong: usize,
    /// The number of camera rays of a picture.
    rays: usize,
}

/// Numbers of pixels.
#[derive(Clone, Copy, Debug, Default)]
struct PixelCounts {
    /// Wrong with the base, and of these right with the mistake.
    wrong: usize,
    mended: usize,
    /// Changed by the mistake, and of these right with it.
    changed: usize,
    right: usize,
    /// Right with the base, and wrong with the mistake.
    contradicted: usize,
    /// Changed by the mistake, and then equal or nearly right.
    equal: usize,
    nearly: usize,
}

impl PixelCounts {
    fn share(&self) -> f64 {
        self.mended as f64 / self.wrong as f64
    }

    /// Returns true if the mistake makes at least these shares right.
    fn reaches(&self, least: Shares) -> bool {
        let precision = self.right as f64 / self.changed as f64;
        self.share() >= least.of_wrong && precision >= least.of_changed
    }

    /// Returns the number of pixels that are wrong with the mistake.
    fn left(&self) -> usize {
        self.wrong - self.mended + self.contradicted
    }
}

impl<'p> Search<'p> {
    /// Starts a search. The base leaves this residual.
    pub fn new(
        picture: &'p [Rgb],
        base: Rc<Rendering>,
        size: [usize; 2],
        residual: &Residual,
        rays_per_pixel: usize,
    ) -> Self {
        let level = u8::from(residual.visible.len() >= MIN_VISIBLE);
        let mut is_wrong = vec![false; picture.len()];
        // Where rounding explains all, only a mistake that explains it better is of interest.
        let visible = if residual.unexplained.len() < MIN_VISIBLE { &residual.visible[..] } else { &[] };
        residual.unexplained.iter().chain(visible).for_each(|&at| is_wrong[at] = true);
        let is_wrong_by = |at: &usize| is_wrong[*at] && base.pixels[*at].levels(picture[*at]) > level;
        let wrong: Vec<usize> = (0..picture.len()).filter(is_wrong_by).collect();
        let right: Vec<usize> =
            (0..picture.len()).filter(|&at| base.pixels[at].levels(picture[at]) == 0).collect();
        let mut sample = scattered(&wrong, WRONG.pixels(rays_per_pixel));
        let wrong = sample.len();
        sample.extend(scattered(&right, RIGHT.pixels(rays_per_pixel)));
        Self { picture, base, size, is_wrong, level, sample, wrong, rays: rays_per_pixel * picture.len() }
    }

    /// Returns the wrong pixels in the sample.
    pub fn wrong_sample(&self) -> &[usize] {
        &self.sample[..self.wrong]
    }

    /// Counts pixels, by their indices, to which the mistake gives these colours.
    fn counts(&self, rendered: impl Iterator<Item = (usize, RenderedPixel)>) -> PixelCounts {
        let mut counts = PixelCounts::default();
        for (at, rendered) in rendered {
            let (pixel, base) = (self.picture[at], &self.base.pixels[at]);
            let before = base.levels(pixel);
            let (is_right_before, after) = (before <= self.level, rendered.levels(pixel));
            let is_wrong = !is_right_before && self.is_wrong[at];
            let is_right = after <= self.level;
            counts.wrong += usize::from(is_wrong);
            counts.mended += usize::from(is_wrong && is_right);
            if base.levels(rendered.bytes) > self.level {
                counts.changed += 1;
                counts.right += usize::from(is_right);
                counts.contradicted += usize::from(!is_right && is_right_before);
                counts.equal += usize::from(after == 0);
                counts.nearly += usize::from(is_wrong && !is_right && after <= NEARLY);
            }
        }
        counts
    }

    /// Counts all pixels of a picture.
    fn counts_of(&self, rendering: &Rendering) -> PixelCounts {
        self.counts(rendering.pixels.iter().copied().enumerate())
    }

    /// Judges the variant's mistakes by the sample, alone and with each of these changes of the finished picture.
    pub fn suspects(&self, variant: &Variant, mistakes: &[Mistake], changes: &[Mistake]) -> Vec<Suspect> {
        let found = variant.with_painter(Thresholds::OWN, |painter| {
            let first = FIRST.pixels(variant.rays_per_pixel()).min(self.wrong);
            let colors = colors_at(painter, variant, &self.sample[..first], DVec2::ZERO);
            let is_possible =
                |all: &Vec<Mistake>| self.sample_counts(all, &colors).share() >= MIN_FIRST_SHARE;
            let with = |change: &Mistake| [mistakes, std::slice::from_ref(change)].concat();
            let others = changes.iter().filter(|change| !mistakes.contains(change)).map(with);
            let possible: Vec<Vec<Mistake>> =
                std::iter::once(mistakes.to_vec()).chain(others).filter(is_possible).collect();
            if possible.is_empty() {
                return vec![];
            }
            let colors = colors_at(painter, variant, &self.sample, DVec2::ZERO);
            possible.into_iter().filter_map(|all| self.suspect(all, &colors)).collect()
        });
        found.unwrap_or_default()
    }

    /// Judges changes of a finished picture by the sample.
    pub fn suspect_by_pixel_changes(&self, mistakes: Vec<Mistake>, own: &FloatPicture) -> Option<Suspect> {
        let changes = PixelChanges::new(&mistakes);
        let source = |&at: &usize| {
            let [x, y] = changes.source(at, self.size);
            own.colors[y * self.size[0] + x]
        };
        let colors: Vec<Color> = self.sample.iter().map(source).collect();
        self.suspect(mistakes, &colors)
    }

    /// Judges mistakes by the whole sample, which has these colours before changes of the finished picture.
    fn suspect(&self, mistakes: Vec<Mistake>, colors: &[Color]) -> Option<Suspect> {
        let counts = self.sample_counts(&mistakes, colors);
        let is_suspect = counts.share() >= MIN_SHARES_IF_PRECISE.of_wrong / 2.0
            && counts.contradicted as f64 <= 0.1 * counts.changed as f64 + 2.0;
        is_suspect.then(|| Suspect { left: counts.left(), mistakes })
    }

    /// Counts the first pixels of the sample, which have these colours before changes of the finished picture.
    fn sample_counts(&self, mistakes: &[Mistake], colors: &[Color]) -> PixelCounts {
        let changes = PixelChanges::new(mistakes);
        let pairs = self.sample.iter().zip(colors);
        self.counts(pairs.map(|(&at, &color)| (at, RenderedPixel::new(changes.color(color, at, self.size)))))
    }

    /// Sorts suspects, the best ones first, and drops those that a better one leads.
    pub fn shortlist(&self, mut suspects: Vec<Suspect>) -> Vec<Suspect> {
        suspects.sort_by_key(|suspect| (suspect.left, suspect.mistakes.len()));
        let best = suspects.first().map_or(0, |suspect| suspect.left);
        let bound = MIN_LEAD * best as f64 + 8.0;
        let most = (MAX_SHORTLIST_RAYS / self.rays).clamp(2, MAX_SHORTLIST);
        suspects.into_iter().take_while(|suspect| suspect.left as f64 <= bound).take(most).collect()
    }

    /// Judges mistakes by the whole picture. Returns `None` if they are refuted.
    pub fn judge_whole(
        &self,
        mistakes: Vec<Mistake>,
        rendering: Rendering,
        variant: Option<&Variant>,
    ) -> Option<Candidate> {
        let counts = self.counts_of(&rendering);
        if !self.explains_most(&counts) {
            return None;
        }
        let residual = rounding::residual(self.picture, &rendering, variant);
        Some(Candidate { mistakes, rendering: Rc::new(rendering), residual, share: counts.share() })
    }

    /// Returns true if mistakes with these counts make most wrong pixels right, and contradict few right ones.
    fn explains_most(&self, counts: &PixelCounts) -> bool {
        let explains_most = match self.level {
            0 => counts.reaches(MIN_SHARES_BY_A_LEVEL),
            _ => counts.reaches(MIN_SHARES) || counts.reaches(MIN_SHARES_IF_PRECISE),
        };
        let most_contradicted = MAX_CONTRADICTED * counts.changed as f64 + 0.001 * self.picture.len() as f64;
        explains_most && counts.contradicted as f64 <= most_contradicted
    }

    /// Returns true if the pixels that a candidate changes are equal, and not only nearly right.
    fn is_exact(&self, candidate: &Candidate) -> bool {
        let counts = self.counts_of(&candidate.rendering);
        counts.nearly as f64 <= MAX_NEARLY * counts.equal as f64
    }
}

impl Candidate {
    /// Returns the candidate without a mistake.
    pub fn unchanged(rendering: Rc<Rendering>, residual: Residual) -> Self {
        Self { mistakes: vec![], rendering, residual, share: 0.0 }
    }

    /// Returns true if rounding explains what the mistakes leave of a difference of this size.
    pub fn explains_all(&self, before: &Residual) -> bool {
        match (before.unexplained.len(), before.visible.len()) {
            (0..MIN_VISIBLE, 0..MIN_VISIBLE) => self.residual.differing == 0,
            (0..MIN_VISIBLE, _) => self.residual.visible.is_empty() && self.residual.unexplained.is_empty(),
            _ => self.residual.unexplained.len() <= MAX_UNEXPLAINED,
        }
    }

    /// Returns the number of pixels that are left, the unexplained ones first.
    pub fn left(&self) -> (usize, usize) {
        (self.residual.unexplained.len(), self.residual.differing)
    }
}

/// Returns the mistake of which a part of the difference consists, if there is one: a single mistake that is not merely
/// similar to another, and that leads all others.
pub fn partial_cause(search: &Search, candidates: &[Candidate]) -> Option<Finding> {
    let singles = || candidates.iter().filter(|candidate| candidate.mistakes.len() == 1);
    let best = singles().min_by_key(|candidate| candidate.left())?;
    let bound = MIN_LEAD * best.residual.unexplained.len() as f64;
    let leads = |other: &Candidate| {
        other.mistakes[0].is_akin(&best.mistakes[0])
            || other.residual.unexplained.len() as f64 >= bound
            || other.rendering.is_like(&best.rendering)
    };
    let is_part = search.is_exact(best) && singles().all(leads);
    is_part.then(|| Finding::Part { cause: best.mistakes[0].clone(), share: best.share })
}

/// Returns up to this many of the items, evenly spread, in an order in which each part is evenly spread, too.
fn scattered(items: &[usize], most: usize) -> Vec<usize> {
    let count = items.len().min(most);
    // Multiples of a number without a common divisor with the count visit each item once.
    let step = (1..).map(|i| (count as f64 * 0.618) as usize + i).find(|&step| are_coprime(step, count));
    let step = step.unwrap_or(1);
    (0..count).map(|i| items[(i * step % count) * items.len() / count]).collect()
}

fn are_coprime(a: usize, b: usize) -> bool {
    if b == 0 { a == 1 } else { are_coprime(b, a % b) }
}
