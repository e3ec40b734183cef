//! Judges mistakes by the pixels that they make right.
//!
//! A pixel is right if it is the picture's colour up to rounding, or up to one level more. A mistake is accepted if it
//! makes most of the wrong pixels right, and shows wherever it can. It is all that is wrong if few other pixels differ,
//! nearly all of them at edges, where a tracer in single precision sees the neighbouring surface.

use super::finding::Finding;
use super::mistakes::Mistake;
use crate::picture::{Color, FloatPicture, Picture};
use crate::tools::compare::{EdgeMap, Rgb, Tolerance, colors, largest_channel_difference};
use std::borrow::Cow;
use std::rc::Rc;

/// The largest error of a colour in single precision, in levels.
const ROUNDING: f64 = 1.0 / 64.0;
/// The largest share of all pixels that single precision changes by more than one level at edges.
const AT_EDGES: f64 = 0.005;
/// The largest such share elsewhere.
const ELSEWHERE: f64 = 0.001;
/// The largest share of all pixels that single precision changes by one level more than rounding.
const BY_A_LEVEL: f64 = 0.01;
/// The largest such share if a mistake explains the other differences. Other tracers compute their own way.
const BY_A_LEVEL_AND_MISTAKE: f64 = 0.2;
/// The smallest share of the wrong pixels that a mistake makes right. The first is for pixels that differ by more than
/// rounding, the second for those that differ by one level more. A change of brightness moves many colours by a level.
const MIN_SHARE: [f64; 2] = [0.9, 0.6];
/// The smallest share of the pixels changed by a mistake that it makes right. A change that is only similar to the
/// mistake leaves an error in the same pixels.
const MIN_PRECISION: f64 = 0.75;
/// The smallest share of the visibly wrong pixels that a mistake makes right if it makes nearly all right that it
/// changes. Then other mistakes show in the rest.
const MIN_SHARE_IF_PRECISE: f64 = 1.0 / 3.0;
/// The smallest share of the changed pixels that are right for that.
const PRECISE: f64 = 0.98;
/// The largest share of the pixels changed by a mistake that may be right without it. A mistake shows where it can.
const MAX_CONTRADICTED: f64 = 0.03;
/// The largest such share for rays that hit the surface that they leave. Rounding spares some of them.
const MAX_CONTRADICTED_BY_ROUNDING: f64 = 0.2;
/// The largest share of all pixels that contradict a mistake because of rounding at edges.
const CONTRADICTED_AT_EDGES: f64 = 0.001;
/// Every mistake of another kind must leave at least this many times as many wrong pixels.
const MIN_LEAD: f64 = 2.0;

/// A picture, and the bytes of its pixels if rounding changes its colours.
pub struct Made {
    picture: Picture,
    low: Vec<Rgb>,
    high: Vec<Rgb>,
}

impl Made {
    pub fn new(made: &FloatPicture) -> Self {
        let moved = |levels: f64| {
            let pixel = |color: &Color| color.to_array().map(|channel| (255.0 * channel + levels) as u8);
            made.colors.iter().map(pixel).collect()
        };
        Self { picture: made.to_picture(), low: moved(-ROUNDING), high: moved(ROUNDING) }
    }

    /// Returns the levels by which a pixel differs by more than rounding.
    fn levels(&self, at: usize, pixel: Rgb) -> u8 {
        let levels = |channel: usize| {
            let (byte, low, high) = (pixel[channel], self.low[at][channel], self.high[at][channel]);
            low.saturating_sub(byte).max(byte.saturating_sub(high))
        };
        levels(0).max(levels(1)).max(levels(2))
    }

    fn all_levels(&self, picture: &Picture) -> Vec<u8> {
        colors(picture).iter().enumerate().map(|(at, &pixel)| self.levels(at, pixel)).collect()
    }

    /// Returns true if the pictures are equal up to rounding.
    pub fn is_like(&self, other: &Self) -> bool {
        colors(&other.picture).iter().enumerate().all(|(at, &pixel)| self.levels(at, pixel) == 0)
    }
}

/// The pixels of a wrong picture that a picture leaves wrong.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    differing: u64,
    differing_at_edges: u64,
    /// By more than rounding.
    beyond_rounding: u64,
    /// By more than one level.
    visible: u64,
    visible_at_edges: u64,
}

impl Rest {
    fn of(wrong: &Picture, made: &Made) -> Self {
        let mut rest = Self::default();
        let width = wrong.width() as usize;
        let pairs = colors(wrong).iter().zip(colors(&made.picture)).enumerate();
        let mut edges = None;
        for (at, (&pixel, &right)) in pairs.filter(|(_, (pixel, right))| pixel != right) {
            let edges = edges.get_or_insert_with(|| EdgeMap::new(&made.picture));
            let is_at_edge = u64::from(edges.is_near_edge(at % width, at / width));
            let is_visible = u64::from(largest_channel_difference(pixel, right) > 1);
            rest.differing += 1;
            rest.differing_at_edges += is_at_edge;
            rest.beyond_rounding += u64::from(made.levels(at, pixel) > 0);
            rest.visible += is_visible;
            rest.visible_at_edges += is_visible * is_at_edge;
        }
        rest
    }

    /// Returns true if a tracer in single precision leaves that much wrong in a picture of this many pixels.
    fn is_small(&self, pixels: f64, by_a_level: f64) -> bool {
        let elsewhere = self.visible - self.visible_at_edges;
        self.visible_at_edges as f64 <= AT_EDGES * pixels
            && elsewhere as f64 <= ELSEWHERE * pixels
            && self.beyond_rounding.saturating_sub(self.visible) as f64 <= by_a_level * pixels
    }

    /// Returns the number of wrong pixels. The visible ones count twice.
    fn size(&self) -> u64 {
        self.beyond_rounding + self.visible
    }
}

/// The effect of a mistake, in pixels that differ by more than rounding or by a level more.
#[derive(Clone, Copy, Debug, Default)]
struct Effect {
    /// Pixels of the examined picture that differ from the reference.
    wrong: f64,
    /// Pixels of the examined picture that differ from the picture with the mistake.
    left: f64,
    changed: f64,
    /// Changed pixels that become right.
    right: f64,
    /// Changed pixels that were right before.
    contradicted: f64,
}

impl Effect {
    /// Returns the effect of a mistake on a picture with these differences from the reference, where the mistake makes
    /// these changes: on pixels that differ by more than rounding, and by at least one level more.
    fn of(made: &Made, wrong: &Picture, differences: &[u8], changes: &[u8]) -> [Self; 2] {
        let mut effects = [Self::default(); 2];
        for (at, (&before, &change)) in differences.iter().zip(changes).enumerate() {
            let after = made.levels(at, colors(wrong)[at]);
            for (level, effect) in (0..).zip(&mut effects) {
                let [is_wrong, is_left, is_changed] = [before, after, change].map(|levels| levels > level);
                effect.wrong += f64::from(is_wrong);
                effect.left += f64::from(is_left);
                effect.changed += f64::from(is_changed);
                effect.right += f64::from(is_changed && !is_left);
                effect.contradicted += f64::from(is_changed && is_left && !is_wrong);
            }
        }
        effects
    }

    /// Returns the share of the wrong pixels that are right with the mistake.
    fn share(&self) -> f64 {
        1.0 - self.left / self.wrong
    }

    /// Returns true if a mistake explains too much to be a coincidence.
    fn is_meant(&self, is_visible: bool, max_contradicted: f64, pixels: f64) -> bool {
        let min_share = MIN_SHARE[usize::from(is_visible)];
        let explains =
            |share: f64, precision: f64| self.share() >= share && self.right >= precision * self.changed;
        self.wrong > 0.0
            && self.changed > 0.0
            && (explains(min_share, MIN_PRECISION) || is_visible && explains(MIN_SHARE_IF_PRECISE, PRECISE))
            && self.contradicted <= max_contradicted * self.changed + CONTRADICTED_AT_EDGES * pixels
    }
}

/// Mistakes made together that explain at least part of a difference.
struct Candidate {
    mistakes: Vec<Mistake>,
    made: Rc<Made>,
    rest: Rest,
    /// The share of the wrong pixels that they make right.
    share: f64,
}

/// The search for the cause of one picture.
pub struct Search<'p> {
    wrong: Cow<'p, Picture>,
    reference: Rc<Made>,
    /// The levels by which each pixel differs from the reference by more than rounding.
    differences: Vec<u8>,
    whole: Rest,
    candidates: Vec<Candidate>,
    tried: usize,
}

impl<'p> Search<'p> {
    pub fn new(wrong: Cow<'p, Picture>, reference: Rc<Made>) -> Self {
        let (whole, differences) = (Rest::of(&wrong, &reference), reference.all_levels(&wrong));
        Self { wrong, reference, differences, whole, candidates: vec![], tried: 0 }
    }

    fn try_mistakes(&mut self, mistakes: &[Mistake], made: &Rc<Made>, changes: &[u8]) {
        self.tried += usize::from(mistakes.len() == 1);
        let effects = Effect::of(made, &self.wrong, &self.differences, changes);
        let max_contradicted = match mistakes {
            [Mistake::NoEpsilon { .. }] => MAX_CONTRADICTED_BY_ROUNDING,
            _ => MAX_CONTRADICTED,
        };
        let is_meant = |(effect, is_visible): &(Effect, bool)| {
            effect.is_meant(*is_visible, max_contradicted, self.pixels())
        };
        // Visible pixels count first.
        if let Some((effect, _)) = effects.into_iter().zip([false, true]).rev().find(is_meant) {
            let rest = Rest::of(&self.wrong, made);
            let (mistakes, made, share) = (mistakes.to_vec(), made.clone(), effect.share());
            self.candidates.push(Candidate { mistakes, made, rest, share });
        }
    }

    fn pixels(&self) -> f64 {
        colors(&self.wrong).len() as f64
    }

    /// Returns true if the pixel differs from the reference by more than rounding.
    pub fn differs(&self, at: usize) -> bool {
        self.differences[at] > 0
    }

    /// Returns the mistakes that explain at least part of the difference, one by one and together.
    pub fn likely(&self) -> impl Iterator<Item = &[Mistake]> {
        self.candidates.iter().map(|candidate| candidate.mistakes.as_slice())
    }

    /// Returns the single mistake that explains the most.
    pub fn best(&self) -> Option<Mistake> {
        self.best_of(1).map(|best| best.mistakes[0])
    }

    /// Returns the best of the candidates with at most this many mistakes, the first of several equally good ones.
    fn best_of(&self, most: usize) -> Option<&Candidate> {
        let all = self.candidates.iter().filter(|candidate| candidate.mistakes.len() <= most);
        all.min_by_key(|candidate| (candidate.rest.size(), candidate.rest.differing))
    }

    /// Returns true if the answer is final.
    pub fn is_settled(&self) -> bool {
        match self.finding() {
            Finding::Equal { .. } => true,
            Finding::Rounding { .. } => self.tried > 0,
            _ => false,
        }
    }

    /// Takes the number of mistakes tried from a search in a part of the picture.
    pub fn count_tried(&mut self, part: &Self) {
        self.tried = self.tried.max(part.tried);
    }

    pub fn wrong(&self) -> &Picture {
        &self.wrong
    }

    /// Returns the answer of the mistakes tried so far.
    pub fn finding(&self) -> Finding {
        let unknown = Finding::Unknown { tried: self.tried };
        let whole = &self.whole;
        let is_rounding = whole.is_small(self.pixels(), BY_A_LEVEL);
        let rounding = || Finding::Rounding {
            pixels: whole.differing,
            at_edges: whole.differing_at_edges,
            tolerance: tolerance(whole),
        };
        for count in [1, 2] {
            let Some(best) = self.best_of(count) else { continue };
            let rest = &best.rest;
            // No mistake is needed if rounding explains the difference, unless the mistake gives the very picture.
            let is_better = !is_rounding || rest.differing == 0 || 10 * rest.size() <= whole.size();
            if is_better && rest.is_small(self.pixels(), BY_A_LEVEL_AND_MISTAKE) {
                return Finding::Equal {
                    cause: best.mistakes[0],
                    also: best.mistakes[1..].to_vec(),
                    same: self.same(best),
                    pixels: rest.differing,
                    by_more_than_one_level: rest.visible,
                    at_edges: rest.differing_at_edges,
                };
            }
        }
        match self.best_of(1).filter(|best| self.leads(best)) {
            _ if is_rounding => rounding(),
            Some(best) => Finding::Part { cause: best.mistakes[0], share: best.share },
            None => unknown,
        }
    }

    /// Returns the other mistakes whose picture is the same up to rounding.
    fn same(&self, best: &Candidate) -> Vec<Mistake> {
        let others = self.candidates.iter().filter_map(|other| match other.mistakes[..] {
            [mistake] => Some((mistake, &other.made)),
            _ => None,
        });
        let is_same = |(mistake, made): &(Mistake, &Rc<Made>)| {
            best.mistakes.iter().all(|named| !named.is_akin(*mistake)) && made.is_like(&best.made)
        };
        let mut same: Vec<Mistake> = vec![];
        for (mistake, _) in others.filter(is_same) {
            if !same.iter().any(|named| named.is_akin(mistake)) {
                same.push(mistake);
            }
        }
        same
    }

    /// Returns true if no mistake of another kind explains about as much.
    fn leads(&self, best: &Candidate) -> bool {
        let is_other = |other: &&Candidate| {
            let [mistake] = other.mistakes[..] else { return false };
            !mistake.is_akin(best.mistakes[0]) && !other.made.is_like(&best.made)
        };
        let bound = MIN_LEAD * best.rest.size() as f64;
        self.candidates.iter().filter(is_other).all(|other| other.rest.size() as f64 >= bound)
    }
}

/// Returns a tolerance with round numbers that accepts a difference.
fn tolerance(rest: &Rest) -> Tolerance {
    let rounds = (1..).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u64.pow(power)));
    let pixels =
        if rest.visible == 0 { 0 } else { rounds.take(30).find(|&n| n >= rest.visible).unwrap_or(u64::MAX) };
    Tolerance { levels: 1, pixels }
}

/// Tries all of these mistakes in each search. Skips those that cannot be seen in the reference. Ends early if the
/// finished picture was changed, and nothing else is wrong.
pub fn try_all<'m>(
    all: impl IntoIterator<Item = &'m [Mistake]>,
    make: impl Fn(&[Mistake]) -> Option<FloatPicture>,
    searches: &mut [&mut Search],
) {
    let Some(reference) = searches.first().map(|search| search.reference.clone()) else { return };
    let own = make(&[Mistake::Unchanged]).map(|own| Made::new(&own));
    let shows = |mistakes: &[Mistake], made: &Made| {
        let is_own = own.as_ref().is_some_and(|own| own.is_like(made));
        !reference.is_like(made) && (mistakes == [Mistake::Unchanged] || !is_own)
    };
    let is_of_pixels = |mistakes: &[Mistake]| mistakes.iter().all(|mistake| mistake.is_of_pixels());
    let is_equal = |candidate: &Candidate| candidate.rest.differing == 0 && is_of_pixels(&candidate.mistakes);
    let is_over = |search: &&mut Search| search.candidates.iter().any(is_equal);
    for mistakes in all {
        if !is_of_pixels(mistakes) && searches.iter().all(is_over) {
            break;
        }
        let made = make(mistakes).map(|made| Rc::new(Made::new(&made)));
        if let Some(made) = made.filter(|made| shows(mistakes, made)) {
            let changes = reference.all_levels(&made.picture);
            searches.iter_mut().for_each(|search| search.try_mistakes(mistakes, &made, &changes));
        }
    }
}
